//! Lack of fit: do readings of one place agree with each other better than with the model?

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{DMatrix, DVector};

use crate::algebra::f_tail::f_tail;
use crate::algebra::silent::silent_components;
use crate::algebra::system::{System, rows_of};
use crate::count::count;
use crate::levels::LACK_OF_FIT;
use crate::model::validate::validate;
use crate::noise::linear::Linear;
use crate::noise::reach::Memory;
use crate::{Covariate, LoopError, Model, Origin, Quantity, Remaining, Role};

/// Column that says which way a place was come to: from either side it is a place of its own.
const DIRECTION: &str = "direction";

/// Fewest further visits that show how far visits to one place differ.
const MIN_REPEATS: usize = 4;

/// Standard deviations of white noise beyond which an even drift is taken off.
const CLEAR: f64 = 6.0;

/// The test of lack of fit.
#[derive(Clone, Debug, PartialEq)]
pub struct LackOfFit {
    /// Probability of so much agreement among repeats by chance.
    pub p_value: f64,
    /// Places that are visited more than once.
    pub levels: usize,
    /// Visits to them beyond the first.
    pub repeats: usize,
    /// The coordinates that make a place.
    pub along: Vec<String>,
}

impl LackOfFit {
    /// Whether what repeats is no noise.
    #[must_use]
    pub fn is_significant(&self) -> bool {
        self.p_value <= LACK_OF_FIT
    }

    pub(crate) fn remaining(&self) -> Option<Remaining> {
        self.is_significant().then(|| Remaining {
            covariate: self.along.join(", "),
            shape: "repeats agree: a value of its own at each place".to_owned(),
            p_value: self.p_value,
        })
    }
}

/// The test of lack of fit of the declared model; `None` where no place is visited again.
///
/// # Errors
///
/// As [`close_loop`](crate::close_loop): those of bad input always, the others where a place is
/// visited again.
pub fn lack_of_fit(
    model: &dyn Model,
    covariates: &[Covariate],
) -> Result<Option<LackOfFit>, LoopError> {
    validate(model, covariates)?;
    let Some(places) = Places::of(model, covariates) else { return Ok(None) };
    let keep: Vec<bool> =
        model.declared().layout.groups.iter().map(|g| g.role == Role::Fit).collect();
    let declared = System::declared(model);
    let rows = rows_of(&model.declared().layout, &keep);
    let at = declared.fit_first(&rows).map_err(LoopError::declared)?;
    let silent = silent_components(&declared, &at, &rows);
    Ok(places.test(&Linear::of(&declared, &at, &keep, &silent)))
}

/// Observations that share every coordinate.
pub(crate) struct Places {
    along: Vec<String>,
    /// One per observation.
    of_observation: Vec<usize>,
}

impl Places {
    /// Places of the fitted observations; `None` where too few are visited again.
    pub(crate) fn of(model: &dyn Model, covariates: &[Covariate]) -> Option<Self> {
        let layout = &model.declared().layout;
        let coordinates: Vec<&Covariate> = (covariates.iter())
            .filter(|c| {
                c.origin == Origin::Coordinate && c.quantity != Quantity::Order
                    || c.name == DIRECTION
            })
            .filter(|c| c.values.len() == layout.observations.len())
            .collect();
        let fitted = |o: &usize| layout.groups[layout.observations[*o]].role == Role::Fit;
        let varies = |c: &&&Covariate| c.values.iter().any(|v| v.total_cmp(&c.values[0]).is_ne());
        let along = coordinates.iter().filter(varies).map(|c| c.name.clone()).collect::<Vec<_>>();
        if along.is_empty() {
            return None;
        }
        let of_observation = match &model.declared().places {
            Some(places) if places.len() == layout.observations.len() => places.clone(),
            Some(_) => return None,
            None => shared(&coordinates, layout.observations.len()),
        };
        let n_fitted = (0..layout.observations.len()).filter(fitted).count();
        let seen: BTreeSet<usize> =
            (0..layout.observations.len()).filter(fitted).map(|o| of_observation[o]).collect();
        (n_fitted >= seen.len() + MIN_REPEATS).then_some(Self { along, of_observation })
    }

    /// Mean square of the places' means against that of visits about these (F test).
    ///
    /// Readings of one place that follow each other within the reach of the noise's memory are one
    /// visit: they share whatever changes slowly, and say little of how far visits differ. The
    /// memory is judged by readings about the mean of their place, where nothing that repeats is
    /// left; degrees of freedom count by the share that is independent (Satterthwaite 1946).
    pub(crate) fn test(&self, lin: &Linear<'_>) -> Option<LackOfFit> {
        let q = lin.basis.matrix();
        let residual = self.without_drift(lin, &q)?;
        let memory = Memory::of(&self.compare(lin, &residual, &q, 1)?.about);
        let found = self.compare(lin, &residual, &q, memory.reach)?;
        let ratio = found.between / found.free_between / (found.within / found.free_within);
        let [one, other] = [found.free_between, found.free_within].map(|free| free * memory.share);
        Some(LackOfFit {
            p_value: f_tail(ratio, one, other),
            levels: found.levels,
            repeats: found.repeats,
            along: self.along.clone(),
        })
    }

    /// The residual without an even drift of each series, as the readings of one place show it by themselves, where
    /// it is clear: what drifts would pass for memory, and hide what repeats.
    fn without_drift(&self, lin: &Linear<'_>, q: &DMatrix<f64>) -> Option<DVector<f64>> {
        let mut residual = lin.clean_residual();
        let mut order = DVector::zeros(residual.len());
        for (at, &i) in lin.series.iter().flat_map(|series| series.iter().enumerate()) {
            order[i] = count(at) / lin.sigma[i];
        }
        let about = self.compare(lin, &residual, q, 1)?.about;
        let order_about = self.compare(lin, &order, q, 1)?.about;
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for ((series, about), order_about) in lin.series.iter().zip(&about).zip(&order_about) {
            let (square, along) = (dot(order_about, order_about), dot(about, order_about));
            let rest = dot(about, about) - along * along / square;
            let is_clear = along * along / square * count(about.len()) > CLEAR * CLEAR * rest;
            let drift = if square > 0.0 && is_clear { along / square } else { 0.0 };
            for &i in series {
                residual[i] -= drift * order[i];
            }
        }
        Some(residual)
    }

    /// Places against visits, readings of a place within `reach` of each other being one visit;
    /// `None` where too little repeats.
    fn compare(
        &self,
        lin: &Linear<'_>,
        residual: &DVector<f64>,
        q: &DMatrix<f64>,
        reach: usize,
    ) -> Option<Comparison> {
        let mut places: BTreeMap<(usize, usize), Vec<Visit>> = BTreeMap::new();
        for one in &lin.series {
            for visit in self.visits(lin, one, reach) {
                places.entry((visit.component, visit.place)).or_default().push(visit);
            }
        }
        places.retain(|_, visits| visits.len() > 1);
        let (mut between, mut within, mut free_between, mut free_within) = (0.0, 0.0, 0.0, 0.0);
        let mut about = vec![0.0; residual.len()];
        let mut repeats: BTreeMap<usize, usize> = BTreeMap::new();
        for ((component, _), visits) in &places {
            let rows: Vec<(usize, f64)> =
                visits.iter().flat_map(|v| v.rows.iter().copied()).collect();
            let whole = Mean::of(&rows, residual, q);
            between += whole.along * whole.along;
            free_between += 1.0 - whole.absorbed;
            for visit in visits {
                let one = Mean::of(&visit.rows, residual, q);
                within += one.along * one.along;
                free_within += 1.0 - one.absorbed;
            }
            let mean = whole.along / whole.weight.sqrt();
            for (i, weight) in rows {
                about[i] = residual[i] - mean * weight;
            }
            *repeats.entry(*component).or_insert(0) += visits.len() - 1;
        }
        within -= between;
        free_within -= free_between;
        let levels = places.keys().map(|(_, place)| *place).collect::<BTreeSet<_>>().len();
        let repeats = repeats.into_values().max().unwrap_or(0);
        if repeats < MIN_REPEATS || free_between < 1.0 || free_within < 1.0 || within <= 0.0 {
            return None;
        }
        let about = lin.series.iter().map(|one| one.iter().map(|&i| about[i]).collect()).collect();
        Some(Comparison { between, within, free_between, free_within, about, levels, repeats })
    }

    /// The visits of one component of one record, in measured order.
    fn visits(&self, lin: &Linear<'_>, series: &[usize], reach: usize) -> Vec<Visit> {
        let mut visits: Vec<Visit> = Vec::new();
        // Of each place: its last visit, and when that was.
        let mut last: BTreeMap<usize, (usize, usize)> = BTreeMap::new();
        for (at, &i) in series.iter().enumerate() {
            let row = &lin.layout.rows[lin.rows[i]];
            if !row.reported {
                continue;
            }
            let place = self.of_observation[row.observation];
            let one = (i, 1.0 / lin.sigma[i]);
            match last.get(&place) {
                Some(&(visit, before)) if at - before <= reach => {
                    visits[visit].rows.push(one);
                    last.insert(place, (visit, at));
                }
                _ => {
                    last.insert(place, (visits.len(), at));
                    visits.push(Visit { place, component: row.component, rows: vec![one] });
                }
            }
        }
        visits
    }
}

/// Places against visits.
struct Comparison {
    between: f64,
    within: f64,
    free_between: f64,
    free_within: f64,
    /// Whitened residuals about the means of their places, series by series; zero where a place
    /// does not repeat.
    about: Vec<Vec<f64>>,
    levels: usize,
    repeats: usize,
}

/// Number of each combination of coordinates, one per observation.
fn shared(coordinates: &[&Covariate], observations: usize) -> Vec<usize> {
    let mut known: BTreeMap<Vec<u64>, usize> = BTreeMap::new();
    // Adding zero makes −0 the same place as 0.
    let key = |o: usize| coordinates.iter().map(|c| (c.values[o] + 0.0).to_bits()).collect();
    let mut number = |o: usize| {
        let next = known.len();
        *known.entry(key(o)).or_insert(next)
    };
    (0..observations).map(&mut number).collect()
}

/// Successive readings of one place.
struct Visit {
    place: usize,
    component: usize,
    /// Positions in the rows of the linearised system, and `1/σ` of each.
    rows: Vec<(usize, f64)>,
}

/// A weighted mean of whitened residuals.
struct Mean {
    /// The mean over its standard uncertainty.
    along: f64,
    /// Sum of `1/σ²`.
    weight: f64,
    /// Share of it that the fitted parameters follow.
    absorbed: f64,
}

impl Mean {
    fn of(rows: &[(usize, f64)], residual: &DVector<f64>, q: &DMatrix<f64>) -> Self {
        let weight: f64 = rows.iter().map(|(_, w)| w * w).sum();
        let root = weight.sqrt();
        let along = rows.iter().map(|&(i, w)| w * residual[i]).sum::<f64>() / root;
        let share =
            |column: usize| rows.iter().map(|&(i, w)| w * q[(i, column)]).sum::<f64>() / root;
        let absorbed = (0..q.ncols()).map(|c| share(c).powi(2)).sum();
        Self { along, weight, absorbed }
    }
}
