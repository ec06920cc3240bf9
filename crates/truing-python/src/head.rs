//! The polishing head, and contact forces from its legs.

use nalgebra::{Unit, Vector3};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use truing::force_impedance::{self, ForceFormula, HeadGeometry, HeadLimits, LogSample, solve_log};

use crate::arrays::{Table, column, rows, rows_of, vectors};
use crate::refusal::Refusal;

/// A polishing head on three radial legs and one axial unit.
#[pyclass(frozen, module = "truing", name = "Head")]
#[derive(Debug)]
pub(crate) struct Head {
    pub(crate) head: force_impedance::Head,
}

#[pymethods]
impl Head {
    #[new]
    #[pyo3(signature = (
        *, tip_to_plane_mm, plane_to_joint_mm, head_radius_mm, bracket_radius_mm, leg_angles_rad,
        weight_n=0.0, center_of_gravity_mm=0.0, gravity_direction=[0.0, 0.0, -1.0]
    ))]
    fn new(
        tip_to_plane_mm: f64,
        plane_to_joint_mm: f64,
        head_radius_mm: f64,
        bracket_radius_mm: f64,
        leg_angles_rad: [f64; 3],
        weight_n: f64,
        center_of_gravity_mm: f64,
        gravity_direction: [f64; 3],
    ) -> Result<Self, Refusal> {
        let geometry = HeadGeometry {
            tip_to_plane_mm,
            plane_to_joint_mm,
            head_radius_mm,
            bracket_radius_mm,
            leg_angles_rad,
            weight_n,
            center_of_gravity_mm,
            gravity_direction: Vector3::from(gravity_direction),
        };
        let head = force_impedance::Head::new(geometry, HeadLimits::wide(&geometry))?;
        Ok(Self { head })
    }

    /// Lengths of the legs and the axial unit that put the tip somewhere.
    fn lengths_mm(&self, tip_mm: [f64; 3]) -> Result<[f64; 4], Refusal> {
        Ok(self.head.pose_at(&tip_mm.into())?.lengths_mm)
    }

    /// Contact force of every reading of legs and load cells.
    #[pyo3(signature = (lengths_mm, cells_n, normals, formula="full-balance"))]
    fn contact_force<'py>(
        &self,
        py: Python<'py>,
        lengths_mm: Table<'py>,
        cells_n: Table<'py>,
        normals: Table<'py>,
        formula: &str,
    ) -> PyResult<Bound<'py, PyDict>> {
        let formula = match formula {
            "full-balance" => ForceFormula::FullBalance,
            "published" => ForceFormula::Published,
            found => {
                return Err(Refusal::word("formula", found, &["full-balance", "published"]).into());
            }
        };
        let lengths_mm = rows::<4>("lengths_mm", &lengths_mm)?;
        let n = lengths_mm.len();
        let cells_n = rows_of::<4>("cells_n", &cells_n, n)?;
        let normals = rows_of::<3>("normals", &normals, n)?;
        let solved = py.detach(|| {
            let sample = |i: usize| LogSample {
                // Readings are one by one: their times are their order.
                time_s: f64::from(u32::try_from(i).unwrap_or(u32::MAX)),
                lengths_mm: lengths_mm[i],
                cells_n: cells_n[i],
                normal: Unit::new_normalize(Vector3::from(normals[i])),
                reference_n: None,
                segment: 0,
            };
            let samples: Vec<LogSample> = (0..n).map(sample).collect();
            solve_log(&self.head, &samples, formula)
        });
        let solved = solved.map_err(Refusal::from)?;
        let found = PyDict::new(py);
        let all = || solved.iter();
        found.set_item("normal_n", column(py, all().map(|s| s.normal_n).collect()))?;
        found.set_item("tangential_n", column(py, all().map(|s| s.tangential_n).collect()))?;
        found.set_item("preload_n", column(py, all().map(|s| s.preload_n).collect()))?;
        found.set_item("consistency_mm", column(py, all().map(|s| s.consistency_mm).collect()))?;
        found.set_item("noise_gain", column(py, all().map(|s| s.noise_gain).collect()))?;
        found.set_item("tip_mm", vectors(py, all().map(|s| &s.tip_mm)))?;
        Ok(found)
    }

    fn __repr__(&self) -> String {
        format!("{:?}", self.head)
    }
}
