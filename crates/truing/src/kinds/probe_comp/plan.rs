//! Touches that could be made next.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Point3, Unit, UnitVector3, Vector3};
use probe_comp::{NormalSource, ProbeError, Side};

use super::case::ProbeCase;
use super::settings::{TOUCHES, error};
use super::tables::{APPROACH, GUIDE, SPINDLE, XYZ};
use crate::Error;
use crate::case::Problem;
use crate::kinds::touching::{ACROSS, MOST_PLACES, Place, shuffled};
use crate::kinds::{Offer, Offered, PlannedTouch, undeclared};

/// Columns that hold the feed of a touch, and what makes mm/min of it.
const FEEDS: [(&str, f64); 2] = [("feed_mm_per_min", 1.0), ("feed_mm_per_s", 60.0)];
/// Azimuths from which an inclined touch comes.
const WAYS: u8 = 4;
/// Levels of a recorded column that a plan goes back to, at most.
const MOST_LEVELS: usize = 4;

/// What the touches that are planned have beside their places.
struct Levels {
    /// Column, values, and what makes mm/min of one.
    feed: Option<(&'static str, Vec<f64>, f64)>,
    spindle_deg: Option<Vec<f64>>,
    /// Whether a touch may come from beside the normal.
    oblique_rad: Option<f64>,
}

pub(super) fn offer(case: &ProbeCase) -> Result<Option<Offer>, Error> {
    if matches!(
        case.source,
        NormalSource::MicroPlane | NormalSource::Quadric | NormalSource::Profile
    ) {
        // Every planned touch would need touches of its own around it, or in its row.
        return Ok(None);
    }
    let (settings, touches, nominal) = (&case.plan, &case.touches, &case.surface.nominal);
    let mut places = Vec::with_capacity(touches.balls.len());
    for (index, ball) in touches.balls.iter().enumerate() {
        let foot = nominal
            .foot(&ball.center_mm)
            .map_err(|source| error(touches.file.clone(), ProbeError::NoFoot { index, source }))?;
        places.push(Place { contact_mm: foot.point_mm, normal: foot.normal });
    }
    let contacts: Vec<Point3<f64>> = places.iter().map(|place| place.contact_mm).collect();
    let foot = |at: &Point3<f64>| {
        let foot = nominal.foot(at).ok().filter(|foot| foot.inside_aperture)?;
        Some(Place { contact_mm: foot.point_mm, normal: foot.normal })
    };
    let Some(reachable) = settings.places(&contacts, ACROSS, foot) else {
        let message = format!("[plan] makes more than {MOST_PLACES} places; widen `spacing_mm`");
        return Err(Error::case(case.document.clone(), Problem::WrongValue { message }));
    };
    let levels = Levels::of(case);
    let columns = new_columns(case, &levels, &places);
    let offered: Vec<Offered> = shuffled(&all(case, &levels, &reachable));
    let balls = offered.iter().filter_map(|o| o.touch).map(|touch| touch.ball_mm.z);
    let highest = balls.chain(touches.balls.iter().map(|b| b.center_mm.z)).fold(f64::MIN, f64::max);
    // From below, a height over everything is no safe one.
    let from_above = nominal.side() == Side::Along || reachable.iter().all(|p| p.normal.z >= 0.0);
    Ok(Some(Offer {
        table: TOUCHES,
        readings: XYZ.to_vec(),
        columns,
        offered,
        noun: "touch",
        is_record: false,
        is_new_session: false,
        controls: Vec::new(),
        undeclared: [settings.undeclared(), undeclared_ways(case, &levels)].concat(),
        made: None,
        minutes: settings.minutes(),
        reach: from_above.then(|| settings.reach(highest)),
    }))
}

impl Levels {
    fn of(case: &ProbeCase) -> Self {
        let (settings, touches) = (&case.plan, &case.touches);
        let recorded = FEEDS.iter().find_map(|&(name, factor)| {
            let column = touches.covariates.iter().find(|c| c.name == name)?;
            let of_declared = |feeds: Vec<f64>| feeds.iter().map(|feed| feed / factor).collect();
            let values = settings.feeds().map_or_else(|| distinct(&column.values), of_declared);
            Some((name, values, factor))
        });
        let newly = || {
            let feeds = settings.feeds().filter(|_| settings.measured_feed().is_some())?;
            let (name, factor) = FEEDS[0];
            Some((name, feeds, factor))
        };
        let turned: Vec<f64> = touches.balls.iter().map(|b| b.spindle_rad.to_degrees()).collect();
        let spindle = || Some(distinct(&turned)).filter(|turns| turns.len() > 1);
        Self {
            feed: recorded.or_else(newly),
            spindle_deg: settings.spindle_deg().or_else(spindle),
            oblique_rad: settings.oblique_rad(),
        }
    }
}

/// Keys of `[plan]` that are not declared and would offer touches in more ways.
fn undeclared_ways(case: &ProbeCase, levels: &Levels) -> Vec<&'static str> {
    let settings = &case.plan;
    let has_recorded = case.touches.covariates.iter().any(|c| FEEDS.iter().any(|f| f.0 == c.name));
    undeclared(&[
        ("feeds_mm_per_min", settings.feeds().is_some()),
        ("measured_feed_mm_per_min", has_recorded || settings.measured_feed().is_some()),
        ("spindle_deg", levels.spindle_deg.is_some()),
    ])
}

/// Values of a column, each once; the outermost and some between where there are many.
fn distinct(values: &[f64]) -> Vec<f64> {
    let mut all = values.to_vec();
    all.sort_by(f64::total_cmp);
    all.dedup();
    let last = all.len().saturating_sub(1);
    if last < MOST_LEVELS {
        return all;
    }
    (0..MOST_LEVELS).map(|i| all[i * last / (MOST_LEVELS - 1)]).collect()
}

/// Columns that the plan needs and the table lacks, with what held for the touches measured.
fn new_columns(case: &ProbeCase, levels: &Levels, places: &[Place]) -> Vec<(String, Vec<String>)> {
    let mut columns = Vec::new();
    let touches = &case.touches;
    if levels.oblique_rad.is_some() && !touches.have_approach {
        for (axis, name) in APPROACH.iter().enumerate() {
            let along = places.iter().map(|place| decimals(-place.normal[axis])).collect();
            columns.push(((*name).to_owned(), along));
        }
    }
    if let (Some((name, _, _)), Some(feed)) = (&levels.feed, case.plan.measured_feed())
        && touches.covariates.iter().all(|c| c.name != *name)
    {
        columns.push(((*name).to_owned(), vec![decimals(feed); places.len()]));
    }
    if levels.spindle_deg.is_some() && !touches.have_spindle {
        columns.push((SPINDLE.to_owned(), vec![decimals(0.0); places.len()]));
    }
    columns
}

/// Every place from every way; feeds and turns of the spindle take turns over them.
fn all(case: &ProbeCase, levels: &Levels, places: &[Place]) -> Vec<Offered> {
    let ways = if levels.oblique_rad.is_some() { 1 + WAYS } else { 1 };
    let mut offered = Vec::new();
    for place in places {
        for way in 0..ways {
            let approach = approach(&place.normal, way, levels.oblique_rad);
            let turn = offered.len();
            let of = |values: &[f64]| values.get(turn % values.len().max(1)).copied();
            let feed = levels.feed.as_ref().and_then(|(_, values, _)| of(values));
            // The next level after every round of the feeds.
            let rounds = levels.feed.as_ref().map_or(1, |(_, values, _)| values.len().max(1));
            let spindle_deg = levels
                .spindle_deg
                .as_deref()
                .and_then(|turns| turns.get(turn / rounds % turns.len().max(1)).copied());
            let factor = levels.feed.as_ref().map_or(1.0, |(_, _, factor)| *factor);
            let touch = PlannedTouch {
                contact_mm: place.contact_mm,
                normal: place.normal,
                ball_mm: place.contact_mm + place.normal.into_inner() * case.tip_radius_mm,
                approach,
                feed_mm_per_min: feed.map_or_else(|| case.plan.feed(), |feed| feed * factor),
                spindle_deg,
            };
            let cells = cells(case, levels, &touch, feed);
            offered.push(Offered { touch: Some(touch), ..Offered::of_row("touch", cells) });
        }
    }
    offered
}

/// Along the normal, or beside it from one of the ways round it.
fn approach(normal: &UnitVector3<f64>, way: u8, oblique_rad: Option<f64>) -> UnitVector3<f64> {
    let (Some(angle), Some(way)) = (oblique_rad, way.checked_sub(1)) else { return -*normal };
    let helper = Vector3::ith(normal.iamin(), 1.0);
    let first = normal.cross(&helper).normalize();
    let second = normal.cross(&first);
    let (sin, cos) = (FRAC_PI_2 * f64::from(way)).sin_cos();
    let sideways = first * cos + second * sin;
    Unit::new_normalize(sideways * angle.sin() - normal.into_inner() * angle.cos())
}

fn cells(
    case: &ProbeCase,
    levels: &Levels,
    touch: &PlannedTouch,
    feed: Option<f64>,
) -> Vec<(&'static str, String)> {
    let mut cells = Vec::new();
    for (axis, name) in XYZ.into_iter().enumerate() {
        cells.push((name, decimals(touch.ball_mm[axis])));
    }
    if case.touches.have_approach || levels.oblique_rad.is_some() {
        for (axis, name) in APPROACH.into_iter().enumerate() {
            cells.push((name, decimals(touch.approach[axis])));
        }
    }
    if case.touches.balls.iter().any(|ball| ball.guide_mm.is_some()) {
        for (axis, name) in GUIDE.into_iter().enumerate() {
            cells.push((name, decimals(touch.ball_mm[axis])));
        }
    }
    if let (Some((name, _, _)), Some(feed)) = (&levels.feed, feed) {
        cells.push((name, decimals(feed)));
    }
    if let Some(turn) = touch.spindle_deg {
        cells.push((SPINDLE, decimals(turn)));
    }
    cells
}

/// A nanometre, and a millionth of a direction.
fn decimals(value: f64) -> String {
    format!("{value:.6}")
}
