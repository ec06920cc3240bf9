//! Whatever comes in, what goes out is finite, within limits and within the rate. The bench
//! `endurance` runs the same for 10⁸ cycles.

use force_impedance::{Controller, ControllerSettings, HeadLimits, ReferenceMode, Status};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::hostile::{Hostile, Judge};
use crate::rig::SOFT;
use crate::usual_head::{GEOMETRY, head};

const N_CYCLES: usize = 300_000;

#[test]
fn output_stays_within_its_limits_whatever_comes_in() {
    for mode in [ReferenceMode::Absolute, ReferenceMode::Rebased] {
        // Cells at random contradict each other: that they do is no fault here.
        let settings =
            ControllerSettings { mode, max_disagreement_n: 1e6, ..ControllerSettings::default() };
        let mut controller = Controller::new(head(), SOFT, settings).unwrap();
        let mut stream = Hostile::new(ChaCha8Rng::seed_from_u64(41));
        let mut judge = Judge::new(&controller, HeadLimits::wide(&GEOMETRY));
        let (mut controlled, mut held) = (0, 0);
        for _ in 0..N_CYCLES {
            let (seen, dt_s) = stream.next(controller.head());
            let command = controller.update(&seen, dt_s);
            judge.check(&command, stream.good_in_a_row());
            match command.status {
                Status::Controlling | Status::NoContact => controlled += 1,
                _ => held += 1,
            }
        }
        // Both sides of the table have been exercised.
        assert!(controlled > N_CYCLES / 10 && held > N_CYCLES / 10, "{controlled} {held}");
    }
}
