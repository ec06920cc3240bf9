//! Another session that no column says: from some reading on the machine lies elsewhere against all
//! stations, or one station stands elsewhere.
//!
//! With free errors an axis that came to every angle once hides a machine that was moved: all that
//! shows is an angle that was met before and after.

use crate::count::count;
use crate::missing::course::{self, Course};
use crate::missing::looked_through::{LookedThrough, Moving, Seen};

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

    pub(crate) fn moving(&self) -> Moving {
        moving(self.station)
    }

    /// One for every reading of it, else nought.
    pub(crate) fn share(&self, readings: &[Seen]) -> Vec<f64> {
        let begins = readings[self.first].time;
        let holds = |r: &Seen| r.time >= begins && self.station.is_none_or(|own| own == r.station);
        readings.iter().map(|reading| f64::from(u8::from(holds(reading)))).collect()
    }
}

fn moving(station: Option<usize>) -> Moving {
    if station.is_some() { Moving::Stations } else { Moving::Machine }
}

/// The clearest session of the machine and of each station, where each takes more than a drift of the
/// same does, of a station along its course, and white noise beside this hardly ever shows one as
/// clear.
pub(crate) fn sessions(
    through: &LookedThrough<'_>,
    of: impl Iterator<Item = Option<usize>>,
    courses: &[Course],
) -> Vec<Session> {
    of.filter_map(|station| clearest(through, station, courses)).collect()
}

/// What may stand elsewhere: the machine against all stations, and each station, of which one alone
/// moves as the machine does against it.
pub(crate) fn movable(n_stations: usize) -> impl Iterator<Item = Option<usize>> {
    let alone = (0..n_stations).filter(move |_| n_stations > 1).map(Some);
    std::iter::once(None).chain(alone)
}

fn clearest(
    through: &LookedThrough<'_>,
    station: Option<usize>,
    courses: &[Course],
) -> Option<Session> {
    let (begun, stops) = beginnings(through.readings, station);
    let searched = begun.len();
    let session = |first: usize| Session { station, first, searched };
    let taken = |shares: &[Vec<f64>]| through.taken(moving(station), shares);
    let shift = |first: usize| session(first).share(through.readings);
    let of = |at: usize| Some((taken(&[shift(begun[at])])?.0, at));
    let most_of = |tried: &mut dyn Iterator<Item = usize>| {
        tried.filter_map(of).max_by(|a, b| a.0.total_cmp(&b.0))
    };
    // First at stops of the axis: what begins amid one is shown by that one alone where its angle is met
    // once.
    let stride = stops.len().div_ceil(TRIED).max(1);
    let (coarse, about) = most_of(&mut stops.iter().copied().step_by(stride))?;
    let drift = match station {
        Some(station) => course::of_station(through.readings, station, &courses[station]),
        None => course::of_machine(through.readings),
    };
    let (evenly, width) = taken(std::slice::from_ref(&drift)).unwrap_or((0.0, 0));
    let (_, shown) = taken(&[shift(begun[about])])?;
    if through.p_value([0.0, coarse], [0, shown]) * count(searched) > IN_SIGHT {
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
    let p_value = through.p_value([evenly, both], [width, all]) * count(searched);
    (most > evenly && all > width && p_value <= FALSE_ALARM).then(|| session(begun[best]))
}

/// First readings of every session that there may be, in the order of time, and which of these are the
/// first at a stop of the axis.
fn beginnings(readings: &[Seen], station: Option<usize>) -> (Vec<usize>, Vec<usize>) {
    let is_own = |r: &usize| station.is_none_or(|own| own == readings[*r].station);
    let mut own: Vec<usize> = (0..readings.len()).filter(is_own).collect();
    own.sort_by(|&a, &b| readings[a].time.total_cmp(&readings[b].time));
    let seen = |at: usize| &readings[own[at]];
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
