//! Where the commanded tip may go, so that it can always stop within the limits of the head.

use nalgebra::Vector3;

use crate::motion::MotionLimits;
use crate::{Head, HeadPose};

/// The head's limits, and how near to them a motion has to be looked at.
///
/// A commanded point is a weighted mean of points that were looked at (see
/// [`motion`](crate::motion)). The set of poses within limits is nearly convex: a leg's least length
/// is a sphere seen from outside, and a chord of it dips below it by what its curvature says. By so
/// much the points that are looked at keep inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Workspace {
    kept: Bounds,
    roomy: Bounds,
    least_reach_mm: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Bounds {
    leg_mm: [f64; 2],
    axial_mm: [f64; 2],
    tilt_cosine: f64,
}

impl Workspace {
    pub(crate) fn new(head: &Head, motion: &MotionLimits) -> Self {
        let (geometry, limits) = (&head.geometry, &head.limits);
        let least_reach_mm = limits.axial_mm[0] + geometry.tip_to_plane_mm;
        // A joint moves with the tip by the slide, and by a turn of at most twice that of the axis.
        let arm = geometry.head_radius_mm / least_reach_mm;
        let gradient = 1.0 + 2.0 * arm;
        let bend_per_mm =
            gradient * gradient / limits.leg_mm[0] + (2.0 + 8.0 * arm) / least_reach_mm;
        // Means of `p` and `q`, and of `q` and `r`, with chords of (1 + σ)·V: each dips by half.
        let (lag, over) = (motion.lag, motion.over());
        let dip_mm = bend_per_mm * lag * over * motion.step * motion.step;
        let farthest_mm = (over + lag) * motion.step;
        let within = |by_mm: f64| Bounds {
            leg_mm: [limits.leg_mm[0] + by_mm, limits.leg_mm[1] - by_mm],
            axial_mm: [limits.axial_mm[0] + by_mm, limits.axial_mm[1] - by_mm],
            tilt_cosine: head.tilt_cosine + by_mm / least_reach_mm,
        };
        // The cone of the tilt is convex: nothing dips out of it.
        let kept = Bounds { tilt_cosine: head.tilt_cosine, ..within(dip_mm) };
        Self { kept, roomy: within(dip_mm + gradient * farthest_mm), least_reach_mm }
    }

    /// Whether no motion of one cycle can bring the head's end point near to a limit.
    #[inline]
    pub(crate) fn is_roomy(&self, pose: &HeadPose) -> bool {
        let [l1, l2, l3, l4] = pose.lengths_mm;
        let [shortest_mm, longest_mm] = self.roomy.leg_mm;
        let leg = |l: f64| l >= shortest_mm && l <= longest_mm;
        let axial = l4 >= self.roomy.axial_mm[0] && l4 <= self.roomy.axial_mm[1];
        -pose.axis.y >= self.roomy.tilt_cosine && axial && leg(l1) && leg(l2) && leg(l3)
    }

    /// By how much a tip is beyond what is kept, mm; zero or less within.
    pub(crate) fn excess_mm(&self, head: &Head, tip_mm: &Vector3<f64>) -> f64 {
        let pose = HeadPose::of(head, tip_mm);
        let [l1, l2, l3, l4] = pose.lengths_mm;
        let beyond = |l: f64, [low, high]: [f64; 2]| (low - l).max(l - high);
        let leg = |l: f64| beyond(l, self.kept.leg_mm);
        let lean_mm = (self.kept.tilt_cosine + pose.axis.y) * self.least_reach_mm;
        let most =
            leg(l1).max(leg(l2)).max(leg(l3)).max(beyond(l4, self.kept.axial_mm)).max(lean_mm);
        // `max` passes NaN over.
        if (l1 + l2 + l3 + l4 + pose.axis.y).is_finite() { most } else { f64::INFINITY }
    }
}
