//! A drift that comes to rest, found by looking for its time constant.

use nalgebra::DMatrix;

use crate::algebra::drifts::{Drifts, along};
use crate::algebra::looked_through::FALSE_ALARM;
use crate::count::count;
use crate::{Effect, Model, State, whole_tangent};

/// Time constants that are tried, as shares of the series: from a few readings to a quarter of it,
/// beyond which the course is a straight line with a bend, and a drift is called so.
const SHARES: [f64; 6] = [0.03, 0.05, 0.08, 0.12, 0.18, 0.27];

/// Longer ones of a slower course beside a fast one.
const SLOWER: [f64; 3] = [0.4, 0.6, 1.0];

/// Times by which a slower course is slower, at least: closer ones are one.
const APART: f64 = 2.5;

/// Share of the whole that either of two courses has, at least.
const LEAST: f64 = 0.1;

/// Share of what the time constant does to the readings that their course must leave, squared: where
/// the readings lie at two levels alone, every course is the same, and rounding leaves 1e-30.
const SHOWN: f64 = 1e-9;

/// Steps of the time constant once one is found, either way.
const REFINED: [f64; 5] = [1.2, 1.1, 1.05, 1.02, 1.01];

/// A first-order course: a spindle or a stand that warms up, a pad that sets; or two of them, a small part that is warm soon and a frame that follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settling {
    rest: Rest,
    /// In the unit in which time is counted.
    time_constant: f64,
    slower: Option<Slower>,
    searched: usize,
    leaves_another: bool,
}

/// Where a drift comes to rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rest {
    /// Away from where it started, which was as declared: `1 − exp(−t/τ)`.
    Away,
    /// As declared, from where it started: `exp(−t/τ)`. Where a zero is fitted it is the same.
    AsDeclared,
}

/// The slower of two courses.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Slower {
    time_constant: f64,
    /// Of the whole, 0 to 1.
    share: f64,
}

impl Settling {
    /// Whether the residual shows another course beside it that goes its own way: then it is not the
    /// whole of what happened.
    #[must_use]
    pub fn leaves_another(&self) -> bool {
        self.leaves_another
    }

    /// Whether the time constants of another are no further off than a factor.
    pub(crate) fn is_like(&self, other: &Self, factor: f64) -> bool {
        let near = |a: f64, b: f64| a.max(b) <= factor * a.min(b);
        self.rest == other.rest
            && near(self.time_constant, other.time_constant)
            && self.leaves_another == other.leaves_another
            && match (self.slower, other.slower) {
                (Some(a), Some(b)) => near(a.time_constant, b.time_constant),
                (None, None) => true,
                _ => false,
            }
    }

    pub(crate) fn rests_as_declared(&self) -> bool {
        self.rest == Rest::AsDeclared
    }

    /// The same drift from where it started to what was declared, or the other way.
    pub(crate) fn the_other_way(&self) -> Self {
        let rest = if self.rest == Rest::Away { Rest::AsDeclared } else { Rest::Away };
        Self { rest, ..*self }
    }

    /// How far it is at a time since its start from where it was declared to be.
    pub(crate) fn come(&self, t: f64) -> f64 {
        let slower = self.slower.map(|s| (s.share, course(t, s.time_constant)));
        let (share, slow) = slower.unwrap_or((0.0, 0.0));
        let come = (1.0 - share) * course(t, self.time_constant) + share * slow;
        if self.rest == Rest::Away { come } else { 1.0 - come }
    }

    /// What a unit of each of its numbers adds to how far it has come: of its time constant, and of a
    /// slower course the time constant and the share.
    fn by_constant(&self, t: f64) -> Vec<f64> {
        let sign = if self.rest == Rest::Away { 1.0 } else { -1.0 };
        let fast = sign * by_constant(t, self.time_constant);
        let Some(Slower { time_constant, share }) = self.slower else { return vec![fast] };
        let more = sign * (course(t, time_constant) - course(t, self.time_constant));
        vec![(1.0 - share) * fast, share * sign * by_constant(t, time_constant), more]
    }

    /// The effect for the drift of a model that goes on evenly, an effect of its catalogue, and the time
    /// that had passed at each observation.
    pub(crate) fn effect(
        &self,
        model: &dyn Model,
        drift: usize,
        elapsed: &[f64],
        time_unit: &str,
    ) -> Effect {
        let even = &model.declared().effects[drift];
        let (how, words) = match self.rest {
            Rest::Away => ("settling", "and comes to rest: 1 − exp(−t/τ)"),
            Rest::AsDeclared => (
                "settling to zero",
                "from what it was at first and comes to rest as declared: exp(−t/τ)",
            ),
        };
        let mut effect = along(even, how, self.searched);
        effect.by_place = self.by_place(model, drift, elapsed);
        let slower = self.slower.map_or_else(String::new, |slower| {
            let Slower { time_constant, share } = slower;
            format!(", and {:.1} % of it with τ = {time_constant} {time_unit}", 100.0 * share)
        });
        effect.description =
            format!("{} {words}, τ = {} {time_unit}{slower}", even.description, self.time_constant);
        effect
    }

    /// What a unit of its numbers does to the residual of each row, per unit of each amplitude.
    fn by_place(&self, model: &dyn Model, drift: usize, elapsed: &[f64]) -> Vec<DMatrix<f64>> {
        let even = whole_tangent(model, &State::start(model), drift);
        let rows = &model.declared().layout.rows;
        let ways: Vec<Vec<f64>> = (rows.iter())
            .map(|row| elapsed.get(row.observation).copied().filter(|t| *t > 0.0))
            .map(|t| t.map_or_else(Vec::new, |t| scaled(self.by_constant(t), 1.0 / t)))
            .collect();
        let numbers = ways.iter().map(Vec::len).max().unwrap_or(0);
        let of = |amplitude: nalgebra::DVectorView<'_, f64>| {
            DMatrix::from_fn(rows.len(), numbers, |row, number| {
                ways[row].get(number).map_or(0.0, |way| way * amplitude[row])
            })
        };
        even.column_iter().map(|amplitude| of(amplitude.as_view())).collect()
    }
}

fn scaled(values: Vec<f64>, factor: f64) -> Vec<f64> {
    values.into_iter().map(|value| value * factor).collect()
}

/// What a unit of the time constant adds to a course.
fn by_constant(elapsed: f64, time_constant: f64) -> f64 {
    -elapsed / time_constant.powi(2) * (-elapsed / time_constant).exp()
}

fn course(elapsed: f64, time_constant: f64) -> f64 {
    -(-elapsed / time_constant).exp_m1()
}

/// The time constant with which a drift takes most of the residual, and a second one where the first
/// leaves what that takes; `None` where white noise might show one as clear.
pub(crate) fn settling_of(drifts: &Drifts<'_>, rest: Rest, false_alarm: f64) -> Option<Settling> {
    let span = drifts.span();
    let tried = |share: f64| drifts.explained(Settling::of(rest, share * span, SHARES.len()));
    let all = SHARES.iter().filter_map(|share| tried(*share));
    let best = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let moved =
        |s: &Settling, factor: f64| Settling::of(rest, s.time_constant * factor, s.searched);
    let (most, best) = drifts.refined(best, &[&moved]);
    let columns = drifts.even.ncols();
    if !drifts.shows_constant(&best) {
        return None;
    }
    if drifts.residual.p_value(most, columns) * count(SHARES.len()) > false_alarm {
        return None;
    }
    Some(drifts.with_slower(rest, span, most).unwrap_or_else(|| {
        let leaves_another = drifts.shows_another(&best, span, most);
        Settling { leaves_another, ..best }
    }))
}

impl Settling {
    fn of(rest: Rest, time_constant: f64, searched: usize) -> Self {
        let time_constant = three_digits(time_constant);
        Self { rest, time_constant, slower: None, searched, leaves_another: false }
    }
}

/// One of the numbers of a course moved by a factor.
type Moved<'m> = &'m dyn Fn(&Settling, f64) -> Settling;

impl Drifts<'_> {
    /// What the fitted parameters leave of the drift along a course.
    fn left_of(&self, settling: &Settling) -> DMatrix<f64> {
        self.left_along(|t| settling.come(t))
    }

    /// Whether another time constant is anything else than another amplitude.
    fn shows_constant(&self, best: &Settling) -> bool {
        let left = self.left_of(best);
        let Some(amplitudes) = self.residual.amplitudes(&left) else { return false };
        let way = self.left_along(|t| by_constant(t, best.time_constant)) * amplitudes;
        let Some(inverse) = left.tr_mul(&left).cholesky() else { return false };
        let taken = &left * inverse.solve(&left.tr_mul(&way));
        (&way - taken).norm_squared() > SHOWN * way.norm_squared()
    }

    fn explained(&self, settling: Settling) -> Option<(f64, Settling)> {
        Some((self.residual.explained(&self.left_of(&settling))?, settling))
    }

    fn refined(&self, best: (f64, Settling), ways: &[Moved<'_>]) -> (f64, Settling) {
        let mut best = best;
        for step in REFINED {
            for (way, factor) in ways.iter().flat_map(|way| [(way, 1.0 / step), (way, step)]) {
                let moved = self.explained(way(&best.1, factor));
                if let Some(more) = moved.filter(|(more, _)| *more > best.0) {
                    best = more;
                }
            }
        }
        best
    }

    /// Two courses, where one leaves clearly more than they do.
    fn with_slower(&self, rest: Rest, span: f64, most: f64) -> Option<Settling> {
        let slower: Vec<f64> = SHARES.iter().chain(&SLOWER).copied().collect();
        let pairs: Vec<(f64, f64)> = (SHARES.iter())
            .flat_map(|fast| slower.iter().map(move |slow| (*fast, *slow)))
            .filter(|(fast, slow)| *slow >= APART * fast)
            .collect();
        let searched = pairs.len();
        let of_pair = |&(fast, slow): &(f64, f64)| {
            let one = Settling::of(rest, fast * span, searched);
            let time_constant = three_digits(slow * span);
            let share = self.share(&one, &Settling::of(rest, time_constant, 1))?;
            let two = Slower { time_constant, share };
            self.explained(Settling { slower: Some(two), ..one })
        };
        let all = pairs.iter().filter_map(of_pair);
        let best = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let faster = |s: &Settling, factor: f64| Settling {
            time_constant: three_digits(s.time_constant * factor),
            ..*s
        };
        let of_slower = |s: &Settling, change: &dyn Fn(Slower) -> Slower| Settling {
            slower: s.slower.map(change),
            ..*s
        };
        let later = |s: &Settling, factor: f64| {
            of_slower(s, &|two| Slower {
                time_constant: three_digits(two.time_constant * factor),
                ..two
            })
        };
        let more = |s: &Settling, factor: f64| {
            let within = |share: f64| share.clamp(LEAST, 1.0 - LEAST);
            of_slower(s, &|two| Slower { share: within(three_digits(two.share * factor)), ..two })
        };
        let (explained, two) = self.refined(best, &[&faster, &later, &more]);
        // A second time constant and a share.
        let p_value = self.residual.p_value_of_more(explained - most, 2, explained);
        (p_value * count(searched) <= FALSE_ALARM).then_some(two)
    }

    /// Whether another course, with amplitudes of its own, takes what white noise hardly ever shows
    /// beside one that takes `most`.
    fn shows_another(&self, one: &Settling, span: f64, most: f64) -> bool {
        let explained = |share: &f64| {
            let both = self.left_of_both(one, &Settling::of(one.rest, share * span, 1));
            self.residual.explained(&both)
        };
        let all = SHARES.iter().filter_map(explained).fold(most, f64::max);
        let p_value = self.residual.p_value_of_more(all - most, self.even.ncols(), all);
        p_value * count(SHARES.len()) <= FALSE_ALARM
    }

    fn left_of_both(&self, one: &Settling, other: &Settling) -> DMatrix<f64> {
        self.left_along_each(&[&|t| one.come(t), &|t| other.come(t)])
    }

    /// Share of the second of two courses in what both come to, where both have a part in it.
    fn share(&self, one: &Settling, other: &Settling) -> Option<f64> {
        let columns = self.even.ncols();
        let both = self.left_of_both(one, other);
        let amplitudes = self.residual.amplitudes(&both)?;
        // In what each amplitude moves the readings: their units may differ.
        let moved: Vec<f64> = both.column_iter().skip(columns).map(|c| c.norm_squared()).collect();
        let of = |k: usize| (amplitudes[k], amplitudes[columns + k], moved[k]);
        let (part, whole) = (0..columns).map(of).fold((0.0, 0.0), |(part, whole), (a, b, m)| {
            (part + m * b * (a + b), whole + m * (a + b) * (a + b))
        });
        let share = three_digits(part / whole);
        (LEAST..=1.0 - LEAST).contains(&share).then_some(share)
    }
}

/// Rounded to three significant digits, as it is printed.
fn three_digits(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}
