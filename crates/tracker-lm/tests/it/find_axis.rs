//! An axis of which nothing but the letter is declared.

use nalgebra::{Point3, Unit, Vector3, Vector4};
use tracker_lm::{
    AxisLetter, AxisModel, Noise, Options, RotaryAxis, Sought, Survey, TrackerError, calibrate,
    find_axis,
};

use crate::scene::{Plan, Scene, simulate};

const NOISE_MM: f64 = 5e-4;
const STATION_MM: f64 = 4e-3;

fn options() -> Options {
    let noise =
        Noise { displacement_mm: Some(NOISE_MM), station_mm: Some(STATION_MM), ..Noise::default() };
    Options { noise, ..Options::default() }
}

fn perfect(letter: AxisLetter) -> Plan {
    Plan { letter, error_mm: 0.0, error_rad: 0.0, angles: 19, ..Plan::default() }
}

fn unit(letter: AxisLetter) -> Vector3<f64> {
    match letter {
        AxisLetter::A => Vector3::x(),
        AxisLetter::B => Vector3::y(),
        AxisLetter::C => Vector3::z(),
    }
}

/// The survey of a drawing without its axis.
fn undeclared(scene: &Scene) -> Survey {
    let letter = scene.survey.axis.letter;
    let axis = RotaryAxis::new(letter, Point3::origin(), unit(letter)).unwrap();
    Survey { axis, ..scene.survey.clone() }
}

/// How far the true axis is from the one found, as errors of location.
fn off(found: &RotaryAxis, truth: &RotaryAxis) -> Vector4<f64> {
    let along = found.direction.into_inner();
    let apart = truth.origin_mm - found.origin_mm;
    let across = apart - along * apart.dot(&along);
    let turned = along.cross(&truth.direction);
    let [first, second] = match found.letter {
        AxisLetter::A => [1, 2],
        AxisLetter::B => [0, 2],
        AxisLetter::C => [0, 1],
    };
    Vector4::new(across[first], across[second], turned[first], turned[second])
}

/// Surveys per letter; the mean of 24 values of χ² with four degrees of freedom lies within 4 ± 1.9
/// but once in a thousand (standard deviation √(8/24), 3.3 of it).
const SEEDS: u64 = 8;
const MEAN_CHI2: std::ops::Range<f64> = 2.1..5.9;

#[test]
fn the_axis_is_found_within_the_uncertainty_of_its_location() {
    let mut sum = 0.0;
    for letter in [AxisLetter::A, AxisLetter::B, AxisLetter::C] {
        for seed in 0..SEEDS {
            let scene = simulate(&perfect(letter), 700 + seed);
            let mut survey = undeclared(&scene);
            let located = Options { axis: AxisModel::Located, ..options() };
            survey.axis = find_axis(&survey, Sought::OriginAndDirection, &located).unwrap();
            let location = calibrate(&survey, &located).unwrap().location.unwrap();
            // It stays where it is.
            assert!(location.errors.amax() < 1e-6, "{}", location.errors);
            let off = off(&survey.axis, &scene.survey.axis);
            sum += off.dot(&(location.covariance.cholesky().unwrap().inverse() * off));
        }
    }
    let mean = sum / (3 * SEEDS) as f64;
    assert!(MEAN_CHI2.contains(&mean), "{mean}");
}

#[test]
fn a_declared_direction_is_kept() {
    let scene = simulate(&perfect(AxisLetter::C), 731);
    let mut survey = undeclared(&scene);
    survey.axis.direction = scene.survey.axis.direction;
    let found = find_axis(&survey, Sought::Origin, &options()).unwrap();
    assert_eq!(found.direction, scene.survey.axis.direction);
    survey.axis = found;
    let located = Options { axis: AxisModel::Located, ..options() };
    let location = calibrate(&survey, &located).unwrap().location.unwrap();
    let off = off(&found, &scene.survey.axis);
    // Five standard uncertainties of a place across the axis.
    assert!((0..2).all(|c| off[c].abs() < 5.0 * location.covariance[(c, c)].sqrt()), "{off}");
}

#[test]
fn errors_of_the_axis_are_against_the_line_found() {
    let plan = Plan { angles: 19, ..Plan::default() };
    let scene = simulate(&plan, 733);
    let mut survey = undeclared(&scene);
    survey.axis = find_axis(&survey, Sought::OriginAndDirection, &options()).unwrap();
    let free = calibrate(&survey, &options()).unwrap();
    let location = free.location.unwrap();
    assert!(location.errors.amax() < 1e-6, "{}", location.errors);
    // The line is the true axis as far as its errors, and what they make of a location, are small.
    let off = off(&survey.axis, &scene.survey.axis);
    assert!(off.rows(0, 2).amax() < 10.0 * plan.error_mm, "{off}");
    assert!(off.rows(2, 2).amax() < 10.0 * plan.error_rad, "{off}");
    // Reflectors are known to 0.3 mm: the mean height of four is to half of that.
    let along = (survey.axis.origin_mm - scene.survey.axis.origin_mm).dot(&survey.axis.direction);
    assert!(along.abs() < 4.0 * 0.5 * plan.mounts_off_mm, "{along}");
}

#[test]
fn an_axis_that_stood_still_is_not_found() {
    let plan = Plan { half_arc_deg: 1e-3, ..perfect(AxisLetter::B) };
    let survey = undeclared(&simulate(&plan, 734));
    let error = find_axis(&survey, Sought::OriginAndDirection, &options()).unwrap_err();
    let expected = matches!(
        error,
        TrackerError::AxisNotFound
            | TrackerError::Unobservable { .. }
            | TrackerError::NotConverged { .. }
    );
    assert!(expected, "{error}");
}

#[test]
fn a_direction_up_to_a_tenth_of_a_turn_off_is_mended() {
    let scene = simulate(&perfect(AxisLetter::B), 735);
    let mut survey = undeclared(&scene);
    survey.axis.direction = Unit::new_normalize(Vector3::new(0.2, 1.0, -0.2));
    let found = find_axis(&survey, Sought::OriginAndDirection, &options()).unwrap();
    assert!(off(&found, &scene.survey.axis).rows(2, 2).amax() < 1e-4);
}
