//! What the published formula makes of a contact with friction, beside the full balance.
//!
//! A head leans over a surface that is 30° off its axis; the pad rubs with µ = 0.2.
//!
//! `cargo run -p force-impedance --example weigh_a_contact`

use force_impedance::{ForceImpedanceError, Head, HeadGeometry, HeadLimits};
use nalgebra::Vector3;

fn main() -> Result<(), ForceImpedanceError> {
    let geometry = HeadGeometry {
        tip_to_plane_mm: 120.0,
        plane_to_joint_mm: 180.0,
        head_radius_mm: 40.0,
        bracket_radius_mm: 110.0,
        leg_angles_rad: [90.0_f64, 210.0, 330.0].map(f64::to_radians),
        weight_n: 0.0,
        center_of_gravity_mm: 150.0,
        gravity_direction: -Vector3::z(),
    };
    let head = Head::new(geometry, HeadLimits::wide(&geometry))?;
    let pose = head.pose_at(&head.start_tip_mm())?;
    let balance = head.balance(&pose);

    // A press of 50 N along a normal that leans by 30° towards x, dragged uphill with 10 N.
    let (sin, cos) = 30f64.to_radians().sin_cos();
    let normal = Vector3::new(sin, cos, 0.0);
    let uphill = Vector3::new(-cos, sin, 0.0);
    let force_n = normal * 50.0 + uphill * 10.0;

    // What the cells read: legs in the xz plane at 90°, 210°, 330° push inwards; the moments of the
    // contact about the joint are force × 300 mm, those of the legs reading × 180 mm.
    let sideways_n = force_n.x * 300.0 / 180.0;
    let bracing_n = 120.0;
    let half = sideways_n / 3f64.sqrt();
    let cells_n = [bracing_n, bracing_n - half, bracing_n + half, force_n.y];

    let contact = balance.contact(&cells_n, &normal);
    assert!((contact.force_n - force_n).norm() < 1e-9);
    assert!((contact.normal_n - 50.0).abs() < 1e-9);
    assert!(contact.friction_ratio.is_some_and(|mu| (mu - 0.2).abs() < 1e-9));

    // The axial force over cos 30° takes the drag for pressure: 50·µ·tan 30° = 5.77 N too much.
    let published_n = balance.published_normal_n(&cells_n, &normal)?;
    assert!((published_n - 55.7735).abs() < 1e-3, "{published_n}");
    Ok(())
}
