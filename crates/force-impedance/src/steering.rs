//! Which way the commanded tip goes within one cycle.

use nalgebra::Vector3;

use crate::motion::{Motion, MotionLimits, up_to};
use crate::scalar::{across, norm, sqrt};
use crate::workspace::Workspace;
use crate::{ControllerSettings, Head, HeadPose, Limits};

/// Share of the travel by which a motion along its very end, the normal turning, may seem to end
/// beyond; the step itself ends within.
const TRAVEL_SLACK: f64 = 1e-5;
/// Excesses that differ by less are the same: round-off of lengths, amply.
const SAME_MM: f64 = 1e-9;
/// Shares of a step that are tried where the workspace ends.
const SHARES: [f64; 4] = [1.0, 0.5, 0.25, 0.125];

/// What a cycle wants of the tip, per nominal interval.
pub(crate) struct Wanted {
    /// Outward, of unit length.
    pub(crate) normal: Vector3<f64>,
    /// Step along it.
    pub(crate) along_mm: f64,
    /// Longest step towards the workpiece.
    pub(crate) inward_mm: f64,
    /// Longest step.
    pub(crate) fastest_mm: f64,
    /// A head outside its limits may go towards the workpiece to get back.
    pub(crate) returns: bool,
}

impl Wanted {
    /// Longest step of a motion that goes inwards by so much a cycle: towards a workpiece that is
    /// not touched it is short in every direction, wherever the normal turns to.
    #[inline]
    fn longest_mm(&self, inward_mm: f64) -> f64 {
        if inward_mm > 0.0 { self.inward_mm.min(self.fastest_mm) } else { self.fastest_mm }
    }
}

/// Bounds of the tip's motion: speed, acceleration and jerk, travel along the normal, workspace.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Steering {
    pub(crate) motion: MotionLimits,
    workspace: Workspace,
    travel_mm: [f64; 2],
    approach_mm: f64,
}

/// A motion near the ends of the workspace: what its end may exceed them by, where the head was
/// sent and where it was seen, and how far these are apart.
struct Ends<'a> {
    head: &'a Head,
    workspace: &'a Workspace,
    tip_mm: Vector3<f64>,
    seen_off_mm: Vector3<f64>,
    most_mm: f64,
    seen_most_mm: f64,
}

impl Ends<'_> {
    /// Whether a motion may end `end_mm` off the tip: within, or no farther outside than before.
    fn allow(&self, end_mm: &Vector3<f64>) -> bool {
        let end_mm = self.tip_mm + end_mm;
        self.workspace.excess_mm(self.head, &end_mm) <= self.most_mm
            && self.workspace.excess_mm(self.head, &(end_mm + self.seen_off_mm))
                <= self.seen_most_mm
    }
}

impl Steering {
    pub(crate) fn new(head: &Head, settings: &ControllerSettings) -> Self {
        let motion = settings.tip_motion();
        Self {
            motion,
            workspace: Workspace::new(head, &motion),
            travel_mm: settings.travel_mm,
            approach_mm: settings.approach_mm_per_s * settings.interval_s,
        }
    }

    /// The action that stops soonest, as far as it leaves a way to stop within all bounds.
    pub(crate) fn brake(
        &self,
        head: &Head,
        pose: &HeadPose,
        motion: &Motion,
        normal: &Vector3<f64>,
    ) -> Vector3<f64> {
        let stop = motion.stopping(&self.motion);
        let wanted = self.motion.toward(&-motion.step);
        let ends =
            (!self.workspace.is_roomy(pose)).then(|| self.ends(head, pose, pose, motion, &stop));
        let allowed = |change: &Vector3<f64>| {
            let end_mm = motion.end(&self.motion, change);
            ends.as_ref().is_none_or(|ends| ends.allow(&end_mm))
        };
        let way = wanted - stop;
        let part = way.dot(normal);
        let offset_mm = pose.tip_mm - head.start_tip_mm();
        let within = self.within_travel(&offset_mm, motion, normal, &stop, part);
        let free = motion.reach(&self.motion, &stop, &way, self.motion.step);
        if free >= 1.0 && within >= 1.0 && allowed(&wanted) {
            return wanted;
        }
        let way = way * free.min(within);
        for share in SHARES {
            let change = stop + way * share;
            if allowed(&change) {
                return change;
            }
        }
        stop
    }

    /// The change of the tip's step: all of `exact_mm` where every bound allows it, else what is
    /// wanted along the normal first, then across it, each as far as allowed.
    #[inline]
    #[expect(clippy::too_many_arguments, reason = "the state of a controller, part by part")]
    pub(crate) fn steer(
        &self,
        head: &Head,
        pose: &HeadPose,
        seen: &HeadPose,
        motion: &Motion,
        wanted: &Wanted,
        exact_mm: Option<&Vector3<f64>>,
        limits: &mut Limits,
    ) -> Vector3<f64> {
        let roomy = self.workspace.is_roomy(pose) && self.workspace.is_roomy(seen);
        if roomy
            && let Some(change) =
                exact_mm.and_then(|step| self.exact(head, pose, motion, wanted, step))
        {
            return change;
        }
        self.within(head, pose, seen, roomy, motion, wanted, exact_mm, limits)
    }

    /// The change that makes exactly a step, where speed, acceleration, jerk and travel allow it.
    #[inline]
    fn exact(
        &self,
        head: &Head,
        pose: &HeadPose,
        motion: &Motion,
        wanted: &Wanted,
        step_mm: &Vector3<f64>,
    ) -> Option<Vector3<f64>> {
        let change = step_mm - motion.step;
        let normal = &wanted.normal;
        let led = motion.led(&self.motion, &change);
        let tip_mm = pose.tip_mm - head.start_tip_mm();
        let end_mm = (tip_mm + motion.end(&self.motion, &change)).dot(normal);
        let [inward_mm, outward_mm] = self.travel_mm;
        let (down_mm, led_down_mm) = (-step_mm.dot(normal), -led.dot(normal));
        let longest_mm = wanted.longest_mm(down_mm.max(led_down_mm)).min(self.motion.step);
        let slow = step_mm.dot(step_mm) <= longest_mm * longest_mm
            && down_mm <= wanted.inward_mm
            && led_down_mm <= wanted.inward_mm;
        let slack_mm = TRAVEL_SLACK * (outward_mm - inward_mm);
        let ends = end_mm >= inward_mm - slack_mm && end_mm <= outward_mm + slack_mm;
        (slow && ends && motion.allows(&self.motion, &change, longest_mm)).then_some(change)
    }

    #[cold]
    #[expect(clippy::too_many_arguments, reason = "the state of a controller, part by part")]
    fn within(
        &self,
        head: &Head,
        pose: &HeadPose,
        seen: &HeadPose,
        roomy: bool,
        motion: &Motion,
        wanted: &Wanted,
        exact_mm: Option<&Vector3<f64>>,
        limits: &mut Limits,
    ) -> Vector3<f64> {
        let stop = motion.stopping(&self.motion);
        let ends = (!roomy).then(|| self.ends(head, pose, seen, motion, &stop));
        let exact = exact_mm.and_then(|step| self.exact(head, pose, motion, wanted, step));
        let outside = !roomy && !head.allows(seen);
        limits.set(Limits::OUTSIDE, outside);
        let allowed = |change: &Vector3<f64>| {
            let end_mm = motion.end(&self.motion, change);
            ends.as_ref().is_none_or(|ends| ends.allow(&end_mm))
        };
        if let Some(change) = exact.filter(|change| !outside && allowed(change)) {
            return change;
        }
        limits.set(Limits::RATE, exact_mm.is_some() && exact.is_none());
        let offset_mm = pose.tip_mm - head.start_tip_mm();
        let mut along_mm = wanted.along_mm;
        if let Some(ends) = ends.as_ref().filter(|_| outside) {
            along_mm = self.back(head, seen, ends, wanted, along_mm);
        }
        let (step_mm, across_mm) = self.steps(&offset_mm, wanted, along_mm);
        let part = self.along(&offset_mm, motion, wanted, step_mm, &stop, limits);
        let other = self.across(motion, wanted, step_mm, &across_mm, &(stop + part), &stop);
        for [a, b] in [[1.0, 1.0], [1.0, 0.0], [0.0, 1.0]] {
            for share in SHARES {
                let change = stop + part * (a * share) + other * (b * share);
                if allowed(&change) {
                    return change;
                }
                limits.set(Limits::WORKSPACE, true);
            }
        }
        stop
    }

    fn ends<'a>(
        &'a self,
        head: &'a Head,
        pose: &HeadPose,
        seen: &HeadPose,
        motion: &Motion,
        stop: &Vector3<f64>,
    ) -> Ends<'a> {
        let tip_mm = pose.tip_mm.coords;
        let seen_off_mm = seen.tip_mm - pose.tip_mm;
        let end_mm = tip_mm + motion.end(&self.motion, stop);
        let most = |tip_mm: &Vector3<f64>| {
            let excess_mm = self.workspace.excess_mm(head, tip_mm);
            if excess_mm > 0.0 { excess_mm + SAME_MM } else { 0.0 }
        };
        Ends {
            head,
            workspace: &self.workspace,
            tip_mm,
            seen_off_mm,
            most_mm: most(&end_mm),
            seen_most_mm: most(&(end_mm + seen_off_mm)),
        }
    }

    /// The step along the normal of a head that was seen outside its limits: towards the straight
    /// head, but towards the workpiece only where the force leaves room for it.
    fn back(
        &self,
        head: &Head,
        seen: &HeadPose,
        ends: &Ends<'_>,
        wanted: &Wanted,
        along_mm: f64,
    ) -> f64 {
        let way_mm = head.start_tip_mm() - seen.tip_mm;
        let fast_mm =
            self.approach_mm.min(ends.seen_most_mm / (self.motion.over() + self.motion.lag));
        let back_mm = way_mm.dot(&wanted.normal) * (fast_mm / norm(&way_mm));
        if back_mm > 0.0 {
            along_mm.max(back_mm)
        } else if wanted.returns {
            along_mm.min(back_mm)
        } else {
            along_mm
        }
    }

    /// What can be added to stopping of the step along the normal.
    fn along(
        &self,
        offset_mm: &Vector3<f64>,
        motion: &Motion,
        wanted: &Wanted,
        step_mm: f64,
        stop: &Vector3<f64>,
        limits: &mut Limits,
    ) -> Vector3<f64> {
        let normal = &wanted.normal;
        let change = self.motion.toward_along(step_mm - motion.step.dot(normal));
        let part = change - stop.dot(normal);
        let way = normal * part;
        // No faster inwards than allowed, or than stopping is.
        let led = motion.led(&self.motion, stop);
        let inward_mm = -led.dot(normal);
        let slow = up_to(inward_mm, -part * self.motion.over(), wanted.inward_mm);
        let longest_mm = self.longest_mm(wanted, -step_mm, &led);
        let free = motion.reach(&self.motion, stop, &way, longest_mm).min(slow);
        let within = self.within_travel(offset_mm, motion, normal, stop, part);
        limits.set(Limits::TRAVEL, within < free);
        way * free.min(within)
    }

    /// What can be added to `from` of a step across the normal.
    fn across(
        &self,
        motion: &Motion,
        wanted: &Wanted,
        along_mm: f64,
        across_mm: &Vector3<f64>,
        from: &Vector3<f64>,
        stop: &Vector3<f64>,
    ) -> Vector3<f64> {
        let normal = &wanted.normal;
        let gap = across_mm - across(&motion.step, normal);
        let way = self.motion.toward(&gap) - across(stop, normal);
        let led = motion.led(&self.motion, from);
        let longest_mm = self.longest_mm(wanted, -along_mm, &led);
        way * motion.reach(&self.motion, from, &way, longest_mm)
    }

    /// Longest step that is aimed at: no longer than allowed, or than it already is.
    fn longest_mm(&self, wanted: &Wanted, inward_mm: f64, led: &Vector3<f64>) -> f64 {
        wanted.longest_mm(inward_mm).max(norm(led)).min(self.motion.step)
    }

    /// Steps along the normal and across it, back onto it.
    fn steps(
        &self,
        offset_mm: &Vector3<f64>,
        wanted: &Wanted,
        along_mm: f64,
    ) -> (f64, Vector3<f64>) {
        let way_mm = -across(offset_mm, &wanted.normal);
        // As a weighted mean, never past it.
        let across_mm = way_mm * (1.0 / (self.motion.over() + self.motion.lag));
        let longest_mm = wanted.inward_mm.min(wanted.fastest_mm);
        let far_mm = norm(&across_mm);
        // Of a diagonal at most: both together are no longer than one.
        let diagonal_mm = core::f64::consts::FRAC_1_SQRT_2 * longest_mm;
        let share = if far_mm > diagonal_mm { diagonal_mm / far_mm } else { 1.0 };
        let left_mm = sqrt((longest_mm * longest_mm - far_mm * far_mm * share * share).max(0.0));
        let step_mm = along_mm.min(wanted.fastest_mm).max(-left_mm);
        (step_mm, across_mm * share)
    }

    /// The share of a change along the normal that leaves a stop within the travel, or no farther
    /// outside than before.
    fn within_travel(
        &self,
        offset_mm: &Vector3<f64>,
        motion: &Motion,
        normal: &Vector3<f64>,
        stop: &Vector3<f64>,
        part: f64,
    ) -> f64 {
        let over = self.motion.over();
        let end_mm = (offset_mm + motion.end(&self.motion, stop)).dot(normal);
        let way_mm = part * over * over;
        let [least_mm, most_mm] = self.travel_mm;
        up_to(end_mm, way_mm, most_mm).min(up_to(-end_mm, -way_mm, -least_mm))
    }
}
