//! By what numbers in some rows may have to be multiplied.

use super::unit::Dimension;

/// By what some numbers may have to be multiplied, and why.
pub(super) struct Factor {
    pub(super) effect: &'static str,
    pub(super) what: String,
    pub(super) by: f64,
}

impl Factor {
    /// Of numbers in a unit that is so many of the file's own.
    pub(super) fn all(dimension: Dimension, declared: f64) -> Vec<Self> {
        let of = |effect, what: &str, by| Self { effect, what: what.to_owned(), by };
        let own = dimension.name_of(declared);
        let mut all = vec![of("input:sign", "of the opposite sign", -1.0)];
        all.extend(dimension.instead_of(declared).map(|(unit, by)| {
            of("input:unit", &format!("in another unit, {unit} instead of {own},"), by)
        }));
        let ten = "ten or a hundred times what it is elsewhere, or so small a part of it (another range, a decimal point)";
        all.extend(dimension.tenfold(declared).map(|by| of("input:decimal-point", ten, by)));
        let twice = "twice or half of what it is elsewhere (another gain, a diameter for a radius)";
        all.extend([0.5, 2.0].map(|by| of("input:gain", twice, by)));
        all
    }
}
