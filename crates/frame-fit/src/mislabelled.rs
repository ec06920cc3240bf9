//! Poses that carry the name of another place than the one they hold the tip at.

use nalgebra::{DVector, Vector3};

use crate::tip::{Design, place_mm};
use crate::{FrameFitError, TipPose};

/// Rounds of the robust fit and of the exchange of names; both settle in far fewer.
const ROUNDS: usize = 30;
/// A pose is another place's where it lies this much nearer to it.
const NEARER: f64 = 0.25;
/// Largest share of poses whose names may be wrong: of more, nobody knows which ones are right.
const LARGEST_SHARE: f64 = 1.0 / 3.0;
/// Smallest distance that weighs a pose, over the median one: no pose holds the fit alone.
const LEAST_OF_MEDIAN: f64 = 0.1;

/// A pose and where it belongs.
#[derive(Clone, Debug, PartialEq)]
pub struct Mislabelled {
    /// Its index.
    pub pose: usize,
    /// Index of a pose that holds the tip at the right place, and carries its name.
    pub like: usize,
    /// Distance of its tip from the place that it names, mm.
    pub from_named_mm: f64,
    /// Distance of its tip from the place where it belongs, mm.
    pub from_own_mm: f64,
}

/// Poses whose tip is at another place than they say, beside all others; empty where none is.
///
/// Tip and places are fitted by least absolute distances, which up to half of the poses of a place
/// cannot pull away; poses that lie four times nearer to another place get its name, and the fit is
/// repeated until no name changes.
///
/// # Errors
///
/// As [`fit_tip`](crate::fit_tip).
pub fn mislabelled(poses: &[TipPose]) -> Result<Vec<Mislabelled>, FrameFitError> {
    let named = Design::of(poses, &[])?;
    let mut design = named.clone();
    let mut x = robust(&design)?;
    for _ in 0..ROUNDS {
        let moved: Vec<usize> = (0..poses.len()).map(|i| nearest(&named, &x, i)).collect();
        if moved == design.at {
            break;
        }
        design.at = moved;
        x = robust(&design)?;
    }
    let changed: Vec<usize> = (0..poses.len()).filter(|&i| design.at[i] != named.at[i]).collect();
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let share = changed.len() as f64 / poses.len() as f64;
    if share > LARGEST_SHARE {
        return Ok(Vec::new());
    }
    let describe = |pose: usize| {
        let own = design.at[pose];
        let like = (0..poses.len()).find(|&i| named.at[i] == own && design.at[i] == own)?;
        let tip = tip_at(&named, &x, pose);
        Some(Mislabelled {
            pose,
            like,
            from_named_mm: (tip - place_mm(&x, named.at[pose])).norm(),
            from_own_mm: (tip - place_mm(&x, own)).norm(),
        })
    };
    Ok(changed.into_iter().filter_map(describe).collect())
}

/// The place that a pose names, or the one that it lies much nearer to.
fn nearest(named: &Design, x: &DVector<f64>, pose: usize) -> usize {
    let tip = tip_at(named, x, pose);
    let distance = |place: usize| (tip - place_mm(x, place)).norm();
    let own = named.at[pose];
    let best = (0..named.names.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
    best.filter(|&best| distance(best) < NEARER * distance(own)).unwrap_or(own)
}

fn tip_at(design: &Design, x: &DVector<f64>, pose: usize) -> Vector3<f64> {
    design.positions_mm[pose] + design.rotations[pose] * x.fixed_rows::<3>(0)
}

/// Tip and places of least summed distance, by weights of one over the distance.
fn robust(design: &Design) -> Result<DVector<f64>, FrameFitError> {
    let n = design.at.len();
    let mut weights = vec![1.0; n];
    let mut x = design.closed_form(&weights)?;
    for _ in 0..ROUNDS {
        let distances: Vec<f64> =
            (0..n).map(|i| (tip_at(design, &x, i) - place_mm(&x, design.at[i])).norm()).collect();
        let mut sorted = distances.clone();
        sorted.sort_by(f64::total_cmp);
        let least = LEAST_OF_MEDIAN * sorted[n / 2];
        if least <= 0.0 {
            break;
        }
        weights.iter_mut().zip(&distances).for_each(|(w, d)| *w = least / d.max(least));
        x = design.closed_form(&weights)?;
    }
    Ok(x)
}
