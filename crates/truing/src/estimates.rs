use model_discrepancy::Step;
use serde::Serialize;
use truing_report::ExtraPlot;

use crate::estimated::{Estimated, Export};
use crate::kinds::{
    AxisRunEstimate, DisplacementEstimates, ForceImpedanceEstimates, FrameFitEstimates,
    FtCenterEstimates, GravityEstimates, PathForceEstimates, PoseIcpEstimates,
    PositioningEstimates, ProbeCompEstimates, TipEstimates, TrackerLmEstimates,
};
use crate::text_table::{Cell, EXPANDED, TextTable};

/// What was solved for, by kind; each serialises as its own object.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
#[non_exhaustive]
pub enum Estimates {
    /// `frame-fit`.
    FrameFit(FrameFitEstimates),
    /// `frame-fit` from poses of a flange.
    Tip(TipEstimates),
    /// `ft-center` from presses.
    FtCenter(FtCenterEstimates),
    /// `ft-center` from a table of displacements.
    Displacements(DisplacementEstimates),
    /// `ft-center` from static poses.
    Gravity(GravityEstimates),
    /// `pose-icp`.
    PoseIcp(PoseIcpEstimates),
    /// `probe-comp`.
    ProbeComp(ProbeCompEstimates),
    /// `force-impedance`.
    ForceImpedance(ForceImpedanceEstimates),
    /// `force-impedance` from runs along a path.
    PathForce(PathForceEstimates),
    /// `positioning`.
    Positioning(PositioningEstimates),
    /// `tracker-lm`.
    TrackerLm(TrackerLmEstimates),
}

impl Estimates {
    /// The numbers that describe the whole case, with their uncertainties.
    pub(crate) fn parameters(&self) -> Vec<Estimated> {
        match self {
            Self::FrameFit(estimates) => estimates.parameters(),
            Self::Tip(estimates) => estimates.parameters(),
            Self::FtCenter(estimates) => estimates.parameters(),
            Self::Displacements(estimates) => {
                estimates.run.iter().flat_map(AxisRunEstimate::parameters).collect()
            }
            Self::Positioning(estimates) => estimates.run.parameters(),
            Self::ProbeComp(estimates) => estimates.parameters(),
            Self::Gravity(estimates) => estimates.parameters(),
            Self::PoseIcp(estimates) => estimates.parameters(),
            Self::ForceImpedance(estimates) => estimates.parameters(),
            Self::PathForce(estimates) => estimates.parameters(),
            Self::TrackerLm(estimates) => estimates.parameters(),
        }
    }

    /// When what is handed back holds, and what of the accepted effects it leaves to corrections.
    #[must_use]
    pub fn conditions(&self) -> &[String] {
        match self {
            Self::FrameFit(estimates) => &estimates.conditions,
            Self::FtCenter(estimates) => &estimates.conditions,
            Self::Displacements(estimates) => &estimates.conditions,
            Self::Positioning(estimates) => &estimates.conditions,
            Self::Gravity(estimates) => &estimates.conditions,
            Self::ForceImpedance(estimates) => &estimates.conditions,
            Self::PathForce(estimates) => &estimates.conditions,
            _ => &[],
        }
    }

    /// Gives steps the uncertainty that what they found has in these estimates, where that is larger.
    pub(crate) fn widen(&self, steps: &mut [Step]) {
        if let Self::TrackerLm(estimates) = self {
            estimates.widen(steps);
        }
    }

    /// Pictures that only this kind has.
    pub(crate) fn plots(&self) -> Vec<ExtraPlot> {
        match self {
            Self::TrackerLm(estimates) => estimates.plots(),
            Self::Positioning(estimates) => vec![estimates.run.plot()],
            Self::Displacements(estimates) => {
                estimates.run.iter().map(AxisRunEstimate::plot).collect()
            }
            _ => Vec::new(),
        }
    }

    /// The estimates as a file of that format; `None` where the kind has nothing to put there.
    #[must_use]
    pub fn export(&self, format: Export) -> Option<String> {
        match self {
            Self::TrackerLm(estimates) => Some(estimates.export(format)),
            Self::Positioning(estimates) => estimates.run.export(format),
            Self::Displacements(estimates) => estimates.run.as_ref()?.export(format),
            _ => None,
        }
    }

    /// Tables for people.
    pub(crate) fn tables(&self) -> Vec<TextTable> {
        let mut tables = Vec::new();
        let parameters = self.parameters();
        if !parameters.is_empty() {
            let columns = ["parameter", "value", EXPANDED, "unit"];
            let mut table = TextTable::of_quantities("estimates", &columns);
            for p in &parameters {
                table.push(vec![
                    p.name.clone().into(),
                    Cell::Known(p.value, p.std),
                    Cell::Expanded(p.std),
                    p.unit.to_owned().into(),
                ]);
            }
            tables.push(table);
        }
        if let Self::Displacements(DisplacementEstimates { run: Some(run), .. }) = self {
            tables.push(run.table());
        }
        tables.push(match self {
            Self::FrameFit(estimates) => estimates.table(),
            Self::Tip(estimates) => estimates.table(),
            Self::FtCenter(estimates) => estimates.table(),
            Self::Displacements(estimates) => estimates.table(),
            Self::Positioning(estimates) => estimates.run.table(),
            Self::Gravity(estimates) => estimates.table(),
            Self::PoseIcp(estimates) => estimates.table(),
            Self::ProbeComp(estimates) => estimates.table(),
            Self::ForceImpedance(estimates) => estimates.table(),
            Self::PathForce(estimates) => estimates.table(),
            Self::TrackerLm(estimates) => estimates.table(),
        });
        tables
    }
}
