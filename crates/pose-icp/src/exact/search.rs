//! Gauss-Newton steps, Newton's where those do not do, under Levenberg-Marquardt damping.

use geometry::{Foot, GeometryError};

use super::chart::Chart;
use super::rows::{Equations, Linearised};
use crate::Touch;

/// Rounds before giving up; five to ten are needed, the worst of 10 000 starts took some thirty.
const MAX_ROUNDS: usize = 60;
/// The estimate is within 1e-6 of a standard uncertainty of the minimum.
const COST_TOLERANCE: f64 = 1e-12;
/// Roundings that a distance is made of.
const ROUNDINGS: f64 = 8.0;
/// Gauss-Newton that gains less than a digit of the gradient a step is helped by Newton.
const SLOW: f64 = 1e-2;
/// Steps during which Gauss-Newton may be slow: the way in from a bad start.
const WAY_IN: usize = 2;
/// Damping after the first refused step, relative to the squared lengths of the columns.
const FIRST_DAMPING: f64 = 1e-3;
/// Damping under which the longest step left is a billionth of Gauss-Newton's.
const NOTHING_MOVES: f64 = 1e9;
const HARDER: f64 = 10.0;
const EASIER: f64 = 0.03;

/// Why a search ended without a minimum.
#[derive(Clone, Debug)]
pub(crate) enum Failed {
    /// A touch has no foot where the search starts.
    NoFoot(usize, GeometryError),
    /// Out of rounds.
    OutOfRounds(Box<Found>),
}

/// Where a search ended.
#[derive(Clone, Debug)]
pub(crate) struct Found {
    pub(crate) at: Chart,
    pub(crate) linearised: Linearised,
    /// Closest points of the touches, by the search's wider aperture.
    pub(crate) feet: Vec<Foot>,
    /// Steps accepted.
    pub(crate) iterations: usize,
    /// Poses at which the equations were evaluated.
    pub(crate) evaluations: usize,
}

/// Minimises the cost from `start`; allocates room for the feet once.
pub(crate) fn search(equations: &Equations<'_>, start: Chart) -> Result<Found, Failed> {
    let mut feet = Vec::with_capacity(equations.touches.len());
    let mut room = Vec::with_capacity(equations.touches.len());
    let no_foot = |(index, source)| Failed::NoFoot(index, source);
    let linearised = equations.linearise(&start, &mut feet).map_err(no_foot)?;
    let mut found = Found { at: start, linearised, feet, iterations: 0, evaluations: 1 };
    let round_off = round_off(equations);
    let (mut damping, mut newton) = (0.0, false);
    let mut promised = found.linearised.triangle.predicted();
    for _ in 0..MAX_ROUNDS {
        let cost = found.linearised.cost;
        if promised <= COST_TOLERANCE * cost || promised <= 0.5 * round_off * round_off {
            return Ok(found);
        }
        // Rounding adds to the length of the residual.
        let ceiling = 0.5 * ((2.0 * cost).sqrt() + round_off).powi(2);
        if round(equations, &mut found, &mut room, [damping, ceiling], newton) {
            found.iterations += 1;
            let before = promised;
            promised = found.linearised.triangle.predicted();
            newton |= found.iterations > WAY_IN && promised > SLOW * before;
            damping = if damping > FIRST_DAMPING { damping * EASIER } else { 0.0 };
        } else if damping > NOTHING_MOVES && equations.part.has_edges() {
            // On the edge between two faces of a mesh every step goes uphill.
            return Ok(found);
        } else {
            newton = true;
            damping = if damping == 0.0 { FIRST_DAMPING } else { damping * HARDER };
        }
    }
    Err(Failed::OutOfRounds(Box::new(found)))
}

/// Takes the first step that does not raise the cost above the ceiling; false if there is none.
fn round(
    equations: &Equations<'_>,
    found: &mut Found,
    room: &mut Vec<Foot>,
    [damping, ceiling]: [f64; 2],
    newton: bool,
) -> bool {
    let triangle = found.linearised.triangle;
    let exact = newton
        .then(|| {
            let second = equations.second_order(&found.at, &found.feet);
            dampings(damping).find_map(|damping| triangle.newton(&second, damping))
        })
        .flatten();
    for step in exact.into_iter().chain([triangle.step(damping)]) {
        let trial = found.at.stepped(equations.free.as_slice(), &step);
        found.evaluations += 1;
        let linearised = equations.linearise(&trial, room).ok().filter(|l| l.cost <= ceiling);
        if let Some(linearised) = linearised {
            found.at = trial;
            found.linearised = linearised;
            std::mem::swap(&mut found.feet, room);
            return true;
        }
    }
    false
}

/// The damping asked for, and greater ones up to those under which nothing moves.
fn dampings(asked: f64) -> impl Iterator<Item = f64> {
    let harder = |last: &f64| Some(FIRST_DAMPING.max(last * HARDER));
    std::iter::successors(Some(asked), harder).take_while(|damping| *damping < NOTHING_MOVES)
}

/// Length, in whitened units, of what rounding does to the residual.
fn round_off(equations: &Equations<'_>) -> f64 {
    let of = |t: &Touch| ROUNDINGS * f64::EPSILON * (1.0 + t.center_mm.coords.amax()) / t.sigma_mm;
    equations.touches.iter().map(|t| of(t).powi(2)).sum::<f64>().sqrt()
}
