mod closest;
mod crossing;
mod interval;
mod profile;
mod root;

use std::f64::consts::FRAC_PI_2;
use std::ops::ControlFlow;

use nalgebra::{Point2, Point3, Unit, Vector2, Vector3};

use self::interval::Interval;
use self::profile::Profile;
use crate::error::finite;
use crate::{Curvature, Foot, GeometryError, Hit, Line, Surface};

/// Feet are sought this far past the rim, so that a fit may pass over the rim on its way.
const MARGIN_RATIO: f64 = 1.25;

/// The margin stays this far from the radius at which a conic stands upright.
const CONIC_SHARE: f64 = 0.999;

/// The rim belongs to the aperture, whatever round-off does to a point on it.
const RIM_SHARE: f64 = 1e-12;

/// Cells in which the meridian's curvature and height are bounded once.
const BOUND_CELLS: u32 = 128;

/// Shape and extent of an asphere, ISO 10110-12.
///
/// `z = r²/(R(1 + √(1 − (1 + k) r²/R²))) + A4 r⁴ + A6 r⁶ + …` with `r² = x² + y²`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AsphereShape {
    /// Vertex radius of curvature R; positive: a bowl, concave towards +z; negative: a dome.
    ///
    /// Infinite for a flat base.
    pub radius_mm: f64,
    /// Conic constant k: 0 a sphere, −1 a paraboloid, below −1 a hyperboloid.
    pub conic: f64,
    /// `A4, A6, A8, …` in mm⁻³, mm⁻⁵, mm⁻⁷, …
    pub coefficients: Vec<f64>,
    /// Diameter of the aperture in the xy plane.
    pub diameter_mm: f64,
    /// Centre of the aperture in the xy plane; away from the origin for an off-axis part.
    pub aperture_center_mm: Point2<f64>,
}

impl AsphereShape {
    /// Shape with its aperture around the axis.
    #[must_use]
    pub fn on_axis(radius_mm: f64, conic: f64, coefficients: Vec<f64>, diameter_mm: f64) -> Self {
        let aperture_center_mm = Point2::origin();
        Self { radius_mm, conic, coefficients, diameter_mm, aperture_center_mm }
    }
}

/// Conic asphere about the z axis, vertex at the origin; its normal points to +z.
///
/// Closest points and hits are exact to round-off: about 1e-13 mm at 100 mm, divided, for a closest
/// point, by `1 − κ d` with κ the curvature towards the query and d its distance.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "AsphereShape", into = "AsphereShape")
)]
pub struct Asphere {
    shape: AsphereShape,
    profile: Profile,
    /// Distance from the axis up to which feet and hits are sought.
    reach: f64,
    /// Bound of the meridian's |curvature| within `reach`.
    max_curvature: f64,
    /// Bound of the sag within `reach`.
    height: Interval,
}

impl Asphere {
    /// Checks a shape and bounds its curvature.
    ///
    /// Takes some ten microseconds.
    ///
    /// # Errors
    ///
    /// [`GeometryError::InvalidRadius`], [`GeometryError::InvalidAperture`],
    /// [`GeometryError::ApertureBeyondConic`], [`GeometryError::NonFinite`].
    pub fn new(shape: AsphereShape) -> Result<Self, GeometryError> {
        check(&shape)?;
        let rim_mm = shape.aperture_center_mm.coords.norm() + 0.5 * shape.diameter_mm;
        finite([&rim_mm], "aperture centre")?;
        let profile = Profile::new(shape.radius_mm, shape.conic, shape.coefficients.clone());
        let limit_mm = profile.limit();
        if rim_mm >= limit_mm {
            return Err(GeometryError::ApertureBeyondConic { rim_mm, limit_mm });
        }
        let reach = rim_mm.max((MARGIN_RATIO * rim_mm).min(CONIC_SHARE * limit_mm));
        finite([&(reach * reach)], "aperture diameter")?;
        let whole = profile.meridian_over(Interval { lo: 0.0, hi: reach });
        finite([&whole.slope.square().hi, &whole.bend.magnitude()], "slope of the surface")?;
        let (max_curvature, height) = bounds(&profile, reach);
        finite([&max_curvature, &height.square().hi], "sag within the aperture")?;
        Ok(Self { shape, profile, reach, max_curvature, height })
    }

    /// The shape it was made from.
    #[must_use]
    pub fn shape(&self) -> &AsphereShape {
        &self.shape
    }

    /// Height of the surface over the vertex plane; also outside the aperture.
    ///
    /// # Errors
    ///
    /// [`GeometryError::SagUndefined`] beyond the conic's end, [`GeometryError::NonFinite`].
    pub fn sag_mm(&self, x_mm: f64, y_mm: f64) -> Result<f64, GeometryError> {
        let s = x_mm * x_mm + y_mm * y_mm;
        let z = self.profile.jet(s).z;
        self.defined(s, [z])?;
        Ok(z)
    }

    /// `(∂z/∂x, ∂z/∂y)`, a ratio; also outside the aperture.
    ///
    /// # Errors
    ///
    /// As [`Asphere::sag_mm`], and also at the conic's end.
    pub fn gradient(&self, x_mm: f64, y_mm: f64) -> Result<Vector2<f64>, GeometryError> {
        let s = x_mm * x_mm + y_mm * y_mm;
        let dz = self.profile.jet(s).dz;
        self.defined(s, [dz])?;
        Ok(Vector2::new(x_mm, y_mm) * (2.0 * dz))
    }

    /// Unit normal, on the +z side; also outside the aperture.
    ///
    /// # Errors
    ///
    /// As [`Asphere::gradient`].
    pub fn normal(&self, x_mm: f64, y_mm: f64) -> Result<Unit<Vector3<f64>>, GeometryError> {
        let gradient = self.gradient(x_mm, y_mm)?;
        Ok(upward_normal(gradient.x, gradient.y))
    }

    /// Whether a point's projection along z is within the aperture, its rim included.
    #[must_use]
    pub fn contains(&self, x_mm: f64, y_mm: f64) -> bool {
        self.off_center(x_mm, y_mm) <= 0.5 * self.shape.diameter_mm + RIM_SHARE * self.reach
    }

    fn off_center(&self, x_mm: f64, y_mm: f64) -> f64 {
        (Point2::new(x_mm, y_mm) - self.shape.aperture_center_mm).norm()
    }

    fn outside(&self, distance_mm: f64) -> GeometryError {
        let aperture_radius_mm = 0.5 * self.shape.diameter_mm;
        GeometryError::OutsideAperture { distance_mm, aperture_radius_mm }
    }

    /// Fails where the profile gave NaN or infinity.
    fn defined<const N: usize>(&self, s: f64, values: [f64; N]) -> Result<(), GeometryError> {
        finite([&s], "position on the surface")?;
        let limit_mm = self.profile.limit();
        if values.iter().all(|v| v.is_finite()) {
            Ok(())
        } else if s.sqrt() >= limit_mm {
            Err(GeometryError::SagUndefined { radius_mm: s.sqrt(), limit_mm })
        } else {
            Err(GeometryError::NonFinite { argument: "sag at this position" })
        }
    }
}

impl Surface for Asphere {
    fn closest_point(&self, query_mm: &Point3<f64>) -> Result<Foot, GeometryError> {
        let radius = (query_mm.x * query_mm.x + query_mm.y * query_mm.y).sqrt();
        finite([&radius, &(query_mm.z * query_mm.z)], "query point")?;
        let foot = self.meridian_foot(radius, query_mm.z)?;
        // Unit vector away from the axis; any will do for a query on it, whose foot is the vertex.
        let (cos, sin) =
            if radius > 0.0 { (query_mm.x / radius, query_mm.y / radius) } else { (1.0, 0.0) };
        let point_mm = Point3::new(foot.r * cos, foot.r * sin, foot.z);
        let (up, out) = (foot.stretch.recip(), -foot.slope / foot.stretch);
        Ok(Foot {
            point_mm,
            normal: Unit::new_unchecked(Vector3::new(out * cos, out * sin, up)),
            signed_distance_mm: foot.signed_distance,
            inside_aperture: self.contains(point_mm.x, point_mm.y),
        })
    }

    fn curvature(&self, point_mm: &Point3<f64>) -> Result<Curvature, GeometryError> {
        let s = point_mm.x * point_mm.x + point_mm.y * point_mm.y;
        let r = s.sqrt();
        let at = self.profile.meridian(r);
        self.defined(s, [at.slope, at.bend])?;
        let stretch = at.slope.hypot(1.0);
        let meridional = at.bend / stretch.powi(3);
        let sagittal = 2.0 * self.profile.jet(s).dz / stretch;
        let (cos, sin) = if r > 0.0 { (point_mm.x / r, point_mm.y / r) } else { (1.0, 0.0) };
        let outward = Unit::new_normalize(Vector3::new(cos, sin, at.slope));
        let around = Unit::new_unchecked(Vector3::new(-sin, cos, 0.0));
        let swapped = sagittal > meridional;
        let (major_direction, minor_direction) =
            if swapped { (around, outward) } else { (outward, around) };
        Ok(Curvature {
            major_per_mm: meridional.max(sagittal),
            minor_per_mm: meridional.min(sagittal),
            major_direction,
            minor_direction,
        })
    }

    fn hits(&self, line: &Line) -> Result<Vec<Hit>, GeometryError> {
        let mut hits = Vec::new();
        self.each_hit(line, f64::NEG_INFINITY, &mut |hit| {
            hits.push(hit);
            ControlFlow::Continue(())
        })?;
        Ok(hits)
    }

    fn first_hit(&self, ray: &Line) -> Result<Hit, GeometryError> {
        let mut first = None;
        let mut keep_first = |hit| {
            first = Some(hit);
            ControlFlow::Break(())
        };
        let ahead = self.each_hit(ray, 0.0, &mut keep_first);
        if let Some(hit) = first {
            return Ok(hit);
        }
        // Nothing ahead: the nearest hit behind is the first of the reversed ray.
        let mut behind = None;
        let mut keep_first = |hit: Hit| {
            behind = Some(hit.distance_mm);
            ControlFlow::Break(())
        };
        match (self.each_hit(&ray.reversed(), 0.0, &mut keep_first), behind) {
            (Ok(()), Some(distance_mm)) => Err(GeometryError::BehindRay { distance_mm }),
            _ => Err(ahead.err().unwrap_or(GeometryError::Misses)),
        }
    }
}

impl TryFrom<AsphereShape> for Asphere {
    type Error = GeometryError;

    fn try_from(shape: AsphereShape) -> Result<Self, GeometryError> {
        Self::new(shape)
    }
}

impl From<Asphere> for AsphereShape {
    fn from(asphere: Asphere) -> Self {
        asphere.shape
    }
}

/// Refuses numbers that make no shape.
fn check(shape: &AsphereShape) -> Result<(), GeometryError> {
    let radius_mm = shape.radius_mm;
    let inverse = radius_mm.recip();
    if radius_mm == 0.0 {
        return Err(GeometryError::InvalidRadius { radius_mm });
    }
    finite([&inverse], "vertex radius")?;
    finite([&shape.conic], "conic constant")?;
    finite(&shape.coefficients, "aspheric coefficient")?;
    finite([&shape.diameter_mm], "aperture diameter")?;
    finite(shape.aperture_center_mm.iter(), "aperture centre")?;
    if shape.diameter_mm <= 0.0 {
        return Err(GeometryError::InvalidAperture { diameter_mm: shape.diameter_mm });
    }
    Ok(())
}

fn upward_normal(slope_x: f64, slope_y: f64) -> Unit<Vector3<f64>> {
    Unit::new_normalize(Vector3::new(-slope_x, -slope_y, 1.0))
}

/// Bounds of the meridian's |curvature| and of its height for `r` up to `reach`.
fn bounds(profile: &Profile, reach: f64) -> (f64, Interval) {
    let mut max_curvature = 0.0_f64;
    let mut height = Interval::point(0.0);
    let mut inner = 0.0;
    for i in 1..=BOUND_CELLS {
        // Even steps of the angle, not of r: a conic close to its end turns upright there.
        let angle = FRAC_PI_2 * f64::from(i) / f64::from(BOUND_CELLS);
        let outer = if i == BOUND_CELLS { reach } else { reach * angle.sin() };
        let over = profile.meridian_over(Interval::between(inner, outer));
        let stretch = over.slope.mignitude().hypot(1.0);
        max_curvature = max_curvature.max(over.bend.magnitude() / stretch.powi(3));
        height = Interval { lo: height.lo.min(over.z.lo), hi: height.hi.max(over.z.hi) };
        inner = outer;
    }
    (max_curvature, height)
}
