//! The presses as a model: tangents, and what the loop makes of one load and of two.

use ft_center::{
    LocateOptions, Noise, OrbitOptions, Press, PressModel, PressRole, SolvedPress, solve_presses,
};
use geometry::Wrench;
use model_discrepancy::{Closure, Model, Options, Step, Verdict, close_loop};
use nalgebra::{Point2, Vector2, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::jacobian::assert_tangents;
use crate::simulator::{CONTACT, Colour, Head, Placement, press, record};

const PLACEMENT: Placement =
    Placement { angle_rad: 0.4, mirrored: false, shift_mm: Vector2::new(-210.0, 95.0) };

/// Presses on a 3 × 3 grid of 40 mm pitch, the loads in turn; `fault` spoils each reading.
pub(crate) fn grid(
    loads_n: &[f64],
    lateral_n: f64,
    colour: &Colour,
    seed: u64,
    fault: impl Fn(usize, &mut Wrench),
) -> Vec<Press> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut presses = Vec::new();
    for (round, load_n) in loads_n.iter().enumerate() {
        for i in 0..9 {
            let machine =
                Point2::new(500.0 + 40.0 * f64::from(i % 3), 80.0 + 40.0 * f64::from(i / 3));
            let k = 9 * round + i as usize;
            let turn = 1.3 * k as f64;
            let head = Head {
                load_n: *load_n,
                lateral_n: lateral_n * Vector2::new(turn.cos(), turn.sin()),
                ..Head::default()
            };
            let center = PLACEMENT.to_sensor(machine);
            let mut record = record(center, &head, colour, 150, 10.0, &mut rng);
            for sample in &mut record {
                fault(k, &mut sample.wrench);
            }
            presses.push(press(&format!("p{k}"), PressRole::Frame, machine, record));
        }
    }
    presses
}

fn solved(presses: &[Press]) -> Vec<SolvedPress> {
    solve_presses(presses, &CONTACT, &OrbitOptions::default()).unwrap()
}

pub(crate) fn model(presses: &[Press]) -> PressModel {
    PressModel::new(&solved(presses), &CONTACT, &LocateOptions::default(), &[]).unwrap()
}

fn closed(presses: &[Press]) -> Closure {
    let model = model(presses);
    close_loop(&model, &model.covariates(), &Options::default()).unwrap()
}

/// Names of one step: the effect and what the data accept in its place.
fn names(step: &Step) -> Vec<&str> {
    let rivals = step.indistinguishable_from.iter().map(String::as_str);
    std::iter::once(step.effect.as_str()).chain(rivals).collect()
}

#[test]
fn adds_nothing_where_nothing_is_wrong() {
    let closure = closed(&grid(&[40.0, 80.0], 3.0, &Colour::COLOURED, 5, |_, _| {}));
    assert!(closure.steps.is_empty(), "{:?}", closure.steps);
}

#[test]
fn one_load_cannot_tell_a_moment_bias_from_the_frame() {
    let bias = |_, w: &mut Wrench| w.torque_nmm += Vector3::new(30.0, -50.0, 0.0);
    let closure = closed(&grid(&[40.0], 3.0, &Colour::COLOURED, 5, bias));
    let hidden = closure.not_observable.iter().find(|n| n.effect == "sensor-bias [moment]");
    let hidden = hidden.expect("one load hides a moment bias");
    assert!(hidden.aliased_with.iter().any(|a| a.contains("translation")), "{hidden:?}");
    assert_eq!(hidden.separate_by.as_deref(), Some("press at a second load"));
    assert!(closure.steps.iter().all(|s| !names(s).contains(&"sensor-bias")));
}

#[test]
fn two_loads_find_the_moment_bias() {
    let bias = |_, w: &mut Wrench| w.torque_nmm += Vector3::new(30.0, -50.0, 0.0);
    let closure = closed(&grid(&[40.0, 80.0], 3.0, &Colour::COLOURED, 5, bias));
    assert_eq!(closure.steps.len(), 1, "{:?}", closure.steps);
    assert!(names(&closure.steps[0]).contains(&"sensor-bias"), "{:?}", closure.steps);
}

#[test]
fn one_load_cannot_tell_a_force_bias_from_a_gain() {
    let bias = |_, w: &mut Wrench| w.force_n.z += 1.0;
    let closure = closed(&grid(&[40.0], 3.0, &Colour::COLOURED, 5, bias));
    assert_eq!(closure.steps.len(), 1, "{:?}", closure.steps);
    let class = names(&closure.steps[0]);
    assert!(class.contains(&"force-gain") && class.contains(&"sensor-bias"), "{class:?}");
    assert!(closure.steps[0].separate_by.is_some());
}

#[test]
fn two_loads_tell_a_force_bias_from_a_gain() {
    let bias = |_, w: &mut Wrench| w.force_n.z += 1.0;
    let closure = closed(&grid(&[40.0, 80.0], 3.0, &Colour::COLOURED, 5, bias));
    let class = names(&closure.steps[0]);
    assert!(class.contains(&"sensor-bias") && !class.contains(&"force-gain"), "{class:?}");
}

#[test]
fn a_height_error_shows_in_lateral_forces() {
    let low = |_, w: &mut Wrench| {
        let f = w.force_n;
        w.torque_nmm += Vector3::new(0.0, 0.0, 2.0).cross(&f);
    };
    let closure = closed(&grid(&[40.0, 80.0], 12.0, &Colour::COLOURED, 5, low));
    assert!(names(&closure.steps[0]).contains(&"contact-height"), "{:?}", closure.steps);
}

#[test]
fn a_load_cell_that_is_not_linear_is_no_gain() {
    // 3.2 % more at 80 N than at none: the catalogue has gains and biases only.
    let curved = |_, w: &mut Wrench| w.force_n.z *= 1.0 + 4e-4 * w.force_n.z.abs();
    let closure = closed(&grid(&[20.0, 40.0, 80.0], 3.0, &Colour::WHITE, 5, curved));
    assert_eq!(closure.verdict, Verdict::StructureRemains, "{:?}", closure.steps);
    assert!(
        closure.remaining.iter().any(|r| r.shape.contains("along fz_n")),
        "{:?} {:?}",
        closure.remaining,
        closure.steps
    );
}

/// A fifth too much is a sensor's gain; a third and more too little is none.
#[test]
fn a_gain_that_no_sensor_has_is_not_named() {
    let named = |factor: f64| {
        let gain = move |_, w: &mut Wrench| w.force_n.z *= factor;
        let closure = closed(&grid(&[40.0, 80.0], 3.0, &Colour::COLOURED, 5, gain));
        closure.steps.iter().any(|step| names(step).contains(&"force-gain"))
    };
    assert!(named(1.2));
    assert!(!named(0.65));
}

/// A head that turns in every press leaves its line in every record: where it is gone although
/// the noise would not hide it, nothing is «explained».
#[test]
fn records_without_the_spin_of_the_others_leave_a_doubt() {
    let mut presses = solved(&grid(&[60.0], 0.0, &Colour::WHITE, 77, |_, _| {}));
    let doubts = |presses: &[SolvedPress]| {
        PressModel::new(presses, &CONTACT, &LocateOptions::default(), &[])
            .unwrap()
            .declared()
            .findings
            .clone()
    };
    assert!(presses.iter().all(|p| p.orbit.wobble.is_some()));
    assert!(doubts(&presses).is_empty());
    presses[2].orbit.wobble = None;
    let found = doubts(&presses);
    assert_eq!(found.len(), 1);
    assert_eq!(
        (found[0].covariate.as_str(), found[0].shape.as_str()),
        ("spin", "lost in 1 of 9 records")
    );
    let model = PressModel::new(&presses, &CONTACT, &LocateOptions::default(), &[]).unwrap();
    let closure = close_loop(&model, &model.covariates(), &Options::default()).unwrap();
    assert_eq!(closure.verdict, Verdict::StructureRemains);
    // Noise in which a circle of that size drowns is no doubt.
    for press in &mut presses {
        press.orbit.scatter_mm2 *= 1e4;
    }
    assert!(doubts(&presses).is_empty());
}

/// A housing that warms up moves the head against the sensor, whatever the load.
#[test]
fn a_machine_that_comes_to_rest_is_a_drift_and_no_error_of_the_sensor() {
    let rounds = grid(&[40.0, 80.0], 3.0, &Colour::COLOURED, 5, |_, _| {});
    // Both loads at every place, so that load and time do not go together.
    let mut presses: Vec<Press> =
        (0..9).flat_map(|i| [rounds[i].clone(), rounds[9 + i].clone()]).collect();
    for (k, press) in presses.iter_mut().enumerate() {
        let come = -(-(k as f64) / 2.5).exp_m1();
        press.machine_mm -= Vector2::new(0.30, -0.15) * come;
    }
    let closure = closed(&presses);
    assert_eq!(closure.steps.len(), 1, "{:?}", closure.steps);
    let step = &closure.steps[0];
    assert_eq!((&*step.effect, step.subject.as_deref()), ("drift", Some("machine, settling")));
    // Its course is that of every press, also of those that are proposed.
    let model =
        PressModel::new(&solved(&presses), &CONTACT, &LocateOptions::default(), &[]).unwrap();
    assert_tangents(&model);
    assert_eq!(closure.verdict, Verdict::Explained);
    for (parameter, end_um) in step.parameters.iter().zip([300.0, -150.0]) {
        let off = (parameter.value - end_um).abs();
        // A time constant three tenths off moves what it comes to by a twentieth.
        assert!(off < 4.0 * parameter.std + 15.0, "{parameter:?}");
    }
}

/// A machine that was homed anew between two presses, which nobody wrote down.
#[test]
fn another_session_is_named_by_its_first_press() {
    let rounds = grid(&[40.0, 80.0], 3.0, &Colour::WHITE, 6, |_, _| {});
    // Both loads at every place, so that load and time do not go together.
    let mut presses: Vec<Press> =
        (0..9).flat_map(|i| [rounds[i].clone(), rounds[9 + i].clone()]).collect();
    let first = 7;
    for press in &mut presses[first..] {
        press.machine_mm -= Vector2::new(0.20, -0.30);
    }
    let closure = closed(&presses);
    assert_eq!(closure.steps.len(), 1, "{:?}", closure.steps);
    let step = &closure.steps[0];
    let subject = format!("machine, from {} on", presses[first].name);
    assert_eq!((&*step.effect, step.subject.as_ref()), ("session-shift", Some(&subject)));
    assert_eq!(closure.verdict, Verdict::Explained);
    for (parameter, shift_um) in step.parameters.iter().zip([200.0, -300.0]) {
        assert!((parameter.value - shift_um).abs() < 4.0 * parameter.std, "{parameter:?}");
    }
}

/// Play that is round lets the head go along the friction, by as much whatever the force: no height does.
#[test]
fn slip_in_a_round_guide_is_no_height() {
    let slip = |_, w: &mut Wrench| {
        let along = w.force_n.xy().normalize() * 0.2;
        let f = w.force_n;
        w.torque_nmm += Vector3::new(along.x, along.y, 0.0).cross(&f);
    };
    let closure = closed(&grid(&[20.0, 60.0], 6.0, &Colour::WHITE, 5, slip));
    assert_eq!(closure.steps.len(), 1, "{:?}", closure.steps);
    let class = names(&closure.steps[0]);
    assert!(class[0] == "slip" && !class.contains(&"contact-height"), "{class:?}");
    assert!((closure.steps[0].parameters[0].value - 200.0).abs() < 20.0, "{:?}", closure.steps);
}

/// What moves the head along the lateral force: in proportion to it, or to its ratio to the load. The latter is what
/// another contact height does to the centres.
#[test]
fn a_head_that_gives_way_is_no_height_and_one_that_slips_by_the_ratio_may_be() {
    let moved = |w: &mut Wrench, along: Vector2<f64>| {
        let f = w.force_n;
        w.torque_nmm += Vector3::new(along.x, along.y, 0.0).cross(&f);
    };
    let gives = |_, w: &mut Wrench| moved(w, w.force_n.xy() * 0.02);
    // Of one lateral force it would be a slip.
    let mut presses = grid(&[20.0, 40.0, 60.0], 3.0, &Colour::WHITE, 5, gives);
    let of_more = grid(&[20.0, 40.0, 60.0], 9.0, &Colour::WHITE, 6, gives);
    presses.extend(of_more.into_iter().map(|p| Press { name: format!("more {}", p.name), ..p }));
    let closure = closed(&presses);
    assert_eq!(closure.steps.len(), 1, "{:?}", closure.steps);
    let class = names(&closure.steps[0]);
    assert!(class[0] == "lateral-compliance" && !class.contains(&"contact-height"), "{class:?}");
    let compliance = &closure.steps[0].parameters[0];
    assert!((compliance.value - 20.0).abs() < 4.0 * compliance.std, "{compliance:?}");

    let slips = |_, w: &mut Wrench| moved(w, w.force_n.xy() / w.force_n.z.abs());
    let closure = closed(&grid(&[20.0, 40.0, 60.0], 6.0, &Colour::WHITE, 5, slips));
    assert_eq!(closure.steps.len(), 1, "{:?}", closure.steps);
    let class = names(&closure.steps[0]);
    assert!(class[0] == "contact-height" && class.contains(&"slip"), "{class:?}");
}

/// Readings of lateral forces that are nothing but noise are in the centres, times z0: a contact plane
/// at z0 = 0 would take that noise off. No effect may follow them.
#[test]
fn noise_of_lateral_forces_is_no_height() {
    let noisy = Colour { white_force_n: 0.3, ..Colour::WHITE };
    for seed in 1..7 {
        let gain = |_, w: &mut Wrench| w.force_n.z *= 1.01;
        let closure = closed(&grid(&[40.0, 80.0], 0.0, &noisy, seed, gain));
        for lateral in ["contact-height", "platform-tilt", "slip"] {
            let is_named = closure.steps.iter().any(|s| names(s).contains(&lateral));
            assert!(!is_named, "{seed}: {:?}", closure.steps);
            let hidden = closure.not_observable.iter().any(|n| n.effect.starts_with(lateral));
            assert!(hidden, "{lateral}: {:?}", closure.not_observable);
        }
        assert!(names(&closure.steps[0]).contains(&"force-gain"), "{:?}", closure.steps);
    }
}

/// The scatter from press to press that the data show has a bad press in it: it is no declared noise
/// whose tail a press far off could be.
#[test]
fn a_bad_press_is_no_tail_of_the_scatter_that_it_makes() {
    let mut presses = grid(&[40.0, 80.0], 3.0, &Colour::WHITE, 8, |_, _| {});
    presses[11].machine_mm += Vector2::new(0.25, -0.15);
    let noise = Some(Noise { force_n: 0.05, moment_nmm: 2.0 });
    let options = LocateOptions { noise, ..LocateOptions::default() };
    let model = PressModel::new(&solved(&presses), &CONTACT, &options, &[]).unwrap();
    let closure = close_loop(&model, &model.covariates(), &Options::default()).unwrap();
    assert_eq!(closure.steps.len(), 1, "{:?}", closure.steps);
    let step = &closure.steps[0];
    assert_eq!((&*step.effect, step.subject.as_deref()), ("bad-press", Some("p11")));
}
