//! Six effects of every kind, by the size of one amplitude in the unit in which it is reported.

use crate::kinds::force_impedance::polish::{self, Run};
use crate::kinds::frame_fit::survey::{Defect, Survey};
use crate::kinds::ft_center::press::{Fault, Session};
use crate::kinds::pose_icp::mirror::{self, Mirror};
use crate::kinds::probe_comp::probe;
use crate::kinds::tracker_lm::tracer;
use crate::kinds::tracker_lm::tracer_run;
use crate::power::scene::Scene;
use crate::program::without_subject;

/// One effect.
pub(super) struct Situation {
    pub(super) krate: &'static str,
    /// Its id, with its subject in brackets where it has one.
    pub(super) effect: &'static str,
    /// Of which the size is asked.
    pub(super) amplitude: &'static str,
    pub(super) unit: &'static str,
    /// The case of a seed with this much of it.
    pub(super) make: fn(u64, f64) -> Scene,
}

impl Situation {
    /// The id.
    pub(super) fn name(&self) -> &'static str {
        without_subject(self.effect)
    }
}

/// All of them.
pub(super) fn situations() -> Vec<Situation> {
    let kinds = [surveys(), sessions(), logs(), runs(), mirrors(), probings()];
    kinds.into_iter().flatten().collect()
}

type Make = fn(u64, f64) -> Scene;

fn of(
    krate: &'static str,
    all: &[(&'static str, &'static str, &'static str, Make); 6],
) -> Vec<Situation> {
    let one = |&(effect, amplitude, unit, make)| Situation { krate, effect, amplitude, unit, make };
    all.iter().map(one).collect()
}

/// How long a survey takes: a point every forty seconds.
const SURVEY_H: f64 = 47.0 * 40.0 / 3600.0;

fn surveys() -> Vec<Situation> {
    fn with(seed: u64, defect: Defect) -> Scene {
        Scene::Survey(Survey {
            defect,
            record_air: true,
            n_fit: 36,
            n_check: 12,
            ..Survey::new(seed)
        })
    }
    of(
        "frame-fit",
        &[
            ("scale", "scale", "ppm", |seed, s| with(seed, Defect::Scale(s * 1e-6))),
            ("anisotropic-scale", "x", "ppm", |seed, s| {
                with(seed, Defect::AxisScale([s * 1e-6, 0.0, 0.0]))
            }),
            ("shear", "xy", "µrad", |seed, s| {
                with(seed, Defect::Squareness([s * 1e-6, 0.0, 0.0]))
            }),
            ("drift", "z", "mm/h", |seed, s| with(seed, Defect::Drift([0.0, 0.0, s * SURVEY_H]))),
            ("bad-point [P01]", "x", "mm", |seed, s| {
                with(seed, Defect::BadPoint(0, [s, 0.0, 0.0]))
            }),
            ("temperature", "expansion", "ppm/K", |seed, s| {
                with(seed, Defect::Expansion(s * 1e-6))
            }),
        ],
    )
}

fn sessions() -> Vec<Situation> {
    fn with(seed: u64, fault: Fault) -> Scene {
        let loads_n = vec![20.0, 35.0, 60.0];
        let session =
            Session { n_frame: 27, n_check: 9, loads_n, drag: 0.15, ..Session::new(seed) };
        Scene::Session(Session { fault, ..session })
    }
    of(
        "ft-center",
        &[
            ("sensor-bias [moment]", "mx", "N·mm", |seed, s| {
                with(seed, Fault::Bias([0.0, 0.0, 0.0, s, 0.0, 0.0]))
            }),
            ("bias-drift [moment]", "mx", "N·mm", |seed, s| {
                with(seed, Fault::BiasDrift([0.0, 0.0, 0.0, s, 0.0, 0.0]))
            }),
            ("moment-gain", "gain error", "ppm", |seed, s| with(seed, Fault::MomentGain(s * 1e-6))),
            ("frame-scale", "scale error", "ppm", |seed, s| {
                with(seed, Fault::FrameScale(s * 1e-6))
            }),
            ("contact-height", "height error", "mm", |seed, s| with(seed, Fault::ContactHeight(s))),
            ("load-shift", "x", "µm/N", |seed, s| with(seed, Fault::LoadShift([s * 1e-3, 0.0]))),
        ],
    )
}

fn logs() -> Vec<Situation> {
    fn with(seed: u64, flaw: polish::Flaw) -> Scene {
        Scene::Run(Run { flaw, ..Run::new(seed) })
    }
    of(
        "force-impedance",
        &[
            ("leg-zero [force, axial]", "zero", "N", |seed, s| {
                with(seed, polish::Flaw::CellZero(3, s))
            }),
            ("leg-gain [force, axial]", "gain error", "%", |seed, s| {
                with(seed, polish::Flaw::CellGain(3, s * 1e-2))
            }),
            ("head-weight", "missing weight", "N", |seed, s| with(seed, polish::Flaw::Weight(s))),
            ("spline-friction", "friction force", "N", |seed, s| {
                with(seed, polish::Flaw::Spline(s))
            }),
            ("force-drift", "drift over the log", "N", |seed, s| {
                with(seed, polish::Flaw::Drift(s))
            }),
            ("delay", "delay", "ms", |seed, s| with(seed, polish::Flaw::Delay(s * 1e-3))),
        ],
    )
}

/// How long a run takes.
const RUN_H: f64 = 0.125;

fn runs() -> Vec<Situation> {
    use tracer_run::Defect as Flaw;
    fn run(seed: u64) -> tracer::Run {
        tracer::Run { n_angles: 19, record_air: true, ..tracer::Run::new(seed) }
    }
    fn with(seed: u64, defect: Flaw) -> Scene {
        Scene::Tracer(tracer::Run { defect, ..run(seed) })
    }
    fn known(seed: u64, defect: Flaw) -> Scene {
        Scene::Tracer(tracer::Run { defect, stations_off_mm: 5e-4, ..run(seed) })
    }
    of(
        "tracker-lm",
        &[
            ("range-scale", "scale", "ppm", |seed, s| known(seed, Flaw::RangeScale(s * 1e-6))),
            ("bad-station [S5]", "scale", "ppm", |seed, s| {
                known(seed, Flaw::BadStation(4, s * 1e-6))
            }),
            ("temperature [air_c]", "scale", "ppm/K", |seed, s| {
                with(seed, Flaw::Temperature(s * 1e-6))
            }),
            ("incidence", "at grazing incidence", "µm", |seed, s| {
                with(seed, Flaw::Incidence(s * 1e-3))
            }),
            ("station-drift [S3]", "x", "mm/h", |seed, s| {
                with(seed, Flaw::StationDrift(2, [s * RUN_H, 0.0, 0.0]))
            }),
            ("station-drift [S1]", "z", "mm/h", |seed, s| {
                with(seed, Flaw::StationDrift(0, [0.0, 0.0, s * RUN_H]))
            }),
        ],
    )
}

fn mirrors() -> Vec<Situation> {
    use mirror::Flaw;
    fn with(seed: u64, flaw: Flaw) -> Scene {
        Scene::Mirror(Mirror { flaw, n_points: 72, ..Mirror::new(seed) })
    }
    of(
        "pose-icp",
        &[
            ("vertex-radius", "radius", "mm", |seed, s| with(seed, Flaw::VertexRadius(s))),
            ("conic", "conic", "1", |seed, s| with(seed, Flaw::Conic(s))),
            ("astigmatism", "cos", "µm", |seed, s| with(seed, Flaw::Astigmatism([s * 1e-3, 0.0]))),
            ("coma", "cos", "µm", |seed, s| with(seed, Flaw::Coma([s * 1e-3, 0.0]))),
            ("trefoil", "cos", "µm", |seed, s| with(seed, Flaw::Trefoil([s * 1e-3, 0.0]))),
            ("axis-scale [x]", "x", "ppm", |seed, s| {
                with(seed, Flaw::MachineScale([s * 1e-6, 0.0, 0.0]))
            }),
        ],
    )
}

fn probings() -> Vec<Situation> {
    use probe::{Flaw, Session};
    fn with(seed: u64, flaw: Flaw) -> Scene {
        Scene::Probe(Session { flaw, ..Session::new(seed) })
    }
    of(
        "probe-comp",
        &[
            ("tip-radius", "radius", "mm", |seed, s| with(seed, Flaw::Ball(s))),
            ("bending", "sideways", "µm", |seed, s| with(seed, Flaw::Bending(s * 1e-3))),
            ("squareness", "xy", "µrad", |seed, s| {
                with(seed, Flaw::Squareness([s * 1e-6, 0.0, 0.0]))
            }),
            ("axis-scale [y]", "y", "ppm", |seed, s| {
                with(seed, Flaw::AxisScale([0.0, s * 1e-6, 0.0]))
            }),
            ("lobing [with the sideways part of the approach]", "cos", "µm", |seed, s| {
                let flaw = Flaw::Lobing([s * 1e-3, 0.0]);
                Scene::Probe(Session { flaw, oblique_rad: 0.5, ..Session::new(seed) })
            }),
            ("bad-point [T01]", "along the normal", "mm", |seed, s| {
                with(seed, Flaw::BadPoint(0, s))
            }),
        ],
    )
}
