//! Whitened equations of a pose problem.

use geometry::{Foot, GeometryError};
use nalgebra::{Matrix2, Point2, Vector3};

use super::chart::Chart;
use super::triangle::{Block, MAX, Triangle};
use crate::{LateralPrior, Part, PoseError, PoseStart, Tip, Touch};

/// Everything the equations depend on but the pose.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Equations<'a> {
    pub(crate) part: &'a Part,
    pub(crate) touches: &'a [Touch],
    pub(crate) tip: Tip,
    pub(crate) lateral: Option<Whitened>,
    /// Indices of the parameters that are not held, ascending.
    pub(crate) free: Free,
}

/// Indices of free parameters, without memory of its own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Free {
    indices: [usize; MAX],
    count: usize,
}

impl Free {
    pub(crate) fn of(is_free: impl Fn(usize) -> bool) -> Self {
        let mut free = Self { indices: [0; MAX], count: 0 };
        for index in (0..MAX).filter(|&i| is_free(i)) {
            free.indices[free.count] = index;
            free.count += 1;
        }
        free
    }

    pub(crate) fn as_slice(&self) -> &[usize] {
        &self.indices[..self.count]
    }
}

/// A lateral prior with the inverse of its covariance's lower factor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Whitened {
    pub(crate) prior: LateralPrior,
    pub(crate) whitener: Matrix2<f64>,
}

impl Whitened {
    pub(crate) fn new(prior: &LateralPrior) -> Result<Self, PoseError> {
        let invalid = |value| PoseError::InvalidOption {
            name: "covariance of the lateral position",
            needed: "positive definite",
            value,
        };
        let covariance = prior.covariance_mm2;
        let determinant = covariance.determinant();
        let factor = covariance.cholesky().ok_or_else(|| invalid(determinant))?;
        let whitener = factor.l().try_inverse().ok_or_else(|| invalid(determinant))?;
        for value in [prior.at_z_mm, prior.center_mm.x, prior.center_mm.y] {
            if !value.is_finite() {
                let (name, needed) = ("lateral position", "finite");
                return Err(PoseError::InvalidOption { name, needed, value });
            }
        }
        Ok(Self { prior: *prior, whitener })
    }

    /// The same knowledge of another clamping, whose axis is where `pose` has it.
    pub(crate) fn moved_to(mut self, pose: &PoseStart) -> Self {
        let axis = pose.machine_from_workpiece().rotation * Vector3::z();
        let down_mm = self.prior.at_z_mm - pose.position_mm.z;
        self.prior.center_mm = Point2::from(pose.position_mm.xy() + axis.xy() * (down_mm / axis.z));
        self
    }

    pub(crate) fn equations(&self, at: &Chart) -> [([f64; MAX], f64); 2] {
        let (off, rows) = at.lateral(&self.prior);
        let w = &self.whitener;
        let first = (rows[0].map(|v| v * w[(0, 0)]), off[0] * w[(0, 0)]);
        let mut second = [0.0; MAX];
        for (k, value) in second.iter_mut().enumerate() {
            *value = w[(1, 0)] * rows[0][k] + w[(1, 1)] * rows[1][k];
        }
        [first, (second, w[(1, 0)] * off[0] + w[(1, 1)] * off[1])]
    }
}

/// The equations at one pose, reduced.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Linearised {
    pub(crate) triangle: Triangle,
    /// Half the sum of squares of the whitened residuals.
    pub(crate) cost: f64,
}

impl Equations<'_> {
    /// Reduces the equations at `at` and leaves the touches' feet in `feet`; fails with the index
    /// of a touch that has none.
    pub(crate) fn linearise(
        &self,
        at: &Chart,
        feet: &mut Vec<Foot>,
    ) -> Result<Linearised, (usize, GeometryError)> {
        feet.clear();
        for (index, touch) in self.touches.iter().enumerate() {
            let foot = self.part.surface().closest_point(&at.in_workpiece(&touch.center_mm));
            feet.push(foot.map_err(|source| (index, source))?);
        }
        Ok(self.reduce(at, feet))
    }

    /// The same where the feet are known; `at` may be any chart of their pose.
    pub(crate) fn reduce(&self, at: &Chart, feet: &[Foot]) -> Linearised {
        let free = self.free.as_slice();
        let mut triangle = Triangle::new(free.len());
        let mut block = Block::new();
        let mut twice_cost = 0.0;
        let mut push = |row: &[f64; MAX], residual: f64| {
            let mut packed = [0.0; MAX + 1];
            for (k, &parameter) in free.iter().enumerate() {
                packed[k] = row[parameter];
            }
            packed[MAX] = residual;
            block.push(&packed);
            if block.is_full() {
                triangle.take(&mut block);
            }
            twice_cost += residual * residual;
        };
        let target_mm = self.tip.signed_radius_mm();
        for (touch, foot) in self.touches.iter().zip(feet) {
            let normal = at.direction_to_machine(&foot.normal);
            let weight = touch.sigma_mm.recip();
            let row = at.distance_row(&touch.center_mm, &normal).map(|v| v * weight);
            push(&row, (foot.signed_distance_mm - target_mm) * weight);
        }
        for (row, residual) in self.lateral.iter().flat_map(|l| l.equations(at)) {
            push(&row, residual);
        }
        triangle.take(&mut block);
        Linearised { triangle, cost: 0.5 * twice_cost }
    }

    /// `Σ r ∂²r/∂²` of the free parameters, upper triangle: what Gauss-Newton leaves out.
    ///
    /// Where the asphericity that shows a tilt is as small as the noise it decides convergence.
    pub(crate) fn second_order(&self, at: &Chart, feet: &[Foot]) -> [[f64; MAX]; MAX] {
        let target_mm = self.tip.signed_radius_mm();
        let mut second = [[0.0; MAX]; MAX];
        for (touch, foot) in self.touches.iter().zip(feet) {
            let normal = at.direction_to_machine(&foot.normal);
            let pull = (foot.signed_distance_mm - target_mm) / touch.sigma_mm.powi(2);
            at.add_turning(&touch.center_mm, &normal, pull, &mut second);
            self.add_bend(at, touch, foot, pull, &mut second);
        }
        packed(&second, self.free.as_slice())
    }

    /// The part of the second derivative that comes from the surface's curvature:
    /// `∇²distance = −Σ κ/(1 − κ d) t tᵀ` over the principal directions.
    fn add_bend(
        &self,
        at: &Chart,
        touch: &Touch,
        foot: &Foot,
        pull: f64,
        out: &mut [[f64; MAX]; MAX],
    ) {
        // Without a curvature (a vertex of a mesh) Gauss-Newton has to do.
        let Ok(curvature) = self.part.surface().curvature(&foot.point_mm) else { return };
        let principal = [
            (curvature.major_per_mm, curvature.major_direction),
            (curvature.minor_per_mm, curvature.minor_direction),
        ];
        for (per_mm, direction) in principal {
            let tangent = at.direction_to_machine(&direction);
            let row = at.distance_row(&touch.center_mm, &tangent);
            let bend = -pull * per_mm / (1.0 - per_mm * foot.signed_distance_mm);
            for i in 0..MAX {
                for j in i..MAX {
                    out[i][j] += bend * row[i] * row[j];
                }
            }
        }
    }
}

fn packed(full: &[[f64; MAX]; MAX], free: &[usize]) -> [[f64; MAX]; MAX] {
    let mut packed = [[0.0; MAX]; MAX];
    for (i, &a) in free.iter().enumerate() {
        for (j, &b) in free.iter().enumerate().skip(i) {
            packed[i][j] = full[a][b];
        }
    }
    packed
}
