//! Cases whose loop ends with rivals, or does not see what there is, and how they go on.

use std::fmt::Write as _;

use anyhow::{Context, Result};
use serde_json::Value;

use super::hanging::Hanging;
use super::head::Polishing;
use super::machines::Pressing;
use super::scene::{Files, Scene};
use super::turning::{Instrument, Upwards};
use crate::kinds::force_impedance::polish;
use crate::kinds::frame_fit::survey::{Defect, Survey, measure_again, simulate};
use crate::kinds::ft_center::press;
use crate::kinds::pose_icp::mirror::{self, Mirror};
use crate::kinds::positioning::axis_run::{self, AxisRun};
use crate::kinds::probe_comp::probe::{self, Meant, Session, Shape};
use crate::kinds::probe_comp::probe_tables::{case_toml, touches_csv};
use crate::kinds::tracker_lm::targets::{Fault, Survey as Points};
use crate::kinds::tracker_lm::tracer::Run;
use crate::kinds::tracker_lm::tracer_run;

/// One situation.
pub(crate) struct Situation {
    pub(crate) krate: &'static str,
    pub(crate) name: &'static str,
    /// The effect that there is.
    pub(crate) truth: &'static str,
    pub(crate) make: fn(u64) -> Box<dyn Scene>,
}

#[expect(clippy::too_many_lines, reason = "a table: one entry per situation")]
pub(super) fn situations() -> Vec<Situation> {
    let probe = |name, truth, make| Situation { krate: "probe-comp", name, truth, make };
    let pose = |name, truth, make| Situation { krate: "pose-icp", name, truth, make };
    let press = |name, truth, make| Situation { krate: "ft-center", name, truth, make };
    let axis = |name, truth, make| Situation { krate: "positioning", name, truth, make };
    let tracer = |name, truth, make| Situation { krate: "tracker-lm", name, truth, make };
    let frame = |name, truth, make| Situation { krate: "frame-fit", name, truth, make };
    let head = |name, truth, make| Situation { krate: "force-impedance", name, truth, make };
    vec![
        probe("ball 8 µm larger, touched along the normal", "tip-radius", |seed| {
            let flaw = probe::Flaw::Ball(0.008);
            Box::new(Touching::open(Session { flaw, ..Session::new(seed) }))
        }),
        probe("triggers 8 µm late, touched along the normal", "pretravel", |seed| {
            let flaw = probe::Flaw::Pretravel(0.008);
            Box::new(Touching::open(Session { flaw, ..Session::new(seed) }))
        }),
        pose("conic 0.03 too large, middle of the mirror touched", "conic", |seed| {
            Box::new(Middle(Mirror { flaw: mirror::Flaw::Conic(0.03), ..Mirror::new(seed) }))
        }),
        pose("three lobes of 6 µm, middle of the mirror touched", "trefoil", |seed| {
            let flaw = mirror::Flaw::Trefoil([5e-3, 3e-3]);
            Box::new(Middle(Mirror { flaw, ..Mirror::new(seed) }))
        }),
        frame("x leans with z, measured in one plane", "shear", |seed| {
            let defect = Defect::Squareness([0.0, 150e-6, -100e-6]);
            Box::new(Flat(Survey { defect, ..Survey::new(seed) }))
        }),
        frame("z reads long, measured in one plane", "anisotropic-scale", |seed| {
            let defect = Defect::AxisScale([0.0, 0.0, 200e-6]);
            Box::new(Flat(Survey { defect, ..Survey::new(seed) }))
        }),
        press("platform 0.5 mm thicker, pressed upright", "contact-height", |seed| {
            let fault = press::Fault::ContactHeight(0.5);
            let session = press::Session { fault, drag: 0.0, ..press::Session::new(seed) };
            let plan = "loads_n = [40]\nleans_deg = [10]";
            Box::new(Pressing { session, aim: "contact-height", plan })
        }),
        press("the head gives way by 1 µm/N, pressed with one load", "load-shift", |seed| {
            let fault = press::Fault::LoadShift([1e-3, -5e-4]);
            let session = press::Session { fault, ..press::Session::new(seed) };
            let session = press::Session { loads_n: vec![40.0], ..session };
            Box::new(Pressing { session, aim: "load-shift", plan: "loads_n = [10, 80]" })
        }),
        axis("stops 8 µm apart from either side, sent from one", "reversal", |seed| {
            Box::new(AxisRun { fault: axis_run::Fault::Reversal(8e-3), seed })
        }),
        axis("to and fro by 4 µm a turn, targets whole turns apart", "cyclic-error", |seed| {
            Box::new(AxisRun { fault: axis_run::Fault::Cyclic(4e-3), seed })
        }),
        tracer("play of the drive, turned upwards only", "backlash", |seed| {
            let defect = tracer_run::Defect::Backlash(6e-5, [6e-3, -3e-3, 4.5e-3]);
            let run = Run { n_stations: 5, n_mounts: 3, n_angles: 9, defect, ..Run::new(seed) };
            Box::new(Upwards { instrument: Instrument::Ranges(run), aim: "backlash", cycles: 1 })
        }),
        head("a leg's cell reads 2 % high, pressed with one load", "leg-gain", |seed| {
            let flaw = polish::Flaw::CellGain(0, 0.02);
            let run = polish::Run { flaw, loads_n: vec![45.0], ..polish::Run::new(seed) };
            Box::new(Polishing { run, aim: "leg-gain", plan: "leans_deg = [0, 15]" })
        }),
        head("head 3 N heavier, upright on a hill", "head-weight", |seed| {
            let run = polish::Run { flaw: polish::Flaw::Weight(3.0), ..polish::Run::new(seed) };
            Box::new(Polishing { run, aim: "head-weight", plan: "leans_deg = [0, 20]" })
        }),
        pose("coma of 6 µm, middle of the mirror touched", "coma", |seed| {
            let flaw = mirror::Flaw::Coma([5e-3, 3e-3]);
            Box::new(Middle(Mirror { flaw, ..Mirror::new(seed) }))
        }),
        press("moments read 60 N·mm beside, pressed with one load", "sensor-bias", |seed| {
            let fault = press::Fault::Bias([0.0, 0.0, 0.0, 30.0, -50.0, 0.0]);
            let session =
                press::Session { fault, loads_n: vec![40.0], ..press::Session::new(seed) };
            Box::new(Pressing { session, aim: "sensor-bias", plan: "loads_n = [10, 80]" })
        }),
        head("a leg's cell reads 1 N with no load, pressed with one load", "leg-zero", |seed| {
            let flaw = polish::Flaw::CellZero(0, 1.0);
            let run = polish::Run { flaw, loads_n: vec![45.0], ..polish::Run::new(seed) };
            Box::new(Polishing { run, aim: "rivals", plan: "leans_deg = [0, 15]" })
        }),
        probe("read 5 ms late, touched with one feed", "latency", |seed| {
            let flaw = probe::Flaw::Latency(5e-3);
            let session = Session { flaw, feeds_mm_per_min: &[100.0], ..Session::new(seed) };
            let plan = "feeds_mm_per_min = [25, 100]\nmeasured_feed_mm_per_min = 100";
            Box::new(Touching { session, aim: Some("latency"), plan })
        }),
        pose("saddle of 6 µm, middle of the mirror touched", "astigmatism", |seed| {
            let flaw = mirror::Flaw::Astigmatism([5e-3, 3e-3]);
            Box::new(Middle(Mirror { flaw, ..Mirror::new(seed) }))
        }),
        press("platform leans by 10 mrad, pressed upright", "platform-tilt", |seed| {
            let fault = press::Fault::PlatformTilt([8e-3, -6e-3]);
            let session = press::Session { fault, drag: 0.0, ..press::Session::new(seed) };
            let plan = "loads_n = [40]\nleans_deg = [10]";
            Box::new(Pressing { session, aim: "platform-tilt", plan })
        }),
        press("5 N·mm of my per N of fx, pressed upright", "crosstalk", |seed| {
            let fault = press::Fault::Crosstalk(4, 0, 5.0);
            let session = press::Session { fault, drag: 0.0, ..press::Session::new(seed) };
            let plan = "loads_n = [40]\nleans_deg = [10]";
            Box::new(Pressing { session, aim: "crosstalk", plan })
        }),
        head("a leg's length reads 0.3 mm long, pressed with one load", "leg-zero", |seed| {
            let flaw = polish::Flaw::LengthZero(0, 0.3);
            let run = polish::Run { flaw, loads_n: vec![45.0], ..polish::Run::new(seed) };
            Box::new(Polishing { run, aim: "rivals", plan: "leans_deg = [0, 15]" })
        }),
        press("moments read 60 N·mm beside, pressed with two loads", "sensor-bias", |seed| {
            let fault = press::Fault::Bias([0.0, 0.0, 0.0, 30.0, -50.0, 0.0]);
            let session =
                press::Session { fault, loads_n: vec![40.0, 50.0], ..press::Session::new(seed) };
            Box::new(Pressing { session, aim: "rivals", plan: "loads_n = [10, 80]" })
        }),
        probe(
            "the stylus gives way by 20 µm, a bowl touched along the normal",
            "bending",
            |seed| {
                let flaw = probe::Flaw::Bending(0.02);
                let shape = Shape::Bowl { radius_mm: 120.0 };
                Box::new(Touching::open(Session { shape, flaw, ..Session::new(seed) }))
            },
        ),
        head("a leg's length reads 0.3 mm long, no reference", "leg-zero", |seed| {
            let flaw = polish::Flaw::LengthZero(0, 0.3);
            let run = polish::Run { flaw, reference: false, ..polish::Run::new(seed) };
            Box::new(Polishing { run, aim: "rivals", plan: "leans_deg = [0, 15]" })
        }),
        press("platform 0.5 mm thicker, pressed with a drag", "contact-height", |seed| {
            let fault = press::Fault::ContactHeight(0.5);
            let session = press::Session { fault, ..press::Session::new(seed) };
            let plan = "loads_n = [10, 40, 80]\nleans_deg = [0, 10]";
            Box::new(Pressing { session, aim: "rivals", plan })
        }),
        press(
            "the sensor is turned on its flange, weighed about one axis",
            "mount-rotation",
            |seed| Box::new(Hanging { about_x_rad: [0.0, 0.01], seed }),
        ),
        press("the base leans, the tool weighed about one axis", "platform-tilt", |seed| {
            Box::new(Hanging { about_x_rad: [0.01, 0.0], seed })
        }),
        tracer("a tracker's points, play of the drive, turned upwards only", "backlash", |seed| {
            let fault = Fault::Backlash(60e-6, [0.0, 0.02, 0.0]);
            let survey = Points { fault, ..Points::new(seed) };
            Box::new(Upwards { instrument: Instrument::Points(survey), aim: "backlash", cycles: 1 })
        }),
        tracer("one stand gives way by 16 µm, few angles", "station-drift", |seed| {
            let defect = tracer_run::Defect::StationDrift(2, [0.008, -0.006, 0.012]);
            let run = Run { n_stations: 5, n_mounts: 3, n_angles: 9, defect, ..Run::new(seed) };
            Box::new(Upwards { instrument: Instrument::Ranges(run), aim: "rivals", cycles: 3 })
        }),
    ]
}

/// A session of touches that goes on.
#[derive(Debug)]
struct Touching {
    session: Session,
    /// What the plan is made for, where it is not what the loop leaves open.
    aim: Option<&'static str>,
    /// Lines of `[plan]`.
    plan: &'static str,
}

impl Touching {
    /// What the loop leaves open, with what any machine can do.
    fn open(session: Session) -> Self {
        Self { session, aim: None, plan: "" }
    }

    fn case_toml(&self) -> String {
        format!("{}\n[plan]\n{}\n", case_toml(&self.session), self.plan)
    }

    /// The session with more touches, and the approach of every touch beside it, the feed where the first had one.
    fn further(&self, meant: &[Meant], seed: u64) -> Files {
        let session = &self.session;
        let of_feed = session.feeds_mm_per_min.len() == 1;
        let feed = |mm_per_min: f64| if of_feed { format!(",{mm_per_min}") } else { String::new() };
        let touches = probe::simulate(session);
        let heading = if of_feed { ",feed_mm_per_min" } else { "" };
        let mut table = format!("touch,x_mm,y_mm,z_mm,use,time_s,nx,ny,nz{heading}\n");
        let old = touches_csv(session, &touches);
        for (line, touch) in old.lines().skip(1).zip(&touches) {
            let ([x, y, z], feed) = (touch.approach, feed(touch.feed_mm_per_min));
            let _ = writeln!(table, "{line},{x:.6},{y:.6},{z:.6}{feed}");
        }
        let read = probe::touch_again(session, meant, seed);
        for (n, (place, [x, y, z])) in meant.iter().zip(read).enumerate() {
            let time = probe::TOUCH_INTERVAL_S * as_f64(touches.len() + n);
            let ([a, b, c], feed) = (place.approach, feed(place.feed_mm_per_min));
            let at = format!("{x:.5},{y:.5},{z:.5},fit,{time}");
            let _ = writeln!(table, "N{},{at},{a:.6},{b:.6},{c:.6}{feed}", n + 1);
        }
        vec![("case.toml", self.case_toml()), ("touches.csv", table)]
    }
}

impl Scene for Touching {
    fn files(&self) -> Files {
        let touches = touches_csv(&self.session, &probe::simulate(&self.session));
        vec![("case.toml", self.case_toml()), ("touches.csv", touches)]
    }

    fn aim(&self) -> Option<&'static str> {
        self.aim
    }

    fn with_plan(&self, plan: &[Value], seed: u64) -> Result<Files> {
        let meant = plan.iter().map(|one| {
            let touch = &one["touch"];
            Ok(Meant {
                contact_mm: triple(&touch["contact_mm"])?,
                normal: triple(&touch["normal"])?,
                approach: triple(&touch["approach"])?,
                feed_mm_per_min: touch["feed_mm_per_min"].as_f64().context("no feed")?,
            })
        });
        Ok(self.further(&meant.collect::<Result<Vec<_>>>()?, seed))
    }

    fn with_even(&self, count: usize, seed: u64) -> Files {
        self.further(&probe::even_places(&self.session, count), seed)
    }
}

/// A mirror of which only the middle third was touched.
#[derive(Debug)]
struct Middle(Mirror);

/// Share of the places of a mirror that are nearest to its middle.
const MIDDLE: f64 = 1.0 / 3.0;

impl Middle {
    fn with(&self, places: &[[f64; 2]], seed: u64) -> Files {
        let Self(mirror) = self;
        let whole = mirror::simulate(mirror);
        let mut table = String::from("point,x_mm,y_mm,z_mm\n");
        let first = places_of_middle(mirror);
        let old = mirror::touch_again(mirror, &first, mirror.seed + 1);
        let new = mirror::touch_again(mirror, places, seed);
        for (n, [x, y, z]) in old.iter().chain(&new).enumerate() {
            let _ = writeln!(table, "P{},{x:.5},{y:.5},{z:.5}", n + 1);
        }
        let mut files = vec![("case.toml", whole.case_toml), ("points.csv", table)];
        files.extend(whole.edge_csv.map(|edge| ("edge.csv", edge)));
        files
    }
}

fn places_of_middle(mirror: &Mirror) -> Vec<[f64; 2]> {
    let places = mirror::even_places(mirror, mirror.n_points);
    places.into_iter().map(|place| place.map(|v| MIDDLE * v)).collect()
}

impl Scene for Middle {
    fn files(&self) -> Files {
        self.with(&[], 0)
    }

    fn aim(&self) -> Option<&'static str> {
        Some(match self.0.flaw {
            mirror::Flaw::Conic(_) => "conic",
            mirror::Flaw::Coma(_) => "coma",
            mirror::Flaw::Astigmatism(_) => "astigmatism",
            _ => "trefoil",
        })
    }

    fn with_plan(&self, plan: &[Value], seed: u64) -> Result<Files> {
        let places = plan.iter().map(|one| {
            let [x, y, _] = triple(&one["touch"]["contact_mm"])?;
            Ok([x, y])
        });
        Ok(self.with(&places.collect::<Result<Vec<_>>>()?, seed))
    }

    fn with_even(&self, count: usize, seed: u64) -> Files {
        self.with(&mirror::even_places(&self.0, count), seed)
    }
}

/// A survey of which all points lie in one plane, z = 0.
#[derive(Debug)]
struct Flat(Survey);

/// Where the machine of a survey can go, mm from the middle.
const REACH_MM: [f64; 3] = [300.0, 200.0, 125.0];

impl Flat {
    fn with(&self, further: &[[f64; 3]], seed: u64) -> Files {
        let Self(survey) = self;
        let surveyed = simulate(survey);
        let flat: Vec<[f64; 3]> = surveyed.from_mm.iter().map(|[x, y, _]| [*x, *y, 0.0]).collect();
        let first = measure_again(survey, &flat, survey.seed + 1);
        let second = measure_again(survey, further, seed);
        let from = flat.iter().chain(further);
        let mut table =
            String::from("point,from_x_mm,from_y_mm,from_z_mm,to_x_mm,to_y_mm,to_z_mm\n");
        for (n, (from, to)) in from.zip(first.iter().chain(&second)).enumerate() {
            let ([a, b, c], [x, y, z]) = (from, to);
            let _ = writeln!(table, "P{},{a:.3},{b:.3},{c:.3},{x:.5},{y:.5},{z:.5}", n + 1);
        }
        let [_, _, z] = REACH_MM;
        let plan = format!("\n[plan]\nz_mm = [{:.1}, {z:.1}]\n", -z);
        vec![("case.toml", surveyed.case_toml + &plan), ("pairs.csv", table)]
    }
}

impl Scene for Flat {
    fn files(&self) -> Files {
        self.with(&[], 0)
    }

    fn aim(&self) -> Option<&'static str> {
        Some(match self.0.defect {
            Defect::AxisScale(_) => "anisotropic-scale",
            _ => "shear",
        })
    }

    fn with_plan(&self, plan: &[Value], seed: u64) -> Result<Files> {
        let places = plan.iter().map(|one| {
            let cell = |name: &str| one["cells"][name].as_f64().context("no place");
            Ok([cell("from_x_mm")?, cell("from_y_mm")?, cell("from_z_mm")?])
        });
        Ok(self.with(&places.collect::<Result<Vec<_>>>()?, seed))
    }

    /// More points in the plane that is at hand, on a sunflower.
    fn with_even(&self, count: usize, seed: u64) -> Files {
        let place = |n: usize| {
            let radius = ((as_f64(n) + 0.5) / as_f64(count)).sqrt();
            let (sin, cos) = (2.399_963 * as_f64(n)).sin_cos();
            [REACH_MM[0] * radius * cos, REACH_MM[1] * radius * sin, 0.0]
        };
        self.with(&(0..count).map(place).collect::<Vec<_>>(), seed)
    }
}

fn triple(value: &Value) -> Result<[f64; 3]> {
    let at = |n: usize| value[n].as_f64().context("expected three numbers");
    Ok([at(0)?, at(1)?, at(2)?])
}

#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
fn as_f64(n: usize) -> f64 {
    n as f64
}
