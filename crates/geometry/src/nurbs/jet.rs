use nalgebra::{Matrix2, Point3, Unit, Vector2, Vector3, Vector4};

use super::Nurbs;
use crate::error::finite;
use crate::{Curvature, GeometryError};

/// A point of a NURBS surface with its first and second derivatives by u and v, mm per knot unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct NurbsJet {
    /// The point.
    pub point_mm: Point3<f64>,
    /// ∂/∂u and ∂/∂v.
    pub tangents_mm: [Vector3<f64>; 2],
    /// ∂²/∂u², ∂²/∂u∂v, ∂²/∂v².
    pub bends_mm: [Vector3<f64>; 3],
}

/// Sine between, or ratio of, two tangents below which they make no plane.
const COLLAPSED: f64 = 1e-9;

impl NurbsJet {
    /// `∂a·∂b` for the tangents a and b.
    pub(super) fn metric(&self) -> Matrix2<f64> {
        let [u, v] = &self.tangents_mm;
        Matrix2::new(u.dot(u), u.dot(v), u.dot(v), v.dot(v))
    }

    /// Second derivatives along a direction in space.
    pub(super) fn bend_along(&self, direction: &Vector3<f64>) -> Matrix2<f64> {
        let [uu, uv, vv] = self.bends_mm.map(|bend| bend.dot(direction));
        Matrix2::new(uu, uv, uv, vv)
    }

    /// What a step in u and v is in space.
    pub(super) fn moved(&self, step: &Vector2<f64>) -> Vector3<f64> {
        self.tangents_mm[0] * step.x + self.tangents_mm[1] * step.y
    }
}

impl Nurbs {
    /// The point at a place and its derivatives; beyond the edge the outermost polynomial goes on.
    pub(super) fn jet_at(&self, [u, v]: [f64; 2]) -> NurbsJet {
        let spans = [self.net.knots[0].span(u), self.net.knots[1].span(v)];
        let along_u = self.net.knots[0].weights(spans[0], u);
        let along_v = self.net.knots[1].weights(spans[1], v);
        // Value, ∂u, ∂v, ∂uu, ∂uv, ∂vv.
        let mut sums = [Vector4::zeros(); 6];
        let across = along_v[0].iter().zip(&along_v[1]).zip(&along_v[2]);
        for (b, ((of, first), second)) in across.enumerate().take(self.net.knots[1].degree + 1) {
            let mut row = [Vector4::zeros(); 3];
            for a in 0..=self.net.knots[0].degree {
                let control = self.net.control(spans, a, b);
                for (sum, weights) in row.iter_mut().zip(&along_u) {
                    *sum += control * weights[a];
                }
            }
            let [of, first, second] = [*of, *first, *second];
            sums[0] += row[0] * of;
            sums[1] += row[1] * of;
            sums[2] += row[0] * first;
            sums[3] += row[2] * of;
            sums[4] += row[1] * first;
            sums[5] += row[0] * second;
        }
        let [value, du, dv, duu, duv, dvv] = sums;
        let w = value.w;
        let point = value.xyz() / w;
        let first = |d: &Vector4<f64>| (d.xyz() - point * d.w) / w;
        let [by_u, by_v] = [first(&du), first(&dv)];
        let second = |d: &Vector4<f64>, turned: Vector3<f64>| (d.xyz() - point * d.w - turned) / w;
        NurbsJet {
            point_mm: Point3::from(point),
            tangents_mm: [by_u, by_v],
            bends_mm: [
                second(&duu, by_u * (2.0 * du.w)),
                second(&duv, by_v * du.w + by_u * dv.w),
                second(&dvv, by_v * (2.0 * dv.w)),
            ],
        }
    }

    pub(super) fn normal_of(
        &self,
        jet: &NurbsJet,
        at: [f64; 2],
    ) -> Result<Unit<Vector3<f64>>, GeometryError> {
        // Over the whole surface, so that the unit of the knots does not matter.
        let lengths = self.domain().map(|[from, to]| to - from);
        let [u, v] = [0, 1].map(|d| jet.tangents_mm[d] * lengths[d]);
        let mixed = jet.bends_mm[1] * (lengths[0] * lengths[1]);
        let across = |a: &Vector3<f64>, b: &Vector3<f64>| {
            let scale = u.norm().max(v.norm()).max(f64::MIN_POSITIVE);
            Unit::try_new(a.cross(b), COLLAPSED * scale * scale)
        };
        // At a collapsed edge one tangent vanishes in proportion to the distance from it; inwards
        // of the edge it has the sign of the mixed derivative.
        let inwards = |d: usize| {
            let [from, to] = self.net.knots[d].domain();
            if at[d] - from <= to - at[d] { 1.0 } else { -1.0 }
        };
        let limit = || {
            if u.norm() <= v.norm() {
                across(&(mixed * inwards(1)), &v)
            } else {
                across(&u, &(mixed * inwards(0)))
            }
        };
        let none = GeometryError::NoNormal { u: at[0], v: at[1] };
        across(&u, &v).or_else(limit).ok_or(none)
    }

    pub(super) fn curvature_of(
        &self,
        jet: &NurbsJet,
        at: [f64; 2],
    ) -> Result<Curvature, GeometryError> {
        let normal = self.normal_of(jet, at)?;
        let none = GeometryError::NoNormal { u: at[0], v: at[1] };
        let longer = usize::from(jet.tangents_mm[1].norm() > jet.tangents_mm[0].norm());
        let first = jet.tangents_mm[longer].normalize();
        let second = normal.cross(&first);
        // Steps in u and v that make a unit along each tangent.
        let inverse = jet.metric().try_inverse().ok_or(none)?;
        let step = |tangent: &Vector3<f64>| {
            inverse * Vector2::new(jet.tangents_mm[0].dot(tangent), jet.tangents_mm[1].dot(tangent))
        };
        let steps = [step(&first), step(&second)];
        let bend = jet.bend_along(&normal);
        let shape = Matrix2::from_fn(|i, j| steps[i].dot(&(bend * steps[j])));
        finite(shape.iter(), "position on the surface").map_err(|_| none)?;
        Ok(Curvature::of_shape(&shape, &first, &second))
    }
}

#[expect(clippy::cast_precision_loss, reason = "control points are far below 2^53")]
pub(super) fn as_f64(count: usize) -> f64 {
    count as f64
}
