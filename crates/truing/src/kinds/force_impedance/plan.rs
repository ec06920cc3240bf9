//! Runs of a head on a plate that could be recorded next.

use force_impedance::{ForceFormula, Head, LogSample, LoggedForce, solve_log};
use nalgebra::{Point3, Unit, UnitQuaternion, Vector3};

use super::plan_settings::{HeadPlanSettings, Load};
use super::settings::{CELLS, LENGTHS, LOG};
use crate::case::{Finite, Positive};
use crate::count::count;
use crate::kinds::lean::Lean;
use crate::kinds::touching::shuffled;
use crate::kinds::{Cells, Offer, Offered};

/// Samples that stand for a planned run.
const SAMPLES: u32 = 20;
/// Time of a run where none is declared.
const SECONDS: f64 = 1.0;
/// Speed of the axial unit where none is declared.
const AXIAL_MM_PER_S: f64 = 5.0;
/// Lean that every head has room for, where the log has none.
const LITTLE_DEG: f64 = 5.0;
/// Sides to which a head leans.
const SIDES: u8 = 4;

/// A log as the planner sees it.
pub(super) struct Logged<'c> {
    pub(super) head: &'c Head,
    pub(super) formula: ForceFormula,
    pub(super) samples: &'c [LogSample],
    pub(super) solved: &'c [LoggedForce],
    /// Name of the segment of every sample, where the log has no column for it.
    pub(super) segments: Option<Vec<String>>,
}

/// What the head does in one run.
#[derive(Clone, Copy, Debug)]
struct Run {
    lean_deg: f64,
    /// Side to which it leans, from x towards z.
    towards_deg: f64,
    /// Normal force at the beginning and at the end.
    load_n: [f64; 2],
    axial_mm_per_s: f64,
    /// Whether the tool moves across the plate: friction acts.
    rubs: bool,
}

/// Runs that could be made, in an order in which load and time do not run together.
pub(super) fn offer(settings: &HeadPlanSettings, log: &Logged<'_>) -> Offer {
    let bench = Bench::of(log);
    let seconds = settings.seconds.map_or(SECONDS, |Positive(seconds)| seconds);
    let last_s = log.samples.iter().map(|s| s.time_s).fold(f64::MIN, f64::max);
    let readings: Vec<_> = LENGTHS
        .into_iter()
        .chain(CELLS)
        .chain(bench.has_reference.then_some("reference_n"))
        .collect();
    let made = shuffled(&runs(settings, &bench));
    let offered = (made.iter().enumerate()).filter_map(|(n, run)| {
        // A pause as long as a run before each.
        let begins_s = last_s + seconds * (2.0 * count(n) + 1.0);
        bench.record(run, begins_s, seconds).map(|rows| Offered {
            rows,
            told: run.told(&bench),
            ..Offered::of_row("segment", Vec::new())
        })
    });
    let mut segments: Vec<usize> = log.samples.iter().map(|s| s.segment).collect();
    segments.dedup();
    let columns = log.segments.clone().map(|names| ("segment".to_owned(), names));
    Offer {
        table: LOG,
        offered: offered.collect(),
        readings,
        columns: columns.into_iter().collect(),
        noun: "run",
        is_record: true,
        is_new_session: false,
        controls: Vec::new(),
        undeclared: settings.undeclared(),
        made: Some(segments.len()),
        minutes: settings.minutes_per_measurement.map(|Positive(minutes)| minutes),
        reach: None,
    }
}

fn runs(settings: &HeadPlanSettings, bench: &Bench<'_>) -> Vec<Run> {
    let declared: Option<Vec<f64>> =
        settings.leans_deg.as_ref().map(|all| all.iter().map(|Lean(angle)| *angle).collect());
    let leans = declared.unwrap_or_else(|| vec![0.0, bench.farthest_deg.max(LITTLE_DEG)]);
    let loads: Vec<f64> = match &settings.loads_n {
        Some(loads) => loads.iter().map(|Load(load)| *load).collect(),
        None => bench.loads_n.to_vec(),
    };
    let speeds: Vec<f64> = match &settings.axial_mm_per_s {
        Some(speeds) => speeds.iter().map(|Finite(speed)| *speed).collect(),
        None => vec![0.0, AXIAL_MM_PER_S, -AXIAL_MM_PER_S],
    };
    let mut courses: Vec<[f64; 2]> = loads.iter().map(|load| [*load; 2]).collect();
    let range = |of: fn(f64, f64) -> f64| loads.iter().copied().reduce(of);
    // A load that changes shows a delay.
    let rising = range(f64::min).zip(range(f64::max)).filter(|(low, high)| low < high);
    courses.extend(rising.map(|(low, high)| [low, high]));
    let mut all = Vec::new();
    for lean in leans {
        let sides = if lean > 0.0 { SIDES } else { 1 };
        for (side, load_n) in (0..sides).flat_map(|side| courses.iter().map(move |c| (side, *c))) {
            for &axial_mm_per_s in &speeds {
                let may_rub = bench.friction_ratio > 0.0 && load_n[1] > 0.0;
                let rubbing: &[bool] = if may_rub { &[false, true] } else { &[false] };
                all.extend(rubbing.iter().map(|&rubs| Run {
                    lean_deg: lean,
                    towards_deg: 360.0 * f64::from(side) / f64::from(SIDES),
                    load_n,
                    axial_mm_per_s,
                    rubs,
                }));
            }
        }
    }
    all
}

impl Run {
    fn told(&self, bench: &Bench<'_>) -> Vec<(&'static str, f64)> {
        let [nx, ny, nz] = bench.normal.into_inner().into();
        let mut told = vec![
            ("nx", nx),
            ("ny", ny),
            ("nz", nz),
            ("lean_deg", self.lean_deg),
            ("lean_towards_deg", self.towards_deg),
            ("load_from_n", self.load_n[0]),
            ("load_to_n", self.load_n[1]),
            ("axial_mm_per_s", self.axial_mm_per_s),
        ];
        if bench.friction_ratio > 0.0 {
            told.push(("moves_across", f64::from(u8::from(self.rubs))));
        }
        told
    }
}

/// The head over a plate as the log had it, on the mean.
struct Bench<'c> {
    log: &'c Logged<'c>,
    has_reference: bool,
    normal: Unit<Vector3<f64>>,
    /// In which the tool moves over the plate.
    across: Vector3<f64>,
    friction_ratio: f64,
    preload_n: f64,
    /// Distance of the tip from the joint in the middle of its travel.
    reach_mm: f64,
    /// Farthest that the head has leant from straight.
    farthest_deg: f64,
    /// None, and the middle and the largest of those that there were.
    loads_n: [f64; 3],
}

impl<'c> Bench<'c> {
    fn of(log: &'c Logged<'c>) -> Self {
        let (samples, solved) = (log.samples, log.solved);
        let mean = |of: &dyn Fn(&LoggedForce) -> f64| {
            solved.iter().map(of).sum::<f64>() / count(solved.len())
        };
        let straight = Unit::new_normalize(log.head.start_tip_mm().coords);
        let sum: Vector3<f64> = samples.iter().map(|s| s.normal.into_inner()).sum();
        let normal = Unit::try_new(sum, f64::EPSILON).unwrap_or(-straight);
        let helper = Vector3::ith(normal.iamin(), 1.0);
        let mut loads: Vec<f64> = solved.iter().map(|s| s.normal_n.max(0.0)).collect();
        loads.sort_by(f64::total_cmp);
        let pressing = solved.iter().filter(|s| s.normal_n > 0.0);
        let mut ratios: Vec<f64> = pressing.map(|s| s.tangential_n / s.normal_n).collect();
        ratios.sort_by(f64::total_cmp);
        Self {
            log,
            has_reference: samples.iter().all(|s| s.reference_n.is_some()),
            normal,
            across: normal.cross(&helper).normalize(),
            friction_ratio: ratios.get(ratios.len() / 2).copied().unwrap_or(0.0),
            preload_n: mean(&|s| s.preload_n),
            reach_mm: mean(&|s| s.tip_mm.norm()),
            farthest_deg: (solved.iter().map(|s| straight.angle(&s.tip_mm)).fold(0.0, f64::max))
                .to_degrees(),
            loads_n: [0.0, loads[loads.len() / 2], loads[loads.len() - 1]],
        }
    }

    /// The record of a run as the declared head reads it; `None` where it cannot get there.
    fn record(&self, run: &Run, begins_s: f64, seconds: f64) -> Option<Vec<Cells>> {
        let samples = (0..SAMPLES)
            .map(|i| self.sample(run, begins_s, seconds, f64::from(i) / f64::from(SAMPLES)))
            .collect::<Option<Vec<_>>>()?;
        let solved = solve_log(self.log.head, &samples, self.log.formula).ok()?;
        let row = |(sample, solved): (&LogSample, &LoggedForce)| {
            let names = LENGTHS.into_iter().chain(CELLS).chain(["nx", "ny", "nz"]);
            let LogSample { lengths_mm, cells_n, normal, .. } = sample;
            let values = lengths_mm.iter().chain(cells_n).chain(normal.iter());
            // Readings have to be those of the model.
            let cells = names.zip(values).map(|(name, value)| (name, format!("{value:.9}")));
            let mut cells: Cells = cells.collect();
            cells.push(("time_s", format!("{:.6}", sample.time_s)));
            if self.has_reference {
                cells.push(("reference_n", format!("{:.9}", solved.normal_n)));
            }
            cells
        };
        Some(samples.iter().zip(&solved).map(row).collect())
    }

    fn sample(&self, run: &Run, begins_s: f64, seconds: f64, share: f64) -> Option<LogSample> {
        let straight = self.log.head.start_tip_mm().coords;
        let (sin, cos) = run.towards_deg.to_radians().sin_cos();
        let about = straight.cross(&Vector3::new(cos, 0.0, sin));
        let lean =
            UnitQuaternion::from_axis_angle(&Unit::try_new(about, 0.0)?, run.lean_deg.to_radians());
        let slid_mm = run.axial_mm_per_s * seconds * (share - 0.5);
        let tip = lean * straight.normalize() * (self.reach_mm + slid_mm);
        let pose = self.log.head.pose_at(&Point3::from(tip)).ok()?;
        let load_n = run.load_n[0] + (run.load_n[1] - run.load_n[0]) * share;
        let rub_n = if run.rubs { self.friction_ratio * load_n } else { 0.0 };
        let force_n = self.normal.into_inner() * load_n - self.across * rub_n;
        let cells_n = self.log.head.balance(&pose).cells_n(&force_n, self.preload_n)?;
        Some(LogSample {
            time_s: begins_s + seconds * share,
            lengths_mm: pose.lengths_mm,
            cells_n,
            normal: self.normal,
            reference_n: None,
            segment: 0,
        })
    }
}
