//! What the observations of a survey of points are: their rows, groups and places.

use model_discrepancy::{Group, Layout, Role, Row};

use super::bundle::Bundle;
use super::rows::Rows;
use super::{HoldOut, TargetOptions, TargetSurvey};
use crate::AxisModel;
use crate::angle_steps::angles;
use crate::missing::layout::{Seen, numbered};

/// One observation per reading.
pub(super) fn layout(
    survey: &TargetSurvey,
    rows: &Rows,
    hold_out: HoldOut,
    options: &TargetOptions,
    declared: bool,
) -> Layout {
    let group = |name: &String| Group { name: name.clone(), role: Role::Fit };
    let (groups, observations) = match hold_out {
        HoldOut::Step => {
            let mut groups: Vec<Group> = survey.steps.iter().map(|s| group(&s.name)).collect();
            // The first angle is where the errors are zero: met once, it says where the trackers
            // stand, and without it nothing does.
            if options.axis == AxisModel::Free
                && let Some([first]) = angles(&survey.steps).0.first().map(|a| &a.steps[..])
            {
                groups[*first].role = Role::Prior;
            }
            (groups, survey.targets.iter().map(|t| t.step).collect())
        }
        HoldOut::Mount => (
            survey.mounts.iter().map(|m| group(&m.name)).collect(),
            survey.targets.iter().map(|t| t.mount).collect(),
        ),
    };
    let row = |(&(observation, component), &sigma): (&(usize, usize), &f64)| Row {
        observation,
        component,
        sigma,
        reported: true,
    };
    Layout {
        rows: rows.tied_to.iter().zip(&rows.sigma_mm).map(row).collect(),
        observations,
        groups,
        unit: "mm".to_owned(),
        sigma_declared: declared,
    }
}

/// Place of every reading: station, mount, angle and the way the axis came to it.
///
/// With free errors, or reflectors whose places are taken out, none repeats another: a row combines
/// readings of several angles.
pub(super) fn places(bundle: &Bundle<'_>, hold_out: HoldOut) -> Vec<usize> {
    let targets = &bundle.survey.targets;
    if bundle.axis_model == AxisModel::Free || hold_out == HoldOut::Mount {
        return (0..targets.len()).collect();
    }
    numbered(targets.iter().map(|target| Seen {
        station: target.station,
        mount: target.mount,
        angle: bundle.angle_of_step[target.step],
        approach: bundle.survey.steps[target.step].approach,
    }))
}
