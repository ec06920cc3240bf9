mod closest;
mod control_net;
mod hits;
mod jet;
mod knots;
mod patch;
mod tree;

use std::ops::ControlFlow;

use nalgebra::{Point3, Unit, Vector3, Vector4};

pub use jet::NurbsJet;

use crate::error::finite;
use crate::surface::ahead;
use crate::{Curvature, Foot, GeometryError, Hit, Line, Surface};
use control_net::ControlNet;
use knots::Knots;
use patch::Leaf;
use tree::Tree;

/// A tensor-product NURBS surface of any degree up to 15; its normal is `∂u × ∂v`.
///
/// With equal weights it is a B-spline. Its closest point is the nearest of all feet: the surface
/// is cut into nearly flat leaves with boxes that hold them, and every leaf that could be nearer is
/// searched by Newton's method. Beyond its edges the outermost polynomials go on for a
/// twentieth of their span, unless the edge closes on the one across or collapses to a point.
#[derive(Clone, Debug, PartialEq)]
pub struct Nurbs {
    net: ControlNet,
    /// How far beyond its beginning and end each direction goes on.
    margins: [[f64; 2]; 2],
    tree: Tree,
}

/// Share of the outermost span by which the surface goes on beyond its edge.
const MARGIN_SHARE: f64 = 0.05;
/// Two places are one below this share of the part.
const SAME_SHARE: f64 = 1e-9;

impl Nurbs {
    /// Control points and weights along u first: point `i + j·n` is `i` along u and `j` along v,
    /// of `n = knots[0].len() − degrees[0] − 1`.
    ///
    /// # Errors
    ///
    /// [`GeometryError::InvalidDegree`], [`GeometryError::TooFewKnots`],
    /// [`GeometryError::KnotsDecrease`], [`GeometryError::KnotRepeated`],
    /// [`GeometryError::InvalidNet`], [`GeometryError::InvalidWeight`], [`GeometryError::NonFinite`];
    /// [`GeometryError::NoNormal`] for a net without area.
    pub fn new(
        degrees: [usize; 2],
        knots: [Vec<f64>; 2],
        points_mm: &[Point3<f64>],
        weights: &[f64],
    ) -> Result<Self, GeometryError> {
        let [u, v] = knots;
        let knots = [Knots::new(degrees[0], u, "u")?, Knots::new(degrees[1], v, "v")?];
        let [columns, rows] = [knots[0].count(), knots[1].count()];
        if columns * rows != points_mm.len() || points_mm.len() != weights.len() {
            let (points, weights) = (points_mm.len(), weights.len());
            return Err(GeometryError::InvalidNet { columns, rows, points, weights });
        }
        finite(points_mm.iter().flat_map(|p| p.iter()), "control point")?;
        finite(weights, "weight")?;
        if let Some(index) = weights.iter().position(|w| *w <= 0.0) {
            return Err(GeometryError::InvalidWeight { index, weight: weights[index] });
        }
        let net: Vec<Vector4<f64>> =
            points_mm.iter().zip(weights).map(|(p, w)| (p.coords * *w).push(*w)).collect();
        finite(net.iter().flat_map(|p| p.iter()), "weighted control point")?;
        let margins = margins(&knots, points_mm, weights);
        let net = ControlNet { knots, points: net };
        let mut this = Self { net, margins, tree: Tree::new(Vec::new()) };
        this.tree = Tree::new(this.leaves());
        // A net on a line or at a point is no surface: its middle has no normal.
        let [u, v] = [0, 1].map(|d| {
            let [from, to] = this.net.knots[d].domain();
            from + 0.493 * (to - from)
        });
        this.normal(u, v)?;
        Ok(this)
    }

    /// Knots that make a surface end at its outermost control points, spans of equal length 1.
    #[must_use]
    pub fn clamped_knots(degree: usize, count: usize) -> Vec<f64> {
        let spans = count.saturating_sub(degree).max(1);
        let inner = (0..=spans).map(jet::as_f64);
        let (first, last) = (std::iter::repeat_n(0.0, degree), jet::as_f64(spans));
        first.chain(inner).chain(std::iter::repeat_n(last, degree)).collect()
    }

    /// The same surface with the opposite normal: u and v exchanged.
    #[must_use]
    pub fn flipped(&self) -> Self {
        let [columns, rows] = [self.net.knots[0].count(), self.net.knots[1].count()];
        let net = (0..columns).flat_map(|i| (0..rows).map(move |j| i + j * columns));
        let [u, v] = self.net.knots.clone();
        let [of_u, of_v] = self.margins;
        let mut this = Self {
            net: ControlNet {
                knots: [v, u],
                points: net.map(|index| self.net.points[index]).collect(),
            },
            margins: [of_v, of_u],
            tree: Tree::new(Vec::new()),
        };
        this.tree = Tree::new(this.leaves());
        this
    }

    /// Beginning and end of u and of v.
    #[must_use]
    pub fn domain(&self) -> [[f64; 2]; 2] {
        [self.net.knots[0].domain(), self.net.knots[1].domain()]
    }

    /// The point at a place, and how it changes.
    ///
    /// # Errors
    ///
    /// [`GeometryError::OutsideKnots`].
    pub fn jet(&self, u: f64, v: f64) -> Result<NurbsJet, GeometryError> {
        let inside = (0..2).all(|d| {
            let [from, to] = self.net.knots[d].domain();
            (from..=to).contains(&[u, v][d])
        });
        if inside { Ok(self.jet_at([u, v])) } else { Err(GeometryError::OutsideKnots { u, v }) }
    }

    /// Unit normal at a place, `∂u × ∂v`; where an edge collapses to a point, its limit there.
    ///
    /// # Errors
    ///
    /// [`GeometryError::OutsideKnots`], [`GeometryError::NoNormal`].
    pub fn normal(&self, u: f64, v: f64) -> Result<Unit<Vector3<f64>>, GeometryError> {
        self.normal_of(&self.jet(u, v)?, [u, v])
    }

    /// The point `distance_mm` above the surface, along its normal: the centre of a ball of that
    /// radius that touches there.
    ///
    /// # Errors
    ///
    /// [`GeometryError::OutsideKnots`], [`GeometryError::NoNormal`].
    pub fn offset_point(
        &self,
        u: f64,
        v: f64,
        distance_mm: f64,
    ) -> Result<Point3<f64>, GeometryError> {
        Ok(self.jet(u, v)?.point_mm + self.normal(u, v)?.into_inner() * distance_mm)
    }

    /// u and v of the closest point.
    ///
    /// # Errors
    ///
    /// As [`Surface::closest_point`].
    pub fn closest_place(&self, query_mm: &Point3<f64>) -> Result<[f64; 2], GeometryError> {
        self.nearest(query_mm).map(|nearest| nearest.at)
    }

    fn leaves(&self) -> Vec<Leaf> {
        let mut leaves = Vec::new();
        for (along_v, from_to_v) in self.net.knots[1].spans() {
            for (along_u, from_to_u) in self.net.knots[0].spans() {
                let domain = [from_to_u, from_to_v];
                Leaf::cut(&self.net, [along_u, along_v], domain, [0; 2], &mut leaves);
            }
        }
        leaves
    }
}

/// How far the surface goes on beyond each edge: not where it closes on itself or collapses.
fn margins(knots: &[Knots; 2], points_mm: &[Point3<f64>], weights: &[f64]) -> [[f64; 2]; 2] {
    let counts = [knots[0].count(), knots[1].count()];
    let size = points_mm.iter().map(|p| (p - points_mm[0]).norm()).fold(0.0, f64::max);
    let same = |a: usize, b: usize| {
        (points_mm[a] - points_mm[b]).norm() <= SAME_SHARE * size
            && (weights[a] - weights[b]).abs() <= SAME_SHARE * weights[a]
    };
    [0, 1].map(|d| {
        let [along, across] = [counts[d], counts[1 - d]];
        let at = |i: usize, j: usize| {
            if d == 0 { i + j * counts[0] } else { j + i * counts[0] }
        };
        let closed = (0..across).all(|j| same(at(0, j), at(along - 1, j)));
        let place = |i: usize, j: usize| points_mm[at(i, j)];
        let collapsed =
            |i: usize| (0..across).all(|j| (place(i, j) - place(i, 0)).norm() <= SAME_SHARE * size);
        let spans: Vec<[f64; 2]> = knots[d].spans().map(|(_, span)| span).collect();
        let margin = |span: &[f64; 2], edge: usize| {
            if closed || collapsed(edge) { 0.0 } else { MARGIN_SHARE * (span[1] - span[0]) }
        };
        match spans[..] {
            [first, .., last] => [margin(&first, 0), margin(&last, along - 1)],
            [only] => [margin(&only, 0), margin(&only, along - 1)],
            [] => [0.0; 2],
        }
    })
}

impl Surface for Nurbs {
    fn closest_point(&self, query_mm: &Point3<f64>) -> Result<Foot, GeometryError> {
        self.foot(query_mm)
    }

    fn curvature(&self, point_mm: &Point3<f64>) -> Result<Curvature, GeometryError> {
        let at = self.nearest(point_mm)?.at;
        self.curvature_of(&self.jet_at(at), at)
    }

    fn hits(&self, line: &Line) -> Result<Vec<Hit>, GeometryError> {
        let mut hits: Vec<Hit> = Vec::new();
        self.each_hit(line, &mut |hit| {
            hits.push(hit);
            ControlFlow::Continue(())
        })?;
        hits.sort_by(|a, b| a.distance_mm.total_cmp(&b.distance_mm));
        let same_mm = SAME_SHARE * self.tree.reach_mm();
        // One on the border of two leaves is found from both.
        hits.dedup_by(|a, b| (a.distance_mm - b.distance_mm).abs() <= same_mm);
        if hits.is_empty() { Err(GeometryError::Misses) } else { Ok(hits) }
    }

    fn first_hit(&self, ray: &Line) -> Result<Hit, GeometryError> {
        let (mut first, mut behind) = (None::<Hit>, None::<f64>);
        self.each_hit(ray, &mut |hit| {
            if hit.distance_mm < 0.0 {
                behind = Some(behind.map_or(hit.distance_mm, |b| b.max(hit.distance_mm)));
            } else if first.is_none_or(|f| hit.distance_mm < f.distance_mm) {
                first = Some(hit);
            }
            ControlFlow::Continue(())
        })?;
        ahead(first, behind)
    }
}
