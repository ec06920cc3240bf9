use std::collections::BTreeMap;

use model_discrepancy::Quantity;
use serde::Deserialize;
use toml::Spanned;

use super::document::Document;
use super::folder::Folder;
use super::group::no_column;
use super::table::Table;
use crate::Error;

/// `[loop] columns`: the quantities of recorded columns, where their names do not say them.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(transparent)]
pub(crate) struct ColumnKinds(BTreeMap<Spanned<String>, Name>);

/// A quantity as it is written in `case.toml`.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Name {
    Time,
    Temperature,
    Angle,
    Position,
    Other,
}

impl ColumnKinds {
    /// What the column called `name` holds: as declared, or else as its name says.
    pub(crate) fn of(&self, name: &str) -> Quantity {
        let declared = self.0.iter().find(|(column, _)| column.get_ref() == name);
        match declared.map(|(_, quantity)| quantity) {
            Some(Name::Time) => Quantity::Time,
            Some(Name::Temperature) => Quantity::Temperature,
            Some(Name::Angle) => Quantity::Angle,
            Some(Name::Position) => Quantity::Position,
            Some(Name::Other) => Quantity::Other,
            None => quantity_of(name),
        }
    }

    /// Every column that is declared is one of these tables.
    pub(crate) fn check(
        &self,
        folder: &Folder,
        tables: &[&'static str],
        document: &Document,
    ) -> Result<(), Error> {
        if self.0.is_empty() {
            return Ok(());
        }
        let there = tables.iter().filter(|file| folder.has(file));
        let tables = there.map(|file| folder.table(file, &[])).collect::<Result<Vec<_>, _>>()?;
        let tables: Vec<&Table> = tables.iter().collect();
        let absent = |column: &&Spanned<String>| {
            tables.iter().all(|table| table.column(column.get_ref()).is_none())
        };
        match self.0.keys().find(absent) {
            Some(column) => Err(no_column(column, &tables, document.at(&column.span()))),
            None => Ok(()),
        }
    }
}

/// Words at the beginning of a name after which `_a`, `_b` and `_c` are rotary axes, not units.
const OF_AN_AXIS: [&str; 8] =
    ["actual", "angle", "axis", "commanded", "pos", "position", "target", "encoder"];

/// What a column of this name holds: the unit at its end says it.
///
/// `_s` is a time, `_c` a temperature in °C, `_deg` and `_rad` an angle, `_mm` a position. A name as
/// `pos_c` is the position of axis C.
#[must_use]
pub fn quantity_of(name: &str) -> Quantity {
    let Some((stem, unit)) = name.rsplit_once('_') else { return Quantity::Other };
    let of_an_axis = OF_AN_AXIS.contains(&stem.rsplit('_').next().unwrap_or(stem));
    match unit {
        "a" | "b" | "c" if of_an_axis => Quantity::Angle,
        "c" => Quantity::Temperature,
        // A length per second is no time: `feed_mm_s`.
        "s" if !stem.ends_with("_mm") => Quantity::Time,
        "deg" => Quantity::Angle,
        "mm" => Quantity::Position,
        _ => Quantity::Other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_of_a_name_says_the_quantity() {
        let expected = [
            ("time_s", Quantity::Time),
            ("air_c", Quantity::Temperature),
            ("spindle_front_c", Quantity::Temperature),
            ("pos_c", Quantity::Angle),
            ("machine_axis_b", Quantity::Angle),
            ("table_deg", Quantity::Angle),
            ("from_x_mm", Quantity::Position),
            ("feed_mm_s", Quantity::Other),
            ("load", Quantity::Other),
            ("c", Quantity::Other),
        ];
        for (name, quantity) in expected {
            assert_eq!(quantity_of(name), quantity, "{name}");
        }
    }
}
