//! A positioning run, and what of it every effect is a function of.

use std::f64::consts::TAU;

use model_discrepancy::{Covariate, Effect, Scope};
use nalgebra::DMatrix;

use crate::axis_reading::{AxisMotion, AxisReading, distinct_targets};
use crate::count;

/// Name of the column that times the readings.
const TIME: &str = "time_s";
/// Readings before the axis turns for the first time from which on they have a lag of their own.
const FEWEST_BEFORE_A_TURN: usize = 5;
/// Below it the sine or cosine of a phase is the phase's own round-off: 10⁶ turns · 2π · 2⁻⁵².
const WAVE_ROUND_OFF: f64 = 2e-9;

/// A positioning run with what was recorded beside it.
#[derive(Clone, Copy, Debug)]
pub struct AxisRun<'r> {
    /// In the order measured.
    pub readings: &'r [AxisReading],
    /// Linear or rotary.
    pub motion: AxisMotion,
    /// Travel per turn of the screw or worm, in the unit of a target; `None`: searched for.
    pub lead: Option<f64>,
    /// Which cycle each reading is of, counted from 0; `None` where it was not recorded.
    pub cycles: Option<&'r [usize]>,
    /// One value per reading; `time_s` drives the drift, columns ending in `_c` thermal growth.
    pub covariates: &'r [Covariate],
}

/// An effect, and what a unit of each of its amplitudes adds to each deviation.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisTerm {
    /// As the loop sees it.
    pub effect: Effect,
    /// One per amplitude, one value per reading.
    pub columns: Vec<Vec<f64>>,
}

impl AxisRun<'_> {
    /// Whether readings repeat targets or come both ways, so that there is a run to speak of.
    #[must_use]
    pub fn is_a_run(&self) -> bool {
        let ways = |sign: f64| {
            self.readings.iter().any(|r| r.approach.is_some_and(|a| a.sign() * sign > 0.0))
        };
        distinct_targets(self.readings).len() < self.readings.len() || ways(1.0) && ways(-1.0)
    }

    pub(super) fn each(&self, value: impl Fn(&AxisReading) -> f64) -> Vec<f64> {
        self.readings.iter().map(value).collect()
    }

    /// What is left of a lag that falls to 1/e over a travel, at the travel of each reading since the turn; apart
    /// where the axis has not turned yet and there are readings enough, as how far it had come then is not known.
    pub(super) fn lagging(&self, travel: f64, since: &[f64]) -> Vec<Vec<f64>> {
        let way = |r: &AxisReading| r.approach.map_or(0.0, crate::Approach::sign);
        let of = |(r, s): (&AxisReading, &f64)| -way(r) * (-s / travel).exp();
        let all: Vec<f64> = self.readings.iter().zip(since).map(of).collect();
        let first = self.readings.first().map_or(0.0, way);
        let turned = self.readings.iter().take_while(|r| way(r) * first > 0.0).count();
        if turned < FEWEST_BEFORE_A_TURN {
            return vec![all];
        }
        let part = |is_of: &dyn Fn(usize) -> bool| {
            let of = |(i, value): (usize, &f64)| if is_of(i) { *value } else { 0.0 };
            all.iter().enumerate().map(of).collect()
        };
        vec![part(&|i| i >= turned), part(&|i| i < turned)]
    }

    /// Travel of each reading since the axis turned round, or since the first reading; `None` where
    /// some way is not known, or none is turned.
    pub(super) fn since_the_turn(&self) -> Option<Vec<f64>> {
        let ways: Vec<f64> =
            self.readings.iter().map(|r| Some(r.approach?.sign())).collect::<Option<_>>()?;
        let (mut turned_at, mut all) = (self.readings.first()?.target, Vec::new());
        for (i, reading) in self.readings.iter().enumerate() {
            if i > 0 && ways[i] * ways[i - 1] < 0.0 {
                turned_at = self.readings[i - 1].target;
            }
            all.push((reading.target - turned_at).abs());
        }
        ways.iter().any(|way| way * ways[0] < 0.0).then_some(all)
    }

    pub(super) fn wave_columns(&self, period: f64) -> (Vec<f64>, Vec<f64>) {
        let phase = |r: &AxisReading| TAU * r.target / period;
        // At targets of whole turns a sine is nothing but round-off, which no amplitude may scale.
        let shown = |value: f64| if value.abs() < WAVE_ROUND_OFF { 0.0 } else { value };
        (self.each(|r| shown(phase(r).cos())), self.each(|r| shown(phase(r).sin())))
    }

    pub(super) fn time(&self) -> Option<&Covariate> {
        self.covariates.iter().find(|c| Self::is_time(c))
    }

    /// Whether a column times the readings.
    pub(super) fn is_time(covariate: &Covariate) -> bool {
        covariate.name == TIME
    }

    /// Time since the first reading, or readings since.
    pub(super) fn elapsed(&self) -> Vec<f64> {
        let Some(time) = self.time() else { return (0..self.readings.len()).map(count).collect() };
        let low = time.values.iter().copied().fold(f64::INFINITY, f64::min);
        time.values.iter().map(|t| t - low).collect()
    }
}

impl AxisTerm {
    /// `∂ residual / ∂ amplitude`: all readings, or the one that it moves.
    pub(crate) fn tangent(&self) -> DMatrix<f64> {
        if let Scope::Observation(row) = self.effect.scope {
            return DMatrix::from_element(1, 1, -self.columns[0][row]);
        }
        let rows = self.columns[0].len();
        DMatrix::from_fn(rows, self.columns.len(), |row, k| -self.columns[k][row])
    }
}
