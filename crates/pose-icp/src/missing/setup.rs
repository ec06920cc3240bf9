//! One clamping of the part: its pose near a reference, and what is known of its axis.

use nalgebra::DVector;

use crate::exact::{Chart, Whitened};
use crate::{PoseParameter, PoseStart};

/// The part as clamped once; its parameters are steps of the free ones from `reference`.
#[derive(Clone, Debug)]
pub(crate) struct Setup {
    pub(crate) reference: Chart,
    pub(crate) lateral: Option<Whitened>,
    /// Index of its first base parameter.
    pub(crate) first: usize,
}

impl Setup {
    pub(crate) fn new(
        reference: &PoseStart,
        pivot_mm: f64,
        lateral: Option<Whitened>,
        first: usize,
    ) -> Self {
        Self { reference: Chart::new(reference, pivot_mm), lateral, first }
    }

    /// The pose at base parameters, and with `extra` steps of all six.
    pub(crate) fn chart(&self, free: &[usize], base: &DVector<f64>, extra: &[f64; 6]) -> Chart {
        let mut step = *extra;
        for (k, &parameter) in free.iter().enumerate() {
            step[parameter] += base[self.first + k];
        }
        self.reference.stepped(&ALL, &step)
    }
}

const ALL: [usize; 6] = [0, 1, 2, 3, 4, 5];

/// `[x y z α β γ]`, mm and rad.
pub(crate) fn coordinates(pose: &PoseStart) -> [f64; 6] {
    let (at, angles) = (pose.position_mm, pose.angles);
    [at.x, at.y, at.z, angles.alpha_rad, angles.beta_rad, angles.gamma_rad]
}

/// Unit and factor in which a parameter is reported.
pub(crate) fn reported(parameter: PoseParameter) -> (&'static str, f64) {
    if parameter.is_angle() { ("µrad", 1e6) } else { ("mm", 1.0) }
}
