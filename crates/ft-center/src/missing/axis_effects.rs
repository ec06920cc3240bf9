//! What moves an axis off its targets: the catalogue of a positioning run.
//!
//! A deviation is the sum of its effects, so every effect is a few columns: what a unit of each
//! amplitude adds to the deviation of each reading.

use model_discrepancy::{Effect, Parameter, Quantity, Scope, Shown};

use crate::axis_reading::{Approach, AxisMotion, AxisReading, distinct_targets};
use crate::missing::axis_run::{AxisRun, AxisTerm};
use crate::missing::axis_searched::{LAGS, MAX_PLACES, SIDES, Searched};
use crate::missing::parameter::parameter;

/// Reference temperature of dimensional measurement, ISO 1.
const REFERENCE_C: f64 = 20.0;
/// Fewest targets with a deviation of their own: two are a scale.
const MIN_PLACES: usize = 3;
/// Visits that each target must have on the mean before it has a deviation of its own.
pub(super) const MIN_VISITS: usize = 2;
/// Fewest cycles of which each has a zero of its own: of two it is a step between them.
const MIN_CYCLES: usize = 3;
/// A rotary axis must cover this much before what repeats with its turn is told from a curve.
const MIN_ARC_DEG: f64 = 120.0;
const TURN_DEG: f64 = 360.0;
/// Travel of a rotary axis from which on a parabola is no rival: of it a wave per turn and a zero leave a fortieth of its
/// standard deviation over 120°, a ninth over 240°.
const MIN_TURNED_DEG: f64 = 240.0;
/// Waves in the travel by which two periods must differ to be told apart.
const TOLD_APART: f64 = 0.5;

impl AxisRun<'_> {
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
        self.terms_as(&Searched::of(self), shown)
    }

    /// The same, with what was looked for in the deviations.
    pub(super) fn terms_as(&self, searched: &Searched, shown: &Shown) -> Vec<AxisTerm> {
        let mut terms = self.causes(searched);
        terms.extend(self.bad_points());
        terms.extend(self.courses(shown));
        terms
    }

    /// What moves more than one reading, but for the courses of a drift; with what was looked for in the
    /// deviations of this run, or of one that it goes on from.
    pub(super) fn causes(&self, searched: &Searched) -> Vec<AxisTerm> {
        let mut terms = self.reversals(searched.side);
        if let Some(profile) = self.profile() {
            let unresolved = searched.is_unresolved.then(|| self.unresolved_wave(&profile));
            terms.push(profile);
            terms.extend(unresolved);
            // A profile spans zero and pitch together: without this it would be named for them.
            terms.push(self.pitch_and_zero());
        }
        terms.extend(self.cycle_zeros());
        terms.extend(searched.lag.and_then(|travel| self.lag(travel)));
        terms.extend(self.waves(searched.period));
        terms.extend(self.growth());
        terms.push(self.drift(searched.span));
        terms
    }

    /// Whether every target is read once, in order: then whatever goes with time may as well be a deviation of the
    /// targets' own, and what grows along the travel with time is any bow of it.
    pub(super) fn is_one_pass(&self) -> bool {
        let rises = |rises: bool| {
            self.readings.windows(2).all(|pair| (pair[1].target > pair[0].target) == rises)
        };
        distinct_targets(self.readings).len() == self.readings.len()
            && (rises(true) || rises(false))
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

    /// What an axis does when it comes from the other side: the same everywhere, and another from place to place; all of
    /// it on the `side` that is off.
    fn reversals(&self, side: Option<Approach>) -> Vec<AxisTerm> {
        let (fine, factor) = self.motion.reported();
        let stops = match side {
            None => "stops elsewhere when it comes from the other side",
            Some(Approach::Falling) => {
                "stops elsewhere when it falls, and where it says when it rises"
            }
            Some(Approach::Rising) => {
                "stops elsewhere when it rises, and where it says when it falls"
            }
        };
        let everywhere = Effect::new(
            "reversal",
            &format!("the axis {stops}"),
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
        let named = |effect: Effect| match side {
            None => effect,
            Some(way) => {
                let subject = if way == Approach::Falling { "falling" } else { "rising" };
                Effect { searched: SIDES, ..effect }.about(subject)
            }
        };
        let [same, rising, bent] = self.reversal_columns(side);
        let mut all = vec![term(named(everywhere), vec![same])];
        // From one side alone it is a profile.
        let comes = |way| self.readings.iter().any(|r| r.approach == Some(way));
        if comes(Approach::Rising) && comes(Approach::Falling) {
            all.push(term(named(by_place), vec![rising, bent]));
        }
        all
    }

    /// Legendre polynomials of degree 0, 1 and 2 along the travel, times half the way, or all of it on one side.
    pub(super) fn reversal_columns(&self, side: Option<Approach>) -> [Vec<f64>; 3] {
        let share = |r: &AxisReading| match (r.approach, side) {
            (Some(way), None) => 0.5 * way.sign(),
            (Some(way), Some(side)) if way == side => side.sign(),
            _ => 0.0,
        };
        let targets = distinct_targets(self.readings);
        let (low, high) = match (targets.first(), targets.last()) {
            (Some(low), Some(high)) if high > low => (*low, *high),
            (low, _) => (low.copied().unwrap_or(0.0), low.copied().unwrap_or(0.0) + 1.0),
        };
        let along = |r: &AxisReading| 2.0 * (r.target - low) / (high - low) - 1.0;
        let bent = |r: &AxisReading| 1.5 * along(r).powi(2) - 0.5;
        [self.each(share), self.each(|r| share(r) * along(r)), self.each(|r| share(r) * bent(r))]
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
        let effect = effect.at_most(most_of_profile(self.motion));
        let column = |t: &f64| self.each(|r| f64::from(u8::from(is_at(r, *t))));
        Some(term(effect, again.iter().map(column).collect()))
    }

    /// A zero of its own in every cycle.
    fn cycle_zeros(&self) -> Option<AxisTerm> {
        let cycles = self.cycles?;
        let n = cycles.iter().max().map_or(0, |last| last + 1);
        let of = |cycle: usize| cycles.iter().filter(|c| **c == cycle).count();
        let is_seen = (MIN_CYCLES..=MAX_PLACES).contains(&n) && (0..n).all(|c| of(c) >= MIN_VISITS);
        if !is_seen {
            return None;
        }
        let (fine, factor) = self.motion.reported();
        let parameters =
            (1..=n).map(|cycle| parameter(&format!("cycle {cycle}"), fine, factor)).collect();
        let text = "every cycle has a zero of its own: it was set anew, or moved, between them";
        let effect = Effect::new("cycle-zero", text, parameters);
        let column = |cycle: usize| {
            cycles.iter().map(|c| f64::from(u8::from(*c == cycle))).collect::<Vec<f64>>()
        };
        Some(term(effect, (0..n).map(column).collect()))
    }

    /// A period shorter than the targets resolve: it is any deviation of the targets' own.
    fn unresolved_wave(&self, profile: &AxisTerm) -> AxisTerm {
        let key = lead_key(self.motion);
        let lead = match self.lead {
            Some(_) => format!("see whether `{key}` is right"),
            None => format!("declare the lead (`{key}`)"),
        };
        let text = format!(
            "the deviation repeats along the travel with a period that these targets are too far apart to \
             show; measure between them, or {lead}"
        );
        let effect = Effect::new("cyclic-error", &text, profile.effect.parameters.clone());
        term(effect.about("shorter than the targets resolve"), profile.columns.clone())
    }

    /// What an axis has not yet made up after it turned round: balls that roll before they slide, a
    /// wound-up drive.
    fn lag(&self, travel: f64) -> Option<AxisTerm> {
        let columns = self.lagging(travel, &self.since_the_turn()?);
        let (fine, factor) = self.motion.reported();
        let text = format!(
            "the axis lags behind after it turned round; of what it lags at the turn 1/e is left {travel:.4} {} \
             on",
            self.motion.target_unit()
        );
        let names = ["lag at the turn", "at the first reading"];
        let parameters =
            names.iter().take(columns.len()).map(|name| parameter(name, fine, factor)).collect();
        let effect = Effect::new("hysteresis", &text, parameters);
        Some(term(Effect { searched: LAGS.len(), ..effect }, columns))
    }

    /// Errors that repeat with a turn of the screw, worm or axis, or with a period that was looked for.
    fn waves(&self, period: Option<(f64, usize)>) -> Vec<AxisTerm> {
        let targets = distinct_targets(self.readings);
        let range = targets.last().zip(targets.first()).map_or(0.0, |(b, a)| b - a);
        let unit = self.motion.target_unit();
        let mut waves = Vec::new();
        if self.motion == AxisMotion::Rotary && range >= MIN_ARC_DEG {
            waves.push(self.wave("once per turn of the axis", TURN_DEG, 1));
            waves.push(self.wave("twice per turn of the axis", 0.5 * TURN_DEG, 1));
            if range < MIN_TURNED_DEG {
                waves.push(self.parabola());
                waves.push(self.wave_and_zero());
            }
        }
        if let Some(lead) = self.lead {
            waves.push(self.wave(&format!("once per turn of the screw, {lead} {unit}"), lead, 1));
            waves.push(self.wave("twice per turn of the screw", 0.5 * lead, 1));
        }
        let is_of_lead = |period: f64| {
            let turns = |lead: f64| range / period - range / lead;
            self.lead.is_some_and(|lead| {
                [lead, 0.5 * lead].into_iter().any(|lead| turns(lead).abs() < TOLD_APART)
            })
        };
        if let Some((period, searched)) = period.filter(|(period, _)| !is_of_lead(*period)) {
            let digits = format!("{period:.4}");
            let mut wave = self.wave(&format!("period {digits} {unit}"), period, searched);
            if self.lead.is_some() {
                let key = lead_key(self.motion);
                wave.effect.description = format!(
                    "{}; it is not that of the screw: see whether `{key}` is right",
                    wave.effect.description
                );
            }
            waves.push(wave);
        }
        waves
    }

    /// A parabola along the travel, which part of a turn hardly tells from a wave per turn about a zero.
    fn parabola(&self) -> AxisTerm {
        let (fine, factor) = self.motion.reported();
        let (ratio, per) = ratio(self.motion);
        let targets = distinct_targets(self.readings);
        let ends = targets.first().zip(targets.last()).filter(|(low, high)| high > low);
        let (low, travel) = ends.map_or((0.0, 1.0), |(low, high)| (*low, high - low));
        let at = |r: &AxisReading| (r.target - low) / travel;
        let text =
            "every target has a deviation of its own that repeats, on a parabola along the travel";
        let parameters = vec![
            parameter("in the middle beside the ends", fine, factor),
            parameter("pitch error", ratio, per),
            parameter("offset", fine, factor),
        ];
        let middle = self.each(|r| 4.0 * at(r) * (1.0 - at(r)));
        let columns = vec![middle, self.each(|r| r.target), self.each(|_| 1.0)];
        term(Effect::new("profile", text, parameters).about("a parabola"), columns)
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

    /// The wave per turn about a zero that was set at one end of the travel.
    fn wave_and_zero(&self) -> AxisTerm {
        let (fine, factor) = self.motion.reported();
        let mut wave = self.wave("once per turn of the axis, and its zero", TURN_DEG, 1);
        wave.effect.parameters.push(parameter("offset", fine, factor));
        wave.columns.push(self.each(|_| 1.0));
        wave
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
    fn drift(&self, span: f64) -> AxisTerm {
        let passed = self.elapsed().iter().map(|t| t / span).collect();
        let text = "zero and length of the axis drift evenly from the first reading to the last";
        let (mut parameters, mut columns) = (self.growing(", over the run"), self.grown(passed));
        if self.is_one_pass() {
            parameters.truncate(1);
            columns.truncate(1);
        }
        term(self.with_time(Effect::new("drift", text, parameters)), columns)
    }

    /// Driven by the time, where that was recorded.
    pub(super) fn with_time(&self, effect: Effect) -> Effect {
        match self.time() {
            Some(time) => effect.driven_by(&time.name),
            None => effect,
        }
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

/// Deviation that no axis has at a target, a millimetre or a quarter of a degree. A target that is written
/// wrong has more.
fn most_of_profile(motion: AxisMotion) -> f64 {
    match motion {
        AxisMotion::Linear => 1.0,
        AxisMotion::Rotary => 900.0,
    }
}

/// Key of a case's `case.toml` that declares the lead of the screw or worm.
fn lead_key(motion: AxisMotion) -> &'static str {
    match motion {
        AxisMotion::Linear => "[axis] lead_mm",
        AxisMotion::Rotary => "[axis] lead_deg",
    }
}

/// Unit of a deviation over a target as reported, and the factor.
fn ratio(motion: AxisMotion) -> (&'static str, f64) {
    match motion {
        AxisMotion::Linear => ("ppm", 1e6),
        AxisMotion::Rotary => ("arcsec/deg", 1.0),
    }
}
