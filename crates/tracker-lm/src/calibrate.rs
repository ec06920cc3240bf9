//! From a survey to the six errors.

use std::ops::Range;

use least_squares::{BlockParts, BorderedPoint, BorderedSolution};
use nalgebra::Point3;

use crate::frame::{Frame, Motion};
use crate::free_points::FreePoints;
use crate::gauge::StationChart;
use crate::joint::{Joint, held};
use crate::network::Network;
use crate::readings::Readings;
use crate::search::{covariance, settle};
use crate::start::Start;
use crate::weights::Weights;
use crate::{
    AxisModel, Calibration, ErrorOrder, Formulation, Gauge, Options, Survey, TrackerError,
};
use crate::{joint_result, points_result};

/// Standard uncertainty of a displacement that the first fit takes where none is declared.
const FIRST_GUESS_MM: f64 = 1e-3;
/// Estimates of the noise below this are rounding, and no reason to weigh anything by.
const LEAST_NOISE_MM: f64 = 1e-9;
/// Fits with the noise estimated anew; beside other declared uncertainties it settles in three.
const NOISE_PASSES: usize = 8;
/// Relative change of the estimated noise that is worth another fit.
const NOISE_SETTLED: f64 = 1e-3;
/// Residual beyond which a nominal start is not trusted, in standard uncertainties.
const POOR_FIT: f64 = 10.0;

/// Finds stations, dead paths, reflectors, and the axis' six errors at every angle.
///
/// # Errors
///
/// See [`TrackerError`]: every variant means that there is no calibration to rely on.
pub fn calibrate(survey: &Survey, options: &Options) -> Result<Calibration, TrackerError> {
    match options.formulation {
        Formulation::Joint => Ok(fitted_joint(survey, options)?.0),
        Formulation::FreePoints if options.axis != AxisModel::Free => {
            Err(TrackerError::PerfectAxisOfFreePoints)
        }
        Formulation::FreePoints => {
            let (network, chart) = checked(survey, options)?;
            let with =
                |w: Weights| FreePoints::new(&network, &chart, w.displacement_mm, w.rigid_mm);
            let Fit { problem, solution, weights } =
                fit((&network, &chart), options, with, FreePoints::start, &[])?;
            points_result::result(&problem, solution, weights, options)
        }
    }
}

/// The joint bundle and its point, whatever formulation is asked for.
pub(crate) fn fitted_joint(
    survey: &Survey,
    options: &Options,
) -> Result<(Calibration, BorderedPoint), TrackerError> {
    let options = Options { formulation: Formulation::Joint, ..*options };
    let options = Placed::of(survey, &options)?.options;
    let (network, chart) = checked(survey, &options)?;
    let with = |w: Weights| Joint::new(&network, &chart, w.displacement_mm);
    let held = held(options.axis, network.angles.len());
    let Fit { problem, solution, weights } =
        fit((&network, &chart), &options, with, Joint::start, &held)?;
    let calibration = joint_result::result(&problem, &solution, weights, &options)?;
    Ok((calibration, solution.point))
}

/// How a perfect axis is held against its declared place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed {
    /// Options to calibrate with.
    pub(crate) options: Options,
    /// The frame that the axis is off its place in; `None` where it is taken as without error.
    pub(crate) frame: Option<Frame>,
    /// Whether the axis is off its place by more than the frame is uncertain.
    pub(crate) is_off: bool,
}

impl Placed {
    /// Stations whose places are data would move as one with an axis that is off its place: where it
    /// is off by more than these are uncertain, the frame is the fit of all of them.
    pub(crate) fn of(survey: &Survey, options: &Options) -> Result<Self, TrackerError> {
        let plain = Self { options: *options, frame: None, is_off: true };
        let Some(station_mm) = options.noise.station_mm else { return Ok(plain) };
        if options.axis != AxisModel::Fixed || options.gauge != Gauge::Stations {
            return Ok(plain);
        }
        let of = |axis| {
            let (gauge, order) = (Gauge::Shape, ErrorOrder::Fixed);
            fitted_joint(survey, &Options { axis, gauge, order, ..*options })
        };
        let axis = &survey.axis;
        let places: Vec<_> =
            survey.stations.iter().map(|s| s.nominal_mm - axis.origin_mm).collect();
        let frame = Frame::of_places(axis, &places, station_mm, None);
        // Free errors leave a motion no way to look like a place; without as many readings as these
        // need, the place alone is fitted.
        let free = of(AxisModel::Free).ok().map(|(free, _)| free);
        let motion = free.as_ref().and_then(|f| Motion::of(&f.axis_errors, f.location.as_ref()?));
        let found = match free.and_then(|free| free.location) {
            Some(location) => Some(location),
            None => of(AxisModel::Located)?.0.location,
        };
        let is_off = match (&frame, &found) {
            (Some(frame), Some(location)) => frame.is_exceeded(location, motion),
            _ => false,
        };
        let gauge = if is_off { Gauge::Shape } else { Gauge::Stations };
        let frame = frame.filter(|_| is_off);
        Ok(Self { options: Options { gauge, ..*options }, frame, is_off })
    }
}

pub(crate) fn checked<'a>(
    survey: &'a Survey,
    options: &Options,
) -> Result<(Network<'a>, StationChart), TrackerError> {
    let network = Network::new(survey, options)?;
    let nominal: Vec<Point3<f64>> = survey.stations.iter().map(|s| s.nominal_mm).collect();
    Ok((network, StationChart::new(&nominal, options)?))
}

/// A solved problem under the noise that it was solved with.
struct Fit<P> {
    problem: P,
    solution: BorderedSolution,
    weights: Weights,
}

/// Fits from the nominal start, from a resected one where that is poor, and estimates the noise
/// where it is not declared.
fn fit<P: Readings>(
    (network, chart): (&Network<'_>, &StationChart),
    options: &Options,
    with: impl Fn(Weights) -> P,
    start: impl Fn(&P, &Start) -> BorderedPoint,
    held: &[usize],
) -> Result<Fit<P>, TrackerError> {
    let declared = options.noise.displacement_mm;
    let mut weights = Weights::new(&options.noise, declared.unwrap_or(FIRST_GUESS_MM));
    let mut problem = with(weights);
    let search = |problem: &P, from| settle(problem, from, held, options.max_iterations);
    let from = |place: &Start| search(&problem, start(&problem, place));
    let first = from(&Start::nominal(network));
    let factor = |settled: &BorderedSolution| settled.variance_factor.unwrap_or(0.0);
    let mut settled = match first {
        Ok(settled) if factor(&settled) <= POOR_FIT * POOR_FIT => settled,
        first => match (first, from(&Start::resected(network, chart))) {
            (Ok(first), Ok(second)) if factor(&second) < factor(&first) => second,
            (Err(_), Ok(second)) => second,
            (first, _) => first?,
        },
    };
    if declared.is_some() {
        return Ok(Fit { problem, solution: settled, weights });
    }
    for _ in 0..NOISE_PASSES {
        let ratio = range_variance(&problem, &settled, held)?.sqrt();
        let estimate = (weights.displacement_mm * ratio).max(LEAST_NOISE_MM);
        let change = estimate / weights.displacement_mm - 1.0;
        weights = Weights::new(&options.noise, estimate);
        problem = with(weights);
        settled = search(&problem, settled.point)?;
        if change.abs() < NOISE_SETTLED || estimate <= LEAST_NOISE_MM {
            break;
        }
    }
    Ok(Fit { problem, solution: settled, weights })
}

/// Mean whitened square of the ranges' residuals over their redundancy: the variance that they
/// have beside rows of another kind (Förstner 1979).
fn range_variance<P: Readings>(
    problem: &P,
    settled: &BorderedSolution,
    held: &[usize],
) -> Result<f64, TrackerError> {
    let covariance = covariance(problem, &settled.point, held)?;
    let of_blocks = |blocks: Range<usize>, parts: &mut BlockParts| {
        let (mut squares, mut redundancy) = (0.0, 0.0);
        let blocks: Vec<usize> = blocks.collect();
        let mut in_turn = covariance.in_turn(&blocks, parts);
        for &block in &blocks {
            let Some(part) = in_turn.next() else { break };
            let rows = part.residuals().iter().zip(part.leverages());
            for (residual, leverage) in rows.take(problem.range_count(block)) {
                squares += residual * residual;
                redundancy += 1.0 - leverage;
            }
        }
        (squares, redundancy)
    };
    let mut sums = (0.0, 0.0);
    covariance.in_chunks(problem.block_count(), of_blocks, |(squares, redundancy)| {
        sums = (sums.0 + squares, sums.1 + redundancy);
    });
    Ok(sums.0 / sums.1)
}
