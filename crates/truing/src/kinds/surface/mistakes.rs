//! What may be wrong with the numbers of a drawing.

use crate::case::Files;
use crate::suspect::{Hypothesis, lengths, scaled_setting};

/// Sign and unit of the vertex radius, the diameter for the radius, the sign of the conic.
pub(crate) fn mistakes_of_drawing(files: &Files) -> Vec<Hypothesis> {
    let document = &files.document;
    let mut all = lengths(document, &["surface", "radius_mm"]);
    let bowl = "of the opposite sign (bowl for dome, inward normal)";
    let radius = ["surface", "radius_mm"];
    all.extend(scaled_setting(document, &radius, "input:sign", bowl, -1.0));
    let conic = ["surface", "conic"];
    all.extend(scaled_setting(document, &conic, "input:sign", "of the opposite sign", -1.0));
    all.extend(lengths(document, &["surface", "unit_mm"]));
    all
}
