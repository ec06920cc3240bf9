//! Four displacements as they were printed.

use model_discrepancy::{Closure, HoldOut, Layout, Outcome, Pass, Role, Stability, Step, Verdict};
use nalgebra::DMatrix;

use super::{
    Sample, confusability, covariate, error, estimate, fact, no_state, rms, score, strings,
};
use crate::Published;

/// Four displacements as printed: offset and gain, and a class of names for the gain.
pub(crate) fn four_displacements() -> Sample {
    let commanded = [1.0, 2.0, 5.0, 10.0];
    let solved = [0.819, 1.961, 5.168, 10.5];
    let layout = Layout::scalars(commanded.iter().map(|c| format!("{c} mm")), "mm", None);
    let before: Vec<f64> = solved.iter().zip(commanded).map(|(s, c)| s - c).collect();
    let line = |(s, c): (&f64, f64)| s - (-0.2151 + 1.0728 * c);
    let after: Vec<f64> = solved.iter().zip(commanded).map(line).collect();
    let fitted = |r: &[f64]| rms(&layout, r, Role::Fit);
    let closure = Closure {
        before: error(fitted(&before), 0.2802, HoldOut::LeaveOneOut, "mm"),
        after: error(fitted(&after), 0.0659, HoldOut::LeaveOneOut, "mm"),
        steps: vec![
            Step {
                effect: "moment-gain".into(),
                subject: None,
                description: "The moment channels read too much by one factor.".into(),
                parameters: vec![estimate("gain", "%", 7.28, 0.46)],
                p_value: 4.1e-3,
                held_out_rms: 0.171,
                train_rms: 0.121,
                indistinguishable_from: strings(&["force-gain", "frame-scale"]),
                rivals: strings(&["force-gain", "frame-scale"]),
                separate_by: Some("press at a second load".into()),
                stability: Stability::default(),
            },
            Step {
                effect: "datum-offset".into(),
                subject: None,
                description: "The zero of the displacements is not where it is said to be.".into(),
                parameters: vec![estimate("offset", "mm", -0.2151, 0.0262)],
                p_value: 1.3e-2,
                held_out_rms: 0.0659,
                train_rms: fitted(&after),
                indistinguishable_from: vec![],
                rivals: vec![],
                separate_by: None,
                stability: Stability::default(),
            },
        ],
        passes: vec![
            Pass {
                scores: vec![
                    score("moment-gain", (22.0, 4.1e-3), 0.171, 0.0, Outcome::Added),
                    score("force-gain", (21.8, 4.2e-3), 0.172, 0.0, Outcome::Rival),
                    score("frame-scale", (22.0, 4.1e-3), 0.171, 0.0, Outcome::Rival),
                    score("datum-offset", (0.4, 0.57), 0.36, 0.0, Outcome::NotSignificant),
                ],
            },
            Pass {
                scores: vec![score("datum-offset", (67.0, 1.3e-2), 0.0659, 0.0, Outcome::Added)],
            },
        ],
        verdict: Verdict::Explained,
        remaining: vec![],
        lack_of_fit: None,
        odd_check: None,
        not_observable: vec![],
        confusability: confusability(4, 0.98),
        confusable_ids: strings(&["moment-gain", "force-gain", "frame-scale", "datum-offset"]),
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
        warnings: strings(&["four points: the interval of the error after is itself uncertain"]),
    };
    Sample {
        title: "Polishing head moved 1 to 10 mm".into(),
        kind: "ft-center",
        source: Some("document [A], Table 4".into()),
        description: strings(&["A head was moved by known amounts over a six-axis force sensor."]),
        measured: vec![fact("displacements", "1 mm to 10 mm")],
        declared: strings(&["solved = commanded; nothing is free."]),
        parameters: vec![],
        layout,
        components: vec![],
        residual: "solved − commanded",
        group_noun: "point".into(),
        closure,
        covariates: vec![covariate("commanded_mm", commanded.to_vec())],
        plots: vec![],
        published: Some(Published {
            text: "0.280 mm rms".into(),
            source: "document [A], Table 4".into(),
            rms: Some(0.280),
        }),
        warnings: vec![],
    }
}
