//! What a report and an error say.

use least_squares::{Options, SolveError, solve};
use nalgebra::DVector;

use crate::problems::{Written, line};

#[test]
fn a_report_fits_in_three_lines() {
    let points = [(0.0, 1.0), (1.0, 3.1), (2.0, 4.9)];
    let fit = solve(&line(&points), DVector::zeros(2), &Options::default()).unwrap();
    let text = fit.report.to_string();
    assert_eq!(text.lines().count(), 3, "{text}");
    assert!(text.starts_with("converged (gradient) after "), "{text}");
    assert!(text.contains(" in 1 search,"), "{text}");
    assert!(text.ends_with("rank 2 of 2, condition 2.8e0, 3 of 3 residuals used"), "{text}");
    let costs = (fit.report.initial_cost, fit.report.final_cost);
    assert_eq!(costs.0, 0.5 * (1.0 + 3.1 * 3.1 + 4.9 * 4.9));
    assert_eq!(costs.1, 0.5 * fit.residuals.norm_squared());
}

/// A shift and a rotation about a far centre do the same to one point.
#[test]
fn a_free_direction_is_named_with_its_largest_components() {
    let problem = Written::new(&["tx [mm]", "ty [mm]", "ry [rad]"], 4, |p| {
        let lever = 500.0;
        let seen = p[0] + p[2] * lever;
        vec![seen - 1.0, seen - 1.1, p[1] - 2.0, p[1] - 2.1]
    });
    let error = solve(&problem, DVector::zeros(3), &Options::default()).unwrap_err();
    let SolveError::Unobservable { directions, best, report } = &error else { panic!("{error}") };
    assert_eq!(report.rank, 2);
    assert!((best[1] - 2.05).abs() < 1e-12);
    let text = error.to_string();
    let either = ["1.00·tx [mm] − 1.00·ry [rad]", "1.00·ry [rad] − 1.00·tx [mm]"];
    assert!(either.iter().any(|named| text.contains(named)), "{text}");
    assert!(text.starts_with("the data leave 1 of 3 directions free: "), "{text}");
    // As a step: 500 mm against 1 rad, and nothing of the rest.
    let step = &directions[0].step;
    assert!((step[0] / step[2] + 500.0).abs() < 1e-9);
    assert!(step[1].abs() < 1e-9 * step[0].abs());
}

/// Two independent freedoms come out apart, not as two mixtures.
#[test]
fn independent_free_directions_are_told_apart() {
    let problem = Written::new(&["a", "b", "c", "d", "e"], 3, |p| {
        vec![p[0] + p[1] - 1.0, p[2] + p[3] - 2.0, p[4] - 3.0]
    });
    let error = solve(&problem, DVector::zeros(5), &Options::default()).unwrap_err();
    let SolveError::Unobservable { directions, .. } = &error else { panic!("{error}") };
    let mut named: Vec<Vec<&str>> = directions
        .iter()
        .map(|d| {
            let mut names: Vec<&str> = d.components.iter().map(|(n, _)| n.as_str()).collect();
            names.sort_unstable();
            names
        })
        .collect();
    named.sort();
    assert_eq!(named, [["a", "b"], ["c", "d"]]);
}
