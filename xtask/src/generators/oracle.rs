//! What somebody who knows everything but the noise would get from a session.

use crate::generators::vector::{norm, orthogonalise};
use crate::kinds::ft_center::press::{Press, Recorded, Role};

/// Least normal force of a sample in contact, N.
const CONTACT_N: f64 = 5.0;

/// Centre of a press in the sensor's frame, mm.
///
/// Constant part of a least-squares fit of a constant and two harmonics of the known spin to
/// x = (z Fx − My)/Fz, y = (Mx + z Fy)/Fz (\[A\] 1.11): the mean, with what an incomplete turn
/// leaves of the orbit taken out.
pub(crate) fn center_mm(press: &Press, height_mm: f64) -> [f64; 2] {
    let touching: Vec<_> =
        press.samples.iter().filter(|(_, wrench)| wrench[2].abs() > CONTACT_N).collect();
    let turn = |t: f64| std::f64::consts::TAU * press.spin_hz * t;
    let column = |f: &dyn Fn(f64) -> f64| touching.iter().map(|(t, _)| f(*t)).collect::<Vec<_>>();
    let harmonics = [
        column(&|t| turn(t).cos()),
        column(&|t| turn(t).sin()),
        column(&|t| (2.0 * turn(t)).cos()),
        column(&|t| (2.0 * turn(t)).sin()),
    ];
    let mut constant = column(&|_| 1.0);
    orthogonalise(&mut constant, &harmonics);
    let length: f64 = constant.iter().map(|v| v * v).sum();
    let mut sum = [0.0; 2];
    for (weight, (_, [fx, fy, fz, mx, my, _])) in constant.iter().zip(touching) {
        sum[0] += weight * (height_mm * fx - my) / fz;
        sum[1] += weight * (mx + height_mm * fy) / fz;
    }
    sum.map(|s| s / length)
}

/// Centres of all presses in the sensor's frame, mm.
pub(crate) fn centers_mm(recorded: &Recorded) -> Vec<[f64; 2]> {
    recorded.presses.iter().map(|p| center_mm(p, recorded.declared_height_mm)).collect()
}

/// Root mean square distance of the check presses from where the machine says they are, with the
/// sensor's true place known, mm.
pub(crate) fn check_error_mm(recorded: &Recorded) -> f64 {
    let centers = centers_mm(recorded);
    let mut sum = 0.0;
    let mut count = 0.0;
    for (press, center) in recorded.presses.iter().zip(centers) {
        if press.role == Role::Check {
            let truth = recorded.in_sensor(press.commanded_mm);
            sum += norm(&[center[0] - truth[0], center[1] - truth[1]]).powi(2);
            count += 1.0;
        }
    }
    (sum / f64::max(count, 1.0)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::ft_center::press::{Fault, Session, simulate};

    /// Of a record without noise the fit misses the centre by the mean of the jitter: 1 % of
    /// 0.6 mm, coloured, so that 6 µm remain 4 or so; three times that in two coordinates.
    #[test]
    fn the_centre_of_a_clean_record_is_the_centre_of_its_orbit() {
        for upside_down in [false, true] {
            let session = Session {
                upside_down,
                force_noise_n: 0.0,
                moment_noise_nmm: 0.0,
                seat_mm: 0.0,
                ..Session::new(3)
            };
            let recorded = simulate(&session);
            let error = check_error_mm(&recorded);
            assert!(error < 0.015, "{error} mm");
        }
    }

    /// A moment bias moves the answer by bias over load: 9 N·mm at 20 N is 0.45 mm.
    #[test]
    fn a_moment_bias_moves_the_centre_by_its_ratio_to_the_load() {
        let session = Session { loads_n: vec![20.0], ..Session::new(4) };
        let biased =
            Session { fault: Fault::Bias([0.0, 0.0, 0.0, 9.0, 0.0, 0.0]), ..session.clone() };
        let clean = centers_mm(&simulate(&session));
        let moved = centers_mm(&simulate(&biased));
        for (a, b) in clean.iter().zip(&moved) {
            assert!((b[0] - a[0]).abs() < 1e-9);
            // The load itself varies by 2 % during a turn.
            assert!((b[1] - a[1] + 0.45).abs() < 0.01, "{}", b[1] - a[1]);
        }
    }
}
