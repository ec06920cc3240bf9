#![expect(
    clippy::inline_always,
    reason = "inlined into functions that are compiled for wide registers"
)]

use nalgebra::{Point3, Unit, Vector3};
use rayon::prelude::*;

use super::error::{RegisterError, Side};
use super::kd_tree::{Found, KdTree, spatial_order};
use super::point_cloud::{PointCloud, check_points};

/// Queries of one piece of parallel work.
const QUERIES_AT_ONCE: usize = 512;

/// Residual directions of a surface found by PCA are off by some degrees; a point over the surface
/// at height h then seems to lie h·sin beside it.
const SIDEWAYS_PER_HEIGHT: f64 = 0.2;

/// What a source is moved onto.
pub(crate) trait Target: Sync {
    /// Finds what is nearest to each query, which should be neighbours of one another.
    fn search(&self, queries: &[Point3<f64>], limit_mm: f64, margin_mm: f64, found: &mut [Found]);

    /// The point of the target that was found for a query.
    fn foot(&self, slot: u32, query: &Point3<f64>) -> Foot;

    /// How far the target's points lie apart; 0 where it is not made of points.
    fn spacing_mm(&self) -> f64;
}

/// Point of a target.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Foot {
    pub(crate) point: Point3<f64>,
    pub(crate) normal: Vector3<f64>,
    /// Whether the query lies beside the target, past its border.
    pub(crate) is_beside: bool,
}

/// A cloud made ready to be registered onto: searchable, in an order that suits memory.
#[derive(Clone, Debug)]
pub struct CloudTarget {
    tree: KdTree,
    normals: Option<Vec<Vector3<f64>>>,
    /// How far the points about each slot extend.
    reach_mm: Vec<f32>,
}

/// Nearest point of a cloud.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Nearest {
    /// Its place in the cloud, from 0.
    pub index: usize,
    /// Its distance.
    pub distance_mm: f64,
}

impl CloudTarget {
    /// Builds the search tree; `n log n` in time, 150 bytes a point.
    ///
    /// # Errors
    ///
    /// As [`PointCloud::check`].
    pub fn new(cloud: &PointCloud) -> Result<Self, RegisterError> {
        cloud.check(Side::Target)?;
        let tree = KdTree::new(&cloud.points_mm);
        let normals = cloud.normals.as_ref().map(|n| tree.in_slots(n));
        let normals = normals.map(|n| n.into_iter().map(Unit::into_inner).collect());
        let reach_mm = tree.leaf_reaches();
        Ok(Self { tree, normals, reach_mm })
    }

    /// Whether the cloud came with normals.
    #[must_use]
    pub fn has_normals(&self) -> bool {
        self.normals.is_some()
    }

    /// Nearest point of each query, in the order of the queries.
    ///
    /// Sorts them first, since neighbours are answered together.
    ///
    /// # Errors
    ///
    /// [`RegisterError::InvalidPoint`] for a query that is not finite.
    pub fn nearest(&self, queries_mm: &[Point3<f64>]) -> Result<Vec<Nearest>, RegisterError> {
        check_points(queries_mm, Side::Source)?;
        let (queries, order) = spatial_order(queries_mm);
        let mut found = vec![Found::NOTHING; queries.len()];
        queries
            .par_chunks(QUERIES_AT_ONCE)
            .zip(found.par_chunks_mut(QUERIES_AT_ONCE))
            .for_each(|(queries, found)| self.search(queries, f64::INFINITY, 0.0, found));
        let mut nearest = vec![Nearest { index: 0, distance_mm: 0.0 }; queries.len()];
        for ((query, found), at) in queries.iter().zip(&found).zip(order) {
            nearest[at as usize] = Nearest {
                index: self.tree.order()[found.slot as usize] as usize,
                distance_mm: (self.tree.points()[found.slot as usize] - query).norm(),
            };
        }
        Ok(nearest)
    }
}

impl Target for CloudTarget {
    fn search(&self, queries: &[Point3<f64>], limit_mm: f64, margin_mm: f64, found: &mut [Found]) {
        pulp::Arch::new().dispatch(
            #[inline(always)]
            || self.tree.search(queries, limit_mm, margin_mm, found),
        );
    }

    #[inline(always)]
    fn foot(&self, slot: u32, query: &Point3<f64>) -> Foot {
        let point = self.tree.points()[slot as usize];
        let Some(normals) = &self.normals else {
            return Foot { point, normal: Vector3::zeros(), is_beside: false };
        };
        let normal = normals[slot as usize];
        let offset = query - point;
        let height = normal.dot(&offset);
        let sideways = offset.norm_squared() - height * height;
        let reach = f64::from(self.reach_mm[slot as usize]) + SIDEWAYS_PER_HEIGHT * height.abs();
        Foot { point, normal, is_beside: sideways > reach * reach }
    }

    fn spacing_mm(&self) -> f64 {
        let mut reaches = self.reach_mm.clone();
        let middle = reaches.len() / 2;
        let (_, median, _) = reaches.select_nth_unstable_by(middle, f32::total_cmp);
        // A leaf of eight points on a surface is about four spacings across.
        f64::from(*median) / 4.0
    }
}
