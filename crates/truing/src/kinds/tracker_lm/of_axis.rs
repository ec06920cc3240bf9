//! What was found of one axis, as it is shown and handed out.

use tracker_lm::{AxisError, AxisLetter, axis_errors_csv, heidenhain_table, linuxcnc_compensation};
use truing_report::{Curve, CurvePlot, ExtraPlot};

use super::axis_error::{AxisErrorEstimate, AxisLocationEstimate};
use super::plausible::{FoundAxis, implausible};
use crate::estimated::Export;
use crate::implausible::ImplausibleResult;
use crate::text_table::{Cell, TextTable, number};

/// What was found of one axis.
pub(super) struct OfAxis<'a> {
    pub(super) letter: AxisLetter,
    /// Declared direction.
    pub(super) direction: [f64; 3],
    pub(super) errors: &'a [AxisErrorEstimate],
    pub(super) location: Option<&'a AxisLocationEstimate>,
}

impl OfAxis<'_> {
    /// Angle and rotation error about the axis itself, degrees.
    pub(super) fn own_rotation_deg(&self) -> Vec<[f64; 2]> {
        let own = match self.letter {
            AxisLetter::A => 3,
            AxisLetter::B => 4,
            AxisLetter::C => 5,
        };
        let of = |e: &AxisErrorEstimate| [e.angle_deg, e.numbers()[own].to_degrees()];
        self.errors.iter().map(of).collect()
    }

    pub(super) fn table(&self, reference: &str) -> TextTable {
        let columns = [
            "angle °",
            "e_x µm",
            "e_y µm",
            "e_z µm",
            "e_a µrad",
            "e_b µrad",
            "e_c µrad",
            "U e_x µm",
            "U e_y µm",
            "U e_z µm",
            "U e_a µrad",
            "U e_b µrad",
            "U e_c µrad",
        ];
        let letter = self.letter.letter();
        let title = format!("errors of axis {letter}, {reference}; U with k = 2");
        let mut table = TextTable::new(title, &columns);
        for e in self.errors {
            let factor = |c: usize| if c % 6 < 3 { 1e3 } else { 1e6 };
            let shown: [f64; 12] = std::array::from_fn(|c| e.numbers()[c] * factor(c));
            let errors = (0..6).map(|c| Cell::Known(shown[c], Some(shown[6 + c])));
            let expanded = (6..12).map(|c| Cell::Expanded(Some(shown[c])));
            let angle = std::iter::once(Cell::from(number(Some(e.angle_deg))));
            table.push(angle.chain(errors).chain(expanded).collect());
        }
        table
    }

    pub(super) fn implausible(&self, limit_deg: f64) -> Option<ImplausibleResult> {
        let location = self.location.into_iter();
        let found = FoundAxis {
            letter: self.letter.letter(),
            direction: self.direction,
            own_rotation_deg: &self.own_rotation_deg(),
            location: location
                .flat_map(|l| l.names.iter().map(String::as_str).zip(l.values))
                .collect(),
        };
        implausible(&found, limit_deg)
    }
}

/// Errors of one axis as a file.
pub(super) fn file(
    letter: AxisLetter,
    errors: &[AxisError],
    reversal: Option<[f64; 6]>,
    format: Export,
) -> String {
    match format {
        Export::Csv => axis_errors_csv(letter, errors),
        Export::LinuxCnc => {
            linuxcnc_compensation(letter, errors, &reversal.unwrap_or_default().into())
        }
        // Points have a table of their own.
        Export::Heidenhain | Export::PointErrors(_) => heidenhain_table(letter, errors),
    }
}

/// Displacements and rotations of one axis.
pub(super) fn plots_of(
    (letter, errors, of, caption): (AxisLetter, &[AxisErrorEstimate], &str, &str),
) -> [ExtraPlot; 2] {
    let names = letter.error_names();
    let plot = |what: &str, unit: &str, first: usize, factor: f64| {
        let curve = |c: usize| {
            let mut points: Vec<([f64; 2], f64)> = (errors.iter())
                .map(|e| {
                    let numbers = e.numbers();
                    let half = 1.96 * numbers[6 + c] * factor;
                    ([e.angle_deg, numbers[c] * factor], half)
                })
                .collect();
            points.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
            let (points, half_widths) = points.into_iter().unzip();
            Curve { name: names[c].clone(), points, half_widths, joined: true }
        };
        let letter = letter.letter();
        ExtraPlot::Curves(CurvePlot {
            title: format!("{what} {of} of axis {letter}"),
            caption: caption.to_owned(),
            x_title: format!("{letter} (°)"),
            y_title: format!("error ({unit})"),
            curves: (first..first + 3).map(curve).collect(),
        })
    };
    [plot("Displacement", "µm", 0, 1e3), plot("Rotation", "µrad", 3, 1e6)]
}
