//! A log of tens of thousands of samples.

use model_discrepancy::{
    Closure, Group, HoldOut, Layout, NotObservable, Outcome, Pass, Remaining, Role, Row, Score,
    Stability, Step, Verdict,
};
use nalgebra::DMatrix;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::{
    Sample, confusability, covariate, error, estimate, fact, no_state, normal, parameter, rms,
    score, strings,
};
use crate::{Curve, CurvePlot, ExtraPlot};

const PRESSES: usize = 40;
const SIGMA_MM: f64 = 0.004;

/// Many samples in presses, a slow wave that has no name, structure left.
pub(crate) fn long_log(samples_per_press: usize) -> Sample {
    let n = PRESSES * samples_per_press;
    let time: Vec<f64> = (0u32..).take(n).map(|i| 0.02 * f64::from(i)).collect();
    let load = |i: usize| if (i / samples_per_press).is_multiple_of(2) { 20.0 } else { 35.0 };
    let end = time[n - 1];
    let warming = time.iter().map(|t| 21.0 + 1.5 * (1.0 - (-4.0 * t / end).exp()));
    let temperature: Vec<f64> = warming.collect();
    let after = wave_in_coloured_noise(&time);
    let drift = |i: usize| 0.012 * (temperature[i / 2] - 21.0);
    let drifting = |(i, r): (usize, &f64)| if i.is_multiple_of(2) { r + drift(i) } else { *r };
    let before: Vec<f64> = after.iter().enumerate().map(drifting).collect();
    let layout = layout(samples_per_press);
    Sample {
        title: "Force-sensor log, 40 presses".into(),
        kind: "ft-center",
        source: Some("simulated: coloured noise, seed 11".into()),
        description: strings(&["A rotating head pressed at 40 places with two loads."]),
        measured: vec![fact("rate", "50 Hz"), fact("loads", "20 N and 35 N")],
        declared: strings(&["M = p × F at the contact height; centre = mean over the record."]),
        parameters: vec![parameter("frame angle", "°", 0.512_33, 0.0021, (0.511_98, 0.0009))],
        covariates: vec![
            covariate("temperature_c", temperature),
            covariate("load_n", (0..n).map(load).collect()),
            covariate("time_s", time),
        ],
        components: strings(&["x", "y"]),
        residual: "solved centre − expected centre, machine frame",
        group_noun: "press".into(),
        closure: closure(&layout, before, after),
        layout,
        plots: vec![orbit()],
        published: None,
        warnings: strings(&["no [noise] moment_nmm: estimated from the residual"]),
    }
}

/// Residuals x, y, x, y …: white noise, a slow wander common to both, and a wave.
fn wave_in_coloured_noise(time: &[f64]) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let end = time[time.len() - 1];
    let mut wander = 0.0;
    let mut residuals = Vec::with_capacity(2 * time.len());
    for t in time {
        wander = 0.98 * wander + 0.0006 * normal(&mut rng);
        for phase in [0.0, 1.0] {
            let wave = 0.002 * (40.0 * t / end + phase).sin();
            residuals.push(wander + SIGMA_MM * normal(&mut rng) + wave);
        }
    }
    residuals
}

fn layout(samples_per_press: usize) -> Layout {
    let n = PRESSES * samples_per_press;
    let row =
        |i: usize| Row { observation: i / 2, component: i % 2, sigma: SIGMA_MM, reported: true };
    let group = |i| Group { name: format!("press {}", i + 1), role: Role::Fit };
    Layout {
        rows: (0..2 * n).map(row).collect(),
        observations: (0..n).map(|i| i / samples_per_press).collect(),
        groups: (0..PRESSES).map(group).collect(),
        unit: "mm".into(),
        sigma_declared: true,
    }
}

fn closure(layout: &Layout, before: Vec<f64>, after: Vec<f64>) -> Closure {
    let summary = |residuals: &[f64]| {
        let fitted = rms(layout, residuals, Role::Fit);
        error(fitted, 1.05 * fitted, HoldOut::Nested, "mm")
    };
    let (error_before, error_after) = (summary(&before), summary(&after));
    Closure {
        steps: vec![Step {
            effect: "bias-drift".into(),
            subject: None,
            description: "The sensor's zero wanders with time.".into(),
            parameters: vec![
                estimate("force x", "N/h", 0.0421, 0.0033),
                estimate("force y", "N/h", -0.0007, 0.0031),
            ],
            p_value: 2e-9,
            held_out_rms: error_after.held_out_rms,
            train_rms: error_after.train_rms,
            indistinguishable_from: strings(&["covariate:temperature_c"]),
            rivals: strings(&["covariate:temperature_c"]),
            separate_by: Some("repeat the first press at the end, once the sensor is cold".into()),
            stability: Stability { resampled: Some(0.93), perturbed: Some(1.0) },
        }],
        passes: vec![pass(error_before.held_out_rms, error_after.held_out_rms)],
        before: error_before,
        after: error_after,
        verdict: Verdict::StructureRemains,
        remaining: vec![
            Remaining { covariate: "time_s".into(), shape: "periodic".into(), p_value: 3e-5 },
            Remaining { covariate: "order".into(), shape: "autocorrelated".into(), p_value: 0.004 },
        ],
        lack_of_fit: None,
        odd_check: None,
        not_observable: vec![NotObservable {
            effect: "sensor-bias".into(),
            aliased_with: strings(&["frame tx", "frame ty"]),
            separate_by: Some("press at a second load".into()),
        }],
        confusability: confusability(PRESSES + 2, 0.9),
        confusable_ids: candidates(),
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
        warnings: strings(&["press 12: 31 of 500 samples below the force gate were left out"]),
    }
}

/// Two that matter, and one for each press.
fn candidates() -> Vec<String> {
    let shifts = (1..=PRESSES).map(|press| format!("load-shift [press {press}]"));
    strings(&["bias-drift", "covariate:temperature_c"]).into_iter().chain(shifts).collect()
}

fn pass(without: f64, with: f64) -> Pass {
    let scored = |(i, label): (u32, &String)| -> Score {
        match i {
            0 => score(label, (88.0, 2e-9), with, 0.07, Outcome::Added),
            1 => score(label, (86.0, 2.4e-9), 1.01 * with, 0.07, Outcome::Rival),
            _ => {
                let p = (0.01 * f64::from(i - 1).powf(1.2)).min(1.0);
                let error = without * (0.97 + 0.002 * f64::from(i));
                score(label, (2.0, p), error, 0.3, Outcome::NotSignificant)
            }
        }
    };
    Pass { scores: (0u32..).zip(&candidates()).map(scored).collect() }
}

fn orbit() -> ExtraPlot {
    let curve = |name: &str, phase: f64| Curve {
        name: name.into(),
        points: (0..37)
            .map(|i| [10.0 * f64::from(i), 4.0 * (f64::from(i) / 5.0 + phase).sin()])
            .collect(),
        half_widths: (0..37).map(|i| 0.6 + 0.02 * f64::from(i)).collect(),
        joined: true,
    };
    ExtraPlot::Curves(CurvePlot {
        title: "Orbit over one turn".into(),
        caption: "Mean of all turns with its 95 % band.".into(),
        x_title: "spindle angle, °".into(),
        y_title: "centre, µm".into(),
        curves: vec![curve("x", 0.0), curve("y", 1.5)],
    })
}
