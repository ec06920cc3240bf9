//! Effects on a perfect axis, in a model about one solution.

use crate::curves::{Curves, ErrorsAt};
use crate::joint::Joint;
use crate::missing::axis_effects::{AxisEffect, axis_effects};
use crate::missing::effects::Entry;
use crate::missing::orders::Orders;
use crate::missing::reduction::of_ranges;
use crate::missing::sights::Sight;
use crate::missing::solved::Solved;
use crate::missing::stops::Stops;
use crate::network::Network;

/// Effects on the axis with what they do about a solution.
pub(crate) struct OfAxis {
    effects: Vec<AxisEffect>,
    /// What the declared model fits of the axis, then what the effects do.
    pub(crate) curves: Curves,
    /// How many of the curves the declared model fits.
    n_fitted: usize,
    /// Of all curves.
    amplitudes: Vec<f64>,
    /// Angle by angle.
    at: Vec<ErrorsAt>,
}

impl OfAxis {
    pub(crate) fn new(
        joint: &Joint<'_>,
        stops: &Stops<'_>,
        orders: &Orders,
        solved: &Solved,
    ) -> Self {
        let effects = axis_effects(joint.network.axis_model, stops, orders);
        let fitted = joint.curves.shapes.iter();
        let shapes = fitted.chain(effects.iter().flat_map(|e| &e.shapes)).cloned().collect();
        let curves = Curves::new(stops.axis, stops.angles_rad, shapes);
        let fitted = &solved.point.shared[joint.curve_start()..];
        let mut amplitudes: Vec<f64> = fitted.iter().chain(&solved.of_axis).copied().collect();
        amplitudes.resize(curves.len(), 0.0);
        let at = (0..stops.angles_rad.len()).map(|k| curves.at(k, &amplitudes)).collect();
        Self { effects, curves, n_fitted: fitted.len(), amplitudes, at }
    }

    /// Takes what the amplitudes of effects do off the residuals, as far as rows are linear.
    pub(crate) fn taken_off(
        &self,
        network: &Network<'_>,
        sights: &[Sight],
        residuals_mm: &mut [f64],
    ) {
        for (r, residual) in residuals_mm.iter_mut().enumerate() {
            let slopes = self.slopes(network, r);
            for (slope, amplitude) in slopes.iter().zip(&self.amplitudes).skip(self.n_fitted) {
                *residual -= sights[r].by_error.dot(slope) * amplitude;
            }
        }
    }

    /// The first curve of every effect, after so many effects that are not on the axis.
    pub(crate) fn curve_of(&self, n_others: usize) -> Vec<Option<usize>> {
        let mut next = self.n_fitted;
        let first = self.effects.iter().map(|effect| {
            next += effect.shapes.len();
            Some(next - effect.shapes.len())
        });
        std::iter::repeat_n(None, n_others).chain(first).collect()
    }

    /// The effects as entries of the catalogue.
    pub(crate) fn entries(&self, network: &Network<'_>, sights: &[Sight]) -> Vec<Entry> {
        let mut next = self.n_fitted;
        let entry = |effect: &AxisEffect| {
            let own = next..next + effect.shapes.len();
            next = own.end;
            let column = |r: usize| {
                let slopes = &self.slopes(network, r)[own.clone()];
                slopes.iter().map(|slope| sights[r].by_error.dot(slope)).collect()
            };
            let columns = of_ranges(sights.len(), effect.shapes.len(), column);
            Entry { effect: effect.effect.clone(), columns, moves: None }
        };
        self.effects.iter().map(entry).collect()
    }

    fn slopes(&self, network: &Network<'_>, range: usize) -> &[nalgebra::Vector6<f64>] {
        &self.at[network.angle_of_step[network.survey.ranges[range].step]].slopes
    }
}
