//! GARPOS: ranges from a ship to the sea floor, a problem without a crate, by the example of the
//! bordered core.

use std::path::Path;

use anyhow::Result;

use crate::shell;

const PLACE: &str = "garpos_saga_multilateration";
const SOURCE: &str = "github.com/s-watanabe-jhod/garpos, commit 0e463b347fac, GPL-3.0";
const REFERENCE: &str =
    "shots left out: 77.8 cm as sailed, 15.1, 7.3; 89.2, 14.1, 5.4. Whole lines: 13.8 and 5.8 cm";

/// What the example prints, where its data are.
pub(super) fn run(data: &Path) -> Result<Option<String>> {
    let place = data.join(PLACE);
    if !place.exists() {
        println!("garpos-sea-floor: skipped, {} is not there; {SOURCE}", place.display());
        return Ok(None);
    }
    let example = ["run", "--release", "--quiet", "-p", "least-squares", "--example", "sea_floor"];
    // The example may run elsewhere than this program.
    let data = std::path::absolute(data)?;
    let variable = ("TRUING_MEASURED_DATA", data.as_os_str());
    let text = shell::output_with(env!("CARGO"), &example, &[variable])?;
    println!("garpos-sea-floor\n{text}  independent calculation: {REFERENCE}");
    Ok(Some(format!(
        "\nRanges to the sea floor, {SOURCE}; independent calculation: {REFERENCE}\n\n```text\n{text}```\n"
    )))
}
