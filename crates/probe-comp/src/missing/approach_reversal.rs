//! Axes that read otherwise by the approach, where the touches show it.

use model_discrepancy::Left;
use nalgebra::{Unit, Vector3};

use super::form::{Form, FormScale};
use crate::nominal::NominalFoot;

/// Touches from either side of an axis from which its reversal can be told: of fewer, which side each came
/// from is a pattern that the part may have as well.
pub(super) const EACH_WAY: usize = 5;
/// Standard uncertainties from which on it is seen beside all that is smooth, and from which on it may be there instead of
/// several of these.
const SEEN: f64 = 3.0;
const HARDLY_SEEN: f64 = 1.0;

/// Those of `axes` whose reversal shows beside any error that goes smoothly with the normal, as a ball, a shift, a scale, a
/// stylus that gives way, or with the forms that the part may have.
///
/// Along the normal it is `|n|` of that axis, which anything curved resembles: among the candidates it would stand in for
/// all of them where a single touch is far off. Where it shows less, it is with `true`, to be looked for
/// [only instead](model_discrepancy::Effect::only_instead) of several.
pub(super) fn reversed_axes(
    axes: &[usize],
    (feet, approaches): (&[NominalFoot], &[Unit<Vector3<f64>>]),
    (forms, scale): (impl Iterator<Item = Form>, &FormScale),
) -> Vec<(usize, bool)> {
    let normal = |k: usize| feet.iter().map(move |foot| foot.normal[k]);
    let mut smooth = vec![vec![1.0; feet.len()]];
    for k in 0..3 {
        smooth.push(normal(k).collect());
        smooth.extend((0..=k).map(|j| normal(k).zip(normal(j)).map(|(a, b)| a * b).collect()));
    }
    for form in forms {
        let heights = feet.iter().map(|f| form.heights(scale, &f.point_mm));
        let heights: Vec<Vec<f64>> = heights.collect();
        let width = heights.first().map_or(0, Vec::len);
        smooth.extend((0..width).map(|k| heights.iter().map(|row| row[k]).collect()));
    }
    let distances: Vec<f64> = feet.iter().map(|foot| foot.distance_mm).collect();
    let left = Left::by(&smooth, &distances);
    let seen = |&axis: &usize| {
        let way = |approach: &Vector3<f64>| if approach[axis] < 0.0 { -1.0 } else { 1.0 };
        let ways: Vec<f64> = approaches.iter().map(|a| way(a)).collect();
        let comes = |sign: f64| ways.iter().filter(|way| **way * sign > 0.0).count() >= EACH_WAY;
        let kink = normal(axis).zip(&ways).map(|(n, way)| n * way).collect();
        let in_sigmas = left.taken_by(&[kink]).in_sigmas();
        let may_be = comes(1.0) && comes(-1.0) && in_sigmas >= HARDLY_SEEN;
        may_be.then_some((axis, in_sigmas < SEEN))
    };
    axes.iter().filter_map(seen).collect()
}
