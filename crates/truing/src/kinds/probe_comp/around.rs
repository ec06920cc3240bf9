//! Further touches around a touch, under the name of another.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Vector3;

use super::settings::{MICRO, TOUCHES};
use crate::case::{Change, Edit, Table};
use crate::count::count;
use crate::kind::Files;
use crate::kinds::surface::XYZ;
use crate::suspect::Hypothesis;

/// Distances of the farthest of the further touches from their middle beyond which the touch that they name lies
/// outside of them, and within which the one lies that they are of.
const OUTSIDE: f64 = 4.0;
const INSIDE: f64 = 1.0;

/// The further touches of one name.
struct Ring<'t> {
    touch: &'t str,
    rows: Vec<usize>,
    middle_mm: Vector3<f64>,
    reach_mm: f64,
}

/// The names of those that lie about other touches than they name, each about one: a shift, or some in another order.
///
/// Whatever the fit says, as a small plane has nearly the same normal elsewhere.
pub(super) fn around_others(files: &Files) -> Option<Hypothesis> {
    let columns = ["touch", XYZ[0], XYZ[1], XYZ[2]];
    let touches = files.folder.table(TOUCHES, &columns).ok()?;
    let micro = files.folder.table(MICRO, &columns).ok()?;
    let name = touches.column("touch")?;
    let places_mm = places(&touches)?;
    let far = |ring: &Ring<'_>, row: usize| (places_mm[row] - ring.middle_mm).norm();
    let mut other_names: BTreeMap<&str, &str> = BTreeMap::new();
    let (mut rows, mut any_outside) = (Vec::new(), false);
    for ring in rings(&micro)? {
        let all = 0..touches.n_rows();
        let own = all.clone().find(|&row| touches.cell(row, name) == ring.touch)?;
        let is_near = |times: f64, row: usize| far(&ring, row) <= times * ring.reach_mm;
        if is_near(INSIDE, own) {
            continue;
        }
        // That which it names may be the next to the one that it is of.
        let nearest = all.min_by(|&a, &b| far(&ring, a).total_cmp(&far(&ring, b)));
        let of_it = match nearest.filter(|&row| is_near(INSIDE, row)) {
            None if is_near(OUTSIDE, own) => continue,
            found => found?,
        };
        any_outside |= !is_near(OUTSIDE, own);
        other_names.insert(ring.touch, touches.cell(of_it, name));
        rows.extend(ring.rows);
    }
    let of_others: BTreeSet<&str> = other_names.values().copied().collect();
    let is_another_order = of_others == other_names.keys().copied().collect();
    let (first, other) =
        other_names.first_key_value().filter(|_| is_another_order && any_outside)?;
    let description = format!(
        "the further touches of {} names in {MICRO} lie about other touches, those of `{first}` about \
         `{other}`: `touch` should name these",
        other_names.len()
    );
    rows.sort_unstable();
    let names = other_names.iter().map(|(from, to)| [(*from).to_owned(), (*to).to_owned()]);
    let names = names.collect();
    let change = Change::Rename { column: "touch".to_owned(), rows: Some(rows), names };
    let edits = vec![Edit { file: MICRO, change }];
    Some(Hypothesis::of("input:labels", (MICRO, &["touch"]), description, edits).certain())
}

/// Those of every name.
fn rings(micro: &Table) -> Option<Vec<Ring<'_>>> {
    let name = micro.column("touch")?;
    let places_mm = places(micro)?;
    let mut of_names: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for row in 0..micro.n_rows() {
        of_names.entry(micro.cell(row, name)).or_default().push(row);
    }
    let ring = |(touch, rows): (_, Vec<usize>)| {
        let middle_mm = rows.iter().map(|&row| places_mm[row]).sum::<Vector3<f64>>();
        let middle_mm = middle_mm / count(rows.len());
        let reach_mm = rows.iter().map(|&row| (places_mm[row] - middle_mm).norm());
        let reach_mm = reach_mm.fold(0.0, f64::max);
        Ring { touch, rows, middle_mm, reach_mm }
    };
    Some(of_names.into_iter().map(ring).collect())
}

fn places(table: &Table) -> Option<Vec<Vector3<f64>>> {
    let [x, y, z] = XYZ.map(|name| table.numbers(name));
    let (x, y, z) = (x?, y?, z?);
    Some((0..x.len()).map(|row| Vector3::new(x[row], y[row], z[row])).collect())
}
