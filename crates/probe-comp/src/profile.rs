use nalgebra::{Matrix3, Point3, Unit, Vector2, Vector3};

use crate::ProbeError;
use crate::neighbours::MeasuredNormal;

/// A contact of a ball that was scanned along a profile, in the plane of x and z.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ProfileContact {
    /// Ball's centre, (x, z).
    pub center_mm: Vector2<f64>,
    /// Contact, (x, z).
    pub point_mm: Vector2<f64>,
    /// Inclination of the normal towards +x, θ.
    pub inclination_rad: f64,
    /// Standard uncertainty of it, from that of the two neighbours.
    pub sigma_inclination_rad: f64,
}

/// Contacts of a ball on a profile z(x), by the neighbours of each place (document \[E\], 2-D).
///
/// With ball centres z₁ and z₂ at x ∓ h, tan θ' = (z₁ − z₂)/(2h) and
/// A' = (x − r sin θ', z − r cos θ'). The first and the last place have no second neighbour and
/// no contact: `centers_mm` of n places give n − 2. Places may be unevenly apart; the slope is
/// then that of the parabola through the three. `sigma_mm` is the standard uncertainty of a z.
///
/// # Errors
///
/// [`ProbeError::InvalidProfile`], [`ProbeError::InvalidTip`].
pub fn compensate_profile(
    centers_mm: &[Vector2<f64>],
    tip_radius_mm: f64,
    sigma_mm: f64,
) -> Result<Vec<ProfileContact>, ProbeError> {
    if !(tip_radius_mm >= 0.0 && tip_radius_mm.is_finite()) {
        return Err(ProbeError::InvalidTip { radius_mm: tip_radius_mm });
    }
    let increases = |w: &[Vector2<f64>]| w[0].x < w[1].x && w.iter().all(|p| p.y.is_finite());
    if centers_mm.len() < 3 || !centers_mm.windows(2).all(increases) {
        return Err(ProbeError::InvalidProfile { got: centers_mm.len() });
    }
    let contact = |w: &[Vector2<f64>]| {
        let at = w[1];
        let Slope { slope, gain_per_mm: gain } = slope_of_parabola([w[0], w[1], w[2]], at.x);
        let inclination_rad = (-slope).atan();
        let (sin, cos) = inclination_rad.sin_cos();
        ProfileContact {
            center_mm: at,
            point_mm: at - Vector2::new(sin, cos) * tip_radius_mm,
            inclination_rad,
            sigma_inclination_rad: sigma_mm * gain * cos * cos,
        }
    };
    Ok(centers_mm.windows(3).map(contact).collect())
}

/// Slope of a profile, and the root sum of squares of its derivatives by the heights.
#[derive(Clone, Copy, Debug)]
struct Slope {
    slope: f64,
    gain_per_mm: f64,
}

/// Slope at `x` of the parabola through three places.
fn slope_of_parabola(places: [Vector2<f64>; 3], x: f64) -> Slope {
    let weight = |i: usize| {
        let [a, b, c] = [0, 1, 2].map(|k| places[(i + k) % 3].x);
        (2.0 * x - b - c) / ((a - b) * (a - c))
    };
    let weights = [0, 1, 2].map(weight);
    let slope = weights.iter().zip(places).map(|(weight, place)| weight * place.y).sum();
    let gain_per_mm = weights.iter().map(|w| w * w).sum::<f64>().sqrt();
    Slope { slope, gain_per_mm }
}

/// Distance from the row, as a share of its length, from which on a ball is not on it.
const OFF_ROW: f64 = 1e-3;
/// Distance of two balls along the row, as a share of its length, below which they are in one place.
const SAME_PLACE: f64 = 1e-9;

/// Normals of a profile at balls that stand in one row of the xy plane, whatever their order: upwards, and
/// at right angles to what is across the row.
///
/// The outermost ones have the slope that the parabola through the three nearest has there.
pub(crate) fn profile_normals(
    centers_mm: &[Point3<f64>],
) -> Result<Vec<MeasuredNormal>, ProbeError> {
    let got = centers_mm.len();
    if got < 3 {
        return Err(ProbeError::InvalidProfile { got });
    }
    let (first, along, length_mm) = row(centers_mm);
    let across = Vector2::new(-along.y, along.x);
    for (index, center) in centers_mm.iter().enumerate() {
        let off_mm = across.dot(&(center.xy().coords - first)).abs();
        // Also true for NaN.
        let is_on_row = off_mm <= OFF_ROW * length_mm;
        if !is_on_row {
            return Err(ProbeError::BesideProfile { index, off_mm });
        }
    }
    let place =
        |center: &Point3<f64>| Vector2::new(along.dot(&(center.xy().coords - first)), center.z);
    let places: Vec<Vector2<f64>> = centers_mm.iter().map(place).collect();
    let mut order: Vec<usize> = (0..got).collect();
    order.sort_by(|&a, &b| places[a].x.total_cmp(&places[b].x));
    let stands = |w: &&[usize]| places[w[1]].x - places[w[0]].x <= SAME_PLACE * length_mm;
    if let Some(w) = order.windows(2).find(stands) {
        return Err(ProbeError::SamePlace { index: w[0].max(w[1]), other: w[0].min(w[1]) });
    }
    let mut normals = vec![None; got];
    for (rank, &index) in order.iter().enumerate() {
        let from = rank.saturating_sub(1).min(got - 3);
        let three = [0, 1, 2].map(|k| places[order[from + k]]);
        let found = slope_of_parabola(three, places[index].x);
        normals[index] = Some(found.normal(&along));
    }
    Ok(normals.into_iter().flatten().collect())
}

impl Slope {
    /// The noise of a reading tilts the normal by that of the height, and the noise of its place by
    /// that times the slope.
    fn normal(self, along: &Vector2<f64>) -> MeasuredNormal {
        let (sin, cos) = (-self.slope).atan().sin_cos();
        let normal = Vector3::new(sin * along.x, sin * along.y, cos);
        let tangent = Vector3::new(cos * along.x, cos * along.y, -sin);
        let turn = self.gain_per_mm * cos;
        let spread_per_mm2: Matrix3<f64> = tangent * tangent.transpose() * (turn * turn);
        MeasuredNormal { normal: Unit::new_normalize(normal), spread_per_mm2 }
    }
}

/// One end of the row, its direction to the other, and its length.
fn row(centers_mm: &[Point3<f64>]) -> (Vector2<f64>, Vector2<f64>, f64) {
    let farthest = |from: &Vector2<f64>| {
        let off = |p: &Point3<f64>| (p.xy().coords - from).norm();
        let far = centers_mm.iter().max_by(|a, b| off(a).total_cmp(&off(b)));
        far.map_or(*from, |p| p.xy().coords)
    };
    let first = farthest(&centers_mm[0].xy().coords);
    let arm = farthest(&first) - first;
    let length_mm = arm.norm();
    let along = if length_mm > 0.0 { arm / length_mm } else { Vector2::x() };
    (first, along, length_mm)
}
