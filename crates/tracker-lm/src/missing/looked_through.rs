//! The residual of the declared model, in which motions by time are looked for.

use model_discrepancy::chance_to_explain;
use nalgebra::{DMatrix, DVector, Vector6};

/// Share of a column's length that must be left beside the model: rows are linear to no more.
const NOTHING_LEFT: f64 = 1e-3;

/// By which station, at which step and when a reading was taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Seen {
    pub(crate) station: usize,
    pub(crate) step: usize,
    pub(crate) time: f64,
}

/// What moves against the rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Moving {
    /// The machine, against all stations.
    Machine,
    /// The station of each reading.
    Stations,
}

/// What a motion does to whitened values that has come so far at every reading, and the length of each
/// column before anything was taken out of them.
pub(crate) type Values<'a> = dyn Fn(Moving, &[f64]) -> (DMatrix<f64>, Vec<f64>) + 'a;

/// What a fit takes of whitened values: of the rows of a fit, or of readings that rows are combinations of.
#[derive(Clone, Debug)]
pub(crate) struct Fit {
    /// What the parameters take, directions × values.
    pub(crate) shared: DMatrix<f64>,
    /// Of values with unknowns of their own, which of these, and what they take; none of rows.
    pub(crate) own: Vec<Option<(usize, Vector6<f64>)>>,
    /// Residual of every value.
    pub(crate) residual: DVector<f64>,
    /// Square of the residual of all rows, and their degrees of freedom.
    pub(crate) square: f64,
    pub(crate) dof: usize,
}

/// Orthonormal basis of the columns of a fit's parameters, whitened, and the residual without what it explains.
pub(crate) fn beside(
    sigma_mm: impl Iterator<Item = f64>,
    jacobian: &DMatrix<f64>,
    residual: &DVector<f64>,
) -> (DMatrix<f64>, DVector<f64>) {
    let (mut whitened, mut residual) = (jacobian.clone(), residual.clone());
    for (i, sigma) in sigma_mm.enumerate() {
        whitened.row_mut(i).unscale_mut(sigma);
        residual[i] /= sigma;
    }
    for mut column in whitened.column_iter_mut() {
        let length = column.norm().max(f64::MIN_POSITIVE);
        column.unscale_mut(length);
    }
    let basis = whitened.qr().q();
    let along = basis.tr_mul(&residual);
    residual -= &basis * along;
    (basis, residual)
}

impl Fit {
    /// Of rows, with an orthonormal basis of the parameters' columns and the residual beside it.
    pub(crate) fn of_rows(basis: &DMatrix<f64>, residual: &DVector<f64>) -> Self {
        Self {
            shared: basis.transpose(),
            own: Vec::new(),
            residual: residual.clone(),
            square: residual.norm_squared(),
            dof: residual.len().saturating_sub(basis.ncols()),
        }
    }

    /// What it leaves of columns, with each other and with the residual.
    fn products(&self, columns: &DMatrix<f64>) -> (DMatrix<f64>, DVector<f64>) {
        let m = columns.ncols();
        let mut along = DMatrix::zeros(self.shared.nrows(), m);
        let n_own = self.own.iter().flatten().map(|(which, _)| which + 1).max().unwrap_or(0);
        let mut of_own = vec![vec![Vector6::zeros(); m]; n_own];
        let mut left = DMatrix::zeros(m, m);
        let mut onto = DVector::zeros(m);
        for value in 0..columns.nrows() {
            let row = columns.row(value);
            // A station moves its own readings alone.
            if row.iter().all(|entry| *entry == 0.0) {
                continue;
            }
            let own = self.own.get(value).and_then(Option::as_ref);
            for (j, &entry) in row.iter().enumerate() {
                along.column_mut(j).axpy(entry, &self.shared.column(value), 1.0);
                if let Some((which, taken)) = own {
                    of_own[*which][j] += taken * entry;
                }
                for (k, &other) in row.iter().enumerate() {
                    left[(k, j)] += entry * other;
                }
                onto[j] += entry * self.residual[value];
            }
        }
        left -= along.tr_mul(&along);
        for taken in &of_own {
            for (j, one) in taken.iter().enumerate() {
                for (k, other) in taken.iter().enumerate() {
                    left[(k, j)] -= one.dot(other);
                }
            }
        }
        (left, onto)
    }
}

/// A residual in which motions are looked for.
#[derive(Clone, Copy)]
pub(crate) struct LookedThrough<'a> {
    pub(crate) readings: &'a [Seen],
    pub(crate) fit: &'a Fit,
    pub(crate) values: &'a Values<'a>,
}

impl LookedThrough<'_> {
    /// What motions with these courses take together of the sum of squares, and the directions that
    /// they show; `None` where they show none.
    pub(crate) fn taken(&self, moving: Moving, shares: &[Vec<f64>]) -> Option<(f64, usize)> {
        let (tangents, lengths): (Vec<DMatrix<f64>>, Vec<Vec<f64>>) =
            shares.iter().map(|share| (self.values)(moving, share)).unzip();
        let columns: Vec<_> = tangents.iter().flat_map(DMatrix::column_iter).collect();
        if columns.is_empty() {
            return None;
        }
        let (left, onto) = self.fit.products(&DMatrix::from_columns(&columns));
        // Cholesky's factor row by row, without the columns of which those before leave nothing, and the
        // residual along their directions.
        let mut shown: Vec<(usize, Vec<f64>, f64)> = Vec::new();
        for (j, whole) in lengths.iter().flatten().enumerate() {
            let mut row: Vec<f64> = Vec::with_capacity(shown.len() + 1);
            for (k, of_known, _) in &shown {
                let before: f64 = row.iter().zip(of_known).map(|(a, b)| a * b).sum();
                row.push((left[(j, *k)] - before) / of_known[row.len()]);
            }
            let length = (left[(j, j)] - row.iter().map(|v| v * v).sum::<f64>()).max(0.0).sqrt();
            if length > NOTHING_LEFT * whole {
                let before: f64 = row.iter().zip(&shown).map(|(v, (.., known))| v * known).sum();
                row.push(length);
                shown.push((j, row, (onto[j] - before) / length));
            }
        }
        let taken = shown.iter().map(|(.., along)| along * along).sum();
        (!shown.is_empty()).then_some((taken, shown.len()))
    }

    /// That what is taken rises so by chance with so many parameters, from before to after.
    pub(crate) fn p_value(&self, taken: [f64; 2], parameters: [usize; 2]) -> f64 {
        let more = parameters[1].saturating_sub(parameters[0]);
        let dof = self.fit.dof.saturating_sub(parameters[1]);
        let left = (self.fit.square - taken[1]).max(0.0);
        chance_to_explain((taken[1] - taken[0]) / left, more, dof)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::count::count;

    /// Of products of some hundred numbers near one, over the square of what is left of a column.
    const ROUND_OFF: f64 = 1e-9;

    fn wave(i: usize, j: usize) -> f64 {
        (1.3 * count(i) + 0.7 * count(j * j) + 0.9 * count(i * j)).sin()
    }

    /// Of two motions, of which the second shows one direction that the first does not: what a fit to
    /// all columns takes of the sum of squares.
    #[test]
    fn what_is_taken_is_what_a_fit_takes() {
        const ROWS: usize = 600;
        let basis = DMatrix::from_fn(ROWS, 5, wave).qr().q();
        let data = DVector::from_fn(ROWS, |i, _| wave(i, 17));
        let residual = &data - &basis * basis.tr_mul(&data);
        let columns = |moving, share: &[f64]| match (moving, share[0] > 0.0) {
            (Moving::Machine, true) => DMatrix::from_fn(ROWS, 3, |i, j| wave(i, j + 7)),
            _ => DMatrix::from_fn(ROWS, 2, |i, j| wave(i, 9 + j)),
        };
        let values = |moving, share: &[f64]| {
            let columns = columns(moving, share);
            let whole = columns.column_iter().map(|c| c.norm()).collect();
            (columns, whole)
        };
        let fit = Fit::of_rows(&basis, &residual);
        let through = LookedThrough { readings: &[], fit: &fit, values: &values };
        let (taken, shown) = through.taken(Moving::Machine, &[vec![1.0], vec![0.0]]).unwrap();
        assert_eq!(shown, 4);
        let both = DMatrix::from_fn(ROWS, 4, |i, j| wave(i, j + 7));
        let all: Vec<_> = basis.column_iter().chain(both.column_iter()).collect();
        let whole = DMatrix::from_columns(&all).qr().q();
        let fitted = whole.tr_mul(&residual).norm_squared();
        assert!((taken / fitted - 1.0).abs() < ROUND_OFF, "{taken} {fitted}");
        assert!(through.taken(Moving::Machine, &[]).is_none());
    }
}
