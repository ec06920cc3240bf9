use std::fmt;

use nalgebra::{Point3, Vector3, Vector6};

/// A direction is called weak when its singular value is below this share of the largest: it is
/// known thirty times worse than the best.
const WEAK_RATIO: f64 = 1.0 / 30.0;

/// How well each motion is determined by the shape of the surface.
///
/// From point-to-surface rows, whatever was minimised: those between points hide that a surface
/// slides along itself. Rotations count as the way of a point at `arm_mm` from `pivot_mm`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Observability {
    /// Singular values of the rows, the largest first; `√n` for a motion that all n points show.
    pub singular_values: Vec<f64>,
    /// Distance from the pivot, root-mean-square over the points.
    pub arm_mm: f64,
    /// Directions known thirty times worse than the best, or still worse; the weakest last.
    pub weak: Vec<WeakDirection>,
}

/// A motion that the shape of the surface shows little of, or nothing.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct WeakDirection {
    /// The motion, `[tx, ty, tz, rx, ry, rz]` in mm and rad about `pivot_mm`, of one mm in
    /// quadratic mean.
    pub twist: Vector6<f64>,
    /// Point of the target frame that rotations turn about.
    pub pivot_mm: Point3<f64>,
    /// Distance from the pivot, root-mean-square over the points.
    pub arm_mm: f64,
    /// Singular value over the largest.
    pub relative_singular_value: f64,
    /// Standard uncertainty of the motion; `None` where it is free.
    pub sigma_mm: Option<f64>,
}

impl WeakDirection {
    pub(crate) fn is_weak(relative_singular_value: f64) -> bool {
        relative_singular_value < WEAK_RATIO
    }

    /// Point of the axis that is nearest to the pivot, its direction, and the way along it in mm
    /// a rad; `None` for a translation.
    #[must_use]
    pub fn screw(&self) -> Option<(Point3<f64>, Vector3<f64>, f64)> {
        let translation = self.twist.fixed_rows::<3>(0).into_owned();
        let rotation = self.twist.fixed_rows::<3>(3).into_owned();
        let squared = rotation.norm_squared();
        // An axis a hundred sizes away is no axis.
        if rotation.norm() * self.arm_mm <= 0.01 * translation.norm() {
            return None;
        }
        let point = self.pivot_mm + rotation.cross(&translation) / squared;
        Some((point, rotation / squared.sqrt(), translation.dot(&rotation) / squared))
    }
}

impl fmt::Display for WeakDirection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.screw() {
            None => {
                let direction = self.twist.fixed_rows::<3>(0).normalize();
                write!(f, "the translation along {}", Triple(&direction))?;
            }
            Some((point, axis, pitch_mm)) => {
                let axis_name = Triple(&axis);
                write!(f, "the rotation about {axis_name} through {} mm", Place(&point))?;
                if pitch_mm.abs() > 0.01 * self.arm_mm {
                    write!(f, " with {pitch_mm:.3} mm along it per rad")?;
                }
            }
        }
        match self.sigma_mm {
            Some(sigma_mm) => write!(
                f,
                " (singular value {:.1e} of the largest, standard uncertainty {sigma_mm:.2e} mm \
                 at the points)",
                self.relative_singular_value
            ),
            None => Ok(()),
        }
    }
}

struct Triple<'a>(&'a Vector3<f64>);

impl fmt::Display for Triple<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let leading = self.0[self.0.iamax()];
        let names = ["x", "y", "z"];
        // A direction has no sign: the largest component is shown as positive.
        let v = self.0 * leading.signum();
        if leading.abs() > 0.9995 {
            return write!(f, "{}", names[self.0.iamax()]);
        }
        write!(f, "({:.3}, {:.3}, {:.3})", v.x + 0.0, v.y + 0.0, v.z + 0.0)
    }
}

struct Place<'a>(&'a Point3<f64>);

impl fmt::Display for Place<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "({:.3}, {:.3}, {:.3})", self.0.x, self.0.y, self.0.z)
    }
}
