use std::sync::OnceLock;

/// The cells of one column: of texts or of numbers, of which the others are found when first asked for.
#[derive(Clone, Debug, Default)]
pub(super) struct Cells {
    written: OnceLock<Written>,
    /// `None` where a cell is not a number.
    numbers: OnceLock<Option<Vec<f64>>>,
}

/// Texts one after the other, and where each ends.
#[derive(Clone, Debug, Default)]
struct Written {
    text: String,
    ends: Vec<usize>,
}

impl Written {
    fn push(&mut self, cell: &str) {
        self.text.push_str(cell);
        self.ends.push(self.text.len());
    }

    fn cell(&self, row: usize) -> &str {
        let start = if row == 0 { 0 } else { self.ends[row - 1] };
        &self.text[start..self.ends[row]]
    }
}

impl Cells {
    /// Cells that read as these texts.
    pub(super) fn of_texts<T: AsRef<str>>(texts: impl IntoIterator<Item = T>) -> Self {
        let mut written = Written::default();
        for cell in texts {
            written.push(cell.as_ref());
        }
        Self { written: OnceLock::from(written), numbers: OnceLock::new() }
    }

    /// Cells that read as these numbers.
    pub(super) fn of_numbers(numbers: Vec<f64>) -> Self {
        Self { written: OnceLock::new(), numbers: OnceLock::from(Some(numbers)) }
    }

    /// Cells of other columns, each with its row there.
    pub(super) fn picked<'c>(from: impl Iterator<Item = (&'c Self, usize)> + Clone) -> Self {
        let number = |(cells, row): (&'c Self, usize)| Some(cells.numbers.get()?.as_ref()?[row]);
        let numbers: Option<Vec<f64>> = from.clone().map(number).collect();
        let is_written = from.clone().any(|(cells, _)| cells.written.get().is_some());
        match numbers {
            Some(numbers) if !is_written => Self::of_numbers(numbers),
            numbers => {
                let numbers = numbers.map_or_else(OnceLock::new, |all| OnceLock::from(Some(all)));
                Self { numbers, ..Self::of_texts(from.map(|(cells, row)| cells.text(row))) }
            }
        }
    }

    /// Other numbers for those of these rows, where `number` gives one; what is no number stays.
    pub(super) fn changed(
        &self,
        rows: &[usize],
        number: impl Fn(usize, f64) -> Option<f64>,
    ) -> Self {
        let known = self.numbers();
        let other = |row: usize| number(row, self.number(row)?);
        let others: Vec<Option<f64>> = rows.iter().copied().map(other).collect();
        if let Some(all) = others.iter().copied().collect() {
            return Self::of_numbers(all);
        }
        let cells = rows.iter().copied().zip(&others);
        let text = |(row, other): (usize, &Option<f64>)| {
            other.map_or_else(|| self.text(row).to_owned(), shortest)
        };
        let changed = Self::of_texts(cells.clone().map(text));
        if let Some(known) = known {
            let numbers = cells.map(|(row, other)| other.unwrap_or(known[row])).collect();
            changed.numbers.get_or_init(|| Some(numbers));
        }
        changed
    }

    /// One cell more.
    pub(super) fn push(&mut self, cell: &str) {
        self.written();
        self.numbers.take();
        if let Some(written) = self.written.get_mut() {
            written.push(cell);
        }
    }

    /// The text of a cell: of a number the shortest that reads as the same.
    pub(super) fn text(&self, row: usize) -> &str {
        self.written().cell(row)
    }

    fn written(&self) -> &Written {
        self.written.get_or_init(|| {
            let mut written = Written::default();
            let numbers = self.numbers.get().and_then(Option::as_ref);
            for number in numbers.into_iter().flatten() {
                written.push(&shortest(*number));
            }
            written
        })
    }

    /// All cells as numbers; `None` where one is not.
    pub(super) fn numbers(&self) -> Option<&[f64]> {
        let of_texts = || {
            let written = self.written.get()?;
            (0..written.ends.len()).map(|row| written.cell(row).parse().ok()).collect()
        };
        self.numbers.get_or_init(of_texts).as_deref()
    }

    /// A cell as a number, where it is one.
    pub(super) fn number(&self, row: usize) -> Option<f64> {
        self.numbers().map_or_else(|| self.text(row).parse().ok(), |all| Some(all[row]))
    }
}

fn shortest(value: f64) -> String {
    format!("{value:?}")
}
