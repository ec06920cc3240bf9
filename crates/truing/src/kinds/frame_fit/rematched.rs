//! Points that stand in rows of others.

use frame_fit::{FrameMap, Options, PointPair, fit_frame};
use nalgebra::Point;

use super::settings::{FROM, PAIRS, TO};
use crate::case::{Change, Edit, Order, Table};
use crate::count::count;
use crate::measured::{Fitted, Observation};
use crate::suspect::{Hypothesis, Proof, stretches_of};

/// Points that a map is tried on, and how far apart they are in the table at most: rows that were not touched
/// stand together, or a few rows apart.
const TRIED: usize = 4;
const APART: usize = 8;
/// Points of a table in which this is looked for: fewer say nothing, of more every pair costs time.
const FEWEST_POINTS: usize = 8;
const MOST_POINTS: usize = 2000;
/// Share of the smallest distance between two points within which a mapped point is one of them.
const NEAR: f64 = 0.25;
/// Share of the rows that a map must take onto their own points, and onto any.
const IN_PLACE: f64 = 0.25;
const ANYWHERE: f64 = 0.9;

/// The points of one side in the order of those of the other, where a map that takes a good part of them onto
/// their own points takes the others onto points of other rows.
pub(super) fn rematched(table: &Table, fitted: &Fitted) -> Option<Hypothesis> {
    let side = |names: [&str; 3]| names.map(|name| table.numbers(name));
    match (side(FROM), side(TO)) {
        ([Some(x), Some(y), Some(z)], [Some(u), Some(v), Some(w)]) => {
            of_points((table, fitted), &points(&[x, y, z]), &points(&[u, v, w]))
        }
        ([Some(x), Some(y), None], [Some(u), Some(v), None]) => {
            of_points((table, fitted), &points(&[x, y]), &points(&[u, v]))
        }
        _ => None,
    }
}

fn points<const D: usize>(axes: &[Vec<f64>; D]) -> Vec<Point<f64, D>> {
    let point = |row: usize| Point::from(std::array::from_fn::<f64, D, _>(|axis| axes[axis][row]));
    (0..axes[0].len()).map(point).collect()
}

fn of_points<const D: usize>(
    (table, fitted): (&Table, &Fitted),
    from: &[Point<f64, D>],
    to: &[Point<f64, D>],
) -> Option<Hypothesis> {
    let n = from.len();
    if !(FEWEST_POINTS..=MOST_POINTS).contains(&n) {
        return None;
    }
    let near = NEAR * smallest_distance(to);
    let is_off = |o: &Observation| o.residual.iter().map(|v| v * v).sum::<f64>() > near * near;
    if !fitted.observations.iter().any(is_off) {
        return None;
    }
    let own = |map: &FrameMap<D>| -> Vec<usize> {
        (0..n).filter(|&i| (map.apply(&from[i]) - to[i]).norm() < near).collect()
    };
    let map_of = |rows: &[usize]| {
        let pair = |&i: &usize| PointPair::isotropic(from[i], to[i], near);
        let pairs: Vec<PointPair<D>> = rows.iter().map(pair).collect();
        fit_frame(&pairs, &Options::default()).ok().map(|fit| fit.target_from_source)
    };
    let tried = (1..=APART).flat_map(|step| {
        (0..n.saturating_sub(step * (TRIED - 1)))
            .map(move |start| (0..TRIED).map(|i| start + i * step).collect::<Vec<usize>>())
    });
    let in_place = tried.filter_map(|rows| Some(own(&map_of(&rows)?)));
    let in_place = in_place.max_by_key(Vec::len)?;
    let least = |share: f64| (share * count(n)).ceil();
    if count(in_place.len()) < least(IN_PLACE) || in_place.len() == n {
        return None;
    }
    let map = map_of(&in_place)?;
    let nearest = |i: usize| {
        let mapped = map.apply(&from[i]);
        (0..n).find(|&j| (mapped - to[j]).norm() < near)
    };
    let order: Vec<Option<usize>> = (0..n).map(nearest).collect();
    let mut taken: Vec<usize> = order.iter().flatten().copied().collect();
    let found = taken.len();
    taken.sort_unstable();
    taken.dedup();
    if taken.len() < found || count(found) < least(ANYWHERE) {
        return None;
    }
    let moved: Vec<usize> = (0..n).filter(|&i| order[i].is_some_and(|j| j != i)).collect();
    let first = *moved.first()?;
    let lines: Vec<usize> = moved.iter().map(|&i| table.line(i)).collect();
    let description = format!(
        "{} points of {PAIRS} stand in rows of others (labels or rows exchanged, shifted or in another order; \
         lines {}): the point of line {} has its {} in line {}; put them in one order",
        moved.len(),
        stretches_of(&lines),
        lines[0],
        TO[..D].join(", "),
        table.line(order[first]?)
    );
    let kept: Vec<usize> = (0..n).filter(|&i| order[i].is_some()).collect();
    let order = Order::Listed((0..n).map(|i| order[i].unwrap_or(i)).collect());
    let columns = TO[..D].iter().map(|name| (*name).to_owned()).collect();
    let mut edits = vec![Edit { file: PAIRS, change: Change::Rows { columns, order } }];
    if kept.len() < n {
        edits.push(Edit { file: PAIRS, change: Change::Keep { rows: kept } });
    }
    let found = Hypothesis::of("input:labels", (PAIRS, &TO[..D]), description, edits);
    Some(Hypothesis { proof: Proof::FitIfNoOther, ..found })
}

fn smallest_distance<const D: usize>(points: &[Point<f64, D>]) -> f64 {
    let of = |i: usize| {
        points[..i].iter().map(|other| (points[i] - other).norm()).fold(f64::INFINITY, f64::min)
    };
    (0..points.len()).map(of).fold(f64::INFINITY, f64::min)
}
