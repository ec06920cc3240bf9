//! Streams of wrenches, as `truing monitor` takes them.

use std::sync::OnceLock;

use truing::{Case, PathMonitor, PathMonitorOptions, StreamTable, read_case};

use super::bundle::unpack;

/// Presses on a sensor that lies as the machine does.
const PRESSES: &[u8] = include_bytes!("stream/presses");

pub(super) fn read(bytes: &[u8]) {
    static CASE: OnceLock<Case> = OnceLock::new();
    let case = CASE.get_or_init(|| read_case(unpack(PRESSES).path()).expect("a case of presses"));
    let options = PathMonitorOptions { tolerance_mm: 0.5, filter_s: 0.2 };
    let mut monitor = PathMonitor::new(case, options).expect("presses give a frame");
    let mut table = StreamTable::default();
    for line in String::from_utf8_lossy(bytes).lines() {
        if StreamTable::is_header(line) {
            let Ok(named) = StreamTable::of_header(line) else { return };
            table = named;
        } else if let Ok(row) = table.row(line)
            && let Some(event) = monitor.update(&row)
        {
            assert!(!event.to_string().is_empty());
        }
    }
    let summary = monitor.summary();
    assert!(summary.farthest_mm >= 0.0 && !summary.to_string().is_empty());
}
