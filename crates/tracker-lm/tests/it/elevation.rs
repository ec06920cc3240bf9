//! What eight targets on two mirrors can decide, target by target (`fixtures/tracker-lm/measured-elevation-targets`).
//!
//! Calculated from the points alone, with nothing of the crate: a target that is left out is predicted
//! from the rigid motion of the others of its body.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Vector3};

/// Half of α = 0.05, what all single effects share.
const LEVEL: f64 = 0.025;
/// Rounds in which the shape of a body settles; the second changes it by nanometres.
const ROUNDS: usize = 4;

type Place = Vector3<f64>;

/// Places by target at the stops where all were seen.
fn places() -> Vec<Vec<Place>> {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../fixtures/tracker-lm/measured-elevation-targets/targets.csv"
    );
    let text = std::fs::read_to_string(path).unwrap();
    let mut by_step: BTreeMap<String, BTreeMap<String, Place>> = BTreeMap::new();
    for line in text.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |i: usize| cells[i].parse::<f64>().unwrap();
        let place = Vector3::new(number(5), number(6), number(7));
        by_step.entry(cells[2].to_owned()).or_default().insert(cells[1].to_owned(), place);
    }
    // Names in order: four of M1, then four of M2.
    let all: Vec<Vec<Place>> =
        by_step.values().filter(|t| t.len() == 8).map(|t| t.values().copied().collect()).collect();
    assert_eq!(all.len(), 14);
    all
}

/// Rotation and centroids that take one set of points onto another (Kabsch 1976).
fn rigid(from: &[Place], to: &[Place]) -> (Matrix3<f64>, Place, Place) {
    let mean = |of: &[Place]| of.iter().sum::<Place>() / of.len() as f64;
    let (a, b) = (mean(from), mean(to));
    let spread: Matrix3<f64> =
        from.iter().zip(to).map(|(p, q)| (q - b) * (p - a).transpose()).sum();
    let svd = spread.svd(true, true);
    let (u, v_t) = (svd.u.unwrap(), svd.v_t.unwrap());
    let mirror = Vector3::new(1.0, 1.0, (u * v_t).determinant().signum());
    (u * Matrix3::from_diagonal(&mirror) * v_t, a, b)
}

/// Mean square of what a target is off where the others of its body say it is, about its own mean.
fn square_of(target: usize, body: &[usize], places: &[Vec<Place>]) -> f64 {
    let others: Vec<usize> = body.iter().copied().filter(|&i| i != target).collect();
    let at = |stop: &Vec<Place>| others.iter().map(|&i| stop[i]).collect::<Vec<_>>();
    let mut shape = at(&places[0]);
    for _ in 0..ROUNDS {
        let mut sum = vec![Vector3::zeros(); others.len()];
        for stop in places {
            let (turn, from, to) = rigid(&shape, &at(stop));
            for (sum, place) in sum.iter_mut().zip(at(stop)) {
                *sum += turn.tr_mul(&(place - to)) + from;
            }
        }
        shape = sum.into_iter().map(|s| s / places.len() as f64).collect();
    }
    let seen: Vec<Place> = places
        .iter()
        .map(|stop| {
            let (turn, from, to) = rigid(&shape, &at(stop));
            turn.tr_mul(&(stop[target] - to)) + from
        })
        .collect();
    let mean = seen.iter().sum::<Place>() / seen.len() as f64;
    seen.iter().map(|s| (s - mean).norm_squared()).sum::<f64>() / (seen.len() - 1) as f64
}

fn rms_mm(bodies: &[Vec<usize>], places: &[Vec<Place>]) -> f64 {
    let square = |body: &Vec<usize>| body.iter().map(|&t| square_of(t, body, places)).sum::<f64>();
    (bodies.iter().map(square).sum::<f64>() / 8.0).sqrt()
}

/// Whoever divides the eight targets into two fours has 35 ways. That into the two mirrors is the best of
/// all, by far: but the best of 35 has a chance of one in 35, which is more than the level of all single
/// effects together, whatever the data are. So target by target nothing can be named; stop by stop, where
/// there are twenty groups, the loop names the second mirror's sag and tilt.
#[test]
fn eight_targets_cannot_confirm_two_bodies() {
    let places = places();
    let one = rms_mm(&[(0..8).collect()], &places);
    let mut all: Vec<(f64, u8)> = (0..128_u8)
        .filter(|mask| mask.count_ones() == 4)
        .map(|mask| {
            let is_in = |first: bool| {
                (0..8).filter(|&i| ((mask >> i) & 1 == 1) == first).collect::<Vec<usize>>()
            };
            (rms_mm(&[is_in(true), is_in(false)], &places), mask)
        })
        .collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert_eq!(all.len(), 35);
    let (mirrors, mask) = all[0];
    assert_eq!(mask, 0b1111, "{all:?}");
    assert!(mirrors < 0.5 * one && mirrors < 0.5 * all[1].0, "{mirrors} {one} {:?}", all[1]);
    let best_possible = 1.0 / all.len() as f64;
    assert!(best_possible > LEVEL);
}
