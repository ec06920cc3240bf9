//! Models of proposed measurements: those of the touches that they plan, and what a standard adds.

use std::f64::consts::FRAC_PI_3;

use model_discrepancy::{Covariate, Model, Quantity, Role, State};
use nalgebra::{DMatrix, Point3};
use probe_comp::{BallTouch, ProbeModel, Side};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::scene::{TIP_MM, directions, measured, noise, reference_sphere, setup};

const N: usize = 24;
const SIGMA_MM: f64 = 1e-3;
/// Round-off of two ways to the same column, relative to the largest entry.
const SAME_TOL: f64 = 1e-12;

/// Touches all round a sphere, the probe turned anew for each.
fn touches() -> Vec<BallTouch> {
    let mut rng = ChaCha8Rng::seed_from_u64(71);
    directions(24)
        .into_iter()
        .map(|out| {
            let center = Point3::new(40.0, -20.0, 15.0) + out * (25.0 + TIP_MM);
            let spindle_rad = rng.random_range(-3.0..3.0);
            BallTouch {
                spindle_rad,
                ..BallTouch::new(center + noise(SIGMA_MM, &mut rng), SIGMA_MM)
            }
        })
        .collect()
}

/// Time in uneven steps, feed and temperature of each touch.
fn columns() -> [Vec<f64>; 3] {
    let of = |f: fn(f64) -> f64| (0..24).map(|k| f(f64::from(k))).collect();
    [of(|k| 100.0 + 8.0 * k + 0.2 * k * k), of(|k| 60.0 + 30.0 * (k % 3.0)), of(|k| 20.0 + k % 5.0)]
}

fn model(touches: Vec<BallTouch>, [times, feeds, temperatures]: [Vec<f64>; 3]) -> ProbeModel {
    let columns = [
        Covariate::recorded("time_s", Quantity::Time, times),
        Covariate::recorded("feed_mm_per_min", Quantity::Other, feeds),
        Covariate::recorded("part_c", Quantity::Temperature, temperatures),
    ];
    ProbeModel::new(setup(reference_sphere(Side::Along)), measured(touches), &columns).unwrap()
}

fn proposed(starts: &str) -> Box<dyn Model> {
    let model = model(touches(), columns());
    let proposals = model.proposals();
    proposals.into_iter().find(|p| p.text.starts_with(starts)).unwrap().model().unwrap()
}

/// What every effect does to every row; one touch that is off says nothing of others.
fn tangents(model: &dyn Model) -> Vec<(String, String, DMatrix<f64>)> {
    let start = State::start(model);
    let effects = model.declared().effects.iter().enumerate();
    effects
        .filter(|(_, effect)| effect.id != "bad-point")
        .map(|(k, e)| (e.id.clone(), format!("{:?}", e.subject), model.tangent(&start, k)))
        .collect()
}

/// A proposal that touches points again says what the model of those touches would say: time goes on
/// at its mean pace, and nothing changes but what the proposal names.
#[test]
fn a_proposal_is_the_model_of_the_touches_that_it_plans() {
    const FIRST: [usize; 3] = [0, 1, 2];
    let all: Vec<usize> = (0..N).collect();
    let back: Vec<usize> = (0..N).rev().collect();
    // What is repeated, and by how much the probe is turned, the feed multiplied and the part warmer.
    let planned: [(&str, &[usize], f64, f64, f64); 5] = [
        ("touch the first points again", &FIRST, 0.0, 1.0, 0.0),
        ("touch the points again at a quarter", &all, 0.0, 0.25, 0.0),
        ("turn the probe by 60°", &all, FRAC_PI_3, 1.0, 0.0),
        ("touch all points a second time, in reverse", &back, 0.0, 1.0, 0.0),
        ("touch all points again, 5 K warmer", &all, 0.0, 1.0, 5.0),
    ];
    for (text, which, turn_rad, feed_ratio, warmer_k) in planned {
        let (mut touched, mut columns) = (touches(), columns());
        let pace_s = (columns[0][N - 1] - columns[0][0]) / 23.0;
        for &like in which {
            let mut touch = touched[like].clone();
            touch.spindle_rad += turn_rad;
            touched.push(touch);
            let last_s = columns[0][columns[0].len() - 1];
            columns[0].push(last_s + pace_s);
            let feed = columns[1][like] * feed_ratio;
            columns[1].push(feed);
            let temperature = columns[2][like] + warmer_k;
            columns[2].push(temperature);
        }
        let (found, expected) = (proposed(text), model(touched, columns));
        let (found, expected) = (tangents(&*found), tangents(&expected));
        assert_eq!(found.len(), expected.len(), "{text}");
        for ((effect, subject, found), (name, of, expected)) in found.iter().zip(&expected) {
            assert_eq!((effect, subject), (name, of), "{text}");
            let off = (found - expected).amax();
            assert!(off <= SAME_TOL * expected.amax(), "{text}, {effect}: {off:e}");
        }
    }
}

/// A standard is one row of prior knowledge for each amplitude that it tells, and for no other.
#[test]
fn a_standard_tells_the_amplitudes_that_it_measures() {
    let told = [
        ("measure the ball by itself", "tip-radius", 1),
        // Of each axis from the origin on, and from the middle of the part.
        ("measure the machine's travel", "axis-scale", 6),
        ("measure the machine's squareness", "squareness", 3),
        // Five harmonics of the second degree and seven of the third.
        ("measure the part's form", "form", 12),
    ];
    for (text, id, count) in told {
        let model = proposed(text);
        let declared = model.declared();
        let groups = &declared.layout.groups;
        let priors = groups.iter().filter(|group| group.role == Role::Prior).count();
        assert_eq!(priors, count, "{text}");
        assert_eq!(declared.layout.rows.len(), N + count, "{text}");
        for (effect, subject, tangent) in tangents(&*model) {
            for column in tangent.rows(N, count).column_iter() {
                let rows = column.iter().filter(|v| **v != 0.0).count();
                assert_eq!(rows, usize::from(effect == id), "{text}: {effect} {subject}");
            }
        }
    }
}
