//! What moves an axis off its targets: the catalogue of a positioning run.
//!
//! A deviation is the sum of its effects, so every effect is a few columns: what a unit of each
//! amplitude adds to the deviation of each reading.

use std::f64::consts::TAU;

use model_discrepancy::{Covariate, Effect, Parameter, Quantity, Scope, Shown};
use nalgebra::{DMatrix, DVector};

use crate::axis_reading::{AxisMotion, AxisReading, distinct_targets};
use crate::count;
use crate::missing::parameter::parameter;

/// Reference temperature of dimensional measurement, ISO 1.
const REFERENCE_C: f64 = 20.0;
/// Name of the column that times the readings.
const TIME: &str = "time_s";
/// Fewest and most targets with a deviation of their own: two are a scale, and of many a curve says
/// the same with less.
const MIN_PLACES: usize = 3;
const MAX_PLACES: usize = 64;
/// Visits that each target must have on the mean before it has a deviation of its own.
pub(super) const MIN_VISITS: usize = 2;
/// Targets from which on a period can be looked for: fewer are followed by any wave beside a line.
const MIN_TARGETS_FOR_PERIOD: usize = 8;
/// Targets from which on a lag can be told from a reversal that changes along the travel.
const MIN_TARGETS_FOR_LAG: usize = 5;
/// Travels over which a lag falls to 1/e that are tried, as shares of the whole.
const LAGS: [f64; 4] = [0.05, 0.1, 0.2, 0.4];
/// Roughness of the targets' deviations from which on a period between the targets may have made them.
const ROUGH: f64 = 1.0;
/// Longest period that is looked for: two thirds of the travel, for less than that is a curve.
const FEWEST_WAVES: f64 = 1.5;
/// Steps of the search for a period per independent frequency, so that no wave falls between two.
const STEPS_PER_FREQUENCY: f64 = 2.0;
/// Steps to either side with which the best period is refined.
const REFINED: i32 = 16;
/// A rotary axis must cover this much before what repeats with its turn is told from a curve.
const MIN_ARC_DEG: f64 = 120.0;
const TURN_DEG: f64 = 360.0;
/// Below it the sine or cosine of a phase is the phase's own round-off: 10⁶ turns · 2π · 2⁻⁵².
const WAVE_ROUND_OFF: f64 = 2e-9;
/// How much more a shorter period must explain before it is preferred: targets at equal distances
/// show several periods alike.
const ALIKE: f64 = 1e-9;

/// An effect, and what a unit of each of its amplitudes adds to each deviation.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisTerm {
    /// As the loop sees it.
    pub effect: Effect,
    /// One per amplitude, one value per reading.
    pub columns: Vec<Vec<f64>>,
}

/// A positioning run with what was recorded beside it.
#[derive(Clone, Copy, Debug)]
pub struct AxisRun<'r> {
    /// In the order measured.
    pub readings: &'r [AxisReading],
    /// Linear or rotary.
    pub motion: AxisMotion,
    /// Travel per turn of the screw or worm, in the unit of a target; `None`: searched for.
    pub lead: Option<f64>,
    /// One value per reading; `time_s` drives the drift, columns ending in `_c` thermal growth.
    pub covariates: &'r [Covariate],
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

    /// Offset and scale: what a machine may be asked for before anything else.
    pub(crate) fn zero_and_pitch(&self) -> Vec<AxisTerm> {
        let (fine, factor) = self.motion.reported();
        let (ratio, per) = ratio(self.motion);
        let zero = Effect::new(
            "datum-offset",
            "axis and length standard count from different origins",
            vec![parameter("offset", fine, factor)],
        );
        let pitch = Effect::new(
            "pitch-error",
            "the axis moves farther than it says by a ratio",
            vec![parameter("pitch error", ratio, per)],
        );
        vec![
            AxisTerm { effect: zero, columns: vec![self.each(|_| 1.0)] },
            term(pitch, vec![self.each(|r| r.target)]),
        ]
    }

    /// All that a run may show beside offset and scale; the courses of its drift are the last.
    #[must_use]
    pub fn terms(&self, shown: &Shown) -> Vec<AxisTerm> {
        let mut terms = self.reversals();
        if let Some(profile) = self.profile() {
            let unresolved = self.unresolved_wave(&profile);
            terms.push(profile);
            terms.extend(unresolved);
            // A profile spans zero and pitch together: without this it would be named for them.
            terms.push(self.pitch_and_zero());
        }
        terms.extend(self.lag());
        terms.extend(self.waves());
        terms.extend(self.growth());
        terms.push(self.drift());
        terms.extend(self.bad_points());
        terms.extend(self.courses(shown));
        terms
    }

    /// A pitch error about a place at which the axis does not count from zero.
    fn pitch_and_zero(&self) -> AxisTerm {
        let (fine, factor) = self.motion.reported();
        let (ratio, per) = ratio(self.motion);
        let effect = Effect::new(
            "pitch-error",
            "the axis moves farther than it says by a ratio, and counts from a different origin",
            vec![parameter("offset", fine, factor), parameter("pitch error", ratio, per)],
        );
        let columns = vec![self.each(|_| 1.0), self.each(|r| r.target)];
        term(effect.about("and its zero"), columns)
    }

    fn each(&self, value: impl Fn(&AxisReading) -> f64) -> Vec<f64> {
        self.readings.iter().map(value).collect()
    }

    fn reversals(&self) -> Vec<AxisTerm> {
        let (fine, factor) = self.motion.reported();
        let half = |r: &AxisReading| r.approach.map_or(0.0, |a| 0.5 * a.sign());
        let targets = distinct_targets(self.readings);
        let (Some(low), Some(high)) = (targets.first(), targets.last()) else { return Vec::new() };
        let span = if high > low { high - low } else { 1.0 };
        let along = |target: f64| 2.0 * (target - low) / span - 1.0;
        let everywhere = Effect::new(
            "reversal",
            "the axis stops elsewhere when it comes from the other side",
            vec![parameter("rising less falling", fine, factor)],
        );
        let by_place = Effect::new(
            "backlash-by-place",
            "the reversal is another at the ends of the travel than in its middle",
            vec![
                parameter("more at the upper than at the lower end, half", fine, factor),
                parameter("more at the ends than in the middle, two thirds", fine, factor),
            ],
        );
        let bent = |r: &AxisReading| half(r) * (1.5 * along(r.target).powi(2) - 0.5);
        vec![
            term(everywhere, vec![self.each(half)]),
            term(by_place, vec![self.each(|r| half(r) * along(r.target)), self.each(bent)]),
        ]
    }

    /// A deviation of its own at every target that is visited again.
    fn profile(&self) -> Option<AxisTerm> {
        let targets = distinct_targets(self.readings);
        let is_at = |r: &AxisReading, target: f64| (r.target + 0.0).total_cmp(&target).is_eq();
        let visits = |target: f64| self.readings.iter().filter(|r| is_at(r, target)).count();
        let again: Vec<f64> = targets.iter().copied().filter(|t| visits(*t) > 1).collect();
        let is_repeated = (MIN_PLACES..=MAX_PLACES).contains(&again.len())
            && self.readings.len() >= MIN_VISITS * targets.len();
        if !is_repeated {
            return None;
        }
        let (fine, factor) = self.motion.reported();
        let unit = self.motion.target_unit();
        let parameters: Vec<Parameter> =
            again.iter().map(|t| parameter(&format!("at {t} {unit}"), fine, factor)).collect();
        let effect = Effect::new(
            "profile",
            "every target has a deviation of its own that repeats",
            parameters,
        );
        let column = |t: &f64| self.each(|r| f64::from(u8::from(is_at(r, *t))));
        Some(term(effect, again.iter().map(column).collect()))
    }

    /// A period shorter than the targets resolve, where their deviations jump from each to the next: it
    /// is any deviation of the targets' own.
    fn unresolved_wave(&self, profile: &AxisTerm) -> Option<AxisTerm> {
        let targets = distinct_targets(self.readings);
        let mean = |target: &f64| {
            let of = |r: &&AxisReading| (r.target + 0.0).total_cmp(target).is_eq();
            let sum: f64 = self.readings.iter().filter(of).map(|r| r.deviation).sum();
            sum / count(self.readings.iter().filter(of).count())
        };
        let means: Vec<f64> = targets.iter().map(mean).collect();
        if self.lead.is_some() || roughness(&targets, &means)? < ROUGH {
            return None;
        }
        let text = "the deviation repeats along the travel with a period that these targets are too \
                    far apart to show; measure between them, or declare the lead (`[axis] lead_mm`)";
        let effect = Effect::new("cyclic-error", text, profile.effect.parameters.clone());
        Some(term(effect.about("shorter than the targets resolve"), profile.columns.clone()))
    }

    /// What an axis has not yet made up after it turned round: balls that roll before they slide, a
    /// wound-up drive.
    fn lag(&self) -> Option<AxisTerm> {
        let travelled = self.since_the_turn()?;
        let targets = distinct_targets(self.readings);
        let range = targets.last().zip(targets.first()).map_or(0.0, |(b, a)| b - a);
        if targets.len() < MIN_TARGETS_FOR_LAG || range <= 0.0 {
            return None;
        }
        let column = |share: f64| -> Vec<f64> {
            let of = |(r, s): (&AxisReading, &f64)| {
                -r.approach.map_or(0.0, crate::Approach::sign) * (-s / (share * range)).exp()
            };
            self.readings.iter().zip(&travelled).map(of).collect()
        };
        let explained = |share: &f64| self.explained_by(vec![column(*share)]);
        let share = LAGS.into_iter().max_by(|a, b| explained(a).total_cmp(&explained(b)))?;
        let (fine, factor) = self.motion.reported();
        let text = format!(
            "the axis lags behind after it turned round; of what it lags at the turn 1/e is left {:.4} {} \
             on",
            share * range,
            self.motion.target_unit()
        );
        let effect =
            Effect::new("hysteresis", &text, vec![parameter("lag at the turn", fine, factor)]);
        Some(term(Effect { searched: LAGS.len(), ..effect }, vec![column(share)]))
    }

    /// Travel of each reading since the axis turned round, or since the first reading; `None` where
    /// some way is not known, or none is turned.
    fn since_the_turn(&self) -> Option<Vec<f64>> {
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

    /// Errors that repeat with a turn of the screw, worm or axis.
    fn waves(&self) -> Vec<AxisTerm> {
        let targets = distinct_targets(self.readings);
        let range = targets.last().zip(targets.first()).map_or(0.0, |(b, a)| b - a);
        let unit = self.motion.target_unit();
        let mut waves = Vec::new();
        if self.motion == AxisMotion::Rotary && range >= MIN_ARC_DEG {
            waves.push(self.wave("once per turn of the axis", TURN_DEG, 1));
            waves.push(self.wave("twice per turn of the axis", 0.5 * TURN_DEG, 1));
        }
        if let Some(lead) = self.lead {
            waves.push(self.wave(&format!("once per turn of the screw, {lead} {unit}"), lead, 1));
            waves.push(self.wave("twice per turn of the screw", 0.5 * lead, 1));
        } else if targets.len() >= MIN_TARGETS_FOR_PERIOD
            && let Some((period, searched)) = self.strongest_period(targets.len(), range)
        {
            let digits = format!("{period:.4}");
            waves.push(self.wave(&format!("period {digits} {unit}"), period, searched));
        }
        waves
    }

    fn wave(&self, subject: &str, period: f64, searched: usize) -> AxisTerm {
        let (fine, factor) = self.motion.reported();
        let parameters =
            ["cosine", "sine"].map(|name| parameter(name, fine, factor)).into_iter().collect();
        let text = "the deviation repeats along the travel, as a screw, worm or scale does that is \
                    not round or not even";
        let effect = Effect { searched, ..Effect::new("cyclic-error", text, parameters) };
        let (cosine, sine) = self.wave_columns(period);
        term(effect.about(subject), vec![cosine, sine])
    }

    fn wave_columns(&self, period: f64) -> (Vec<f64>, Vec<f64>) {
        let phase = |r: &AxisReading| TAU * r.target / period;
        // At targets of whole turns a sine is nothing but round-off, which no amplitude may scale.
        let shown = |value: f64| if value.abs() < WAVE_ROUND_OFF { 0.0 } else { value };
        (self.each(|r| shown(phase(r).cos())), self.each(|r| shown(phase(r).sin())))
    }

    /// The period that describes the deviations best beside offset, scale and reversal, with how
    /// many independent ones there were.
    fn strongest_period(&self, targets: usize, range: f64) -> Option<(f64, usize)> {
        // Frequencies a half wave in the travel apart are independent; above one wave in two targets
        // shorter periods look like longer ones.
        let per_step = 1.0 / (2.0 * STEPS_PER_FREQUENCY * range);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "twice the number of targets"
        )]
        let steps = |waves: f64| (2.0 * STEPS_PER_FREQUENCY * waves).round() as usize;
        let (first, last) = (steps(FEWEST_WAVES), steps(0.5 * count(targets - 1)));
        let mut best: Option<(f64, f64)> = None;
        let mut better = |frequency: f64, margin: f64| {
            let explained = self.explained_by_wave(1.0 / frequency);
            if best.is_none_or(|(most, _)| explained > most * (1.0 + margin)) {
                best = Some((explained, frequency));
            }
        };
        (first..=last).for_each(|step| better(count(step) * per_step, ALIKE));
        let (_, coarse) = best?;
        let mut refined = (self.explained_by_wave(1.0 / coarse), coarse);
        for step in -REFINED..=REFINED {
            let frequency = coarse + f64::from(step) / f64::from(REFINED) * per_step;
            let explained = self.explained_by_wave(1.0 / frequency);
            if explained > refined.0 {
                refined = (explained, frequency);
            }
        }
        let independent = (last - first + 1).div_ceil(2);
        Some((1.0 / refined.1, independent))
    }

    fn explained_by_wave(&self, period: f64) -> f64 {
        let (cosine, sine) = self.wave_columns(period);
        self.explained_by(vec![cosine, sine])
    }

    /// Sum of squares that columns take away beside offset, scale and reversal.
    fn explained_by(&self, columns: Vec<Vec<f64>>) -> f64 {
        let middle =
            self.readings.iter().map(|r| r.target).sum::<f64>() / count(self.readings.len());
        let beside = [
            self.each(|_| 1.0),
            self.each(|r| r.target - middle),
            self.each(|r| r.approach.map_or(0.0, crate::Approach::sign)),
        ];
        let mut basis: Vec<DVector<f64>> = Vec::new();
        let mut left = |column: Vec<f64>| {
            let column = DVector::from_vec(column);
            let mut rest = column.clone();
            for direction in &basis {
                rest -= direction.dot(&rest) * direction;
            }
            // What rounding leaves of a column that the others hold is no direction.
            let unit = rest.try_normalize(1e-9 * column.norm())?;
            basis.push(unit.clone());
            Some(unit)
        };
        for column in beside {
            left(column);
        }
        let deviations = DVector::from_vec(self.each(|r| r.deviation));
        columns
            .into_iter()
            .filter_map(&mut left)
            .map(|direction| direction.dot(&deviations).powi(2))
            .sum()
    }

    /// Growth with every temperature that was recorded.
    fn growth(&self) -> Vec<AxisTerm> {
        let (fine, factor) = self.motion.reported();
        let (ratio, per) = ratio(self.motion);
        let columns = self.covariates.iter().filter(|c| c.quantity == Quantity::Temperature);
        columns
            .map(|column| {
                let text = format!("the axis grows, or its zero moves, with {}", column.name);
                let parameters = vec![
                    parameter("of the zero", &format!("{fine}/K"), factor),
                    parameter("along the travel", &format!("{ratio}/K"), per),
                ];
                let effect = Effect::new("temperature", &text, parameters).driven_by(&column.name);
                let excess: Vec<f64> = column.values.iter().map(|t| t - REFERENCE_C).collect();
                let grown = self.readings.iter().zip(&excess).map(|(r, t)| r.target * t).collect();
                term(effect.about(&column.name), vec![excess.clone(), grown])
            })
            .collect()
    }

    /// Growth without a thermometer: even from the first reading to the last.
    pub(super) fn drift(&self) -> AxisTerm {
        let elapsed = self.elapsed();
        let span = elapsed.iter().copied().fold(0.0, f64::max);
        let span = if span > 0.0 { span } else { 1.0 };
        let passed = elapsed.iter().map(|t| t / span).collect();
        let text = "zero and length of the axis drift evenly from the first reading to the last";
        let effect = Effect::new("drift", text, self.growing(", over the run"));
        term(self.with_time(effect), self.grown(passed))
    }

    /// Driven by the time, where that was recorded.
    pub(super) fn with_time(&self, effect: Effect) -> Effect {
        if self.time().is_some() { effect.driven_by(TIME) } else { effect }
    }

    /// Amplitudes of a drift.
    pub(super) fn growing(&self, when: &str) -> Vec<Parameter> {
        let (fine, factor) = self.motion.reported();
        let (ratio, per) = ratio(self.motion);
        vec![
            parameter(&format!("of the zero{when}"), fine, factor),
            parameter(&format!("along the travel{when}"), ratio, per),
        ]
    }

    /// Zero and length that follow a course.
    pub(super) fn grown(&self, course: Vec<f64>) -> Vec<Vec<f64>> {
        let grown = self.readings.iter().zip(&course).map(|(r, t)| r.target * t).collect();
        vec![course, grown]
    }

    pub(super) fn time(&self) -> Option<&Covariate> {
        self.covariates.iter().find(|c| c.name == TIME)
    }

    /// Time since the first reading, or readings since.
    pub(super) fn elapsed(&self) -> Vec<f64> {
        let Some(time) = self.time() else { return (0..self.readings.len()).map(count).collect() };
        let low = time.values.iter().copied().fold(f64::INFINITY, f64::min);
        time.values.iter().map(|t| t - low).collect()
    }

    fn bad_points(&self) -> impl Iterator<Item = AxisTerm> {
        let (fine, factor) = self.motion.reported();
        let n = self.readings.len();
        self.readings.iter().enumerate().map(move |(row, reading)| {
            let text = "one reading is off, unlike the others";
            let effect = Effect::new("bad-point", text, vec![parameter("off by", fine, factor)]);
            let effect = effect.about(&reading.name).within(Scope::Observation(row));
            let mut column = vec![0.0; n];
            column[row] = 1.0;
            AxisTerm { effect, columns: vec![column] }
        })
    }
}

/// Designs that show nothing of it exist.
fn term(effect: Effect, columns: Vec<Vec<f64>>) -> AxisTerm {
    AxisTerm { effect: effect.within(Scope::SomeDesigns), columns }
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

/// Unit of a deviation over a target as reported, and the factor.
fn ratio(motion: AxisMotion) -> (&'static str, f64) {
    match motion {
        AxisMotion::Linear => ("ppm", 1e6),
        AxisMotion::Rotary => ("arcsec/deg", 1.0),
    }
}

/// Mean squared difference from each value to the next about a straight line, over their variance (von
/// Neumann 1941): 2 for values that have nothing to do with each other, near 0 along a curve.
fn roughness(at: &[f64], values: &[f64]) -> Option<f64> {
    let n = count(values.len());
    let [middle, mean] = [at, values].map(|all| all.iter().sum::<f64>() / n);
    let spread: f64 = at.iter().map(|x| (x - middle).powi(2)).sum();
    let slope = at.iter().zip(values).map(|(x, v)| (x - middle) * (v - mean)).sum::<f64>() / spread;
    let left: Vec<f64> =
        at.iter().zip(values).map(|(x, v)| v - mean - slope * (x - middle)).collect();
    let variance = left.iter().map(|v| v * v).sum::<f64>() / n;
    let steps: f64 = left.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum();
    let ratio = steps / (n - 1.0) / variance;
    ratio.is_finite().then_some(ratio)
}
