//! Cases with the numbers and sizes of real ones; residuals are simulated, scores are made up.

use model_discrepancy::{
    Closure, Covariate, ErrorSummary, Group, HoldOut, Layout, NotObservable, Origin, Outcome,
    ParameterEstimate, Pass, Remaining, Role, Row, Score, State, Step, Verdict,
};
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::report::{
    Arrow, Curve, CurvePlot, Evidence, ExtraPlot, Fact, ParameterRow, Published, ReportInput,
    VectorMap,
};

/// A case that owns what [`ReportInput`] borrows.
pub(crate) struct Sample {
    pub(crate) title: String,
    pub(crate) kind: &'static str,
    pub(crate) source: Option<String>,
    pub(crate) description: Vec<String>,
    pub(crate) measured: Vec<Fact>,
    pub(crate) declared: Vec<String>,
    pub(crate) parameters: Vec<ParameterRow>,
    pub(crate) layout: Layout,
    pub(crate) components: Vec<String>,
    pub(crate) residual: &'static str,
    pub(crate) group_noun: String,
    pub(crate) closure: Closure,
    pub(crate) covariates: Vec<Covariate>,
    pub(crate) plots: Vec<ExtraPlot>,
    pub(crate) published: Option<Published>,
    pub(crate) warnings: Vec<String>,
}

impl Sample {
    pub(crate) fn closed(&self) -> ReportInput<'_> {
        self.input(Evidence::Closed(&self.closure))
    }

    pub(crate) fn solved(&self) -> ReportInput<'_> {
        self.input(Evidence::Solved { residuals: &self.closure.residuals_before })
    }

    fn input<'a>(&'a self, evidence: Evidence<'a>) -> ReportInput<'a> {
        ReportInput {
            title: &self.title,
            kind: self.kind,
            source: self.source.as_deref(),
            description: &self.description,
            measured: &self.measured,
            declared: &self.declared,
            parameters: &self.parameters,
            layout: &self.layout,
            components: &self.components,
            residual: self.residual,
            group_noun: &self.group_noun,
            evidence,
            covariates: &self.covariates,
            plots: &self.plots,
            published: self.published.as_ref(),
            warnings: &self.warnings,
        }
    }
}

/// Standard normal, near enough for a picture.
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    (0..12).map(|_| rng.random_range(-0.5..0.5)).sum()
}

fn strings(lines: &[&str]) -> Vec<String> {
    lines.iter().map(|l| (*l).to_string()).collect()
}

fn fact(name: &str, value: &str) -> Fact {
    Fact { name: name.into(), value: value.into() }
}

fn parameter(name: &str, unit: &str, value: f64, std: f64, after: (f64, f64)) -> ParameterRow {
    ParameterRow { name: name.into(), unit: unit.into(), value, std: Some(std), after: Some(after) }
}

fn estimate(name: &str, unit: &str, value: f64, std: f64) -> ParameterEstimate {
    ParameterEstimate { name: name.into(), unit: unit.into(), value, std }
}

fn score(label: &str, (f, p): (f64, f64), held_out: f64, absorbed: f64, outcome: Outcome) -> Score {
    Score {
        label: label.into(),
        absorbed,
        f_statistic: f,
        p_value: p,
        held_out_rms: held_out,
        detectable_rms: 0.3 * held_out / (1.0 - absorbed).max(1e-3).sqrt(),
        outcome,
    }
}

fn covariate(name: &str, values: Vec<f64>) -> Covariate {
    Covariate { name: name.into(), values, origin: Origin::Recorded }
}

/// Similarities that fall off with the distance in the list.
fn confusability(n: usize, closeness: f64) -> DMatrix<f64> {
    DMatrix::from_fn(n, n, |i, j| {
        let apart = i32::try_from(i.abs_diff(j)).expect("few candidates");
        closeness.powi(apart)
    })
}

fn rms(layout: &Layout, residuals: &[f64], role: Role) -> f64 {
    let of_role = |row: &Row| layout.groups[layout.observations[row.observation]].role == role;
    let squares: Vec<f64> =
        layout.rows.iter().zip(residuals).filter(|(r, _)| of_role(r)).map(|(_, v)| v * v).collect();
    let observations = layout.observations.iter().filter(|g| layout.groups[**g].role == role);
    #[expect(clippy::cast_precision_loss, reason = "few observations")]
    let n = observations.count() as f64;
    (squares.iter().sum::<f64>() / n).sqrt()
}

fn error(train_rms: f64, held_out_rms: f64, hold_out: HoldOut, unit: &str) -> ErrorSummary {
    ErrorSummary {
        train_rms,
        held_out_rms,
        held_out_std: 0.11 * held_out_rms,
        hold_out,
        unit: unit.into(),
        chi2_per_dof: None,
    }
}

fn no_state() -> State {
    State { base: DVector::zeros(0), amplitudes: Vec::new() }
}

/// 24 points in space, a scale that the rigid model lacks, 6 points set aside.
pub(crate) fn photogrammetry() -> Sample {
    const SIGMA_MM: f64 = 0.02;
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let points: Vec<[f64; 3]> = (0..24)
        .map(|_| [1500.0, 1500.0, 400.0].map(|half| rng.random_range(-half..half)))
        .collect();
    let temperature: Vec<f64> = (0..24).map(|i| 20.0 + 0.05 * f64::from(i)).collect();
    let layout = Layout {
        rows: (0..72)
            .map(|i| Row { observation: i / 3, component: i % 3, sigma: SIGMA_MM, reported: true })
            .collect(),
        observations: (0..24).collect(),
        groups: (0..24)
            .map(|i| Group {
                name: format!("T{}", 101 + i),
                role: if i % 4 == 3 { Role::Check } else { Role::Fit },
            })
            .collect(),
        unit: "mm".into(),
        sigma_declared: true,
    };
    let noise: Vec<f64> = (0..72).map(|_| SIGMA_MM * normal(&mut rng)).collect();
    let scaled = noise.iter().enumerate().map(|(i, e)| e - 429e-6 * points[i / 3][i % 3]);
    let before: Vec<f64> = scaled.collect();
    let arrows = |residuals: &[f64]| -> Vec<Arrow> {
        let arrow = |(i, p): (usize, &[f64; 3])| Arrow {
            at: [p[0], p[1]],
            error: [residuals[3 * i], residuals[3 * i + 1]],
            name: format!("T{}", 101 + i),
        };
        points.iter().enumerate().map(arrow).collect()
    };
    let vectors = ExtraPlot::Vectors(VectorMap {
        title: "Where the errors point".into(),
        caption: "Residual of each target seen along z. Vectors that all point inwards or \
            outwards are a scale; all to one side, a shift; around, a rotation."
            .into(),
        x_title: "x, mm".into(),
        y_title: "y, mm".into(),
        unit: "mm".into(),
        before: arrows(&before),
        after: arrows(&noise),
    });
    let (judged, fitted) = (Role::Check, Role::Fit);
    let closure = Closure {
        before: ErrorSummary {
            chi2_per_dof: Some(412.0),
            ..error(
                rms(&layout, &before, fitted),
                rms(&layout, &before, judged),
                HoldOut::CheckGroups,
                "mm",
            )
        },
        after: ErrorSummary {
            chi2_per_dof: Some(1.07),
            ..error(
                rms(&layout, &noise, fitted),
                rms(&layout, &noise, judged),
                HoldOut::CheckGroups,
                "mm",
            )
        },
        steps: vec![Step {
            effect: "scale".into(),
            subject: None,
            description: "One frame's unit of length differs from the other's.".into(),
            parameters: vec![estimate("scale", "ppm", -429.13, 2.31)],
            p_value: 3.2e-19,
            held_out_rms: 0.0361,
            train_rms: 0.0342,
            indistinguishable_from: vec![],
            separate_by: None,
            stability: Some(1.0),
        }],
        passes: vec![
            Pass {
                scores: vec![
                    score("scale", (5210.0, 3.2e-19), 0.0361, 0.02, Outcome::Added),
                    score("anisotropic-scale", (1740.0, 4e-18), 0.0372, 0.03, Outcome::Weaker),
                    score(
                        "covariate:temperature_c",
                        (4.1, 0.061),
                        0.66,
                        0.4,
                        Outcome::NotSignificant,
                    ),
                    score("drift", (3.2, 0.031), 0.71, 0.2, Outcome::DidNotGeneralise),
                    score("shear", (1.3, 0.31), 0.70, 0.1, Outcome::NotSignificant),
                    score("sag", (0.9, 0.36), 0.69, 0.35, Outcome::NotSignificant),
                    score("bad-point (T117)", (0.8, 0.52), 0.72, 0.2, Outcome::NotSignificant),
                    Score {
                        f_statistic: f64::NAN,
                        p_value: f64::NAN,
                        held_out_rms: f64::NAN,
                        detectable_rms: f64::INFINITY,
                        ..score("shift", (0.0, 1.0), 0.7, 1.0, Outcome::NotObservable)
                    },
                    Score {
                        f_statistic: f64::NAN,
                        p_value: f64::NAN,
                        held_out_rms: f64::NAN,
                        detectable_rms: f64::INFINITY,
                        ..score("rotation", (0.0, 1.0), 0.7, 1.0, Outcome::NotObservable)
                    },
                ],
            },
            Pass {
                scores: vec![
                    score(
                        "covariate:temperature_c",
                        (4.4, 0.05),
                        0.0352,
                        0.4,
                        Outcome::NotSignificant,
                    ),
                    score("bad-point (T104)", (2.9, 0.052), 0.0363, 0.2, Outcome::NotSignificant),
                    score("anisotropic-scale", (1.4, 0.27), 0.0372, 0.03, Outcome::NotSignificant),
                    score("sag", (1.1, 0.30), 0.0368, 0.35, Outcome::NotSignificant),
                    score("drift", (0.7, 0.56), 0.0375, 0.2, Outcome::NotSignificant),
                    score("shear", (0.4, 0.75), 0.0381, 0.1, Outcome::NotSignificant),
                ],
            },
        ],
        verdict: Verdict::Explained,
        remaining: vec![],
        not_observable: vec![
            NotObservable {
                effect: "shift".into(),
                aliased_with: strings(&["tx", "ty", "tz"]),
                separate_by: None,
            },
            NotObservable {
                effect: "rotation".into(),
                aliased_with: strings(&["rx", "ry", "rz"]),
                separate_by: Some(
                    "declare the transform `none` if both sets claim one frame".into(),
                ),
            },
        ],
        confusability: confusability(7, 0.62),
        confusable_ids: strings(&[
            "scale",
            "anisotropic-scale",
            "shear",
            "sag",
            "drift",
            "bad-point (T117)",
            "covariate:temperature_c",
        ]),
        state: no_state(),
        covariance: DMatrix::zeros(0, 0),
        residuals_before: before,
        residuals_after: noise,
        warnings: vec![],
    };
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
        covariates: vec![
            covariate("temperature_c", temperature),
            covariate("from_x_mm", points.iter().map(|p| p[0]).collect()),
            covariate("from_y_mm", points.iter().map(|p| p[1]).collect()),
            covariate("from_z_mm", points.iter().map(|p| p[2]).collect()),
        ],
        layout,
        components: strings(&["x", "y", "z"]),
        residual: "to − T(from)",
        group_noun: "point".into(),
        closure,
        plots: vec![vectors],
        published: None,
        warnings: vec![],
    }
}

/// Four displacements as printed: offset and gain, and a class of names for the gain.
pub(crate) fn four_displacements() -> Sample {
    let commanded = [1.0, 2.0, 5.0, 10.0];
    let solved = [0.819, 1.961, 5.168, 10.5];
    let layout = Layout {
        rows: (0..4)
            .map(|i| Row { observation: i, component: 0, sigma: 1.0, reported: true })
            .collect(),
        observations: (0..4).collect(),
        groups: commanded
            .iter()
            .map(|c| Group { name: format!("{c} mm"), role: Role::Fit })
            .collect(),
        unit: "mm".into(),
        sigma_declared: false,
    };
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
                separate_by: Some("press at a second load".into()),
                stability: None,
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
                separate_by: None,
                stability: None,
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
        not_observable: vec![],
        confusability: confusability(4, 0.98),
        confusable_ids: strings(&["moment-gain", "force-gain", "frame-scale", "datum-offset"]),
        state: no_state(),
        covariance: DMatrix::zeros(0, 0),
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

/// Many samples in presses, a slow wave that has no name, structure left.
pub(crate) fn long_log(samples_per_press: usize) -> Sample {
    const PRESSES: usize = 40;
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let n = PRESSES * samples_per_press;
    #[expect(clippy::cast_precision_loss, reason = "few samples")]
    let time: Vec<f64> = (0..n).map(|i| 0.02 * i as f64).collect();
    let load: Vec<f64> =
        (0..n).map(|i| if (i / samples_per_press) % 2 == 0 { 20.0 } else { 35.0 }).collect();
    let end = time[n - 1];
    let temperature: Vec<f64> =
        time.iter().map(|t| 21.0 + 1.5 * (1.0 - (-4.0 * t / end).exp())).collect();
    let mut slow = 0.0;
    let wander: Vec<f64> = (0..n)
        .map(|_| {
            slow = 0.98 * slow + 0.0006 * normal(&mut rng);
            slow
        })
        .collect();
    let after: Vec<f64> = (0..2 * n)
        .map(|i| {
            let wave = (40.0 * time[i / 2] / end + f64::from(u8::from(i % 2 == 1))).sin();
            wander[i / 2] + 0.004 * normal(&mut rng) + 0.002 * wave
        })
        .collect();
    let drift = |i: usize| if i % 2 == 0 { 0.012 * (temperature[i / 2] - 21.0) } else { 0.0 };
    let before: Vec<f64> = after.iter().enumerate().map(|(i, r)| r + drift(i)).collect();
    let layout = Layout {
        rows: (0..2 * n)
            .map(|i| Row { observation: i / 2, component: i % 2, sigma: 0.004, reported: true })
            .collect(),
        observations: (0..n).map(|i| i / samples_per_press).collect(),
        groups: (0..PRESSES)
            .map(|i| Group { name: format!("press {}", i + 1), role: Role::Fit })
            .collect(),
        unit: "mm".into(),
        sigma_declared: true,
    };
    let fitted = |r: &[f64]| rms(&layout, r, Role::Fit);
    let mut scores = vec![
        score("bias-drift", (88.0, 2e-9), 0.0091, 0.07, Outcome::Added),
        score("covariate:temperature_c", (86.0, 2.4e-9), 0.0092, 0.07, Outcome::Rival),
    ];
    for press in 1..=PRESSES {
        let label = format!("load-shift (press {press})");
        let p = 0.01 * f64::from(u8::try_from(press).expect("few")).powf(1.2);
        scores.push(score(&label, (2.0, p.min(1.0)), 0.0149, 0.3, Outcome::NotSignificant));
    }
    let curve = |name: &str, phase: f64| Curve {
        name: name.into(),
        points: (0..37)
            .map(|i| [10.0 * f64::from(i), 4.0 * (f64::from(i) / 5.0 + phase).sin()])
            .collect(),
        half_widths: (0..37).map(|i| 0.6 + 0.02 * f64::from(i)).collect(),
        joined: true,
    };
    let closure = Closure {
        before: error(fitted(&before), 1.04 * fitted(&before), HoldOut::Nested, "mm"),
        after: error(fitted(&after), 1.09 * fitted(&after), HoldOut::Nested, "mm"),
        steps: vec![Step {
            effect: "bias-drift".into(),
            subject: None,
            description: "The sensor's zero wanders with time.".into(),
            parameters: vec![
                estimate("force x", "N/h", 0.0421, 0.0033),
                estimate("force y", "N/h", -0.0007, 0.0031),
            ],
            p_value: 2e-9,
            held_out_rms: 0.0091,
            train_rms: fitted(&after),
            indistinguishable_from: strings(&["covariate:temperature_c"]),
            separate_by: Some(
                "repeat the first press at the end, after the sensor has cooled".into(),
            ),
            stability: Some(0.93),
        }],
        passes: vec![Pass { scores }],
        verdict: Verdict::StructureRemains,
        remaining: vec![
            Remaining { covariate: "time_s".into(), shape: "periodic".into(), p_value: 3e-5 },
            Remaining { covariate: "order".into(), shape: "autocorrelated".into(), p_value: 0.004 },
        ],
        not_observable: vec![NotObservable {
            effect: "sensor-bias".into(),
            aliased_with: strings(&["frame tx", "frame ty"]),
            separate_by: Some("press at a second load".into()),
        }],
        confusability: confusability(42, 0.9),
        confusable_ids: (0..42)
            .map(
                |i| {
                    if i < 2 { format!("candidate {i}") } else { format!("load-shift (press {i})") }
                },
            )
            .collect(),
        state: no_state(),
        covariance: DMatrix::zeros(0, 0),
        residuals_before: before,
        residuals_after: after,
        warnings: strings(&["press 12: 31 of 500 samples below the force gate were left out"]),
    };
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
            covariate("load_n", load),
            covariate("time_s", time),
        ],
        layout,
        components: strings(&["x", "y"]),
        residual: "solved centre − expected centre, machine frame",
        group_noun: "press".into(),
        closure,
        plots: vec![ExtraPlot::Curves(CurvePlot {
            title: "Orbit over one turn".into(),
            caption: "Mean of all turns with its 95 % band.".into(),
            x_title: "spindle angle, °".into(),
            y_title: "centre, µm".into(),
            curves: vec![curve("x", 0.0), curve("y", 1.5)],
        })],
        published: None,
        warnings: strings(&["no [noise] moment_nmm: estimated from the residual"]),
    }
}

/// The declared model explains the data.
pub(crate) fn nothing_missing() -> Sample {
    let mut sample = photogrammetry();
    let closure = &mut sample.closure;
    closure.residuals_before = closure.residuals_after.clone();
    closure.before = closure.after.clone();
    closure.steps.clear();
    closure.passes = vec![closure.passes[1].clone()];
    closure.verdict = Verdict::NothingMissing;
    sample.plots.clear();
    sample.title = "The same reflector, one scale bar".into();
    for row in &mut sample.parameters {
        row.after = None;
    }
    sample
}
