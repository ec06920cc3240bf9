//! Another session that no column says: from some reading on the machine lies elsewhere against all
//! stations, or one station stands elsewhere.
//!
//! With free errors an axis that came to every angle once hides a machine that was moved: all that
//! shows is an angle that was met before and after.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use crate::count::count;

/// Readings of what is moved before and after it, at least: fewer are readings far off, or a reflector
/// that slipped.
const MIN_SIDE: usize = 8;
/// Stops of the axis before and after it, at least, of which successive readings at one step are one.
const MIN_STOPS: usize = 4;
/// Beginnings that are looked at first; then all about the clearest of these.
const TRIED: usize = 24;
/// Chance that a survey without another session shows one.
const FALSE_ALARM: f64 = 0.01;
/// The same below which its beginning is looked for nearer by.
const IN_SIGHT: f64 = 0.5;
/// Share of a column's length that must be left beside the model: rows are linear to no more.
const NOTHING_LEFT: f64 = 1e-3;

/// From when on what stands elsewhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Session {
    /// One station's stand; `None`: the machine against all stations.
    pub(crate) station: Option<usize>,
    /// The first reading of it.
    pub(crate) first: usize,
    /// How many beginnings were looked at to find it.
    pub(crate) searched: usize,
}

impl Session {
    /// Id, subject and text of its effect, by the names of station, reflector and step of its first
    /// reading.
    pub(crate) fn named(
        &self,
        [station, mount, step]: [&str; 3],
    ) -> (&'static str, String, String) {
        if self.station.is_some() {
            let text = format!(
                "station {station} stands elsewhere from its reading of {mount} at step {step} on; its \
                 place is printed as it was before"
            );
            return ("station-shift", format!("{station} from {mount} at {step} on"), text);
        }
        let from = format!("{station}-{mount} at {step}");
        let text = format!(
            "the axis, or what carries it, lies elsewhere against all stations from the reading of \
             {from} on: it was moved, or another session began; displacement and rotation of the \
             axis in the machine's frame"
        );
        ("session-shift", format!("from {from} on"), text)
    }

    /// One for every reading of it, else nought.
    pub(crate) fn share(&self, readings: &[Seen]) -> Vec<f64> {
        let begins = readings[self.first].time;
        let holds = |r: &Seen| r.time >= begins && self.station.is_none_or(|own| own == r.station);
        readings.iter().map(|reading| f64::from(u8::from(holds(reading)))).collect()
    }
}

/// By which station, at which step and when a reading was taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Seen {
    pub(crate) station: usize,
    pub(crate) step: usize,
    pub(crate) time: f64,
}

/// A residual in which sessions are looked for.
pub(crate) struct LookedThrough<'a> {
    pub(crate) readings: Vec<Seen>,
    /// Orthonormal basis of the fitted parameters' whitened columns, and the residual beside it.
    pub(crate) basis: &'a DMatrix<f64>,
    pub(crate) residual: &'a DVector<f64>,
}

/// Whitened rows of what a motion does that has come so far at every reading, and the length of each
/// column before anything was taken out of its rows.
pub(crate) type Rows<'a> = dyn Fn(Option<usize>, &[f64]) -> (DMatrix<f64>, Vec<f64>) + 'a;

/// The clearest session of the machine and of each station, where each takes more than a drift of the
/// same does and white noise beside this hardly ever shows one as clear.
pub(crate) fn sessions(
    fitted: &LookedThrough<'_>,
    of: impl Iterator<Item = Option<usize>>,
    rows: &Rows<'_>,
) -> Vec<Session> {
    of.filter_map(|station| clearest(fitted, station, rows)).collect()
}

/// What may stand elsewhere: the machine against all stations, and each station, of which one alone
/// moves as the machine does against it.
pub(crate) fn movable(n_stations: usize) -> impl Iterator<Item = Option<usize>> {
    let alone = (0..n_stations).filter(move |_| n_stations > 1).map(Some);
    std::iter::once(None).chain(alone)
}

fn clearest(
    fitted: &LookedThrough<'_>,
    station: Option<usize>,
    rows: &Rows<'_>,
) -> Option<Session> {
    let (begun, stops) = fitted.beginnings(station);
    let searched = begun.len();
    let session = |first: usize| Session { station, first, searched };
    let taken = |shares: &[Vec<f64>]| fitted.taken(station, shares, rows);
    let shift = |first: usize| session(first).share(&fitted.readings);
    let of = |at: usize| Some((taken(&[shift(begun[at])])?.0, at));
    let most_of = |tried: &mut dyn Iterator<Item = usize>| {
        tried.filter_map(of).max_by(|a, b| a.0.total_cmp(&b.0))
    };
    // First at stops of the axis: what begins amid one is shown by that one alone where its angle is met
    // once.
    let stride = stops.len().div_ceil(TRIED).max(1);
    let (coarse, about) = most_of(&mut stops.iter().copied().step_by(stride))?;
    let drift = fitted.drift(station);
    let (evenly, width) = taken(std::slice::from_ref(&drift)).unwrap_or((0.0, 0));
    let (_, shown) = taken(&[shift(begun[about])])?;
    if fitted.p_value([0.0, coarse], [0, shown]) * count(searched) > IN_SIGHT {
        return None;
    }
    let beside = |at: usize, by: usize| {
        let stop = stops.partition_point(|&stop| stop < at);
        (stops[stop.saturating_sub(by)], stops[(stop + by).min(stops.len() - 1)])
    };
    let (from, to) = beside(about, stride);
    let within = stops.iter().copied().filter(|stop| (from..=to).contains(stop));
    let (_, at_stop) = most_of(&mut within.into_iter())?;
    let (from, to) = beside(at_stop, 1);
    let (most, best) = most_of(&mut (from..=to))?;
    let (both, all) = taken(&[drift, shift(begun[best])])?;
    let p_value = fitted.p_value([evenly, both], [width, all]) * count(searched);
    (most > evenly && all > width && p_value <= FALSE_ALARM).then(|| session(begun[best]))
}

impl LookedThrough<'_> {
    /// First readings of every session that there may be, in the order of time, and which of these are the
    /// first at a stop of the axis.
    fn beginnings(&self, station: Option<usize>) -> (Vec<usize>, Vec<usize>) {
        let is_own = |r: &usize| station.is_none_or(|own| own == self.readings[*r].station);
        let mut own: Vec<usize> = (0..self.readings.len()).filter(is_own).collect();
        own.sort_by(|&a, &b| self.readings[a].time.total_cmp(&self.readings[b].time));
        let seen = |at: usize| &self.readings[own[at]];
        let is_stop = |at: usize| at == 0 || seen(at - 1).step != seen(at).step;
        let stops: Vec<usize> = (0..own.len()).filter(|&at| is_stop(at)).collect();
        let [Some(first), Some(last)] = [Some(MIN_STOPS), stops.len().checked_sub(MIN_STOPS)]
            .map(|stop| stop.and_then(|stop| stops.get(stop).copied()))
        else {
            return (Vec::new(), Vec::new());
        };
        let (first, last) = (first.max(MIN_SIDE), last.min(own.len().saturating_sub(MIN_SIDE)));
        let begun: Vec<usize> =
            (first..=last).filter(|&at| seen(at - 1).time < seen(at).time).collect();
        let at_stops = (0..begun.len()).filter(|&k| is_stop(begun[k])).collect();
        (begun.into_iter().map(|at| own[at]).collect(), at_stops)
    }

    /// Time since the first reading of what is moved.
    fn drift(&self, station: Option<usize>) -> Vec<f64> {
        let is_own = |r: &Seen| station.is_none_or(|own| own == r.station);
        let times = self.readings.iter().filter(|r| is_own(r)).map(|r| r.time);
        let first = times.fold(f64::INFINITY, f64::min);
        let since = |r: &Seen| if is_own(r) { r.time - first } else { 0.0 };
        self.readings.iter().map(since).collect()
    }

    /// What motions with these courses take together of the sum of squares, and the directions that
    /// they show; `None` where they show none.
    fn taken(
        &self,
        station: Option<usize>,
        shares: &[Vec<f64>],
        rows: &Rows<'_>,
    ) -> Option<(f64, usize)> {
        let mut shown: Vec<DVector<f64>> = Vec::new();
        for share in shares {
            let (tangent, whole) = rows(station, share);
            let left = &tangent - self.basis * self.basis.tr_mul(&tangent);
            for (column, whole) in left.column_iter().zip(&whole) {
                let mut rest = column.into_owned();
                // Twice: what is left may be a thousandth.
                for _ in 0..2 {
                    for known in &shown {
                        let along = known.dot(&rest);
                        rest.axpy(-along, known, 1.0);
                    }
                }
                let length = rest.norm();
                if length > NOTHING_LEFT * whole {
                    rest.unscale_mut(length);
                    shown.push(rest);
                }
            }
        }
        let taken = shown.iter().map(|way| way.dot(self.residual).powi(2)).sum();
        (!shown.is_empty()).then_some((taken, shown.len()))
    }

    /// That what is taken rises so by chance with so many parameters, from before to after.
    fn p_value(&self, taken: [f64; 2], parameters: [usize; 2]) -> f64 {
        let more = parameters[1].saturating_sub(parameters[0]);
        let fitted = self.basis.ncols() + parameters[1];
        let dof = self.residual.len().checked_sub(fitted).filter(|dof| *dof > 0 && more > 0);
        let Some(dof) = dof else { return 1.0 };
        let left = (self.residual.norm_squared() - taken[1]).max(f64::MIN_POSITIVE);
        let f = (taken[1] - taken[0]).max(0.0) / count(more) / (left / count(dof));
        FisherSnedecor::new(count(more), count(dof)).map_or(1.0, |law| law.sf(f))
    }
}
