//! Foreign tables, for `truing import table`.

use std::fs;

use tempfile::TempDir;
use truing::{ColumnMap, TableImport, import_table};

/// A kind and one of its tables for every reader of numbers that there is.
const TABLES: [(&str, &str); 4] = [
    ("frame-fit", "pairs.csv"),
    ("ft-center", "wrench.csv"),
    ("probe-comp", "touches.csv"),
    ("force-impedance", "log.csv"),
];

/// A table below one line that says what a column of it is, as `--map` does.
pub(super) fn read(bytes: &[u8]) {
    let end = bytes.iter().position(|byte| *byte == b'\n').map_or(0, |at| at + 1);
    let (first, table) = bytes.split_at(end);
    let map: Vec<ColumnMap> = String::from_utf8_lossy(first).trim().parse().into_iter().collect();
    let folder = TempDir::new().expect("a temporary folder can be made");
    let file = folder.path().join("table.csv");
    fs::write(&file, table).expect("the folder can be written to");
    for (kind, table) in TABLES {
        let (kind, table) = (kind.to_owned(), Some(table.to_owned()));
        if let Err(error) = import_table(&file, &TableImport { kind, table, map: map.clone() }) {
            assert_eq!(error.exit_code(), 2, "{error}");
        }
    }
}
