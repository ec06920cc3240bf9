//! Probe logs of a controller, alone and in the rows that a plan left open.

use std::fs;

use tempfile::TempDir;
use truing::{
    ProbeLogKind, ProbeLogSettings, import_planned_log, import_probe_log, read_case, write_imported,
};

/// A plan with two open rows.
const PLANNED: &str = "touch,x_mm,y_mm,z_mm\na,1,2,3\nb,,,\nc,,,\n";

pub(super) fn read(bytes: &[u8]) {
    let folder = TempDir::new().expect("a temporary folder can be made");
    let log = folder.path().join("log.txt");
    fs::write(&log, bytes).expect("the folder can be written to");
    fs::write(folder.path().join("touches.csv"), PLANNED).expect("the folder can be written to");
    let _ = import_planned_log(&log, folder.path(), 1.0);
    for kind in [ProbeLogKind::ProbeComp, ProbeLogKind::PoseIcp] {
        let settings = ProbeLogSettings {
            kind,
            feed_mm_per_min: Some(60.0),
            tip_radius_mm: 3.0,
            unit_mm: 25.4,
        };
        let Ok(imported) = import_probe_log(&log, &settings) else { continue };
        let case = TempDir::new().expect("a temporary folder can be made");
        write_imported(&imported.files, case.path()).expect("the folder is empty");
        let _ = read_case(case.path());
    }
}
