//! What the model of a survey offers the loop, and by which names.

use std::collections::HashSet;

use model_discrepancy::{Effect, Model};
use tracker_lm::{AxisModel, Noise, Options, Survey, TrackerModel};

use crate::scene::{Plan, simulate};

/// Seven angles, of which the fourth is amid the run.
fn seven() -> Plan {
    Plan { angles: 7, ..Plan::default() }
}

fn model(survey: Survey, axis: AxisModel) -> TrackerModel {
    let noise = Noise { displacement_mm: Some(5e-4), station_mm: Some(4e-3), ..Noise::default() };
    TrackerModel::new(survey, None, Vec::new(), &Options { axis, noise, ..Options::default() })
        .unwrap()
}

fn subjects(model: &TrackerModel, id: &str) -> HashSet<String> {
    let effects = model.declared().effects.iter().filter(|effect| effect.id == id);
    effects.filter_map(|effect| effect.subject.clone()).collect()
}

fn effect<'m>(model: &'m TrackerModel, id: &str, subject: Option<&str>) -> &'m Effect {
    let is_it = |effect: &&Effect| effect.id == id && effect.subject.as_deref() == subject;
    model.declared().effects.iter().find(is_it).unwrap()
}

/// Whatever the residual shows: a lock or a station that lost its beam, a reflector that slipped.
#[test]
fn each_lock_and_station_and_reflector_may_change_amid_the_run() {
    let model = model(simulate(&seven(), 41).survey, AxisModel::Free);
    let (jumps, slips) = (subjects(&model, "dead-path-jump"), subjects(&model, "mount-slip"));
    for station in 1..=6 {
        assert!(jumps.contains(&format!("S{station} at 4")), "S{station}: {jumps:?}");
        for mount in 1..=4 {
            let lock = format!("S{station}-R{mount} at 4");
            assert!(jumps.contains(&lock), "{lock}: {jumps:?}");
        }
    }
    for mount in 1..=4 {
        let slip = format!("R{mount} at 4 from S1");
        assert!(slips.contains(&slip), "{slip}: {slips:?}");
    }
}

/// A tracer that loses its count amid the run, in one lock by more than in the others: both its station
/// and that lock show a jump where either is offered already.
#[test]
fn nothing_is_offered_twice() {
    let mut survey = simulate(&seven(), 42).survey;
    for range in survey.ranges.iter_mut().filter(|range| range.station == 2 && range.step >= 3) {
        range.displacement_mm += if range.mount == 0 { 0.09 } else { 0.03 };
    }
    let model = model(survey, AxisModel::Free);
    let mut known = HashSet::new();
    for effect in &model.declared().effects {
        let name = (&effect.id, &effect.subject);
        assert!(known.insert(name), "{name:?}");
    }
}

#[test]
fn a_backlash_is_of_the_six_errors_in_their_units() {
    let plan = Plan { both_ways: true, ..seven() };
    let model = model(simulate(&plan, 43).survey, AxisModel::Free);
    let parameters = &effect(&model, "backlash", None).parameters;
    let found: Vec<_> =
        parameters.iter().map(|p| (p.name.as_str(), p.unit.as_str(), p.report_factor)).collect();
    let displacements = ["EXB", "EYB", "EZB"].map(|name| (name, "µm", 1e3));
    let rotations = ["EAB", "EBB", "ECB"].map(|name| (name, "µrad", 1e6));
    assert_eq!(found, [displacements, rotations].concat());
}

#[test]
fn values_by_angle_are_named_for_their_angles() {
    let plan = Plan {
        angles: 5,
        both_ways: true,
        once_more: true,
        error_mm: 0.0,
        error_rad: 0.0,
        ..Plan::default()
    };
    let model = model(simulate(&plan, 44).survey, AxisModel::Fixed);
    let values = effect(&model, "angular-positioning", Some("EBB angle by angle"));
    let names: Vec<&str> = values.parameters.iter().map(|p| p.name.as_str()).collect();
    // Each relative to the first, at −90°.
    assert_eq!(names, ["EBB at -45°", "EBB at 0°", "EBB at 45°", "EBB at 90°"]);
}

#[test]
fn unknowns_are_named_for_what_they_are_of() {
    let model = model(simulate(&seven(), 45).survey, AxisModel::Located);
    let base = &model.declared().base;
    let names: Vec<&str> = base.iter().map(|p| p.name.as_str()).collect();
    let coordinates = |what: &'static str, n: usize| {
        (1..=n).flat_map(move |i| ["x", "y", "z"].map(|axis| format!("{axis} of {what}{i}")))
    };
    let paths = (1..=6).flat_map(|i| (1..=4).map(move |j| format!("dead path from S{i} to R{j}")));
    let expected: Vec<String> =
        coordinates("station S", 6).chain(paths).chain(coordinates("mount R", 4)).collect();
    assert_eq!(names[..expected.len()], expected);
    assert_eq!(names[expected.len()..], ["EX0B", "EZ0B", "EA0B (rad)", "EC0B (rad)"]);
}

/// A stand that moved steadily as long as it was measured: ranges that are planned, of which nobody knows
/// it, do not make it one that comes to rest.
#[test]
fn a_stand_goes_on_through_what_is_planned() {
    const INTERVAL_S: f64 = 5.0;
    let mut survey = simulate(&Plan { angles: 9, both_ways: true, ..Plan::default() }, 43).survey;
    let n_measured = survey.ranges.iter().filter(|range| range.step < 9).count();
    assert!(survey.ranges[..n_measured].iter().all(|range| range.step < 9));
    for (n, range) in survey.ranges[..n_measured].iter_mut().enumerate() {
        if range.station == 2 {
            range.displacement_mm += 0.03 * n as f64 / n_measured as f64;
        }
    }
    let time_s: Vec<f64> = (0..survey.ranges.len()).map(|n| INTERVAL_S * n as f64).collect();
    let noise = Noise { displacement_mm: Some(5e-4), station_mm: Some(4e-3), ..Noise::default() };
    let options = Options { noise, ..Options::default() };
    let (whole, times) = (survey.clone(), time_s.clone());
    let as_if_read = TrackerModel::new(whole, Some(times), Vec::new(), &options).unwrap();
    let planned =
        TrackerModel::with_planned(survey, Some(time_s), Vec::new(), &options, n_measured).unwrap();
    let unit = |model: &TrackerModel| {
        effect(model, "station-drift", Some("S3")).parameters[0].unit.clone()
    };
    assert_eq!([unit(&as_if_read), unit(&planned)], ["mm", "mm/h"]);
}
