//! Shapes along a covariate at a glance: the classical F test tells which are worth a hearing.

use nalgebra::{DMatrix, DVector, DVectorView, Matrix3};

use crate::Covariate;
use crate::algebra::basis::Basis;
use crate::choice::shape::{Periods, Shape, is_constant};
use crate::count::count;
use crate::levels::MIN_SHAPE_KEPT;
use crate::noise::linear::Linear;
use crate::tests::f_test::{Significance, f_test_of};

/// Functions whose values are taken together: more would not stay in a processor's cache.
const TOGETHER: usize = 32;

/// What shapes are tested beside.
pub(crate) struct Screening<'a> {
    pub(crate) lin: &'a Linear<'a>,
    components: Vec<Component>,
    /// Directions of the system, and with what it leaves of the constants that go along with a shape.
    directions: [usize; 2],
    /// Square of what the system leaves of the data, and with the constants.
    squares: [f64; 2],
}

/// The rows of one component, as a function of the observation sees them: the column that follows it
/// has its value there times a weight.
struct Component {
    observations: Vec<usize>,
    /// Squares of the weights.
    squares: DVector<f64>,
    /// Directions, constants last, one a row, times the weights.
    held: DMatrix<f64>,
    /// What the system leaves of the data, and with the constants, times the weights.
    left: [DVector<f64>; 2],
}

/// Products of the columns of a shape, functions first, components in each.
struct Products {
    /// With each other.
    own: DMatrix<f64>,
    /// With the directions.
    held: DMatrix<f64>,
    /// With what is left of the data.
    onto: DVector<f64>,
}

impl<'a> Screening<'a> {
    pub(crate) fn new(lin: &'a Linear<'a>, clean: &DVector<f64>) -> Self {
        let ones = vec![1.0; lin.layout.observations.len()];
        let tangent = DMatrix::from_columns(&lin.followed(&ones));
        let beside = lin.basis.reject_columns(&tangent);
        let mut constants = Basis::empty(tangent.nrows());
        for (left, whole) in beside.column_iter().zip(tangent.column_iter()) {
            constants.push(&left.into_owned(), whole.norm(), MIN_SHAPE_KEPT);
        }
        let varying = constants.reject(clean);
        let (system, constants) = (lin.basis.matrix(), constants.matrix());
        let component = |weights: DVectorView<'_, f64>| {
            let rows: Vec<usize> = (0..weights.len()).filter(|&i| weights[i] != 0.0).collect();
            let weights = DVector::from_fn(rows.len(), |i, _| weights[rows[i]]);
            let held = DMatrix::from_fn(system.ncols() + constants.ncols(), rows.len(), |k, i| {
                let row = rows[i];
                let entry = match k.checked_sub(system.ncols()) {
                    Some(constant) => constants[(row, constant)],
                    None => system[(row, k)],
                };
                entry * weights[i]
            });
            let weighted = |of: &DVector<f64>| of.select_rows(&rows).component_mul(&weights);
            let left = [weighted(clean), weighted(&varying)];
            let observation = |&row: &usize| lin.layout.rows[lin.rows[row]].observation;
            let observations = rows.iter().map(observation).collect();
            Component { observations, squares: weights.map(|w| w * w), held, left }
        };
        Self {
            lin,
            components: tangent.column_iter().map(|c| component(c.as_view())).collect(),
            directions: [system.ncols(), system.ncols() + constants.ncols()],
            squares: [clean.norm_squared(), varying.norm_squared()],
        }
    }

    /// The F test of each shape beside the constants that go along; `None` where nothing is left
    /// to test.
    pub(crate) fn screened(&self, shapes: &[Shape]) -> Vec<Option<Significance>> {
        shapes.iter().map(|shape| self.one(shape)).collect()
    }

    fn one(&self, shape: &Shape) -> Option<Significance> {
        let varying = shape.functions.iter().filter(|(name, _)| !is_constant(name));
        let functions: Vec<_> = varying.map(|(_, values)| DVectorView::from(&values[..])).collect();
        let along = shape.functions.iter().any(|(name, _)| is_constant(name));
        let values = DMatrix::from_columns(&functions);
        self.test(&self.products(&values, values.ncols(), along).pop()?, along)
    }

    /// The F test of each period.
    pub(crate) fn of_periods(
        &self,
        covariate: &Covariate,
        periods: &Periods,
    ) -> Vec<Option<Significance>> {
        let once = |value: &f64| (std::f64::consts::TAU * value / periods.longest).sin_cos();
        let (sine, cosine): (Vec<f64>, Vec<f64>) = covariate.values.iter().map(once).unzip();
        // Of every observation the sine and cosine of the part come to.
        let mut turned: Vec<(f64, f64)> = vec![(0.0, 1.0); sine.len()];
        let mut part = 0;
        let mut tests = Vec::with_capacity(periods.parts.len());
        for some in periods.parts.chunks(TOGETHER / 2) {
            let mut values = DMatrix::zeros(sine.len(), 2 * some.len());
            for (k, &wanted) in some.iter().enumerate() {
                for _ in part..wanted {
                    for ((turned, s), c) in turned.iter_mut().zip(&sine).zip(&cosine) {
                        *turned = (turned.0 * c + turned.1 * s, turned.1 * c - turned.0 * s);
                    }
                }
                part = wanted;
                for (i, (sine, cosine)) in turned.iter().enumerate() {
                    values[(i, 2 * k)] = *cosine;
                    values[(i, 2 * k + 1)] = *sine;
                }
            }
            let products = self.products(&values, 2, true);
            tests.extend(products.iter().map(|products| self.test(products, true)));
        }
        tests
    }

    /// Products of shapes of so many functions each, the values one observation a row.
    fn products(&self, values: &DMatrix<f64>, functions: usize, along: bool) -> Vec<Products> {
        let (which, k) = (usize::from(along), self.components.len());
        let shapes = values.ncols() / functions.max(1);
        let columns = functions * k;
        let empty = || Products {
            own: DMatrix::zeros(columns, columns),
            held: DMatrix::zeros(self.directions[which], columns),
            onto: DVector::zeros(columns),
        };
        let mut products: Vec<Products> = (0..shapes).map(|_| empty()).collect();
        for (c, component) in self.components.iter().enumerate() {
            let here = values.select_rows(&component.observations);
            let held = component.held.rows(0, self.directions[which]) * &here;
            let onto = here.tr_mul(&component.left[which]);
            for (shape, products) in products.iter_mut().enumerate() {
                let first = shape * functions;
                for f in 0..functions {
                    let at = f * k + c;
                    products.held.set_column(at, &held.column(first + f));
                    products.onto[at] = onto[first + f];
                    let weighted = here.column(first + f).component_mul(&component.squares);
                    for g in f..functions {
                        let product = weighted.dot(&here.column(first + g));
                        products.own[(at, g * k + c)] = product;
                        products.own[(g * k + c, at)] = product;
                    }
                }
            }
        }
        products
    }

    fn test(&self, products: &Products, along: bool) -> Option<Significance> {
        let which = usize::from(along);
        let left = &products.own - products.held.tr_mul(&products.held);
        let (explained, directions) = explained(&left, &products.own.diagonal(), &products.onto);
        let (square, base_dim) = (self.squares[which], self.directions[which]);
        f_test_of(explained, directions, square, self.lin.rows.len(), base_dim)
    }

    /// What interruptions along a covariate are tested with.
    pub(crate) fn course(&self, covariate: &Covariate) -> Course<'_> {
        let values = &covariate.values;
        let mean = values.iter().sum::<f64>() / count(values.len());
        let from_mean: Vec<f64> = values.iter().map(|v| v - mean).collect();
        let sorted = |component: &Component| {
            let mut sorted: Vec<usize> = (0..component.observations.len()).collect();
            let value = |i: usize| from_mean[component.observations[i]];
            sorted.sort_by(|&a, &b| value(b).total_cmp(&value(a)));
            sorted
        };
        let sorted = self.components.iter().map(sorted).collect();
        Course { screening: self, mean, from_mean, sorted }
    }
}

/// Products with a function's course along a covariate, as sums from its end.
pub(crate) struct Course<'a> {
    screening: &'a Screening<'a>,
    mean: f64,
    /// Of every observation.
    from_mean: Vec<f64>,
    /// Rows of each component, the largest value first.
    sorted: Vec<Vec<usize>>,
}

/// Sums over the rows after a break of what a row holds, times its value to the power of 0 and 1 (of
/// the weights also 2).
#[derive(Clone)]
struct Sums {
    held: [DVector<f64>; 2],
    onto: [f64; 2],
    squares: [f64; 3],
}

impl Course<'_> {
    /// The F test of a jump and another slope after each of the places, ascending.
    pub(crate) fn of_breaks(&self, at: &[f64]) -> Vec<Option<Significance>> {
        let k = self.sorted.len();
        let empty = || Products {
            own: DMatrix::zeros(3 * k, 3 * k),
            held: DMatrix::zeros(self.screening.directions[1], 3 * k),
            onto: DVector::zeros(3 * k),
        };
        let mut products: Vec<Products> = at.iter().map(|_| empty()).collect();
        for c in 0..k {
            let (after, all) = self.sums(c, at);
            for ((products, sums), at) in products.iter_mut().zip(&after).zip(at) {
                let from = at - self.mean;
                let columns = [c, k + c, 2 * k + c];
                let [one, slope] = &sums.held;
                products.held.set_column(columns[0], one);
                products.held.set_column(columns[1], &all.held[1]);
                products.held.set_column(columns[2], &(slope - one * from));
                let onto = [sums.onto[0], all.onto[1], sums.onto[1] - from * sums.onto[0]];
                let [w, wv, wvv] = sums.squares;
                let (bent, bent_along) = (wv - from * w, wvv - from * wv);
                let own = Matrix3::new(
                    w,
                    wv,
                    bent, //
                    wv,
                    all.squares[2],
                    bent_along, //
                    bent,
                    bent_along,
                    bent_along - from * bent,
                );
                for i in 0..3 {
                    products.onto[columns[i]] = onto[i];
                    (0..3).for_each(|j| products.own[(columns[i], columns[j])] = own[(i, j)]);
                }
            }
        }
        products.iter().map(|products| self.screening.test(products, true)).collect()
    }

    /// Over the rows of a component after each place, and over all of them.
    fn sums(&self, component: usize, at: &[f64]) -> (Vec<Sums>, Sums) {
        let (sorted, component) = (&self.sorted[component], &self.screening.components[component]);
        let zero = DVector::zeros(self.screening.directions[1]);
        let mut sums = Sums { held: [zero.clone(), zero], onto: [0.0; 2], squares: [0.0; 3] };
        let mut after = Vec::with_capacity(at.len());
        let mut rows = sorted.iter().peekable();
        for place in at.iter().rev().copied().chain([f64::NEG_INFINITY]) {
            let is_after =
                |&&row: &&usize| self.from_mean[component.observations[row]] > place - self.mean;
            while let Some(&row) = rows.next_if(is_after) {
                let value = self.from_mean[component.observations[row]];
                let held = component.held.column(row);
                sums.held[0] += held;
                sums.held[1].axpy(value, &held, 1.0);
                let (onto, square) = (component.left[1][row], component.squares[row]);
                sums.onto[0] += onto;
                sums.onto[1] += onto * value;
                sums.squares[0] += square;
                sums.squares[1] += square * value;
                sums.squares[2] += square * value * value;
            }
            after.push(sums.clone());
        }
        after.pop();
        after.reverse();
        (after, sums)
    }
}

/// Square of a residual that columns explain, from their products with each other and with it, and
/// how many directions they have; a column of which less than a share of its `whole` square is new
/// beside those before it counts for nothing (Cholesky's factor, row by row).
fn explained(products: &DMatrix<f64>, whole: &DVector<f64>, onto: &DVector<f64>) -> (f64, usize) {
    // Rows of the factor, each with what it takes of the residual.
    let mut kept: Vec<(usize, Vec<f64>, f64)> = Vec::new();
    for column in 0..products.ncols() {
        let mut row: Vec<f64> = Vec::with_capacity(kept.len() + 1);
        for (other, earlier, _) in &kept {
            let known: f64 = earlier.iter().zip(&row).map(|(a, b)| a * b).sum();
            row.push((products[(*other, column)] - known) / earlier[row.len()]);
        }
        let new = products[(column, column)] - row.iter().map(|v| v * v).sum::<f64>();
        // `>` also turns away NaN and the zero column.
        if new > MIN_SHAPE_KEPT * MIN_SHAPE_KEPT * whole[column] {
            let known: f64 = kept.iter().zip(&row).map(|((_, _, took), v)| took * v).sum();
            let length = new.sqrt();
            row.push(length);
            kept.push((column, row, (onto[column] - known) / length));
        }
    }
    (kept.iter().map(|(_, _, took)| took * took).sum(), kept.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::algebra::basis::NEW_DIRECTION;
    use crate::algebra::linearised::Linearised;
    use crate::choice::interruption::interrupted;
    use crate::{Group, Layout, Quantity, Role, Row};

    /// Round-off of products of numbers near one.
    const ROUND_OFF: f64 = 1e-12;
    /// The same of sums over a course, which lose the square of its length over that of a part.
    const OF_SUMS: f64 = 1e-10;

    const POINTS: usize = 40;

    /// Points of two components, of which the second is missing at every third.
    fn layout() -> Layout {
        let rows = (0..POINTS).flat_map(|observation| {
            let components = if observation % 3 == 0 { 0..1 } else { 0..2 };
            components.map(move |component| {
                let sigma = 1.0 + 0.1 * count(observation % 4);
                Row { observation, component, sigma, reported: true }
            })
        });
        let group = |i: usize| Group { name: i.to_string(), role: Role::Fit };
        Layout {
            rows: rows.collect(),
            observations: (0..POINTS).collect(),
            groups: (0..POINTS).map(group).collect(),
            unit: "mm".to_owned(),
            sigma_declared: true,
        }
    }

    fn wave(i: usize, j: usize) -> f64 {
        (1.1 * count(i) + 0.6 * count(j * j) + 0.8 * count(i * j)).sin()
    }

    fn assert_same(quick: &[Option<Significance>], whole: &[Option<Significance>], to: f64) {
        assert_eq!(quick.len(), whole.len());
        for (quick, whole) in quick.iter().zip(whole) {
            let (quick, whole) = (quick.unwrap(), whole.unwrap());
            assert_eq!((quick.directions, quick.dof), (whole.directions, whole.dof));
            assert!((quick.explained - whole.explained).abs() < to, "{quick:?} {whole:?}");
        }
    }

    /// Interruptions by sums and periods by turning give what their columns give.
    #[test]
    fn courses_and_periods_are_what_their_columns_are() {
        let layout = layout();
        let n = layout.rows.len();
        let basis = Basis::of(&DMatrix::from_fn(n, 4, wave), NEW_DIRECTION);
        let clusters = (0..POINTS).map(|_| Vec::new()).collect();
        let residual = DVector::from_fn(n, |i, _| wave(i, 9));
        let mut rows = Linearised::of_parts(&layout, residual, basis, clusters);
        rows.sigma = layout.rows.iter().map(|row| row.sigma).collect();
        let lin = Linear::from(rows);
        let screening = Screening::new(&lin, &lin.clean_residual());
        let values: Vec<f64> = (0..POINTS).map(|i| 900.0 + 7.0 * wave(i, 2)).collect();
        let covariate = Covariate::recorded("time_s", Quantity::Time, values);

        let breaks = [894.0, 898.5, 901.0, 905.5];
        let shapes: Vec<Shape> =
            breaks.iter().map(|&at| interrupted(&covariate, at, &breaks)).collect();
        let by_sums = screening.course(&covariate).of_breaks(&breaks);
        assert_same(&by_sums, &screening.screened(&shapes), OF_SUMS);

        let periods = Periods::of_parts(28.0, (3..40).collect());
        let shape = |&part: &usize| periods.shape(&covariate, part);
        let shapes: Vec<Shape> = periods.parts.iter().map(shape).collect();
        let turned = screening.of_periods(&covariate, &periods);
        assert_same(&turned, &screening.screened(&shapes), OF_SUMS);
    }

    #[test]
    fn what_columns_explain_is_what_their_span_explains() {
        let entry = |i: usize, j: usize| f64::from(u8::try_from((7 * i + 5 * j * j) % 11).unwrap());
        let mut columns = DMatrix::from_fn(9, 4, entry);
        // The third is the sum of the first two.
        let sum = columns.column(0) + columns.column(1);
        columns.set_column(2, &sum);
        let residual = DVector::from_fn(9, |i, _| entry(i, 3) - entry(i, 5));
        let span = Basis::of(&columns, MIN_SHAPE_KEPT);
        let products = columns.tr_mul(&columns);
        let (explained, directions) =
            explained(&products, &products.diagonal(), &columns.tr_mul(&residual));
        assert_eq!(directions, 3);
        let exact = span.explained(&residual);
        assert!((explained - exact).abs() < ROUND_OFF * exact.max(1.0), "{explained} {exact}");
    }
}
