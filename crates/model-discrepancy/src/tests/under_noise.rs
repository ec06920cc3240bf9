//! Tests of a candidate under every model that the noise may have.

use crate::levels::NEGLIGIBLE;
use std::iter;

use nalgebra::{DMatrix, DVector};

use crate::algebra::basis::Basis;
use crate::count::count;
use crate::noise::linear::Linear;
use crate::noise::noise_models::{Family, STEPS, UnderNoise, Variance};
use crate::tests::global_test::chi2_interval;

/// What is tested, beside everything it is tested beside.
pub(crate) struct Tested<'a> {
    lin: &'a Linear<'a>,
    /// Columns beside `lin.basis`, the tested ones last, then what they all leave of the data.
    columns: DMatrix<f64>,
    /// Share of the data in each tested column.
    along: DVector<f64>,
}

impl<'a> Tested<'a> {
    /// The last `n_tested` columns of `full`, which begins with the columns of `lin.basis`;
    /// `residual` is what the columns before them leave of the data.
    pub(crate) fn new(
        lin: &'a Linear<'a>,
        full: &Basis,
        n_tested: usize,
        residual: &DVector<f64>,
    ) -> Self {
        let columns = full.columns_from(lin.basis.dim());
        let beside = columns.ncols();
        let tested = columns.columns(beside - n_tested, n_tested);
        let along = tested.tr_mul(residual);
        // Without what the tested columns explain, so that no digits are lost in the products.
        let rest = residual - tested * &along;
        let mut columns = columns.insert_column(beside, 0.0);
        columns.set_column(beside, &rest);
        Self { lin, columns, along }
    }

    /// p-values with coloured noise along the measured order, where white is not the likeliest:
    /// noise of which neighbours agree, of long memory, and of the machine's position. Each is found
    /// when it is asked for.
    pub(crate) fn p_values(&self) -> impl Iterator<Item = f64> {
        let (lin, models) = (self.lin, &self.lin.noise);
        let of = |family| self.p_value(&self.columns, family);
        let neighbours = iter::once_with(move || of(models.neighbours(lin)));
        let memory = iter::once_with(move || of(models.fractional(lin)?));
        let position = iter::once_with(move || of(models.position(lin)?));
        neighbours.chain(memory).chain(position).flatten()
    }

    /// The same with the noise in the readings behind the rows, where there are such.
    pub(crate) fn p_values_of_readings(&self) -> impl Iterator<Item = f64> {
        let (lin, models) = (self.lin, &self.lin.noise);
        let of = |family| self.p_value(&models.readings(lin)?.lift(&self.columns), family);
        let neighbours = iter::once_with(move || of(models.neighbours_in_readings(lin)?));
        let memory = iter::once_with(move || of(models.fractional_in_readings(lin)?));
        neighbours.chain(memory).flatten()
    }

    /// That which was declared, where what is left beside the candidate has no larger one: a memory that only
    /// a larger one would hide in it is then no explanation.
    fn variance(&self, white: &UnderNoise) -> Variance {
        let [_, most] = chi2_interval(white.dof);
        let declared =
            self.lin.over_declared.filter(|over| over * white.square <= most * white.dof);
        declared.map_or(Variance::Found, Variance::Declared)
    }

    /// The model is not known, and the variance of a slow effect depends on it: the mean over
    /// the models, each as likely as the data make it; before them, that the noise is white is as
    /// likely as that it has any memory. Restricted likelihood (Patterson and
    /// Thompson 1971): unlike the plain lag-one correlation it is not pulled towards zero by what
    /// the fit has taken out.
    fn p_value(&self, columns: &DMatrix<f64>, family: &Family) -> Option<f64> {
        let mut judged: Vec<UnderNoise> = Vec::with_capacity(STEPS);
        let mut variance = Variance::Found;
        let mut best = f64::INFINITY;
        for model in family.judged(columns, &self.along) {
            if judged.is_empty() {
                variance = self.variance(&model);
            }
            let deviance = model.deviance(variance);
            best = best.min(deviance);
            // Stronger ones are less likely still.
            let is_negligible = deviance - best > 2.0 * NEGLIGIBLE.recip().ln();
            judged.push(model);
            if is_negligible {
                break;
            }
        }
        // White is the first.
        let (white, others) =
            judged.split_first().filter(|(white, _)| white.deviance(variance) > best)?;
        let share = |c: &UnderNoise| (0.5 * (best - c.deviance(variance))).exp();
        let of_white = (count(STEPS - 1) * share(white), white.p_value(variance));
        let shares = others.iter().map(|c| (share(c), c.p_value(variance))).chain([of_white]);
        let likely: Vec<_> = shares.filter(|(share, _)| *share > NEGLIGIBLE).collect();
        let sum: f64 = likely.iter().map(|(share, _)| share).sum();
        Some(likely.iter().map(|(share, p_value)| share * p_value).sum::<f64>() / sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::basis::NEW_DIRECTION;
    use crate::algebra::f_tail::f_tail;
    use crate::algebra::linearised::Linearised;
    use crate::{Group, Layout, Projected, Role, Row};

    const STEPS_MEASURED: usize = 7;
    /// Raw observations of a step, each of its own record, and the rows left of them.
    const READINGS: usize = 4;
    const LEFT: usize = 2;
    /// Round-off of some hundred products, of condition 1000.
    const ROUND_OFF: f64 = 1e-10;

    fn wave(i: usize, j: usize) -> f64 {
        (1.7 * count(i) + 0.9 * count(j * j) + 0.3 * count(i * j)).sin()
    }

    /// Orthonormal combinations of the readings of one step, at every step others.
    fn combination(step: usize) -> DMatrix<f64> {
        let any = DMatrix::from_fn(READINGS, LEFT, |i, j| wave(READINGS * step + i, j + 1));
        any.qr().q().transpose()
    }

    fn layout() -> Layout {
        let row = |i: usize| {
            let observation = READINGS * (i / LEFT) + i % LEFT;
            Row { observation, component: 0, sigma: 1.0, reported: true }
        };
        let group = |i: usize| Group { name: format!("{i}"), role: Role::Fit };
        Layout {
            rows: (0..LEFT * STEPS_MEASURED).map(row).collect(),
            observations: (0..READINGS * STEPS_MEASURED).map(|i| i / READINGS).collect(),
            groups: (0..STEPS_MEASURED).map(group).collect(),
            unit: "mm".to_owned(),
            sigma_declared: true,
        }
    }

    /// The same by the covariance of the rows themselves, `T·C·Tᵀ`: deviance up to a constant, and
    /// p-value.
    fn by_rows(
        correlation: f64,
        base: &DMatrix<f64>,
        last: &DVector<f64>,
        data: &DVector<f64>,
    ) -> (f64, f64) {
        let n = LEFT * STEPS_MEASURED;
        let covariance = DMatrix::from_fn(n, n, |i, j| {
            let (a, b) = (i / LEFT, j / LEFT);
            let share = combination(a).row(i % LEFT).dot(&combination(b).row(j % LEFT));
            share * correlation.powf(count(a.abs_diff(b)))
        });
        let root = covariance.cholesky().unwrap().unpack();
        let white = |m: &DMatrix<f64>| root.solve_lower_triangular(m).unwrap();
        let all = base.clone().insert_column(base.ncols(), 0.0);
        let all = {
            let mut all = all;
            all.set_column(base.ncols(), last);
            all
        };
        let (before, after) = (white(base).qr().q(), white(&all));
        let information = (after.transpose() * &after).determinant().ln();
        let after = after.qr().q();
        let data = root.solve_lower_triangular(data).unwrap();
        let square = |q: &DMatrix<f64>| data.norm_squared() - q.tr_mul(&data).norm_squared();
        let dof = count(n - all.ncols());
        let f = (square(&before) - square(&after)) / (square(&after) / dof);
        let log_determinant: f64 = root.diagonal().iter().map(|v| 2.0 * v.ln()).sum();
        (dof * square(&after).ln() + log_determinant + information, f_tail(f, 1.0, dof))
    }

    #[test]
    fn readings_give_what_the_covariance_of_the_rows_gives() {
        let layout = layout();
        let n = layout.rows.len();
        let projected: Vec<Projected> = (0..STEPS_MEASURED)
            .map(|step| Projected {
                first_row: LEFT * step,
                readings: (READINGS * step..READINGS * (step + 1)).map(|o| (o, 0)).collect(),
                combination: combination(step),
            })
            .collect();
        let records: Vec<usize> = (0..READINGS * STEPS_MEASURED).map(|i| i % READINGS).collect();
        let base = DMatrix::from_fn(n, 2, |i, j| wave(i, j + 3));
        let tested = DVector::from_fn(n, |i, _| wave(i, 6));
        let data = DVector::from_fn(n, |i, _| wave(i, 8) + 0.5 * tested[i]);

        let basis = Basis::of(&base, NEW_DIRECTION);
        let clusters = (0..STEPS_MEASURED).map(|s| (LEFT * s..LEFT * (s + 1)).collect()).collect();
        let mut lin = Linearised::of_parts(&layout, data.clone(), basis.clone(), clusters);
        lin.projected = &projected;
        lin.records = Some(&records);
        let lin = Linear::from(lin);
        let full = basis.with(&DMatrix::from_columns(std::slice::from_ref(&tested)), NEW_DIRECTION);
        let test = Tested::new(&lin, &full, 1, &basis.reject(&data));

        let family = lin.noise.neighbours_in_readings(&lin).unwrap();
        let columns = lin.noise.readings(&lin).unwrap().lift(&test.columns);
        let of_readings: Vec<UnderNoise> = family.judged(&columns, &test.along).collect();
        assert_eq!(of_readings.len(), STEPS);
        let correlation = |i: usize| 0.95 * count(i) / count(STEPS - 1);
        let of_rows: Vec<(f64, f64)> =
            (0..STEPS).map(|i| by_rows(correlation(i), &base, &tested, &data)).collect();
        for (readings, rows) in of_readings.iter().zip(&of_rows) {
            let deviance = |under: &UnderNoise| under.deviance(Variance::Found);
            let likelier = deviance(readings) - deviance(&of_readings[0]);
            assert!((likelier - (rows.0 - of_rows[0].0)).abs() < ROUND_OFF);
            assert!((readings.p_value(Variance::Found) - rows.1).abs() < ROUND_OFF);
        }
    }
}
