//! Touches as a user programs them, and what the machine answered.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};

/// Clear of everything on the table.
pub(super) const SAFE_Z_MM: f64 = 20.0;
/// Feeds between touches, as the `[plan]` of the cases declares them.
pub(super) const TRAVEL_MM_PER_MIN: f64 = 12_000.0;

/// One touch of a program.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touch {
    /// Where the centre of the drawn ball is at the contact with the drawn part.
    pub(super) ball_mm: [f64; 3],
    /// Unit vector along which the machine moves.
    pub(super) way: [f64; 3],
    pub(super) feed_mm_per_min: f64,
}

impl Touch {
    pub(super) fn along_the_normal(
        contact_mm: [f64; 3],
        normal: [f64; 3],
        radius_mm: f64,
        feed: f64,
    ) -> Self {
        Self {
            ball_mm: at(contact_mm, normal, radius_mm),
            way: normal.map(|v| -v),
            feed_mm_per_min: feed,
        }
    }
}

/// A point a way farther along.
pub(super) fn at(from: [f64; 3], along: [f64; 3], way: f64) -> [f64; 3] {
    std::array::from_fn(|k| from[k] + way * along[k])
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

pub(super) fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = dot(v, v).sqrt();
    v.map(|c| c / length)
}

fn words([x, y, z]: [f64; 3]) -> String {
    format!("X{x:.5} Y{y:.5} Z{z:.5}")
}

/// The touches one after another, each from `reach_mm` before the drawn contact to as far beyond it.
pub(super) fn program(touches: &[Touch], reach_mm: f64, log: &str) -> String {
    let mut text = format!("G21 G90 G94 G17 G40 G49 G64 P0.001\n(PROBEOPEN {log})\n");
    for touch in touches {
        let start = at(touch.ball_mm, touch.way, -reach_mm);
        let [x, y, _] = start;
        let _ = writeln!(text, "G0 X{x:.5} Y{y:.5} Z{SAFE_Z_MM:.1}");
        let _ = writeln!(text, "G1 {} F{TRAVEL_MM_PER_MIN}", words(start));
        let end = at(touch.ball_mm, touch.way, reach_mm);
        let _ = writeln!(text, "G38.2 {} F{}", words(end), touch.feed_mm_per_min);
        let _ = writeln!(text, "G1 {} F{TRAVEL_MM_PER_MIN}", words(start));
        let _ = writeln!(text, "G0 X{x:.5} Y{y:.5} Z{SAFE_Z_MM:.1}");
    }
    text.push_str("(PROBECLOSE)\nM2\n");
    text
}

/// Middle and way of every touch that a program makes, corrected or not: between the place from which
/// it starts and the one to which it would go.
pub(super) fn expected(program: &str) -> Result<Vec<([f64; 3], [f64; 3])>> {
    let mut touches = Vec::new();
    let mut last = None;
    for line in program.lines() {
        let mut place = [f64::NAN; 3];
        for word in line.split_whitespace() {
            if let Some(axis) = word.chars().next().and_then(|letter| "XYZ".find(letter)) {
                place[axis] = word[1..].parse().with_context(|| line.to_owned())?;
            }
        }
        if place.iter().any(|v| v.is_nan()) {
            continue;
        }
        if line.starts_with("G38") {
            let start: [f64; 3] = last.context("a touch from nowhere")?;
            let middle = std::array::from_fn(|k| 0.5 * (start[k] + place[k]));
            touches.push((middle, unit(std::array::from_fn(|k| place[k] - start[k]))));
        }
        last = Some(place);
    }
    Ok(touches)
}

/// Where the ball was at each trigger.
pub(super) fn logged(log: &Path) -> Result<Vec<[f64; 3]>> {
    let text = fs::read_to_string(log).with_context(|| log.display().to_string())?;
    let triggers = text.lines().map(|line| {
        let numbers: Vec<f64> =
            line.split_whitespace().map(str::parse).collect::<Result<_, _>>()?;
        ensure!(numbers.len() == 9, "{line}");
        Ok([numbers[0], numbers[1], numbers[2]])
    });
    triggers.collect()
}

/// How far each trigger is from where the program expects it, against its way, mm: positive where the
/// machine stopped before.
pub(super) fn errors_mm(program: &str, log: &Path) -> Result<Vec<f64>> {
    let (expected, logged) = (expected(program)?, logged(log)?);
    ensure!(
        expected.len() == logged.len(),
        "{} touches, {} triggers",
        expected.len(),
        logged.len()
    );
    let pairs = expected.iter().zip(&logged);
    Ok(pairs
        .map(|((middle, way), at)| -dot(std::array::from_fn(|k| at[k] - middle[k]), *way))
        .collect())
}

/// Root mean square and largest magnitude.
pub(super) fn spread(errors: &[f64]) -> [f64; 2] {
    #[expect(clippy::cast_precision_loss, reason = "some tens of touches")]
    let mean_square = errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64;
    [mean_square.sqrt(), errors.iter().fold(0.0, |most, e| e.abs().max(most))]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_expects_what_it_was_made_for() {
        let touch = Touch::along_the_normal([1.0, -2.0, 3.0], [0.6, 0.0, 0.8], 3.0, 120.0);
        let expected = expected(&program(&[touch], 0.5, "a.log")).unwrap();
        let [(middle, way)] = expected[..] else { panic!("{expected:?}") };
        for k in 0..3 {
            // Coordinates are written to 10 nm.
            assert!((middle[k] - touch.ball_mm[k]).abs() < 1e-5);
            assert!((way[k] - touch.way[k]).abs() < 1e-4);
        }
    }

    #[test]
    fn an_early_trigger_is_a_positive_error() {
        let touch = Touch::along_the_normal([0.0; 3], [0.0, 0.0, 1.0], 3.0, 120.0);
        let folder = std::env::temp_dir().join("xtask-linuxcnc-early");
        fs::create_dir_all(&folder).unwrap();
        let log = folder.join("a.log");
        fs::write(&log, "0 0 3.25 0 0 0 0 0 0\n").unwrap();
        assert_eq!(errors_mm(&program(&[touch], 0.5, "a.log"), &log).unwrap(), [0.25]);
        assert_eq!(spread(&[3.0, -4.0])[1].to_bits(), 4.0_f64.to_bits());
    }
}
