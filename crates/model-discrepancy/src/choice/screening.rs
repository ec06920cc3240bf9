//! Shapes along a covariate, screened: the classical F test tells which are worth all tests.

use nalgebra::{DMatrix, DVector, DVectorView, Matrix3};

use crate::Covariate;
use crate::algebra::independent::Independent;
use crate::algebra::product::{times, view};
use crate::choice::beside::{Beside, Sums};
use crate::choice::shape::{Periods, Shape, is_constant};
use crate::count::count;
use crate::levels::MIN_SHAPE_KEPT;
use crate::noise::linear::Linear;
use crate::tests::f_test::{Significance, f_test_of};

/// Functions whose values are taken together: more would not stay in a processor's cache.
const TOGETHER: usize = 32;

/// What shapes are tested beside, on all rows.
pub(crate) struct Screening {
    followed: Followed,
    beside: Option<Beside>,
}

impl Screening {
    pub(crate) fn new(lin: &Linear<'_>, clean: &DVector<f64>) -> Self {
        let system = lin.basis.matrix();
        let constants = constants(lin);
        let beside = Beside::of(&Sums::of_all(&system, &constants, clean));
        Self { followed: Followed::of(lin, &constants, clean), beside }
    }

    /// The F test of each shape beside the constants that go along; `None` where nothing is left
    /// to test.
    pub(crate) fn screened(&self, shapes: &[Shape]) -> Vec<Option<Significance>> {
        let products = |shape| products_of(&[&self.followed], shape).pop();
        shapes.iter().map(|shape| test(&products(shape)?, self.beside.as_ref()?)).collect()
    }

    /// The F test of each period.
    pub(crate) fn of_periods(
        &self,
        covariate: &Covariate,
        periods: &Periods,
    ) -> Vec<Option<Significance>> {
        let products = products_of_periods(&[&self.followed], covariate, periods).pop();
        let test = |products| test(products, self.beside.as_ref()?);
        products.iter().flatten().map(test).collect()
    }

    /// The F test of a jump and another slope after each of the places, ascending.
    pub(crate) fn of_breaks(&self, course: &Course, at: &[f64]) -> Vec<Option<Significance>> {
        let products = self.followed.of_breaks(course, at, None);
        products.iter().map(|products| test(products, self.beside.as_ref()?)).collect()
    }

    /// What interruptions along a covariate are tested with.
    pub(crate) fn course(&self, covariate: &Covariate) -> Course {
        self.followed.course(covariate)
    }
}

/// A column for every component that follows a constant, whitened.
pub(crate) fn constants(lin: &Linear<'_>) -> DMatrix<f64> {
    let ones = vec![1.0; lin.layout.observations.len()];
    let columns = lin.followed(&ones);
    if columns.is_empty() {
        DMatrix::zeros(lin.rows.len(), 0)
    } else {
        DMatrix::from_columns(&columns)
    }
}

/// The rows that follow a function of the observation, component by component.
pub(crate) struct Followed {
    components: Vec<Component>,
    /// Directions of the system.
    directions: usize,
}

/// The rows of one component, as a function of the observation sees them: the column that follows it
/// has its value there times a weight.
struct Component {
    /// Positions of the rows among all.
    rows: Vec<usize>,
    observations: Vec<usize>,
    /// Squares of the weights: products with the component's own constant.
    squares: DVector<f64>,
    /// Directions of the system and, last, what it leaves of the data, one a row, times the weights.
    held: DMatrix<f64>,
}

/// Products of the columns of a shape, functions first, components in each.
#[derive(Clone, Debug)]
pub(crate) struct Products {
    /// Whether constants go along.
    along: bool,
    /// With each other.
    own: DMatrix<f64>,
    /// With the directions, and the constants of all components.
    held: DMatrix<f64>,
    /// With what is left of the data.
    onto: DVector<f64>,
}

impl Products {
    fn zeros(along: bool, columns: usize, held: usize) -> Self {
        Self {
            along,
            own: DMatrix::zeros(columns, columns),
            held: DMatrix::zeros(held, columns),
            onto: DVector::zeros(columns),
        }
    }

    /// What a component has of function `f` with the later ones and with its constant, from another one; of so many
    /// functions, components and directions of the system.
    fn copy_own(
        &mut self,
        [other, c]: [usize; 2],
        (f, functions): (usize, usize),
        (k, directions): (usize, usize),
    ) {
        let at = f * k;
        self.held[(directions + c, at + c)] = self.held[(directions + other, at + other)];
        for g in f..functions {
            let product = self.own[(at + other, g * k + other)];
            self.own[(at + c, g * k + c)] = product;
            self.own[(g * k + c, at + c)] = product;
        }
    }

    /// Sums over the rows of both.
    pub(crate) fn with(mut self, others: &Self) -> Self {
        self.own += &others.own;
        self.held += &others.held;
        self.onto += &others.onto;
        self
    }

    /// Sums over rows without those of `some`.
    pub(crate) fn less(&self, some: &Self) -> Self {
        Self {
            along: self.along,
            own: &self.own - &some.own,
            held: &self.held - &some.held,
            onto: &self.onto - &some.onto,
        }
    }
}

/// The F test of a shape beside a system; `None` where nothing is left to test.
pub(crate) fn test(products: &Products, beside: &Beside) -> Option<Significance> {
    let which = usize::from(products.along);
    let held = beside.held(&products.held, products.along);
    let left = &products.own - held.tr_mul(&held);
    let onto = &products.onto - held.tr_mul(&beside.data(products.along));
    let whole = products.own.diagonal();
    let new = Independent::of(&left, |column| MIN_SHAPE_KEPT * MIN_SHAPE_KEPT * whole[column]);
    let explained = new.along_one(&onto).norm_squared();
    let (square, directions) = (beside.squares[which], beside.directions[which]);
    f_test_of(explained, new.kept.len(), square, beside.rows, directions)
}

/// Products of a shape over the rows of each of `followed`.
pub(crate) fn products_of(followed: &[&Followed], shape: &Shape) -> Vec<Products> {
    let varying = shape.functions.iter().filter(|(name, _)| !is_constant(name));
    let functions: Vec<_> = varying.map(|(_, values)| DVectorView::from(&values[..])).collect();
    let along = shape.functions.iter().any(|(name, _)| is_constant(name));
    let values = DMatrix::from_columns(&functions);
    followed.iter().flat_map(|one| one.products(&values, values.ncols(), along)).collect()
}

/// The same of each period.
pub(crate) fn products_of_periods(
    followed: &[&Followed],
    covariate: &Covariate,
    periods: &Periods,
) -> Vec<Vec<Products>> {
    let once = |value: &f64| (std::f64::consts::TAU * value / periods.longest).sin_cos();
    let (sine, cosine): (Vec<f64>, Vec<f64>) = covariate.values.iter().map(once).unzip();
    // Of every observation the sine and cosine of the part come to.
    let mut turned: Vec<(f64, f64)> = vec![(0.0, 1.0); sine.len()];
    let mut part = 0;
    let mut products: Vec<Vec<Products>> = followed.iter().map(|_| Vec::new()).collect();
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
        for (products, one) in products.iter_mut().zip(followed) {
            products.extend(one.products(&values, 2, true));
        }
    }
    products
}

impl Followed {
    /// Those of its rows for which `some` is true.
    pub(crate) fn narrowed(&self, some: &[bool]) -> Self {
        let components = self.components.iter().map(|component| component.of(some)).collect();
        Self { components, directions: self.directions }
    }

    pub(crate) fn of(lin: &Linear<'_>, constants: &DMatrix<f64>, clean: &DVector<f64>) -> Self {
        let directions = lin.basis.dim();
        let component = |weights: DVectorView<'_, f64>| {
            let rows: Vec<usize> = (0..weights.len()).filter(|&i| weights[i] != 0.0).collect();
            let weights = DVector::from_fn(rows.len(), |i, _| weights[rows[i]]);
            let mut held = DMatrix::zeros(directions + 1, rows.len());
            let system = lin.basis.rows(&rows);
            for (k, column) in system.column_iter().enumerate() {
                let weighted = column.iter().zip(&weights).map(|(value, weight)| value * weight);
                held.row_mut(k).iter_mut().zip(weighted).for_each(|(to, value)| *to = value);
            }
            for (i, (&row, weight)) in rows.iter().zip(&weights).enumerate() {
                held[(directions, i)] = clean[row] * weight;
            }
            let observation = |&row: &usize| lin.layout.rows[lin.rows[row]].observation;
            let observations = rows.iter().map(observation).collect();
            Component { rows, observations, squares: weights.map(|w| w * w), held }
        };
        Self { components: constants.column_iter().map(component).collect(), directions }
    }

    /// Products of shapes of so many functions each, the values one observation a row.
    fn products(&self, values: &DMatrix<f64>, functions: usize, along: bool) -> Vec<Products> {
        let k = self.components.len();
        let shapes = values.ncols() / functions.max(1);
        let empty = || Products::zeros(along, functions * k, self.directions + k);
        let mut products: Vec<Products> = (0..shapes).map(|_| empty()).collect();
        let mut selected: Option<(&[usize], DMatrix<f64>)> = None;
        for (c, component) in self.components.iter().enumerate() {
            let observations = &component.observations[..];
            let is_known = selected.as_ref().is_some_and(|(known, _)| *known == observations);
            let here = if component.is_every(values.nrows()) {
                values
            } else if is_known {
                &selected.as_ref().expect("known").1
            } else {
                &selected.insert((observations, values.select_rows(observations))).1
            };
            let held = times(view(&component.held), view(here));
            // Of a component that has the same weights, the products of functions with each other are known.
            let like = self.components[..c].iter().position(|other| other.is_like(component));
            let mut weighted = DVector::zeros(here.nrows());
            for (shape, products) in products.iter_mut().enumerate() {
                let first = shape * functions;
                for f in 0..functions {
                    let (at, own) = (f * k + c, held.column(first + f));
                    let of_system = own.rows(0, self.directions);
                    products.held.view_mut((0, at), (self.directions, 1)).copy_from(&of_system);
                    products.onto[at] = own[self.directions];
                    if let Some(other) = like {
                        products.copy_own([other, c], (f, functions), (k, self.directions));
                        continue;
                    }
                    weighted.cmpy(1.0, &here.column(first + f), &component.squares, 0.0);
                    products.held[(self.directions + c, at)] = weighted.sum();
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

    /// What interruptions along a covariate are tested with.
    pub(crate) fn course(&self, covariate: &Covariate) -> Course {
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
        Course { mean, from_mean, sorted }
    }

    /// Products of a jump and another slope after each of the places, ascending, over the rows that
    /// are not of `left_out`.
    pub(crate) fn of_breaks(
        &self,
        course: &Course,
        at: &[f64],
        left_out: Option<&[bool]>,
    ) -> Vec<Products> {
        let (k, d) = (self.components.len(), self.directions);
        let empty = || Products::zeros(true, 3 * k, d + k);
        let mut products: Vec<Products> = at.iter().map(|_| empty()).collect();
        for c in 0..k {
            let (after, all) = self.after_breaks(course, c, at, left_out);
            for ((products, sums), at) in products.iter_mut().zip(&after).zip(at) {
                let from = at - course.mean;
                let columns = [c, k + c, 2 * k + c];
                let [one, slope] = &sums.held;
                let [w, wv, wvv] = sums.squares;
                let (bent, bent_along) = (wv - from * w, wvv - from * wv);
                let held = [one, &all.held[1], &(slope - one * from)];
                for ((column, held), with_constant) in
                    columns.into_iter().zip(held).zip([w, all.squares[1], bent])
                {
                    products.held.view_mut((0, column), (d, 1)).copy_from(&held.rows(0, d));
                    products.held[(d + c, column)] = with_constant;
                    products.onto[column] = held[d];
                }
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
                    (0..3).for_each(|j| products.own[(columns[i], columns[j])] = own[(i, j)]);
                }
            }
        }
        products
    }

    /// Over the rows of a component after each place, and over all of them.
    fn after_breaks(
        &self,
        course: &Course,
        component: usize,
        at: &[f64],
        left_out: Option<&[bool]>,
    ) -> (Vec<AfterBreak>, AfterBreak) {
        let (sorted, component) = (&course.sorted[component], &self.components[component]);
        let zero = DVector::zeros(self.directions + 1);
        let mut sums = AfterBreak { held: [zero.clone(), zero], squares: [0.0; 3] };
        let mut after = Vec::with_capacity(at.len());
        let is_in = |row: usize| left_out.is_none_or(|left_out| !left_out[component.rows[row]]);
        let mut rows = sorted.iter().filter(|&&row| is_in(row)).peekable();
        for place in at.iter().rev().copied().chain([f64::NEG_INFINITY]) {
            let value = |row: usize| course.from_mean[component.observations[row]];
            while let Some(&row) = rows.next_if(|&&row| value(row) > place - course.mean) {
                let (value, held) = (value(row), component.held.column(row));
                sums.held[0] += held;
                sums.held[1].axpy(value, &held, 1.0);
                let square = component.squares[row];
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

impl Component {
    /// Whether it has a row for each of so many observations, in their order.
    fn is_every(&self, observations: usize) -> bool {
        self.observations.len() == observations
            && self.observations.iter().enumerate().all(|(i, &observation)| i == observation)
    }

    /// Whether a function of the observation has the same values and weights in another one.
    fn is_like(&self, other: &Self) -> bool {
        self.observations == other.observations && self.squares == other.squares
    }

    /// Those of its rows for which `some` is true.
    fn of(&self, some: &[bool]) -> Self {
        let kept: Vec<usize> = (0..self.rows.len()).filter(|&i| some[self.rows[i]]).collect();
        Self {
            rows: kept.iter().map(|&i| self.rows[i]).collect(),
            observations: kept.iter().map(|&i| self.observations[i]).collect(),
            squares: self.squares.select_rows(&kept),
            held: self.held.select_columns(&kept),
        }
    }
}

/// The rows of every component by the value of a covariate.
pub(crate) struct Course {
    mean: f64,
    /// Of every observation.
    from_mean: Vec<f64>,
    /// Rows of each component, the largest value first.
    sorted: Vec<Vec<usize>>,
}

/// Sums over the rows after a break of what a row holds, times its value to the power of 0 and 1 (of
/// the weights also 2).
#[derive(Clone)]
struct AfterBreak {
    held: [DVector<f64>; 2],
    squares: [f64; 3],
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::algebra::basis::{Basis, NEW_DIRECTION};
    use crate::algebra::linearised::Linearised;
    use crate::choice::interruption::interrupted;
    use crate::{Group, Layout, Quantity, Role, Row};

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
        let by_sums = screening.of_breaks(&screening.course(&covariate), &breaks);
        assert_same(&by_sums, &screening.screened(&shapes), OF_SUMS);

        let periods = Periods::of_parts(28.0, (3..40).collect());
        let shape = |&part: &usize| periods.shape(&covariate, part);
        let shapes: Vec<Shape> = periods.parts.iter().map(shape).collect();
        let turned = screening.of_periods(&covariate, &periods);
        assert_same(&turned, &screening.screened(&shapes), OF_SUMS);
    }
}
