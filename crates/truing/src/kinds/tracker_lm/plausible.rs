//! Whether the errors found of an axis can be true of a machine.

use crate::implausible::ImplausibleResult;

/// Largest rotation of a rotary axis about itself that is a correction, in degrees: what a worm of
/// fifty teeth is wrong by when it has jumped a seventh of a tooth.
pub(super) const MAX_ROTATION_DEG: f64 = 1.0;

/// Largest displacement of an axis from where it was declared that is an error of location.
const MAX_LOCATION_MM: f64 = 50.0;

/// Largest rotation of an axis from where it was declared that is an error of location, in degrees.
const MAX_LOCATION_DEG: f64 = 5.0;

/// Change of the rotation error per angle beyond which the axis turns the other way: an axis that is
/// declared reversed turns by the angle backwards, and is wrong by twice of it; the sign is that of the
/// letter's axis against the declared direction.
const REVERSED: f64 = 1.5;

/// What was found of an axis, as far as it can be beyond any machine.
pub(super) struct FoundAxis<'a> {
    pub(super) letter: char,
    /// Declared direction.
    pub(super) direction: [f64; 3],
    /// Angle and rotation error about the axis itself, degrees.
    pub(super) own_rotation_deg: &'a [[f64; 2]],
    /// Name and value of each error of location: two displacements in mm, two rotations in rad.
    pub(super) location: Vec<(&'a str, f64)>,
}

/// A compensation, or a place of the axis, beyond any machine.
pub(super) fn implausible(axis: &FoundAxis<'_>, limit_deg: f64) -> Option<ImplausibleResult> {
    let own = axis.own_rotation_deg;
    let [at_deg, found_deg] =
        own.iter().copied().max_by(|a, b| a[1].abs().total_cmp(&b[1].abs())).unwrap_or([0.0; 2]);
    if found_deg.abs() > limit_deg {
        if slope(own).abs() > REVERSED {
            let reversed = axis.direction.map(|v| if v == 0.0 { 0.0 } else { -v });
            let largest_deg = found_deg.abs();
            return Some(ImplausibleResult::Reversed { largest_deg, reversed });
        }
        let letter = axis.letter;
        return Some(ImplausibleResult::Compensation { letter, found_deg, at_deg, limit_deg });
    }
    axis.location.iter().enumerate().find_map(|(i, (name, value))| {
        let (found, unit, limit) = if i < 2 {
            (*value, "mm", MAX_LOCATION_MM)
        } else {
            (value.to_degrees(), "°", MAX_LOCATION_DEG)
        };
        let name = (*name).to_owned();
        (found.abs() > limit).then_some(ImplausibleResult::Location { name, found, unit, limit })
    })
}

/// Median change of the error from angle to angle, per angle; a rotation comes round again after a
/// turn.
fn slope(points: &[[f64; 2]]) -> f64 {
    let mut ascending = points.to_vec();
    ascending.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let change = |pair: &[[f64; 2]]| {
        let error_deg = (pair[1][1] - pair[0][1] + 180.0).rem_euclid(360.0) - 180.0;
        error_deg / (pair[1][0] - pair[0][0])
    };
    let mut slopes: Vec<f64> =
        ascending.windows(2).filter(|pair| pair[1][0] > pair[0][0]).map(change).collect();
    slopes.sort_by(f64::total_cmp);
    slopes.get(slopes.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::slope;

    #[test]
    fn slope_of_a_reversed_axis_is_minus_two() {
        let wrapped = |deg: f64| (deg + 180.0).rem_euclid(360.0) - 180.0;
        let points: Vec<[f64; 2]> =
            (0..=18).map(|i| f64::from(i) * 10.0).map(|a| [a, wrapped(-2.0 * a)]).collect();
        assert!((slope(&points) + 2.0).abs() < 1e-12);
        assert!(slope(&[[0.0, 0.0]]).abs() < f64::EPSILON);
    }
}
