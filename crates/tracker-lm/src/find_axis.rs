//! Where an axis is that no drawing places: the line that the reflectors turn about.

use nalgebra::{Point3, Unit, Vector3};

use crate::calibrate::{checked, fitted_joint};
use crate::count::count;
use crate::start::Start;
use crate::{AxisModel, Formulation, Options, RotaryAxis, Survey, TrackerError};

/// What is to be found of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sought {
    /// A point on it; its direction is that of the survey's axis.
    Origin,
    /// A point on it and its direction, of which the survey's axis is a first guess.
    OriginAndDirection,
}

/// Resections, each about the axis that the one before found: it tells the place of a station from
/// its mirror image.
const RESECTIONS: usize = 3;
/// Calibrations, each about the axis that the one before found.
const ROUNDS: usize = 8;
/// An axis that moves by less has been found, mm and rad.
const SETTLED: [f64; 2] = [1e-7, 1e-10];

/// The axis that the ranges show, in the frame of the nominal stations.
///
/// Every station is resected from its ranges to the nominal reflectors, in the frame of the axis;
/// the rigid fit of the stations to their nominal places then puts the axis into the machine, and
/// calibrations with its location free refine it (\[B\], step S1; the location is that of ISO 230-1).
/// `survey.axis` gives the letter and the direction, to 45° at least; its origin is not used. How
/// high the origin is along the axis follows from the nominal places of the reflectors.
///
/// # Errors
///
/// As of [`calibrate`](crate::calibrate): what is too little for a location is an error.
/// [`TrackerError::TwoAxesOtherwise`] of a head with two axes, and
/// [`TrackerError::AxisNotFound`] where the stations do not say where the axis is.
pub fn find_axis(
    survey: &Survey,
    sought: Sought,
    options: &Options,
) -> Result<RotaryAxis, TrackerError> {
    if survey.second.is_some() {
        return Err(TrackerError::TwoAxesOtherwise);
    }
    let located = Options { formulation: Formulation::Joint, axis: AxisModel::Located, ..*options };
    let given = survey.axis.direction;
    let kept = |axis: RotaryAxis| match sought {
        Sought::Origin => RotaryAxis { direction: given, ..axis },
        Sought::OriginAndDirection => axis,
    };
    let mut survey = survey.clone();
    survey.axis.origin_mm = Point3::origin();
    for _ in 0..RESECTIONS {
        let (network, chart) = checked(&survey, &located)?;
        let moved = Start::resected(&network, &chart).moved;
        let axis = survey.axis;
        survey.axis = kept(RotaryAxis {
            origin_mm: moved * axis.origin_mm,
            direction: Unit::new_normalize(moved * axis.direction.into_inner()),
            ..axis
        });
    }
    let found = refined(survey, sought, &located)?;
    if options.axis == AxisModel::Free {
        // Of an axis with errors it is the line against which these have no share of a location.
        return refined(found, sought, &Options { axis: AxisModel::Free, ..located })
            .map(|survey| survey.axis);
    }
    Ok(found.axis)
}

/// The survey with its axis where a calibration leaves it no error of location.
fn refined(mut survey: Survey, sought: Sought, options: &Options) -> Result<Survey, TrackerError> {
    for _ in 0..ROUNDS {
        let found = fitted_joint(&survey, options)?.0;
        let location = found.location.ok_or(TrackerError::AxisNotFound)?;
        let mut errors = location.errors;
        if sought == Sought::Origin {
            errors.fixed_rows_mut::<2>(2).fill(0.0);
        }
        let too_low = mean_height(&survey, found.mounts.iter().map(|m| m.position_mm))
            - mean_height(&survey, survey.mounts.iter().map(|m| m.nominal_mm));
        survey.axis = moved(&survey.axis, errors.as_slice(), too_low);
        if errors.rows(0, 2).amax() < SETTLED[0] && errors.rows(2, 2).amax() < SETTLED[1] {
            return Ok(survey);
        }
    }
    Err(TrackerError::AxisNotFound)
}

/// Mean of places of reflectors along the axis.
fn mean_height(survey: &Survey, places_mm: impl Iterator<Item = Point3<f64>>) -> f64 {
    let sum: f64 = places_mm.map(|place| place.coords.dot(&survey.axis.direction)).sum();
    sum / count(survey.mounts.len())
}

/// The axis with errors of location, two displacements and two rotations across its letter's axis,
/// and its origin moved along it.
fn moved(axis: &RotaryAxis, errors: &[f64], along_mm: f64) -> RotaryAxis {
    let [first, second] = axis.letter.across().map(|i| Vector3::ith(i, 1.0));
    let displaced = first * errors[0] + second * errors[1] + axis.direction.into_inner() * along_mm;
    let turned = geometry::so3::exp(&(first * errors[2] + second * errors[3]));
    let direction = Unit::new_normalize(turned * axis.direction.into_inner());
    RotaryAxis { origin_mm: axis.origin_mm + displaced, direction, ..*axis }
}
