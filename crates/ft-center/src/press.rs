//! Presses: records with the machine position at which they were taken.

use nalgebra::Point2;

use crate::{Contact, FtCenterError, Orbit, OrbitOptions, Sample, solve_orbit};

/// What a press is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum PressRole {
    /// Position known: places the sensor in the machine.
    Frame,
    /// Position known, never fitted, only judged.
    Check,
    /// Position is where the head should be; the answer is where it is.
    Locate,
}

/// One press as recorded.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Press {
    /// Name as the user knows it.
    pub name: String,
    /// What it is for.
    pub role: PressRole,
    /// Where the head was sent, machine frame.
    pub machine_mm: Point2<f64>,
    /// Readings in the order of time.
    pub record: Vec<Sample>,
}

/// One press with its record reduced to an orbit.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SolvedPress {
    /// Name as the user knows it.
    pub name: String,
    /// What it is for.
    pub role: PressRole,
    /// Where the head was sent, machine frame.
    pub machine_mm: Point2<f64>,
    /// The record, reduced.
    pub orbit: Orbit,
}

/// Reduces every record; order is kept.
///
/// # Errors
///
/// [`FtCenterError::Press`] names the press whose record cannot be used.
pub fn solve_presses(
    presses: &[Press],
    contact: &Contact,
    options: &OrbitOptions,
) -> Result<Vec<SolvedPress>, FtCenterError> {
    let solve = |press: &Press| {
        let orbit = solve_orbit(&press.record, contact, options).map_err(|source| {
            FtCenterError::Press { name: press.name.clone(), source: Box::new(source) }
        })?;
        Ok(SolvedPress {
            name: press.name.clone(),
            role: press.role,
            machine_mm: press.machine_mm,
            orbit,
        })
    };
    presses.iter().map(solve).collect()
}
