//! One reading: its residual and derivatives, along the beam and across it.

use geometry::so3;
use nalgebra::{Matrix3, SMatrix, Vector3};

use crate::{Target, TargetNoise, TrackerError};

/// Directions in which a reading is compared, and its standard uncertainty in each.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights {
    /// Rows are unit vectors of the station's frame: the beam and two across it, or its axes.
    pub(super) directions: Matrix3<f64>,
    pub(super) sigma_mm: Vector3<f64>,
}

/// Nearer than this a target has no direction.
const NEAREST_MM: f64 = 1.0;

impl Weights {
    /// `estimated_mm` is what stands for noise that is not declared.
    pub(super) fn new(
        target: &Target,
        noise: TargetNoise,
        estimated_mm: f64,
    ) -> Result<Self, TrackerError> {
        let same = |sigma_mm: f64| Self {
            directions: Matrix3::identity(),
            sigma_mm: Vector3::from_element(sigma_mm),
        };
        match noise {
            TargetNoise::Estimated => Ok(same(estimated_mm)),
            TargetNoise::Point { point_mm } => Ok(same(point_mm)),
            TargetNoise::Polar { range_mm, angle_rad } => {
                let distance = target.at_mm.coords.norm();
                if distance < NEAREST_MM {
                    return Err(TrackerError::NotFinite);
                }
                let beam = target.at_mm.coords / distance;
                let first = beam.cross(&Vector3::ith(beam.iamin(), 1.0)).normalize();
                let across = beam.cross(&first);
                let directions = Matrix3::from_columns(&[beam, first, across]).transpose();
                let sigma = angle_rad * distance;
                Ok(Self { directions, sigma_mm: Vector3::new(range_mm, sigma, sigma) })
            }
        }
    }
}

/// Where a station is: `[c, w]` beside its start, machine frame from its own
/// `p ↦ start.c + c + exp(w)·start.R·p`.
#[derive(Clone, Copy, Debug)]
pub(super) struct StationAt {
    pub(super) center_mm: Vector3<f64>,
    pub(super) rotation: Matrix3<f64>,
    pub(super) left_jacobian: Matrix3<f64>,
}

impl StationAt {
    pub(super) fn new(start: &nalgebra::Isometry3<f64>, parameters: &[f64]) -> Self {
        let turn = Vector3::new(parameters[3], parameters[4], parameters[5]);
        let moved = Vector3::new(parameters[0], parameters[1], parameters[2]);
        Self {
            center_mm: start.translation.vector + moved,
            rotation: (so3::exp(&turn) * start.rotation).to_rotation_matrix().into_inner(),
            left_jacobian: so3::left_jacobian(&turn),
        }
    }
}

/// The six errors of an angle as matrices.
#[derive(Clone, Copy, Debug)]
pub(super) struct ErrorAt {
    pub(super) displacement_mm: Vector3<f64>,
    pub(super) turned: Matrix3<f64>,
    pub(super) left_jacobian: Matrix3<f64>,
}

impl ErrorAt {
    pub(super) fn new(error: &[f64]) -> Self {
        let rotation = Vector3::new(error[3], error[4], error[5]);
        Self {
            displacement_mm: Vector3::new(error[0], error[1], error[2]),
            turned: so3::exp(&rotation).to_rotation_matrix().into_inner(),
            left_jacobian: so3::left_jacobian(&rotation),
        }
    }
}

/// Predicted minus measured point and its derivatives, by the directions of [`Weights`], mm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    pub(super) residual_mm: Vector3<f64>,
    /// By displacement of the station and by the parameters of its rotation.
    pub(super) by_station: SMatrix<f64, 3, 6>,
    pub(super) by_mount: Matrix3<f64>,
    /// By displacement of the axis and by the parameters of its rotation.
    pub(super) by_error: SMatrix<f64, 3, 6>,
    /// Directions of a reading from the axes of the machine.
    to_rows: Matrix3<f64>,
    /// From the station to the predicted point, and from the displaced axis, machine frame.
    beam_mm: Vector3<f64>,
    arm_mm: Vector3<f64>,
    /// Directions of a reading from the axes of the station.
    from_station: Matrix3<f64>,
    /// The reflector in the turning frame.
    pub(super) body_mm: Vector3<f64>,
    /// The predicted point.
    pub(super) predicted_mm: Vector3<f64>,
}

/// What a reading is compared with.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) origin_mm: Vector3<f64>,
    /// Nominal rotation of the axis.
    pub(super) nominal: Matrix3<f64>,
    pub(super) error: ErrorAt,
    pub(super) body_mm: Vector3<f64>,
    pub(super) station: StationAt,
}

impl Sight {
    pub(super) fn new(place: &Place, target: &Target, weights: &Weights) -> Self {
        let Place { origin_mm, nominal, error, body_mm, station } = place;
        let arm = error.turned * (nominal * body_mm);
        let beam = origin_mm + error.displacement_mm + arm - station.center_mm;
        let to_rows = weights.directions * station.rotation.transpose();
        let predicted_mm = to_rows * beam;
        let mut by_error = SMatrix::<f64, 3, 6>::zeros();
        by_error.fixed_view_mut::<3, 3>(0, 0).copy_from(&to_rows);
        let by_turn = -(to_rows * arm.cross_matrix() * error.left_jacobian);
        by_error.fixed_view_mut::<3, 3>(0, 3).copy_from(&by_turn);
        let mut by_station = SMatrix::<f64, 3, 6>::zeros();
        by_station.fixed_view_mut::<3, 3>(0, 0).copy_from(&-to_rows);
        let by_turn = to_rows * beam.cross_matrix() * station.left_jacobian;
        by_station.fixed_view_mut::<3, 3>(0, 3).copy_from(&by_turn);
        Self {
            residual_mm: predicted_mm - weights.directions * target.at_mm.coords,
            by_station,
            by_mount: to_rows * error.turned * nominal,
            by_error,
            to_rows,
            beam_mm: beam,
            arm_mm: arm,
            from_station: weights.directions,
            body_mm: *body_mm,
            predicted_mm,
        }
    }

    /// What a small displacement or rotation of the station does, about the axes of the machine.
    pub(super) fn by_station_motion(&self, coordinate: usize) -> Vector3<f64> {
        let along = Vector3::ith(coordinate % 3, 1.0);
        self.to_rows * if coordinate < 3 { -along } else { self.beam_mm.cross(&along) }
    }

    /// What a small displacement or rotation of the axis does, about the axes of the machine.
    pub(super) fn by_axis_motion(&self, coordinate: usize) -> Vector3<f64> {
        let along = Vector3::ith(coordinate % 3, 1.0);
        self.to_rows * if coordinate < 3 { along } else { along.cross(&self.arm_mm) }
    }

    /// A reading that is off along an axis of the station.
    pub(super) fn by_reading(&self, coordinate: usize) -> Vector3<f64> {
        self.from_station.column(coordinate).into_owned()
    }

    /// Derivative by displacement and rotation of the reflector's body in the turning frame.
    pub(super) fn by_motion(&self, coordinate: usize) -> Vector3<f64> {
        let along = Vector3::ith(coordinate % 3, 1.0);
        let moved = if coordinate < 3 { along } else { along.cross(&self.body_mm) };
        self.by_mount * moved
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Point3};

    use super::*;

    /// Central differences over half a step of 1e-4 on 400 mm: the third power of the step, and round-off
    /// of 1e-13 mm over the step.
    const STEP: f64 = 1e-4;
    const DIFFERENCE: f64 = 1e-5;

    /// Small motions of a station and of the axis, about the axes of the machine, at a station and errors
    /// that are turned.
    #[test]
    fn motions_about_the_axes_of_the_machine_are_derivatives() {
        let target =
            Target { station: 0, mount: 0, step: 0, at_mm: Point3::new(310.0, -120.0, 80.0) };
        let noise = TargetNoise::Polar { range_mm: 0.01, angle_rad: 5e-6 };
        let weights = Weights::new(&target, noise, 1.0).unwrap();
        let start = Isometry3::new(Vector3::new(-260.0, 90.0, 40.0), Vector3::new(0.4, -0.7, 0.2));
        let place = Place {
            origin_mm: Vector3::new(5.0, -8.0, 12.0),
            nominal: so3::exp(&Vector3::new(0.0, 0.9, 0.0)).to_rotation_matrix().into_inner(),
            error: ErrorAt::new(&[0.4, -0.2, 0.1, 0.03, -0.02, 0.05]),
            body_mm: Vector3::new(70.0, -30.0, 110.0),
            station: StationAt::new(&start, &[0.3, 0.2, -0.6, 0.1, -0.2, 0.3]),
        };
        let at = Sight::new(&place, &target, &weights);
        let turned = |by: f64, c: usize| {
            so3::exp(&(Vector3::ith(c, 1.0) * by)).to_rotation_matrix().into_inner()
        };
        for coordinate in 0..6 {
            let c = coordinate % 3;
            let predicted = |by: f64, of_station: bool| {
                let mut moved = place;
                let StationAt { center_mm, rotation, .. } = &mut moved.station;
                let ErrorAt { displacement_mm, turned: turn, .. } = &mut moved.error;
                match (of_station, coordinate < 3) {
                    (true, true) => center_mm[c] += by,
                    (true, false) => *rotation = turned(by, c) * *rotation,
                    (false, true) => displacement_mm[c] += by,
                    (false, false) => *turn = turned(by, c) * *turn,
                }
                Sight::new(&moved, &target, &weights).predicted_mm
            };
            for (of_station, slope) in
                [(true, at.by_station_motion(coordinate)), (false, at.by_axis_motion(coordinate))]
            {
                let difference =
                    predicted(STEP / 2.0, of_station) - predicted(-STEP / 2.0, of_station);
                let off = (difference / STEP - slope).amax();
                assert!(off < DIFFERENCE, "{coordinate} {of_station}: {off}");
            }
        }
    }
}
