//! Units as the suffixes of names.

/// Suffixes that case files use, and the word for the unit.
const EXPECTED: [(&str, &str); 8] = [
    ("mm", "mm"),
    ("n", "N"),
    ("nmm", "N·mm"),
    ("deg", "degrees"),
    ("rad", "rad"),
    ("s", "s"),
    ("c", "°C"),
    ("kg", "kg"),
];

/// Suffixes people use for the same quantities, which case files do not.
const OTHERS: [&str; 37] = [
    "um",
    "m",
    "cm",
    "dm",
    "nm",
    "in",
    "inch",
    "inches",
    "mil",
    "ft",
    "kn",
    "mn",
    "lbf",
    "lb",
    "kgf",
    "gf",
    "ncm",
    "knmm",
    "mnm",
    "lbin",
    "ms",
    "us",
    "ns",
    "min",
    "h",
    "k",
    "f",
    "g",
    "t",
    "urad",
    "mrad",
    "arcsec",
    "arcmin",
    "grad",
    "newton",
    "meters",
    "millimeters",
];

/// The word for the unit that `name` ends in, if it ends in one of the contract's.
pub(crate) fn unit_of(name: &str) -> Option<&'static str> {
    let (_, suffix) = name.rsplit_once('_')?;
    EXPECTED.iter().find(|(s, _)| *s == suffix).map(|(_, unit)| *unit)
}

/// Whether `found` is `expected` with another unit, or with none.
pub(crate) fn differs_in_unit(found: &str, expected: &str) -> bool {
    if unit_of(expected).is_none() {
        return false;
    }
    let Some((stem, expected_suffix)) = expected.rsplit_once('_') else { return false };
    let found = found.to_ascii_lowercase();
    if found == stem {
        return true;
    }
    let Some((found_stem, suffix)) = found.rsplit_once('_') else { return false };
    let is_unit = EXPECTED.iter().any(|(s, _)| *s == suffix) || OTHERS.contains(&suffix);
    found_stem == stem && suffix != expected_suffix && is_unit
}

#[cfg(test)]
mod tests {
    use super::{differs_in_unit, unit_of};

    #[test]
    fn knows_the_units_of_names() {
        assert_eq!(unit_of("mx_nmm"), Some("N·mm"));
        assert_eq!(unit_of("point"), None);
        assert_eq!(unit_of("from_x_um"), None);
    }

    #[test]
    fn tells_another_unit_from_another_quantity() {
        assert!(differs_in_unit("from_x_um", "from_x_mm"));
        assert!(differs_in_unit("fx_kn", "fx_n"));
        assert!(differs_in_unit("mx_nm", "mx_nmm"));
        assert!(differs_in_unit("From_X", "from_x_mm"));
        assert!(!differs_in_unit("from_x_mm", "from_x_mm"));
        assert!(!differs_in_unit("from_y_um", "from_x_mm"));
        assert!(!differs_in_unit("from_x_raw", "from_x_mm"));
        assert!(!differs_in_unit("point_mm", "point"));
    }
}
