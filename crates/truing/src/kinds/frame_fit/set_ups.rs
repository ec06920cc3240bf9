//! Labels of poses and places of set-ups that are not what the tables say.

use std::collections::BTreeSet;

use frame_fit::{Mislabelled, TipPose, mislabelled};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::estimates::FrameFitEstimates;
use super::settings::{COORDINATES as POSITION, FROM, KNOWN, PAIRS, POSES, TO};
use crate::case::{Change, Edit, Order, SESSION, Table};
use crate::kind::Files;
use crate::kinds::orientation::QUATERNION;
use crate::measured::Fitted;
use crate::suspect::{Hypothesis, Label, labelled, stretches_of};

/// Logarithm of the likelihood ratio that a moved group of points must reach, as for any mistake:
/// odds of 1 to 10¹³, which two or three components of a shift do not spend.
const MISPLACED_EVIDENCE: f64 = 30.0;

/// Rows that carry the name of another place than the one where their tip is.
///
/// Single rows of which some carry each other's name are left to the exchanges and shifts of rows, which have no
/// choice of their own.
pub(super) fn relabelled(table: &Table) -> Option<Hypothesis> {
    let column = table.column("place")?;
    let [x, y, z] = POSITION.map(|name| table.numbers(name));
    let [w, i, j, k] = QUATERNION.map(|name| table.numbers(name));
    let (x, y, z, w, i, j, k) = (x?, y?, z?, w?, i?, j?, k?);
    let poses: Vec<TipPose> = (0..table.n_rows())
        .map(|row| TipPose {
            place: table.cell(row, column).to_owned(),
            position_mm: Vector3::new(x[row], y[row], z[row]),
            rotation: UnitQuaternion::from_quaternion(Quaternion::new(
                w[row], i[row], j[row], k[row],
            )),
        })
        .collect();
    let wrong = mislabelled(&poses).ok()?;
    let follows = |pair: &[Mislabelled]| pair[1].pose == pair[0].pose + 1;
    let names = |one: &Mislabelled| [one.pose, one.like].map(|row| table.cell(row, column));
    let is_each_others = |one: &Mislabelled| {
        let [named, own] = names(one);
        wrong.iter().any(|other| names(other) == [own, named])
    };
    if wrong.is_empty() || !wrong.windows(2).any(follows) && wrong.iter().any(is_each_others) {
        return None;
    }
    let mut order: Vec<usize> = (0..table.n_rows()).collect();
    for one in &wrong {
        order[one.pose] = one.like;
    }
    let lines: Vec<usize> = wrong.iter().map(|one| table.line(one.pose)).collect();
    let own: BTreeSet<&str> = wrong.iter().map(|one| table.cell(one.like, column)).collect();
    let named: BTreeSet<&str> = wrong.iter().map(|one| table.cell(one.pose, column)).collect();
    let listed = |names: BTreeSet<&str>| {
        names.into_iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
    };
    let farthest = wrong.iter().map(|one| one.from_own_mm).fold(0.0, f64::max);
    let nearest = wrong.iter().map(|one| one.from_named_mm).fold(f64::INFINITY, f64::min);
    let description = format!(
        "{} rows of {POSES} (lines {}) carry the label {} in `place`, but hold the tip at {} \
         (within {farthest:.1} mm; {nearest:.1} mm and more from the place they name): correct \
         their labels",
        wrong.len(),
        stretches_of(&lines),
        listed(named),
        listed(own)
    );
    let order = Order::Listed(order);
    let change = Change::Rows { columns: vec!["place".to_owned()], order };
    let edits = vec![Edit { file: POSES, change }];
    Some(Hypothesis::of("input:labels", (POSES, &["place"]), description, edits))
}

/// All points of one label at another place than the table says: a set-up or a fixture that stood
/// elsewhere.
pub(super) fn misplaced(files: &Files, table: &Table, fitted: &Fitted) -> Vec<Hypothesis> {
    let square = |r: &[f64]| r.iter().map(|v| v * v).sum::<f64>();
    let sides: Vec<Vec<f64>> = FROM.iter().filter_map(|name| table.numbers(name)).collect();
    let to: Vec<Vec<f64>> = TO.iter().filter_map(|name| table.numbers(name)).collect();
    let (d, n) = (sides.len(), table.n_rows());
    if d < 2 || to.len() != d || fitted.observations.len() != n {
        return Vec::new();
    }
    let before: f64 = fitted.observations.iter().map(|o| square(&o.residual)).sum();
    let mut all = Vec::new();
    for Label { column: label, name, rows } in labelled(table, &[KNOWN, &[SESSION]].concat()) {
        let rest: Vec<usize> = (0..n).filter(|row| !rows.contains(row)).collect();
        let edits = [Edit { file: PAIRS, change: Change::Keep { rows: rest } }];
        let without = files.with(&edits).read().ok().and_then(|r| r.measured.fit().ok());
        let found = without.as_ref().and_then(|f| f.estimates.downcast_ref::<FrameFitEstimates>());
        let Some(found) = found else {
            continue;
        };
        let miss = |row: usize, axis: usize| {
            let from = (0..d).map(|k| found.matrix[axis][k] * sides[k][row]).sum::<f64>();
            to[axis][row] - from - found.matrix[axis][d]
        };
        let shift: Vec<f64> = (0..d)
            .map(|axis| rows.iter().map(|&row| miss(row, axis)).sum::<f64>() / ratio(rows.len()))
            .collect();
        let left: f64 = (without.iter().flat_map(|f| &f.observations))
            .map(|o| square(&o.residual))
            .chain(rows.iter().map(|&row| {
                square(&(0..d).map(|axis| miss(row, axis) - shift[axis]).collect::<Vec<_>>())
            }))
            .sum();
        // As many equations less as the shift has components.
        let freedom = fitted.degrees_of_freedom.saturating_sub(d);
        if left <= 0.0 || 0.5 * ratio(freedom) * (before / left).ln() < MISPLACED_EVIDENCE {
            continue;
        }
        let linear = nalgebra::DMatrix::from_fn(d, d, |i, j| found.matrix[i][j]);
        let Some(back) = linear.lu().solve(&nalgebra::DVector::from_vec(shift)) else { continue };
        let edits = (0..d)
            .map(|axis| {
                let mut values = sides[axis].clone();
                for &row in &rows {
                    values[row] += back[axis];
                }
                let column = FROM[axis].to_owned();
                Edit { file: PAIRS, change: Change::Replace { column, values } }
            })
            .collect();
        let apart: Vec<String> = back.iter().map(|v| format!("{v:.3}")).collect();
        let description = format!(
            "the {} points of {PAIRS} with `{label}` = `{name}` all lie ({}) mm, {:.2} mm in all, from \
             where {} say: they were set up elsewhere than noted; correct the note, or measure again",
            rows.len(),
            apart.join(", "),
            back.norm(),
            FROM[..d].iter().map(|c| format!("`{c}`")).collect::<Vec<_>>().join(", ")
        );
        let mut found = Hypothesis::of("input:misplaced", (PAIRS, &FROM[..d]), description, edits);
        found.subject = format!("{PAIRS}: {label} {name}");
        all.push(found);
    }
    all
}

fn ratio(n: usize) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let n = n as f64;
    n
}
