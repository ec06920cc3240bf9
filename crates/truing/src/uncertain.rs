//! Which numbers of a case are uncertain.

/// Numbers of one table and their standard uncertainty.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Uncertain {
    pub(crate) table: &'static str,
    pub(crate) columns: &'static [&'static str],
    pub(crate) std: Std,
}

impl Uncertain {
    /// Table and key, for people.
    pub(crate) fn name(&self) -> String {
        let by = match self.std {
            Std::Declared(key) => format!("[noise] {key}"),
            Std::Columns(columns) => columns.join(", "),
            Std::Polar { range, angle } => format!("[noise] {range}, {angle}"),
        };
        format!("{} by {by}", self.table)
    }
}

/// Where a standard uncertainty stands.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Std {
    /// A key of `[noise]`.
    Declared(&'static str),
    /// Columns of the same table, one for all numbers or one for each.
    Columns(&'static [&'static str]),
    /// Keys of `[noise]`: along the beam, and per distance across it, of a point about its tracker.
    Polar { range: &'static str, angle: &'static str },
}

/// Keys of `[noise]` that would say how uncertain the numbers are.
pub(crate) fn keys(uncertain: &[Uncertain]) -> Vec<String> {
    let mut keys = Vec::new();
    for numbers in uncertain {
        match numbers.std {
            Std::Declared(key) => keys.push(key.to_owned()),
            Std::Polar { range, angle } => keys.extend([range.to_owned(), angle.to_owned()]),
            Std::Columns(_) => {}
        }
    }
    keys.sort();
    keys.dedup();
    keys
}
