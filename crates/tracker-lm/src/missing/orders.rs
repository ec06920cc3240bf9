//! How many harmonics each motion error of a perfect axis shows.
//!
//! Two are offered of each; more where the residual of the declared model, with the location of the
//! axis and all other motion errors in it, shows one so clearly that white noise does it once in a
//! hundred surveys. Looked at one by one instead, every error would seem to have all the harmonics
//! that another has.

use model_discrepancy::chance_to_explain;
use nalgebra::{DMatrix, DVector};

use crate::curves::{LOCATION, Shape};
use crate::missing::stops::{Stops, harmonic};

/// Highest order of every error that is offered, and how many were looked at to find it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Orders {
    pub(crate) highest: [u8; 6],
    pub(crate) searched: [usize; 6],
    /// Whether a value at every angle is offered as well.
    pub(crate) by_angle: bool,
    /// Whether the place of the axis is offered.
    pub(crate) location: bool,
}

/// Harmonics that are offered in any case.
const USUAL: u8 = 2;
/// Harmonics that are looked for at most: lobes of a bearing; the teeth of a gear are finer than the
/// stops of a survey.
const MOST: u8 = 8;
/// Chance that a survey without a further harmonic shows one.
const FALSE_ALARM: f64 = 0.01;
/// Share of a column's length below which nothing of it is left.
const NOTHING_LEFT: f64 = 1e-3;

impl Orders {
    /// Those that are offered whatever the residual shows.
    pub(crate) fn usual(stops: &Stops<'_>) -> Self {
        let highest = [USUAL.min(resolved(stops.angles_rad)); 6];
        Self { highest, searched: [1; 6], by_angle: stops.are_repeated(), location: true }
    }

    /// What the residual shows; `rows` gives the whitened columns of shapes of the six errors.
    pub(crate) fn shown(
        stops: &Stops<'_>,
        basis: &DMatrix<f64>,
        residual: &DVector<f64>,
        rows: impl Fn(&[Shape]) -> DMatrix<f64>,
    ) -> Self {
        let mut orders = Self::usual(stops);
        let angles_rad = stops.angles_rad;
        let most = MOST.min(resolved(angles_rad));
        if most <= USUAL {
            return orders;
        }
        let pair = |component: usize, order: u8| {
            let of = |wave| harmonic(angles_rad, component, order, wave);
            [of(f64::cos as fn(f64) -> f64), of(f64::sin)]
        };
        let mut known = Known::new(basis, residual);
        known.add(&rows(&LOCATION));
        for component in 0..6 {
            let own: Vec<Shape> =
                (1..=orders.highest[component]).flat_map(|order| pair(component, order)).collect();
            known.add(&rows(&own));
        }
        let steps = usize::from(most - USUAL);
        let further: Vec<Vec<DMatrix<f64>>> = (0..6)
            .map(|c| (USUAL + 1..=most).map(|order| rows(&pair(c, order))).collect())
            .collect();
        loop {
            let mut best: Option<(f64, usize, u8)> = None;
            for (component, columns) in further.iter().enumerate() {
                for order in orders.highest[component] + 1..=most {
                    let new = &columns[usize::from(orders.highest[component] - USUAL)
                        ..usize::from(order - USUAL)];
                    let p_value = known.p_value(new);
                    if best.is_none_or(|(least, ..)| p_value < least) {
                        best = Some((p_value, component, order));
                    }
                }
            }
            let tried = 6.0 * f64::from(most - USUAL);
            let Some((p_value, component, order)) = best else { return orders };
            if p_value * tried > FALSE_ALARM {
                return orders;
            }
            let from = usize::from(orders.highest[component] - USUAL);
            for columns in &further[component][from..usize::from(order - USUAL)] {
                known.add(columns);
            }
            orders.highest[component] = order;
            orders.searched[component] = steps;
        }
    }
}

/// Highest order that the angles tell from a lower one: a quarter of what they could hold at even
/// distances, so that six errors and their place leave rows to judge them by.
fn resolved(angles_rad: &[f64]) -> u8 {
    let orders = angles_rad.len().saturating_sub(1) / 3;
    u8::try_from(orders.min(usize::from(MOST))).unwrap_or(MOST)
}

/// What is in the model so far.
struct Known {
    /// Orthonormal.
    basis: Vec<DVector<f64>>,
    residual: DVector<f64>,
}

impl Known {
    fn new(basis: &DMatrix<f64>, residual: &DVector<f64>) -> Self {
        let basis = basis.column_iter().map(nalgebra::Matrix::into_owned).collect();
        Self { basis, residual: residual.clone() }
    }

    fn add(&mut self, columns: &DMatrix<f64>) {
        for new in left_of(&self.basis, columns) {
            let share = new.dot(&self.residual);
            self.residual.axpy(-share, &new, 1.0);
            self.basis.push(new);
        }
    }

    /// That columns explain nothing.
    fn p_value(&self, columns: &[DMatrix<f64>]) -> f64 {
        let mut new: Vec<DVector<f64>> = Vec::new();
        for columns in columns {
            let all: Vec<_> = self.basis.iter().chain(&new).cloned().collect();
            new.extend(left_of(&all, columns));
        }
        let dof = self.residual.len().saturating_sub(self.basis.len() + new.len());
        let explained: f64 = new.iter().map(|n| n.dot(&self.residual).powi(2)).sum();
        let left = (self.residual.norm_squared() - explained).max(0.0);
        chance_to_explain(explained / left, new.len(), dof)
    }
}

/// Orthonormal directions of the columns that a basis does not hold.
fn left_of(basis: &[DVector<f64>], columns: &DMatrix<f64>) -> Vec<DVector<f64>> {
    let mut new: Vec<DVector<f64>> = Vec::new();
    for column in columns.column_iter() {
        let mut rest = column.into_owned();
        let length = rest.norm();
        for _ in 0..2 {
            for known in basis.iter().chain(&new) {
                let share = known.dot(&rest);
                rest.axpy(-share, known, 1.0);
            }
        }
        let left = rest.norm();
        if left > NOTHING_LEFT * length {
            rest.unscale_mut(left);
            new.push(rest);
        }
    }
    new
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::curves::Curves;
    use crate::{AxisLetter, RotaryAxis};

    /// Surveys of white noise alone: one in a hundred shows a further harmonic, so that of these it is
    /// fifteen, with a standard deviation of four.
    const SURVEYS: u32 = 1500;
    const EXPECTED: f64 = 15.0;
    const DEVIATION: f64 = 3.9;

    #[test]
    fn one_survey_in_a_hundred_seems_to_have_a_further_harmonic() {
        let axis = RotaryAxis::new(AxisLetter::C, Point3::origin(), nalgebra::Vector3::z());
        let axis = axis.unwrap();
        // Ten angles resolve one harmonic beyond those that are offered in any case.
        let angles_rad: Vec<f64> = (0..10).map(|k| 0.6 * f64::from(k)).collect();
        let stops = Stops { axis: &axis, angles_rad: &angles_rad, visits: &[1; 10] };
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let slopes: Vec<[f64; 6]> =
            (0..80).map(|_| std::array::from_fn(|_| rng.random_range(-1.0..1.0))).collect();
        let rows = |shapes: &[Shape]| {
            let curves = Curves::new(&axis, &angles_rad, shapes.to_vec());
            let at: Vec<_> =
                (0..10).map(|k| curves.at(k, &vec![0.0; shapes.len()]).slopes).collect();
            DMatrix::from_fn(slopes.len(), shapes.len(), |i, j| {
                slopes[i].iter().zip(&at[i % 10][j]).map(|(slope, error)| slope * error).sum()
            })
        };
        let basis = DMatrix::zeros(slopes.len(), 0);
        let mut shown = 0;
        for _ in 0..SURVEYS {
            let noise = DVector::from_fn(slopes.len(), |_, _| StandardNormal.sample(&mut rng));
            let orders = Orders::shown(&stops, &basis, &noise, rows);
            shown += u32::from(orders.highest != [USUAL; 6]);
        }
        assert!((f64::from(shown) - EXPECTED).abs() < 3.0 * DEVIATION, "{shown}");
    }
}
