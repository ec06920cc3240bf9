//! A head whose log does not show what is wrong, and how it goes on.

use anyhow::{Context, Result};
use serde_json::Value;

use super::scene::{Files, Scene};
use crate::generators::vector::{add, cross, norm, rotate, scale};
use crate::kinds::force_impedance::polish::{Instant, Run, Sample, record_on, simulate};
use crate::kinds::force_impedance::polish_head::HeadModel;
use crate::kinds::force_impedance::polish_tables::{case_toml, log_csv};

/// A polishing run that goes on.
#[derive(Debug)]
pub(super) struct Polishing {
    pub(super) run: Run,
    /// What the plan is made for.
    pub(super) aim: &'static str,
    /// Lines of `[plan]`.
    pub(super) plan: &'static str,
}

/// Time of one planned run, as the plan has it where nothing is declared.
const SECONDS: f64 = 1.0;

impl Polishing {
    fn with(&self, further: Vec<Sample>) -> Files {
        let mut samples = simulate(&self.run);
        samples.extend(further);
        let mut log = log_csv(&self.run, &samples);
        // Recorded afterwards, each with the name that the plan gave it.
        let n_strips = self.run.n_segments;
        for segment in n_strips..=samples.last().map_or(0, |last| last.segment) {
            let name = format!(",strip {}\n", segment + 1);
            log = log.replace(&name, &format!(",N{}\n", segment + 1 - n_strips));
        }
        let toml = format!("{}\n[plan]\n{}\n", case_toml(&self.run), self.plan);
        vec![("case.toml", toml), ("log.csv", log)]
    }

    fn made(&self, meant: &[Box<dyn Fn(f64) -> Instant>], seed: u64) -> Files {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few")]
        let n_samples = (SECONDS * self.run.rate_hz) as usize;
        self.with(record_on(&self.run, meant, n_samples, seed))
    }
}

impl Scene for Polishing {
    fn files(&self) -> Files {
        self.with(Vec::new())
    }

    fn aim(&self) -> Option<&'static str> {
        Some(self.aim)
    }

    fn with_plan(&self, plan: &[Value], seed: u64) -> Result<Files> {
        let plate = mean_normal(&simulate(&self.run));
        let friction = self.run.friction;
        let meant = plan.iter().map(|one| {
            let cell = |name: &str| one["cells"][name].as_f64().context("not planned");
            let lean = [cell("lean_deg")?, cell("lean_towards_deg")?].map(f64::to_radians);
            let load = [cell("load_from_n")?, cell("load_to_n")?];
            let axial = cell("axial_mm_per_s")?;
            let rubs = cell("moves_across").unwrap_or(0.0) > 0.0 && friction > 0.0;
            let at: Box<dyn Fn(f64) -> Instant> =
                Box::new(move |since_s| on_plate(plate, lean, load, (axial, rubs), since_s));
            Ok(at)
        });
        Ok(self.made(&meant.collect::<Result<Vec<_>>>()?, seed))
    }

    /// The head straight on the plate at the loads that there were, moving across.
    fn with_even(&self, count: usize, seed: u64) -> Files {
        let plate = mean_normal(&simulate(&self.run));
        let loads = self.run.loads_n.clone();
        let made = (0..count).map(|n| {
            let load = [loads[n % loads.len()]; 2];
            let at: Box<dyn Fn(f64) -> Instant> =
                Box::new(move |since_s| on_plate(plate, [0.0; 2], load, (0.0, true), since_s));
            at
        });
        self.made(&made.collect::<Vec<_>>(), seed)
    }
}

/// A head that leans by an angle towards a side, on a plate.
fn on_plate(
    plate: [f64; 3],
    [lean_rad, towards_rad]: [f64; 2],
    [from_n, to_n]: [f64; 2],
    (axial_mm_per_s, rubs): (f64, bool),
    since_s: f64,
) -> Instant {
    let straight = HeadModel::USUAL.start_tip_mm();
    let side = [towards_rad.cos(), 0.0, towards_rad.sin()];
    let about = cross(straight, side);
    let leant = rotate(scale(1.0 / norm(&about), about), lean_rad, straight);
    let share = since_s / SECONDS;
    let slid_mm = axial_mm_per_s * (since_s - 0.5 * SECONDS);
    let feed = cross(plate, [0.0, 0.0, 1.0]);
    let feed = scale(1.0 / norm(&feed), feed);
    Instant {
        tip_mm: add(leant, scale(slid_mm / norm(&leant), leant)),
        normal: plate,
        rubs: if rubs { scale(-1.0, feed) } else { [0.0; 3] },
        press_n: from_n + (to_n - from_n) * share,
    }
}

fn mean_normal(samples: &[Sample]) -> [f64; 3] {
    let sum = samples.iter().fold([0.0; 3], |sum, s| add(sum, s.normal));
    scale(1.0 / norm(&sum), sum)
}
