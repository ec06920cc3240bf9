//! Ranges from a ship to transponders on the sea floor: a stranger's problem on the bordered core.
//!
//! Four stations and the lever arm from antenna to transducer are shared; every survey line has a
//! sound speed of its own that may drift. The error is that of shots, or of whole lines, left out of
//! the fit; the speed of a line left out is taken from its neighbours. Reads the sample of github.com/s-watanabe-jhod/garpos, commit 0e463b347fac, from the folder
//! `garpos_saga_multilateration` under `TRUING_MEASURED_DATA`; says so and stops without it.

#![expect(clippy::print_stdout, reason = "the output of an example")]
#![expect(clippy::cast_precision_loss, reason = "some thousands of shots")]

use std::collections::BTreeMap;
use std::error::Error;
use std::fs;
use std::path::Path;

use least_squares::{
    BlockRows, BorderedOptions, BorderedPoint, BorderedProblem, Pattern, solve_bordered,
};
use nalgebra::{Matrix3, Rotation3, RowVector3, Vector3};

/// Standard uncertainty of half the path there and back.
const SIGMA_M: f64 = 0.05;
const STATIONS: [&str; 4] = ["M11", "M12", "M13", "M14"];
const LEVER: usize = 3 * STATIONS.len();
const SHARED: usize = LEVER + 3;
/// Every shot is left out once in this many fits.
const FOLDS: usize = 5;

/// One signal there and back.
struct Shot {
    station: usize,
    line: String,
    flight_s: f64,
    sent_s: f64,
    /// Antenna and attitude when it was sent, and when the answer came.
    ends: [(Vector3<f64>, Matrix3<f64>); 2],
}

impl Shot {
    /// Half the geometric path, and its derivatives by station and by lever arm.
    fn path(&self, shared: &[f64]) -> (f64, RowVector3<f64>, RowVector3<f64>) {
        let station = Vector3::from_column_slice(&shared[3 * self.station..][..3]);
        let lever = Vector3::from_column_slice(&shared[LEVER..]);
        let mut sum = (0.0, RowVector3::zeros(), RowVector3::zeros());
        for (antenna, attitude) in &self.ends {
            let ray = station - (antenna + attitude * lever);
            let along = ray.normalize().transpose() * 0.5;
            sum = (sum.0 + 0.5 * ray.norm(), sum.1 + along, sum.2 - along * attitude);
        }
        sum
    }
}

/// Shots by survey line, with the time of each from −1 at the start of its line to 1 at its end.
struct Survey<'a> {
    lines: Vec<Vec<(&'a Shot, f64)>>,
    patterns: Vec<Pattern>,
    /// 1, or 2 where the speed drifts.
    speeds: usize,
}

impl<'a> Survey<'a> {
    fn new(lines: Vec<Vec<(&'a Shot, f64)>>, speeds: usize) -> Self {
        let pattern = |line: &Vec<(&Shot, f64)>| {
            let mut pattern = Pattern::new();
            for (shot, _) in line {
                let s = 3 * shot.station;
                pattern.push(&[0, 1][..speeds], &[s, s + 1, s + 2, LEVER, LEVER + 1, LEVER + 2]);
            }
            pattern
        };
        let patterns = lines.iter().map(pattern).collect();
        Self { lines, patterns, speeds }
    }
}

impl BorderedProblem for Survey<'_> {
    fn shared_dim(&self) -> usize {
        SHARED
    }

    /// Sound speed in the middle of the line, and its change towards the end.
    fn block_dim(&self) -> usize {
        self.speeds
    }

    fn block_count(&self) -> usize {
        self.lines.len()
    }

    fn patterns(&self) -> &[Pattern] {
        &self.patterns
    }

    fn pattern_of(&self, block: usize) -> usize {
        block
    }

    fn residuals(&self, block: usize, shared: &[f64], point: &[f64], out: &mut [f64]) {
        for ((shot, time), out) in self.lines[block].iter().zip(out) {
            *out = residual_m(shot, *time, shared, point) / SIGMA_M;
        }
    }

    fn linearise(&self, block: usize, shared: &[f64], point: &[f64], rows: BlockRows<'_>) {
        self.residuals(block, shared, point, rows.residuals);
        for (i, (shot, time)) in self.lines[block].iter().enumerate() {
            let half_s = 0.5 * shot.flight_s / SIGMA_M;
            let by_speed = &[half_s, half_s * time][..self.speeds];
            rows.by_block[self.speeds * i..][..self.speeds].copy_from_slice(by_speed);
            let (_, by_station, by_lever) = shot.path(shared);
            let by_shared = by_station.iter().chain(&by_lever).map(|d| -d / SIGMA_M);
            rows.by_shared[6 * i..][..6].iter_mut().zip(by_shared).for_each(|(out, d)| *out = d);
        }
    }
}

fn residual_m(shot: &Shot, time: f64, shared: &[f64], speed: &[f64]) -> f64 {
    0.5 * (speed[0] + speed.get(1).unwrap_or(&0.0) * time) * shot.flight_s - shot.path(shared).0
}

/// What of the model is estimated beside the stations.
struct Model {
    name: &'static str,
    lever_arm: bool,
    speed_per_line: bool,
    drift: bool,
}

const MODELS: [Model; 4] = [
    Model { name: "one speed", lever_arm: false, speed_per_line: false, drift: false },
    Model { name: "and the lever arm", lever_arm: true, speed_per_line: false, drift: false },
    Model { name: "a speed per line", lever_arm: true, speed_per_line: true, drift: false },
    Model { name: "that drifts", lever_arm: true, speed_per_line: true, drift: true },
];

/// Root mean square of half paths left out of the fit, in m: single shots spread over their lines,
/// or whole lines.
fn left_out_rms_m(
    model: &Model,
    whole_lines: bool,
    shots: &[Shot],
    start: &[f64],
) -> Result<f64, Box<dyn Error>> {
    let lines = lines_of(model, shots);
    let mut held_shared: Vec<usize> = Vec::new();
    if !model.lever_arm {
        held_shared.extend(LEVER..SHARED);
    }
    let speeds = if model.drift { 2 } else { 1 };
    let options = BorderedOptions { held_shared, ..BorderedOptions::default() };
    let by_line = whole_lines && model.speed_per_line;
    // The line of a shot counts where lines are left out, even where all share one speed.
    let numbers = line_numbers(shots);
    let is_left_out =
        |i: usize, fold: usize| (if whole_lines { numbers[i] } else { i }) % FOLDS == fold;
    let mut square = 0.0;
    for fold in 0..FOLDS {
        let kept = |line: &&Line| !by_line || !is_left_out(line.shots[0].0, fold);
        let fitted = lines.iter().filter(kept).map(|line| {
            let kept = line.shots.iter().filter(|(i, _)| !is_left_out(*i, fold));
            kept.map(|(_, shot)| (*shot, line.time(shot.sent_s))).collect()
        });
        let survey = Survey::new(fitted.collect(), speeds);
        let blocks = [SOUND_SPEED_M_PER_S, 0.0][..speeds].repeat(survey.lines.len());
        let point = BorderedPoint { shared: start.to_vec(), blocks };
        let fit = solve_bordered(&survey, point, &options)?.point;
        let middles = lines.iter().filter(kept).map(|line| line.middle_s);
        let known: Vec<(f64, &[f64])> = middles.zip(fit.blocks.chunks(speeds)).collect();
        for (own, line) in lines.iter().enumerate() {
            for (_, shot) in line.shots.iter().filter(|(i, _)| is_left_out(*i, fold)) {
                let (time, speed) = if by_line {
                    (0.0, vec![between(&known, shot.sent_s)])
                } else {
                    let (_, speed): (f64, &[f64]) = known[own];
                    (line.time(shot.sent_s), speed.to_vec())
                };
                square += residual_m(shot, time, &fit.shared, &speed).powi(2);
            }
        }
    }
    Ok((square / shots.len() as f64).sqrt())
}

/// Shots with their numbers, in the order sent.
struct Line<'a> {
    shots: Vec<(usize, &'a Shot)>,
    middle_s: f64,
    half_s: f64,
}

impl Line<'_> {
    /// From −1 at the start to 1 at the end.
    fn time(&self, sent_s: f64) -> f64 {
        (sent_s - self.middle_s) / self.half_s
    }
}

/// Survey lines in the order sailed, or all of them as one.
fn lines_of<'a>(model: &Model, shots: &'a [Shot]) -> Vec<Line<'a>> {
    let mut lines: BTreeMap<usize, Vec<(usize, &Shot)>> = BTreeMap::new();
    for ((i, shot), number) in shots.iter().enumerate().zip(line_numbers(shots)) {
        lines.entry(if model.speed_per_line { number } else { 0 }).or_default().push((i, shot));
    }
    let line = |shots: Vec<(usize, &'a Shot)>| {
        let (first, last) = (shots[0].1.sent_s, shots[shots.len() - 1].1.sent_s);
        Line { shots, middle_s: 0.5 * (first + last), half_s: (0.5 * (last - first)).max(1.0) }
    };
    lines.into_values().map(line).collect()
}

/// The line of each shot, counted in the order sailed.
fn line_numbers(shots: &[Shot]) -> Vec<usize> {
    let mut names: Vec<&str> = Vec::new();
    shots
        .iter()
        .map(|shot| {
            names.iter().position(|name| *name == shot.line).unwrap_or_else(|| {
                names.push(&shot.line);
                names.len() - 1
            })
        })
        .collect()
}

/// Speed at a time no line of which is known: on the straight line between the lines before and
/// after, or that of the nearest.
fn between(known: &[(f64, &[f64])], sent_s: f64) -> f64 {
    let after = known.partition_point(|(middle_s, _)| *middle_s < sent_s);
    match (after.checked_sub(1).map(|before| known[before]), known.get(after)) {
        (Some((t0, v0)), Some((t1, v1))) => v0[0] + (v1[0] - v0[0]) * (sent_s - t0) / (t1 - t0),
        (Some((_, v)), None) => v[0],
        (None, Some((_, v))) => v[0],
        (None, None) => SOUND_SPEED_M_PER_S,
    }
}

/// Of sea water, to start from.
const SOUND_SPEED_M_PER_S: f64 = 1490.0;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::var("TRUING_MEASURED_DATA").unwrap_or_default();
    let folder = Path::new(&folder).join("garpos_saga_multilateration");
    if !folder.is_dir() {
        println!("skipped: TRUING_MEASURED_DATA names no folder with garpos_saga_multilateration");
        return Ok(());
    }
    for campaign in ["SAGA.1903.kaiyo_k4", "SAGA.1905.meiyo_m5"] {
        let start = surveyed(&fs::read_to_string(folder.join(format!("{campaign}-initcfg.ini")))?)?;
        let shots = shots(&fs::read_to_string(folder.join(format!("{campaign}-obs.csv")))?)?;
        println!("{campaign}: {} shots", shots.len());
        let mut before = f64::INFINITY;
        for model in &MODELS {
            let rms_m = left_out_rms_m(model, false, &shots, &start)?;
            let lines_m = left_out_rms_m(model, true, &shots, &start)?;
            println!(
                "  {:<18} {:6.1} cm on shots left out, {:6.1} cm on whole lines",
                model.name,
                100.0 * rms_m,
                100.0 * lines_m
            );
            assert!(rms_m < before, "{} predicts no better", model.name);
            before = rms_m;
        }
        assert!(before < 0.1, "{before}");
    }
    Ok(())
}

/// Stations east, north, up, and the lever arm forward, to the right, down, in m.
fn surveyed(text: &str) -> Result<Vec<f64>, Box<dyn Error>> {
    let mut shared = Vec::with_capacity(SHARED);
    for key in STATIONS.map(|name| format!("{name}_dPos")).iter().chain([&"ATDoffset".to_owned()]) {
        let line = text.lines().find(|line| line.trim_start().starts_with(key.as_str()));
        let values = line.and_then(|line| line.split_once('=')).ok_or(format!("no {key}"))?.1;
        for value in values.split_whitespace().take(3) {
            shared.push(value.parse()?);
        }
    }
    Ok(shared)
}

fn shots(text: &str) -> Result<Vec<Shot>, Box<dyn Error>> {
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<&str> = lines.next().ok_or("no header")?.split(',').collect();
    let column = |name: &str| names.iter().position(|n| *n == name).ok_or(format!("no {name}"));
    let end = |k: usize| -> Result<[usize; 6], String> {
        let names = ["ant_e", "ant_n", "ant_u", "head", "pitch", "roll"];
        let mut columns = [0; 6];
        for (found, name) in columns.iter_mut().zip(names) {
            *found = column(&format!("{name}{k}"))?;
        }
        Ok(columns)
    };
    let (sent, received) = (end(0)?, end(1)?);
    let (set, line, station) = (column("SET")?, column("LN")?, column("MT")?);
    let (flight, time, flag) = (column("TT")?, column("ST")?, column("flag")?);
    let mut found = Vec::new();
    for row in lines {
        let cells: Vec<&str> = row.split(',').collect();
        if cells[flag] != "False" {
            continue;
        }
        let place = |columns: &[usize; 6]| -> Result<_, Box<dyn Error>> {
            let mut values = [0.0; 6];
            for (value, column) in values.iter_mut().zip(columns) {
                *value = cells[*column].parse()?;
            }
            let [e, n, u, heading, pitch, roll] = values;
            Ok((Vector3::new(e, n, u), enu_from_ship(heading, pitch, roll)))
        };
        found.push(Shot {
            station: STATIONS.iter().position(|s| *s == cells[station]).ok_or("a new station")?,
            line: format!("{} {}", cells[set], cells[line]),
            flight_s: cells[flight].parse()?,
            sent_s: cells[time].parse()?,
            ends: [place(&sent)?, place(&received)?],
        });
    }
    Ok(found)
}

/// Rotation from forward, right, down to east, north, up; angles in degrees.
fn enu_from_ship(heading: f64, pitch: f64, roll: f64) -> Matrix3<f64> {
    let [heading, pitch, roll] = [heading, pitch, roll].map(f64::to_radians);
    let ned_from_ship = Rotation3::from_euler_angles(roll, pitch, heading);
    let enu_from_ned = Matrix3::new(0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0);
    enu_from_ned * ned_from_ship.matrix()
}
