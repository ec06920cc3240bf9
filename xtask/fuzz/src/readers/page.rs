//! Pages of `--report` and lists of findings, for `truing index`.

use std::fs;

use tempfile::TempDir;
use truing::{read_findings, read_page, report::render_index};

pub(super) fn read(bytes: &[u8]) {
    let folder = TempDir::new().expect("a temporary folder can be made");
    let page = folder.path().join("page.html");
    fs::write(&page, bytes).expect("the folder can be written to");
    if let Ok(entry) = read_page(&page) {
        assert!(render_index("Index", "", &[entry]).contains("</html>"));
    }
    let _ = read_findings(&page);
}
