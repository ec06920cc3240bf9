//! A pose on its way, and how the distance of a touch from the surface changes with it.

use geometry::EulerAngles;
use nalgebra::{Matrix3, Matrix6, Point3, Vector3};

use super::triangle::MAX;
use crate::{LateralPrior, PoseParameter, PoseStart};

/// A pose as `[mx my mz α β γ]`, `m` being the image of the pivot `(0, 0, h)` of the workpiece.
///
/// With the pivot in the centre of curvature a tilt hardly changes the distances, and what it
/// does change is nearly linear: the valley in which tilt and decentre cancel runs straight.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chart {
    pub(crate) pivot_mm: f64,
    pub(crate) image_mm: Vector3<f64>,
    pub(crate) angles: EulerAngles,
    rotation: Matrix3<f64>,
    /// Axes in the machine frame about which α, β and γ turn.
    turning: Matrix3<f64>,
}

impl Chart {
    pub(crate) fn new(start: &PoseStart, pivot_mm: f64) -> Self {
        let mut chart = Self {
            pivot_mm,
            image_mm: start.position_mm,
            angles: start.angles,
            rotation: Matrix3::identity(),
            turning: Matrix3::identity(),
        };
        chart.turn(start.angles);
        chart.image_mm += chart.arm_mm();
        chart
    }

    fn turn(&mut self, angles: EulerAngles) {
        let (sa, ca) = angles.alpha_rad.sin_cos();
        let (sb, cb) = angles.beta_rad.sin_cos();
        let (sg, cg) = angles.gamma_rad.sin_cos();
        self.angles = angles;
        self.rotation = Matrix3::new(
            cg * cb,
            cg * sb * sa - sg * ca,
            cg * sb * ca + sg * sa,
            sg * cb,
            sg * sb * sa + cg * ca,
            sg * sb * ca - cg * sa,
            -sb,
            cb * sa,
            cb * ca,
        );
        // Columns: Rz Ry x, Rz y, z.
        self.turning = Matrix3::new(cg * cb, -sg, 0.0, sg * cb, cg, 0.0, -sb, 0.0, 1.0);
    }

    /// From the workpiece's origin to the image of the pivot.
    fn arm_mm(&self) -> Vector3<f64> {
        self.axis() * self.pivot_mm
    }

    /// The workpiece's z axis in the machine frame.
    pub(crate) fn axis(&self) -> Vector3<f64> {
        self.rotation.column(2).into_owned()
    }

    pub(crate) fn pose(&self) -> PoseStart {
        PoseStart { position_mm: self.image_mm - self.arm_mm(), angles: self.angles }
    }

    /// The chart with the pivot at the workpiece's origin.
    pub(crate) fn at_origin(&self) -> Self {
        Self { pivot_mm: 0.0, image_mm: self.image_mm - self.arm_mm(), ..*self }
    }

    pub(crate) fn in_workpiece(&self, machine_mm: &Point3<f64>) -> Point3<f64> {
        let mut point = self.rotation.tr_mul(&(machine_mm.coords - self.image_mm));
        point.z += self.pivot_mm;
        Point3::from(point)
    }

    pub(crate) fn direction_to_machine(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * direction
    }

    /// `∂ distance / ∂ [m α β γ]` of a touch whose foot has the normal `normal` (machine frame).
    pub(crate) fn distance_row(
        &self,
        center_mm: &Point3<f64>,
        normal: &Vector3<f64>,
    ) -> [f64; MAX] {
        let moment = normal.cross(&(center_mm.coords - self.image_mm));
        let turned = self.turning.tr_mul(&moment);
        [-normal.x, -normal.y, -normal.z, turned.x, turned.y, turned.z]
    }

    /// Adds `weight · ∂² distance / ∂ [m α β γ]²`, upper triangle, apart from the surface's bend.
    ///
    /// The point travels `φ × δm + ½ φ × (φ × v)` in second order, `v` from the pivot's image, and
    /// Euler angles follow each other.
    pub(crate) fn add_turning(
        &self,
        center_mm: &Point3<f64>,
        normal: &Vector3<f64>,
        weight: f64,
        out: &mut [[f64; MAX]; MAX],
    ) {
        let v = center_mm.coords - self.image_mm;
        let moment = normal.cross(&v);
        let axes = [0, 1, 2].map(|j| self.turning.column(j).into_owned());
        for (j, axis) in axes.iter().enumerate() {
            let mixed = normal.cross(axis);
            for k in 0..3 {
                out[k][3 + j] += weight * mixed[k];
            }
            for (i, other) in axes.iter().enumerate().take(j + 1) {
                let bent = 0.5
                    * (normal.dot(other) * axis.dot(&v) + normal.dot(axis) * other.dot(&v))
                    - normal.dot(&v) * other.dot(axis);
                let order = if i < j { 0.5 * axis.cross(other).dot(&moment) } else { 0.0 };
                out[3 + i][3 + j] += weight * (bent + order);
            }
        }
    }

    /// Where the axis passes the plane of `prior` less where it should, and its derivative.
    pub(crate) fn lateral(&self, prior: &LateralPrior) -> ([f64; 2], [[f64; MAX]; 2]) {
        let axis = self.axis();
        let lean = axis.xy() / axis.z;
        let down_mm = prior.at_z_mm - self.image_mm.z;
        let off = self.image_mm.xy() + lean * down_mm - prior.center_mm.coords;
        let mut rows = [[0.0; MAX]; 2];
        for (k, row) in rows.iter_mut().enumerate() {
            row[k] = 1.0;
            row[2] = -lean[k];
            for (j, turning) in self.turning.column_iter().enumerate() {
                let change = turning.cross(&axis);
                row[3 + j] = down_mm * (change[k] - lean[k] * change.z) / axis.z;
            }
        }
        ([off.x, off.y], rows)
    }

    /// The chart after a step of the `free` parameters.
    pub(crate) fn stepped(&self, free: &[usize], step: &[f64; MAX]) -> Self {
        let mut next = *self;
        let mut angles = self.angles;
        for (&parameter, &value) in free.iter().zip(step) {
            match PoseParameter::ALL[parameter] {
                PoseParameter::X => next.image_mm.x += value,
                PoseParameter::Y => next.image_mm.y += value,
                PoseParameter::Z => next.image_mm.z += value,
                PoseParameter::Alpha => angles.alpha_rad += value,
                PoseParameter::Beta => angles.beta_rad += value,
                PoseParameter::Gamma => angles.gamma_rad += value,
            }
        }
        next.turn(angles);
        next
    }

    /// `∂ [x y z α β γ] / ∂ [m α β γ]`: from this chart to the pose's own numbers.
    pub(crate) fn pose_jacobian(&self) -> Matrix6<f64> {
        let mut jacobian = Matrix6::identity();
        let arm = self.arm_mm();
        for (j, turning) in self.turning.column_iter().enumerate() {
            jacobian.fixed_view_mut::<3, 1>(0, 3 + j).copy_from(&-turning.cross(&arm));
        }
        jacobian
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Central differences over 1e-4 of rows of 60 mm: the third derivative leaves 60 · 1e-8 / 6, and
    /// rounding 60 · 2⁻⁵² / 1e-4.
    const DIFFERENCE_TOL: f64 = 1e-6;

    /// Of a plane of the workpiece the distance is linear in the point, and nothing bends but the motion.
    #[test]
    fn turning_twice_is_the_derivative_of_the_row() {
        let center_mm = Point3::new(42.0, -17.0, 30.0);
        let of_part = Vector3::new(0.3, -0.5, 0.8).normalize();
        let parameters = [4.0, -3.0, 7.0, 0.2, -0.35, 0.6];
        let at = |p: [f64; 6]| {
            let angles = EulerAngles { alpha_rad: p[3], beta_rad: p[4], gamma_rad: p[5] };
            let start = PoseStart { position_mm: Vector3::zeros(), angles };
            Chart { image_mm: Vector3::new(p[0], p[1], p[2]), ..Chart::new(&start, 20.0) }
        };
        let row = |p: [f64; 6]| {
            let chart = at(p);
            chart.distance_row(&center_mm, &chart.direction_to_machine(&of_part))
        };
        let (mut second, weight) = ([[0.0; MAX]; MAX], 1.5);
        let chart = at(parameters);
        let normal = chart.direction_to_machine(&of_part);
        chart.add_turning(&center_mm, &normal, weight, &mut second);
        let step = 1e-4;
        for i in 0..MAX {
            let (mut above, mut below) = (parameters, parameters);
            above[i] += step;
            below[i] -= step;
            let (above, below) = (row(above), row(below));
            for j in i..MAX {
                let slope = weight * (above[j] - below[j]) / (2.0 * step);
                assert!((second[i][j] - slope).abs() < DIFFERENCE_TOL, "{i} {j}: {slope}");
            }
        }
    }
}
