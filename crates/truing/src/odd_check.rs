//! A reading that was set aside and lies far off by itself.

use crate::Case;
use crate::case::{Change, Edit};

/// Column that says what a row is for, and what it says of one that is set aside.
const USE: &str = "use";
const CHECK: &str = "check";

/// A case with one of its check readings among those that are fitted, so that it can be named.
pub(crate) struct Fitted {
    pub(crate) case: Case,
    /// Name of the reading.
    pub(crate) name: String,
    /// What was done.
    pub(crate) said: String,
}

impl Fitted {
    /// `None` where the observation is no row of a table that says which rows check.
    pub(crate) fn of(case: &Case, observation: usize) -> Option<Self> {
        let row = match case.measured.rows() {
            Some(rows) => *rows.get(observation)?,
            None => observation,
        };
        let folder = &case.files.folder;
        let set_aside = case.files.kind.readings.iter().find_map(|of| {
            let table = folder.has(of.file).then(|| folder.table(of.file, &[USE]).ok())??;
            let column = table.column(USE)?;
            let is_check = row < table.n_rows() && table.cell(row, column) == CHECK;
            is_check.then(|| (of, table.cell(row, 0).to_owned(), table.line(row)))
        });
        let (of, name, line) = set_aside?;
        let change = Change::Rename {
            column: USE.to_owned(),
            rows: Some(vec![row]),
            names: vec![[CHECK.to_owned(), of.fitted.to_owned()]],
        };
        let case = case.with(&[Edit { file: of.file, change }]).ok()?;
        let said = format!(
            "`{name}` in line {line} of {} is a check reading and lies far off what the others predict: it was taken \
             among the fitted ones to be judged, and the error after is of the other check readings",
            of.file
        );
        Some(Self { case, name, said })
    }
}
