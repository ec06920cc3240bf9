//! The impedance controller, one call a cycle.

use nalgebra::Vector3;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use truing::force_impedance::{
    self, ControllerSettings, ImpedanceParameters, Measurement, ReferenceMode, Status,
};

use crate::head::Head;
use crate::refusal::Refusal;

/// Force control by position impedance along the surface normal.
#[pyclass(module = "truing", name = "Controller")]
#[derive(Debug)]
pub(crate) struct Controller {
    controller: force_impedance::Controller,
}

#[pymethods]
impl Controller {
    #[new]
    #[pyo3(signature = (head, *, mass_kg, damping_ns_per_mm, stiffness_n_per_mm=0.0, interval_s=1e-3, absolute=false))]
    fn new(
        head: PyRef<'_, Head>,
        mass_kg: f64,
        damping_ns_per_mm: f64,
        stiffness_n_per_mm: f64,
        interval_s: f64,
        absolute: bool,
    ) -> Result<Self, Refusal> {
        let parameters = ImpedanceParameters { mass_kg, damping_ns_per_mm, stiffness_n_per_mm };
        let mode = if absolute { ReferenceMode::Absolute } else { ReferenceMode::Rebased };
        let settings = ControllerSettings { interval_s, mode, ..ControllerSettings::default() };
        let controller = force_impedance::Controller::new(head.head, parameters, settings)?;
        Ok(Self { controller })
    }

    /// One cycle: readings in, lengths to command out.
    #[pyo3(signature = (lengths_mm, cells_n, normal, reference_n, dt_s))]
    fn update<'py>(
        &mut self,
        py: Python<'py>,
        lengths_mm: Option<[f64; 4]>,
        cells_n: Option<[f64; 4]>,
        normal: [f64; 3],
        reference_n: f64,
        dt_s: f64,
    ) -> PyResult<Bound<'py, PyDict>> {
        let normal = Vector3::from(normal);
        let seen = Measurement { lengths_mm, cells_n, normal, reference_n };
        let command = self.controller.update(&seen, dt_s);
        let found = PyDict::new(py);
        found.set_item("lengths_mm", command.lengths_mm)?;
        found.set_item("tip_mm", <[f64; 3]>::from(command.tip_mm))?;
        found.set_item("offset_mm", command.offset_mm)?;
        found.set_item("reference_n", command.reference_n)?;
        found.set_item("normal_n", command.contact.map(|c| c.normal_n))?;
        found.set_item("tangential_n", command.contact.map(|c| c.tangential_n))?;
        let (status, fault) = match command.status {
            Status::Controlling => ("controlling", None),
            Status::NoContact => ("no-contact", None),
            Status::Recovering => ("recovering", None),
            Status::Held(fault) => ("held", Some(fault)),
            Status::Retracting(fault) => ("retracting", Some(fault)),
        };
        found.set_item("status", status)?;
        found.set_item("fault", fault.map(|f| format!("{f:?}")))?;
        found.set_item("limited", command.limits.any())?;
        Ok(found)
    }
}
