//! What is looked for in the deviations of a run: its catalogue depends on them by these numbers alone.

use model_discrepancy::Left;

use crate::Approach;
use crate::axis_reading::distinct_targets;
use crate::count;
use crate::missing::axis_run::AxisRun;

/// Travels over which a lag falls to 1/e that are tried, as shares of the whole.
pub(super) const LAGS: [f64; 4] = [0.05, 0.1, 0.2, 0.4];
/// Steps to either side with which the best of them is refined.
const LAG_STEPS: i32 = 8;
/// Most targets with a deviation of their own: of many a curve says the same with less.
pub(super) const MAX_PLACES: usize = 64;
/// Roughness of the targets' deviations from which on a period between the targets may have made them.
const ROUGH: f64 = 1.0;
/// Longest period that is looked for: two thirds of the travel, for less than that is a curve.
const FEWEST_WAVES: f64 = 1.5;
/// Steps of the search for a period per independent frequency, so that no wave falls between two.
const STEPS_PER_FREQUENCY: f64 = 2.0;
/// Steps to either side with which the best period is refined.
const REFINED: i32 = 16;
/// How much more a shorter period must explain before it is preferred: targets at equal distances
/// show several periods alike.
const ALIKE: f64 = 1e-9;
/// Targets from which on a period can be looked for: fewer are followed by any wave beside a line.
const MIN_TARGETS_FOR_PERIOD: usize = 8;
/// Targets from which on a lag can be told from a reversal that changes along the travel.
const MIN_TARGETS_FOR_LAG: usize = 5;

/// Ways in which a reversal may be shared between the two sides.
pub(super) const SIDES: usize = 3;
/// Readings from either side from which on a reversal can be told from an offset.
const FEWEST_FROM_A_SIDE: usize = 4;
/// Standard uncertainties from which on what is taken away beside a reversal is there, and below which it is not.
const IS_THERE: f64 = 5.0;
const IS_NOT: f64 = 2.5;
/// Standard deviations, as most of the readings have them, from which on one has no say in that: it may be bad.
const FAR: f64 = 5.0;
/// The median of their sizes over the standard deviation of normal values.
const MEDIAN: f64 = 0.6745;

/// Numbers that the deviations of a run tell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Searched {
    /// Travel over which a lag falls to 1/e, in the unit of a target; `None` where none can be told.
    pub(super) lag: Option<f64>,
    /// The side that alone is off, where zero was set from the other.
    pub(super) side: Option<Approach>,
    /// Period in the unit of a target, and how many were looked through; `None` where none can be told.
    pub(super) period: Option<(f64, usize)>,
    /// Whether the targets' deviations may be those of a period between the targets.
    pub(super) is_unresolved: bool,
    /// Time or readings from the first reading to the last.
    pub(super) span: f64,
}

impl Searched {
    pub(super) fn of(run: &AxisRun<'_>) -> Self {
        let targets = distinct_targets(run.readings);
        let range = targets.last().zip(targets.first()).map_or(0.0, |(b, a)| b - a);
        let shows_period = targets.len() >= MIN_TARGETS_FOR_PERIOD;
        let span = run.elapsed().into_iter().fold(0.0, f64::max);
        let lag = run.searched_lag(targets.len(), range);
        Self {
            lag,
            side: run.side_off(targets.len(), lag),
            period: shows_period.then(|| run.strongest_period(targets.len(), range)).flatten(),
            is_unresolved: targets.len() <= MAX_PLACES
                && run.roughness(&targets).is_some_and(|rough| rough >= ROUGH),
            span: if span > 0.0 { span } else { 1.0 },
        }
    }
}

impl AxisRun<'_> {
    fn searched_lag(&self, targets: usize, range: f64) -> Option<f64> {
        let since = self.since_the_turn()?;
        if targets < MIN_TARGETS_FOR_LAG || range <= 0.0 {
            return None;
        }
        let left = self.left();
        let explained = |share: f64| left.taken_by(&self.lagging(share * range, &since)).share();
        let best = |a: &f64, b: &f64| explained(*a).total_cmp(&explained(*b));
        let share = LAGS.into_iter().max_by(best)?;
        // Between its neighbours, a factor of two away.
        let refined = |step: i32| share * (f64::from(step) / f64::from(LAG_STEPS)).exp2();
        let share = (-LAG_STEPS..=LAG_STEPS).map(refined).max_by(best)?;
        Some(share * range)
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
        let left = self.left();
        let explained = |period: f64| {
            let (cosine, sine) = self.wave_columns(period);
            left.taken_by(&[cosine, sine]).share()
        };
        let mut best: Option<(f64, f64)> = None;
        let mut better = |frequency: f64, margin: f64| {
            let share = explained(1.0 / frequency);
            if best.is_none_or(|(most, _)| share > most * (1.0 + margin)) {
                best = Some((share, frequency));
            }
        };
        (first..=last).for_each(|step| better(count(step) * per_step, ALIKE));
        let (_, coarse) = best?;
        let mut refined = (explained(1.0 / coarse), coarse);
        for step in -REFINED..=REFINED {
            let frequency = coarse + f64::from(step) / f64::from(REFINED) * per_step;
            let share = explained(1.0 / frequency);
            if share > refined.0 {
                refined = (share, frequency);
            }
        }
        let independent = (last - first + 1).div_ceil(2);
        Some((1.0 / refined.1, independent))
    }

    /// The side whose reversal leaves no offset, where one shared by both sides leaves one; `None` of an axis that lags,
    /// which leaves one either way.
    fn side_off(&self, targets: usize, lag: Option<f64>) -> Option<Approach> {
        let from = |side| self.readings.iter().filter(|r| r.approach == Some(side)).count();
        if from(Approach::Falling).min(from(Approach::Rising)) < FEWEST_FROM_A_SIDE {
            return None;
        }
        // At one target, a scale is an offset.
        let scale = if targets < 2 { Vec::new() } else { vec![self.each(|r| r.target)] };
        let reversal = |side| [scale.clone(), self.reversal_columns(side).into()];
        let offset = vec![self.each(|_| 1.0)];
        let deviations = self.each(|r| r.deviation);
        let shared = [&reversal(None).concat()[..], &offset[..]].concat();
        let is_near = near(Left::by(&shared, &deviations).values());
        let kept = |column: &[f64]| -> Vec<f64> {
            column.iter().zip(&is_near).filter(|(_, near)| **near).map(|(v, _)| *v).collect()
        };
        let all_kept = |columns: &[Vec<f64>]| -> Vec<Vec<f64>> {
            columns.iter().map(|column| kept(column)).collect()
        };
        let deviations = kept(&deviations);
        let taken = |beside: &[Vec<f64>], columns: &[Vec<f64>]| {
            Left::by(&all_kept(beside), &deviations).taken_by(&all_kept(columns)).in_sigmas()
        };
        let lagging = lag.zip(self.since_the_turn());
        let lags = lagging.is_some_and(|(travel, since)| {
            taken(&shared, &self.lagging(travel, &since)) >= IS_THERE
        });
        let of_offset = |side| taken(&reversal(side).concat(), &offset);
        let is_off = |side: &Approach| of_offset(Some(*side)) < IS_NOT;
        if lags || of_offset(None) < IS_THERE {
            return None;
        }
        [Approach::Falling, Approach::Rising].into_iter().find(is_off)
    }

    /// Deviations beside offset, scale and reversal.
    fn left(&self) -> Left {
        let middle =
            self.readings.iter().map(|r| r.target).sum::<f64>() / count(self.readings.len());
        let beside = [
            self.each(|_| 1.0),
            self.each(|r| r.target - middle),
            self.each(|r| r.approach.map_or(0.0, Approach::sign)),
        ];
        Left::by(&beside, &self.each(|r| r.deviation))
    }

    /// Mean squared difference from the mean deviation of each target to that of the next about a straight
    /// line, over their variance (von Neumann 1941): 2 for values that have nothing to do with each other,
    /// near 0 along a curve.
    fn roughness(&self, targets: &[f64]) -> Option<f64> {
        let mean = |target: &f64| {
            let of = |r: &&crate::AxisReading| (r.target + 0.0).total_cmp(target).is_eq();
            let sum: f64 = self.readings.iter().filter(of).map(|r| r.deviation).sum();
            sum / count(self.readings.iter().filter(of).count())
        };
        let means: Vec<f64> = targets.iter().map(mean).collect();
        let n = count(targets.len());
        let [middle, mean] = [targets, &means[..]].map(|all| all.iter().sum::<f64>() / n);
        let spread: f64 = targets.iter().map(|x| (x - middle).powi(2)).sum();
        let slope = targets.iter().zip(&means).map(|(x, v)| (x - middle) * (v - mean)).sum::<f64>()
            / spread;
        let left: Vec<f64> =
            targets.iter().zip(&means).map(|(x, v)| v - mean - slope * (x - middle)).collect();
        let variance = left.iter().map(|v| v * v).sum::<f64>() / n;
        let steps: f64 = left.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum();
        let ratio = steps / (n - 1.0) / variance;
        ratio.is_finite().then_some(ratio)
    }
}

/// Which values are not far off most of them.
fn near(values: &[f64]) -> Vec<bool> {
    let mut sizes: Vec<f64> = values.iter().map(|value| value.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let scale = sizes.get(sizes.len() / 2).map_or(0.0, |median| median / MEDIAN);
    values.iter().map(|value| value.abs() <= FAR * scale).collect()
}
