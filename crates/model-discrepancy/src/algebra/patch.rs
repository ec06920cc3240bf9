//! A patch of a surface that lies higher or lower than the rest, found by looking.
//!
//! There are as many patches as places, and testing all of them in the loop would cost every other
//! effect its significance. So the domain offers the one that takes most of the residual away, and the
//! one that does so beside another effect, if white noise shows one as clear in no more than one set of
//! readings in a hundred; it says among how many it was found, and competes with every other effect.

use nalgebra::{DMatrix, DVector, Matrix3, Point3, Vector3};

use crate::algebra::looked_through::{FALSE_ALARM, LookedThrough};
use crate::count::count;
use crate::{Effect, Model, Parameter, Scope, State};

/// Readings about the middle of a patch, of which the farthest lies at its radius.
const NEIGHBOURS: [usize; 3] = [4, 8, 16];
/// Most readings within the radius, as a share: more are a bend of the whole surface.
const MOST_WITHIN: f64 = 0.4;
/// Fewest readings within the radius: fewer are readings far off, which have a name of their own.
const FEWEST_WITHIN: usize = 5;
/// Readings without which a patch must still show.
const FAR_OFF: usize = 2;
/// Most middles that are tried at first, evenly among the readings.
const MOST_MIDDLES: usize = 400;
/// Share of a patch that the fitted parameters must leave.
const SEEN: f64 = 0.2;
/// Mean square of the readings' scatter along a direction, over that along the longest, below which
/// they do not show where the middle lies in it.
const ON_A_LINE: f64 = 1e-4;
/// Cosine between the traces of two patches from which on they count as one.
const ALIKE: f64 = 0.9;
/// Steps of the middle, as shares of the radius, and of the radius itself, once a patch is found.
const REFINED: [f64; 3] = [0.5, 0.25, 0.125];
/// The same of one with a steep edge, which lies between two readings.
const STEEP: [f64; 12] =
    [0.25, 0.25, 0.25, 0.125, 0.125, 0.125, 0.0625, 0.0625, 0.0625, 0.03125, 0.03125, 0.03125];
/// How steep its edge may be where it is no bell, as one of wear or of a clamp is: something between, and a step, as of a
/// coating or a scrape.
const STEEPNESS: [i32; 2] = [8, 32];
/// Radii that are tried with a steeper edge, over that of the bell.
const EDGES: [f64; 8] = [0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2];
/// Standard deviations from which on a steeper edge is clearly there.
const STEEPER: f64 = 6.0;
/// Share of what is left that a patch must explain to have a steep edge: beside other forms an edge is one of theirs.
const MOSTLY: f64 = 0.8;
/// Standard deviation of a normal distribution over its median deviation.
const OF_MEDIAN: f64 = 1.4826;
/// Places and radius are rounded to this share of the radius, so that what is printed is what is used.
const ROUNDED: f64 = 0.05;

/// Where a patch lies: full height at its middle, 1/e² of it at the radius, in the unit of positions; the share
/// exp(−2 (d/radius)ⁿ) of it at the distance d, n being its steepness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Its middle.
    pub center_mm: Point3<f64>,
    /// Where its height is down to 1/e², 0.135.
    pub radius_mm: f64,
    /// 2 for a bell; the larger, the flatter it is within and the steeper at its edge.
    pub steepness: i32,
    /// Places at which the clearest was looked for.
    pub searched: usize,
}

impl Patch {
    /// Height at a point over that at the middle.
    #[must_use]
    pub fn share(&self, point_mm: &Point3<f64>) -> f64 {
        (-2.0 * ((point_mm - self.center_mm).norm() / self.radius_mm).powi(self.steepness)).exp()
    }

    /// The effect `patch` of parts that are touched in mm, its height along the normal, where it
    /// makes a residual lower; `places_mm` has the place of each row of the layout.
    #[must_use]
    pub fn effect(&self, places_mm: &[Option<Point3<f64>>]) -> Effect {
        let decimals = self.decimals();
        let [x, y, z, radius] =
            [self.center_mm.x, self.center_mm.y, self.center_mm.z, self.radius_mm]
                .map(|v| format!("{v:.decimals$}"));
        let n = self.steepness;
        let edge = (n > 2)
            .then(|| format!(", flat within and steep at its edge, exp(−2 (d/{radius} mm)^{n})"));
        let text = format!(
            "the part is higher than declared in a patch about ({x}, {y}, {z}) mm; height at its middle, \
             1/e² of it {radius} mm away{}",
            edge.unwrap_or_default()
        );
        let height = Parameter::new("height", "µm", 1e3);
        let mut effect =
            Effect::new("patch", &text, vec![height]).about(&format!("({x}, {y}, {z}) mm"));
        effect.searched = self.searched;
        effect.by_place = vec![self.by_place(places_mm)];
        effect
    }

    /// What moving it along the surface, widening it and making its edge steeper does to the residual of each row, per
    /// unit of its height.
    fn by_place(&self, places_mm: &[Option<Point3<f64>>]) -> DMatrix<f64> {
        let held: Vec<(f64, Vector3<f64>)> = (places_mm.iter().flatten())
            .map(|place| (self.share(place), place - self.center_mm))
            .collect();
        let scatter: Matrix3<f64> =
            held.iter().map(|(share, arm)| arm * arm.transpose() * *share).sum();
        let eigen = scatter.symmetric_eigen();
        let most = eigen.eigenvalues.max();
        // The normal is the direction in which the readings scatter least; readings on a line show
        // one direction alone.
        let along =
            |k: &usize| *k != eigen.eigenvalues.imin() && eigen.eigenvalues[*k] > ON_A_LINE * most;
        let ways: Vec<Vector3<f64>> =
            (0..3).filter(along).map(|k| eigen.eigenvectors.column(k).into_owned()).collect();
        // A bell has no steepness that was looked for.
        let of_edge = usize::from(self.steepness > 2);
        let mut by_place = DMatrix::zeros(places_mm.len(), ways.len() + 1 + of_edge);
        for (mut row, place) in by_place.row_iter_mut().zip(places_mm) {
            let Some(place) = place else { continue };
            let arm = place - self.center_mm;
            // Of the exponent by the distance, over the distance.
            let n = self.steepness;
            let rise = (arm.norm() / self.radius_mm).powi(n - 2) / self.radius_mm.powi(2);
            let slope = -2.0 * f64::from(n) * self.share(place) * rise;
            for (value, way) in row.iter_mut().zip(&ways) {
                *value = slope * way.dot(&arm);
            }
            row[ways.len()] = slope * arm.norm_squared() / self.radius_mm;
            let way = (arm.norm() / self.radius_mm).max(f64::MIN_POSITIVE);
            let by_steepness = 2.0 * way.powi(n) * way.ln() * self.share(place);
            row.columns_mut(ways.len() + 1, of_edge).fill(by_steepness);
        }
        by_place
    }

    /// Decimals of the places as they are printed.
    fn decimals(&self) -> usize {
        let finest = (self.radius_mm * ROUNDED).log10().floor();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 12")]
        let decimals = (-finest).clamp(0.0, 12.0) as usize;
        decimals
    }

    /// The same with places as they are printed.
    fn rounded(self) -> Self {
        let to =
            |v: f64, decimals: usize| format!("{v:.decimals$}").parse::<f64>().unwrap_or(v) + 0.0;
        // The radius first: as rounded it says how the rest is.
        let radius_mm = to(self.radius_mm, self.decimals());
        let decimals = Self { radius_mm, ..self }.decimals();
        let center_mm = self.center_mm.map(|v| to(v, decimals));
        Self { center_mm, radius_mm: to(radius_mm, decimals), ..self }
    }
}

/// The clearest patch in the residual of a model at `at`, a solution of its declared part, or of that
/// and the effects that `at` has; and the clearest beside one effect of the catalogue, if the two
/// together show better and it is another. None where white noise might show it. Of a positive height
/// they make a residual lower.
///
/// `positions_mm` are those of the observations, one row each; `None` for one that has no place.
#[must_use]
pub fn clearest_patches(
    model: &dyn Model,
    at: &State,
    positions_mm: &[Option<Point3<f64>>],
) -> Vec<Patch> {
    let scene = Scene::of(model, at, positions_mm);
    let tried = scene.tried();
    let alone = scene.clearest(&tried);
    let beside = scene.clearest_beside_one(model, at, &tried);
    let is_other = |patch: &Patch| alone.is_none_or(|alone| !scene.are_alike(&alone, patch));
    alone.into_iter().chain(beside.filter(is_other)).collect()
}

/// Patches about a middle, by the readings that they hold.
fn about(center_mm: Point3<f64>, middles: &[Point3<f64>]) -> Vec<Patch> {
    let mut distances: Vec<f64> = middles.iter().map(|p| (p - center_mm).norm()).collect();
    distances.sort_by(f64::total_cmp);
    let patch = |k: usize| {
        let radius_mm = *distances.get(k)?;
        (radius_mm > 0.0).then_some(Patch { center_mm, radius_mm, steepness: 2, searched: 1 })
    };
    NEIGHBOURS.into_iter().filter_map(patch).collect()
}

/// A patch moved towards and away from readings that it holds, by a share of their distance, so that its middle stays
/// on the surface; and wider or narrower.
fn neighbours(patch: &Patch, step: f64, middles: &[Point3<f64>]) -> Vec<Patch> {
    let arms: Vec<Vector3<f64>> = (middles.iter().map(|p| p - patch.center_mm))
        .filter(|arm| arm.norm() <= patch.radius_mm)
        .collect();
    let ways = arms.iter().flat_map(|arm| [arm * step, arm * -step]);
    let sizes = [1.0 - step, 1.0, 1.0 + step].map(|grown| patch.radius_mm * grown);
    let moved = |by: Vector3<f64>| {
        sizes.map(|radius_mm| Patch { center_mm: patch.center_mm + by, radius_mm, ..*patch })
    };
    ways.chain([Vector3::zeros()]).flat_map(moved).collect()
}

/// The residual to be looked through, and where its rows lie.
struct Scene {
    residual: LookedThrough,
    positions: Vec<Option<Point3<f64>>>,
}

impl Scene {
    fn of(model: &dyn Model, at: &State, positions_mm: &[Option<Point3<f64>>]) -> Self {
        let residual = LookedThrough::of(model, at);
        let rows = &model.declared().layout.rows;
        let position = |&row: &usize| *positions_mm.get(rows[row].observation)?;
        Self { positions: residual.rows().iter().map(position).collect(), residual }
    }

    fn middles(&self) -> Vec<Point3<f64>> {
        self.positions.iter().flatten().copied().collect()
    }

    /// Patches that are tried at first.
    fn tried(&self) -> Vec<Patch> {
        let middles = self.middles();
        let every = middles.len().div_ceil(MOST_MIDDLES).max(1);
        middles.iter().step_by(every).flat_map(|center_mm| about(*center_mm, &middles)).collect()
    }

    /// The clearest patch of those tried and what lies about it; `None` where white noise might show it.
    fn clearest(&self, tried: &[Patch]) -> Option<Patch> {
        let clearest = self.best_of(tried.iter().copied())?;
        self.refined(clearest, tried.len(), &STEEPNESS)
    }

    fn best_of(&self, patches: impl Iterator<Item = Patch>) -> Option<(f64, Patch)> {
        let explained = patches.filter_map(|p| Some((self.explained(&p)?, p)));
        explained.max_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// A patch put where it explains most, with a steep edge where that explains clearly more, if it is clear of so many
    /// that were tried.
    fn refined(&self, clearest: (f64, Patch), searched: usize, edges: &[i32]) -> Option<Patch> {
        let middles = self.middles();
        let mut found = self.moved(clearest, &REFINED, &middles);
        for &steepness in edges {
            let (most, bell) = found;
            let steep =
                EDGES.map(|grown| Patch { radius_mm: bell.radius_mm * grown, steepness, ..bell });
            let Some(best) = self.best_of(steep.into_iter()) else { continue };
            let best = self.moved(best, &STEEP, &middles);
            let more = best.0 - most;
            let is_most = best.0 >= MOSTLY * self.residual.values().norm_squared();
            if is_most && more >= STEEPER.powi(2) * self.noise_beside(&best.1) {
                found = best;
            }
        }
        let (_, best) = found;
        let searched = searched * (1 + edges.len());
        let best = Patch { searched, ..best }.rounded();
        let (explained, by_others) = (self.explained(&best)?, self.explained_by_others(&best)?);
        let is_clear = self.residual.p_value(explained, 1) * count(searched) <= FALSE_ALARM;
        (is_clear && self.residual.p_value(by_others, 1) <= FALSE_ALARM).then_some(best)
    }

    /// Variance of what is left beside a patch, by its median: a reading far off hides no edge.
    fn noise_beside(&self, patch: &Patch) -> f64 {
        let Some(left) = self.left_of(patch) else { return f64::INFINITY };
        let left = left.column(0);
        let height = left.dot(self.residual.values()) / left.norm_squared();
        let rest = self.residual.values() - left * height;
        let mut deviations: Vec<f64> = rest.iter().map(|value| value.abs()).collect();
        let middle = deviations.len() / 2;
        let (_, median, _) = deviations.select_nth_unstable_by(middle, f64::total_cmp);
        (OF_MEDIAN * *median).powi(2)
    }

    /// A patch moved, widened and narrowed for as long as it explains more.
    fn moved(
        &self,
        (mut most, mut best): (f64, Patch),
        steps: &[f64],
        middles: &[Point3<f64>],
    ) -> (f64, Patch) {
        for &step in steps {
            let about = neighbours(&best, step, middles);
            let better = self.best_of(about.into_iter()).filter(|(more, _)| *more > most);
            if let Some(better) = better {
                (most, best) = better;
            }
        }
        (most, best)
    }

    /// The patch that explains most together with one effect of the catalogue; `None` where the
    /// effect explains no more beside the patch than chance does.
    fn clearest_beside_one(&self, model: &dyn Model, at: &State, tried: &[Patch]) -> Option<Patch> {
        let effects = &model.declared().effects;
        let is_asked = |e: &usize| {
            effects[*e].scope == Scope::Everywhere || effects[*e].scope == Scope::SomeDesigns
        };
        let asked = (0..effects.len()).filter(|e| is_asked(e) && !at.has(*e));
        let others: Vec<DMatrix<f64>> =
            asked.filter_map(|e| self.residual.left_of_effect(model, at, e)).collect();
        let taken: Vec<DVector<f64>> =
            others.iter().map(|o| o.tr_mul(self.residual.values())).collect();
        let together = |patch: &Patch| {
            let left = self.left_of(patch)?;
            let left = left.column(0);
            let (whole, score) = (left.norm_squared(), left.dot(self.residual.values()));
            let of = |(index, other): (usize, &DMatrix<f64>)| {
                let shared = other.tr_mul(&left);
                let own = whole - shared.norm_squared();
                let more = (score - shared.dot(&taken[index])).powi(2) / own;
                (own >= SEEN * whole).then(|| (taken[index].norm_squared() + more, index))
            };
            others.iter().enumerate().filter_map(of).max_by(|a, b| a.0.total_cmp(&b.0))
        };
        let all = tried.iter().filter_map(|p| Some((together(p)?, *p)));
        let ((_, other), patch) = all.max_by(|a, b| a.0.0.total_cmp(&b.0.0))?;
        let beside = Self {
            residual: self.residual.beside(&others[other]),
            positions: self.positions.clone(),
        };
        let searched = tried.len() * others.len();
        let patch = beside.refined((beside.explained(&patch)?, patch), searched, &[])?;
        let both = taken[other].norm_squared() + beside.explained(&patch)?;
        let more = both - self.explained(&patch)?;
        let p_value = self.residual.p_value_of_more(more, others[other].ncols(), both);
        (p_value * count(others.len()) <= FALSE_ALARM).then_some(patch)
    }

    /// Whether two patches are one but for the readings' noise.
    fn are_alike(&self, a: &Patch, b: &Patch) -> bool {
        let (Some(a), Some(b)) = (self.left_of(a), self.left_of(b)) else { return false };
        a.dot(&b) >= ALIKE * a.norm() * b.norm()
    }

    /// What a patch takes of the sum of squares.
    fn explained(&self, patch: &Patch) -> Option<f64> {
        self.residual.explained(&self.left_of(patch)?)
    }

    /// What a patch takes of the sum of squares without the two readings that show it most: two
    /// that are far off, side by side, are none.
    fn explained_by_others(&self, patch: &Patch) -> Option<f64> {
        let left = self.left_of(patch)?;
        let mut shown: Vec<[f64; 2]> =
            left.iter().zip(self.residual.values()).map(|(l, r)| [l * r, l * l]).collect();
        let way = shown.iter().map(|[along, _]| along).sum::<f64>().signum();
        shown.sort_by(|a, b| (way * b[0]).total_cmp(&(way * a[0])));
        let rest = shown.iter().skip(FAR_OFF);
        let [along, squares] = rest.fold([0.0; 2], |sum, v| [sum[0] + v[0], sum[1] + v[1]]);
        (way * along > 0.0).then(|| along * along / squares)
    }

    /// The trace of a patch that the fitted parameters leave; `None` of one that is too wide or too
    /// narrow, or that they take up.
    fn left_of(&self, patch: &Patch) -> Option<DMatrix<f64>> {
        let at = |p: &Option<Point3<f64>>| p.map_or(0.0, |p| patch.share(&p));
        let shares = DMatrix::from_iterator(self.positions.len(), 1, self.positions.iter().map(at));
        let edge = (-2.0_f64).exp();
        let within = shares.iter().filter(|share| **share >= edge).count();
        let places = self.positions.iter().flatten().count();
        if within < FEWEST_WITHIN || count(within) > MOST_WITHIN * count(places) {
            return None;
        }
        let tangent = self.residual.whitened(shares);
        let whole = tangent.norm_squared();
        Some(self.residual.left_of(tangent)).filter(|left| left.norm_squared() >= SEEN * whole)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_printed_is_what_is_used_at_every_radius() {
        for k in 1..4000 {
            let radius_mm = 0.013 * f64::from(k);
            let center_mm = Point3::new(1.0 / 3.0, -20.0 / 7.0, 1e-5) * radius_mm;
            let patch = Patch { center_mm, radius_mm, steepness: 2, searched: 1 }.rounded();
            assert_eq!(patch.rounded(), patch);
            let subject = patch.effect(&[]).subject.unwrap();
            let place = subject.trim_matches(|c| "() m".contains(c)).split(',');
            let said: Vec<f64> = place.map(|v| v.trim().parse().unwrap()).collect();
            assert_eq!(said, patch.center_mm.coords.as_slice());
        }
    }
}
