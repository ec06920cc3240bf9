//! The controller on the plant: margins as the card promises, force over a freeform path.

use force_impedance::{
    Controller, ControllerSettings, Discretisation, ImpedanceParameters, LoopSettings, Measurement,
    ReferenceMode, margins_at, recommend,
};
use nalgebra::Vector3;

use crate::equilibrium::equilibrium;
use crate::plant::Plant;
use crate::usual_head::{GEOMETRY, head};

const T: f64 = 1e-3;
const REFERENCE_N: f64 = 40.0;

fn plant(contact_n_per_mm: f64) -> Plant {
    Plant {
        interval_s: T,
        delay_s: 1.5e-3,
        lag_s: 5e-3,
        seal_mm: 0.0,
        contact_n_per_mm,
        hardens: 0.0,
        noise_n: 0.0,
        path_mm: 0.0,
    }
}

fn settings(plant: &Plant) -> LoopSettings {
    LoopSettings {
        interval_s: T,
        delay_s: plant.delay_s,
        lag_s: plant.lag_s,
        discretisation: Discretisation::ExactHold,
        mode: ReferenceMode::Rebased,
    }
}

/// The controller as a law from force to offset, with the whole head between: what the cells read
/// of a force at the commanded tip, and the lengths there.
fn law(parameters: ImpedanceParameters) -> impl FnMut(f64) -> f64 {
    let wide = ControllerSettings {
        max_error_n: 1e6,
        rate_mm_per_s: 1e4,
        approach_mm_per_s: 1e4,
        acceleration_mm_per_s2: 1e8,
        jerk_mm_per_s3: 1e12,
        travel_mm: [-10.0, 10.0],
        reference_rate_n_per_s: 1e9,
        max_cell_n: 1e6,
        recovery_cycles: 1,
        ..ControllerSettings::default()
    };
    let mut controller = Controller::new(head(), parameters, wide).unwrap();
    let normal = Vector3::y();
    let mut tip_mm = head().start_tip_mm();
    let mut cycle = 0_u32;
    move |force_n| {
        let held = equilibrium(tip_mm, normal, normal * force_n, 300.0, &GEOMETRY);
        cycle += 1;
        // The last digit of the converters, so that nothing looks frozen.
        let digit = f64::from(cycle % 7) * 1e-12;
        let seen = Measurement {
            lengths_mm: Some(held.lengths_mm),
            cells_n: Some(held.cells_n.map(|f| f + digit)),
            normal,
            reference_n: REFERENCE_N,
        };
        let command = controller.update(&seen, T);
        tip_mm = command.tip_mm;
        command.offset_mm
    }
}

/// The factor of stiffness, or the dead time added, from which on runs grow: six steps over
/// ± 25 % leave 0.4 %.
fn found(expected: f64, grows: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.75 * expected, 1.25 * expected);
    for _ in 0..6 {
        let middle = 0.5 * (low + high);
        if grows(middle) { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}

/// What the card promises, within a tenth.
const PROMISED: f64 = 0.10;
/// Samples of a run whose loop is quick.
const SHORTEST: usize = 1600;
/// At its delay margin a loop swings with a period of four delays or more: two of them in
/// each half of a run.
const PERIODS: f64 = 16.0;

/// Gains for the whole range, on each contact of it: where the run begins to grow is where the card says.
/// The softest contact takes 14 s of dead time, so runs are as long as the margin asks for.
#[test]
fn the_plant_has_the_margins_of_the_card_on_every_contact() {
    let advice = recommend(&settings(&plant(1.0)), [10.0, 10_000.0], 0.5).unwrap();
    for contact in [10.0, 100.0, 1000.0, 10_000.0] {
        let plain = plant(contact);
        let promised = margins_at(advice.parameters, &settings(&plain), contact).unwrap();
        // A touch of the surface far below what would lift the tool off.
        let grows = |plant: Plant, n: usize| {
            plant.run(REFERENCE_N, n, 1e-6, law(advice.parameters)).growth > 1.0
        };
        let gain = found(promised.gain_ratio, |factor| grows(plant(contact * factor), SHORTEST));
        assert!((gain / promised.gain_ratio - 1.0).abs() < PROMISED, "{gain} {promised:?}");
        let delay_s = promised.delay_s.unwrap();
        let n = SHORTEST.max((PERIODS * delay_s / T) as usize);
        let delay =
            found(delay_s, |more_s| grows(Plant { delay_s: plain.delay_s + more_s, ..plain }, n));
        assert!((delay / delay_s - 1.0).abs() < PROMISED, "{contact}: {delay} {promised:?}");
    }
}

/// The recommended gains on the whole range, on a path with seal friction, hardening and noise:
/// the loop calms down, and where the contact is stiff the force is far better than without.
#[test]
fn one_set_of_gains_holds_every_contact() {
    let rough = |contact: f64| Plant {
        seal_mm: 0.5e-3,
        hardens: 0.05,
        noise_n: 0.2,
        path_mm: 0.05,
        ..plant(contact)
    };
    let advice = recommend(&settings(&plant(1.0)), [10.0, 10_000.0], 0.5).unwrap();
    for contact in [10.0, 1000.0, 10_000.0] {
        let plant = rough(contact);
        let controlled = plant.run(REFERENCE_N, 4000, 0.0, law(advice.parameters));
        let free = plant.run(REFERENCE_N, 4000, 0.0, |_| 0.0);
        assert!(
            controlled.rms_n.is_finite() && controlled.growth < 2.0,
            "{contact}: {controlled:?}"
        );
        // Soft contacts hardly feel the path; stiff ones are what control is for.
        let most = if contact < 100.0 { 1.05 } else { 0.5 };
        assert!(controlled.rms_n < most * free.rms_n, "{contact}: {controlled:?} {free:?}");
    }
}
