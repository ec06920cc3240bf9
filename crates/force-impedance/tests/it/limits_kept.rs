//! Whatever comes in, commands keep speed, acceleration and jerk, as differences of commands over
//! nominal intervals: in both modes, through faults, retracting, and at the ends of the workspace.

use force_impedance::{
    Command, Controller, ControllerSettings, Head, HeadLimits, ReferenceMode, Status,
};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::hostile::Hostile;
use crate::rig::SOFT;
use crate::usual_head::{GEOMETRY, head};

const N_CYCLES: usize = 60_000;
/// Coordinates of up to 512 mm are rounded to 6e-14 mm; a third difference holds eight of them, a
/// vector three of these, and the motion itself rounds as often.
const ROUND_OFF_MM: f64 = 1e-12;

/// Differences of a series of commands: of the tip, mm, and of the reference, N.
#[derive(Default)]
struct Differences {
    tips: Vec<Vector3<f64>>,
    references: Vec<f64>,
}

impl Differences {
    fn of<T: Copy + std::ops::Sub<Output = T>>(series: &[T]) -> Option<[T; 3]> {
        let &[a, b, c, d] = series.last_chunk()?;
        Some([d - c, (d - c) - (c - b), (d - c) - (c - b) - ((c - b) - (b - a))])
    }

    fn add(&mut self, command: &Command) -> (Option<[f64; 3]>, Option<[f64; 3]>) {
        self.tips.push(command.tip_mm.coords);
        self.references.push(command.reference_n);
        if self.tips.len() > 4 {
            self.tips.remove(0);
            self.references.remove(0);
        }
        let norms = Self::of(&self.tips).map(|d| d.map(|v| v.norm()));
        (norms, Self::of(&self.references).map(|d| d.map(f64::abs)))
    }
}

fn keeps(settings: ControllerSettings, limits: HeadLimits) {
    let narrow = Head::new(GEOMETRY, limits).unwrap();
    let wide = head();
    let mut controller = Controller::new(narrow, SOFT, settings).unwrap();
    let mut stream = Hostile::new(ChaCha8Rng::seed_from_u64(97));
    let mut differences = Differences::default();
    let t = settings.interval_s;
    let of = |rate: f64, acceleration: f64, jerk: f64| {
        [rate * t, acceleration * t * t, jerk * t * t * t]
    };
    let tip_most =
        of(settings.rate_mm_per_s, settings.acceleration_mm_per_s2, settings.jerk_mm_per_s3);
    let reference_most = of(
        settings.reference_rate_n_per_s,
        settings.reference_acceleration_n_per_s2,
        settings.reference_jerk_n_per_s3,
    );
    let mut seen_states = [0_usize; 5];
    let mut moved = 0;
    for cycle in 0..N_CYCLES {
        let (seen, dt_s) = stream.next(&wide);
        let command = controller.update(&seen, dt_s);
        let (tip, reference) = differences.add(&command);
        for (found, most) in [(tip, tip_most), (reference, reference_most)] {
            for (found, most) in found.unwrap_or_default().iter().zip(most) {
                assert!(*found <= most + ROUND_OFF_MM, "{cycle}: {found} {most} {command:?}");
            }
        }
        moved += usize::from(tip.unwrap_or_default()[0] > 0.0);
        assert!(narrow.pose_at(&command.tip_mm).is_ok(), "{cycle}: {command:?}");
        seen_states[match command.status {
            Status::Controlling => 0,
            Status::NoContact => 1,
            Status::Recovering => 2,
            Status::Held(_) => 3,
            Status::Retracting(_) => 4,
        }] += 1;
    }
    // Every state was visited, and the tip did move.
    assert!(seen_states.iter().all(|n| *n > 100), "{seen_states:?}");
    assert!(moved > N_CYCLES / 10, "{moved}");
}

fn narrow() -> HeadLimits {
    HeadLimits { leg_mm: [69.7, 70.4], axial_mm: [179.5, 180.3], tilt_rad: 2e-3 }
}

fn in_both_modes(settings: ControllerSettings) {
    for mode in [ReferenceMode::Absolute, ReferenceMode::Rebased] {
        for limits in [HeadLimits::wide(&GEOMETRY), narrow()] {
            keeps(ControllerSettings { mode, hold_cycles: 20, ..settings }, limits);
        }
    }
}

#[test]
fn commands_keep_the_default_limits() {
    in_both_modes(ControllerSettings::default());
}

#[test]
fn commands_keep_limits_of_jerk_that_take_many_cycles() {
    in_both_modes(ControllerSettings {
        acceleration_mm_per_s2: 3e3,
        jerk_mm_per_s3: 2e5,
        reference_acceleration_n_per_s2: 2e4,
        reference_jerk_n_per_s3: 2e6,
        ..ControllerSettings::default()
    });
}

#[test]
fn commands_keep_limits_between() {
    in_both_modes(ControllerSettings {
        rate_mm_per_s: 200.0,
        acceleration_mm_per_s2: 4e4,
        jerk_mm_per_s3: 1e7,
        travel_mm: [-0.3, 0.2],
        ..ControllerSettings::default()
    });
}

/// Limits so wide that the tip starts and stops within a cycle.
#[test]
fn commands_keep_limits_that_count_for_a_cycle_only() {
    in_both_modes(ControllerSettings {
        acceleration_mm_per_s2: 6e4,
        jerk_mm_per_s3: 1.5e8,
        ..ControllerSettings::default()
    });
}
