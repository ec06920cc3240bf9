//! 10⁸ cycles of NaN, infinities, jumps, dropouts and jitter, half of them on a head with narrow
//! limits outside which it is often seen: the output is finite, within limits and rate, and control
//! resumes when it must. Stops at the first that is not.
//!
//! `cargo bench -p force-impedance --bench endurance`; with `--test` or `--quick`, 10⁵ cycles.
#![expect(clippy::print_stdout, reason = "a bench prints its result")]
#![expect(clippy::unwrap_used, reason = "settings of a bench are known to be good")]

#[path = "../tests/it/hostile.rs"]
mod hostile;
#[path = "../tests/it/usual_head.rs"]
mod usual_head;

use force_impedance::{
    Controller, ControllerSettings, Head, HeadLimits, ImpedanceParameters, ReferenceMode, Status,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use hostile::{Hostile, Judge};
use usual_head::{GEOMETRY, head as head_of_wide_limits};

const N_CYCLES: u64 = 100_000_000;

fn main() {
    let short = std::env::args().any(|a| a == "--test" || a == "--quick");
    let n = if short { 100_000 } else { N_CYCLES };
    let narrow = HeadLimits { leg_mm: [69.7, 70.4], axial_mm: [179.5, 180.3], tilt_rad: 2e-3 };
    for mode in [ReferenceMode::Rebased, ReferenceMode::Absolute] {
        for limits in [HeadLimits::wide(&GEOMETRY), narrow] {
            endure(mode, limits, n / 4);
        }
    }
}

fn endure(mode: ReferenceMode, limits: HeadLimits, n: u64) {
    let parameters =
        ImpedanceParameters { mass_kg: 1.0, damping_ns_per_mm: 0.5, stiffness_n_per_mm: 2.0 };
    // Cells at random contradict each other: that they do is no fault here.
    let settings =
        ControllerSettings { mode, max_disagreement_n: 1e6, ..ControllerSettings::default() };
    let head = Head::new(GEOMETRY, limits).unwrap();
    let wide = head_of_wide_limits();
    let mut controller = Controller::new(head, parameters, settings).unwrap();
    let mut stream = Hostile::new(ChaCha8Rng::seed_from_u64(42));
    let mut judge = Judge::new(&controller, *head.limits());
    let mut held = 0_u64;
    for _ in 0..n {
        let (seen, dt_s) = stream.next(&wide);
        let command = controller.update(&seen, dt_s);
        judge.check(&command, stream.good_in_a_row());
        held += u64::from(matches!(command.status, Status::Held(_)));
    }
    println!(
        "{mode:?}, legs {:?} mm: {n} cycles, {held} of them held; every output within limits and rate",
        limits.leg_mm
    );
}
