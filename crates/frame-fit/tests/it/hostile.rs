//! Whatever comes in, nothing panics and nothing but numbers comes out.

use frame_fit::{
    FrameModel, Handedness, MeasuredPoint, Noise, Options, PointPair, SnoopingOptions, Transform,
    Uncertainty, compare_transforms, fit_frame, shape_of, snoop,
};
use least_squares::Loss;
use model_discrepancy::{Covariate, Model, Quantity, State};
use nalgebra::{Point, SMatrix, SVector};
use proptest::prelude::*;

/// Ordinary numbers, often equal ones, and everything that files hold by mistake.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => -500.0..500.0_f64,
        4 => prop::sample::select(vec![0.0, 1.0, -1.0, 100.0]),
        1 => prop::sample::select(vec![
            f64::NAN, f64::INFINITY, 1e300, -1e300, 1e-300, 5e-324, 4.2e9, 1e12, -0.0,
        ]),
    ]
}

fn sigma() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => 1e-3..1.0_f64,
        2 => prop::sample::select(vec![1e-12, 1e-6, 1e9, 1.0]),
        1 => number(),
    ]
}

fn uncertainty<const D: usize>() -> impl Strategy<Value = Uncertainty<D>> {
    prop_oneof![
        4 => sigma().prop_map(|sigma_mm| Uncertainty::Isotropic { sigma_mm }),
        2 => prop::array::uniform::<_, D>(sigma())
            .prop_map(|s| Uncertainty::PerAxis { sigma_mm: SVector::from(s) }),
        1 => prop::array::uniform::<_, D>(prop::array::uniform::<_, D>(number()))
            .prop_map(|m| Uncertainty::Full { covariance_mm2: SMatrix::from(m) }),
        1 => prop::array::uniform::<_, D>(prop::array::uniform::<_, D>(-1.0..1.0_f64))
            .prop_map(|m| {
                let m = SMatrix::<f64, D, D>::from(m);
                Uncertainty::Full { covariance_mm2: m * m.transpose() }
            }),
    ]
}

fn pairs<const D: usize>() -> impl Strategy<Value = Vec<PointPair<D>>> {
    let place =
        || prop::array::uniform::<_, D>(number()).prop_map(|c| Point::from(SVector::from(c)));
    let pair = (place(), place(), uncertainty::<D>(), any::<bool>()).prop_map(
        |(source_mm, target_mm, uncertainty, same)| PointPair {
            target_mm: if same { source_mm } else { target_mm },
            source_mm,
            uncertainty,
        },
    );
    prop::collection::vec(pair, 0..9)
}

fn options() -> impl Strategy<Value = Options> {
    let loss = prop_oneof![
        3 => Just(None),
        1 => number().prop_map(|scale| Some(Loss::Huber { scale })),
        1 => number().prop_map(|scale| Some(Loss::Tukey { scale })),
    ];
    let transform = prop::sample::select(Transform::ALL.to_vec());
    (transform, any::<bool>(), any::<bool>(), loss).prop_map(|(transform, improper, free, loss)| {
        Options {
            transform,
            handedness: if improper { Handedness::Improper } else { Handedness::Proper },
            noise: if free { Noise::Estimated } else { Noise::Declared },
            loss,
        }
    })
}

fn survive<const D: usize>(
    pairs: &[PointPair<D>],
    options: &Options,
    snooping: &SnoopingOptions,
    times: &[f64],
) -> Result<(), TestCaseError> {
    if let Ok(fit) = fit_frame(pairs, options) {
        let map = fit.target_from_source;
        prop_assert!(map.linear.iter().chain(map.translation_mm.iter()).all(|v| v.is_finite()));
        prop_assert!(fit.covariance.iter().all(|v| v.is_finite()));
        prop_assert!(fit.residuals_mm.iter().all(|r| r.iter().all(|v| v.is_finite())));
        prop_assert!(shape_of(&map).shears_rad.iter().all(|v| v.is_finite()));
    }
    for test in compare_transforms(pairs, options).unwrap_or_default() {
        prop_assert!((0.0..=1.0).contains(&test.p_value), "{test:?}");
    }
    if let Ok(snooping) = snoop(pairs, options, snooping) {
        prop_assert_eq!(snooping.kept.len() + snooping.suspects.len(), pairs.len());
    }
    let points = pairs.iter().enumerate().map(|(k, p)| MeasuredPoint::new(k.to_string(), *p));
    let covariates = [Covariate::recorded("air_c", Quantity::Temperature, times.to_vec())];
    if let Ok(model) = FrameModel::new(points.collect(), &covariates, options) {
        let state = State::start(&model);
        prop_assert!(model.residuals(&state).iter().all(|v| v.is_finite()));
        for effect in 0..model.declared().effects.len() {
            prop_assert!(model.tangent(&state, effect).iter().all(|v| v.is_finite()));
        }
        prop_assert!(model.proposals().iter().all(|p| !p.text.is_empty()));
    }
    Ok(())
}

proptest! {
    #![proptest_config(crate::seeded(400))]

    #[test]
    fn nothing_panics(
        planar in pairs::<2>(),
        spatial in pairs::<3>(),
        options in options(),
        levels in (number(), number()),
        times in prop::collection::vec(number(), 0..9),
    ) {
        let snooping = SnoopingOptions {
            family_significance: levels.0,
            power: levels.1,
            max_removed: usize::MAX,
        };
        survive(&planar, &options, &snooping, &times)?;
        survive(&spatial, &options, &snooping, &times)?;
    }
}
