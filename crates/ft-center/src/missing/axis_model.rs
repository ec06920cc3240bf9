//! A positioning run as a model for the loop.

use model_discrepancy::{Covariate, Declared, Layout, LinearModel, Quantity, Shown, resolution_of};
use nalgebra::{DMatrix, DVector};

use crate::axis_reading::AxisMotion;
use crate::error::require_positive;
use crate::missing::axis_proposals::{Longer, proposals};
use crate::missing::axis_run::{AxisRun, AxisTerm};
use crate::missing::axis_searched::Searched;
use crate::{FtCenterError, Table};

/// The declared model claims that every target was reached: residual is the deviation, in mm or
/// seconds of arc, and nothing is estimated. The courses `shown` are the last effects of its catalogue
/// ([`AxisRun::shown`]). `sigma` is the standard uncertainty of one, `None` where
/// the residual is to tell.
///
/// # Errors
///
/// [`FtCenterError::Empty`], [`FtCenterError::NotFinite`], [`FtCenterError::NotPositive`],
/// [`FtCenterError::CovariateLength`].
pub fn positioning_model(
    run: &AxisRun<'_>,
    shown: &Shown,
    sigma: Option<f64>,
) -> Result<LinearModel, FtCenterError> {
    check(run, sigma)?;
    let searched = Searched::of(run);
    let with = |Longer { text, readings, cycles, covariates }: Longer| {
        let cycles = cycles.as_deref();
        let longer = AxisRun { readings: &readings, cycles, covariates: &covariates, ..*run };
        let mut causes = longer.causes(&searched);
        causes.extend(longer.courses(shown));
        (text.to_owned(), run_model(&longer, causes, sigma))
    };
    let extended = proposals(run).into_iter().map(with).collect();
    Ok(LinearModel { extended, ..run_model(run, run.terms_as(&searched, shown), sigma) })
}

/// The model of a run that was checked, with what it may show beside offset and scale.
fn run_model(run: &AxisRun<'_>, beside: Vec<AxisTerm>, sigma: Option<f64>) -> LinearModel {
    let mut terms = run.zero_and_pitch();
    terms.extend(beside);
    let names = run.readings.iter().map(|r| r.name.clone());
    let layout = Layout::scalars(names, run.motion.deviation_unit(), sigma);
    let tangents = terms.iter().map(AxisTerm::tangent).collect();
    let effects = terms.into_iter().map(|term| term.effect).collect();
    let n = run.readings.len();
    LinearModel {
        declared: Declared {
            resolution: resolution_of(run.readings.iter().map(|r| r.deviation)),
            ..Declared::new(layout, Vec::new(), effects)
        },
        residual: DVector::from_iterator(n, run.readings.iter().map(|r| r.deviation)),
        base: DMatrix::zeros(n, 0),
        tangents,
        extended: Vec::new(),
    }
}

fn check(run: &AxisRun<'_>, sigma: Option<f64>) -> Result<(), FtCenterError> {
    if run.readings.is_empty() {
        return Err(FtCenterError::Empty { of: Table::Displacements });
    }
    let is_finite = |r: &crate::AxisReading| r.target.is_finite() && r.deviation.is_finite();
    if let Some(index) = run.readings.iter().position(|r| !is_finite(r)) {
        return Err(FtCenterError::NotFinite { index });
    }
    for (value, setting) in [(sigma, "sigma"), (run.lead, "lead")] {
        if let Some(value) = value {
            require_positive(value, setting)?;
        }
    }
    let needed = run.readings.len();
    if let Some(cycles) = run.cycles.filter(|cycles| cycles.len() != needed) {
        let name = "cycle".to_owned();
        return Err(FtCenterError::CovariateLength { name, got: cycles.len(), needed });
    }
    match run.covariates.iter().find(|c| c.values.len() != needed) {
        Some(c) => {
            let (name, got) = (c.name.clone(), c.values.len());
            Err(FtCenterError::CovariateLength { name, got, needed })
        }
        None => Ok(()),
    }
}

/// Targets, and which way the axis came where that is known of every reading, as covariates.
#[must_use]
pub fn axis_coordinates(run: &AxisRun<'_>, target: &str) -> Vec<Covariate> {
    let targets = run.readings.iter().map(|r| r.target).collect();
    let quantity = match run.motion {
        AxisMotion::Linear => Quantity::Position,
        AxisMotion::Rotary => Quantity::Angle,
    };
    let ways: Option<Vec<f64>> = run.readings.iter().map(|r| Some(r.approach?.sign())).collect();
    let ways = ways.map(|ways| Covariate::coordinate("direction", Quantity::Other, ways));
    std::iter::once(Covariate::coordinate(target, quantity, targets)).chain(ways).collect()
}
