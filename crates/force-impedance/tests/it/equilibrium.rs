//! A head in static equilibrium, solved as seven equations in seven unknowns: an oracle that
//! shares nothing with the crate.

use std::f64::consts::TAU;

use force_impedance::HeadGeometry;
use nalgebra::{Point3, Rotation3, SMatrix, SVector, Unit, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// A head somewhere in its workspace under a load.
pub(crate) struct Loaded {
    pub(crate) tip_mm: Point3<f64>,
    pub(crate) normal: Vector3<f64>,
    /// Force of the workpiece on the tool.
    pub(crate) force_n: Vector3<f64>,
    pub(crate) cells_n: [f64; 4],
    pub(crate) lengths_mm: [f64; 4],
    /// Sum of the readings of the radial legs, chosen freely: their bracing.
    pub(crate) bracing_n: f64,
}

/// Where everything of the straight head goes when it leans and slides.
pub(crate) struct Placed {
    pub(crate) axis: Vector3<f64>,
    pub(crate) turn: Rotation3<f64>,
    pub(crate) slide_mm: f64,
}

impl Placed {
    pub(crate) fn at(tip_mm: &Point3<f64>, g: &HeadGeometry) -> Self {
        let straight = -Vector3::y();
        let axis = tip_mm.coords.normalize();
        let turn = match Unit::try_new(straight.cross(&axis), 1e-15) {
            Some(about) => {
                // The arc cosine of nearly 1 has no digits.
                let sine = straight.cross(&axis).norm();
                Rotation3::from_axis_angle(&about, sine.atan2(straight.dot(&axis)))
            }
            None => Rotation3::identity(),
        };
        let slide_mm = tip_mm.coords.norm() - g.tip_to_plane_mm - g.plane_to_joint_mm;
        Self { axis, turn, slide_mm }
    }

    fn of(&self, straight_mm: Vector3<f64>) -> Vector3<f64> {
        self.turn * straight_mm + self.axis * self.slide_mm
    }
}

fn ring(radius_mm: f64, angle_rad: f64, g: &HeadGeometry) -> Vector3<f64> {
    Vector3::new(radius_mm * angle_rad.cos(), -g.plane_to_joint_mm, radius_mm * angle_rad.sin())
}

/// Cells and lengths of a head in equilibrium: unknown are four cell forces, two forces of the
/// joint across the axis and its moment along the axis.
pub(crate) fn equilibrium(
    tip_mm: Point3<f64>,
    normal: Vector3<f64>,
    force_n: Vector3<f64>,
    bracing_n: f64,
    g: &HeadGeometry,
) -> Loaded {
    let placed = Placed::at(&tip_mm, g);
    let u = placed.axis;
    let side = u.cross(&Vector3::x()).normalize();
    let other = u.cross(&side);
    let mut a = SMatrix::<f64, 7, 7>::zeros();
    let mut lengths_mm = [0.0; 4];
    for i in 0..3 {
        let on_head = placed.of(ring(g.head_radius_mm, g.leg_angles_rad[i], g));
        let leg = on_head - ring(g.bracket_radius_mm, g.leg_angles_rad[i], g);
        lengths_mm[i] = leg.norm();
        let push = leg.normalize();
        a.fixed_view_mut::<3, 1>(0, i).copy_from(&push);
        a.fixed_view_mut::<3, 1>(3, i).copy_from(&on_head.cross(&push));
        a[(6, i)] = 1.0;
    }
    lengths_mm[3] = placed.of(Vector3::new(0.0, -g.plane_to_joint_mm, 0.0)).norm();
    for (column, push) in [(3, u), (4, side), (5, other)] {
        a.fixed_view_mut::<3, 1>(0, column).copy_from(&push);
    }
    a.fixed_view_mut::<3, 1>(3, 6).copy_from(&u);
    let weight_n = g.gravity_direction * g.weight_n;
    let center_mm = placed.of(Vector3::new(0.0, -g.center_of_gravity_mm, 0.0));
    let forces = force_n + weight_n;
    let moments = tip_mm.coords.cross(&force_n) + center_mm.cross(&weight_n);
    let mut b = SVector::<f64, 7>::zeros();
    b.fixed_rows_mut::<3>(0).copy_from(&-forces);
    b.fixed_rows_mut::<3>(3).copy_from(&-moments);
    b[6] = bracing_n;
    let x = a.full_piv_lu().solve(&b).unwrap();
    let cells_n = [x[0], x[1], x[2], x[3]];
    Loaded { tip_mm, normal, force_n, cells_n, lengths_mm, bracing_n }
}

/// A tip within ±25 mm sideways (5°) and ±10 mm along.
pub(crate) fn random_tip(rng: &mut ChaCha8Rng) -> Point3<f64> {
    Point3::new(
        rng.random_range(-25.0..25.0),
        -300.0 + rng.random_range(-10.0..10.0),
        rng.random_range(-25.0..25.0),
    )
}

/// A unit vector at `tilt_rad` from `axis`, in the direction `turn_rad` round it.
pub(crate) fn tilted(axis: &Vector3<f64>, tilt_rad: f64, turn_rad: f64) -> Vector3<f64> {
    let side = axis.cross(&Vector3::x()).normalize();
    let other = axis.cross(&side);
    let (sin, cos) = turn_rad.sin_cos();
    axis * tilt_rad.cos() + (side * cos + other * sin) * tilt_rad.sin()
}

/// The force of a surface with friction on a tool that slides in the direction `turn_rad`.
pub(crate) fn rubbing(normal: &Vector3<f64>, press_n: f64, mu: f64, turn_rad: f64) -> Vector3<f64> {
    normal * press_n + tilted(normal, TAU / 4.0, turn_rad) * (mu * press_n)
}

pub(crate) fn random_load(rng: &mut ChaCha8Rng, g: &HeadGeometry) -> Loaded {
    let tip_mm = random_tip(rng);
    let back = -tip_mm.coords.normalize();
    let normal = tilted(&back, rng.random_range(0.0..0.5), rng.random_range(0.0..TAU));
    let press_n = rng.random_range(5.0..200.0);
    let force_n = rubbing(&normal, press_n, rng.random_range(0.0..0.4), rng.random_range(0.0..TAU));
    equilibrium(tip_mm, normal, force_n, rng.random_range(60.0..400.0), g)
}
