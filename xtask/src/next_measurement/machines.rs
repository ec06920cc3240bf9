//! Axes, sensors and tracers whose case does not show what is wrong, and how they go on.

use anyhow::{Context, Result};
use serde_json::Value;

use super::scene::{Files, Scene};
use crate::kinds::ft_center::press::{self, Meant, Press, REACH_MM, Recorded, Session};
use crate::kinds::ft_center::press_tables;
use crate::kinds::positioning::axis_run::{AxisRun, Fault};

impl Scene for AxisRun {
    fn files(&self) -> Files {
        AxisRun::files(self, &[], 0)
    }

    fn aim(&self) -> Option<&'static str> {
        Some(match self.fault {
            Fault::Reversal(_) => "reversal",
            Fault::Cyclic(_) => "cyclic-error",
            Fault::Long(_) => "pitch-error",
        })
    }

    fn with_plan(&self, plan: &[Value], seed: u64) -> Result<Files> {
        let reading = |one: &Value| {
            let cell = |name: &str| one["cells"][name].as_f64().context("no target");
            Ok((cell("target_mm")?, cell("direction")? > 0.0))
        };
        Ok(AxisRun::files(self, &plan.iter().map(reading).collect::<Result<Vec<_>>>()?, seed))
    }

    fn with_even(&self, count: usize, seed: u64) -> Files {
        AxisRun::files(self, &AxisRun::even(count), seed)
    }
}

/// A session of presses that goes on.
#[derive(Debug)]
pub(super) struct Pressing {
    pub(super) session: Session,
    /// What the plan is made for.
    pub(super) aim: &'static str,
    /// Lines of `[plan]`.
    pub(super) plan: &'static str,
}

impl Pressing {
    fn with(&self, further: Vec<Press>, mut recorded: Recorded) -> Files {
        recorded.presses.extend(further);
        let toml = press_tables::case_toml(&self.session, &recorded);
        vec![
            ("case.toml", format!("{toml}\n[plan]\n{}\n", self.plan)),
            ("presses.csv", press_tables::presses_csv(&recorded)),
            ("wrench.csv", press_tables::wrench_csv(&recorded)),
        ]
    }
}

impl Scene for Pressing {
    fn files(&self) -> Files {
        self.with(Vec::new(), press::simulate(&self.session))
    }

    fn aim(&self) -> Option<&'static str> {
        Some(self.aim)
    }

    fn with_plan(&self, plan: &[Value], seed: u64) -> Result<Files> {
        let recorded = press::simulate(&self.session);
        let meant = plan.iter().map(|one| {
            let cell = |name: &str| one["cells"][name].as_f64();
            let lean = |name: &str| cell(name).unwrap_or(0.0).to_radians().tan();
            // The head presses down: what leans with the load comes back against it.
            Ok(Meant {
                commanded_mm: [
                    cell("machine_x_mm").context("no place")?,
                    cell("machine_y_mm").context("no place")?,
                ],
                load_n: cell("load_n").context("no load")?,
                across: [-lean("lean_x_deg"), -lean("lean_y_deg")],
            })
        });
        let meant = meant.collect::<Result<Vec<Meant>>>()?;
        let further = press::press_again(&self.session, &recorded, &meant, seed);
        Ok(self.with(further, recorded))
    }

    /// On a sunflower over the platform, upright, at the loads that there were.
    fn with_even(&self, count: usize, seed: u64) -> Files {
        let recorded = press::simulate(&self.session);
        let meant = |n: usize| {
            let radius = REACH_MM * ((as_f64(n) + 0.5) / as_f64(count)).sqrt();
            let (sin, cos) = (2.399_963 * as_f64(n)).sin_cos();
            let [x, y] = recorded.sensor_mm;
            Meant {
                commanded_mm: [x + radius * cos, y + radius * sin],
                load_n: self.session.loads_n[n % self.session.loads_n.len()],
                across: [0.0; 2],
            }
        };
        let meant: Vec<Meant> = (0..count).map(meant).collect();
        let further = press::press_again(&self.session, &recorded, &meant, seed);
        self.with(further, recorded)
    }
}

#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
fn as_f64(n: usize) -> f64 {
    n as f64
}
