//! Whether groups that the fit did not see are predicted as well as the noise allows.

use crate::levels::BADLY_PREDICTED;
use crate::levels::MIN_SCATTERING_CHECKS;
use crate::levels::MIN_SCATTERING_GROUPS;
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use crate::choice::context::Context;
use crate::choice::selected::Selected;
use crate::count::count;
use crate::noise::linear::Linear;
use crate::tests::hold_out::predict;
use crate::tests::tails::reaches;
use crate::{Remaining, Role, Row};

/// Check groups that lie farther from their prediction than the fitted groups do from theirs.
///
/// A raised patch that a few touches meet can pass for a bad reading among those that are fitted;
/// the touches that were set aside tell. The squared distance of all check rows, whitened with
/// noise and uncertainty of the prediction, is compared with that of fitted groups left out one by
/// one, or with the declared noise where that is larger (F test). A group counts as many readings
/// as the scatter of the groups shows (Satterthwaite 1946), at most those that it holds, so that
/// readings that depend on each other are not counted as if they did not. Where all of it is one
/// observation, it may be the tail of the noise.
pub(crate) fn badly_predicted(
    context: &Context<'_>,
    chosen: &Selected<'_>,
    lin: &Linear<'_>,
) -> Option<BadlyPredicted> {
    let fitted = fitted_scatter(lin)?;
    let check = check_distance(context, chosen, lin, &|row| chosen.estimate.sigma(row))?;
    let declared = if lin.layout.sigma_declared { 1.0 } else { 0.0 };
    let dof = |groups: f64| groups * fitted.readings;
    let p_value = |square: f64, rows: f64, groups: f64| {
        let law = FisherSnedecor::new(dof(groups), dof(fitted.groups)).ok()?;
        Some(law.sf(square / rows / fitted.variance.max(declared)))
    };
    let of_all = p_value(check.square, check.rows, check.groups)?;
    let Worst { name, square, rows, one } = &check.worst;
    let are_others_bad = {
        let (square, rows) = (check.square - square, check.rows - rows);
        let of_others = p_value(square.max(0.0), rows, check.groups - 1.0);
        rows > 0.0 && of_others.is_some_and(|p_value| p_value <= BADLY_PREDICTED)
    };
    let one = one.filter(|_| !are_others_bad);
    let may_be_a_tail = || one.is_some_and(|(_, farthest)| reaches(lin, farthest, check.rows));
    if of_all > BADLY_PREDICTED || may_be_a_tail() {
        return None;
    }
    let remaining = Remaining {
        covariate: CHECK_GROUPS.to_owned(),
        shape: format!("predicted worse than the noise allows, worst {name}"),
        p_value: of_all,
    };
    let may_be_alone = check.groups > MIN_SCATTERING_CHECKS;
    Some(BadlyPredicted { remaining, alone: one.filter(|_| may_be_alone).map(|(of, _)| of) })
}

/// What [`Remaining::covariate`] is of groups that were set aside.
const CHECK_GROUPS: &str = "check groups";

/// Check groups that are not predicted as well as the noise allows.
pub(crate) struct BadlyPredicted {
    pub(crate) remaining: Remaining,
    /// The one observation to which all of it is due, where the others are predicted as well as they should be.
    pub(crate) alone: Option<usize>,
}

/// How fitted groups scatter about what the others predict.
struct Scatter {
    groups: f64,
    /// Mean square per row, in units of sigma.
    variance: f64,
    /// Independent readings that a group is worth.
    readings: f64,
}

fn fitted_scatter(lin: &Linear<'_>) -> Option<Scatter> {
    let residual = lin.clean_residual();
    let of_group = |rows: &Vec<usize>| {
        let square = predict(&lin.basis, &residual, rows)?.dot(&residual.select_rows(rows));
        Some((square, count(rows.len())))
    };
    let groups: Vec<(f64, f64)> = lin.clusters.iter().filter_map(of_group).collect();
    if groups.len() < MIN_SCATTERING_GROUPS {
        return None;
    }
    let n = count(groups.len());
    let rows: f64 = groups.iter().map(|g| g.1).sum();
    let variance = groups.iter().map(|g| g.0).sum::<f64>() / rows;
    let between: f64 = groups.iter().map(|(square, n)| (square / n - variance).powi(2)).sum();
    let readings = (2.0 * variance * variance * (n - 1.0) / between).min(rows / n);
    (variance > 0.0).then_some(Scatter { groups: n, variance, readings })
}

/// How far check groups lie from their prediction.
pub(crate) struct Distance {
    groups: f64,
    pub(crate) rows: f64,
    /// Squared, in units of noise and uncertainty of the prediction.
    pub(crate) square: f64,
    worst: Worst,
}

/// The group that lies farthest.
struct Worst {
    name: String,
    /// Squared, in units of noise.
    square: f64,
    rows: f64,
    /// The one observation that it is, with how far its farthest row lies.
    one: Option<(usize, f64)>,
}

/// Distance of the check groups, with these standard uncertainties; `None` without such groups, or
/// where the fit does not determine what they need.
pub(crate) fn check_distance(
    context: &Context<'_>,
    chosen: &Selected<'_>,
    lin: &Linear<'_>,
    sigma: &dyn Fn(&Row) -> f64,
) -> Option<Distance> {
    let layout = lin.layout;
    let is_check: Vec<bool> = layout.groups.iter().map(|g| g.role == Role::Check).collect();
    let group = |row: usize| layout.observations[layout.rows[row].observation];
    let silent = |row: usize| context.silent.get(layout.rows[row].component) == Some(&true);
    let judged = |&row: &usize| is_check[group(row)] && !silent(row);
    let rows: Vec<usize> = (0..layout.rows.len()).filter(judged).collect();
    if rows.is_empty() {
        return None;
    }
    let (system, at) = (&chosen.system, &chosen.estimate);
    let all = system.residuals(at);
    let sigma = |row: usize| sigma(&layout.rows[row]);
    let error = DVector::from_fn(rows.len(), |i, _| all[rows[i]] / sigma(rows[i]));
    let jacobian = system.jacobian(at);
    let whitened = |rows: &[usize]| {
        DMatrix::from_fn(rows.len(), jacobian.ncols(), |i, j| {
            jacobian[(rows[i], j)] / sigma(rows[i])
        })
    };
    let square = squared_distance(whitened(&lin.rows), &whitened(&rows), &error)?;
    let mut of_group = vec![0.0; layout.groups.len()];
    for (&row, error) in rows.iter().zip(error.iter()) {
        of_group[group(row)] += error * error;
    }
    let worst = (0..of_group.len()).max_by(|&a, &b| of_group[a].total_cmp(&of_group[b]))?;
    let groups = (0..is_check.len()).filter(|&g| is_check[g] && of_group[g] > 0.0).count();
    let its_rows: Vec<usize> = (0..rows.len()).filter(|&i| group(rows[i]) == worst).collect();
    let observation = |&i: &usize| layout.rows[rows[i]].observation;
    let one = its_rows.first().map(observation);
    let one = one.filter(|one| its_rows.iter().all(|i| observation(i) == *one));
    let farthest = its_rows.iter().map(|&i| error[i].abs()).fold(0.0, f64::max);
    Some(Distance {
        groups: count(groups),
        rows: count(rows.len()),
        square,
        worst: Worst {
            name: layout.groups[worst].name.clone(),
            square: of_group[worst],
            rows: count(its_rows.len()),
            one: one.map(|one| (one, farthest)),
        },
    })
}

/// `eᵀ(I + J(JₒᵀJₒ)⁻¹Jᵀ)⁻¹e` of the errors `e` of rows with Jacobian `J`, predicted from a fit with
/// Jacobian `Jₒ`; `None` where that fit does not determine all of it.
fn squared_distance(
    fitted: DMatrix<f64>,
    predicted: &DMatrix<f64>,
    error: &DVector<f64>,
) -> Option<f64> {
    let p = fitted.ncols();
    if p == 0 {
        return Some(error.norm_squared());
    }
    if fitted.nrows() < p {
        return None;
    }
    let r = fitted.qr().r();
    let spread = r.tr_solve_upper_triangular(&predicted.transpose())?;
    let along = &spread * error;
    let inner = DMatrix::identity(p, p) + &spread * spread.transpose();
    let square = error.norm_squared() - along.dot(&inner.cholesky()?.solve(&along));
    square.is_finite().then_some(square)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Round-off of products of numbers near ten.
    const ROUND_OFF: f64 = 1e-12;

    #[test]
    fn distance_is_that_of_the_covariance_of_a_prediction() {
        let fitted = DMatrix::from_fn(7, 2, |i, j| if j == 0 { 1.0 } else { 0.3 * count(i) - 1.0 });
        let predicted = DMatrix::from_row_slice(3, 2, &[1.0, 4.0, 1.0, -2.0, 1.0, 0.5]);
        let error = DVector::from_column_slice(&[2.0, -1.0, 0.7]);
        let inverse = (fitted.transpose() * &fitted).try_inverse().expect("a line through seven");
        let covariance = DMatrix::identity(3, 3) + &predicted * inverse * predicted.transpose();
        let exact = error.dot(&(covariance.try_inverse().expect("positive definite") * &error));
        let square = squared_distance(fitted, &predicted, &error).expect("determined");
        assert!((square - exact).abs() < ROUND_OFF, "{square} {exact}");
    }

    #[test]
    fn what_the_fit_does_not_determine_has_no_distance() {
        let fitted = DMatrix::from_fn(5, 2, |_, j| count(1 - j));
        let predicted = DMatrix::from_element(1, 2, 1.0);
        assert_eq!(squared_distance(fitted, &predicted, &DVector::zeros(1)), None);
    }
}
