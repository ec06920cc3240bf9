//! Axes that read otherwise by the approach, where the touches show it.

use model_discrepancy::Taken;
use nalgebra::Vector3;

use super::catalogue::Setting;

/// Mean square of a normal's component from which a motion along that axis can be told.
const SHOWN: f64 = 0.01;
/// Touches from either side of an axis from which its reversal can be told: of fewer, which side each came
/// from is a pattern that the part may have as well.
const EACH_WAY: usize = 5;
/// Standard uncertainties from which on it is seen beside all that is smooth.
const SEEN: f64 = 3.0;

/// Those whose reversal shows beside any error that goes smoothly with the normal, as a ball, a shift, a scale, a
/// stylus that gives way, or with the forms that the part may have.
///
/// Along the normal it is `|n|` of that axis, which anything curved resembles: among the candidates it would stand in for
/// all of them where a single touch is far off.
pub(super) fn reversed_axes(setting: &Setting<'_>) -> Vec<usize> {
    let normal = |k: usize| setting.feet.iter().map(move |foot| foot.normal[k]);
    let mut smooth = vec![vec![1.0; setting.feet.len()]];
    for k in 0..3 {
        smooth.push(normal(k).collect());
        smooth.extend((0..=k).map(|j| normal(k).zip(normal(j)).map(|(a, b)| a * b).collect()));
    }
    for (form, _) in &setting.forms {
        let heights = setting.feet.iter().map(|f| form.heights(&setting.form_scale, &f.point_mm));
        let heights: Vec<Vec<f64>> = heights.collect();
        let width = heights.first().map_or(0, Vec::len);
        smooth.extend((0..width).map(|k| heights.iter().map(|row| row[k]).collect()));
    }
    let distances: Vec<f64> = setting.feet.iter().map(|foot| foot.distance_mm).collect();
    let is_seen = |axis: &usize| {
        let way = |approach: &Vector3<f64>| if approach[*axis] < 0.0 { -1.0 } else { 1.0 };
        let ways: Vec<f64> = setting.approaches.iter().map(|a| way(a)).collect();
        let comes = |sign: f64| ways.iter().filter(|way| **way * sign > 0.0).count() >= EACH_WAY;
        let kink = normal(*axis).zip(&ways).map(|(n, way)| n * way).collect();
        setting.normal_squares[*axis] > SHOWN
            && comes(1.0)
            && comes(-1.0)
            && Taken::beside(&smooth, &[kink], &distances).in_sigmas() >= SEEN
    };
    (0..3).filter(is_seen).collect()
}
