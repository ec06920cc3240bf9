//! A polishing run recorded: a head that follows a freeform surface, pressed unevenly, its legs and
//! cells read beside a reference instrument. Millimetres, newtons, seconds.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::generators::noise::{Colour, Noise};
use crate::generators::vector::{add, cross, norm, scale};
use crate::kinds::force_impedance::polish_head::HeadModel;

/// What is wrong with the head, its sensors or the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Flaw {
    /// Nothing.
    None,
    /// A cell (0 to 3) reads this much under no load, N.
    CellZero(usize, f64),
    /// A length sensor (0 to 3) reads this much too long, mm.
    LengthZero(usize, f64),
    /// A cell reads too large, relative.
    CellGain(usize, f64),
    /// The head is heavier than declared, N.
    Weight(f64),
    /// Coulomb friction of the spline, N.
    Spline(f64),
    /// The axial cell drifts in proportion to time, N over the run.
    Drift(f64),
    /// The reference is read late, s.
    Delay(f64),
    /// The axial cell reads `f·(1 + factor·f)`, 1/N.
    CellCurvature(f64),
    /// The reference shows mechanical play, N half width.
    Play(f64),
    /// The axial cell follows a humidity that only the table knows, N per percent.
    Humidity(f64),
    /// The reference reads too high in one strip: which, N.
    Strip(usize, f64),
    /// The zero of the axial cell settles, N at the start: six tenths of it with a time constant of
    /// a twelfth of the run, the rest with one of half the run.
    Settling(f64),
    /// The reference warms up, with a time constant of an eighth of the run, and reads low: N in the
    /// end.
    Warming(f64),
    /// The axial cell follows the temperature of the air from 20 °C, N/K.
    Warmth(f64),
}

/// A run to simulate.
#[expect(clippy::struct_excessive_bools, reason = "columns of the table that may be there")]
#[derive(Clone, Debug)]
pub(crate) struct Run {
    /// Strips of the raster, each a segment.
    pub n_segments: usize,
    /// Samples per strip.
    pub n_samples: usize,
    /// Samples per second.
    pub rate_hz: f64,
    /// Forces asked for, taken in turn, N.
    pub loads_n: Vec<f64>,
    /// Friction over normal force.
    pub friction: f64,
    /// Standard deviation of a cell and of the reference, N.
    pub noise_n: f64,
    /// Standard deviation of a length, mm.
    pub length_noise_mm: f64,
    /// Dependence of successive samples of a channel.
    pub colour: Colour,
    /// Whether the case declares the noise.
    pub declare_noise: bool,
    /// Whether there is a reference instrument.
    pub reference: bool,
    /// Whether strips are named in the table.
    pub name_segments: bool,
    /// Whether the temperature of the air is in the table.
    pub record_air: bool,
    /// Weight of the head, declared, N.
    pub weight_n: f64,
    /// Formula that the case declares.
    pub formula: &'static str,
    /// What is wrong.
    pub flaw: Flaw,
    /// What is wrong beside it.
    pub also: Flaw,
    /// Seed of everything random.
    pub seed: u64,
}

impl Run {
    /// Ten strips of forty samples at 30, 45 and 60 N, nothing wrong.
    pub(crate) fn new(seed: u64) -> Self {
        Self {
            n_segments: 10,
            n_samples: 40,
            rate_hz: 20.0,
            loads_n: vec![30.0, 45.0, 60.0],
            friction: 0.18,
            noise_n: 0.15,
            length_noise_mm: 0.001,
            colour: Colour::White,
            declare_noise: true,
            reference: true,
            name_segments: true,
            record_air: false,
            weight_n: HeadModel::USUAL.weight_n,
            formula: "full-balance",
            flaw: Flaw::None,
            also: Flaw::None,
            seed,
        }
    }
}

/// One row of the log.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    /// Since the run began, s.
    pub time_s: f64,
    /// Strip.
    pub segment: usize,
    /// As read.
    pub lengths_mm: [f64; 4],
    /// As read.
    pub cells_n: [f64; 4],
    /// Outward unit normal.
    pub normal: [f64; 3],
    /// As read.
    pub reference_n: f64,
    /// Relative humidity, percent.
    pub humidity_pct: f64,
    /// Temperature of the air, °C.
    pub air_c: f64,
}

/// Depth of the waves of the workpiece, mm, and their lengths, mm.
const WAVES: [[f64; 2]; 2] = [[5.0, 140.0], [3.5, 95.0]];
/// Distance of the strips, mm.
const PITCH_MM: f64 = 9.0;
/// Feed, mm/s.
const FEED_MM_PER_S: f64 = 22.0;
/// Sum of the legs' readings, N.
const BRACING_N: f64 = 330.0;
/// Seconds between strips.
const PAUSE_S: f64 = 1.0;

/// Simulates a run.
pub(crate) fn simulate(run: &Run) -> Vec<Sample> {
    let mut rng = ChaCha8Rng::seed_from_u64(run.seed);
    let phases: [f64; 6] = std::array::from_fn(|_| rng.random_range(0.0..TAU));
    let mut rig = Rig::new(run, phases, &mut rng);
    let strip_s = rig.strip_s;
    let strip = |segment: usize| {
        let at = |since_s: f64| raster(run, &phases, strip_s, segment, since_s);
        rig.record(segment, run.n_samples, &mut rng, &at)
    };
    (0..run.n_segments).flat_map(strip).collect()
}

/// Runs recorded afterwards, each of so many samples, where the tool does something else.
pub(crate) fn record_on(
    run: &Run,
    made: &[Box<dyn Fn(f64) -> Instant>],
    n_samples: usize,
    seed: u64,
) -> Vec<Sample> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut rig = Rig::new(run, [0.0; 6], &mut rng);
    let segments = (run.n_segments..).zip(made);
    segments.flat_map(|(segment, at)| rig.record(segment, n_samples, &mut rng, at)).collect()
}

struct Rig<'a> {
    run: &'a Run,
    /// Of the air that nobody records.
    phases: [f64; 6],
    strip_s: f64,
    run_s: f64,
    /// Noise of the cells and of the reference.
    forces: Vec<Noise>,
    lengths: Vec<Noise>,
    /// What a reference with play shows.
    play_n: f64,
}

/// Where tool and workpiece are, and how hard they press.
pub(crate) struct Instant {
    pub(crate) tip_mm: [f64; 3],
    /// Outward unit normal.
    pub(crate) normal: [f64; 3],
    /// Direction of friction on the tool; nothing where it stands.
    pub(crate) rubs: [f64; 3],
    pub(crate) press_n: f64,
}

/// Some time into a strip of a raster over a wavy workpiece.
fn raster(run: &Run, phases: &[f64; 6], strip_s: f64, segment: usize, since_s: f64) -> Instant {
    let [p0, p1, p2, p3, p4, p5] = *phases;
    let way = if segment.is_multiple_of(2) { 1.0 } else { -1.0 };
    let (x, z) = (way * FEED_MM_PER_S * (since_s - 0.5 * strip_s), PITCH_MM * as_f64(segment));
    let [[a, l], [b, m]] = WAVES;
    let slope_x = TAU * a / l * (TAU * x / l + p0).cos();
    let slope_z = TAU * b / m * (TAU * z / m + p1).cos();
    let up = [-slope_x, 1.0, -slope_z];
    let normal = scale(1.0 / norm(&up), up);
    let along = [way, way * slope_x, 0.0];
    let along = scale(1.0 / norm(&along), along);
    // The pad turns: its rub is turned from the feed by 40°.
    let across = cross(normal, along);
    let rubs = add(scale(-0.766, along), scale(-0.643, across));
    let t = since_s + as_f64(segment) * strip_s;
    let off_mm = 0.5 * (TAU * 0.21 * t + p2).sin() + 0.25 * (TAU * 0.57 * t + p3).sin();
    let load_n = run.loads_n[segment % run.loads_n.len()];
    let ripple = 0.10 * (TAU * 0.9 * t + p4).sin() + 0.06 * (TAU * 1.7 * t + p5).sin();
    Instant {
        tip_mm: add(HeadModel::USUAL.start_tip_mm(), scale(off_mm, normal)),
        normal,
        rubs,
        press_n: load_n * (1.0 + ripple),
    }
}

impl<'a> Rig<'a> {
    fn new(run: &'a Run, phases: [f64; 6], rng: &mut ChaCha8Rng) -> Self {
        let forces = (0..5).map(|_| Noise::new(run.colour, rng)).collect();
        let lengths = (0..4).map(|_| Noise::new(Colour::White, rng)).collect();
        let strip_s = as_f64(run.n_samples) / run.rate_hz;
        let run_s = as_f64(run.n_segments) * (strip_s + PAUSE_S);
        Self { run, phases, strip_s, run_s, forces, lengths, play_n: 0.0 }
    }

    /// A segment, of what goes on some time after it began.
    fn record(
        &mut self,
        segment: usize,
        n_samples: usize,
        rng: &mut ChaCha8Rng,
        at: &dyn Fn(f64) -> Instant,
    ) -> Vec<Sample> {
        let run = self.run;
        let one = |index: usize| {
            let since_s = as_f64(index) / run.rate_hz;
            let noise = std::array::from_fn(|i| run.noise_n * self.forces[i].next(rng));
            let jitter = std::array::from_fn(|i| run.length_noise_mm * self.lengths[i].next(rng));
            self.sample((segment, since_s), at, noise, jitter)
        };
        (0..n_samples).map(one).collect()
    }

    fn sample(
        &mut self,
        (segment, since_s): (usize, f64),
        at: &dyn Fn(f64) -> Instant,
        noise: [f64; 5],
        jitter: [f64; 4],
    ) -> Sample {
        let run = self.run;
        let now = at(since_s);
        let time_s = as_f64(segment) * (self.strip_s + PAUSE_S) + since_s;
        let flaws = [run.flaw, run.also];
        let heavier_n: f64 =
            flaws.iter().map(|f| if let Flaw::Weight(n) = f { *n } else { 0.0 }).sum();
        let head = HeadModel { weight_n: run.weight_n + heavier_n, ..HeadModel::USUAL };
        let placed = head.at(now.tip_mm);
        let rub_n = scale(run.friction * now.press_n, now.rubs);
        let force_n = add(scale(now.press_n, now.normal), rub_n);
        let mut cells_n = placed.cells_n(force_n, BRACING_N);
        let mut lengths_mm = placed.lengths_mm;
        let later = norm(&at(since_s + 1e-4).tip_mm);
        // Damp air comes and goes with the hour, not with the strips.
        let humidity_pct = 45.0 + 6.0 * (TAU * 1.37 * time_s / self.run_s + self.phases[0]).sin();
        let air_c = self.air_c(time_s);
        for flaw in flaws {
            match flaw {
                Flaw::CellZero(i, zero_n) => cells_n[i] += zero_n,
                Flaw::CellGain(i, gain) => cells_n[i] *= 1.0 + gain,
                Flaw::LengthZero(i, zero_mm) => lengths_mm[i] += zero_mm,
                Flaw::Spline(n) => cells_n[3] += n * (later - norm(&now.tip_mm)).signum(),
                Flaw::Drift(n) => cells_n[3] += n * time_s / self.run_s,
                Flaw::CellCurvature(per_n) => cells_n[3] *= 1.0 + per_n * cells_n[3],
                Flaw::Humidity(n) => cells_n[3] += n * (humidity_pct - 45.0),
                Flaw::Warmth(n) => cells_n[3] += n * (air_c - 20.0),
                Flaw::Settling(n) => {
                    let share = time_s / self.run_s;
                    cells_n[3] += n * (0.6 * (-12.0 * share).exp() + 0.4 * (-2.0 * share).exp());
                }
                Flaw::Strip(..)
                | Flaw::None
                | Flaw::Weight(_)
                | Flaw::Delay(_)
                | Flaw::Play(_)
                | Flaw::Warming(_) => {}
            }
        }
        let late_s: f64 =
            flaws.iter().map(|f| if let Flaw::Delay(late_s) = f { *late_s } else { 0.0 }).sum();
        let mut reference_n = at(since_s - late_s).press_n;
        for flaw in flaws {
            match flaw {
                Flaw::Play(width_n) => {
                    let within = (reference_n - width_n, reference_n + width_n);
                    self.play_n = self.play_n.clamp(within.0, within.1);
                    reference_n = self.play_n;
                }
                Flaw::Strip(off, high_n) if off == segment => reference_n += high_n,
                Flaw::Warming(n) => reference_n -= n * (1.0 - (-8.0 * time_s / self.run_s).exp()),
                _ => {}
            }
        }
        Sample {
            time_s,
            segment,
            lengths_mm: std::array::from_fn(|i| lengths_mm[i] + jitter[i]),
            cells_n: std::array::from_fn(|i| cells_n[i] + noise[i]),
            normal: now.normal,
            reference_n: reference_n + noise[4],
            humidity_pct,
            air_c,
        }
    }

    /// A hall that warms and cools with the door and the plant, to either side of 20 °C.
    fn air_c(&self, time_s: f64) -> f64 {
        let share = TAU * time_s / self.run_s;
        20.0 + 1.0 * (2.3 * share + self.phases[3]).sin()
            + 0.8 * (0.9 * share + self.phases[5]).sin()
    }
}

/// Normal force by the declared head − reference, of every sample, by the simulator's own statics.
pub(crate) fn residuals_n(run: &Run, samples: &[Sample]) -> Vec<f64> {
    let head = HeadModel { weight_n: run.weight_n, ..HeadModel::USUAL };
    let residual = |s: &Sample| {
        // The legs' lengths hardly move the answer: the tip is had from the axial unit and the
        // differences of the legs, by Newton's method on the simulator's own head.
        let placed = head.at(tip_of(s.lengths_mm));
        let force_n = placed.force_n(s.cells_n);
        (0..3).map(|i| force_n[i] * s.normal[i]).sum::<f64>() - s.reference_n
    };
    samples.iter().map(residual).collect()
}

/// The tip that four lengths belong to, least squares by repeated linearisation with differences.
fn tip_of(lengths_mm: [f64; 4]) -> [f64; 3] {
    const STEP_MM: f64 = 1e-4;
    let head = HeadModel::USUAL;
    let mut tip_mm = head.start_tip_mm();
    for _ in 0..8 {
        let here = head.at(tip_mm).lengths_mm;
        let columns: [[f64; 4]; 3] = std::array::from_fn(|axis| {
            let mut moved = tip_mm;
            moved[axis] += STEP_MM;
            let there = head.at(moved).lengths_mm;
            std::array::from_fn(|i| (there[i] - here[i]) / STEP_MM)
        });
        let dot = |a: &[f64; 4], b: &[f64; 4]| (0..4).map(|i| a[i] * b[i]).sum::<f64>();
        let misfit: [f64; 4] = std::array::from_fn(|i| lengths_mm[i] - here[i]);
        let rows: Vec<Vec<f64>> = (0..3)
            .map(|i| {
                let mut row: Vec<f64> = (0..3).map(|j| dot(&columns[i], &columns[j])).collect();
                row.push(dot(&columns[i], &misfit));
                row
            })
            .collect();
        let step = crate::kinds::force_impedance::polish_head::solve(rows);
        (0..3).for_each(|i| tip_mm[i] += step[i]);
    }
    tip_mm
}

#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
fn as_f64(count: usize) -> f64 {
    count as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sound_run_without_noise_has_no_residual() {
        let run = Run { noise_n: 0.0, length_noise_mm: 0.0, ..Run::new(1) };
        for residual_n in residuals_n(&run, &simulate(&run)) {
            // Differences of 1e-4 mm leave the Newton steps of the tip at 1e-9 mm.
            assert!(residual_n.abs() < 1e-6, "{residual_n}");
        }
    }

    #[test]
    fn the_noise_is_as_large_as_declared() {
        let run = Run::new(2);
        let samples = simulate(&run);
        let mean_square: f64 =
            residuals_n(&run, &samples).iter().map(|r| r * r).sum::<f64>() / as_f64(samples.len());
        // The axial cell and the reference, 0.15 N each, and little of the legs; 400 samples.
        let expected = 0.15 * 2f64.sqrt();
        assert!((mean_square.sqrt() / expected - 1.0).abs() < 0.12, "{}", mean_square.sqrt());
    }
}
