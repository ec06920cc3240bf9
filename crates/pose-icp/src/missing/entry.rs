//! An effect as the loop sees it, and what the catalogue depends on.

use model_discrepancy::{Covariate, Effect, Parameter, Scope};
use nalgebra::Vector3;

use super::form::Form;
use super::measured::MeasuredTouch;
use super::term::Term;
use crate::{Part, PoseParameter};

pub(super) const AXES: [&str; 3] = ["x", "y", "z"];

/// An effect as the loop sees it, and what it does.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(crate) effect: Effect,
    pub(crate) term: Term,
}

/// What the catalogue depends on.
pub(crate) struct Setting<'a> {
    pub(crate) part: &'a Part,
    pub(crate) held: &'a [PoseParameter],
    /// Held ones that are not in question.
    pub(crate) known: &'a [PoseParameter],
    pub(crate) touches: &'a [MeasuredTouch],
    pub(crate) covariates: &'a [Covariate],
    /// Whether the machine has axes that may be wrong.
    pub(crate) machine_axes: bool,
    /// Distance from the axis at which the heights of errors of form count.
    pub(crate) form_radius_mm: f64,
    /// Rotation of the part about its axis.
    pub(crate) gamma_rad: f64,
    /// Mean of the readings, machine frame.
    pub(crate) center_mm: Vector3<f64>,
    /// Normals at the contacts as declared, machine frame.
    pub(crate) normals: Vec<Vector3<f64>>,
    /// +1 or −1: the side of the part on which the ball is.
    pub(crate) side: f64,
    /// Mean squares of the normals' components, machine frame.
    pub(crate) normal_squares: Vector3<f64>,
    /// Root mean square of the normals' components times the height over the mean, machine frame.
    pub(crate) lateral_travel_mm: Vector3<f64>,
}

pub(super) fn entry(id: &str, description: &str, parameters: Vec<Parameter>, term: Term) -> Entry {
    let effect = Effect::new(id, description, parameters).within(scope(&term));
    Entry { effect, term }
}

/// What a term moves; touches in one plane, on one diameter or at 20 °C show nothing of some.
fn scope(term: &Term) -> Scope {
    match term {
        Term::BadPoint { observation } => Scope::Observation(*observation),
        Term::Tip | Term::Form(Form::VertexRadius | Form::Conic | Form::Focus) => Scope::Everywhere,
        _ => Scope::SomeDesigns,
    }
}

pub(super) fn parameter(name: &str, unit: &str, report_factor: f64) -> Parameter {
    Parameter { name: name.to_owned(), unit: unit.to_owned(), report_factor }
}
