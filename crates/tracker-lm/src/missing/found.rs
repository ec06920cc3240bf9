//! The model anew about what a loop has found.

use least_squares::BorderedPoint;
use model_discrepancy::{Model, Solution};

use crate::TrackerModel;
use crate::gauge::StationChart;
use crate::joint::Joint;
use crate::missing::sights::sights;
use crate::missing::solved::Solved;
use crate::network::Network;
use crate::shift::Shift;

/// Nearer to what was found than this, in mm, the model is as good as about it: across a beam of
/// half a metre it bends a row by 10⁻¹³ mm, the round-off of a range.
pub(crate) const NEAR_MM: f64 = 1e-5;

impl TrackerModel {
    /// The model about what a loop on it has found; `None` where it is near that already, where
    /// nothing was found, and where the solution is not one of this model.
    ///
    /// Effects are then where they are, and not where the slopes at the declared solution put them: a
    /// beam that was lost for millimetres bends the rows by more than their noise.
    #[must_use]
    pub fn about_found(&self, found: &Solution) -> Option<Self> {
        if found.is_declared() {
            return None;
        }
        let network = Network::new(&self.survey, &self.options).ok()?;
        let nominal: Vec<_> = self.survey.stations.iter().map(|s| s.nominal_mm).collect();
        let chart = StationChart::new(&nominal, &self.options).ok()?;
        let (moved, angles) = self.follow(&network, &chart, found, 1.0)?;
        let before = &self.solved.point.shared;
        let point = BorderedPoint {
            shared: before.iter().zip(moved.iter()).map(|(at, step)| at + step).collect(),
            blocks: angles.iter().flat_map(|angle| angle.own_error.iter().copied()).collect(),
        };
        let shifts = self.shifts(found);
        let joint = Joint::new(&network, &chart, 1.0).shifted(shifts.clone());
        let there = sights(&joint, &point);
        let away = there.iter().zip(&self.sights).map(|(a, b)| (a.along_mm - b.along_mm).norm());
        if away.fold(0.0, f64::max) < NEAR_MM {
            return None;
        }
        let of_axis = self.amplitudes_of_axis(found);
        let calibration = self.solved.calibration.clone();
        let solved = Solved { calibration, point, shifts, of_axis };
        let (survey, recorded) = (self.survey.clone(), self.recorded.clone());
        let mut about =
            Self::about(survey, self.options, recorded, solved, Some(&self.choices())).ok()?;
        let is_same = about.declared().layout == self.declared().layout;
        about.frame = self.frame;
        is_same.then_some(about)
    }

    /// What the effects of a solution move, range by range.
    fn shifts(&self, found: &Solution) -> Vec<Shift> {
        let mut shifts = vec![Shift::default(); self.survey.ranges.len()];
        for (moves, amplitudes) in self.moves.iter().zip(&found.state.amplitudes) {
            let Some(moves) = moves else { continue };
            for (range, shift) in shifts.iter_mut().enumerate() {
                moves.shift(shift, amplitudes, range);
            }
        }
        shifts
    }
}
