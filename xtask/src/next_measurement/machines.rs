//! Axes, sensors and tracers whose case does not show what is wrong, and how they go on.

use std::collections::HashMap;
use std::fmt::Write as _;

use anyhow::{Context, Result};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::Value;

use super::scene::{Files, Scene};
use crate::generators::noise::gaussian;
use crate::kinds::ft_center::press::{self, Meant, Press, REACH_MM, Recorded, Session};
use crate::kinds::ft_center::press_tables;
use crate::kinds::positioning::axis_run::{AxisRun, Fault};
use crate::kinds::tracker_lm::tracer::{self, Run};
use crate::kinds::tracker_lm::tracer_run::Measured;
use crate::kinds::tracker_lm::tracer_tables;

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

/// A survey of a rotary axis that was only turned upwards.
#[derive(Debug)]
pub(super) struct Upwards(pub(super) Run);

impl Upwards {
    /// Readings of all steps without noise, both ways.
    fn truth(&self) -> Measured {
        tracer::simulate(&Run { both_ways: true, noise_mm: 0.0, ..self.0.clone() })
    }

    /// The case with the first steps, and further ones of the same angles: step of the run and its
    /// name.
    fn with(&self, further: &[(usize, String)], seed: u64) -> Files {
        let Self(run) = self;
        let truth = self.truth();
        let both = Run { both_ways: true, ..run.clone() };
        let mut files = tracer_tables::tables(&both, &truth);
        let mut readings: HashMap<usize, Vec<(usize, usize, f64)>> = HashMap::new();
        for r in &truth.readings {
            readings.entry(r.step).or_default().push((r.station, r.mount, r.displacement_mm));
        }
        let mut table = String::from("station,mount,step,angle_deg,displacement_mm,direction\n");
        let mut write = |step: usize, name: &str, rng: &mut ChaCha8Rng| {
            let (angle_deg, rising) = truth.steps[step];
            for (station, mount, mm) in &readings[&step] {
                let read_mm = mm + run.noise_mm * gaussian(rng);
                let way = if rising { 1 } else { -1 };
                let _ = writeln!(
                    table,
                    "S{},R{},{name},{angle_deg},{read_mm:.6},{way}",
                    station + 1,
                    mount + 1
                );
            }
        };
        let mut rng = ChaCha8Rng::seed_from_u64(run.seed + 1);
        for step in 0..run.n_angles {
            write(step, &(step + 1).to_string(), &mut rng);
        }
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        for (step, name) in further {
            write(*step, name, &mut rng);
        }
        let angles: Vec<String> =
            truth.steps[..run.n_angles].iter().map(|(angle, _)| format!("{angle}")).collect();
        for (name, text) in &mut files {
            match *name {
                "case.toml" => {
                    // The displacements are made with noise here.
                    *text = text.replace("displacement_mm = 0\n", &declared(run));
                    let _ = write!(text, "\n[plan]\nangles_deg = [{}]\n", angles.join(", "));
                }
                "ranges.csv" => text.clone_from(&table),
                _ => {}
            }
        }
        files
    }
}

fn declared(run: &Run) -> String {
    format!("displacement_mm = {}\n", run.noise_mm)
}

impl Scene for Upwards {
    fn files(&self) -> Files {
        self.with(&[], 0)
    }

    fn aim(&self) -> Option<&'static str> {
        Some("backlash")
    }

    fn with_plan(&self, plan: &[Value], seed: u64) -> Result<Files> {
        let steps = self.truth().steps;
        let further = plan.iter().map(|one| {
            let cell = |name: &str| one["cells"][name].as_f64().context("no angle");
            let (angle, rising) = (cell("angle_deg")?, cell("direction")? > 0.0);
            let is_it = |(a, r): &(f64, bool)| (a - angle).abs() < 1e-6 && *r == rising;
            let step = steps.iter().position(is_it).context("an angle that nobody offered")?;
            Ok((step, one["name"].as_str().context("no name")?.to_owned()))
        });
        Ok(self.with(&further.collect::<Result<Vec<_>>>()?, seed))
    }

    /// The same angles again, from the same side.
    fn with_even(&self, count: usize, seed: u64) -> Files {
        let n = self.0.n_angles;
        let again = (0..count).map(|i| (i * n / count.max(1) % n, format!("N{}", i + 1)));
        self.with(&again.collect::<Vec<_>>(), seed)
    }
}

#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
fn as_f64(n: usize) -> f64 {
    n as f64
}
