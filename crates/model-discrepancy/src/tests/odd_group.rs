//! A single group that does not lie where all the others do, or scatters otherwise.

use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::Remaining;
use crate::count::count;
use crate::levels::ODD_GROUP;
use crate::noise::linear::Linear;
use crate::tests::groups_apart::GROUP;

/// Fewest groups that show how far groups differ.
const MIN_GROUPS: usize = 4;

/// Fewest readings of a component in a group whose mean is near normal, whatever their own law.
const MIN_READINGS: usize = 4;

/// Groups of several readings whose mean lies farther off than those of the others allow.
///
/// The mean residual of each group is compared with those of all other groups (Student's t with
/// the group itself left out of their scatter), so that nothing need be known of the memory that
/// the noise has within a group. The worst group is named.
pub(crate) fn odd_groups(lin: &Linear<'_>) -> Option<Remaining> {
    let residual = lin.clean_residual();
    if lin.clusters.len() < MIN_GROUPS {
        return None;
    }
    let components = lin.rows.iter().map(|&row| lin.layout.rows[row].component + 1).max()?;
    let mut worst: Option<(f64, usize)> = None;
    let mut looked_at = 0;
    for component in 0..components {
        let of = |i: &&usize| {
            let row = &lin.layout.rows[lin.rows[**i]];
            row.reported && row.component == component
        };
        let mean = |cluster: &Vec<usize>| {
            let values: Vec<f64> = cluster.iter().filter(of).map(|&i| residual[i]).collect();
            let n = count(values.len());
            (values.len() >= MIN_READINGS).then(|| values.iter().sum::<f64>() / n)
        };
        let mut sizes: Vec<usize> =
            lin.clusters.iter().map(|rows| rows.iter().filter(of).count()).collect();
        let size_of = sizes.clone();
        sizes.sort_unstable();
        let usual = sizes[sizes.len() / 2];
        // The mean of a much smaller group scatters more than those of the others show.
        let alike = |cluster: usize| 2 * size_of[cluster] >= usual;
        let means: Vec<(usize, f64)> = (lin.clusters.iter().enumerate())
            .filter(|(cluster, _)| alike(*cluster))
            .filter_map(|(cluster, rows)| Some((cluster, mean(rows)?)))
            .collect();
        if means.len() < MIN_GROUPS {
            continue;
        }
        looked_at += means.len();
        for &(cluster, own) in &means {
            let p_value = apart(own, &others(&means, cluster));
            if worst.is_none_or(|(least, _)| p_value < least) {
                worst = Some((p_value, cluster));
            }
        }
    }
    let (p_value, cluster) = worst?;
    let p_value = (p_value * count(looked_at)).min(1.0);
    let name = &lin.layout.groups[lin.cluster_groups[cluster]].name;
    (p_value <= ODD_GROUP).then(|| Remaining {
        covariate: GROUP.to_owned(),
        shape: format!("{name} lies apart from all the others"),
        p_value,
    })
}

/// A group that scatters more than those of the others allow: its root mean square, as a logarithm, is compared
/// with those of all other groups, as [`odd_groups`] does with means.
///
/// Noise is larger everywhere, or grows with something; what is wrong in one group is not noise.
pub(crate) fn odd_scatter(lin: &Linear<'_>) -> Option<Remaining> {
    let residual = lin.clean_residual();
    let square = |i: &usize| lin.layout.rows[lin.rows[*i]].reported.then(|| residual[*i].powi(2));
    let scatter = |(cluster, rows): (usize, &Vec<usize>)| {
        let squares: Vec<f64> = rows.iter().filter_map(square).collect();
        let mean = squares.iter().sum::<f64>() / count(squares.len());
        (squares.len() >= MIN_READINGS && mean > 0.0).then(|| (cluster, 0.5 * mean.ln()))
    };
    let all: Vec<(usize, f64)> = lin.clusters.iter().enumerate().filter_map(scatter).collect();
    let &(cluster, most) = all.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let others = others(&all, cluster);
    if all.len() < MIN_GROUPS {
        return None;
    }
    let p_value = (apart(most, &others) * count(all.len())).min(1.0);
    let usual = others.iter().sum::<f64>() / count(others.len());
    let name = &lin.layout.groups[lin.cluster_groups[cluster]].name;
    (p_value <= ODD_GROUP).then(|| Remaining {
        covariate: GROUP.to_owned(),
        shape: format!("{name} scatters {:.1} times as much as the others", (most - usual).exp()),
        p_value,
    })
}

/// Values of all groups but one.
fn others(of_groups: &[(usize, f64)], but: usize) -> Vec<f64> {
    of_groups.iter().filter(|(group, _)| *group != but).map(|(_, value)| *value).collect()
}

/// Significance of one value beside others.
fn apart(own: f64, others: &[f64]) -> f64 {
    let n = count(others.len());
    let mean = others.iter().sum::<f64>() / n;
    let variance = others.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let spread = (variance * (1.0 + 1.0 / n)).sqrt();
    let Ok(law) = StudentsT::new(0.0, 1.0, n - 1.0) else { return 1.0 };
    if spread > 0.0 { 2.0 * law.sf(((own - mean) / spread).abs()) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

    use super::{apart, odd_scatter};
    use crate::algebra::basis::Basis;
    use crate::algebra::linearised::Linearised;
    use crate::count::count;
    use crate::noise::linear::Linear;
    use crate::{Group, Layout, Role, Row};

    #[test]
    fn one_value_apart_is_significant_and_one_among_others_is_not() {
        let others = [0.1, -0.2, 0.0, 0.15, -0.05, 0.02, -0.1];
        assert!(apart(1.5, &others) < 1e-4);
        assert!(apart(0.2, &others) > 0.05);
    }

    #[test]
    fn a_group_that_scatters_more_is_named_and_groups_that_grow_are_not() {
        const GROUPS: usize = 6;
        const READINGS: usize = 20;
        let row =
            |observation: usize| Row { observation, component: 0, sigma: 1.0, reported: true };
        let layout = Layout {
            rows: (0..GROUPS * READINGS).map(row).collect(),
            observations: (0..GROUPS * READINGS).map(|i| i / READINGS).collect(),
            groups: (0..GROUPS).map(|i| Group { name: format!("s{i}"), role: Role::Fit }).collect(),
            unit: "N".to_owned(),
            sigma_declared: true,
        };
        let of = |scatter: &dyn Fn(usize) -> f64| {
            let wave = |i: usize| scatter(i / READINGS) * (0.7 * count(i * i)).sin();
            let residual = DVector::from_fn(GROUPS * READINGS, |i, _| wave(i));
            let clusters =
                (0..GROUPS).map(|g| (READINGS * g..READINGS * (g + 1)).collect()).collect();
            let basis = Basis::empty(GROUPS * READINGS);
            let lin = Linear::from(Linearised::of_parts(&layout, residual, basis, clusters));
            odd_scatter(&lin).map(|remaining| remaining.shape)
        };
        let one = of(&|group| if group == 3 { 20.0 } else { 2.0 });
        assert!(one.is_some_and(|shape| shape.starts_with("s3 scatters")));
        assert_eq!(of(&|_| 5.0), None);
        assert_eq!(of(&|group| 2.0 + count(group)), None);
    }
}
