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

/// Suffixes that are converted: the one that case files use, the one found, and the number that
/// turns a value into the former, as a quotient so that decimals stay what they are.
///
/// `_nm` is a newton metre where a moment is expected, and nothing where a length is: that would be
/// a nanometre.
const CONVERTED: [(&str, &str, f64, f64); 7] = [
    ("mm", "um", 1.0, 1e3),
    ("mm", "µm", 1.0, 1e3),
    ("mm", "μm", 1.0, 1e3),
    ("mm", "m", 1e3, 1.0),
    ("mm", "in", 25.4, 1.0),
    ("mm", "inch", 25.4, 1.0),
    ("nmm", "nm", 1e3, 1.0),
];

/// How values of one column become those of another unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Conversion {
    times: f64,
    over: f64,
}

impl Conversion {
    pub(crate) fn of(self, value: f64) -> f64 {
        value * self.times / self.over
    }
}

impl std::fmt::Display for Conversion {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.over {
            1.0 => write!(f, "times {}", self.times),
            over => write!(f, "divided by {over}"),
        }
    }
}

/// How `found` becomes `expected`, where it is the same quantity in a unit that is converted.
pub(crate) fn conversion(found: &str, expected: &str) -> Option<Conversion> {
    let (stem, suffix) = expected.rsplit_once('_')?;
    let unit = found.strip_prefix(stem)?.strip_prefix('_')?;
    let (_, _, times, over) = *CONVERTED.iter().find(|(e, f, ..)| *e == suffix && *f == unit)?;
    Some(Conversion { times, over })
}

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
    use super::{conversion, differs_in_unit, unit_of};

    #[test]
    fn converts_what_is_one_quantity_in_one_unit() {
        let of = |found, expected| conversion(found, expected).map(|c| c.of(1500.0));
        assert_eq!(of("from_x_um", "from_x_mm"), Some(1.5));
        assert_eq!(of("x_µm", "x_mm"), Some(1.5));
        assert_eq!(of("x_in", "x_mm"), Some(38_100.0));
        assert_eq!(of("x_m", "x_mm"), Some(1_500_000.0));
        assert_eq!(of("mx_nm", "mx_nmm"), Some(1_500_000.0));
        for (found, expected) in
            [("x_nm", "x_mm"), ("y_um", "x_mm"), ("x_mm", "x_mm"), ("fx_kn", "fx_n"), ("x", "x_mm")]
        {
            assert_eq!(of(found, expected), None, "{found}");
        }
    }

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
