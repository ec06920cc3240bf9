//! A reference sphere is touched from thirty directions; the stylus gives way sideways, and the
//! loop finds out.

use geometry::Sphere;
use model_discrepancy::{Options, Role, close_loop};
use nalgebra::{Point3, Vector3};
use probe_comp::{BallTouch, MeasuredTouch, Nominal, NormalSource, ProbeModel, ProbeSetup, Side};

/// Readings scatter by this much; a fixed pattern stands for noise.
const SIGMA_MM: f64 = 1e-3;
const BENDING_MM: f64 = 0.012;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let sphere = Nominal::sphere(Sphere::new(Point3::origin(), 12.5)?, Side::Along);
    let touches = (0..30)
        .map(|i| {
            let z = (f64::from(i) + 0.5) / 30.0;
            let (sin, cos) = (2.4 * f64::from(i)).sin_cos();
            let side = (1.0 - z * z).sqrt();
            let outward = Vector3::new(side * cos, side * sin, z);
            let noise = SIGMA_MM * (f64::from(i * i % 17) / 8.0 - 1.0);
            let bent = Vector3::new(-outward.x, -outward.y, 0.0) * BENDING_MM;
            let center = Point3::from(outward * (15.5 + noise) + bent);
            let name = format!("T{}", i + 1);
            let touch = BallTouch::new(center, SIGMA_MM);
            MeasuredTouch { group: name.clone(), name, role: Role::Fit, touch }
        })
        .collect();
    let setup = ProbeSetup {
        nominal: sphere,
        tip_radius_mm: 3.0,
        stylus: Vector3::z_axis(),
        source: NormalSource::Nominal,
        sigma_declared: true,
        qualification: None,
    };
    let model = ProbeModel::new(setup, touches, &[])?;
    let closure = close_loop(&model, &model.all_covariates(), &Options::default())?;
    let step = closure.steps.first().ok_or("nothing was found")?;
    let sideways = &step.parameters[0];
    assert_eq!(step.effect, "bending");
    assert!((sideways.value - 1e3 * BENDING_MM).abs() < 4.0 * sideways.std, "{sideways:?}");
    Ok(())
}
