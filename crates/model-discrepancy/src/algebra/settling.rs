//! The course of a drift that comes to rest.

use nalgebra::DMatrix;

use crate::algebra::drifts::along;
use crate::{Effect, Model, State, whole_tangent};

/// Times by which a slower course is slower, at least: closer ones are one, and closer ones that go the other way take most
/// of each other, so that what is left of both is any hump.
pub(super) const APART: f64 = 2.5;
const APART_THE_OTHER_WAY: f64 = 4.0;

/// Share that either of two courses has, at least.
pub(super) const LEAST: f64 = 0.1;

/// A first-order course: a spindle or a stand that warms up, a pad that sets; or two of them, a small part that is warm soon and a frame that follows, or
/// goes the other way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settling {
    pub(super) rest: Rest,
    /// In the unit in which time is counted.
    pub(super) time_constant: f64,
    pub(super) slower: Option<Slower>,
    pub(super) searched: usize,
    pub(super) leaves_another: bool,
}

/// Where a drift comes to rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rest {
    /// Away from where it started, which was as declared: `1 − exp(−t/τ)`.
    Away,
    /// As declared, from where it started: `exp(−t/τ)`. Where a zero is fitted it is the same.
    AsDeclared,
}

impl Rest {
    /// How far it is at a time since its start from where it was declared to be.
    fn at(self, t: f64, time_constant: f64) -> f64 {
        if self == Self::Away { -(-t / time_constant).exp_m1() } else { (-t / time_constant).exp() }
    }
}

/// The slower of two courses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Slower {
    pub(super) time_constant: f64,
    /// Of both courses' sizes together, −1 to 1: negative, it goes the other way.
    pub(super) share: f64,
}

impl Slower {
    /// Share of the faster one.
    fn of_faster(&self) -> f64 {
        1.0 - self.share.abs()
    }

    /// Whether it is slower than that by enough.
    pub(super) fn is_apart(&self, faster: f64) -> bool {
        let apart = if self.share < 0.0 { APART_THE_OTHER_WAY } else { APART };
        self.time_constant >= apart * faster
    }
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

    /// Whether its slower course goes the other way: its amplitude is then the size of both.
    pub(crate) fn goes_both_ways(&self) -> bool {
        self.slower.is_some_and(|slower| slower.share < 0.0)
    }

    /// The same drift from where it started to what was declared, or the other way.
    pub(crate) fn the_other_way(&self) -> Self {
        let rest = if self.rest == Rest::Away { Rest::AsDeclared } else { Rest::Away };
        Self { rest, ..*self }
    }

    /// How far it is at a time since its start from where it was declared to be.
    pub(crate) fn come(&self, t: f64) -> f64 {
        let fast = self.rest.at(t, self.time_constant);
        let both = |slower: Slower| {
            slower.of_faster() * fast + slower.share * self.rest.at(t, slower.time_constant)
        };
        self.slower.map_or(fast, both)
    }

    /// What a unit of each of its numbers adds to how far it has come: of its time constant, and of a
    /// slower course the time constant and the share.
    pub(super) fn by_constant(&self, t: f64) -> Vec<f64> {
        let sign = if self.rest == Rest::Away { 1.0 } else { -1.0 };
        let fast = sign * by_constant(t, self.time_constant);
        let Some(slower) = self.slower else { return vec![fast] };
        let Slower { time_constant, share } = slower;
        let [own, of_faster] =
            [time_constant, self.time_constant].map(|constant| self.rest.at(t, constant));
        let slow = share * sign * by_constant(t, time_constant);
        vec![slower.of_faster() * fast, slow, own - share.signum() * of_faster]
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
            let way = if share < 0.0 { " (the other way)" } else { "" };
            format!(", and {:.1} % of it{way} with τ = {time_constant} {time_unit}", 100.0 * share)
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
pub(super) fn by_constant(elapsed: f64, time_constant: f64) -> f64 {
    -elapsed / time_constant.powi(2) * (-elapsed / time_constant).exp()
}

impl Settling {
    /// Two courses with other numbers; `None` where these are no longer two that both have a part.
    pub(super) fn moved(&self, [faster, later, share]: [f64; 3]) -> Option<Self> {
        let slower = self.slower?;
        let time_constant = self.time_constant + faster;
        let slower =
            Slower { time_constant: slower.time_constant + later, share: slower.share + share };
        let are_two = time_constant > 0.0
            && slower.is_apart(time_constant)
            && (LEAST..=1.0 - LEAST).contains(&slower.share.abs());
        are_two.then_some(Self { time_constant, slower: Some(slower), ..*self })
    }

    /// Its numbers as they are printed.
    pub(super) fn rounded(&self) -> Self {
        let of_slower = |slower: Slower| Slower {
            time_constant: three_digits(slower.time_constant),
            share: three_digits(slower.share),
        };
        let time_constant = three_digits(self.time_constant);
        Self { time_constant, slower: self.slower.map(of_slower), ..*self }
    }

    pub(super) fn of(rest: Rest, time_constant: f64, searched: usize) -> Self {
        let time_constant = three_digits(time_constant);
        Self { rest, time_constant, slower: None, searched, leaves_another: false }
    }
}

/// Rounded to three significant digits, as it is printed.
pub(super) fn three_digits(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}
