//! One pass over the source: what each point meets, and the sums of its residual rows.

#![expect(
    clippy::inline_always,
    reason = "inlined into functions that are compiled for wide registers"
)]

use least_squares::Loss;
use nalgebra::{Isometry3, Matrix3, Point3, Vector3};
use rayon::prelude::*;

use super::averages::Averages;
use super::kd_tree::{Found, LANES, NONE};
use super::moving::{CHUNK, Chunk, Moving};
use super::options::Objective;
use super::sums::{LaneSums, Rows, Sums, weigh};
use super::target::{Target, Wanted};
use super::wide_registers::{Task, dispatch};

/// How a point is judged in one pass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rules<'a> {
    pub(crate) objective: Objective,
    pub(crate) pivot: Point3<f64>,
    pub(crate) skip_beside: bool,
    pub(crate) limit_mm: f64,
    /// Squared residuals above this are trimmed.
    pub(crate) keep_below_mm2: f64,
    pub(crate) loss: Option<Loss>,
    pub(crate) sigma_mm: f64,
    /// Where the surface is known better than from single points of the target.
    pub(crate) averages: Option<&'a Averages>,
}

/// A pose as matrix and vector.
#[derive(Clone, Copy)]
struct Placement {
    rotation: Matrix3<f64>,
    translation: Vector3<f64>,
}

impl Placement {
    fn new(pose: &Isometry3<f64>) -> Self {
        let rotation = pose.rotation.to_rotation_matrix().into_inner();
        Self { rotation, translation: pose.translation.vector }
    }

    #[inline(always)]
    fn turn(&self, v: &Vector3<f64>) -> Vector3<f64> {
        let r = &self.rotation;
        Vector3::new(
            r.m11 * v.x + r.m12 * v.y + r.m13 * v.z,
            r.m21 * v.x + r.m22 * v.y + r.m23 * v.z,
            r.m31 * v.x + r.m32 * v.y + r.m33 * v.z,
        )
    }

    #[inline(always)]
    fn place(&self, p: &Point3<f64>) -> Point3<f64> {
        Point3::from(self.turn(&p.coords) + self.translation)
    }
}

/// Finds what is nearest to each point at `pose`.
///
/// A point whose nearest leads the others by more than both can have moved since keeps it unasked.
pub(crate) fn find<T: Target>(
    moving: &mut Moving,
    target: &T,
    pose: &Isometry3<f64>,
    wanted: &Wanted,
) {
    let before = moving.found_at.replace(*pose).unwrap_or(*pose);
    let placement = Placement::new(pose);
    let chunks = moving.chunks.par_iter_mut();
    let points = moving.points.par_chunks(CHUNK).zip(moving.found.par_chunks_mut(CHUNK));
    chunks.zip(points).for_each(|(chunk, (points, found))| {
        chunk.travel_mm += 2.0 * chunk.motion_mm(&before, pose);
        search(chunk, points, found, target, &placement, wanted);
    });
}

fn search<T: Target>(
    chunk: &Chunk,
    points: &[Point3<f64>],
    found: &mut [Found],
    target: &T,
    placement: &Placement,
    wanted: &Wanted,
) {
    let mut at = [0_usize; CHUNK];
    let mut queries = [Point3::origin(); CHUNK];
    let mut answers = [Found::NOTHING; CHUNK];
    let mut n = 0;
    for (i, (point, known)) in points.iter().zip(&*found).enumerate() {
        if f64::from(known.lead_mm) <= chunk.travel_mm {
            at[n] = i;
            queries[n] = placement.place(point);
            answers[n] = *known;
            n += 1;
        }
    }
    target.search(&queries[..n], wanted, &mut answers[..n]);
    for (&i, answer) in at[..n].iter().zip(&answers[..n]) {
        #[expect(clippy::cast_possible_truncation, reason = "a bound, rounded to the safe side")]
        let lead_mm = (f64::from(answer.lead_mm) + chunk.travel_mm) as f32;
        found[i] = Found { slot: answer.slot, lead_mm: lead_mm.next_down() };
    }
}

/// Sums over all points; the same bits on any number of threads.
pub(crate) fn sum<T: Target>(
    moving: &Moving,
    target: &T,
    pose: &Isometry3<f64>,
    rules: &Rules<'_>,
) -> Sums {
    let placement = Placement::new(pose);
    let partial: Vec<Sums> = (0..moving.chunks.len())
        .into_par_iter()
        .map(|chunk| {
            let view = View::new(moving, chunk);
            dispatch(Summing { view, target, placement: &placement, rules })
        })
        .collect();
    partial.iter().fold(Sums::zero(), Sums::add)
}

/// Squared residual of each point that takes part, in mm².
pub(crate) fn squared_residuals<T: Target>(
    moving: &Moving,
    target: &T,
    pose: &Isometry3<f64>,
    rules: &Rules<'_>,
) -> Vec<f64> {
    let placement = Placement::new(pose);
    let per_chunk: Vec<Vec<f64>> = (0..moving.chunks.len())
        .into_par_iter()
        .map(|chunk| {
            let view = View::new(moving, chunk);
            let squared = |i| view.meet(i, target, &placement, rules).map(|m| m.squared_mm2(rules));
            (0..view.points.len()).filter_map(squared).collect()
        })
        .collect();
    per_chunk.concat()
}

/// Slots of the target that points which take part meet.
pub(crate) fn slots_met<T: Target>(
    moving: &Moving,
    target: &T,
    pose: &Isometry3<f64>,
    rules: &Rules<'_>,
) -> Vec<u32> {
    let placement = Placement::new(pose);
    let per_chunk: Vec<Vec<u32>> = (0..moving.chunks.len())
        .into_par_iter()
        .map(|chunk| {
            let view = View::new(moving, chunk);
            let takes_part = |&i: &usize| {
                let meeting = view.meet(i, target, &placement, rules);
                meeting.is_some_and(|m| m.squared_mm2(rules) <= rules.keep_below_mm2)
            };
            (0..view.points.len()).filter(takes_part).map(|i| view.found[i].slot).collect()
        })
        .collect();
    per_chunk.concat()
}

struct Summing<'a, T> {
    view: View<'a>,
    target: &'a T,
    placement: &'a Placement,
    rules: &'a Rules<'a>,
}

impl<T: Target> Task for Summing<'_, T> {
    type Output = Sums;

    #[inline(always)]
    fn run(self) -> Sums {
        self.view.sum(self.target, self.placement, self.rules)
    }
}

struct View<'a> {
    points: &'a [Point3<f64>],
    normals: Option<&'a [Vector3<f64>]>,
    found: &'a [Found],
}

/// A source point and the target point that it meets.
struct Meeting {
    /// Point from the pivot whose motion along the normal is the residual's.
    arm: Vector3<f64>,
    /// Source point from the target point.
    offset: Vector3<f64>,
    /// Direction in which the residual counts.
    normal: Vector3<f64>,
    /// Derivative of the residual by rotation, beyond `arm × normal`.
    turning: Vector3<f64>,
}

impl<'a> View<'a> {
    fn new(moving: &'a Moving, chunk: usize) -> Self {
        let range = chunk * CHUNK..((chunk + 1) * CHUNK).min(moving.points.len());
        Self {
            points: &moving.points[range.clone()],
            normals: moving.normals.as_ref().map(|n| &n[range.clone()]),
            found: &moving.found[range],
        }
    }

    #[inline(always)]
    fn meet<T: Target>(
        &self,
        i: usize,
        target: &T,
        placement: &Placement,
        rules: &Rules<'_>,
    ) -> Option<Meeting> {
        let slot = self.found[i].slot;
        if slot == NONE {
            return None;
        }
        let point = placement.place(&self.points[i]);
        let foot = target.foot(slot, &point);
        let offset = point - foot.point;
        let is_far = offset.norm_squared() > rules.limit_mm * rules.limit_mm;
        if is_far || (foot.is_beside && rules.skip_beside) {
            return None;
        }
        let lift_mm = rules.averages.map_or(0.0, |a| f64::from(a.lift_mm[slot as usize]));
        let offset = offset - foot.normal * lift_mm;
        // Normal and place must belong together: those of the target point do, and a sphere then
        // shows nothing of its rotation however coarsely it is sampled.
        let place = match rules.objective {
            Objective::PointToPlane => foot.point,
            Objective::PointToPoint | Objective::Symmetric => point,
        };
        let mut meeting = Meeting {
            arm: place - rules.pivot,
            offset,
            normal: foot.normal,
            turning: Vector3::zeros(),
        };
        if rules.objective == Objective::Symmetric {
            let own = self.normals.map_or(foot.normal, |n| placement.turn(&n[i]));
            meeting.lean_to(&own);
        }
        Some(meeting)
    }

    #[inline(always)]
    fn sum<T: Target>(&self, target: &T, placement: &Placement, rules: &Rules<'_>) -> Sums {
        let mut sums = LaneSums::zero();
        let n_rows = if rules.objective == Objective::PointToPoint { 3 } else { 1 };
        let mut n_used = 0;
        for start in (0..self.points.len()).step_by(LANES) {
            let lanes = LANES.min(self.points.len() - start);
            if self.found[start..start + lanes].iter().all(|f| f.slot == NONE) {
                continue;
            }
            let mut rows = [Rows::ZERO; 3];
            for lane in 0..lanes {
                let Some(meeting) = self.meet(start + lane, target, placement, rules) else {
                    continue;
                };
                let squared = meeting.squared_mm2(rules);
                if squared <= rules.keep_below_mm2 {
                    n_used += 1;
                    let weighed = weigh(rules.loss, rules.sigma_mm, squared);
                    meeting.fill(&mut rows[..n_rows], lane, weighed);
                }
            }
            for rows in &rows[..n_rows] {
                sums.add(rows);
            }
        }
        sums.total(n_used, n_used * n_rows)
    }
}

impl Meeting {
    /// Counts along the mean of both normals: Rusinkiewicz (2019), eq. 9, not linearised.
    #[inline(always)]
    fn lean_to(&mut self, own: &Vector3<f64>) {
        let own = if own.dot(&self.normal) < 0.0 { -own } else { *own };
        let sum = own + self.normal;
        let length = sum.norm();
        self.normal = sum / length;
        // The source's normal turns with it.
        self.turning = own.cross(&self.offset) / length;
    }

    #[inline(always)]
    fn squared_mm2(&self, rules: &Rules<'_>) -> f64 {
        if rules.objective == Objective::PointToPoint {
            return self.offset.norm_squared();
        }
        let residual = self.normal.dot(&self.offset);
        residual * residual
    }

    /// Writes one row along the normal, or one along each axis.
    #[inline(always)]
    fn fill(&self, rows: &mut [Rows], lane: usize, (weight, loss): (f64, f64)) {
        let along_axes = rows.len() == 3;
        for (k, rows) in rows.iter_mut().enumerate() {
            let direction = if along_axes { Vector3::ith(k, 1.0) } else { self.normal };
            let turning = self.arm.cross(&direction) + self.turning;
            for axis in 0..3 {
                rows.jacobian[axis][lane] = direction[axis];
                rows.jacobian[3 + axis][lane] = turning[axis];
            }
            rows.residual[lane] = direction.dot(&self.offset);
            rows.weight[lane] = weight;
            rows.loss[lane] = if k == 0 { loss } else { 0.0 };
        }
    }
}
