//! Bad input: one clear error each.

use nalgebra::{Point3, Vector3};
use tracker_lm::{
    AxisLetter, Formulation, Gauge, Noise, Options, Range, Record, RotaryAxis, Shortage, Survey,
    TrackerError, calibrate,
};

use crate::scene::{Plan, simulate};

fn survey() -> Survey {
    simulate(&Plan { angles: 9, ..Plan::default() }, 7).survey
}

fn options() -> Options {
    let noise = Noise { displacement_mm: Some(5e-4), ..Noise::default() };
    Options { noise, ..Options::default() }
}

fn refused(survey: &Survey) -> TrackerError {
    calibrate(survey, &options()).unwrap_err()
}

/// A survey without the stations or mounts from `most` on.
fn cut(mut survey: Survey, stations: usize, mounts: usize) -> Survey {
    survey.stations.truncate(stations);
    survey.mounts.truncate(mounts);
    survey.ranges.retain(|r| r.station < stations && r.mount < mounts);
    survey
}

#[test]
fn three_stations() {
    let error = refused(&cut(survey(), 3, 4));
    assert_eq!(error, TrackerError::TooFewStations { needed: 4, got: 3 });
    assert!(error.to_string().contains("3 stations"));
}

#[test]
fn two_reflectors() {
    let error = refused(&cut(survey(), 6, 2));
    assert_eq!(error, TrackerError::TooFewMounts { needed: 3, got: 2 });
}

#[test]
fn collinear_reflectors() {
    let mut survey = survey();
    let (start, way) = (Vector3::new(10.0, -60.0, 150.0), Vector3::new(0.2, 1.0, -0.1));
    for (n, mount) in survey.mounts.iter_mut().enumerate() {
        mount.nominal_mm = Point3::from(start + way * (40.0 * n as f64));
    }
    let error = refused(&survey);
    let TrackerError::CollinearMounts { line, .. } = error else { panic!("{error}") };
    assert!(Vector3::from(line).cross(&way.normalize()).norm() < 1e-6);
}

#[test]
fn a_target_point_seen_twice() {
    let mut survey = survey();
    let again = Range { displacement_mm: 1.0, ..survey.ranges[17] };
    survey.ranges.push(again);
    let TrackerError::DuplicateRange { station, mount, step, .. } = refused(&survey) else {
        panic!("the same reading twice is not an error")
    };
    assert_eq!(station, survey.stations[again.station].name);
    assert_eq!(mount, survey.mounts[again.mount].name);
    assert_eq!(step, survey.steps[again.step].name);
}

#[test]
fn a_station_that_does_not_exist() {
    let mut survey = survey();
    survey.ranges[3].station = 6;
    let expected =
        TrackerError::UnknownIndex { range: 3, what: Record::Station, index: 6, count: 6 };
    assert_eq!(refused(&survey), expected);
}

#[test]
fn a_station_without_ranges() {
    let mut survey = survey();
    survey.ranges.retain(|r| r.station != 4);
    let expected = TrackerError::Unseen { what: Record::Station, name: "S5".to_owned() };
    assert_eq!(refused(&survey), expected);
}

#[test]
fn counts_say_what_is_short() {
    // 4 stations, 3 mounts, 3 angles: 36 ranges against 12 − 6 + 12 + 9 + 12 unknowns.
    let survey = simulate(&Plan { stations: 4, mounts: 3, angles: 3, ..Plan::default() }, 3).survey;
    let TrackerError::TooFewRanges { equations, unknowns, shortage, needed, got } =
        refused(&survey)
    else {
        panic!("36 ranges cannot determine 39 unknowns")
    };
    assert_eq!((equations, unknowns, shortage, got), (36, 39, Shortage::Angles, 3));
    // One more angle brings 12 ranges and 6 unknowns.
    assert_eq!(needed, 4);
    let more = simulate(&Plan { stations: 4, mounts: 3, angles: 4, ..Plan::default() }, 3).survey;
    let enough = calibrate(&more, &options());
    assert!(!matches!(enough, Err(TrackerError::TooFewRanges { .. })), "{enough:?}");
}

/// Places that are data are as many equations as unknowns.
#[test]
fn known_stations_bring_as_much_as_they_need() {
    let survey = simulate(&Plan { stations: 4, mounts: 3, angles: 2, ..Plan::default() }, 3).survey;
    let noise = Noise { station_mm: Some(4e-3), ..options().noise };
    let TrackerError::TooFewRanges { equations, unknowns, .. } =
        calibrate(&survey, &Options { noise, ..options() }).unwrap_err()
    else {
        panic!("24 ranges and 12 coordinates cannot determine 39 unknowns")
    };
    // Stations, dead paths, reflectors and one angle.
    assert_eq!((equations, unknowns), (24 + 12, 12 + 12 + 9 + 6));
}

#[test]
fn one_angle_that_shows_nothing() {
    let mut survey = survey();
    survey.ranges.retain(|r| r.step != 4 || r.mount < 2);
    let error = refused(&survey);
    assert!(
        matches!(error, TrackerError::UndeterminedAngle { .. } | TrackerError::Unobservable { .. }),
        "{error}"
    );
    assert!(error.to_string().contains("free"), "{error}");
}

#[test]
fn stations_in_a_line_do_not_orient_the_result() {
    let mut survey = survey();
    for (n, station) in survey.stations.iter_mut().enumerate() {
        station.nominal_mm = Point3::new(100.0 * n as f64, 0.0, 0.0);
    }
    for gauge in [Gauge::Inner, Gauge::Minimal] {
        let error = calibrate(&survey, &Options { gauge, ..options() }).unwrap_err();
        assert_eq!(error, TrackerError::CollinearStations);
    }
}

#[test]
fn numbers_that_are_none() {
    let mut nan = survey();
    nan.ranges[5].displacement_mm = f64::NAN;
    assert!(matches!(
        refused(&nan),
        TrackerError::InvalidNumber { what: Record::Range, index: 5, .. }
    ));
    let mut far = survey();
    far.stations[2].nominal_mm.x = 1e12;
    assert!(matches!(
        refused(&far),
        TrackerError::InvalidNumber { what: Record::Station, index: 2, .. }
    ));
    let noise = Noise { station_mm: Some(0.0), ..Noise::default() };
    let error = calibrate(&survey(), &Options { noise, ..options() }).unwrap_err();
    assert!(matches!(error, TrackerError::InvalidNoise { which: "station_mm", .. }));
    let axis = RotaryAxis::new(AxisLetter::C, Point3::origin(), Vector3::zeros());
    assert!(matches!(axis, Err(TrackerError::InvalidAxis { .. })));
}

#[test]
fn displacements_of_another_survey_do_not_pass_for_a_fit() {
    let mut survey = survey();
    survey.ranges.iter_mut().for_each(|r| r.displacement_mm *= -1.0);
    for formulation in [Formulation::Joint, Formulation::FreePoints] {
        match calibrate(&survey, &Options { formulation, ..options() }) {
            Err(_) => {}
            Ok(found) => assert!(found.variance_factor > 1e6, "{}", found.variance_factor),
        }
    }
}
