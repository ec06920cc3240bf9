use crate::case::{CASE_FILE, Change, Edit, Table};

/// One thing that may be wrong with the input, and the change that mends it.
#[derive(Clone, Debug)]
pub(crate) struct Hypothesis {
    /// Id, `input:…`.
    pub(crate) effect: &'static str,
    /// File and column.
    pub(crate) subject: String,
    /// What to change.
    pub(crate) description: String,
    /// The change; empty where the data show the mistake but not what they should have been.
    pub(crate) edits: Vec<Edit>,
    /// What speaks for it.
    pub(crate) proof: Proof,
    /// Effect of the catalogue that would do the same.
    pub(crate) physics: Option<&'static str>,
}

/// What speaks for a mistake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Proof {
    /// Nothing yet: the fit with the change decides.
    Fit,
    /// The data themselves, where the fit is bad.
    Data,
    /// The data themselves, where the fit is worse than any physics makes it.
    Gross,
    /// The data themselves, however good the fit is.
    Certain,
    /// The fit, where it is worse than any physics makes it.
    FitIfGross,
    /// The fit; and physics that does the same would have to go against its own nature.
    Unphysical,
}

impl Hypothesis {
    /// `effect` of columns of a file, to be decided by the fit.
    pub(crate) fn of(
        effect: &'static str,
        (file, columns): (&str, &[&str]),
        description: String,
        edits: Vec<Edit>,
    ) -> Self {
        let subject = format!("{file}: {}", columns.join(", "));
        Self { effect, subject, description, edits, proof: Proof::Fit, physics: None }
    }

    /// The same, as shown by the data.
    pub(crate) fn shown(self) -> Self {
        Self { proof: Proof::Data, ..self }
    }

    /// The same, as shown by the data whether the fit suffers or not.
    pub(crate) fn certain(self) -> Self {
        Self { proof: Proof::Certain, ..self }
    }

    /// The same, where physics cannot be meant.
    pub(crate) fn unphysical(self) -> Self {
        Self { proof: Proof::Unphysical, ..self }
    }

    /// Whether the data themselves show it in a case that is off by as much.
    pub(super) fn is_shown(&self, is_gross: bool) -> bool {
        self.proof == Proof::Data || is_gross && self.proof == Proof::Gross
    }

    /// Whether it leaves out one stretch of rows, which the data name and no fit has chosen.
    pub(crate) fn is_of_a_stretch(&self) -> bool {
        self.effect == "input:stuck"
    }

    /// Whether a whole column stands still: nothing mends that.
    pub(super) fn is_silent(&self) -> bool {
        self.is_of_a_stretch() && self.edits.is_empty()
    }

    /// Whether it leaves out a whole file.
    pub(crate) fn omits_a_file(&self) -> bool {
        self.edits.iter().any(|edit| matches!(edit.change, Change::Omit))
    }

    /// Whether only numbers of `case.toml` change.
    pub(crate) fn is_of_settings(&self) -> bool {
        self.edits.iter().all(|edit| edit.file == CASE_FILE)
    }

    /// Id with subject.
    pub(crate) fn label(&self) -> String {
        format!("{} [{}]", self.effect, self.subject)
    }
}

/// Those of the columns that the table has.
pub(super) fn present<'c>(table: Option<&Table>, columns: &[&'c str]) -> Vec<&'c str> {
    let has = |column: &&str| table.is_some_and(|t| t.has(column));
    columns.iter().copied().filter(has).collect()
}

/// Owned names.
pub(super) fn owned(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

/// Names as code, with commas.
pub(super) fn listed(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    quoted.join(", ")
}
