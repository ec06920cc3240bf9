//! Folds left out of a system, once for all candidates beside it.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::algebra::basis::Basis;
use crate::algebra::product::{gram, tr_times};
use crate::noise::linear::Linear;
use crate::tests::hold_out::{HeldOut, MIN_LEFT, errors_of, predict};

/// A system's rows of every fold.
pub(crate) struct LeftOut {
    /// Directions of the system.
    directions: usize,
    folds: Vec<Fold>,
}

struct Fold {
    clusters: Vec<usize>,
    rows: Vec<usize>,
    system: DMatrix<f64>,
    /// Factor of what the other folds hold of the system's directions; `None` where too little.
    rest: Option<Cholesky<f64, Dyn>>,
}

impl LeftOut {
    /// Clusters for which `skip` is true stay in the fit and are not judged.
    pub(crate) fn of(lin: &Linear<'_>, folds: &[usize], skip: &[bool]) -> Self {
        let directions = lin.basis.dim();
        let fold = |fold: usize| {
            let is_member = |c: &usize| folds[*c] == fold && !skip[*c];
            let clusters: Vec<usize> = (0..folds.len()).filter(is_member).collect();
            let rows: Vec<usize> =
                clusters.iter().flat_map(|&c| lin.clusters[c].iter().copied()).collect();
            let system = lin.basis.rows(&rows);
            let rest = DMatrix::identity(directions, directions) - gram(&system);
            Fold { clusters, rows, system, rest: determined(rest) }
        };
        let n = folds.iter().max().map_or(0, |&f| f + 1);
        Self { directions, folds: (0..n).map(fold).collect() }
    }

    /// Error of each cluster when left out of the fit with the span of `full`, which begins with the
    /// system's columns.
    pub(crate) fn errors(&self, lin: &Linear<'_>, full: &Basis) -> HeldOut {
        let residual = full.reject(&lin.residual);
        let mut held_out = vec![None; lin.clusters.len()];
        for fold in &self.folds {
            if let Some(predicted) = fold.predict(full, self.directions, &residual) {
                errors_of(lin, &fold.clusters, &predicted, &mut held_out);
            }
        }
        held_out
    }
}

impl Fold {
    /// As [`predict`], by the factor of the system where there are more rows than columns.
    fn predict(
        &self,
        full: &Basis,
        directions: usize,
        residual: &DVector<f64>,
    ) -> Option<DVector<f64>> {
        if self.rows.len() <= full.dim() {
            return predict(full, residual, &self.rows);
        }
        let rest = self.rest.as_ref()?;
        let own = residual.select_rows(&self.rows);
        let more = full.rows_from(directions, &self.rows);
        // Of (I − HᵀH)·z = Hᵀe, with the columns of the system first.
        let across = tr_times(&self.system, &more);
        let of_across = rest.solve(&across);
        let m = more.ncols();
        let left = DMatrix::identity(m, m) - gram(&more) - across.tr_mul(&of_across);
        let left = determined(left)?;
        let of_system = rest.solve(&self.system.tr_mul(&own));
        let along_more = left.solve(&(more.tr_mul(&own) + across.tr_mul(&of_system)));
        let along_system = of_system + of_across * &along_more;
        Some(own + &self.system * along_system + more * along_more)
    }
}

/// The factor, unless a direction is left hardly anything of.
fn determined(left: DMatrix<f64>) -> Option<Cholesky<f64, Dyn>> {
    let factor = left.cholesky()?;
    let is_left = factor.l_dirty().diagonal().iter().all(|d| d * d >= MIN_LEFT);
    is_left.then_some(factor)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::basis::NEW_DIRECTION;
    use crate::algebra::linearised::Linearised;
    use crate::count::count;
    use crate::tests::hold_out::leave_out;
    use crate::{Group, Layout, Role, Row};

    /// Round-off of some hundred products, of condition 100.
    const ROUND_OFF: f64 = 1e-11;

    fn wave(i: usize, j: usize) -> f64 {
        (1.3 * count(i) + 0.7 * count(j * j) + 0.9 * count(i * j)).sin()
    }

    /// A fold with many rows, one with few, one of which nothing is known from the others, and one
    /// with a cluster that is not judged; without further columns, and with some.
    #[test]
    fn the_system_known_before_gives_what_the_whole_gives() {
        const ROWS: usize = 48;
        let clusters: Vec<Vec<usize>> = vec![
            (0..14).collect(),
            (14..18).collect(),
            (18..24).collect(),
            (24..36).collect(),
            (36..ROWS).collect(),
        ];
        let row = |observation| Row { observation, component: 0, sigma: 1.0, reported: true };
        let layout = Layout {
            rows: (0..ROWS).map(row).collect(),
            observations: (0..ROWS)
                .map(|i| clusters.iter().position(|c| c.contains(&i)).unwrap())
                .collect(),
            groups: (0..5).map(|g| Group { name: g.to_string(), role: Role::Fit }).collect(),
            unit: "mm".to_owned(),
            sigma_declared: true,
        };
        let mut columns = DMatrix::from_fn(ROWS, 8, wave);
        // A direction that the third cluster alone shows.
        for i in 0..ROWS {
            columns[(i, 2)] = if (18..24).contains(&i) { wave(i, 2) } else { 0.0 };
        }
        let system = Basis::of(&columns.columns(0, 5).into_owned(), NEW_DIRECTION);
        let residual = DVector::from_fn(ROWS, |i, _| wave(i, 31));
        let lin = Linear::from(Linearised::of_parts(&layout, residual, system, clusters));
        let (folds, skip) = ([0, 1, 2, 3, 3], [false, false, false, false, true]);
        let known = LeftOut::of(&lin, &folds, &skip);
        let full = lin.basis.with(&columns.columns(5, 3).into_owned(), NEW_DIRECTION);
        for full in [&lin.basis, &full] {
            let (quick, whole) = (known.errors(&lin, full), leave_out(&lin, full, &folds, &skip));
            assert_eq!(whole.iter().filter(|e| e.is_none()).count(), 2);
            for (quick, whole) in quick.iter().zip(&whole) {
                let [quick, whole] = [quick, whole].map(|e| e.map(|e| e.whitened));
                assert_eq!(quick.is_some(), whole.is_some());
                let (quick, whole) = (quick.unwrap_or(1.0), whole.unwrap_or(1.0));
                assert!((quick / whole - 1.0).abs() < ROUND_OFF, "{quick} {whole}");
            }
        }
    }
}
