#![expect(
    clippy::inline_always,
    reason = "inlined into functions that are compiled for wide registers"
)]

use nalgebra::{Point3, Unit, Vector3};
use rayon::prelude::*;

use super::averages::{Averages, averages};
use super::error::{RegisterError, Side};
use super::kd_tree::{Aabb, BesideRule, Facing, Found, KdTree, spatial_order};
use super::point_cloud::{PointCloud, check_points};
use super::wide_registers::{Task, dispatch};

/// Queries of one piece of parallel work.
const QUERIES_AT_ONCE: usize = 512;

/// Residual directions of a surface found by PCA are off by some degrees; a point over the surface
/// at height h then seems to lie h·sin beside it.
const BESIDE: BesideRule = BesideRule { per_height: 0.2 };

/// Reaches of a point within which a query is searched for without asking whether it is beside:
/// the question costs more than the search where the answer is no.
const ABOUT_REACHES: f64 = 8.0;

/// Points that the usual reach is taken from.
const REACH_SAMPLES: usize = 4096;

/// What a source is moved onto.
pub(crate) trait Target: Sync {
    /// Finds what is nearest to each query, which should be neighbours of one another.
    fn search(&self, queries: &[Point3<f64>], wanted: &Wanted, found: &mut [Found]);

    /// The point of the target that was found for a query.
    fn foot(&self, slot: u32, query: &Point3<f64>) -> Foot;

    /// Averages over neighbouring points of the target, where its noise shows in squared residuals of
    /// this mean.
    fn averages(&self, _residual_mm2: f64) -> Option<Averages> {
        None
    }

    /// How far the target's points lie apart; 0 where it is not made of points.
    fn spacing_mm(&self) -> f64;
}

/// What a search is for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wanted {
    /// Nothing beyond this counts.
    pub(crate) limit_mm: f64,
    /// Up to which leads are looked for.
    pub(crate) margin_mm: f64,
    /// Whether queries beside the target need no answer.
    pub(crate) skip_beside: bool,
}

impl Wanted {
    const NEAREST: Self = Self { limit_mm: f64::INFINITY, margin_mm: 0.0, skip_beside: false };
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
    /// Where there are normals.
    facing: Option<Facing>,
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
    /// Builds the search tree; `n log n` in time, 75 bytes a point.
    ///
    /// # Errors
    ///
    /// As [`PointCloud::check`].
    pub fn new(cloud: &PointCloud) -> Result<Self, RegisterError> {
        cloud.check(Side::Target)?;
        let tree = KdTree::new(&cloud.points_mm);
        let normals = cloud.normals.as_ref().map(|n| tree.in_slots(n));
        let normals: Option<Vec<Vector3<f64>>> =
            normals.map(|n| n.into_iter().map(Unit::into_inner).collect());
        let reach_mm = tree.leaf_reaches();
        let facing = normals.as_ref().map(|normals| Facing::of(&tree, normals, &reach_mm));
        Ok(Self { tree, normals, reach_mm, facing })
    }

    /// Whether the cloud came with normals.
    #[must_use]
    pub fn has_normals(&self) -> bool {
        self.normals.is_some()
    }

    /// The points, in the order of the tree.
    pub(crate) fn points_mm(&self) -> &[Point3<f64>] {
        self.tree.points()
    }

    /// Whether a box begins so near to a point that queries in it may well be over the target.
    #[inline(always)]
    fn is_about(&self, slot: u32, aabb: &Aabb) -> bool {
        let reach = ABOUT_REACHES * f64::from(self.reach_mm[slot as usize]);
        let offset = self.tree.points()[slot as usize] - Point3::from(aabb.min);
        offset.norm_squared() < reach * reach
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
            .for_each(|(queries, found)| self.search(queries, &Wanted::NEAREST, found));
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

struct Searching<'a> {
    target: &'a CloudTarget,
    queries: &'a [Point3<f64>],
    wanted: &'a Wanted,
    found: &'a mut [Found],
}

impl Task for Searching<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { target, queries, wanted, found } = self;
        let facing = target.facing.as_ref().filter(|_| wanted.skip_beside);
        let beside = |aabb: &Aabb, near: Option<u32>| {
            if near.is_some_and(|slot| target.is_about(slot, aabb)) {
                return None;
            }
            let margin_mm = facing?.beside_for_mm(&target.tree, aabb, BESIDE)?;
            #[expect(clippy::cast_possible_truncation, reason = "a bound, rounded down")]
            let lead_mm = (2.0 * margin_mm) as f32;
            Some(lead_mm.next_down())
        };
        let Wanted { limit_mm, margin_mm, .. } = *wanted;
        target.tree.search(queries, limit_mm, margin_mm, found, beside);
    }
}

impl Target for CloudTarget {
    fn search(&self, queries: &[Point3<f64>], wanted: &Wanted, found: &mut [Found]) {
        dispatch(Searching { target: self, queries, wanted, found });
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
        let reach = f64::from(self.reach_mm[slot as usize]) + BESIDE.per_height * height.abs();
        Foot { point, normal, is_beside: sideways > reach * reach }
    }

    fn averages(&self, residual_mm2: f64) -> Option<Averages> {
        averages(&self.tree, self.normals.as_ref()?, residual_mm2)
    }

    fn spacing_mm(&self) -> f64 {
        let step = self.reach_mm.len().div_ceil(REACH_SAMPLES);
        let mut reaches: Vec<f32> = self.reach_mm.iter().step_by(step).copied().collect();
        let middle = reaches.len() / 2;
        let (_, median, _) = reaches.select_nth_unstable_by(middle, f32::total_cmp);
        // A leaf of eight points on a surface is about four spacings across.
        f64::from(*median) / 4.0
    }
}
