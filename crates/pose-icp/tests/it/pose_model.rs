//! The declared model as the loop sees it.

use model_discrepancy::{
    Covariate, Model, Options, Quantity, Role, State, Verdict, check_tangents, close_loop,
};
use nalgebra::DVector;
use pose_icp::{EdgeTouches, MeasuredTouch, PoseModel, PoseOptions, PoseParameter, Touch};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::pose_scene::{TIP_MM, center_over, edge, paraboloid, random_pose, tip, touches};

/// Sunflower of `n` points within `radius_mm`.
fn spread(n: u32, radius_mm: f64) -> Vec<[f64; 2]> {
    (0..n)
        .map(|i| {
            let radius = radius_mm * ((f64::from(i) + 0.5) / f64::from(n)).sqrt();
            let (sin, cos) = (2.399_963 * f64::from(i)).sin_cos();
            [radius * cos, radius * sin]
        })
        .collect()
}

fn measured(touches: Vec<Touch>) -> Vec<MeasuredTouch> {
    let named = |(i, touch): (usize, Touch)| MeasuredTouch {
        name: format!("P{i}"),
        group: format!("P{i}"),
        role: Role::Fit,
        touch,
    };
    touches.into_iter().enumerate().map(named).collect()
}

/// Central differences over tilts of 4e-5 rad of an asphericity that varies over 40/480 rad.
const DIFFERENCE_TOL: f64 = 1e-5;

#[test]
fn derivatives_agree_with_differences_for_every_effect_and_clamping() {
    let mut rng = ChaCha8Rng::seed_from_u64(461);
    let pose = random_pose(&mut rng);
    let points = touches(&pose, &spread(14, 45.0), 1e-3, &mut rng);
    let recorded =
        [("time_s", Quantity::Time), ("part_c", Quantity::Temperature)].map(|(name, quantity)| {
            let values = (0..14).map(|i| 20.0 + f64::from(i * i % 11)).collect();
            Covariate::recorded(name, quantity, values)
        });
    // Side touches to 1 mm, so that rounding of whitened rows stays below the differences.
    let edge = EdgeTouches { sigma_mm: 1.0, ..edge(&pose, 1e-3, &mut rng) };
    let side = edge.locate(tip(), 0.3).unwrap();
    let held = vec![PoseParameter::X, PoseParameter::Beta, PoseParameter::Gamma];
    for options in [
        PoseOptions { tip: tip(), lateral: Some(side.prior), ..PoseOptions::default() },
        PoseOptions { tip: tip(), held, ..PoseOptions::default() },
    ] {
        let model =
            PoseModel::new(paraboloid(), measured(points.clone()), &recorded, &pose, &options)
                .unwrap();
        let mut models: Vec<Box<dyn Model>> = vec![Box::new(model.clone())];
        models.extend(model.proposals().into_iter().map(|p| p.model));
        assert!(models.len() > 8, "{}", models.len());
        for model in models {
            let mut at = State::start(&*model);
            at.base = DVector::from_fn(at.base.len(), |_, _| rng.random_range(-1e-3..1e-3));
            let worst = check_tangents(&*model, &at);
            assert!(worst < DIFFERENCE_TOL, "{worst:e}");
            for amplitude in at.amplitudes.iter_mut().flat_map(|a| a.iter_mut()) {
                *amplitude = rng.random_range(-1e-5..1e-5);
            }
            let worst = check_tangents(&*model, &at);
            assert!(worst < DIFFERENCE_TOL, "{worst:e}");
        }
    }
}

#[test]
fn astigmatism_is_found_with_its_size_and_nothing_is_where_nothing_is() {
    let mut rng = ChaCha8Rng::seed_from_u64(462);
    let pose = random_pose(&mut rng);
    let at = spread(40, 48.0);
    let side = edge(&pose, 1e-3, &mut rng).locate(tip(), pose.angles.gamma_rad).unwrap();
    let options = PoseOptions { tip: tip(), lateral: Some(side.prior), ..PoseOptions::default() };
    let close = |touches: Vec<Touch>| {
        let touches = measured(touches);
        let model = PoseModel::new(paraboloid(), touches, &[], &side.start, &options).unwrap();
        close_loop(&model, &model.all_covariates(), &Options::default()).unwrap()
    };
    let clean = touches(&pose, &at, 1e-3, &mut rng);
    assert_eq!(close(clean.clone()).verdict, Verdict::NothingMissing);

    // 8 µm at the rim, raised along the part's own z.
    let up = center_over(&pose, 0.0, 0.0, TIP_MM + 1.0) - center_over(&pose, 0.0, 0.0, TIP_MM);
    let bent: Vec<Touch> = (clean.iter().zip(&at))
        .map(|(touch, [x, y])| {
            let height = 8e-3 * (x * x - y * y) / 2500.0;
            Touch { center_mm: touch.center_mm + up * height, ..*touch }
        })
        .collect();
    let closure = close(bent);
    let step = &closure.steps[0];
    let names: Vec<&str> = std::iter::once(step.effect.as_str())
        .chain(step.indistinguishable_from.iter().map(String::as_str))
        .collect();
    assert!(names.contains(&"astigmatism"), "{names:?}");
    if step.effect == "astigmatism" {
        let cos = &step.parameters[0];
        assert!((cos.value - 8.0).abs() < 4.0 * cos.std, "{cos:?}");
    }
    assert_eq!(closure.verdict, Verdict::Explained);
}

/// What is known beforehand lies nowhere on the part: columns have their mean there, on which no trend turns.
#[test]
fn prior_knowledge_has_the_mean_of_every_column() {
    let mut rng = ChaCha8Rng::seed_from_u64(463);
    let pose = random_pose(&mut rng);
    let side = edge(&pose, 1e-3, &mut rng).locate(tip(), pose.angles.gamma_rad).unwrap();
    let options = PoseOptions { tip: tip(), lateral: Some(side.prior), ..PoseOptions::default() };
    let points = measured(touches(&pose, &spread(14, 45.0), 1e-3, &mut rng));
    let warm = (0..14).map(|i| 20.0 + f64::from(i)).collect();
    let column = Covariate::recorded("part_c", Quantity::Temperature, warm);
    let model = PoseModel::new(paraboloid(), points, &[column], &pose, &options).unwrap();
    let observations = model.declared().layout.observations.len();
    assert!(observations > 14, "the side is an observation of its own");
    for covariate in model.all_covariates() {
        let (of_touches, beside) = covariate.values.split_at(14);
        let mean = of_touches.iter().sum::<f64>() / 14.0;
        assert_eq!(covariate.values.len(), observations);
        // Round-off of 14 terms of 50 mm.
        assert!(beside.iter().all(|v| (v - mean).abs() < 1e-12), "{}", covariate.name);
    }
    let warm = model.all_covariates().into_iter().find(|c| c.name == "part_c").unwrap();
    assert!((warm.values[14] - 26.5).abs() < 1e-12);
}
