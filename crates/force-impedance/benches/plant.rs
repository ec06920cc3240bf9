//! Force over a freeform path: the recommended impedance, plain PI force loops, and no control, on
//! contacts from 10 to 10 000 N/mm.
//!
//! `cargo bench -p force-impedance --bench plant`; one run each, so that `--test` is the same.
#![expect(clippy::print_stdout, reason = "a bench prints its result")]
#![expect(clippy::unwrap_used, reason = "settings of a bench are known to be good")]
#![expect(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "sample counts are small and positive"
)]

#[path = "../tests/it/plant.rs"]
mod plant;
#[path = "../tests/it/usual_head.rs"]
#[expect(dead_code, reason = "the head here is light")]
mod usual_head;

use std::f64::consts::PI;

use force_impedance::{
    Controller, ControllerSettings, Discretisation, Head, HeadGeometry, HeadLimits,
    ImpedanceParameters, LoopSettings, Measurement, ReferenceMode, margins_at, recommend,
};
use nalgebra::{Complex, Vector3};

use plant::{Outcome, Plant};
use usual_head::GEOMETRY;

const T: f64 = 1e-3;
const REFERENCE_N: f64 = 40.0;
/// Stiffness at which the second PI loop was tuned, as on a machine with one workpiece.
const WORKSHOP_N_PER_MM: f64 = 300.0;
const STIFFEST_N_PER_MM: f64 = 10_000.0;
const N_SAMPLES: usize = 20_000;

fn plant(contact_n_per_mm: f64) -> Plant {
    Plant {
        interval_s: T,
        delay_s: 1.5e-3,
        lag_s: 5e-3,
        seal_mm: 0.5e-3,
        contact_n_per_mm,
        hardens: 0.05,
        noise_n: 0.2,
        path_mm: 0.05,
    }
}

fn main() {
    let loops = LoopSettings {
        interval_s: T,
        delay_s: plant(1.0).delay_s,
        lag_s: plant(1.0).lag_s,
        discretisation: Discretisation::ExactHold,
        mode: ReferenceMode::Rebased,
    };
    let whole = recommend(&loops, [10.0, STIFFEST_N_PER_MM], 0.5).unwrap().parameters;
    let light = light(&loops, STIFFEST_N_PER_MM);
    // What a slowly changing error of the path meets is the integral part alone.
    let pi_per_s = tuned_gain(STIFFEST_N_PER_MM, &plant(1.0)) / plant(1.0).lag_s;
    println!(
        "integral part times stiffness of the contact, 1/s, each with 6 dB and 45° at the least: PI \
         {:.0}, impedance without inertia {:.0}, recommended impedance {:.0}",
        STIFFEST_N_PER_MM * pi_per_s,
        STIFFEST_N_PER_MM / light.damping_ns_per_mm,
        STIFFEST_N_PER_MM / whole.damping_ns_per_mm,
    );
    println!(
        "one impedance for all: M {:.3} kg, D {:.3} N·s/mm; force error, N rms, reference {REFERENCE_N} N",
        whole.mass_kg, whole.damping_ns_per_mm
    );
    println!(
        "{:>12} {:>10} | {:>10} {:>10} {:>10} {:>10} | {:>10} {:>10} {:>10}",
        "contact N/mm",
        "no control",
        "PI 10000",
        "PI 300",
        "impedance",
        "no inertia",
        "PI own",
        "imp. own",
        "no in. own"
    );
    for contact in [10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0, 10_000.0] {
        row(contact, &loops, whole, light);
    }
}

/// One contact: gains for all contacts, then gains for this one.
fn row(
    contact: f64,
    loops: &LoopSettings,
    whole: ImpedanceParameters,
    without_inertia: ImpedanceParameters,
) {
    let plant = plant(contact);
    let own = recommend(loops, [contact, contact], 0.02).unwrap().parameters;
    let run = |outcome: Outcome| {
        let calm = outcome.growth < 3.0 && outcome.rms_n < 1e3;
        if calm { format!("{:.3}", outcome.rms_n) } else { "unstable".to_owned() }
    };
    let with = |parameters| run(plant.run(REFERENCE_N, N_SAMPLES, 0.0, impedance(parameters)));
    let with_pi = |tuned| run(plant.run(REFERENCE_N, N_SAMPLES, 0.0, pi(tuned, &plant)));
    println!(
        "{contact:>12} {:>10} | {:>10} {:>10} {:>10} {:>10} | {:>10} {:>10} {:>10}",
        run(plant.run(REFERENCE_N, N_SAMPLES, 0.0, |_| 0.0)),
        with_pi(STIFFEST_N_PER_MM),
        with_pi(WORKSHOP_N_PER_MM),
        with(whole),
        with(without_inertia),
        with_pi(contact),
        with(own),
        with(light(loops, contact)),
    );
}

/// An impedance of next to no inertia, as quick as 6 dB and 45° allow on a contact.
fn light(loops: &LoopSettings, contact: f64) -> ImpedanceParameters {
    let with = |damping: f64| ImpedanceParameters {
        mass_kg: 1e3 * damping * 0.1 * T,
        damping_ns_per_mm: damping,
        stiffness_n_per_mm: 0.0,
    };
    let (mut low, mut high) = (1e-4 * contact, contact);
    while high / low > 1.001_f64 {
        let middle = (low * high).sqrt();
        let comfortable = margins_at(with(middle), loops, contact).unwrap().is_comfortable();
        if comfortable { high = middle } else { low = middle }
    }
    with(high)
}

/// The controller with head, cells and lengths between: a straight head, legs unloaded.
fn impedance(parameters: ImpedanceParameters) -> impl FnMut(f64) -> f64 {
    let geometry = HeadGeometry { weight_n: 0.0, ..GEOMETRY };
    let settings = ControllerSettings {
        max_error_n: 1e6,
        max_cell_n: 1e6,
        rate_mm_per_s: 1e3,
        approach_mm_per_s: 1e3,
        // The law alone is compared.
        acceleration_mm_per_s2: 1e8,
        jerk_mm_per_s3: 1e12,
        reference_rate_n_per_s: 1e9,
        recovery_cycles: 1,
        ..ControllerSettings::default()
    };
    let head = Head::new(geometry, HeadLimits::wide(&geometry)).unwrap();
    let mut controller = Controller::new(head, parameters, settings).unwrap();
    let mut lengths_mm = head.pose_at(&head.start_tip_mm()).unwrap().lengths_mm;
    move |force_n| {
        let seen = Measurement {
            lengths_mm: Some(lengths_mm),
            cells_n: Some([0.0, 0.0, 0.0, force_n]),
            normal: Vector3::y(),
            reference_n: REFERENCE_N,
        };
        let command = controller.update(&seen, T);
        lengths_mm = command.lengths_mm;
        command.offset_mm
    }
}

/// A plain PI force loop, integral time the lag of the legs, as quick as 6 dB and 45° allow on a
/// contact.
fn pi(tuned_n_per_mm: f64, plant: &Plant) -> impl FnMut(f64) -> f64 + use<> {
    let gain_mm_per_n = tuned_gain(tuned_n_per_mm, plant);
    let integral_s = plant.lag_s;
    let mut integral_mm = 0.0;
    move |force_n| {
        let error_n = force_n - REFERENCE_N;
        integral_mm += gain_mm_per_n * error_n * T / integral_s;
        gain_mm_per_n * error_n + integral_mm
    }
}

fn tuned_gain(contact_n_per_mm: f64, plant: &Plant) -> f64 {
    let comfortable = |gain: f64| {
        let points = (1..4000)
            .map(|i| transfer(PI * f64::from(i) / 4000.0, plant) * gain * contact_n_per_mm);
        // −1 stays outside: no point beyond −1/2 on the real axis' side, none near the unit circle
        // with less than 45° to go.
        let mut before: Option<Complex<f64>> = None;
        for value in points {
            if let Some(last) = before {
                let crosses = last.im * value.im <= 0.0 && value.re < -0.5;
                let leaves = last.norm() >= 1.0 && value.norm() < 1.0;
                let lag = (-value.arg()).rem_euclid(2.0 * PI);
                if crosses || leaves && lag > 0.75 * PI {
                    return false;
                }
            }
            before = Some(value);
        }
        true
    };
    let (mut low, mut high) = (1e-9, 1.0);
    while high / low > 1.01_f64 {
        let middle = (low * high).sqrt();
        if comfortable(middle) { low = middle } else { high = middle }
    }
    low
}

/// PI of unit gain and the legs, at `z = e^{iω}`.
fn transfer(omega: f64, plant: &Plant) -> Complex<f64> {
    let late = Complex::new(0.0, -omega).exp();
    let one = Complex::new(1.0, 0.0);
    let whole = (plant.delay_s / T).floor();
    let rest_s = plant.delay_s - whole * T;
    let (keep, acted) = ((-T / plant.lag_s).exp(), (-(T - rest_s) / plant.lag_s).exp());
    let waited = Complex::new(0.0, -omega * (whole + 1.0)).exp();
    let legs = waited * (late * (acted - keep) + (1.0 - acted)) / (one - late * keep);
    (one + one * (T / plant.lag_s) / (one - late)) * legs
}
