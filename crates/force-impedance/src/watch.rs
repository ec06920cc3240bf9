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
    pub(crate) pose: HeadPose,
}

impl Watch {
    pub(crate) fn new(pose: HeadPose) -> Self {
        Self { cells_n: [0.0; 4], unchanged_cycles: 0, pose }
    }

    /// Everything that can be wrong, in the order of the fault table; the cells' readings where
    /// nothing is, with the head's place in `pose`.
    #[inline]
    pub(crate) fn judge(
        &mut self,
        head: &Head,
        settings: &ControllerSettings,
        normal_cosine: f64,
        commanded: &HeadPose,
        seen: &Measurement,
        dt_s: f64,
    ) -> Result<[f64; 4], Fault> {
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
        let in_range = cells_n.iter().all(|f| f.abs() <= settings.max_cell_n);
        if !(in_range && lengths_mm.iter().all(|l| l.is_finite())) {
            let finite = cells_n.iter().chain(&lengths_mm).all(|v| v.is_finite());
            return Err(if finite { Fault::CellRange } else { Fault::NotFinite });
        }
        if frozen {
            return Err(Fault::Frozen);
        }
        if !self.find(head, settings.max_consistency_mm, &lengths_mm) {
            // A head that was lost is looked for from where it was sent.
            self.pose = *commanded;
            return Err(Fault::Lengths);
        }
        if !usable(&seen.normal, &self.pose.axis, normal_cosine) {
            return Err(Fault::Normal);
        }
        Ok(cells_n)
    }

    #[inline]
    fn frozen(&mut self, cells_n: &[f64; 4], limit: u32) -> bool {
        let same = cells_n.iter().zip(&self.cells_n).all(|(a, b)| a.to_bits() == b.to_bits());
        self.unchanged_cycles = if same { self.unchanged_cycles.saturating_add(1) } else { 0 };
        self.cells_n = *cells_n;
        self.unchanged_cycles >= limit
    }

    /// Finds the pose of the lengths from where the head was last seen; false where there is none.
    #[inline]
    fn find(&mut self, head: &Head, max_mm: f64, lengths_mm: &[f64; 4]) -> bool {
        for _ in 0..MAX_STEPS {
            let tip_mm = head.forward_step(&self.pose, lengths_mm);
            let step_mm = norm(&(tip_mm - self.pose.tip_mm));
            self.pose = HeadPose::of(head, &tip_mm.coords);
            if !head.allows(&self.pose) {
                return false;
            }
            if step_mm <= LAST_STEP_MM {
                break;
            }
        }
        let ([a, b, c, d], [e, f, g, h]) = (self.pose.lengths_mm, lengths_mm);
        let agrees = |found_mm: f64, read_mm: &f64| (found_mm - read_mm).abs() <= max_mm;
        agrees(a, e) && agrees(b, f) && agrees(c, g) && agrees(d, h)
    }
}

#[inline]
fn usable(normal: &Vector3<f64>, axis: &Vector3<f64>, least_cosine: f64) -> bool {
    let squared = normal.dot(normal);
    let is_unit = is_finite(normal) && (squared - 1.0).abs() <= UNIT_TOL;
    is_unit && -normal.dot(axis) >= least_cosine
}
