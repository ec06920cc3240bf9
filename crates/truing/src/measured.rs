//! Data of one kind of case, ready to be solved, and what solving gives.

use std::fmt;
use std::sync::Arc;

use model_discrepancy::{Closure, Covariate, EmpiricalCorrection, Model, Solution};
use truing_report::{CurvePlot, Facet, Fact};

use crate::Error;
use crate::case::LoopSettings;
use crate::depth::Polished;
use crate::estimates::Estimates;
use crate::guide::{GuidePlaces, GuidesOfCase};
use crate::itlicp::SampledCase;
use crate::kinds::Offer;
use crate::monitor::LiveFrame;
use crate::suspect::Yardstick;

/// What a kind read.
pub(crate) struct Reading {
    pub(crate) measured: Box<dyn Measured>,
    pub(crate) loop_settings: LoopSettings,
    pub(crate) warnings: Vec<String>,
    /// Tables that were read.
    pub(crate) tables: Vec<&'static str>,
}

/// Data of one kind, ready to be solved.
pub(crate) trait Measured: fmt::Debug + Send + Sync {
    /// Fits the declared model.
    fn fit(&self) -> Result<Fitted, Error>;

    /// The same for who asks for residuals alone, as of hundreds of changes that are tried: estimates may lack
    /// what takes longer than the fit.
    fn fit_alone(&self) -> Result<Fitted, Error> {
        self.fit()
    }

    /// The declared model as the loop sees it.
    fn prepare(&self) -> Result<Prepared<'_>, Error>;

    /// The same where only the first rows of the table of measurements were measured and the others are
    /// planned: laws that are looked for in the data are looked for in those alone.
    fn prepare_planned(&self, _n_measured: usize) -> Result<Prepared<'_>, Error> {
        self.prepare()
    }

    /// The case in words.
    fn words(&self) -> Words;

    /// What a misfit of the declared model is measured by.
    fn yardstick(&self, _fitted: &Fitted) -> Yardstick {
        Yardstick::NONE
    }

    /// Whether observations of this kind can repeat each other: not where rows combine several.
    fn repeats_places(&self) -> bool {
        true
    }

    /// Degrees of freedom with which uncertainties were known before, where nothing is fitted.
    fn known_before(&self) -> Option<usize> {
        None
    }

    /// What further measurements the machine can make; `None` where this kind of case cannot say.
    fn offer(&self) -> Result<Option<Offer>, Error> {
        Ok(None)
    }

    /// Guide points; `None` where nothing is touched along z.
    fn guides(&self, _of: &GuidePlaces) -> Result<Option<GuidesOfCase>, Error> {
        Ok(None)
    }

    /// Where a contact can be followed live; `None` where there is no frame of a sensor.
    fn live(&self) -> Result<Option<LiveFrame>, Error> {
        Ok(None)
    }

    /// Row of the table of measurements with which each observation of the model begins; `None` where
    /// every row is an observation.
    fn rows(&self) -> Option<Vec<usize>> {
        None
    }

    /// What the method of document \[D\] needs; `None` of kinds without it.
    fn sampled(&self) -> Result<Option<SampledCase>, Error> {
        Ok(None)
    }

    /// The part as it lies under a polishing tool; `None` of kinds without one.
    fn polished(&self) -> Result<Option<Polished>, Error> {
        Ok(None)
    }

    /// Curves that the report of this kind shows.
    fn curves(&self) -> Vec<CurvePlot> {
        Vec::new()
    }
}

/// The declared model, fitted.
#[derive(Debug)]
pub(crate) struct Fitted {
    pub(crate) estimates: Arc<dyn Estimates>,
    /// In the order of the model's observations.
    pub(crate) observations: Vec<Observation>,
    /// Unit of the residuals.
    pub(crate) unit: &'static str,
    pub(crate) degrees_of_freedom: usize,
    /// χ² over degrees of freedom where the noise was declared.
    pub(crate) chi2_per_dof: Option<f64>,
    pub(crate) warnings: Vec<String>,
}

/// One point, press or pose with its residual.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Observation {
    /// One entry per component of the model's layout.
    pub(crate) residual: Vec<f64>,
    /// Whether it took part in the fit.
    pub(crate) fitted: bool,
}

impl Observation {
    /// Squared length of the residual.
    pub(crate) fn square(&self) -> f64 {
        self.residual.iter().map(|r| r * r).sum()
    }
}

/// Sentences that say where the empirical corrections of a closure are.
pub(crate) fn empirical_conditions(closure: &Closure) -> Vec<String> {
    let sentence = |e: &EmpiricalCorrection| {
        format!(
            "the cause of the correction along {} ({}) is not known; only the corrections of the \
             readings contain it",
            e.covariate, e.shape
        )
    };
    closure.empirical.iter().map(sentence).collect()
}

/// Estimates of a kind with the accepted effects in the model.
pub(crate) type EstimatesOf<'c> = Box<dyn Fn(&Closure) -> Arc<dyn Estimates> + 'c>;

/// What the loop needs, anew about what one has found; `None` where nothing would change.
pub(crate) type About<'c> = Box<dyn Fn(&Solution) -> Result<Option<Prepared<'c>>, Error> + 'c>;

/// What the loop needs.
pub(crate) struct Prepared<'c> {
    pub(crate) model: Arc<dyn Model + Send + 'c>,
    pub(crate) covariates: Vec<Covariate>,
    pub(crate) estimates: EstimatesOf<'c>,
    /// Of a model whose rows are linear about one solution, or whose catalogue has effects that were
    /// found by looking at the residual; it has the same rows there.
    pub(crate) about: Option<About<'c>>,
}

/// A case in words, for tables and reports.
#[derive(Clone, Debug)]
pub(crate) struct Words {
    /// The declared model, one paragraph per line.
    pub(crate) declared: Vec<String>,
    /// What the residual is.
    pub(crate) residual: &'static str,
    /// Components of one observation's residual.
    pub(crate) components: &'static [&'static str],
    /// What one group is called.
    pub(crate) group_noun: String,
    /// Facts about the measurement.
    pub(crate) measured: Vec<Fact>,
    /// Where the observations were made, where that is a plane.
    pub(crate) places: Option<Places>,
}

/// Places of the observations in a plane.
#[derive(Clone, Debug)]
pub(crate) struct Places {
    pub(crate) x_title: &'static str,
    pub(crate) y_title: &'static str,
    /// One per observation.
    pub(crate) at: Vec<[f64; 2]>,
    /// One per observation.
    pub(crate) names: Vec<String>,
    /// A surface on which they lie, the farthest facet first; empty where there is none.
    pub(crate) facets: Vec<Facet>,
}
