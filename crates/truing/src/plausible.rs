//! Whether what is handed back can be true of a machine.

use nalgebra::Matrix3;

use crate::kinds::{
    AxisRunEstimate, AxisTargetEstimate, FtCenterEstimates, GravityEstimates, PoseIcpEstimates,
    ProbeCompEstimates, TipEstimates, TouchEstimate, TrackerLmEstimates,
};
use crate::{Error, Estimates};

/// Largest rotation of a rotary axis about itself that is a correction, in degrees: what a worm of
/// fifty teeth is wrong by when it has jumped a seventh of a tooth.
const MAX_ROTATION_DEG: f64 = 1.0;

/// Largest displacement of an axis from where it was declared that is an error of location.
const MAX_LOCATION_MM: f64 = 50.0;

/// Largest rotation of an axis from where it was declared that is an error of location, in degrees.
const MAX_LOCATION_DEG: f64 = 5.0;

/// Largest distance between where a head presses and where it was sent that is an error of the
/// machine: as for an axis.
const MAX_CONTACT_MM: f64 = MAX_LOCATION_MM;

/// Largest distance by which an axis misses a target: a tooth of a rack, or half a turn of a screw.
const MAX_POSITION_MM: f64 = 5.0;

/// The same of a rotary axis: a degree, as for its compensation.
const MAX_POSITION_ARCSEC: f64 = 3600.0;

/// Farthest from its flange or sensor that a tool is held: the reach of a large robot.
const MAX_TOOL_MM: f64 = 3000.0;

/// Farthest from the machine's zero that a workpiece lies: the bed of the longest gantry.
const MAX_PLACE_MM: f64 = 1e5;

/// Largest share by which the axes of a machine are wrong in length or square: what is found of
/// better ones without any compensation is a tenth of it.
const MAX_AXES: f64 = 0.02;

/// Largest deviation of a part from its drawing that a probe meets: beyond it, the ball touched
/// something else.
const MAX_DEVIATION_MM: f64 = 50.0;

/// Change of the rotation error per angle beyond which the axis turns the other way: an axis that is
/// declared reversed turns by the angle backwards, and is wrong by twice of it; the sign is that of the
/// letter's axis against the declared direction.
const REVERSED: f64 = 1.5;

/// A result larger than any that a machine needs.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ImplausibleResult {
    /// The axis turns against its declared direction.
    #[error(
        "the axis turns against `[axis] direction`: its rotation error is twice its angle, up \
         to {largest_deg:.1}°; with the direction the other way, direction = [{}, {}, {}], the data fit",
        reversed[0], reversed[1], reversed[2]
    )]
    Reversed {
        /// Largest rotation error.
        largest_deg: f64,
        /// Direction that fits.
        reversed: [f64; 3],
    },
    /// A compensation beyond its bound.
    #[error(
        "the compensation of axis {letter} is {found_deg:.3}° at {at_deg}°, more than the \
         {limit_deg}° that are taken for a correction: check `[axis] direction` and `angle_deg`; \
         `--max-correction {}` writes it all the same",
        found_deg.abs().ceil()
    )]
    Compensation {
        /// Letter of the axis.
        letter: char,
        /// Largest correction.
        found_deg: f64,
        /// Where it is.
        at_deg: f64,
        /// The bound.
        limit_deg: f64,
    },
    /// A location error beyond any machine.
    #[error(
        "the axis lies {found} {unit} from where it is declared ({name}), more than any machine is \
         wrong by ({limit} {unit}): check `[axis] origin_mm`, `[axis] direction`, the stations and \
         their units"
    )]
    Location {
        /// Name of ISO 230-1.
        name: String,
        /// The error.
        found: f64,
        /// Unit of both.
        unit: &'static str,
        /// The bound.
        limit: f64,
    },
    /// A position beyond any machine.
    #[error(
        "the axis misses its target {target} {target_unit} by {found:.3} {unit}, more than any machine \
         does ({limit:.3} {unit}): check units, signs and the order of the rows"
    )]
    Position {
        /// The target.
        target: f64,
        /// Its unit.
        target_unit: &'static str,
        /// Mean deviation there.
        found: f64,
        /// Unit of it and of the bound.
        unit: &'static str,
        /// The bound.
        limit: f64,
    },
    /// A contact beyond any machine.
    #[error(
        "press {press} lies {found_mm:.1} mm from where the head was sent, more than any machine is \
         wrong by ({limit_mm} mm): check the columns of `presses.csv` and `wrench.csv`, their signs \
         and units, and `[contact] z0_mm`"
    )]
    Contact {
        /// Name of the press.
        press: String,
        /// Distance.
        found_mm: f64,
        /// The bound.
        limit_mm: f64,
    },
    /// A tool longer than any.
    #[error(
        "{what} lies {found_mm:.0} mm from {from}, farther than any tool reaches ({limit_mm} mm): \
         check the units of the table, and that the poses turn enough to show it"
    )]
    Tool {
        /// `the tip` or `the centre of gravity`.
        what: &'static str,
        /// What it is measured from.
        from: &'static str,
        /// Distance.
        found_mm: f64,
        /// The bound.
        limit_mm: f64,
    },
    /// A workpiece farther away than any machine is long.
    #[error(
        "the workpiece lies {:.0} m from the zero of its readings, farther than any machine is long \
         ({:.0} m): check the units of `points.csv`",
        found_mm / 1000.0, limit_mm / 1000.0
    )]
    Place {
        /// Distance.
        found_mm: f64,
        /// The bound.
        limit_mm: f64,
    },
    /// Axes worse than those of any machine.
    #[error(
        "the machine's axes as found change lengths and angles by {:.1} %, more than any machine is \
         wrong by ({:.0} %): check `[surface]` and the units of `points.csv`",
        100.0 * found, 100.0 * limit
    )]
    Axes {
        /// Largest share.
        found: f64,
        /// The bound.
        limit: f64,
    },
    /// A part farther from its drawing than any.
    #[error(
        "touch {touch} is {found_mm:.1} mm off the drawn part, more than any part is wrong by \
         ({limit_mm} mm): check `[surface]`, the workpiece frame and the units of `touches.csv`"
    )]
    Deviation {
        /// Name of the touch.
        touch: String,
        /// Its deviation.
        found_mm: f64,
        /// The bound.
        limit_mm: f64,
    },
}

/// Refuses a deliverable that no machine needs; `max_correction_deg` replaces the bound of a
/// compensation, one degree.
///
/// # Errors
///
/// [`Error::Implausible`] with the field to look at and, where the data tell, the value that fits.
pub fn plausible(estimates: &Estimates, max_correction_deg: Option<f64>) -> Result<(), Error> {
    let problem = match estimates {
        Estimates::TrackerLm(axis) => of_axis(axis, max_correction_deg.unwrap_or(MAX_ROTATION_DEG)),
        Estimates::Positioning(found) => of_run(&found.run),
        Estimates::FtCenter(found) => of_presses(found),
        Estimates::Displacements(found) => found.run.as_ref().and_then(of_run),
        Estimates::Gravity(found) => of_gravity(found),
        Estimates::Tip(found) => of_tip(found),
        Estimates::PoseIcp(found) => of_pose(found),
        Estimates::ProbeComp(found) => of_touches(found),
        // A frame may be anywhere, grids of land surveys being thousands of kilometres from their
        // zero, and a force any that the cell can read.
        Estimates::FrameFit(_) | Estimates::ForceImpedance(_) | Estimates::PathForce(_) => None,
    };
    problem.map_or(Ok(()), |problem| Err(Error::Implausible { problem: Box::new(problem) }))
}

fn of_run(run: &AxisRunEstimate) -> Option<ImplausibleResult> {
    let off = |t: &&AxisTargetEstimate| t.mean.abs();
    let worst = run.targets.iter().max_by(|a, b| off(a).total_cmp(&off(b)))?;
    let (target, target_unit, unit) = (worst.target, run.target_unit, run.unit);
    let (found, limit) =
        (off(&worst), if unit == "mm" { MAX_POSITION_MM } else { MAX_POSITION_ARCSEC });
    (found > limit).then_some(ImplausibleResult::Position {
        target,
        target_unit,
        found,
        unit,
        limit,
    })
}

fn of_presses(found: &FtCenterEstimates) -> Option<ImplausibleResult> {
    let off = |i: usize| found.centers[i].offset_x_mm.hypot(found.centers[i].offset_y_mm);
    let worst = (0..found.centers.len()).max_by(|&a, &b| off(a).total_cmp(&off(b)))?;
    let (press, found_mm) = (found.centers[worst].press.clone(), off(worst));
    let limit_mm = MAX_CONTACT_MM;
    (found_mm > limit_mm).then_some(ImplausibleResult::Contact { press, found_mm, limit_mm })
}

fn of_gravity(found: &GravityEstimates) -> Option<ImplausibleResult> {
    too_long("the centre of gravity", "the sensor", found.center_of_gravity_mm)
}

fn of_tip(found: &TipEstimates) -> Option<ImplausibleResult> {
    too_long("the tip", "the flange", found.tip_mm)
}

fn too_long(what: &'static str, from: &'static str, at_mm: [f64; 3]) -> Option<ImplausibleResult> {
    let found_mm = at_mm.iter().map(|v| v * v).sum::<f64>().sqrt();
    let limit_mm = MAX_TOOL_MM;
    (found_mm > limit_mm).then_some(ImplausibleResult::Tool { what, from, found_mm, limit_mm })
}

fn of_pose(found: &PoseIcpEstimates) -> Option<ImplausibleResult> {
    let place = [0, 1, 2].map(|row| found.matrix[row][3]);
    too_far(place).or_else(|| of_axes(found))
}

fn too_far(place_mm: [f64; 3]) -> Option<ImplausibleResult> {
    let found_mm = place_mm.iter().map(|v| v * v).sum::<f64>().sqrt();
    let limit_mm = MAX_PLACE_MM;
    (found_mm > limit_mm).then_some(ImplausibleResult::Place { found_mm, limit_mm })
}

fn of_axes(found: &PoseIcpEstimates) -> Option<ImplausibleResult> {
    of_reading(&Matrix3::from_fn(|row, column| found.matrix[row][column]))
}

/// A pose alone keeps lengths and angles: what its matrix does to them is the axes' doing.
fn of_reading(linear: &Matrix3<f64>) -> Option<ImplausibleResult> {
    let mut strain = linear.transpose() * linear - Matrix3::identity();
    // Squares of lengths change twice as much as lengths.
    strain.set_diagonal(&(0.5 * strain.diagonal()));
    let (found, limit) = (strain.amax(), MAX_AXES);
    (found > limit).then_some(ImplausibleResult::Axes { found, limit })
}

/// Refuses a matrix from workpiece to readings whose axes are worse than those of any machine.
pub(crate) fn plausible_reading(linear: &Matrix3<f64>) -> Result<(), Error> {
    of_reading(linear)
        .map_or(Ok(()), |problem| Err(Error::Implausible { problem: Box::new(problem) }))
}

fn of_touches(found: &ProbeCompEstimates) -> Option<ImplausibleResult> {
    let off = |t: &&TouchEstimate| t.deviation_mm.abs();
    let worst = found.touches.iter().max_by(|a, b| off(a).total_cmp(&off(b)))?;
    let (touch, found_mm, limit_mm) = (worst.touch.clone(), off(&worst), MAX_DEVIATION_MM);
    (found_mm > limit_mm).then_some(ImplausibleResult::Deviation { touch, found_mm, limit_mm })
}

fn of_axis(axis: &TrackerLmEstimates, limit_deg: f64) -> Option<ImplausibleResult> {
    let own: Vec<[f64; 2]> = axis.own_rotation_deg();
    let [at_deg, found_deg] =
        own.iter().copied().max_by(|a, b| a[1].abs().total_cmp(&b[1].abs())).unwrap_or([0.0; 2]);
    if found_deg.abs() > limit_deg {
        if slope(&own).abs() > REVERSED {
            let reversed = axis.direction().map(|v| if v == 0.0 { 0.0 } else { -v });
            let largest_deg = found_deg.abs();
            return Some(ImplausibleResult::Reversed { largest_deg, reversed });
        }
        let letter = axis.letter();
        return Some(ImplausibleResult::Compensation { letter, found_deg, at_deg, limit_deg });
    }
    let location = axis.axis_location.as_ref()?;
    (0..4).find_map(|i| {
        let (found, unit, limit) = if i < 2 {
            (location.values[i], "mm", MAX_LOCATION_MM)
        } else {
            (location.values[i].to_degrees(), "°", MAX_LOCATION_DEG)
        };
        let name = location.names[i].clone();
        (found.abs() > limit).then_some(ImplausibleResult::Location { name, found, unit, limit })
    })
}

/// Median change of the error from angle to angle, per angle; a rotation comes round again after a
/// turn.
fn slope(points: &[[f64; 2]]) -> f64 {
    let mut ascending = points.to_vec();
    ascending.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let change = |pair: &[[f64; 2]]| {
        let error_deg = (pair[1][1] - pair[0][1] + 180.0).rem_euclid(360.0) - 180.0;
        error_deg / (pair[1][0] - pair[0][0])
    };
    let mut slopes: Vec<f64> =
        ascending.windows(2).filter(|pair| pair[1][0] > pair[0][0]).map(change).collect();
    slopes.sort_by(f64::total_cmp);
    slopes.get(slopes.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Rotation3};

    use super::{ImplausibleResult, of_reading, slope, too_far, too_long};

    #[test]
    fn axes_of_a_turned_part_may_be_wrong_by_a_hundredth_and_not_by_all() {
        let turned = Rotation3::from_euler_angles(0.3, -0.2, 0.5).into_inner();
        let mut long = Matrix3::identity();
        long[(0, 0)] = 1.01;
        assert_eq!(of_reading(&turned), None);
        assert_eq!(of_reading(&(long * turned)), None);
        long[(0, 0)] = 0.5;
        let found = of_reading(&(long * turned));
        assert!(matches!(found, Some(ImplausibleResult::Axes { .. })), "{found:?}");
    }

    #[test]
    fn a_tool_of_kilometres_is_named() {
        assert_eq!(too_long("the tip", "the flange", [900.0, 0.0, 1200.0]), None);
        let found = too_long("the tip", "the flange", [0.0, 2e6, 0.0]).expect("two kilometres");
        assert!(found.to_string().contains("the tip lies 2000000 mm from the flange"), "{found}");
    }

    #[test]
    fn a_workpiece_beyond_the_horizon_is_named() {
        assert_eq!(too_far([4e4, -2e4, 900.0]), None);
        let found = too_far([0.0, 3e6, 0.0]).expect("three kilometres");
        assert!(found.to_string().contains("lies 3000 m from the zero"), "{found}");
    }

    #[test]
    fn slope_of_a_reversed_axis_is_minus_two() {
        let wrapped = |deg: f64| (deg + 180.0).rem_euclid(360.0) - 180.0;
        let points: Vec<[f64; 2]> =
            (0..=18).map(|i| f64::from(i) * 10.0).map(|a| [a, wrapped(-2.0 * a)]).collect();
        assert!((slope(&points) + 2.0).abs() < 1e-12);
        assert!(slope(&[[0.0, 0.0]]).abs() < f64::EPSILON);
    }
}
