//! How well a head comes back to the same place.

use nalgebra::Vector2;

use crate::{Center, SolvedPress};

/// Scatter of presses of one commanded place, pooled over places.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Repeatability {
    /// Places that were pressed more than once.
    pub places: usize,
    /// Presses at these places.
    pub presses: usize,
    /// `presses − places`.
    pub degrees_of_freedom: usize,
    /// Standard deviation of one press along the machine's x and y.
    pub std_mm: Vector2<f64>,
}

/// Pools presses whose commanded positions are the same number for number; `None` where no place
/// was pressed twice.
///
/// Noise of the records is in it: it is what a user of the head sees.
#[must_use]
pub fn repeatability(presses: &[SolvedPress], centers: &[Center]) -> Option<Repeatability> {
    let (mut places, mut repeated) = (0, 0);
    let mut squares = Vector2::zeros();
    let mut left: Vec<usize> = (0..presses.len().min(centers.len())).collect();
    while let Some(&first) = left.first() {
        let at = presses[first].machine_mm;
        let (own, others): (Vec<usize>, Vec<usize>) =
            left.iter().partition(|i| presses[**i].machine_mm == at);
        left = others;
        if own.len() > 1 {
            let n = crate::count(own.len());
            let mean = own.iter().map(|i| centers[*i].offset_mm).sum::<Vector2<f64>>() / n;
            let deviation = |i: &usize| centers[*i].offset_mm - mean;
            squares += own.iter().map(|i| deviation(i).map(|v| v * v)).sum::<Vector2<f64>>();
            (places, repeated) = (places + 1, repeated + own.len());
        }
    }
    let degrees_of_freedom = repeated - places;
    (degrees_of_freedom > 0).then(|| Repeatability {
        places,
        presses: repeated,
        degrees_of_freedom,
        std_mm: squares.map(|s| (s / crate::count(degrees_of_freedom)).sqrt()),
    })
}
