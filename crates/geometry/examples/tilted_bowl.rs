//! Finds how a probed aspheric bowl sits on the machine, by Gauss-Newton over its closest points.

#![expect(clippy::print_stdout, reason = "the output of an example")]

use geometry::nalgebra::{DMatrix, DVector, Isometry3, Point3, Vector6};
use geometry::{Asphere, AsphereShape, GeometryError, Surface, se3, units};

/// Round-off of coordinates up to 500 mm over a few transforms.
const EXACT_TOL_MM: f64 = 1e-11;

/// The point cloud turned about the bowl's own axis is the same cloud: rz is held.
const N_FREE: usize = 5;

fn main() -> Result<(), GeometryError> {
    // A4 keeps tilt and decentre apart, which a plain bowl of low aperture hardly does.
    let bowl = Asphere::new(AsphereShape::on_axis(120.0, -1.0, vec![2e-7], 100.0))?;
    let machine_from_nominal = Isometry3::translation(300.0, 200.0, 50.0);
    let moved = Vector6::new(0.003, -0.004, 0.005, 12e-6, -16e-6, 0.0);
    let machine_from_bowl = machine_from_nominal * se3::exp(&moved);
    let touches_mm = touches(&bowl, &machine_from_bowl)?;

    let mut estimate = machine_from_nominal;
    for step in 0..4 {
        let (deviations_mm, correction) = gauss_newton(&bowl, &estimate, &touches_mm)?;
        let largest_um = deviations_mm.amax() * units::UM_PER_MM;
        println!("step {step}: largest deviation {largest_um:.9} um");
        estimate = se3::retract(&estimate, &correction);
    }

    let bowl_from_bowl = estimate.inverse() * machine_from_bowl;
    let rim_mm = Point3::new(50.0, 0.0, 0.0);
    let error_mm = (bowl_from_bowl * rim_mm - rim_mm).norm();
    println!("pose found to {error_mm:e} mm at the rim");
    assert!(error_mm < EXACT_TOL_MM);
    Ok(())
}

/// Twelve points on two rings, as the machine reads them.
fn touches(
    bowl: &Asphere,
    machine_from_bowl: &Isometry3<f64>,
) -> Result<Vec<Point3<f64>>, GeometryError> {
    let touch = |i: u32| {
        let (sin, cos) = (f64::from(i) * 0.55).sin_cos();
        let r = if i.is_multiple_of(2) { 20.0 } else { 45.0 };
        let z = bowl.sag_mm(r * cos, r * sin)?;
        Ok(machine_from_bowl * Point3::new(r * cos, r * sin, z))
    };
    (0..12).map(touch).collect()
}

/// Deviations along the normal, and the step, on the left, that takes them away to first order.
fn gauss_newton(
    bowl: &Asphere,
    machine_from_bowl: &Isometry3<f64>,
    touches_mm: &[Point3<f64>],
) -> Result<(DVector<f64>, Vector6<f64>), GeometryError> {
    let mut deviations_mm = DVector::zeros(touches_mm.len());
    let mut jacobian = DMatrix::zeros(touches_mm.len(), N_FREE);
    for (i, touch) in touches_mm.iter().enumerate() {
        let foot = bowl.closest_point(&(machine_from_bowl.inverse() * touch))?;
        // ξ in the bowl's frame moves the foot along the normal by nᵀ [I, −[p]×] ξ.
        let row = se3::point_jacobian(&foot.point_mm).tr_mul(&foot.normal);
        deviations_mm[i] = foot.signed_distance_mm;
        jacobian.row_mut(i).tr_copy_from(&row.fixed_rows::<N_FREE>(0));
    }
    let svd = jacobian.svd(true, true);
    let solution = svd.solve(&deviations_mm, 0.0).expect("both factors were asked for");
    let mut in_bowl = Vector6::zeros();
    in_bowl.fixed_rows_mut::<N_FREE>(0).copy_from(&solution);
    Ok((deviations_mm, se3::adjoint(machine_from_bowl) * in_bowl))
}
