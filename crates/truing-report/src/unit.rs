//! Units for people.

/// The unit in which a page shows residuals and errors.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Shown {
    /// Shown value = value in the layout's unit × `factor`.
    pub(crate) factor: f64,
    /// Name of the unit shown.
    pub(crate) unit: String,
}

/// Below this a smaller unit reads better: `48 µm`, not `0.048 mm`.
const SMALL: f64 = 0.1;

/// Smaller units of those in which residuals come: from, factor, to.
const SMALLER: &[(&str, f64, &str)] = &[
    ("mm", 1e3, "µm"),
    ("µm", 1e3, "nm"),
    ("N", 1e3, "mN"),
    ("rad", 1e3, "mrad"),
    ("mrad", 1e3, "µrad"),
];

impl Shown {
    /// The unit in which a value of size `typical` reads well.
    pub(crate) fn for_size(unit: &str, typical: f64) -> Self {
        let mut shown = Self { factor: 1.0, unit: unit.to_string() };
        while typical * shown.factor < SMALL && typical > 0.0 {
            let Some((_, factor, to)) = SMALLER.iter().find(|(from, ..)| *from == shown.unit)
            else {
                break;
            };
            shown = Self { factor: shown.factor * factor, unit: (*to).to_string() };
        }
        shown
    }

    /// «quantity, unit», or the quantity alone where there is no unit.
    pub(crate) fn title(&self, quantity: &str) -> String {
        with_unit(quantity, &self.unit)
    }
}

/// «quantity, unit», or the quantity alone where there is no unit.
pub(crate) fn with_unit(quantity: &str, unit: &str) -> String {
    if unit.is_empty() { quantity.to_string() } else { format!("{quantity}, {unit}") }
}

/// Suffixes of column names; the longer first where one ends the other.
const SUFFIXES: &[(&str, &str)] = &[
    ("_mm_per_s", "mm/s"),
    ("_n_per_mm", "N/mm"),
    ("_nmm", "N·mm"),
    ("_mm", "mm"),
    ("_um", "µm"),
    ("_deg", "°"),
    ("_rad", "rad"),
    ("_ppm", "ppm"),
    ("_hz", "Hz"),
    ("_kg", "kg"),
    ("_n", "N"),
    ("_s", "s"),
    ("_c", "°C"),
];

/// Title of an axis from a column's name: `temperature_c` gives «temperature, °C».
pub(crate) fn column_title(column: &str) -> String {
    for (suffix, unit) in SUFFIXES {
        match column.strip_suffix(suffix) {
            Some(stem) if !stem.is_empty() => return with_unit(stem, unit),
            _ => {}
        }
    }
    column.to_string()
}
