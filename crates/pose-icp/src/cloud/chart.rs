//! Poses about the start, as six numbers that can be held or have a prior.

use geometry::so3;
use nalgebra::{Isometry3, Matrix6, Point3, Translation3, Vector3, Vector6};

use super::options::{Freedom, RegisterOptions};

/// `T p = c + t + exp(ω) (T₀ p − c)`: shift `t` of the pivot `c`, rotation `ω` about it, start `T₀`.
///
/// Shift and rotation are apart, so that a pivot whose shift is held stays where it is.
#[derive(Clone, Debug)]
pub(crate) struct Chart {
    start: Isometry3<f64>,
    pub(crate) pivot: Point3<f64>,
    freedoms: [Freedom; 6],
    /// Free components.
    pub(crate) free: Vec<usize>,
}

impl Chart {
    pub(crate) fn new(options: &RegisterOptions, pivot: Point3<f64>) -> Self {
        let freedoms = options.freedoms;
        let free = (0..6).filter(|&k| freedoms[k] != Freedom::Held).collect();
        Self { start: options.start, pivot, freedoms, free }
    }

    pub(crate) fn pose(&self, xi: &Vector6<f64>) -> Isometry3<f64> {
        let (shift, turn) = parts(xi);
        let to_pivot = Translation3::from(-self.pivot.coords);
        let back = Translation3::from(self.pivot.coords + shift);
        let mut pose = back * so3::exp(&turn) * to_pivot * self.start;
        pose.rotation.renormalize();
        pose
    }

    /// Adds the priors as further rows of standard uncertainty `sigma_mm`.
    pub(crate) fn add_priors(
        &self,
        xi: &Vector6<f64>,
        sigma_mm: f64,
        hessian: &mut Matrix6<f64>,
        gradient: &mut Vector6<f64>,
    ) {
        for (k, freedom) in self.freedoms.iter().enumerate() {
            if let Freedom::Prior { sigma } = freedom {
                let weight = (sigma_mm / sigma).powi(2);
                hessian[(k, k)] += weight;
                gradient[k] += weight * xi[k];
            }
        }
    }
}

fn parts(xi: &Vector6<f64>) -> (Vector3<f64>, Vector3<f64>) {
    (xi.fixed_rows::<3>(0).into_owned(), xi.fixed_rows::<3>(3).into_owned())
}

/// Left perturbation about the pivot, by step of the six numbers: `[I, [t]× J; 0, J]`.
pub(crate) fn jacobian(xi: &Vector6<f64>) -> Matrix6<f64> {
    let (shift, turn) = parts(xi);
    let of_turn = so3::left_jacobian(&turn);
    let mut jacobian = Matrix6::identity();
    jacobian.fixed_view_mut::<3, 3>(0, 3).copy_from(&(shift.cross_matrix() * of_turn));
    jacobian.fixed_view_mut::<3, 3>(3, 3).copy_from(&of_turn);
    jacobian
}

/// Normal equations for a step of the six numbers, from those for a left perturbation.
pub(crate) fn pulled_back(
    xi: &Vector6<f64>,
    hessian: &Matrix6<f64>,
    gradient: &Vector6<f64>,
) -> (Matrix6<f64>, Vector6<f64>) {
    let jacobian = jacobian(xi);
    (jacobian.transpose() * hessian * jacobian, jacobian.transpose() * gradient)
}
