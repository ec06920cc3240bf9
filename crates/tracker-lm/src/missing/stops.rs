//! Angles at which an axis stopped, and courses of its errors over them.

use nalgebra::Vector6;

use crate::RotaryAxis;
use crate::curves::Shape;

/// Angles of a survey, and how often each was visited.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stops<'a> {
    pub(crate) axis: &'a RotaryAxis,
    pub(crate) angles_rad: &'a [f64],
    pub(crate) visits: &'a [usize],
}

/// Levels of a value at every angle: more are no longer a table that anyone enters.
const MOST_LEVELS: usize = 64;
/// Fewest angles at which values say more than harmonics.
const FEWEST_LEVELS: usize = 3;
/// Fewest visits of an angle, on the mean. Stops need not scatter alike: two visits of an angle show
/// its own scatter by one difference, and as many variances of one degree of freedom each bound no
/// joint test of the values.
const FEWEST_VISITS: usize = 3;

impl Stops<'_> {
    /// Whether angles are visited so often that a value at each of them can be told from noise.
    pub(crate) fn are_repeated(&self) -> bool {
        let n_visits: usize = self.visits.iter().sum();
        let n_angles = self.angles_rad.len();
        (FEWEST_LEVELS..=MOST_LEVELS).contains(&n_angles) && n_visits >= FEWEST_VISITS * n_angles
    }
}

/// One error as the sine or cosine of a multiple of the angle.
pub(crate) fn harmonic(
    angles_rad: &[f64],
    component: usize,
    order: u8,
    wave: fn(f64) -> f64,
) -> Shape {
    along(component, angles_rad.iter().map(|angle| wave(f64::from(order) * angle)))
}

/// One error with these values at the angles.
pub(crate) fn along(component: usize, by_angle: impl Iterator<Item = f64>) -> Shape {
    Shape::Motion(by_angle.map(|value| value * Vector6::ith(component, 1.0)).collect())
}
