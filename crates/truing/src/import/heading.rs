//! Headings of foreign tables: which quantity, in which unit.

/// Units by the ways they are written: the suffix of case files, the number that makes a value one
/// in it, as a quotient so that decimals stay what they are, and what is added then.
const UNITS: [(&[&str], &str, f64, f64); 22] = [
    (&["mm"], "mm", 1.0, 1.0),
    (&["um", "µm", "μm", "micron", "microns"], "mm", 1.0, 1e3),
    (&["cm"], "mm", 10.0, 1.0),
    (&["m"], "mm", 1e3, 1.0),
    (&["in", "inch", "inches", "\""], "mm", 25.4, 1.0),
    (&["n"], "n", 1.0, 1.0),
    (&["kn"], "n", 1e3, 1.0),
    (&["nmm", "n·mm", "n*mm", "n.mm"], "nmm", 1.0, 1.0),
    (&["nm", "n·m", "n*m", "n.m"], "nmm", 1e3, 1.0),
    (&["deg", "°", "degree", "degrees"], "deg", 1.0, 1.0),
    (&["rad"], "rad", 1.0, 1.0),
    (&["mrad"], "rad", 1.0, 1e3),
    (&["urad", "µrad", "μrad"], "rad", 1.0, 1e6),
    (&["rad"], "deg", 180.0, std::f64::consts::PI),
    (&["arcmin"], "deg", 1.0, 60.0),
    (&["arcsec"], "deg", 1.0, 3600.0),
    (&["s", "sec", "seconds"], "s", 1.0, 1.0),
    (&["ms"], "s", 1.0, 1e3),
    (&["us", "µs", "μs"], "s", 1.0, 1e6),
    (&["min"], "s", 60.0, 1.0),
    (&["c", "°c"], "c", 1.0, 1.0),
    (&["kg"], "kg", 1.0, 1.0),
];

/// How values in one unit become values in another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Factor {
    times: f64,
    over: f64,
}

impl Factor {
    pub(super) const ONE: Self = Self { times: 1.0, over: 1.0 };

    pub(super) fn of(self, value: f64) -> f64 {
        value * self.times / self.over
    }
}

/// How values in `unit`, however it is written, become those that the suffix of `column` says;
/// `None` where they are another quantity.
pub(super) fn factor(unit: &str, column: &str) -> Option<Factor> {
    let unit = unit.trim().to_lowercase();
    let (_, suffix) = column.rsplit_once('_')?;
    let found = UNITS.iter().find(|(names, to, ..)| *to == suffix && names.contains(&&*unit))?;
    Some(Factor { times: found.2, over: found.3 })
}

/// Whether the suffix of `column` is a unit.
pub(super) fn has_unit(column: &str) -> bool {
    let suffix = column.rsplit_once('_').map(|(_, suffix)| suffix);
    UNITS.iter().any(|(_, to, ..)| Some(*to) == suffix)
}

/// Unit of length that the heading of a coordinate says; `mm` however it is written.
pub(crate) fn unit_of_coordinate(text: &str) -> Option<String> {
    let Heading { words, unit } = heading(text);
    let is_coordinate = words.iter().any(|word| matches!(word.as_str(), "x" | "y" | "z"));
    unit.filter(|unit| is_coordinate && factor(unit, "x_mm").is_some())
}

/// A heading taken apart.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Heading {
    /// Its words in lower case, in alphabetical order: `From X` and `x_from` are the same.
    pub(super) words: Vec<String>,
    /// Its unit, in brackets or as the last word.
    pub(super) unit: Option<String>,
}

/// Takes `X from [µm]`, `x_from_um` or `From X (um)` apart.
pub(super) fn heading(text: &str) -> Heading {
    let lower = text.trim().to_lowercase();
    let bracketed = [('[', ']'), ('(', ')'), ('<', '>')].into_iter().find_map(|(open, close)| {
        let (before, rest) = lower.split_once(open)?;
        let (unit, after) = rest.split_once(close)?;
        after.trim().is_empty().then(|| (before.to_owned(), unit.trim().to_owned()))
    });
    let sloped = || {
        let (before, unit) = lower.rsplit_once('/')?;
        Some((before.to_owned(), unit.trim().to_owned()))
    };
    let (stem, mut unit) = match bracketed.or_else(sloped) {
        Some((stem, unit)) => (stem, Some(unit)),
        None => (lower.clone(), None),
    };
    let is_gap = |c: char| !c.is_alphanumeric();
    let mut words: Vec<String> =
        stem.split(is_gap).filter(|w| !w.is_empty()).map(str::to_owned).collect();
    if unit.is_none() && words.len() > 1 {
        let known = |word: &String| UNITS.iter().any(|(names, ..)| names.contains(&word.as_str()));
        unit = words.pop_if(|word| known(word));
    }
    words.sort();
    Heading { words, unit }
}

#[cfg(test)]
mod tests {
    use super::{factor, heading};

    #[test]
    fn headings_in_any_form() {
        let expected = heading("from_x_um");
        assert_eq!(expected.words, ["from", "x"]);
        for text in ["From X [um]", "X from (um)", "from-x / um", " FROM X um"] {
            assert_eq!(heading(text), expected, "{text}");
        }
        assert_eq!(heading("Point").unit, None);
        assert_eq!(heading("m").unit, None, "a name alone is no unit");
        assert_eq!(heading("mx_nmm").unit.as_deref(), Some("nmm"));
    }

    #[test]
    fn units_are_of_one_quantity() {
        let of = |unit, column| factor(unit, column).map(|f| f.of(1500.0));
        assert_eq!(of("µm", "from_x_mm"), Some(1.5));
        assert_eq!(of("N·m", "mx_nmm"), Some(1.5e6));
        assert_eq!(of("arcsec", "angle_deg"), Some(1500.0 / 3600.0));
        assert_eq!(of("N", "from_x_mm"), None);
        assert_eq!(of("furlong", "from_x_mm"), None);
    }
}
