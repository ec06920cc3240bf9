//! Starts to try where the one given leads nowhere, or where none is given.

use std::f64::consts::GOLDEN_RATIO;

use nalgebra::{
    Isometry3, Matrix3, Point3, Rotation3, SymmetricEigen, Translation3, Unit, UnitQuaternion,
    Vector3, Vector6,
};
use rayon::prelude::*;

use super::error::{RegisterError, Side};
use super::moving::Moving;
use super::options::{Freedom, Objective, RegisterOptions};
use super::pass::{self, Rules};
use super::point_cloud::PointCloud;

use super::registration::Termination;
use super::search::{Pass, Search, State, as_f64, rms_mm};
use super::target::{CloudTarget, Target, Wanted};

/// Residuals up to this share of the target's spacing, in quadratic mean, are those of a surface that
/// lies on the other one: a wrong pose leaves about half a spacing.
const FITS_SPACINGS: f64 = 0.1;

/// Residual, over that of the best pose tried, from which on a point counts as not explained.
const UNEXPLAINED_RMS: f64 = 2.0;

/// Share of what one pose leaves unexplained that another must stay below to be taken in its place.
const CLEARLY_LESS: f64 = 0.9;

/// Share of the points over the target from which on two ways to the same pose confirm it.
const MOST: f64 = 0.9;

/// Points of the source that tell one start from another.
const FEW: usize = 1024;

/// Passes with them, at most.
const MAX_PASSES: usize = 60;

/// Rotation between a start and those about it: less than what a search bears by itself.
const ABOUT_RAD: f64 = 0.7;

/// A better start, where the search from the given one did not lead onto the target.
///
/// A start is tried with all points, and again with points beside the target left out once the others
/// lie on it: half an overlap needs them left out from the beginning, a shift by a third of the part
/// needs them pulled along. Where that leads elsewhere than the search did, or leaves many points beside, and
/// not onto the target either, starts turned about each axis are tried as well. What explains clearly more of the points
/// is taken.
pub(super) fn other_start<T: Target>(
    search: &Search<'_, T>,
    level: &mut Moving,
    settled: &Result<(Pass, Option<Termination>), RegisterError>,
    state: &State,
) -> Option<State> {
    let spacing_mm = search.target.spacing_mm();
    // Residuals between points are those of the spacing, wherever the source lies.
    let may_try = search.options.objective != Objective::PointToPoint
        && search.wanted.skip_beside
        && search.wanted.limit_mm.is_infinite();
    let settled = settled.as_ref().ok().map(|(pass, _)| Tried::of(pass, state, level));
    let fits_mm = FITS_SPACINGS * spacing_mm;
    if !may_try || spacing_mm <= 0.0 || settled.as_ref().is_some_and(|s| s.rms_mm <= fits_mm) {
        return None;
    }
    let mut few = level.few(FEW);
    let uses_most = settled.as_ref().is_some_and(|s| s.share >= MOST);
    let mut tried: Vec<Tried> = settled.into_iter().collect();
    let first = tried.len();
    tried.extend(search.tried(&mut few, &Vector6::zeros(), state));
    let is_same = match &tried[..] {
        [usual, other] => few.motion_mm(&usual.state.pose, &other.state.pose) <= spacing_mm,
        _ => false,
    };
    let is_confirmed = is_same && uses_most;
    if !is_confirmed && !tried.iter().any(|t| t.rms_mm <= fits_mm) {
        let turns = (3..6).filter(|&k| search.options.freedoms[k] == Freedom::Free);
        let starts = turns.flat_map(|k| [-ABOUT_RAD, ABOUT_RAD].map(|turn| (k, turn)));
        for (k, turn_rad) in starts {
            let mut xi = Vector6::zeros();
            xi[k] = turn_rad;
            tried.extend(search.tried(&mut few, &xi, state));
            if tried.last().is_some_and(|t| t.rms_mm <= fits_mm) {
                break;
            }
        }
    }
    let (best, left) = search.least_unexplained(&mut few, &tried, fits_mm)?;
    let is_better = best >= first && (first == 0 || left[best] < CLEARLY_LESS * left[0]);
    let passes = tried[first..].iter().map(|t| t.state.iterations).sum::<usize>();
    is_better.then(|| {
        let iterations = state.iterations + passes;
        State { iterations, ..tried.swap_remove(best).state }
    })
}

/// Where a source lies on a target, roughly, with nothing known of it.
///
/// From sixty rotations, those of an icosahedron, about the principal axes of both clouds: none is
/// further than 45° from one of them, which a search bears. A few hundred points are moved from
/// each, and what explains most of them is taken; [`RegisterOptions::start`] for
/// [`register_to_cloud`](crate::register_to_cloud) to refine. Where the part looks the same in
/// several poses, it is one of them. Of the options, `start`, `pivot_mm`, `freedoms`, `objective` and
/// `max_distance_mm` are not looked at.
///
/// # Errors
///
/// As [`register_to_cloud`](crate::register_to_cloud); [`RegisterError::NoOverlap`] where no start
/// leads anywhere.
pub fn find_start(
    source: &PointCloud,
    target: &CloudTarget,
    options: &RegisterOptions,
) -> Result<Isometry3<f64>, RegisterError> {
    source.check(Side::Source)?;
    options.check()?;
    if !target.has_normals() {
        return Err(RegisterError::MissingNormals { side: Side::Target });
    }
    let options = RegisterOptions {
        objective: Objective::PointToPlane,
        freedoms: [Freedom::Free; 6],
        pivot_mm: None,
        max_distance_mm: None,
        ..options.clone()
    };
    let few = Moving::levels(source)[0].few(FEW);
    let (from, onto) = (Axes::of(&few.points), Axes::of(target.points_mm()));
    // The order of the starts decides between equals, not which thread is first.
    let tried: Vec<Result<Option<Tried>, RegisterError>> = icosahedral_rotations()
        .into_par_iter()
        .map(|turn| {
            let start = onto.frame * turn * from.frame.inverse();
            let options = RegisterOptions { start, ..options.clone() };
            let search = Search::new(source, target, true, &options)?;
            Ok(search.tried(&mut few.few(FEW), &Vector6::zeros(), &search.at_start()))
        })
        .collect();
    let tried = tried.into_iter().collect::<Result<Vec<_>, _>>()?;
    let tried: Vec<Tried> = tried.into_iter().flatten().collect();
    let search = Search::new(source, target, true, &options)?;
    let fits_mm = FITS_SPACINGS * target.spacing_mm();
    let mut few = few;
    let best = search.least_unexplained(&mut few, &tried, fits_mm);
    let (used, points, max_distance_mm) = (0, few.points.len(), options.max_distance_mm);
    let none = RegisterError::NoOverlap { used, points, max_distance_mm };
    best.map(|(best, _)| tried[best].state.pose).ok_or(none)
}

/// Where a search got to.
struct Tried {
    state: State,
    rms_mm: f64,
    /// Of the points, those that take part.
    share: f64,
}

impl Tried {
    fn of(pass: &Pass, state: &State, level: &Moving) -> Self {
        let share = as_f64(pass.sums.n_used) / as_f64(level.points.len());
        Self { state: state.clone(), rms_mm: rms_mm(&pass.sums), share }
    }
}

impl<T: Target> Search<'_, T> {
    /// Searches with all points, then without those beside the target.
    fn tried(&self, few: &mut Moving, xi: &Vector6<f64>, like: &State) -> Option<Tried> {
        let options = RegisterOptions { max_iterations: MAX_PASSES, ..self.options.clone() };
        let with = |wanted: Wanted| Search {
            target: self.target,
            has_normals: self.has_normals,
            options: &options,
            chart: self.chart.clone(),
            arm_mm: self.arm_mm,
            wanted,
        };
        few.forget();
        let mut state = State { iterations: 0, xi: *xi, pose: self.chart.pose(xi), ..like.clone() };
        let all = Wanted { skip_beside: false, ..self.wanted };
        with(all).settle(few, &mut state, false, None).ok()?;
        let (pass, _) = with(self.wanted).settle(few, &mut state, false, None).ok()?;
        Some(Tried::of(&pass, &state, few))
    }

    /// The pose that leaves least of the points unexplained, and what each leaves.
    fn least_unexplained(
        &self,
        few: &mut Moving,
        tried: &[Tried],
        fits_mm: f64,
    ) -> Option<(usize, Vec<f64>)> {
        let least_mm = tried.iter().map(|t| t.rms_mm).fold(f64::INFINITY, f64::min);
        let counted_mm2 = (UNEXPLAINED_RMS * least_mm.max(fits_mm)).powi(2);
        let rules = Rules {
            objective: Objective::PointToPlane,
            pivot: self.chart.pivot,
            skip_beside: self.wanted.skip_beside,
            limit_mm: self.wanted.limit_mm,
            keep_below_mm2: f64::INFINITY,
            loss: None,
            sigma_mm: 1.0,
            averages: None,
        };
        few.forget();
        let left: Vec<f64> = tried
            .iter()
            .map(|tried| {
                let pose = &tried.state.pose;
                pass::find(few, self.target, pose, &self.wanted);
                let squared = pass::squared_residuals(few, self.target, pose, &rules);
                let within: f64 = squared.iter().map(|s| s.min(counted_mm2)).sum();
                within + as_f64(few.points.len() - squared.len()) * counted_mm2
            })
            .collect();
        let best = (0..left.len()).min_by(|&a, &b| left[a].total_cmp(&left[b]))?;
        Some((best, left))
    }
}

/// Principal axes of points about their mean.
struct Axes {
    frame: Isometry3<f64>,
}

impl Axes {
    fn of(points: &[Point3<f64>]) -> Self {
        let count = as_f64(points.len());
        let mean = points.iter().fold(Vector3::zeros(), |sum, p| sum + p.coords) / count;
        let scatter = points.iter().fold(Matrix3::zeros(), |scatter, p| {
            let offset = p.coords - mean;
            scatter + offset * offset.transpose()
        });
        let eigen = SymmetricEigen::new(scatter);
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
        let [x, y] = [order[0], order[1]].map(|k| Vector3::from(eigen.eigenvectors.column(k)));
        let axes = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, y, x.cross(&y)]));
        let rotation = UnitQuaternion::from_rotation_matrix(&axes);
        Self { frame: Isometry3::from_parts(Translation3::from(mean), rotation) }
    }
}

/// The sixty rotations of an icosahedron two of whose edges are along x, y and z each.
fn icosahedral_rotations() -> Vec<UnitQuaternion<f64>> {
    let half = std::f64::consts::TAU / 2.0;
    let axes = |a: f64, b: f64| {
        let signs = [(a, b), (a, -b)];
        signs.into_iter().flat_map(|(a, b)| {
            [Vector3::new(0.0, a, b), Vector3::new(a, b, 0.0), Vector3::new(b, 0.0, a)]
        })
    };
    let turn = |axis: Vector3<f64>, angle: f64| {
        UnitQuaternion::from_axis_angle(&Unit::new_normalize(axis), angle)
    };
    let mut turns = vec![UnitQuaternion::identity()];
    // Through corners, by fifths.
    for axis in axes(1.0, GOLDEN_RATIO) {
        turns.extend([1.0, 2.0, 3.0, 4.0].map(|fifths| turn(axis, fifths * half / 2.5)));
    }
    // Through the middles of faces, by thirds.
    let diagonals = [1.0, -1.0].into_iter().flat_map(|y| [1.0, -1.0].map(|z| (y, z)));
    for axis in diagonals
        .map(|(y, z)| Vector3::new(1.0, y, z))
        .chain(axes(GOLDEN_RATIO, 1.0 / GOLDEN_RATIO))
    {
        turns.extend([1.0, 2.0].map(|thirds| turn(axis, thirds * half / 1.5)));
    }
    // Through the middles of edges, by halves.
    let phi = GOLDEN_RATIO;
    let signs = [1.0, -1.0].into_iter().flat_map(|a| [1.0, -1.0].map(|b| (a, b)));
    let of_edges = signs.flat_map(|(a, b)| {
        let edge = Vector3::new(1.0, a * (phi + 1.0), b * phi);
        [edge, Vector3::new(edge.z, edge.x, edge.y), Vector3::new(edge.y, edge.z, edge.x)]
    });
    for axis in [Vector3::x(), Vector3::y(), Vector3::z()].into_iter().chain(of_edges) {
        turns.push(turn(axis, half));
    }
    turns
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, UnitQuaternion, Vector3};

    use super::{Axes, icosahedral_rotations};

    /// Corners of a cross whose arms are 3, 2 and 1 mm long, turned and moved.
    #[test]
    fn axes_go_from_the_widest_to_the_narrowest() {
        let turn = UnitQuaternion::from_euler_angles(0.4, -0.8, 1.9);
        let middle = Vector3::new(70.0, -20.0, 5.0);
        let ends = [3.0, 2.0, 1.0].into_iter().enumerate().flat_map(|(k, size)| {
            [size, -size].map(|end| Point3::from(middle + turn * Vector3::ith(k, end)))
        });
        let axes = Axes::of(&ends.collect::<Vec<_>>());
        // Round-off of coordinates of 70 mm.
        assert!((axes.frame.translation.vector - middle).norm() < 1e-13);
        for k in 0..3 {
            let along =
                (axes.frame.rotation * Vector3::ith(k, 1.0)).dot(&(turn * Vector3::ith(k, 1.0)));
            assert!((along.abs() - 1.0).abs() < 1e-12, "{k}: {along}");
        }
    }

    #[test]
    fn the_rotations_are_sixty_and_a_group() {
        let turns = icosahedral_rotations();
        assert_eq!(turns.len(), 60);
        let is_one = |q: &UnitQuaternion<f64>| turns.iter().any(|t| t.angle_to(q) < 1e-7);
        for a in &turns {
            assert_eq!(turns.iter().filter(|t| t.angle_to(a) < 1e-7).count(), 1);
            for b in &turns {
                assert!(is_one(&(a * b)), "{a} {b}");
            }
        }
    }
}
