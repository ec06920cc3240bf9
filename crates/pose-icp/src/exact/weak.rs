use std::fmt;

use nalgebra::{DMatrix, Matrix6};

use super::singular::{Singular, singular};
use super::triangle::{MAX, Triangle};
use crate::PoseParameter;

/// A motion of the workpiece that the touches hardly show.
#[derive(Clone, Debug, PartialEq)]
pub struct WeakMotion {
    /// Singular value over the largest, with angles measured by the travel they cause at the
    /// touches; 0 for a motion that changes nothing at all.
    pub relative_singular_value: f64,
    /// Parameters that take part, the one that moves the touches most first.
    pub components: Vec<WeakComponent>,
}

/// Share of one parameter in a weak direction.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct WeakComponent {
    /// Which.
    pub parameter: PoseParameter,
    /// Change of it along the direction, mm or rad; the largest travel is 1 mm.
    pub step: f64,
    /// Standard uncertainty of the parameter, mm or rad; `None` where it is unbounded or unknown.
    pub sigma: Option<f64>,
}

/// Below this share of the largest singular value a direction is called weak: 1 µm of noise
/// becomes more than 0.1 mm of travel.
const WEAK: f64 = 1e-2;
/// Below this share a direction is free; surfaces are evaluated to some 1e-13 mm.
const FREE: f64 = 1e-9;
/// Travels below this, of a largest of 1, are not named: tilting a shallow mirror about its far
/// centre of curvature moves it sideways by some twenty times the travel of the tilt.
const MIN_SHARE: f64 = 0.01;

/// Singular values of the whitened Jacobian, angles scaled by `travel_mm`, and weak directions.
///
/// `triangle` is that of the chart with its pivot in the workpiece's origin.
pub(crate) struct Spectrum {
    /// Descending; whitened travel per mm, 1/mm times mm.
    pub(crate) singular_values: Vec<f64>,
    pub(crate) weak: Vec<WeakMotion>,
    pub(crate) free: Vec<WeakMotion>,
}

impl Spectrum {
    pub(crate) fn of(triangle: &Triangle, free: &[usize], travel_mm: f64) -> Self {
        let n = free.len();
        if n == 0 {
            return Self { singular_values: Vec::new(), weak: Vec::new(), free: Vec::new() };
        }
        let scale = |k: usize| if free[k] < 3 { 1.0 } else { travel_mm };
        let mut scaled = [[0.0; MAX]; MAX];
        for (i, row) in scaled[..n].iter_mut().enumerate() {
            for (j, value) in row[..n].iter_mut().enumerate() {
                *value = triangle.entry(i, j) / scale(j);
            }
        }
        let Singular { values, directions: found } = singular(&scaled, n);
        let singular_values = values[..n].to_vec();
        let largest = singular_values.first().copied().unwrap_or(0.0);
        let ratio = |i: usize| if largest > 0.0 { singular_values[i] / largest } else { 0.0 };
        let named = |range: std::ops::Range<usize>| {
            if range.is_empty() {
                return Vec::new();
            }
            let ratios: Vec<f64> = range.clone().map(ratio).collect();
            let basis = DMatrix::from_fn(n, range.len(), |k, i| found[range.start + i][k]);
            directions(&least_squares::sparse_basis(basis), &ratios, free, &scale)
        };
        let first_weak = (0..n).find(|&i| ratio(i) <= WEAK).unwrap_or(n);
        let first_free = (0..n).find(|&i| ratio(i) <= FREE).unwrap_or(n);
        let (weak, unseen) = (named(first_weak..first_free), named(first_free..n));
        Self { singular_values, weak, free: unseen }
    }
}

/// Names of the columns of `basis`, whose rows are travels of the free parameters.
fn directions(
    basis: &DMatrix<f64>,
    ratios: &[f64],
    free: &[usize],
    scale: &impl Fn(usize) -> f64,
) -> Vec<WeakMotion> {
    let of = |(shares, &relative_singular_value): (nalgebra::DVectorView<'_, f64>, &f64)| {
        let mut named: Vec<usize> =
            (0..free.len()).filter(|&k| shares[k].abs() >= MIN_SHARE * shares.amax()).collect();
        named.sort_by(|&a, &b| shares[b].abs().total_cmp(&shares[a].abs()));
        let largest = named.first().map_or(1.0, |&k| shares[k]);
        let component = |&k: &usize| WeakComponent {
            parameter: PoseParameter::ALL[free[k]],
            step: shares[k] / largest / scale(k),
            sigma: None,
        };
        let components = named.iter().map(component).collect();
        WeakMotion { relative_singular_value, components }
    };
    basis.column_iter().zip(ratios).map(of).collect()
}

/// `R⁻¹ R⁻ᵀ`, held parameters filled in with zeros; `None` where `R` is singular.
pub(crate) fn covariance(triangle: &Triangle, free: &[usize]) -> Option<Matrix6<f64>> {
    let n = free.len();
    // Columns of R⁻¹.
    let mut columns = [[0.0; MAX]; MAX];
    for (j, column) in columns[..n].iter_mut().enumerate() {
        for i in (0..=j).rev() {
            let pivot = triangle.entry(i, i);
            if pivot == 0.0 {
                return None;
            }
            let known: f64 = (i + 1..=j).map(|k| triangle.entry(i, k) * column[k]).sum();
            column[i] = (f64::from(u8::from(i == j)) - known) / pivot;
        }
    }
    let mut covariance = Matrix6::zeros();
    for (i, &a) in free.iter().enumerate() {
        for (j, &b) in free.iter().enumerate() {
            covariance[(a, b)] = columns[..n].iter().map(|column| column[i] * column[j]).sum();
        }
    }
    Some(covariance)
}

impl WeakMotion {
    /// Enters the uncertainties of the parameters.
    pub(crate) fn with_sigmas(mut self, sigma: impl Fn(PoseParameter) -> Option<f64>) -> Self {
        for component in &mut self.components {
            component.sigma = sigma(component.parameter);
        }
        self
    }
}

impl fmt::Display for WeakMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, component) in self.components.iter().enumerate() {
            let name = component.parameter.words();
            write!(f, "{}{name}", if i == 0 { "" } else { " with " })?;
            let unit = if component.parameter.is_angle() { "mrad" } else { "mm" };
            let factor = if component.parameter.is_angle() { 1e3 } else { 1.0 };
            if let Some(sigma) = component.sigma {
                write!(f, " (standard uncertainty {:.3} {unit})", sigma * factor)?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The part that moves the touches most makes a travel of 1 mm, the others in proportion; angles are
    /// travels over the arm, and what is under a hundredth of the largest is not named.
    #[test]
    fn a_direction_is_named_by_its_largest_travels() {
        let arm_mm = 32.0;
        let scale = |k: usize| if k == 0 { 1.0 } else { arm_mm };
        // Parameters X, alpha, beta and gamma: powers of two are exact.
        let free = [0, 3, 4, 5];
        let basis = DMatrix::from_column_slice(4, 1, &[0.5, -4.0, 0.031_25, 2.0]);
        let named = directions(&basis, &[1e-3], &free, &scale);
        assert_eq!(named.len(), 1);
        assert_eq!(named[0].relative_singular_value.to_bits(), 1e-3f64.to_bits());
        let parts: Vec<_> = named[0].components.iter().map(|c| (c.parameter, c.step)).collect();
        let expected = [(3, 1.0 / arm_mm), (5, -0.5 / arm_mm), (0, -0.125)];
        assert_eq!(parts, expected.map(|(k, step)| (PoseParameter::ALL[k], step)));
    }
}
