//! The figures of an axis by name, and what its control is to add.

use std::collections::BTreeMap;

use serde::Serialize;

use super::axis_run::{AxisRunEstimate, AxisTargetEstimate};
use crate::count::count;

/// Figures of ISO 230-2 by their symbols, and the table of corrections.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PositioningFigures {
    /// `A_mm`, `A_rising_mm` … and with `u_` before it the standard uncertainty of each (rotary: `_arcsec`);
    /// `None` where the readings do not give it.
    #[serde(flatten)]
    pub figures: BTreeMap<String, Option<f64>>,
    /// What to add to each target, ascending.
    pub table: Vec<AxisCorrection>,
}

/// What the control is to add to one target.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AxisCorrection {
    /// The target, mm or °.
    pub target: f64,
    /// Coming from smaller positions: the mean deviation with the other sign, mm or seconds of arc; where nothing
    /// came so, that of the other way.
    pub correction_forward: f64,
    /// Coming from larger positions.
    pub correction_reverse: f64,
    /// Standard uncertainty of the less certain of the two, from the scatter of its readings; `None` of single ones.
    pub u: Option<f64>,
}

impl PositioningFigures {
    pub(crate) fn of(run: &AxisRunEstimate) -> Self {
        let named = run.figures.iter().flat_map(|figure| {
            let name = format!("{}_{}", figure.symbol.replace(' ', "_"), run.unit);
            [(format!("u_{name}"), figure.std), (name, figure.value)]
        });
        let table = run.targets.iter().map(AxisCorrection::of).collect();
        Self { figures: named.collect(), table }
    }
}

impl AxisCorrection {
    fn of(t: &AxisTargetEstimate) -> Self {
        let of_mean = |std: Option<f64>, n: usize| Some(std? / count(n).sqrt());
        let ways = [of_mean(t.std_rising, t.n_rising), of_mean(t.std_falling, t.n_falling)];
        Self {
            target: t.target,
            correction_forward: -t.mean_rising.unwrap_or(t.mean),
            correction_reverse: -t.mean_falling.unwrap_or(t.mean),
            u: ways.into_iter().flatten().max_by(f64::total_cmp),
        }
    }
}
