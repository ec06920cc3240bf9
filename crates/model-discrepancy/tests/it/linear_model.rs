//! A linear model with any base and any effects, and a plate of points to measure with it.

use model_discrepancy::{
    Condensed, Covariate, Effect, Group, Layout, Model, Origin, Parameter, Proposal, Role, Row,
    State,
};
use nalgebra::{DMatrix, DVector, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// `residual = data − base·θ − Σ effectₑ·aₑ`.
#[derive(Clone)]
pub(crate) struct LinearModel {
    pub(crate) layout: Layout,
    pub(crate) base_names: Vec<Parameter>,
    pub(crate) base: DMatrix<f64>,
    pub(crate) catalogue: Vec<Effect>,
    pub(crate) tangents: Vec<DMatrix<f64>>,
    pub(crate) data: DVector<f64>,
    pub(crate) directions: Option<Vec<Vector3<f64>>>,
    pub(crate) condensed: Vec<Condensed>,
    pub(crate) extended: Vec<(String, Box<LinearModel>)>,
}

impl Model for LinearModel {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn base(&self) -> &[Parameter] {
        &self.base_names
    }

    fn effects(&self) -> &[Effect] {
        &self.catalogue
    }

    fn start(&self) -> DVector<f64> {
        DVector::zeros(self.base.ncols())
    }

    fn residuals(&self, at: &State) -> DVector<f64> {
        let mut r = &self.data - &self.base * &at.base;
        for (tangent, amplitude) in self.tangents.iter().zip(&at.amplitudes) {
            r -= tangent * amplitude;
        }
        r
    }

    fn base_jacobian(&self, _: &State) -> DMatrix<f64> {
        -&self.base
    }

    fn tangent(&self, _: &State, effect: usize) -> DMatrix<f64> {
        -&self.tangents[effect]
    }

    fn directions(&self) -> Option<&[Vector3<f64>]> {
        self.directions.as_deref()
    }

    fn condensed(&self) -> &[Condensed] {
        &self.condensed
    }

    fn proposals(&self) -> Vec<Proposal> {
        let proposal = |(text, model): &(String, Box<LinearModel>)| Proposal {
            text: text.clone(),
            model: model.clone(),
        };
        self.extended.iter().map(proposal).collect()
    }
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
    Parameter { name: name.to_owned(), unit: "1".to_owned(), report_factor: 1.0 }
}

pub(crate) fn effect(id: &str, subject: Option<String>, n: usize) -> Effect {
    Effect {
        id: id.to_owned(),
        subject,
        description: format!("the effect {id}"),
        driver: None,
        searched: 1,
        parameters: (0..n).map(|i| parameter(&format!("a{i}"))).collect(),
    }
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
    let base: Vec<_> = RIGID.iter().map(|(_, field)| column(points, *field)).collect();
    let mut catalogue = Vec::new();
    let mut tangents = Vec::new();
    for (id, fields) in CATALOGUE {
        catalogue.push(effect(id, None, fields.len()));
        let columns: Vec<_> = fields.iter().map(|f| column(points, *f)).collect();
        tangents.push(DMatrix::from_columns(&columns));
    }
    for i in 0..n {
        catalogue.push(effect("bad-point", Some(format!("P{i}")), 3));
        let mut tangent = DMatrix::zeros(3 * n, 3);
        tangent.view_mut((3 * i, 0), (3, 3)).fill_with_identity();
        tangents.push(tangent);
    }
    LinearModel {
        layout,
        base_names: RIGID.iter().map(|(name, _)| parameter(name)).collect(),
        base: DMatrix::from_columns(&base),
        catalogue,
        tangents,
        data: rows_3d(errors.iter().copied()),
        directions: None,
        condensed: Vec::new(),
        extended: Vec::new(),
    }
}

pub(crate) fn coordinates(points: &[Vector3<f64>]) -> Vec<Covariate> {
    let axis = |k: usize| points.iter().map(|p| p[k]).collect();
    (0..3)
        .map(|k| Covariate {
            name: ["from_x_mm", "from_y_mm", "from_z_mm"][k].to_owned(),
            values: axis(k),
            origin: Origin::Coordinate,
        })
        .collect()
}

/// A model of scalars: one group each, no base parameters, effects by column.
pub(crate) fn scalars(data: &[f64], effects: &[(&str, Vec<f64>)]) -> LinearModel {
    let row = |i| Row { observation: i, component: 0, sigma: 1.0, reported: true };
    let group = |i: usize| Group { name: format!("{i}"), role: Role::Fit };
    LinearModel {
        layout: Layout {
            rows: (0..data.len()).map(row).collect(),
            observations: (0..data.len()).collect(),
            groups: (0..data.len()).map(group).collect(),
            unit: "mm".to_owned(),
            sigma_declared: false,
        },
        base_names: Vec::new(),
        base: DMatrix::zeros(data.len(), 0),
        catalogue: effects.iter().map(|(id, _)| effect(id, None, 1)).collect(),
        tangents: effects
            .iter()
            .map(|(_, column)| DMatrix::from_column_slice(data.len(), 1, column))
            .collect(),
        data: DVector::from_column_slice(data),
        directions: None,
        condensed: Vec::new(),
        extended: Vec::new(),
    }
}

/// One normal deviate.
pub(crate) fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}
