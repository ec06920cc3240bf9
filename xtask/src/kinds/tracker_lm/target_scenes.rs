//! Small surveys of points in which every effect on points is accepted at least once.

use crate::generators::vector::{add, rotate, scale};
use crate::kinds::tracker_lm::targets::{Fault, Measured, Reading, Survey, simulate, tables};

/// Beginnings of ids with subjects. The scale of all trackers is that of the reflectors, which
/// are free: no survey of points shows it.
pub(crate) const EFFECTS: &[&str] = &[
    "backlash",
    "body-sag [frame, sine",
    "body-tilt [frame, cosine",
    "station-drift [S2",
    "station-shift [S",
    "session-shift [from",
    "bad-station [S",
    "temperature [air_c",
    "mount-slip [R3 at 7 from S1",
    "bad-point [R2 at 5 from S1",
];

type Files = Vec<(&'static str, String)>;

/// Cases by name.
pub(crate) fn scenes() -> Vec<(&'static str, Files)> {
    let survey = |seed: u64, fault: Fault| Survey { n_angles: 13, fault, ..Survey::new(seed) };
    let backlash = Fault::Backlash(60e-6, [0.0, 0.020, 0.0]);
    let stand = Fault::Stand(1, [0.060, -0.040, 0.090], [15e-6, 20e-6, -10e-6]);
    vec![
        ("points-backlash", plain(&Survey { both_ways: true, ..survey(721, backlash) })),
        ("points-sag", plain(&Survey { n_mounts: 8, ..survey(722, Fault::Flexure(0.080)) })),
        ("points-stand", plain(&survey(723, stand))),
        (
            "points-knocked",
            plain(&survey(729, Fault::Knocked(1, 5, [0.06, -0.05, 0.08], [20e-6, 30e-6, -10e-6]))),
        ),
        (
            "points-moved",
            plain(&Survey {
                both_ways: true,
                ..survey(730, Fault::Moved(8, [0.06, -0.05, 0.08], [60e-6, 40e-6, -50e-6]))
            }),
        ),
        // Millimetres, as a stand that was knocked: rows are far from linear about its start.
        ("points-bad-point", edited(724, |_, r| is_bad(r).then_some([3.0, -2.0, 1.0]))),
        ("points-slip", edited(725, |measured, r| slipped(measured, r, [2.0, 1.0, -2.0]))),
        ("points-tilt", edited(726, tilted)),
        ("points-station", edited(727, |_, r| (r.station == 1).then(|| scale(90e-6, r.at_mm)))),
        ("points-air", with_air(728)),
    ]
}

fn plain(survey: &Survey) -> Files {
    tables(survey, &simulate(survey))
}

/// A sound survey in which readings are moved, in the frame of their tracker.
fn edited(seed: u64, moved: impl Fn(&Measured, &Reading) -> Option<[f64; 3]>) -> Files {
    let survey = Survey::new(seed);
    let mut measured = simulate(&survey);
    let all: Vec<_> = measured.readings.iter().map(|r| moved(&measured, r)).collect();
    for (reading, moved) in measured.readings.iter_mut().zip(all) {
        reading.at_mm = add(reading.at_mm, moved.unwrap_or_default());
    }
    tables(&survey, &measured)
}

fn is_bad(reading: &Reading) -> bool {
    (reading.step, reading.mount, reading.station) == (4, 1, 0)
}

/// What a displacement in the turning frame is in that of the tracker.
fn seen(measured: &Measured, reading: &Reading, body_mm: [f64; 3]) -> [f64; 3] {
    let pose = &measured.stations[reading.station];
    let angle = measured.steps[reading.step].0.to_radians();
    rotate(pose.axis, -pose.turn_rad, rotate(measured.direction, angle, body_mm))
}

fn slipped(measured: &Measured, reading: &Reading, by_mm: [f64; 3]) -> Option<[f64; 3]> {
    (reading.mount == 2 && reading.step >= 6).then(|| seen(measured, reading, by_mm))
}

/// The second body turns about x by 120 µrad times the cosine of the angle.
fn tilted(measured: &Measured, reading: &Reading) -> Option<[f64; 3]> {
    let angle = measured.steps[reading.step].0.to_radians();
    let body = measured.mounts_mm[reading.mount].0;
    let turned = rotate([1.0, 0.0, 0.0], 120e-6 * angle.cos(), body);
    (reading.mount % 2 == 1).then(|| seen(measured, reading, add(turned, scale(-1.0, body))))
}

/// Air that swings by 3 K while distances follow it by −9 ppm/K.
fn with_air(seed: u64) -> Files {
    let survey = Survey::new(seed);
    let mut measured = simulate(&survey);
    let air = |row: usize| (20.0 + 3.0 * (0.11 * crate::handback::as_f64(row)).sin()) * 1e3;
    let air = |row: usize| air(row).round() / 1e3;
    for (row, reading) in measured.readings.iter_mut().enumerate() {
        reading.at_mm = scale(1.0 - 9e-6 * (air(row) - 20.0), reading.at_mm);
    }
    let mut files = tables(&survey, &measured);
    let (_, text) = files.last_mut().expect("the readings come last");
    let add_air = |(line, own): (usize, &str)| match line {
        0 => format!("{own},air_c\n"),
        line => format!("{own},{}\n", air(line - 1)),
    };
    *text = text.lines().enumerate().map(add_air).collect();
    files
}
