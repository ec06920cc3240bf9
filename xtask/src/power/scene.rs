//! A simulated case of any kind, and how large its effect must be.

use super::detectable::{Design, smallest};
use crate::generators::oracle::{center_mm, centers_mm, check_error_mm};
use crate::generators::press::{self, Fault, Recorded, Role, Session};
use crate::generators::press_tables::{case_toml, presses_csv, wrench_csv};
use crate::generators::survey::{self, Defect, Survey};
use crate::generators::tracer::{self, Run};
use crate::generators::tracer_tables::tables;

/// What to simulate.
#[derive(Clone, Debug)]
pub(crate) enum Scene {
    Survey(Survey),
    Session(Session),
    Run(Run),
}

/// A case folder, and the error on its check groups that the noise alone makes.
pub(crate) struct Simulated {
    pub(crate) files: Vec<(&'static str, String)>,
    pub(crate) noise_mm: f64,
}

impl Scene {
    pub(crate) fn simulate(&self) -> Simulated {
        match self {
            Self::Survey(scene) => {
                let surveyed = survey::simulate(scene);
                Simulated {
                    files: vec![
                        ("case.toml", surveyed.case_toml),
                        ("pairs.csv", surveyed.pairs_csv),
                    ],
                    noise_mm: surveyed.check_noise_mm,
                }
            }
            Self::Run(scene) => Simulated {
                files: tables(scene, &tracer::simulate(scene)),
                noise_mm: scene.noise_mm,
            },
            Self::Session(scene) => {
                let recorded = press::simulate(scene);
                let sound = Session { fault: Fault::None, ..scene.clone() };
                Simulated {
                    files: vec![
                        ("case.toml", case_toml(scene, &recorded)),
                        ("presses.csv", presses_csv(&recorded)),
                        ("wrench.csv", wrench_csv(&recorded)),
                    ],
                    noise_mm: check_error_mm(&press::simulate(&sound)),
                }
            }
        }
    }
}

/// Scales the defect, given at a small size, to `times` its minimal detectable size.
pub(crate) fn survey_at(
    survey: &Survey,
    defect: impl Fn(f64) -> Defect,
    n_amplitudes: usize,
    n_candidates: usize,
    times: f64,
) -> Survey {
    const SMALL: f64 = 1e-6;
    let surveyed = survey::simulate(&Survey { defect: defect(SMALL), ..survey.clone() });
    let fitted: Vec<usize> =
        (0..surveyed.is_check.len()).filter(|&i| !surveyed.is_check[i]).collect();
    let rows = |field: &dyn Fn(usize) -> [f64; 3]| -> Vec<f64> {
        fitted.iter().flat_map(|&i| field(i)).map(|v| v / survey.noise_mm).collect()
    };
    let mut base = Vec::new();
    if survey.transform == "rigid" {
        for axis in 0..3 {
            let unit: [f64; 3] = std::array::from_fn(|i| if i == axis { 1.0 } else { 0.0 });
            base.push(rows(&|_| unit));
            base.push(rows(&|i| {
                let p = surveyed.from_mm[i];
                let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
                let mut turned = [0.0; 3];
                (turned[j], turned[k]) = (-p[k], p[j]);
                turned
            }));
        }
    }
    let signal = rows(&|i| surveyed.displacement_mm[i]);
    let factor = smallest(&Design { signal, base, n_amplitudes, n_candidates });
    Survey { defect: defect(times * factor * SMALL), ..survey.clone() }
}

/// Scales the fault, given at a small size, to `times` its minimal detectable size.
pub(crate) fn session_at(
    session: &Session,
    fault: impl Fn(f64) -> Fault,
    n_amplitudes: usize,
    n_candidates: usize,
    times: f64,
) -> Session {
    const SMALL: f64 = 1e-4;
    let silent =
        Session { force_noise_n: 0.0, moment_noise_nmm: 0.0, seat_mm: 0.0, ..session.clone() };
    let clean = press::simulate(&silent);
    let faulty = press::simulate(&Session { fault: fault(SMALL), ..silent });
    let (before, after) = (centers_mm(&clean), centers_mm(&faulty));
    let fitted: Vec<usize> =
        (0..before.len()).filter(|&i| clean.presses[i].role == Role::Frame).collect();
    let rows = |field: &dyn Fn(usize) -> [f64; 2]| -> Vec<f64> {
        fitted
            .iter()
            .flat_map(|&i| field(i).map(|v| v / center_sigma_mm(session, &clean, i)))
            .collect()
    };
    let base = vec![
        rows(&|_| [1.0, 0.0]),
        rows(&|_| [0.0, 1.0]),
        rows(&|i| [-before[i][1], before[i][0]]),
    ];
    let signal = rows(&|i| [after[i][0] - before[i][0], after[i][1] - before[i][1]]);
    let factor = smallest(&Design { signal, base, n_amplitudes, n_candidates });
    Session { fault: fault(times * factor * SMALL), ..session.clone() }
}

/// Standard uncertainty of one coordinate of a press' centre under white noise: the seat, and the
/// mean over the samples of (moment noise, force noise at the lever arms) over the load.
fn center_sigma_mm(session: &Session, clean: &Recorded, index: usize) -> f64 {
    let press = &clean.presses[index];
    let [x, y] = center_mm(press, clean.declared_height_mm);
    let lever2 = 0.5 * (x * x + y * y) + clean.declared_height_mm.powi(2);
    let load_n = press.samples[press.samples.len() / 2].1[2].abs();
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let n_samples = session.n_samples as f64;
    let moment2 = session.moment_noise_nmm.powi(2) + session.force_noise_n.powi(2) * lever2;
    (session.seat_mm.powi(2) + moment2 / load_n.powi(2) / n_samples).sqrt()
}
