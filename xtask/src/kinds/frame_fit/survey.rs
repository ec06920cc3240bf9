//! A survey: points set on a machine and measured by a tracker, in millimetres.
//!
//! The machine says where it is (`from`), the tracker where it sees the machine (`to`). Between
//! them are the tracker's pose, what is wrong with the machine, and the noise.

use std::fmt::Write as _;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::generators::noise::{Colour, Noise, gaussian};
use crate::generators::vector::{add, norm, rotate, scale};

/// What is wrong with the machine or the measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Defect {
    /// Nothing.
    None,
    /// The frame is displaced, mm.
    Shift([f64; 3]),
    /// The frame is rotated about its origin, rad.
    Rotation([f64; 3]),
    /// All axes too long, relative.
    Scale(f64),
    /// Each axis too long by its own, relative.
    AxisScale([f64; 3]),
    /// Axes not square: x gains `[0]·y`, x gains `[1]·z`, y gains `[2]·z`, rad.
    Squareness([f64; 3]),
    /// One target sits wrong in its nest: which one, and by how much, mm.
    BadPoint(usize, [f64; 3]),
    /// The tracker's stand creeps towards its warm state: total over the survey, mm.
    ///
    /// First-order warming whose time constant is twice the survey.
    Drift([f64; 3]),
    /// A stand that was moved sets: in the end by this, mm, with this share of the session as its
    /// time constant.
    Settling([f64; 3], f64),
    /// The ram bends under the moving saddle: largest deflection, mm, downwards (−z).
    ///
    /// Moving load on a beam on two supports 400 mm outside the travel:
    /// deflection under the load ∝ x²(L−x)².
    Sag(f64),
    /// Cubic error of the x scale: error at the end of travel, mm.
    Cubic(f64),
    /// Lead screw of the x axis: amplitude, mm, and period, mm.
    LeadScrew(f64, f64),
    /// The machine's scales grow with the air temperature, which is recorded: relative per kelvin
    /// away from 20 °C.
    Expansion(f64),
    /// The machine is longer in the last third of the survey, a session that nobody recorded the
    /// temperature of: relative.
    WarmSession(f64),
    /// Every place of the machine has an error of its own, along x, that is the same whenever it
    /// goes there: standard deviation, mm.
    Profile(f64),
    /// A mount of carbon-fibre composite swells with humidity: mm per percent, along z.
    Humidity(f64),
}

/// A survey to simulate.
#[derive(Clone, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "independent circumstances")]
pub(crate) struct Survey {
    /// Points fitted.
    pub n_fit: usize,
    /// Points set aside for judging.
    pub n_check: usize,
    /// Whether to measure x and y only.
    pub planar: bool,
    /// Whether the tracker's frame was built parallel to the machine's and on its origin.
    pub common_frame: bool,
    /// Whether the second frame is left-handed, as a camera's with y downwards.
    pub mirrored: bool,
    /// Standard uncertainty of one coordinate, mm.
    pub noise_mm: f64,
    /// Dependence of successive points.
    pub colour: Colour,
    /// Whether the case declares the noise.
    pub declare_noise: bool,
    /// Value of `[model] transform`.
    pub transform: &'static str,
    /// Value of `[model] handedness`, where the case declares it.
    pub handedness: Option<&'static str>,
    /// Whether the air temperature is recorded, which drives nothing.
    pub record_air: bool,
    /// How often all places are visited, one round a session; the number of points is that of all.
    pub rounds: usize,
    /// What is wrong.
    pub defect: Defect,
    /// What else is wrong.
    pub also: Defect,
    /// Seed of everything random.
    pub seed: u64,
}

impl Survey {
    /// Eighteen points and six check points, 2 µm, rigid, nothing wrong.
    pub(crate) fn new(seed: u64) -> Self {
        Self {
            n_fit: 18,
            n_check: 6,
            planar: false,
            common_frame: false,
            mirrored: false,
            noise_mm: 0.002,
            colour: Colour::White,
            declare_noise: true,
            transform: "rigid",
            handedness: None,
            record_air: false,
            rounds: 1,
            defect: Defect::None,
            also: Defect::None,
            seed,
        }
    }
}

/// What a survey gave.
#[derive(Clone, Debug)]
pub(crate) struct Surveyed {
    /// Text of `case.toml`.
    pub case_toml: String,
    /// Text of `pairs.csv`.
    pub pairs_csv: String,
    /// Machine's word for each point, in the order measured, mm.
    pub from_mm: Vec<[f64; 3]>,
    /// Whether each point is set aside for judging.
    pub is_check: Vec<bool>,
    /// Rows of the map from the machine's frame to the tracker's, without the defect.
    pub second_from_first: [[f64; 4]; 3],
    /// What the defect did to each point, in the machine's frame, mm.
    pub displacement_mm: Vec<[f64; 3]>,
    /// Root mean square over check points of the length of the noise alone, mm.
    pub check_noise_mm: f64,
}

/// Half the travel of the machine: x, y, z, mm.
const TRAVEL_MM: [f64; 3] = [300.0, 200.0, 125.0];
/// How far outside the travel the supports of the ram stand, mm.
const SUPPORT_MM: f64 = 400.0;
/// The stand's warming time constant over the length of the survey.
const WARMING_TIME: f64 = 2.0;
/// Seconds between points: drive, settle, average.
const POINT_INTERVAL_S: f64 = 40.0;

/// Simulates a survey.
pub(crate) fn simulate(survey: &Survey) -> Surveyed {
    let mut rng = ChaCha8Rng::seed_from_u64(survey.seed);
    let pose = Pose::random(survey, &mut rng);
    let n_points = survey.n_fit + survey.n_check;
    let places = spread_points(n_points / survey.rounds, survey.planar, &mut rng);
    let from_mm: Vec<[f64; 3]> = places.iter().copied().cycle().take(n_points).collect();
    let is_check = check_points(survey.n_fit, survey.n_check);
    let covariates = Covariates::simulate(n_points, &mut rng);
    let mut noises: Vec<Noise> = (0..3).map(|_| Noise::new(survey.colour, &mut rng)).collect();

    let mut displacement_mm = Vec::new();
    let mut to_mm = Vec::new();
    let mut check_noise = 0.0;
    for (index, &from) in from_mm.iter().enumerate() {
        let [first, second] = [survey.defect, survey.also]
            .map(|defect| displacement_of(defect, from, index, &covariates));
        let displacement = add(first, second);
        let mut noise: [f64; 3] =
            std::array::from_fn(|axis| survey.noise_mm * noises[axis].next(&mut rng));
        if survey.planar {
            noise[2] = 0.0;
        }
        if is_check[index] {
            check_noise += norm(&noise).powi(2);
        }
        to_mm.push(add(pose.map(add(from, displacement)), noise));
        displacement_mm.push(displacement);
    }
    Surveyed {
        case_toml: case_toml(survey),
        pairs_csv: pairs_csv(survey, &from_mm, &to_mm, &is_check, &covariates),
        from_mm,
        is_check,
        second_from_first: pose.rows(),
        displacement_mm,
        check_noise_mm: (check_noise / as_f64(survey.n_check.max(1))).sqrt(),
    }
}

/// Where the tracker sees points that the machine goes to after a survey, with noise of its own;
/// of defects that need neither time nor temperature.
pub(crate) fn measure_again(survey: &Survey, from_mm: &[[f64; 3]], seed: u64) -> Vec<[f64; 3]> {
    // The pose is the first thing that a survey draws.
    let pose = Pose::random(survey, &mut ChaCha8Rng::seed_from_u64(survey.seed));
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let covariates = Covariates::simulate(from_mm.len(), &mut rng);
    (from_mm.iter().enumerate())
        .map(|(index, &from)| {
            let off = [survey.defect, survey.also]
                .map(|defect| displacement_of(defect, from, index, &covariates));
            let noise = std::array::from_fn(|_| survey.noise_mm * gaussian(&mut rng));
            add(pose.map(add(from, add(off[0], off[1]))), noise)
        })
        .collect()
}

/// Displacement of one point by the defect, in the machine's frame, mm.
fn displacement_of(defect: Defect, p: [f64; 3], index: usize, covariates: &Covariates) -> [f64; 3] {
    match defect {
        Defect::None => [0.0; 3],
        Defect::Shift(shift) => shift,
        Defect::Rotation(r) => {
            let angle = norm(&r);
            let turned = rotate(scale(1.0 / angle.max(1e-300), r), angle, p);
            add(turned, scale(-1.0, p))
        }
        Defect::Scale(s) => scale(s, p),
        Defect::AxisScale(s) => std::array::from_fn(|i| s[i] * p[i]),
        Defect::Squareness(g) => [g[0] * p[1] + g[1] * p[2], g[2] * p[2], 0.0],
        Defect::BadPoint(bad, offset) => {
            if index == bad {
                offset
            } else {
                [0.0; 3]
            }
        }
        Defect::Drift(total) => {
            let n_points = covariates.air_c.len();
            let time = as_f64(index) / as_f64(n_points - 1) / WARMING_TIME;
            scale((1.0 - (-time).exp()) / (1.0 - (-1.0 / WARMING_TIME).exp()), total)
        }
        Defect::Settling(total, share) => {
            let time = as_f64(index) / as_f64(covariates.air_c.len() - 1);
            scale(1.0 - (-time / share).exp(), total)
        }
        Defect::Sag(largest) => {
            let span = 2.0 * (TRAVEL_MM[0] + SUPPORT_MM);
            let x = p[0] + span / 2.0;
            [0.0, 0.0, -largest * (x * (span - x)).powi(2) / (span / 2.0).powi(4)]
        }
        Defect::Cubic(at_end) => [at_end * (p[0] / TRAVEL_MM[0]).powi(3), 0.0, 0.0],
        Defect::LeadScrew(amplitude, period) => {
            [amplitude * (std::f64::consts::TAU * p[0] / period).sin(), 0.0, 0.0]
        }
        Defect::WarmSession(strain) => {
            let is_warm = session_of(index, covariates.air_c.len()) == SESSIONS - 1;
            scale(if is_warm { strain } else { 0.0 }, p)
        }
        Defect::Profile(size) => [size * place_noise(p), 0.0, 0.0],
        Defect::Expansion(per_k) => scale(per_k * (covariates.air_c[index] - 20.0), p),
        Defect::Humidity(per_percent) => {
            [0.0, 0.0, per_percent * (covariates.humidity_pct[index] - 50.0)]
        }
    }
}

/// Sessions of a survey in which one is warm.
const SESSIONS: usize = 3;

/// The session of a point.
fn session_of(index: usize, n_points: usize) -> usize {
    SESSIONS * index / n_points
}

/// A standard normal number that belongs to a place.
fn place_noise(p: [f64; 3]) -> f64 {
    let bits = p.iter().fold(0u64, |bits, v| bits.rotate_left(21) ^ v.to_bits());
    gaussian(&mut ChaCha8Rng::seed_from_u64(bits))
}

/// Where the tracker stands.
struct Pose {
    axis: [f64; 3],
    angle_rad: f64,
    translation_mm: [f64; 3],
    mirrored: bool,
}

impl Pose {
    fn random(survey: &Survey, rng: &mut ChaCha8Rng) -> Self {
        let mut uniform = |half: f64| rng.random_range(-half..half);
        let direction = [uniform(0.05), uniform(0.05), 1.0];
        let length = norm(&direction);
        let angle_rad = uniform(1.2);
        let translation_mm = [uniform(1500.0), uniform(1500.0), uniform(300.0)];
        let axis = if survey.planar { [0.0, 0.0, 1.0] } else { direction.map(|v| v / length) };
        let mirrored = survey.mirrored;
        if survey.common_frame {
            return Self { axis, angle_rad: 0.0, translation_mm: [0.0; 3], mirrored };
        }
        Self { axis, angle_rad, translation_mm, mirrored }
    }

    /// Rows of the map; the translation last.
    fn rows(&self) -> [[f64; 4]; 3] {
        let origin = self.map([0.0; 3]);
        let turned = |k: usize| {
            let unit = std::array::from_fn(|i| f64::from(u8::from(i == k)));
            rotate(
                self.axis,
                self.angle_rad,
                if self.mirrored && k == 1 { [0.0, -1.0, 0.0] } else { unit },
            )
        };
        let columns: [[f64; 3]; 3] = std::array::from_fn(turned);
        std::array::from_fn(|i| [columns[0][i], columns[1][i], columns[2][i], origin[i]])
    }

    fn map(&self, p: [f64; 3]) -> [f64; 3] {
        let p = if self.mirrored { [p[0], -p[1], p[2]] } else { p };
        add(rotate(self.axis, self.angle_rad, p), self.translation_mm)
    }
}

/// Points all over the travel, in an order that does not follow any axis.
///
/// Each axis is cut into as many slices as there are points and every slice is used once
/// (Latin hypercube), so that small surveys reach the ends of every axis.
fn spread_points(n_points: usize, planar: bool, rng: &mut ChaCha8Rng) -> Vec<[f64; 3]> {
    let mut axes: Vec<Vec<f64>> = Vec::new();
    for half in TRAVEL_MM {
        let mut slices: Vec<f64> = (0..n_points)
            .map(|i| {
                let place = (as_f64(i) + rng.random_range(0.0..1.0)) / as_f64(n_points);
                half * (2.0 * place - 1.0)
            })
            .collect();
        for last in (1..n_points).rev() {
            slices.swap(last, rng.random_range(0..=last));
        }
        axes.push(slices);
    }
    (0..n_points)
        .map(|i| {
            let rounded = |axis: usize| (axes[axis][i] * 1e3).round() / 1e3;
            [rounded(0), rounded(1), if planar { 0.0 } else { rounded(2) }]
        })
        .collect()
}

/// Check points spread evenly over the order of measurement.
fn check_points(n_fit: usize, n_check: usize) -> Vec<bool> {
    let n_points = n_fit + n_check;
    (0..n_points).map(|i| (i + 1) * n_check / n_points > i * n_check / n_points).collect()
}

/// What was recorded beside the points.
struct Covariates {
    humidity_pct: Vec<f64>,
    air_c: Vec<f64>,
}

impl Covariates {
    fn simulate(n_points: usize, rng: &mut ChaCha8Rng) -> Self {
        let mut humidity = Noise::new(Colour::Ar1(0.6), rng);
        let humidity_pct =
            (0..n_points).map(|_| ((50.0 + 6.0 * humidity.next(rng)) * 10.0).round() / 10.0);
        let humidity_pct = humidity_pct.collect();
        let mut air = 20.0;
        let air_c = (0..n_points).map(|_| {
            air += 0.08 * gaussian(rng);
            (air * 100.0_f64).round() / 100.0
        });
        Self { humidity_pct, air_c: air_c.collect() }
    }
}

fn case_toml(survey: &Survey) -> String {
    let mut text =
        format!("kind = \"frame-fit\"\n\n[model]\ntransform = \"{}\"\n", survey.transform);
    if let Some(handedness) = survey.handedness {
        let _ = writeln!(text, "handedness = \"{handedness}\"");
    }
    if survey.declare_noise {
        let _ = write!(text, "\n[noise]\npoint_mm = {}\n", survey.noise_mm);
    }
    text
}

fn pairs_csv(
    survey: &Survey,
    from_mm: &[[f64; 3]],
    to_mm: &[[f64; 3]],
    is_check: &[bool],
    covariates: &Covariates,
) -> String {
    let n_axes = if survey.planar { 2 } else { 3 };
    let axes = &["x", "y", "z"][..n_axes];
    let with = |of: fn(&Defect) -> bool| of(&survey.defect) || of(&survey.also);
    let with_humidity = with(|d| matches!(d, Defect::Humidity(_)));
    let with_time =
        with(|d| matches!(d, Defect::Drift(_) | Defect::Settling(..) | Defect::WarmSession(_)));
    let with_session = with(|d| matches!(d, Defect::WarmSession(_)));
    let mut text = "point".to_owned();
    for side in ["from", "to"] {
        for axis in axes {
            let _ = write!(text, ",{side}_{axis}_mm");
        }
    }
    text.push_str(",use");
    text.push_str(if with_humidity { ",humidity_pct" } else { "" });
    text.push_str(if with_time { ",time_s" } else { "" });
    text.push_str(if with_session { ",session" } else { "" });
    text.push_str(if survey.rounds > 1 { ",round,target" } else { "" });
    text.push_str(if survey.record_air { ",air_c" } else { "" });
    text.push('\n');
    for (index, (from, to)) in from_mm.iter().zip(to_mm).enumerate() {
        let _ = write!(text, "P{:02}", index + 1);
        for value in &from[..n_axes] {
            let _ = write!(text, ",{value:.3}");
        }
        for value in &to[..n_axes] {
            let _ = write!(text, ",{value:.5}");
        }
        text.push_str(if is_check[index] { ",check" } else { ",fit" });
        if with_humidity {
            let _ = write!(text, ",{:.1}", covariates.humidity_pct[index]);
        }
        if with_time {
            let _ = write!(text, ",{:.0}", POINT_INTERVAL_S * as_f64(index));
        }
        if with_session {
            let _ = write!(text, ",s{}", session_of(index, from_mm.len()) + 1);
        }
        if survey.rounds > 1 {
            let n_places = from_mm.len() / survey.rounds;
            let _ = write!(text, ",r{},T{:02}", index / n_places + 1, index % n_places + 1);
        }
        if survey.record_air {
            let _ = write!(text, ",{:.2}", covariates.air_c[index]);
        }
        text.push('\n');
    }
    text
}

#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
fn as_f64(count: usize) -> f64 {
    count as f64
}
