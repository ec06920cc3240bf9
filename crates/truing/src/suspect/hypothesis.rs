use crate::case::{CASE_FILE, Change, Edit, Folder, Table};

/// Relative distance of one of a factor times its inverse.
const ROUND_OFF: f64 = 1e-9;

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
    /// The fit, where it is worse than any physics makes it and no other mistake explains it.
    FitIfNoOther,
    /// The fit; and physics that does the same would have to go against its own nature.
    Unphysical,
    /// The same, and the data themselves, however good the fit is, where nothing else is found.
    Clear,
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

    /// Whether the data themselves show it, where the fit is bad.
    pub(crate) fn is_shown_by_data(&self) -> bool {
        self.proof == Proof::Data
    }

    /// The same, as shown by the data whether the fit suffers or not.
    pub(crate) fn certain(self) -> Self {
        Self { proof: Proof::Certain, ..self }
    }

    /// The same, where physics cannot be meant.
    pub(crate) fn unphysical(self) -> Self {
        Self { proof: Proof::Unphysical, ..self }
    }

    /// The same, where physics cannot be meant and the data themselves show it.
    pub(crate) fn clear(self) -> Self {
        Self { proof: Proof::Clear, ..self }
    }

    /// Whether physics cannot be meant.
    pub(super) fn is_unphysical(&self) -> bool {
        matches!(self.proof, Proof::Unphysical | Proof::Clear)
    }

    /// Whether it is the same change, of the same rows.
    pub(super) fn is(&self, other: &Self) -> bool {
        self.subject == other.subject && self.description == other.description
    }

    /// Whether it leaves readings out, and changes none.
    pub(super) fn only_leaves_out(&self) -> bool {
        !self.edits.is_empty() && self.edits.iter().all(leaves_out)
    }

    /// Whether it leaves any readings out.
    pub(super) fn leaves_out(&self) -> bool {
        self.edits.iter().any(leaves_out)
    }

    /// The same with further changes after it.
    pub(super) fn and(&self, further: &[Edit]) -> Self {
        Self { edits: [&self.edits, further].concat(), ..self.clone() }
    }

    /// Whether the data themselves show it in a case that is off by as much.
    pub(super) fn is_shown(&self, is_gross: bool) -> bool {
        self.is_shown_by_data() || is_gross && self.proof == Proof::Gross
    }

    /// Whether it leaves out one stretch of rows, which the data name and no fit has chosen.
    pub(crate) fn is_of_a_stretch(&self) -> bool {
        self.effect == "input:stuck"
    }

    /// Whether it leaves out readings at an end of a range, as those that another unit makes small are too.
    pub(super) fn is_of_an_end(&self) -> bool {
        self.effect == "input:saturation"
    }

    /// Whether a whole column stands still: nothing mends that.
    pub(super) fn is_silent(&self) -> bool {
        self.is_of_a_stretch() && self.edits.is_empty()
    }

    /// Whether it leaves out a whole file.
    pub(crate) fn omits_a_file(&self) -> bool {
        self.edits.iter().any(|edit| matches!(edit.change, Change::Omit))
    }

    /// The factor by which some rows are multiplied, where that is all.
    fn factor(&self) -> Option<(f64, &[usize])> {
        match &self.edits[..] {
            [Edit { change: Change::Scale { rows: Some(rows), factor, .. }, .. }] => {
                Some((*factor, rows))
            }
            _ => None,
        }
    }

    /// The rows of a file that it multiplies, where that is all.
    pub(super) fn multiplied(&self) -> Option<(&'static str, &[usize])> {
        let (_, rows) = self.factor()?;
        Some((self.edits.first()?.file, rows))
    }

    /// Whether it multiplies some rows by more than one.
    pub(super) fn enlarges(&self) -> bool {
        self.factor().is_some_and(|(factor, _)| factor > 1.0)
    }

    /// Whether it divides the same rows by as much as the other multiplies them.
    pub(super) fn is_reverse_of(&self, other: &Self) -> bool {
        let both = self.factor().zip(other.factor());
        both.is_some_and(|((mine, rows), (factor, of))| {
            (mine * factor - 1.0).abs() < ROUND_OFF && rows == of
        })
    }

    /// Whether nothing but signs changes.
    pub(super) fn is_of_signs(&self) -> bool {
        let is_sign = |edit: &Edit| matches!(edit.change, Change::Scale { factor, .. } if (factor + 1.0).abs() < ROUND_OFF);
        !self.edits.is_empty() && self.edits.iter().all(is_sign)
    }

    /// Whether only numbers of `case.toml` change.
    pub(crate) fn is_of_settings(&self) -> bool {
        self.edits.iter().all(|edit| edit.file == CASE_FILE)
    }

    /// The same with columns called what the file calls them, which may be in another unit.
    pub(super) fn in_words_of(mut self, folder: &Folder) -> Self {
        let file = self.subject.split_once(": ").map(|(file, _)| file);
        if let Some(table) = file.and_then(|file| folder.known(file)) {
            self.subject = in_words_of(&table, &self.subject);
            self.description = in_words_of(&table, &self.description);
        }
        self
    }

    /// Id with subject.
    pub(crate) fn label(&self) -> String {
        format!("{} [{}]", self.effect, self.subject)
    }
}

/// A text with the table's own names of columns that it has in another unit.
fn in_words_of(table: &Table, text: &str) -> String {
    let is_of_a_name = |c: char| c.is_alphanumeric() || c == '_';
    let mut told = String::with_capacity(text.len());
    let mut rest = text;
    while !rest.is_empty() {
        let end = rest.find(|c| !is_of_a_name(c)).unwrap_or(rest.len());
        let (word, after) = rest.split_at(end);
        match table.read_as(word) {
            Some((column, Some(_))) => told.push_str(&table.names()[column]),
            _ => told.push_str(word),
        }
        let between = after.find(is_of_a_name).unwrap_or(after.len());
        told.push_str(&after[..between]);
        rest = &after[between..];
    }
    told
}

/// Those of the columns that the table has.
pub(super) fn present<'c>(table: Option<&Table>, columns: &[&'c str]) -> Vec<&'c str> {
    let has = |column: &&str| table.is_some_and(|t| t.has(column));
    columns.iter().copied().filter(has).collect()
}

/// Every two of the names, in their order.
pub(super) fn pairs<'c>(names: &[&'c str]) -> impl Iterator<Item = [&'c str; 2]> {
    let later = move |i: usize| names[i + 1..].iter().map(move |other| [names[i], *other]);
    (0..names.len()).flat_map(later)
}

/// Owned names.
pub(super) fn owned(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

/// The verb for so many names.
pub(super) fn is_or_are(names: &[&str]) -> &'static str {
    if names.len() == 1 { "is" } else { "are" }
}

/// Names as code, with commas.
pub(super) fn listed(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    quoted.join(", ")
}

/// The lines of the rows that are marked, neighbours as a range.
pub(crate) fn lines_of(table: &Table, marked: &[bool]) -> String {
    let rows = (0..marked.len()).filter(|&row| marked[row]);
    stretches_of(&rows.map(|row| table.line(row)).collect::<Vec<_>>())
}

/// Numbers in ascending order, neighbours as a range: `3, 7–9`.
pub(crate) fn stretches_of(lines: &[usize]) -> String {
    let mut stretches: Vec<[usize; 2]> = Vec::new();
    for &line in lines {
        match stretches.last_mut() {
            Some([_, last]) if *last + 1 == line => *last = line,
            _ => stretches.push([line, line]),
        }
    }
    let text = |[first, last]: [usize; 2]| match last - first {
        0 => first.to_string(),
        _ => format!("{first}–{last}"),
    };
    stretches.into_iter().map(text).collect::<Vec<_>>().join(", ")
}

/// Whether a change leaves readings out.
pub(super) fn leaves_out(edit: &Edit) -> bool {
    matches!(edit.change, Change::Keep { .. })
}
