//! A linear model with any base and any effects, and a plate of points to measure with it.

use model_discrepancy::{
    Course, Covariate, Declared, Effect, Group, Layout, LinearModel, Parameter, Quantity, Role, Row,
};
use nalgebra::{DMatrix, DVector, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Gives a model its base parameters: what one unit of each adds to the data.
pub(crate) fn set_base(model: &mut LinearModel, names: &[&str], columns: DMatrix<f64>) {
    model.declared.base = names.iter().map(|name| parameter(name)).collect();
    model.declared.start = DVector::zeros(names.len());
    model.base = -columns;
}

/// Adds an effect: what one unit of each amplitude adds to the data.
pub(crate) fn push(model: &mut LinearModel, effect: Effect, columns: DMatrix<f64>) {
    model.declared.effects.push(effect);
    model.tangents.push(-columns);
}

/// Points of a measured body, in mm.
pub(crate) fn points(n: usize, seed: u64) -> Vec<Vector3<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let half = Vector3::new(400.0, 300.0, 150.0);
    (0..n).map(|_| half.map(|h| rng.random_range(-h..h))).collect()
}

/// White or AR(1) noise with standard deviation `sigma`, one vector per point.
pub(crate) fn noise(n: usize, sigma: f64, phi: f64, rng: &mut ChaCha8Rng) -> Vec<Vector3<f64>> {
    let mut normal = || Vector3::from_fn(|_, _| StandardNormal.sample(rng));
    let mut state: Vector3<f64> = normal();
    let step = (1.0 - phi * phi).sqrt();
    (0..n)
        .map(|_| {
            let now = state * sigma;
            state = state * phi + normal() * step;
            now
        })
        .collect()
}

fn rows_3d(values: impl Iterator<Item = Vector3<f64>>) -> DVector<f64> {
    DVector::from_vec(values.flat_map(|v| [v.x, v.y, v.z]).collect())
}

/// What each point adds per unit of one amplitude.
pub(crate) type Field = fn(&Vector3<f64>, f64) -> Vector3<f64>;

fn column(points: &[Vector3<f64>], field: Field) -> DVector<f64> {
    let n = points.len() as f64;
    let order = |i: usize| i as f64 / (n - 1.0) - 0.5;
    rows_3d(points.iter().enumerate().map(|(i, p)| field(p, order(i))))
}

pub(crate) const RIGID: [(&str, Field); 6] = [
    ("tx", |_, _| Vector3::x()),
    ("ty", |_, _| Vector3::y()),
    ("tz", |_, _| Vector3::z()),
    ("rx", |p, _| Vector3::x().cross(p)),
    ("ry", |p, _| Vector3::y().cross(p)),
    ("rz", |p, _| Vector3::z().cross(p)),
];

pub(crate) const CATALOGUE: [(&str, &[Field]); 5] = [
    ("scale", &[|p, _| *p]),
    (
        "anisotropic-scale",
        &[
            |p, _| Vector3::new(p.x, 0.0, 0.0),
            |p, _| Vector3::new(0.0, p.y, 0.0),
            |p, _| Vector3::new(0.0, 0.0, p.z),
        ],
    ),
    (
        "shear",
        &[
            |p, _| Vector3::new(p.y, p.x, 0.0),
            |p, _| Vector3::new(p.z, 0.0, p.x),
            |p, _| Vector3::new(0.0, p.z, p.y),
        ],
    ),
    (
        "drift",
        &[
            |_, t| Vector3::new(t, 0.0, 0.0),
            |_, t| Vector3::new(0.0, t, 0.0),
            |_, t| Vector3::new(0.0, 0.0, t),
        ],
    ),
    (
        "sag",
        &[
            |p, _| Vector3::new(0.0, 0.0, p.x * p.x),
            |p, _| Vector3::new(0.0, 0.0, p.x * p.y),
            |p, _| Vector3::new(0.0, 0.0, p.y * p.y),
        ],
    ),
];

pub(crate) fn parameter(name: &str) -> Parameter {
    Parameter::new(name, "1", 1.0)
}

pub(crate) fn effect(id: &str, n: usize) -> Effect {
    let parameters = (0..n).map(|i| parameter(&format!("a{i}"))).collect();
    Effect::new(id, &format!("the effect {id}"), parameters)
}

/// A rigid frame fit of `points` with the usual catalogue and a bad-point candidate per point.
pub(crate) fn body(points: &[Vector3<f64>], errors: &[Vector3<f64>]) -> LinearModel {
    let n = points.len();
    let row = |i: usize| Row { observation: i / 3, component: i % 3, sigma: 1.0, reported: true };
    let group = |i: usize| Group { name: format!("P{i}"), role: Role::Fit };
    let layout = Layout {
        rows: (0..3 * n).map(row).collect(),
        observations: (0..n).collect(),
        groups: (0..n).map(group).collect(),
        unit: "mm".to_owned(),
        sigma_declared: false,
    };
    let mut model = LinearModel {
        declared: Declared::new(layout, Vec::new(), Vec::new()),
        residual: rows_3d(errors.iter().copied()),
        base: DMatrix::zeros(3 * n, 0),
        tangents: Vec::new(),
        extended: Vec::new(),
    };
    let base: Vec<_> = RIGID.iter().map(|(_, field)| column(points, *field)).collect();
    set_base(&mut model, &RIGID.map(|(name, _)| name), DMatrix::from_columns(&base));
    for (id, fields) in CATALOGUE {
        let columns: Vec<_> = fields.iter().map(|f| column(points, *f)).collect();
        push(&mut model, effect(id, fields.len()), DMatrix::from_columns(&columns));
    }
    for i in 0..n {
        let mut tangent = DMatrix::zeros(3 * n, 3);
        tangent.view_mut((3 * i, 0), (3, 3)).fill_with_identity();
        push(&mut model, effect("bad-point", 3).about(&format!("P{i}")), tangent);
    }
    model
}

pub(crate) fn coordinates(points: &[Vector3<f64>]) -> Vec<Covariate> {
    let axis = |k: usize| points.iter().map(|p| p[k]).collect();
    (0..3)
        .map(|k| {
            Covariate::coordinate(
                ["from_x_mm", "from_y_mm", "from_z_mm"][k],
                Quantity::Position,
                axis(k),
            )
        })
        .collect()
}

/// A model of scalars: one group each, no base parameters, effects by column.
pub(crate) fn scalars(data: &[f64], effects: &[(&str, Vec<f64>)]) -> LinearModel {
    let names = (0..data.len()).map(|i| i.to_string());
    let mut model = LinearModel {
        declared: Declared::new(Layout::scalars(names, "mm", None), Vec::new(), Vec::new()),
        residual: DVector::from_column_slice(data),
        base: DMatrix::zeros(data.len(), 0),
        tangents: Vec::new(),
        extended: Vec::new(),
    };
    for (id, column) in effects {
        push(&mut model, effect(id, 1), DMatrix::from_column_slice(data.len(), 1, column));
    }
    model
}

/// One normal deviate.
pub(crate) fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

/// A course of the first effect, as one more of the catalogue.
pub(crate) fn offer(model: &mut LinearModel, course: &Course, elapsed: &[f64], unit: &str) {
    let effect = course.effect(model, 0, elapsed, "s", (unit, 1.0));
    push(model, effect, DMatrix::from_vec(elapsed.len(), 1, course.come(elapsed)));
}
