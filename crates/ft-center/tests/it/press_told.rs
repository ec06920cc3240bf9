//! What the model of presses tells beside its names: other courses, conditions, uncertainty of a place.

use ft_center::{Press, PressModel, PressRole};
use model_discrepancy::{Effect, Model, Options, State, close_loop};
use nalgebra::Vector2;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::press_loop::{grid, model};
use crate::simulator::{Colour, normal};

/// Beside a drift that was found its likeliest other courses are looked for, too; looking again beside what
/// is found with these shows no more.
#[test]
fn what_shows_beside_a_drift_is_looked_for_once() {
    let rounds = grid(&[40.0, 80.0], 3.0, &Colour::COLOURED, 5, |_, _| {});
    let mut presses: Vec<Press> =
        (0..9).flat_map(|i| [rounds[i].clone(), rounds[9 + i].clone()]).collect();
    for (k, press) in presses.iter_mut().enumerate() {
        press.machine_mm -= Vector2::new(0.30, -0.15) * -(-(k as f64) / 2.5).exp_m1();
    }
    let first = model(&presses);
    assert!(first.about_found(&State::start(&first)).is_none(), "nothing was found");
    let close = |model: &PressModel| {
        close_loop(model, &model.covariates(), &Options::default()).unwrap().state
    };
    let courses = |model: &PressModel| {
        let of_machine = |s: &String| s.starts_with("machine, ");
        let effects = model.declared().effects.iter();
        effects.filter(|e| e.subject.as_ref().is_some_and(of_machine)).count()
    };
    let second = first.about_found(&close(&first)).expect("other courses of the drift");
    assert!(courses(&second) > courses(&first));
    assert!(second.about_found(&close(&second)).is_none(), "not settled");
}

/// The frame is told with what it leaves out.
#[test]
fn a_frame_says_when_it_holds() {
    let model = model(&grid(&[40.0, 80.0], 3.0, &Colour::WHITE, 9, |_, _| {}));
    let closure = close_loop(&model, &model.covariates(), &Options::default()).unwrap();
    assert!(closure.steps.is_empty() && model.located(&closure).conditions.is_empty());
    let said = |id: &str, subject: Option<&str>| {
        let is_it = |e: &Effect| e.id == id && e.subject.as_deref() == subject;
        let effect = model.declared().effects.iter().position(is_it).unwrap();
        let mut held = closure.clone();
        held.state.amplitudes[effect][0] = 1e-3;
        model.located(&held).conditions
    };
    let rest = "is in the corrections of the presses";
    assert_eq!(
        said("drift", Some("machine")),
        [format!("the frame holds at the first press; the drift {rest}")]
    );
    assert_eq!(
        said("load-shift", None),
        [format!("the frame holds without load; the shift by load {rest}")]
    );
    assert_eq!(
        said("bad-press", Some("p3")),
        ["the frame is that of the other presses; the correction of p3 is its own error"]
    );
    // What the frame has in it is left out of nothing.
    assert!(said("frame-scale", None).is_empty());
}

/// A head seats anew on the press that is located, as on every other.
#[test]
fn a_located_press_is_no_surer_than_its_seat() {
    let seat_mm = 0.1;
    let noise = Colour { white_moment_nmm: 2.0, ..Colour::NONE };
    let mut presses = grid(&[40.0, 80.0], 3.0, &noise, 10, |_, _| {});
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    for press in &mut presses {
        press.machine_mm += Vector2::from_fn(|_, _| seat_mm * normal(&mut rng));
    }
    presses[4].role = PressRole::Locate;
    let model = model(&presses);
    let closure = close_loop(&model, &model.covariates(), &Options::default()).unwrap();
    assert!(closure.steps.is_empty(), "{:?}", closure.steps);
    let located = model.located(&closure);
    // What the presses scatter by as the frame has it; the frame of 17 presses has a share of 1/17 beside it
    // and, in the middle of the grid, nothing of the turn. The records know 2 N·mm over 40 N and the root of
    // 150 samples, 0.2 % of the seat's variance.
    let share = located.centers[4].covariance_mm2 / located.seat_mm.powi(2);
    let expected = located.frame.variance_factor + 1.0 / 17.0;
    for axis in 0..2 {
        assert!((share[(axis, axis)] - expected).abs() < 0.02, "{share}");
    }
    // Of 31 degrees of freedom: a standard deviation has one of 13 %, and four of them.
    let scatter_mm = located.seat_mm * located.frame.variance_factor.sqrt();
    assert!((scatter_mm / seat_mm - 1.0).abs() < 0.52, "{scatter_mm}");
}
