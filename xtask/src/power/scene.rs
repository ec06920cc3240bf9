//! A simulated case of any kind, and how large its effect must be.

use crate::generators::oracle::{center_mm, centers_mm, check_error_mm};
use crate::kinds::force_impedance::polish::{self, Run};
use crate::kinds::force_impedance::polish_tables;
use crate::kinds::force_impedance::strokes::{Strokes, path_csv};
use crate::kinds::frame_fit::survey::{self, Defect, Survey};
use crate::kinds::ft_center::press::{self, Fault, Recorded, Role, Session};
use crate::kinds::ft_center::press_tables::{case_toml, presses_csv, wrench_csv};
use crate::kinds::pose_icp::mirror::{self, Mirror};
use crate::kinds::positioning::positions::{self, Positions};
use crate::kinds::probe_comp::{probe, probe_tables};
use crate::kinds::tracker_lm::targets;
use crate::kinds::tracker_lm::tracer;
use crate::kinds::tracker_lm::tracer_tables::tables;
use crate::power::detectable::{Design, smallest};

/// How many times its minimal detectable size an effect has.
pub(crate) const TIMES: f64 = 5.0;

/// What to simulate.
#[derive(Clone, Debug)]
pub(crate) enum Scene {
    Survey(Survey),
    Session(Session),
    Mirror(Mirror),
    Run(Run),
    Strokes(Strokes),
    Tracer(tracer::Run),
    Targets(targets::Survey),
    Probe(probe::Session),
    Positions(Positions),
}

/// A case folder, and the error on its check groups that the noise alone makes.
pub(crate) struct Simulated {
    pub(crate) files: Vec<(&'static str, String)>,
    pub(crate) noise: f64,
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
                    noise: surveyed.check_noise_mm,
                }
            }
            Self::Probe(scene) => {
                let touches = probe::simulate(scene);
                Simulated {
                    files: vec![
                        ("case.toml", probe_tables::case_toml(scene)),
                        ("touches.csv", probe_tables::touches_csv(scene, &touches)),
                    ],
                    noise: probe::check_noise_mm(&touches),
                }
            }
            Self::Positions(scene) => {
                Simulated { files: positions::tables(scene), noise: scene.noise_mm }
            }
            Self::Strokes(scene) => Simulated {
                files: vec![
                    ("case.toml", "kind = \"force-impedance\"\n".to_owned()),
                    ("path.csv", path_csv(scene)),
                ],
                noise: scene.noise_n,
            },
            Self::Tracer(scene) => {
                Simulated { files: tables(scene, &tracer::simulate(scene)), noise: scene.noise_mm }
            }
            Self::Targets(scene) => {
                let measured = targets::simulate(scene);
                Simulated { files: targets::tables(scene, &measured), noise: measured.noise_mm }
            }
            Self::Session(scene) => {
                let recorded = press::simulate(scene);
                let sound = Session { fault: Fault::None, also: Fault::None, ..scene.clone() };
                Simulated {
                    files: vec![
                        ("case.toml", case_toml(scene, &recorded)),
                        ("presses.csv", presses_csv(&recorded)),
                        ("wrench.csv", wrench_csv(&recorded)),
                    ],
                    noise: check_error_mm(&press::simulate(&sound)),
                }
            }
            Self::Run(scene) => {
                let samples = polish::simulate(scene);
                let none = polish::Flaw::None;
                let sound = Run { flaw: none, also: none, ..scene.clone() };
                Simulated {
                    files: vec![
                        ("case.toml", polish_tables::case_toml(scene)),
                        ("log.csv", polish_tables::log_csv(scene, &samples)),
                    ],
                    noise: rms(&polish::residuals_n(&sound, &polish::simulate(&sound))),
                }
            }
            Self::Mirror(scene) => {
                let touched = mirror::simulate(scene);
                let mut files =
                    vec![("case.toml", touched.case_toml), ("points.csv", touched.points_csv)];
                files.extend(touched.edge_csv.map(|text| ("edge.csv", text)));
                Simulated { files, noise: touched.check_noise_mm }
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

/// Scales the flaw, given at a small size, to `times` its minimal detectable size.
pub(crate) fn mirror_at(
    mirror: &Mirror,
    flaw: impl Fn(f64) -> mirror::Flaw,
    n_amplitudes: usize,
    n_candidates: usize,
    times: f64,
) -> Mirror {
    const SMALL: f64 = 1e-6;
    let touched = mirror::simulate(&Mirror { flaw: flaw(SMALL), ..mirror.clone() });
    let fitted: Vec<usize> =
        (0..touched.is_check.len()).filter(|&i| !touched.is_check[i]).collect();
    // The mean of two touches of the side, whose lever to the origin is a few millimetres.
    let side_mm = mirror.noise_mm / 2.0_f64.sqrt();
    let rows = |of_touch: &dyn Fn(usize) -> f64, sides: [f64; 2]| -> Vec<f64> {
        let touches = fitted.iter().map(|&i| of_touch(i) / mirror.noise_mm);
        touches.chain(sides.map(|v| v / side_mm)).collect()
    };
    let moment = |i: usize| {
        let (n, p) = (touched.normals[i], touched.contacts_mm[i]);
        [n[1] * p[2] - n[2] * p[1], n[2] * p[0] - n[0] * p[2]]
    };
    let base = vec![
        rows(&|i| touched.normals[i][0], [1.0, 0.0]),
        rows(&|i| touched.normals[i][1], [0.0, 1.0]),
        rows(&|i| touched.normals[i][2], [0.0, 0.0]),
        rows(&|i| moment(i)[0], [0.0, 0.0]),
        rows(&|i| moment(i)[1], [0.0, 0.0]),
    ];
    let signal = rows(&|i| touched.signal_mm[i], [0.0, 0.0]);
    let factor = smallest(&Design { signal, base, n_amplitudes, n_candidates });
    Mirror { flaw: flaw(times * factor * SMALL), ..mirror.clone() }
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

/// Scales the flaw, given at a small size, to `times` its minimal detectable size, beside another
/// whose size is not known. The declared head has no free parameters.
pub(crate) fn run_at(
    run: &Run,
    flaw: impl Fn(f64) -> polish::Flaw,
    beside: Option<&dyn Fn(f64) -> polish::Flaw>,
    n_candidates: usize,
) -> polish::Flaw {
    const SMALL: f64 = 1e-3;
    let silent = Run { noise_n: 0.0, length_noise_mm: 0.0, ..run.clone() };
    let before = polish::residuals_n(&silent, &polish::simulate(&silent));
    // The axial cell and the reference; the legs add little.
    let sigma_n = 2f64.sqrt() * run.noise_n;
    let signal = |flaw: polish::Flaw| -> Vec<f64> {
        let faulty = Run { flaw, ..silent.clone() };
        let after = polish::residuals_n(&faulty, &polish::simulate(&faulty));
        after.iter().zip(&before).map(|(a, b)| (a - b) / sigma_n).collect()
    };
    let base = beside.map(|other| signal(other(SMALL))).into_iter().collect();
    let design = Design { signal: signal(flaw(SMALL)), base, n_amplitudes: 1, n_candidates };
    flaw(TIMES * smallest(&design) * SMALL)
}

fn rms(values: &[f64]) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let n = values.len() as f64;
    (values.iter().map(|v| v * v).sum::<f64>() / n).sqrt()
}
