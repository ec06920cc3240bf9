//! Accuracy and repeatability of positioning by ISO 230-2:2014.
//!
//! With the deviations `x_ij` of target i in cycle j, per direction: mean `x̄_i`, standard deviation
//! `s_i` (n − 1). At a target: `B_i = x̄_i↑ − x̄_i↓`, mean bidirectional deviation
//! `x̄_i = (x̄_i↑ + x̄_i↓)/2`, `R_i↑ = 4 s_i↑`, `R_i = max(2 s_i↑ + 2 s_i↓ + |B_i|, R_i↑, R_i↓)`. Of the
//! axis: `B = max |B_i|`, `M` the range of `x̄_i`, `E↑` the range of `x̄_i↑`, `E` that of all
//! unidirectional means, `R` the largest `R_i`, `A↑` the range of `x̄_i↑ ± 2 s_i↑`, `A` that of both
//! directions together.
//!
//! Standard uncertainties follow the parts that ISO/TR 230-9 lists, as far as the readings and what is
//! declared of the length standard state them: the scatter of the cycles, which holds repeatability
//! and the variation of the environment, and the part that grows with length (standard, alignment,
//! temperature). A mean has `s/√n` with s pooled over all targets, a standard deviation of n readings
//! `s/√(2(n − 1))`. That the extreme of several means is on the mean larger than the extreme of their
//! expectations is not in it.

use crate::axis_reading::{Approach, AxisReading, distinct_targets};
use crate::count;

/// Deviations of one direction at one target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OneWay {
    /// Readings.
    pub n: usize,
    /// Mean deviation.
    pub mean: f64,
    /// Standard deviation of a reading; `None` for a single one.
    pub std: Option<f64>,
}

/// One target of the run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetFigures {
    /// The target, mm or degrees.
    pub target: f64,
    /// Readings approached from below.
    pub rising: Option<OneWay>,
    /// Readings approached from above.
    pub falling: Option<OneWay>,
}

/// A figure and its standard uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    /// Symbol of ISO 230-2, a direction in words.
    pub symbol: &'static str,
    /// Its name.
    pub name: &'static str,
    /// Value; `None` where the readings do not give it.
    pub value: Option<f64>,
    /// Standard uncertainty; `None` where no target was visited twice.
    pub std: Option<f64>,
}

/// The figures of an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisFigures {
    /// In ascending order.
    pub targets: Vec<TargetFigures>,
    /// A, E, R, B and M, those of one direction after each.
    pub figures: Vec<Figure>,
}

/// The way of a reading among the two.
type Way = fn(&TargetFigures) -> Option<OneWay>;

const RISING: Way = |t| t.rising;
const FALLING: Way = |t| t.falling;

impl TargetFigures {
    /// Mean of the two ways, or of the one there is.
    #[must_use]
    pub fn mean(&self) -> f64 {
        match (self.rising, self.falling) {
            (Some(a), Some(b)) => 0.5 * (a.mean + b.mean),
            (Some(one), None) | (None, Some(one)) => one.mean,
            (None, None) => f64::NAN,
        }
    }

    /// Rising less falling.
    #[must_use]
    pub fn reversal(&self) -> Option<f64> {
        Some(self.rising?.mean - self.falling?.mean)
    }

    /// `R_i` of both ways.
    #[must_use]
    pub fn repeatability(&self) -> Option<f64> {
        let (up, down) = (self.rising?.std?, self.falling?.std?);
        let both = 2.0 * up + 2.0 * down + self.reversal()?.abs();
        Some(both.max(4.0 * up).max(4.0 * down))
    }
}

/// Figures of a run; a reading whose approach is not known counts as rising.
///
/// `length_ratio` is the standard uncertainty of the length standard over the length, 0 where it is
/// not to count.
#[must_use]
pub fn axis_figures(readings: &[AxisReading], length_ratio: f64) -> AxisFigures {
    let way = |target: f64, wanted: Approach| {
        let of = |r: &&AxisReading| {
            (r.target + 0.0).total_cmp(&target).is_eq()
                && r.approach.unwrap_or(Approach::Rising) == wanted
        };
        one_way(&readings.iter().filter(of).map(|r| r.deviation).collect::<Vec<_>>())
    };
    let targets: Vec<TargetFigures> = distinct_targets(readings)
        .into_iter()
        .map(|target| TargetFigures {
            target,
            rising: way(target, Approach::Rising),
            falling: way(target, Approach::Falling),
        })
        .collect();
    let length = targets.last().zip(targets.first()).map_or(0.0, |(b, a)| b.target - a.target);
    let figures = Summary::of(&targets, length_ratio * length).figures(&targets);
    AxisFigures { targets, figures }
}

fn one_way(deviations: &[f64]) -> Option<OneWay> {
    let n = deviations.len();
    if n == 0 {
        return None;
    }
    let mean = deviations.iter().sum::<f64>() / count(n);
    let squares: f64 = deviations.iter().map(|d| (d - mean).powi(2)).sum();
    Some(OneWay { n, mean, std: (n > 1).then(|| (squares / count(n - 1)).sqrt()) })
}

/// Largest less smallest; `None` where a value is missing or there is none.
fn range(values: impl Iterator<Item = Option<[f64; 2]>>) -> Option<f64> {
    let mut ends: Option<[f64; 2]> = None;
    for value in values {
        let [low, high] = value?;
        ends = Some(ends.map_or([low, high], |[l, h]| [l.min(low), h.max(high)]));
    }
    ends.map(|[low, high]| high - low)
}

fn largest(values: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    values.collect::<Option<Vec<f64>>>()?.into_iter().reduce(f64::max)
}

/// Scatter of the run, from which every uncertainty comes.
struct Summary {
    /// Standard deviation of a reading, pooled; `None` where nothing is repeated.
    pooled: Option<f64>,
    /// Fewest readings of one way at one target.
    n: usize,
    /// Standard uncertainty of the length standard over the run.
    of_length: f64,
}

impl Summary {
    fn of(targets: &[TargetFigures], of_length: f64) -> Self {
        let ways = || targets.iter().flat_map(|t| [t.rising, t.falling]).flatten();
        let repeated: Vec<(f64, f64)> =
            ways().filter_map(|w| Some((count(w.n - 1), w.std?))).collect();
        let freedom: f64 = repeated.iter().map(|(f, _)| f).sum();
        let squares: f64 = repeated.iter().map(|(f, s)| f * s * s).sum();
        let pooled = (freedom > 0.0).then(|| (squares / freedom).sqrt());
        Self { pooled, n: ways().map(|w| w.n).min().unwrap_or(0), of_length }
    }

    /// Of a mean over the cycles.
    fn of_mean(&self) -> Option<f64> {
        Some(self.pooled? / count(self.n.max(1)).sqrt())
    }

    /// Of a standard deviation over the cycles.
    fn of_std(&self) -> Option<f64> {
        (self.n > 1).then_some(())?;
        Some(self.pooled? / (2.0 * count(self.n - 1)).sqrt())
    }

    fn figures(&self, targets: &[TargetFigures]) -> Vec<Figure> {
        let is_both = targets.iter().any(|t| t.rising.is_some())
            && targets.iter().any(|t| t.falling.is_some());
        let one = |way: Way, of: fn(OneWay) -> Option<[f64; 2]>| {
            let ways: Vec<OneWay> = targets.iter().filter_map(way).collect();
            range(ways.into_iter().map(of))
        };
        let both = |of: fn(OneWay) -> Option<[f64; 2]>| {
            let ways: Vec<OneWay> =
                targets.iter().flat_map(|t| [t.rising, t.falling]).flatten().collect();
            range(ways.into_iter().map(of)).filter(|_| is_both)
        };
        let mean: fn(OneWay) -> Option<[f64; 2]> = |w| Some([w.mean, w.mean]);
        let band: fn(OneWay) -> Option<[f64; 2]> = |w| {
            let s = w.std?;
            Some([w.mean - 2.0 * s, w.mean + 2.0 * s])
        };
        let spread = |way: Way| {
            let ways: Vec<OneWay> = targets.iter().filter_map(way).collect();
            largest(ways.into_iter().map(|w| w.std.map(|s| 4.0 * s)))
        };
        let whole = || targets.iter().filter(|t| t.rising.is_some() && t.falling.is_some());
        let reversal = largest(whole().map(|t| t.reversal().map(f64::abs)));
        let means: Vec<f64> = whole().filter_map(TargetFigures::reversal).collect();
        let mean_reversal =
            (!means.is_empty()).then(|| means.iter().sum::<f64>() / count(means.len()));
        // Differences of two means; four and twice two standard deviations.
        let (u_mean, u_std) = (self.of_mean(), self.of_std());
        let apart = |u: f64| (2.0 * u * u).sqrt();
        let u_e = u_mean.map(|u| apart(u).hypot(self.of_length));
        let u_a = u_e.zip(u_std).map(|(e, s)| e.hypot(2.0 * apart(s)));
        let u_m = u_mean.map(|u| u.hypot(self.of_length));
        let u_r = u_std.zip(u_mean).map(|(s, m)| (2.0 * apart(s)).hypot(apart(m)));
        let u_b = u_mean.map(apart);
        let u_bm = u_b.map(|u| u / count(means.len().max(1)).sqrt());
        let u_one = u_std.map(|s| 4.0 * s);
        let figure = |symbol, name, value: Option<f64>, std: Option<f64>| Figure {
            symbol,
            name,
            value,
            std: value.and(std),
        };
        vec![
            figure("A", "bidirectional accuracy", both(band), u_a),
            figure("A rising", "accuracy of rising approach", one(RISING, band), u_a),
            figure("A falling", "accuracy of falling approach", one(FALLING, band), u_a),
            figure("E", "bidirectional systematic deviation", both(mean), u_e),
            figure("E rising", "systematic deviation, rising", one(RISING, mean), u_e),
            figure("E falling", "systematic deviation, falling", one(FALLING, mean), u_e),
            figure(
                "R",
                "bidirectional repeatability",
                largest(whole().map(TargetFigures::repeatability)),
                u_r,
            ),
            figure("R rising", "repeatability of rising approach", spread(RISING), u_one),
            figure("R falling", "repeatability of falling approach", spread(FALLING), u_one),
            figure("B", "reversal", reversal, u_b),
            figure("B mean", "mean reversal", mean_reversal, u_bm),
            figure(
                "M",
                "range of the mean bidirectional deviation",
                range(whole().map(|t| Some([t.mean(), t.mean()]))),
                u_m,
            ),
        ]
    }
}
