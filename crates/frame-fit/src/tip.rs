//! Tip of a tool from poses of the flange that hold it at fixed places.
//!
//! Minimised over the tip t (flange frame) and the places c (base frame):
//! `Σ |p + R·t − c|² / σ² + Σ (|c_a − c_b| − d)² / σ_d²`. Without distances the places are means,
//! `c = mean(p + R·t)`, and t is the solution of three linear equations in the rotations about their
//! means; distances are taken in by Gauss-Newton steps from there.

use std::collections::HashMap;

use nalgebra::{DMatrix, DVector, Matrix3, SymmetricEigen, UnitQuaternion, Vector3};

use crate::FrameFitError;
use crate::input::LARGEST_COORDINATE_MM;

/// Spread of the rotations below which a direction of the tip is taken as not observed, rad: a
/// quaternion printed with four digits is no better.
const MIN_TURN_RAD: f64 = 1e-4;
/// Steps after which distances that contradict each other are given up.
const MAX_STEPS: usize = 50;
/// A step this small beside the extent of the places changes nothing that is printed.
const STEP_TOL: f64 = 1e-12;

/// A pose of the flange, its tip at a place.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TipPose {
    /// Name of the place.
    pub place: String,
    /// Origin of the flange, base frame.
    pub position_mm: Vector3<f64>,
    /// From the flange's axes to those of the base.
    pub rotation: UnitQuaternion<f64>,
}

/// A distance between two places that is known from elsewhere.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct KnownDistance {
    /// One place.
    pub from: String,
    /// The other.
    pub to: String,
    /// The distance.
    pub distance_mm: f64,
    /// Its standard uncertainty.
    pub sigma_mm: f64,
}

/// Tip and places, fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct TipFit {
    /// Tip in the flange's frame.
    pub tip_mm: Vector3<f64>,
    /// Name and position of every place, base frame, in the order first touched.
    pub places: Vec<(String, Vector3<f64>)>,
    /// Covariance of the tip, then of every place, mm²; of `sigma_mm`.
    pub covariance: DMatrix<f64>,
    /// `p + R·t − c` of every pose, base frame.
    pub residuals_mm: Vec<Vector3<f64>>,
    /// Found minus known, of every distance.
    pub distance_errors_mm: Vec<f64>,
    /// Standard uncertainty of one coordinate: as given, else estimated from the residual.
    pub sigma_mm: f64,
    /// Observations less unknowns.
    pub degrees_of_freedom: usize,
    /// Weighted sum of squares.
    pub chi2: f64,
}

/// Fits tip and places to poses, each coordinate known to `sigma_mm`; `None`: the residual tells.
///
/// # Errors
///
/// [`FrameFitError::InvalidPose`], [`FrameFitError::InvalidDistance`],
/// [`FrameFitError::TooFewPoses`], [`FrameFitError::TipFree`] where all rotations are about one
/// direction, and [`FrameFitError::NotConverged`] where distances contradict each other.
pub fn fit_tip(
    poses: &[TipPose],
    distances: &[KnownDistance],
    sigma_mm: Option<f64>,
) -> Result<TipFit, FrameFitError> {
    let design = Design::of(poses, distances)?;
    let start = design.closed_form(&vec![1.0; poses.len()])?;
    let rows = 3 * poses.len();
    let redundancy = rows.saturating_sub(start.len());
    if redundancy == 0 {
        return Err(FrameFitError::TooFewPoses { needed: start.len() / 3 + 1, got: poses.len() });
    }
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let estimated =
        || (design.misses(&start).norm_squared() / redundancy as f64).sqrt().max(f64::EPSILON);
    let sigma_mm = sigma_mm.unwrap_or_else(estimated);
    let (x, covariance) = design.refined(start, sigma_mm)?;
    let misses = design.misses(&x);
    let distance_errors_mm = design.distance_errors_mm(&x);
    let weighted = design.distances.iter().zip(&distance_errors_mm);
    let chi2 = misses.norm_squared() / sigma_mm.powi(2)
        + weighted.map(|(d, error)| (error / d.sigma_mm).powi(2)).sum::<f64>();
    let place = |(k, name): (usize, &String)| (name.clone(), place_mm(&x, k));
    Ok(TipFit {
        tip_mm: x.fixed_rows::<3>(0).into_owned(),
        places: design.names.iter().enumerate().map(place).collect(),
        covariance,
        residuals_mm: (0..poses.len())
            .map(|i| misses.fixed_rows::<3>(3 * i).into_owned())
            .collect(),
        distance_errors_mm,
        sigma_mm,
        degrees_of_freedom: rows + distances.len() - x.len(),
        chi2,
    })
}

/// A distance with its places as numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Between {
    pub(crate) places: [usize; 2],
    pub(crate) distance_mm: f64,
    pub(crate) sigma_mm: f64,
}

impl Between {
    /// Derivative of a distance by all unknowns.
    pub(crate) fn row(&self, x: &DVector<f64>) -> DVector<f64> {
        let [a, b] = self.places;
        let apart = place_mm(x, a) - place_mm(x, b);
        // Places that coincide are moved apart along any axis.
        let along = apart.try_normalize(0.0).unwrap_or_else(Vector3::x);
        let mut row = DVector::zeros(x.len());
        row.fixed_rows_mut::<3>(3 + 3 * a).copy_from(&along);
        row.fixed_rows_mut::<3>(3 + 3 * b).copy_from(&-along);
        row
    }
}

/// Poses with their rotations as matrices and their places as numbers.
#[derive(Clone, Debug)]
pub(crate) struct Design {
    pub(crate) names: Vec<String>,
    /// Place of every pose.
    pub(crate) at: Vec<usize>,
    pub(crate) positions_mm: Vec<Vector3<f64>>,
    pub(crate) rotations: Vec<Matrix3<f64>>,
    pub(crate) distances: Vec<Between>,
}

impl Design {
    pub(crate) fn of(
        poses: &[TipPose],
        distances: &[KnownDistance],
    ) -> Result<Self, FrameFitError> {
        let usable = |v: &f64| v.is_finite() && v.abs() <= LARGEST_COORDINATE_MM;
        let mut names: Vec<String> = Vec::new();
        let mut numbers: HashMap<&str, usize> = HashMap::new();
        let mut at = Vec::with_capacity(poses.len());
        for (index, pose) in poses.iter().enumerate() {
            let turned = pose.rotation.coords.iter().all(|v| v.is_finite());
            if !turned || !pose.position_mm.iter().all(usable) {
                return Err(FrameFitError::InvalidPose { index });
            }
            at.push(*numbers.entry(&pose.place).or_insert_with(|| {
                names.push(pose.place.clone());
                names.len() - 1
            }));
        }
        let between = |(index, known): (usize, &KnownDistance)| {
            let positive = |v: f64| usable(&v) && v > 0.0;
            let places = (numbers.get(&*known.from)).zip(numbers.get(&*known.to));
            match places {
                Some((a, b))
                    if a != b && positive(known.distance_mm) && positive(known.sigma_mm) =>
                {
                    let (distance_mm, sigma_mm) = (known.distance_mm, known.sigma_mm);
                    Ok(Between { places: [*a, *b], distance_mm, sigma_mm })
                }
                _ => Err(FrameFitError::InvalidDistance { index }),
            }
        };
        Ok(Self {
            distances: distances.iter().enumerate().map(between).collect::<Result<_, _>>()?,
            at,
            positions_mm: poses.iter().map(|p| p.position_mm).collect(),
            rotations: poses.iter().map(|p| p.rotation.to_rotation_matrix().into_inner()).collect(),
            names,
        })
    }

    /// Tip, then places, without the distances, every pose with its weight.
    pub(crate) fn closed_form(&self, weights: &[f64]) -> Result<DVector<f64>, FrameFitError> {
        let places = self.names.len();
        let mut counts = vec![0.0; places];
        let mut mean_rotations = vec![Matrix3::zeros(); places];
        let mut mean_positions = vec![Vector3::zeros(); places];
        for (i, &k) in self.at.iter().enumerate() {
            counts[k] += weights[i];
            mean_rotations[k] += weights[i] * self.rotations[i];
            mean_positions[k] += weights[i] * self.positions_mm[i];
        }
        mean_rotations.iter_mut().zip(&counts).for_each(|(sum, n)| *sum /= *n);
        mean_positions.iter_mut().zip(&counts).for_each(|(sum, n)| *sum /= *n);
        let (mut turned, mut moved) = (Matrix3::zeros(), Vector3::zeros());
        for (i, &k) in self.at.iter().enumerate() {
            let rotation = self.rotations[i] - mean_rotations[k];
            turned += weights[i] * rotation.transpose() * rotation;
            moved += weights[i] * rotation.transpose() * (self.positions_mm[i] - mean_positions[k]);
        }
        let total: f64 = counts.iter().sum();
        let eigen = SymmetricEigen::new(turned);
        let free = eigen.eigenvalues.imin();
        let spread_rad = (eigen.eigenvalues[free].max(0.0) / total.max(f64::MIN_POSITIVE)).sqrt();
        if spread_rad < MIN_TURN_RAD {
            let direction = eigen.eigenvectors.column(free);
            let direction = [direction[0], direction[1], direction[2]];
            return Err(FrameFitError::TipFree { direction, spread_rad });
        }
        let tip = eigen.eigenvectors
            * (eigen.eigenvectors.transpose() * -moved).component_div(&eigen.eigenvalues);
        let mut x = DVector::zeros(3 + 3 * places);
        x.fixed_rows_mut::<3>(0).copy_from(&tip);
        for (k, (position, rotation)) in mean_positions.iter().zip(&mean_rotations).enumerate() {
            x.fixed_rows_mut::<3>(3 + 3 * k).copy_from(&(position + rotation * tip));
        }
        Ok(x)
    }

    /// The minimum with the distances, and the covariance there.
    fn refined(
        &self,
        mut x: DVector<f64>,
        sigma_mm: f64,
    ) -> Result<(DVector<f64>, DMatrix<f64>), FrameFitError> {
        for _ in 0..MAX_STEPS {
            let (normal, gradient) = self.normal(&x, sigma_mm);
            // Rotations that determine the tip determine everything.
            let Some(factor) = normal.cholesky() else { break };
            let step = factor.solve(&gradient);
            x -= &step;
            if self.distances.is_empty() || step.amax() <= STEP_TOL * x.amax().max(1.0) {
                return Ok((x, factor.inverse()));
            }
        }
        let cost = 0.5 * self.misses(&x).norm_squared() / sigma_mm.powi(2);
        Err(FrameFitError::NotConverged { iterations: MAX_STEPS, cost })
    }

    /// Normal matrix and gradient of half the weighted sum of squares.
    fn normal(&self, x: &DVector<f64>, sigma_mm: f64) -> (DMatrix<f64>, DVector<f64>) {
        let weight = sigma_mm.powi(-2);
        let misses = self.misses(x);
        let mut normal = DMatrix::zeros(x.len(), x.len());
        let mut gradient = DVector::zeros(x.len());
        for (i, &k) in self.at.iter().enumerate() {
            let (rotation, c) = (&self.rotations[i], 3 + 3 * k);
            let miss = misses.fixed_rows::<3>(3 * i).into_owned();
            for axis in 0..3 {
                normal[(axis, axis)] += weight;
                normal[(c + axis, c + axis)] += weight;
            }
            let mut across = normal.fixed_view_mut::<3, 3>(0, c);
            across -= weight * rotation.transpose();
            let mut across = normal.fixed_view_mut::<3, 3>(c, 0);
            across -= weight * rotation;
            let mut of_tip = gradient.fixed_rows_mut::<3>(0);
            of_tip += weight * (rotation.transpose() * miss);
            let mut of_place = gradient.fixed_rows_mut::<3>(c);
            of_place -= weight * miss;
        }
        for (between, error) in self.distances.iter().zip(self.distance_errors_mm(x)) {
            let weight = between.sigma_mm.powi(-2);
            let row = between.row(x);
            normal += weight * (&row * row.transpose());
            gradient += weight * error * row;
        }
        (normal, gradient)
    }

    /// `p + R·t − c`, three per pose.
    pub(crate) fn misses(&self, x: &DVector<f64>) -> DVector<f64> {
        let tip = x.fixed_rows::<3>(0).into_owned();
        let mut misses = DVector::zeros(3 * self.at.len());
        for (i, &k) in self.at.iter().enumerate() {
            let miss = self.positions_mm[i] - place_mm(x, k) + self.rotations[i] * tip;
            misses.fixed_rows_mut::<3>(3 * i).copy_from(&miss);
        }
        misses
    }

    /// Found minus known.
    pub(crate) fn distance_errors_mm(&self, x: &DVector<f64>) -> Vec<f64> {
        let error = |b: &Between| {
            (place_mm(x, b.places[0]) - place_mm(x, b.places[1])).norm() - b.distance_mm
        };
        self.distances.iter().map(error).collect()
    }
}

/// Position of a place among the unknowns.
pub(crate) fn place_mm(x: &DVector<f64>, place: usize) -> Vector3<f64> {
    x.fixed_rows::<3>(3 + 3 * place).into_owned()
}
