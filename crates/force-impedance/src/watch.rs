//! Which cycles may be believed.

use nalgebra::Vector3;

use crate::scalar::{is_finite, norm};
use crate::{ControllerSettings, Fault, Head, HeadPose, Measurement};

/// Steps towards the measured lengths at most; from 5 mm away three reach 0.1 µm.
const MAX_STEPS: usize = 3;
/// A step below this leaves an error of its square over a leg of some 70 mm, about 1 nm.
const LAST_STEP_MM: f64 = 0.01;
/// Squared length of a normal with six good digits.
const UNIT_TOL: f64 = 1e-5;
/// Shortest and longest believable interval, in nominal ones.
const INTERVAL_RANGE: [f64; 2] = [0.5, 10.0];

/// Memory of the input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Watch {
    cells_n: [f64; 4],
    unchanged_cycles: u32,
    /// Where the head was last seen.
    pose: HeadPose,
}

/// A cycle's readings that may be believed.
pub(crate) struct Sound {
    pub(crate) cells_n: [f64; 4],
    pub(crate) pose: HeadPose,
}

impl Watch {
    pub(crate) fn new(pose: HeadPose) -> Self {
        Self { cells_n: [0.0; 4], unchanged_cycles: 0, pose }
    }

    /// Everything that can be wrong, in the order of the fault table.
    #[inline]
    pub(crate) fn judge(
        &mut self,
        head: &Head,
        settings: &ControllerSettings,
        normal_cosine: f64,
        commanded: &HeadPose,
        seen: &Measurement,
        dt_s: f64,
    ) -> Result<Sound, Fault> {
        let [shortest, longest] = INTERVAL_RANGE;
        let in_time =
            dt_s >= shortest * settings.interval_s && dt_s <= longest * settings.interval_s;
        let cells_n = seen.cells_n.ok_or(Fault::NoSample);
        let frozen = cells_n.is_ok_and(|cells_n| self.frozen(&cells_n, settings.frozen_cycles));
        if !in_time {
            return Err(Fault::Interval);
        }
        let cells_n = cells_n?;
        let lengths_mm = seen.lengths_mm.ok_or(Fault::NoSample)?;
        if !(cells_n.iter().chain(&lengths_mm).all(|v| v.is_finite())) {
            return Err(Fault::NotFinite);
        }
        if cells_n.iter().any(|f| f.abs() > settings.max_cell_n) {
            return Err(Fault::CellRange);
        }
        if frozen {
            return Err(Fault::Frozen);
        }
        let pose = self.find(head, settings.max_consistency_mm, &lengths_mm);
        // A head that was lost is looked for from where it was sent.
        self.pose = pose.unwrap_or(*commanded);
        let pose = pose.ok_or(Fault::Lengths)?;
        if !usable(&seen.normal, &pose.axis, normal_cosine) {
            return Err(Fault::Normal);
        }
        Ok(Sound { cells_n, pose })
    }

    #[inline]
    fn frozen(&mut self, cells_n: &[f64; 4], limit: u32) -> bool {
        let same = cells_n.iter().zip(&self.cells_n).all(|(a, b)| a.to_bits() == b.to_bits());
        self.unchanged_cycles = if same { self.unchanged_cycles.saturating_add(1) } else { 0 };
        self.cells_n = *cells_n;
        self.unchanged_cycles >= limit
    }

    /// The pose of the lengths, from where the head was last seen.
    #[inline]
    fn find(&self, head: &Head, max_mm: f64, lengths_mm: &[f64; 4]) -> Option<HeadPose> {
        let mut pose = self.pose;
        for _ in 0..MAX_STEPS {
            let tip_mm = head.forward_step(&pose, lengths_mm);
            let step_mm = norm(&(tip_mm - pose.tip_mm));
            pose = head.pose_at(&tip_mm).ok()?;
            if step_mm <= LAST_STEP_MM {
                break;
            }
        }
        let agrees = |(a, b): (&f64, &f64)| (a - b).abs() <= max_mm;
        pose.lengths_mm.iter().zip(lengths_mm).all(agrees).then_some(pose)
    }
}

#[inline]
fn usable(normal: &Vector3<f64>, axis: &Vector3<f64>, least_cosine: f64) -> bool {
    let squared = normal.dot(normal);
    let is_unit = is_finite(normal) && (squared - 1.0).abs() <= UNIT_TOL;
    is_unit && -normal.dot(axis) >= least_cosine
}
