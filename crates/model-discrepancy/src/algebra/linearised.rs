//! A fitted system, linearised and whitened: what every test of a candidate looks at.

use crate::algebra::basis::NEW_DIRECTION;
use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector, Vector3};

use super::components::{added, reported_components};
use crate::algebra::basis::Basis;
use crate::algebra::system::{Estimate, System, rows_of, whitened};
use crate::{Layout, Projected, Role};

/// Whitened residual and tangents on the rows that take part in inference.
#[derive(Clone)]
pub(crate) struct Linearised<'a> {
    pub(crate) layout: &'a Layout,
    /// Row numbers in the layout.
    pub(crate) rows: Vec<usize>,
    /// Standard uncertainty of each, common scatter included.
    pub(crate) sigma: Vec<f64>,
    /// Whether these uncertainties are the declared ones, without any scatter that the data showed.
    pub(crate) is_as_declared: bool,
    /// Their square over that of the declared ones, where it is the same for all.
    pub(crate) over_declared: Option<f64>,
    /// Components of an observation of which any is reported.
    components: usize,
    /// Whitened residual of the fitted system, with its places corrected.
    pub(crate) residual: DVector<f64>,
    /// Span of the system's whitened Jacobian, with the places at which its effects were found.
    pub(crate) basis: Basis,
    /// Positions in `rows` of each fitted group, in measured order; empty groups left out.
    pub(crate) clusters: Vec<Vec<usize>>,
    /// Layout group of each cluster.
    pub(crate) cluster_groups: Vec<usize>,
    /// Positions in `rows` of each component of each record, in measured order.
    pub(crate) series: Vec<Vec<usize>>,
    /// Whether the model says that a record runs on from group to group.
    pub(crate) runs_on: bool,
    /// Rows that are combinations of several readings.
    pub(crate) projected: &'a [Projected],
    /// The record of each observation, where the model says so.
    pub(crate) records: Option<&'a [usize]>,
    /// Along what each of `rows` reads a displacement, where the model says so.
    pub(crate) directions: Option<Vec<Vector3<f64>>>,
}

/// Share by which values may differ that are one: round-off of a square and a root.
const SAME: f64 = 1e-12;

/// The value that all of these are.
fn one_of_all(mut values: impl Iterator<Item = f64>) -> Option<f64> {
    let first = values.next()?;
    values.all(|value| (value - first).abs() <= SAME * first).then_some(first)
}

impl<'a> Linearised<'a> {
    /// Linearises `system` at `at`, on the groups of `keep`, without the `silent` components.
    pub(crate) fn of(system: &System<'a>, at: &Estimate, keep: &[bool], silent: &[bool]) -> Self {
        Self::about(system, at, keep, silent, &system.jacobian_with_places(at))
    }

    /// The same with places and time constants held as they were found.
    pub(crate) fn of_found(
        system: &System<'a>,
        at: &Estimate,
        keep: &[bool],
        silent: &[bool],
    ) -> Self {
        Self::about(system, at, keep, silent, &system.jacobian(at))
    }

    fn about(
        system: &System<'a>,
        at: &Estimate,
        keep: &[bool],
        silent: &[bool],
        jacobian: &DMatrix<f64>,
    ) -> Self {
        let layout = &system.model.declared().layout;
        let rows: Vec<_> = rows_of(layout, keep)
            .into_iter()
            .filter(|&row| !silent.get(layout.rows[row].component).copied().unwrap_or(false))
            .collect();
        let all = system.residuals(at);
        let sigma: Vec<_> = rows.iter().map(|&row| at.sigma(&layout.rows[row])).collect();
        let over = rows.iter().zip(&sigma).map(|(&row, s)| (s / layout.rows[row].sigma).powi(2));
        let over_declared = layout.sigma_declared.then(|| one_of_all(over)).flatten();
        let mut residual = DVector::from_fn(rows.len(), |i, _| all[rows[i]] / sigma[i]);
        let jacobian = whitened(layout, at, &rows, jacobian);
        let basis = Basis::of(&jacobian, NEW_DIRECTION);
        if jacobian.ncols() > system.dim() {
            // Places are no part of a state: their corrections are taken here.
            residual = basis.reject(&residual);
        }
        let (clusters, cluster_groups) = clusters(layout, &rows);
        let declared = system.model.declared();
        let records = declared.records.as_deref();
        let readings = rows.iter().map(|&row| {
            let row = &layout.rows[row];
            (row.observation, row.component)
        });
        let series = series(layout, records, readings);
        let runs_on = records.is_some_and(|records| runs_on(layout, records));
        let along = |all: &[Vector3<f64>]| {
            rows.iter().map(|&row| all[layout.rows[row].observation]).collect()
        };
        let directions = declared.directions.as_deref().map(along);
        Self {
            layout,
            rows,
            sigma,
            is_as_declared: layout.sigma_declared && at.between_variance <= 0.0,
            over_declared,
            components: reported_components(layout),
            residual,
            basis,
            clusters,
            cluster_groups,
            series,
            runs_on,
            projected: &declared.projected,
            records,
            directions,
        }
    }

    #[cfg(test)]
    pub(crate) fn of_parts(
        layout: &'a Layout,
        residual: DVector<f64>,
        basis: Basis,
        clusters: Vec<Vec<usize>>,
    ) -> Self {
        let n = residual.len();
        Self {
            layout,
            rows: (0..n).collect(),
            sigma: vec![1.0; n],
            is_as_declared: layout.sigma_declared,
            over_declared: layout.sigma_declared.then_some(1.0),
            components: reported_components(layout),
            residual,
            basis,
            cluster_groups: (0..clusters.len()).collect(),
            clusters,
            series: vec![(0..n).collect()],
            runs_on: false,
            projected: &[],
            records: None,
            directions: None,
        }
    }

    /// Whitened rows of a tangent given for all rows of the layout.
    pub(crate) fn tangent(&self, all: &DMatrix<f64>) -> DMatrix<f64> {
        let mut out = all.select_rows(&self.rows);
        for (mut row, sigma) in out.row_iter_mut().zip(&self.sigma) {
            row.unscale_mut(*sigma);
        }
        out
    }

    /// What every reported component that follows `values`, one per observation, adds to the
    /// whitened residual, component by component.
    pub(crate) fn followed(&self, values: &[f64]) -> Vec<DVector<f64>> {
        let whitened = |component, i: usize| {
            added(&self.layout.rows[self.rows[i]], component, values) / self.sigma[i]
        };
        (0..self.components)
            .map(|component| DVector::from_fn(self.rows.len(), |i, _| whitened(component, i)))
            .collect()
    }

    /// Residual with what the basis explains taken out (none is left after a converged fit).
    pub(crate) fn clean_residual(&self) -> DVector<f64> {
        self.basis.reject(&self.residual)
    }
}

fn clusters(layout: &Layout, rows: &[usize]) -> (Vec<Vec<usize>>, Vec<usize>) {
    let mut by_group = vec![Vec::new(); layout.groups.len()];
    for (i, &row) in rows.iter().enumerate() {
        let group = layout.observations[layout.rows[row].observation];
        if layout.groups[group].role == Role::Fit {
            by_group[group].push(i);
        }
    }
    by_group.into_iter().enumerate().filter(|(_, c)| !c.is_empty()).map(|(g, c)| (c, g)).unzip()
}

/// Whether any record has observations in more than one group.
fn runs_on(layout: &Layout, records: &[usize]) -> bool {
    let mut first: BTreeMap<usize, usize> = BTreeMap::new();
    let mut pairs = records.iter().zip(&layout.observations);
    pairs.any(|(&record, &group)| *first.entry(record).or_insert(group) != group)
}

/// Positions of readings, given by observation and component, of each component of each record, in
/// measured order; of the groups that are fitted.
pub(crate) fn series(
    layout: &Layout,
    records: Option<&[usize]>,
    readings: impl Iterator<Item = (usize, usize)>,
) -> Vec<Vec<usize>> {
    let mut series: BTreeMap<(usize, usize), Vec<(usize, usize)>> = BTreeMap::new();
    for (i, (observation, component)) in readings.enumerate() {
        if layout.groups[layout.observations[observation]].role == Role::Fit {
            let record = records.map_or(0, |records| records[observation]);
            series.entry((record, component)).or_default().push((observation, i));
        }
    }
    let in_order = |mut one: Vec<(usize, usize)>| {
        one.sort_unstable();
        one.into_iter().map(|(_, i)| i).collect()
    };
    series.into_values().map(in_order).collect()
}

/// Whether groups are runs of samples on the whole: readings that follow each other are of one group.
///
/// Places that are visited again are groups of several readings too, but of no run.
pub(crate) fn groups_are_runs(lin: &Linearised<'_>) -> bool {
    let longest = lin.series.iter().map(Vec::len).max().unwrap_or(0);
    longest > 2 * lin.clusters.len() && follow_within(lin)
}

/// Whether most readings are followed by one of their own group.
fn follow_within(lin: &Linearised<'_>) -> bool {
    let mut group = vec![None; lin.residual.len()];
    for (g, cluster) in lin.clusters.iter().enumerate() {
        for &i in cluster {
            group[i] = Some(g);
        }
    }
    let pairs = || lin.series.iter().flat_map(|one| one.windows(2));
    let within = pairs().filter(|pair| group[pair[0]] == group[pair[1]]).count();
    2 * within > pairs().count()
}
