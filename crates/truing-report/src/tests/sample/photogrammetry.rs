//! 24 targets seen twice.

use model_discrepancy::{
    Closure, Covariate, ErrorSummary, Group, HoldOut, Layout, NotObservable, Outcome, Pass, Role,
    Row, Score, Stability, Step, Verdict,
};
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{
    Sample, confusability, covariate, error, estimate, fact, no_state, normal, parameter, rms,
    score, strings,
};
use crate::{Arrow, ExtraPlot, VectorMap};

const SIGMA_MM: f64 = 0.02;
const SCALE: f64 = -429e-6;
const TARGETS: usize = 24;

/// 24 points in space, a scale that the rigid model lacks, 6 points set aside.
pub(crate) fn photogrammetry() -> Sample {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let points: Vec<[f64; 3]> = (0..TARGETS)
        .map(|_| [1500.0, 1500.0, 400.0].map(|half| rng.random_range(-half..half)))
        .collect();
    let layout = layout();
    let after: Vec<f64> = (0..3 * TARGETS).map(|_| SIGMA_MM * normal(&mut rng)).collect();
    let before: Vec<f64> =
        after.iter().enumerate().map(|(i, e)| e + SCALE * points[i / 3][i % 3]).collect();
    Sample {
        title: "Large-aperture reflector, bundle 2 against bundle 1".into(),
        kind: "frame-fit",
        source: Some("simulated: 24 targets, seed 7".into()),
        description: strings(&[
            "Two photogrammetry bundles of the same coded targets, taken a day apart. The second \
             bundle's scale bar was not the one of the first.",
        ]),
        measured: vec![fact("volume", "3.0 m × 3.0 m × 0.8 m"), fact("targets", "24, coded")],
        declared: strings(&[
            "Rigid: to = T · from, six parameters. T perturbs on the left, [tx ty tz rx ry rz].",
        ]),
        parameters: vec![
            parameter("tx", "mm", 12.403_121, 0.0083, (12.403_981, 0.0011)),
            parameter("ty", "mm", -3.118_42, 0.0083, (-3.118_95, 0.0011)),
            parameter("tz", "mm", 0.042_11, 0.0083, (0.041_72, 0.0011)),
            parameter("rx", "°", 0.012_114, 0.00041, (0.012_103, 0.00005)),
            parameter("ry", "°", -0.100_217, 0.00041, (-0.100_198, 0.00005)),
            parameter("rz", "°", 30.000_871, 0.00027, (30.000_862, 0.00003)),
        ],
        components: strings(&["x", "y", "z"]),
        residual: "to − T(from)",
        group_noun: "point".into(),
        covariates: covariates(&points),
        plots: vec![vectors(&points, &before, &after)],
        closure: closure(&layout, before, after),
        layout,
        published: None,
        warnings: vec![],
    }
}

/// The same targets with one scale bar: the declared model explains the data.
pub(crate) fn nothing_missing() -> Sample {
    let mut sample = photogrammetry();
    let closure = &mut sample.closure;
    closure.residuals_before = closure.residuals_after.clone();
    closure.before = closure.after.clone();
    closure.steps.clear();
    closure.passes = vec![second_pass()];
    closure.verdict = Verdict::NothingMissing;
    sample.plots.clear();
    sample.title = "The same reflector, one scale bar".into();
    for row in &mut sample.parameters {
        row.after = None;
    }
    sample
}

fn layout() -> Layout {
    let group = |i| Group {
        name: format!("T{}", 101 + i),
        role: if i % 4 == 3 { Role::Check } else { Role::Fit },
    };
    let row =
        |i: usize| Row { observation: i / 3, component: i % 3, sigma: SIGMA_MM, reported: true };
    Layout {
        rows: (0..3 * TARGETS).map(row).collect(),
        observations: (0..TARGETS).collect(),
        groups: (0..TARGETS).map(group).collect(),
        unit: "mm".into(),
        sigma_declared: true,
    }
}

fn covariates(points: &[[f64; 3]]) -> Vec<Covariate> {
    let temperature = (0u32..).take(TARGETS).map(|i| 20.0 + 0.05 * f64::from(i)).collect();
    vec![
        covariate("temperature_c", temperature),
        covariate("from_x_mm", points.iter().map(|p| p[0]).collect()),
        covariate("from_y_mm", points.iter().map(|p| p[1]).collect()),
        covariate("from_z_mm", points.iter().map(|p| p[2]).collect()),
    ]
}

fn vectors(points: &[[f64; 3]], before: &[f64], after: &[f64]) -> ExtraPlot {
    let arrows = |residuals: &[f64]| -> Vec<Arrow> {
        let arrow = |(i, p): (usize, &[f64; 3])| Arrow {
            at: [p[0], p[1]],
            error: [residuals[3 * i], residuals[3 * i + 1]],
            name: format!("T{}", 101 + i),
        };
        points.iter().enumerate().map(arrow).collect()
    };
    ExtraPlot::Vectors(VectorMap {
        title: "Where the errors point".into(),
        caption: "Residual of each target seen along z. Vectors that all point inwards or \
            outwards are a scale; all to one side, a shift; around, a rotation."
            .into(),
        x_title: "x, mm".into(),
        y_title: "y, mm".into(),
        unit: "mm".into(),
        facets: Vec::new(),
        before: arrows(before),
        after: arrows(after),
    })
}

fn closure(layout: &Layout, before: Vec<f64>, after: Vec<f64>) -> Closure {
    let summary = |residuals: &[f64], chi2| ErrorSummary {
        chi2_per_dof: Some(chi2),
        chi2_interval: None,
        ..error(
            rms(layout, residuals, Role::Fit),
            rms(layout, residuals, Role::Check),
            HoldOut::CheckGroups,
            "mm",
        )
    };
    Closure {
        before: summary(&before, 412.0),
        after: summary(&after, 1.07),
        steps: vec![Step {
            effect: "scale".into(),
            subject: None,
            description: "One frame's unit of length differs from the other's.".into(),
            parameters: vec![estimate("scale", "ppm", -429.13, 2.31)],
            p_value: 3.2e-19,
            held_out_rms: 0.0361,
            train_rms: 0.0342,
            indistinguishable_from: vec![],
            rivals: vec![],
            separate_by: None,
            stability: Stability { resampled: Some(1.0), perturbed: Some(1.0) },
        }],
        passes: vec![first_pass(), second_pass()],
        verdict: Verdict::Explained,
        remaining: vec![],
        lack_of_fit: None,
        odd_check: None,
        not_observable: not_observable(),
        confusability: confusability(7, 0.62),
        confusable_ids: strings(&[
            "scale",
            "anisotropic-scale",
            "shear",
            "sag",
            "drift",
            "bad-point [T117]",
            "covariate:temperature_c",
        ]),
        state: no_state(),
        covariance: DMatrix::zeros(0, 0),
        columns: vec![],
        empirical: vec![],
        jacobian: DMatrix::zeros(0, 0),
        variance_factor: 1.0,
        degrees_of_freedom: None,
        alternatives: vec![],
        residuals_before: before,
        residuals_after: after,
        warnings: vec![],
    }
}

fn not_observable() -> Vec<NotObservable> {
    vec![
        NotObservable {
            effect: "shift".into(),
            aliased_with: strings(&["tx", "ty", "tz"]),
            separate_by: None,
        },
        NotObservable {
            effect: "rotation".into(),
            aliased_with: strings(&["rx", "ry", "rz"]),
            separate_by: Some("declare the transform `none` if both sets claim one frame".into()),
        },
    ]
}

fn first_pass() -> Pass {
    let unseen = |label| Score {
        f_statistic: f64::NAN,
        p_value: f64::NAN,
        held_out_rms: f64::NAN,
        detectable_rms: f64::INFINITY,
        ..score(label, (0.0, 1.0), 0.7, 1.0, Outcome::NotObservable)
    };
    Pass {
        scores: vec![
            score("scale", (5210.0, 3.2e-19), 0.0361, 0.02, Outcome::Added),
            score("anisotropic-scale", (1740.0, 4e-18), 0.0372, 0.03, Outcome::Weaker),
            score("covariate:temperature_c", (4.1, 0.061), 0.66, 0.4, Outcome::NotSignificant),
            score("drift", (3.2, 0.031), 0.71, 0.2, Outcome::DidNotGeneralise),
            score("shear", (1.3, 0.31), 0.70, 0.1, Outcome::NotSignificant),
            score("sag", (0.9, 0.36), 0.69, 0.35, Outcome::NotSignificant),
            score("bad-point [T117]", (0.8, 0.52), 0.72, 0.2, Outcome::NotSignificant),
            unseen("shift"),
            unseen("rotation"),
        ],
    }
}

fn second_pass() -> Pass {
    Pass {
        scores: vec![
            score("covariate:temperature_c", (4.4, 0.05), 0.0352, 0.4, Outcome::NotSignificant),
            score("bad-point [T104]", (2.9, 0.052), 0.0363, 0.2, Outcome::NotSignificant),
            score("anisotropic-scale", (1.4, 0.27), 0.0372, 0.03, Outcome::NotSignificant),
            score("sag", (1.1, 0.30), 0.0368, 0.35, Outcome::NotSignificant),
            score("drift", (0.7, 0.56), 0.0375, 0.2, Outcome::NotSignificant),
            score("shear", (0.4, 0.75), 0.0381, 0.1, Outcome::NotSignificant),
        ],
    }
}
