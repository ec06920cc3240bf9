//! The load of a press, as a covariate has it.

use crate::missing::press_design::{Design, PressPoint, load_n};
use crate::missing::press_drag::{CLEAR, LEAST_LEVER_MM};
use crate::missing::sensor_errors::{Corrected, SensorErrors};

/// Load of each press, N: the mean of all those that differ by no more than noise.
///
/// The noise of Fz is in the centre, times the centre's distance over Fz. What followed the order of loads that were
/// set alike, or took presses for neighbours that read them alike, would find that noise in the centres again.
pub(crate) fn loads_n(design: &Design, points: &[PressPoint]) -> Vec<f64> {
    let read_n: Vec<f64> = points.iter().map(load_n).collect();
    let noise_n: Vec<f64> = points.iter().map(|point| noise_n(design, point)).collect();
    let mut order: Vec<usize> = (0..read_n.len()).collect();
    order.sort_by(|&a, &b| read_n[a].total_cmp(&read_n[b]));
    let apart = |a: usize, b: usize| (read_n[a] - read_n[b]).abs();
    let mut loads_n = read_n.clone();
    for alike in order.chunk_by(|&a, &b| apart(a, b) <= CLEAR * noise_n[a].max(noise_n[b])) {
        let largest = alike.iter().map(|&i| noise_n[i]).fold(0.0, f64::max);
        // What goes on and on in small steps was not set alike.
        if apart(alike[0], alike[alike.len() - 1]) <= 2.0 * CLEAR * largest {
            let mean = alike.iter().map(|&i| read_n[i]).sum::<f64>() / crate::count(alike.len());
            // With the digits that it has.
            let per_digit = 10f64.powf(-largest.log10().floor());
            let load_n = if largest > 0.0 { (mean * per_digit).round() / per_digit } else { mean };
            for &i in alike {
                loads_n[i] = load_n;
            }
        }
    }
    loads_n
}

/// Most that the noise of Fz can be: it is in the centre along the way to it, and all that is there.
fn noise_n(design: &Design, point: &PressPoint) -> f64 {
    let center_mm = Corrected::of(&point.reading, &SensorErrors::default(), design.z0_mm).center_mm;
    let distance_mm = center_mm.norm();
    let along = center_mm.try_normalize(0.0).unwrap_or_default();
    let variance_mm2 = along.dot(&(point.covariance_mm2 * along));
    variance_mm2.max(0.0).sqrt() * load_n(point) / distance_mm.max(LEAST_LEVER_MM)
}

#[cfg(test)]
mod tests {
    use geometry::Wrench;
    use nalgebra::{Matrix2, Point2, Vector2, Vector3};

    use super::*;
    use crate::Handedness;
    use crate::missing::press_effects::Catalogue;
    use crate::missing::sensor_errors::Reading;

    /// 100 mm beside the sensor a centre good to 10 µm has no more than 2 mN of noise in 20 N.
    #[test]
    fn loads_that_were_set_alike_are_the_same_and_a_ramp_stays() {
        let design = Design {
            z0_mm: 0.0,
            handedness: Handedness::Same,
            pivot_mm: Point2::origin(),
            catalogue: Catalogue::default(),
        };
        let point = |load_n: f64| PressPoint {
            machine_mm: Point2::origin(),
            reading: Reading {
                wrench: Wrench {
                    force_n: Vector3::new(0.0, 0.0, -load_n),
                    torque_nmm: Vector3::new(0.0, 100.0 * load_n, 0.0),
                },
                drag_n: Vector2::zeros(),
                elapsed_ratio: 0.0,
            },
            covariance_mm2: Matrix2::identity() * 1e-4,
            warmth_k: Vec::new(),
            come: Vec::new(),
            observation: None,
        };
        let of = |loads: &[f64]| {
            loads_n(&design, &loads.iter().map(|load| point(*load)).collect::<Vec<_>>())
        };
        let same = |a: f64, b: f64| (a - b).abs() < 1e-9;
        let set = of(&[20.004, 40.0, 19.998, 20.001, 20.1]);
        let expected = [20.001, 40.0, 20.001, 20.001, 20.1];
        assert!(set.iter().zip(expected).all(|(a, b)| same(*a, b)), "{set:?}");
        let ramp: Vec<f64> = (0..50).map(|i| 20.0 + 0.01 * f64::from(i)).collect();
        assert!(of(&ramp).iter().zip(&ramp).all(|(a, b)| same(*a, *b)));
    }
}
