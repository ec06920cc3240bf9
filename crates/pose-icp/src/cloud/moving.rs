//! The source, sorted into groups of neighbours, at several levels of detail.

use nalgebra::{Isometry3, Point3, Vector3};

use super::kd_tree::{Aabb, Found, LANES, spatial_order};
use super::point_cloud::PointCloud;

/// Points of one piece of parallel work, and of one partial sum.
pub(crate) const CHUNK: usize = 64 * LANES;

/// Points at the coarsest level: enough that the pose is good to a fraction of the spacing.
const COARSEST: usize = 512 * LANES;

/// How much more points the next finer level has.
const REFINEMENT: usize = 16;

/// Source points at one level of detail, and what was found for them so far.
pub(crate) struct Moving {
    pub(crate) points: Vec<Point3<f64>>,
    pub(crate) normals: Option<Vec<Vector3<f64>>>,
    pub(crate) found: Vec<Found>,
    pub(crate) chunks: Vec<Chunk>,
    /// Pose at which it was found.
    pub(crate) found_at: Option<Isometry3<f64>>,
}

/// State of [`CHUNK`] points that follow one another.
#[derive(Clone, Debug)]
pub(crate) struct Chunk {
    corners: [Point3<f64>; 8],
    /// Twice the way that any point of the chunk went so far, at most.
    pub(crate) travel_mm: f64,
}

impl Moving {
    fn new(points: Vec<Point3<f64>>, normals: Option<Vec<Vector3<f64>>>) -> Self {
        let found = vec![Found::NOTHING; points.len()];
        let chunks = points.chunks(CHUNK).map(Chunk::new).collect();
        Self { points, normals, found, chunks, found_at: None }
    }

    /// All points, and before them ever fewer: every sixteenth group, and so on.
    pub(crate) fn levels(cloud: &PointCloud) -> Vec<Self> {
        let (points, order) = spatial_order(&cloud.points_mm);
        let normals = cloud
            .normals
            .as_ref()
            .map(|n| order.iter().map(|&i| n[i as usize].into_inner()).collect::<Vec<_>>());
        let mut levels = Vec::new();
        let mut stride = 1;
        while points.len() / (stride * REFINEMENT) >= COARSEST {
            stride *= REFINEMENT;
            let normals = normals.as_ref().map(|n| every(stride, n));
            levels.push(Self::new(every(stride, &points), normals));
        }
        levels.reverse();
        levels.push(Self::new(points, normals));
        levels
    }

    /// Groups all over the source, of about this many points.
    pub(crate) fn few(&self, n_points: usize) -> Self {
        let stride = self.points.len().div_ceil(n_points);
        Self::new(every(stride, &self.points), self.normals.as_ref().map(|n| every(stride, n)))
    }

    /// Forgets what was found: it does not hold for another way to search.
    pub(crate) fn forget(&mut self) {
        self.found.fill(Found::NOTHING);
        self.chunks.iter_mut().for_each(|chunk| chunk.travel_mm = 0.0);
        self.found_at = None;
    }

    /// The furthest that any point moves between two poses, at most.
    pub(crate) fn motion_mm(&self, from: &Isometry3<f64>, to: &Isometry3<f64>) -> f64 {
        self.chunks.iter().map(|chunk| chunk.motion_mm(from, to)).fold(0.0, f64::max)
    }
}

impl Chunk {
    fn new(points: &[Point3<f64>]) -> Self {
        let aabb = Aabb::of(points);
        let side = |corner: usize, k: usize| {
            if corner >> k & 1 == 0 { aabb.min[k] } else { aabb.max[k] }
        };
        let corners = std::array::from_fn(|c| Point3::new(side(c, 0), side(c, 1), side(c, 2)));
        Self { corners, travel_mm: 0.0 }
    }

    /// The furthest that a point of the chunk moves: that of a corner, displacement being affine.
    pub(crate) fn motion_mm(&self, from: &Isometry3<f64>, to: &Isometry3<f64>) -> f64 {
        self.corners.iter().map(|c| (to * c - from * c).norm()).fold(0.0, f64::max)
    }
}

/// Every `stride`-th group of [`LANES`] values.
fn every<T: Copy>(stride: usize, values: &[T]) -> Vec<T> {
    values.chunks(LANES).step_by(stride).flatten().copied().collect()
}
