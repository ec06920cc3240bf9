//! Errors as exceptions with file, line and free direction.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;
use truing::force_impedance::ForceImpedanceError;
use truing::frame_fit::FrameFitError;
use truing::ft_center::FtCenterError;
use truing::model_discrepancy::LoopError;
use truing::pose_icp::{PoseError, RegisterError};
use truing::probe_comp::ProbeError;
use truing::tracker_lm::TrackerError;
use truing::{Error, Location};

use crate::free;

/// What is wrong, in the words of the command line, and where.
#[derive(Debug)]
pub(crate) struct Refusal {
    message: String,
    place: Option<Box<Location>>,
    /// Position in the input, from 0.
    index: Option<usize>,
    /// Whether the input is usable in form, but leaves something free.
    undetermined: bool,
    free_direction: Option<String>,
}

impl Refusal {
    /// Input that cannot be used.
    pub(crate) fn of(message: String) -> Self {
        Self { message, place: None, index: None, undetermined: false, free_direction: None }
    }

    /// An array of another shape than is needed.
    pub(crate) fn shape(name: &str, needed: &str, found: &[usize]) -> Self {
        let found: Vec<String> = found.iter().map(ToString::to_string).collect();
        Self::of(format!("{name} must have the shape {needed}, got {}", found.join(" × ")))
    }

    /// An index that would count from the end, as `Python`'s do; of reading `reading`, from 0.
    pub(crate) fn below_zero(name: &str, reading: usize, found: i64) -> Self {
        let message = format!("{name} of reading {} is {found}; indices count from 0", reading + 1);
        Self { index: Some(reading), ..Self::of(message) }
    }

    /// A word that is none of those that there are.
    pub(crate) fn word(name: &str, found: &str, known: &[&str]) -> Self {
        Self::of(format!("{name} must be one of {}, got {found:?}", known.join(", ")))
    }

    /// Of an error in arrays, which has no file.
    fn of_arrays(source: impl FnOnce(Box<Location>) -> Error, index: Option<usize>) -> Self {
        let nowhere = Location { file: PathBuf::new(), line: None, column: None, name: None };
        let error = source(Box::new(nowhere));
        let message = error.to_string();
        // The facade says first where a case is wrong: here, at nothing.
        let message = message.strip_prefix(": ").map_or(message.clone(), str::to_owned);
        Self { message, place: None, index, ..Self::from(error) }
    }

    fn raise(self, py: Python<'_>) -> PyResult<PyErr> {
        static INPUT: PyOnceLock<Py<PyType>> = PyOnceLock::new();
        static NOT_DETERMINED: PyOnceLock<Py<PyType>> = PyOnceLock::new();
        let kind = if self.undetermined {
            NOT_DETERMINED.import(py, "truing.errors", "NotDeterminedError")?
        } else {
            INPUT.import(py, "truing.errors", "InputError")?
        };
        let exception = kind.call1((self.message,))?;
        if let Some(place) = self.place {
            exception.setattr("file", place.file.to_string_lossy())?;
            exception.setattr("line", place.line)?;
            exception.setattr("column", place.column)?;
            exception.setattr("name", place.name)?;
        }
        exception.setattr("index", self.index)?;
        exception.setattr("free_direction", self.free_direction)?;
        Ok(PyErr::from_value(exception))
    }
}

impl From<Refusal> for PyErr {
    fn from(refusal: Refusal) -> Self {
        Python::attach(|py| refusal.raise(py).unwrap_or_else(|error| error))
    }
}

impl From<Error> for Refusal {
    fn from(error: Error) -> Self {
        Self {
            message: error.to_string(),
            place: place(&error),
            index: None,
            undetermined: error.is_undetermined(),
            free_direction: free::of(&error),
        }
    }
}

/// Where an error of a case is.
fn place(error: &Error) -> Option<Box<Location>> {
    match error {
        Error::Case { at, .. }
        | Error::FrameFit { at, .. }
        | Error::FtCenter { at, .. }
        | Error::PoseIcp { at, .. }
        | Error::ProbeComp { at, .. }
        | Error::ForceImpedance { at, .. }
        | Error::TrackerLm { at, .. }
        | Error::Loop { at, .. } => Some(at.clone()),
        Error::Input { source, .. } => place(source),
        Error::Carry { path, .. }
        | Error::Exists { path }
        | Error::NotRead { path, .. }
        | Error::NotWritten { path, .. }
        | Error::OutputIsInput { path, .. } => {
            let file = path.clone();
            Some(Box::new(Location { file, line: None, column: None, name: None }))
        }
        _ => None,
    }
}

impl From<FrameFitError> for Refusal {
    fn from(source: FrameFitError) -> Self {
        let index = match source {
            FrameFitError::InvalidPair { index, .. } => Some(index),
            _ => None,
        };
        Self::of_arrays(|at| Error::FrameFit { at, source }, index)
    }
}

impl From<FtCenterError> for Refusal {
    fn from(source: FtCenterError) -> Self {
        let index = match source {
            FtCenterError::NotFinite { index } | FtCenterError::TimeNotIncreasing { index, .. } => {
                Some(index)
            }
            _ => None,
        };
        Self::of_arrays(|at| Error::FtCenter { at, source: Box::new(source) }, index)
    }
}

impl From<PoseError> for Refusal {
    fn from(source: PoseError) -> Self {
        let index = match source {
            PoseError::InvalidTouch { index, .. }
            | PoseError::NoFoot { index, .. }
            | PoseError::OutsideAperture { index, .. }
            | PoseError::TipTooLarge { index, .. } => Some(index),
            _ => None,
        };
        Self::of_arrays(|at| Error::PoseIcp { at, source: Box::new(source) }, index)
    }
}

impl From<ProbeError> for Refusal {
    fn from(source: ProbeError) -> Self {
        let index = source.touch();
        Self::of_arrays(|at| Error::ProbeComp { at, source: Box::new(source) }, index)
    }
}

impl From<ForceImpedanceError> for Refusal {
    fn from(source: ForceImpedanceError) -> Self {
        let index = match source {
            ForceImpedanceError::Sample { index, .. }
            | ForceImpedanceError::TimeNotIncreasing { index, .. } => Some(index),
            _ => None,
        };
        Self::of_arrays(|at| Error::ForceImpedance { at, source: Box::new(source) }, index)
    }
}

impl From<TrackerError> for Refusal {
    fn from(source: TrackerError) -> Self {
        let index = match source {
            TrackerError::InvalidNumber { index, .. } => Some(index),
            TrackerError::UnknownIndex { range, .. }
            | TrackerError::DuplicateRange { range, .. } => Some(range),
            _ => None,
        };
        Self::of_arrays(|at| Error::TrackerLm { at, source: Box::new(source) }, index)
    }
}

impl From<LoopError> for Refusal {
    fn from(source: LoopError) -> Self {
        Self::of_arrays(|at| Error::Loop { at, source }, None)
    }
}

impl From<RegisterError> for Refusal {
    fn from(source: RegisterError) -> Self {
        let index = match source {
            RegisterError::InvalidPoint { index, .. }
            | RegisterError::InvalidNormal { index, .. }
            | RegisterError::NoPlane { index, .. } => Some(index),
            _ => None,
        };
        let path = PathBuf::new();
        Self::of_arrays(|_| Error::Register { path, source: Box::new(source) }, index)
    }
}
