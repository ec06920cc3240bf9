//! Surfaces that faces lie on.

use std::fmt;
use std::sync::Arc;

use geometry::nalgebra::{Point3, Unit, Vector3};

use super::StepProblem;
use super::entity::{Entity, Record};
use super::exchange::Exchange;
use super::net::StepNet;
use super::shown::Shown;

/// What a face lies on, in mm and in the coordinates of its part.
///
/// Directions are those of the surface itself; whether the part is on the other side is said by the
/// face.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum StepSurface {
    /// A B-spline, with or without weights.
    Net(Arc<StepNet>),
    /// A plane.
    Plane {
        /// A point of it.
        point_mm: Point3<f64>,
        /// Its normal.
        normal: Unit<Vector3<f64>>,
    },
    /// A sphere; its normal points away from the centre.
    Sphere {
        /// Its centre.
        center_mm: Point3<f64>,
        /// Its radius.
        radius_mm: f64,
    },
    /// A cylinder.
    Cylinder {
        /// A point of its axis.
        point_mm: Point3<f64>,
        /// Its axis.
        axis: Unit<Vector3<f64>>,
        /// Its radius.
        radius_mm: f64,
    },
    /// A cone.
    Cone {
        /// A point of its axis.
        point_mm: Point3<f64>,
        /// Its axis.
        axis: Unit<Vector3<f64>>,
        /// Its radius about that point.
        radius_mm: f64,
    },
    /// A torus.
    Torus {
        /// Its centre.
        center_mm: Point3<f64>,
        /// Its axis.
        axis: Unit<Vector3<f64>>,
        /// Radius of the circle that the tube goes round.
        major_mm: f64,
        /// Radius of the tube.
        minor_mm: f64,
    },
    /// Another surface, by its name in the standard.
    Other {
        /// The name.
        keyword: String,
    },
}

impl StepSurface {
    /// Whether a case takes it.
    #[must_use]
    pub fn has_shape(&self) -> bool {
        matches!(self, Self::Net(_) | Self::Plane { .. } | Self::Sphere { .. })
    }
}

impl Exchange<'_> {
    pub(super) fn surface(
        &self,
        id: u64,
        by: u64,
        unit_mm: f64,
    ) -> Result<StepSurface, StepProblem> {
        let entity = self.entity(id, by)?;
        if let Some(net) = self.net(&entity, unit_mm)? {
            return Ok(StepSurface::Net(Arc::new(net)));
        }
        let record = entity.record();
        let placed = || self.axis(record.reference(1)?, id, unit_mm);
        Ok(match record.keyword {
            "PLANE" => {
                let (point_mm, normal) = placed()?;
                StepSurface::Plane { point_mm, normal }
            }
            "SPHERICAL_SURFACE" => {
                let (center_mm, _) = placed()?;
                StepSurface::Sphere { center_mm, radius_mm: radius_mm(&record, 2, unit_mm)? }
            }
            "CYLINDRICAL_SURFACE" => {
                let (point_mm, axis) = placed()?;
                StepSurface::Cylinder { point_mm, axis, radius_mm: radius_mm(&record, 2, unit_mm)? }
            }
            "CONICAL_SURFACE" => {
                let (point_mm, axis) = placed()?;
                StepSurface::Cone { point_mm, axis, radius_mm: radius_mm(&record, 2, unit_mm)? }
            }
            "TOROIDAL_SURFACE" | "DEGENERATE_TOROIDAL_SURFACE" => {
                let (center_mm, axis) = placed()?;
                let major_mm = radius_mm(&record, 2, unit_mm)?;
                let minor_mm = radius_mm(&record, 3, unit_mm)?;
                StepSurface::Torus { center_mm, axis, major_mm, minor_mm }
            }
            _ => StepSurface::Other { keyword: named(&entity) },
        })
    }

    /// Origin and z axis of an `AXIS2_PLACEMENT_3D`.
    fn axis(
        &self,
        id: u64,
        by: u64,
        unit_mm: f64,
    ) -> Result<(Point3<f64>, Unit<Vector3<f64>>), StepProblem> {
        let placement = self.entity(id, by)?;
        let record = placement.record();
        let origin_mm = self.point_mm(record.reference(1)?, id, unit_mm)?;
        let Some(direction) = record.optional(2)? else {
            return Ok((origin_mm, Vector3::z_axis()));
        };
        let direction = self.entity(direction, id)?;
        let none = || StepProblem::NoDirection { line: direction.line, id: direction.id };
        let ratios = direction.record().numbers(1)?;
        let &[x, y, z] = ratios.as_slice() else { return Err(none()) };
        // Scaled, so that no square is too large.
        let vector = Vector3::new(x, y, z);
        let largest = vector.amax();
        let axis = Unit::try_new(vector / largest, f64::MIN_POSITIVE).ok_or_else(none)?;
        Ok((origin_mm, axis))
    }

    /// A `CARTESIAN_POINT`.
    pub(super) fn point_mm(
        &self,
        id: u64,
        by: u64,
        unit_mm: f64,
    ) -> Result<Point3<f64>, StepProblem> {
        /// Beyond it a coordinate is a slip; tables of cases hold no larger numbers.
        const MAX_MM: f64 = 1e12;
        let entity = self.entity(id, by)?;
        let record = entity.record();
        let coordinates = record.numbers(1)?;
        match coordinates.as_slice() {
            &[x, y, z] if [x, y, z].iter().all(|v| (v * unit_mm).abs() < MAX_MM) => {
                Ok(Point3::new(x, y, z) * unit_mm)
            }
            _ => Err(record.wrong(1, "three coordinates below 1e12 mm")),
        }
    }
}

fn radius_mm(record: &Record<'_, '_>, n: usize, unit_mm: f64) -> Result<f64, StepProblem> {
    let radius_mm = record.number(n)? * unit_mm;
    if radius_mm.is_finite() { Ok(radius_mm) } else { Err(record.wrong(n, "a finite radius")) }
}

/// What an entity is called.
fn named(entity: &Entity<'_>) -> String {
    let names: Vec<&str> = entity.records.iter().map(|(keyword, _)| *keyword).collect();
    names.join(" + ")
}

impl fmt::Display for StepSurface {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Net(net) => net.fmt(f),
            Self::Plane { point_mm, .. } => write!(f, "plane through {}", Shown(&point_mm.coords)),
            Self::Sphere { center_mm, radius_mm } => {
                write!(f, "sphere of radius {radius_mm} mm about {}", Shown(&center_mm.coords))
            }
            Self::Cylinder { point_mm, axis, radius_mm } => write!(
                f,
                "cylinder of radius {radius_mm} mm about the axis through {} along {}",
                Shown(&point_mm.coords),
                Shown(axis)
            ),
            Self::Cone { point_mm, axis, .. } => write!(
                f,
                "cone about the axis through {} along {}",
                Shown(&point_mm.coords),
                Shown(axis)
            ),
            Self::Torus { center_mm, major_mm, minor_mm, .. } => write!(
                f,
                "torus of radii {major_mm} and {minor_mm} mm about {}",
                Shown(&center_mm.coords)
            ),
            Self::Other { keyword } => write!(f, "{keyword}"),
        }
    }
}
