//! One entity of a file, and its attributes by their place.

use super::StepProblem;
use super::value::Value;

/// An entity: one record, or several of a complex one.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Entity<'a> {
    pub(super) id: u64,
    pub(super) line: usize,
    pub(super) records: Vec<(&'a str, Vec<Value<'a>>)>,
}

/// The attributes of one record.
#[derive(Clone, Copy, Debug)]
pub(super) struct Record<'e, 'a> {
    pub(super) id: u64,
    pub(super) line: usize,
    pub(super) keyword: &'a str,
    pub(super) values: &'e [Value<'a>],
}

impl<'a> Entity<'a> {
    /// Its only record; of a complex one, the first.
    pub(super) fn record(&self) -> Record<'_, 'a> {
        let (keyword, values) =
            self.records.first().map_or(("", &[][..]), |(k, values)| (*k, values.as_slice()));
        Record { id: self.id, line: self.line, keyword, values }
    }

    /// The record of a keyword.
    pub(super) fn named(&self, keyword: &str) -> Option<Record<'_, 'a>> {
        let (keyword, values) = self.records.iter().find(|(found, _)| *found == keyword)?;
        Some(Record { id: self.id, line: self.line, keyword, values })
    }

    /// Whether it has several records.
    pub(super) fn is_complex(&self) -> bool {
        self.records.len() > 1
    }
}

impl<'e, 'a> Record<'e, 'a> {
    /// The same without its first attributes.
    pub(super) fn behind(&self, n: usize) -> Self {
        Self { values: self.values.get(n..).unwrap_or_default(), ..*self }
    }

    /// An attribute is not what it has to be.
    pub(super) fn wrong(&self, n: usize, expected: &'static str) -> StepProblem {
        let keyword = self.keyword.to_owned();
        StepProblem::Attribute { line: self.line, id: self.id, keyword, attribute: n + 1, expected }
    }

    pub(super) fn number(&self, n: usize) -> Result<f64, StepProblem> {
        match self.values.get(n) {
            Some(Value::Number(number)) => Ok(*number),
            _ => Err(self.wrong(n, "a number")),
        }
    }

    /// A number of things.
    pub(super) fn count(&self, n: usize) -> Result<usize, StepProblem> {
        let number = self.number(n)?;
        count(number).ok_or_else(|| self.wrong(n, "a whole number"))
    }

    pub(super) fn reference(&self, n: usize) -> Result<u64, StepProblem> {
        match self.values.get(n) {
            Some(Value::Reference(id)) => Ok(*id),
            _ => Err(self.wrong(n, "a reference, such as #12")),
        }
    }

    /// A reference that may be left out.
    pub(super) fn optional(&self, n: usize) -> Result<Option<u64>, StepProblem> {
        match self.values.get(n) {
            Some(Value::Absent) | None => Ok(None),
            _ => self.reference(n).map(Some),
        }
    }

    pub(super) fn is_true(&self, n: usize) -> Result<bool, StepProblem> {
        match self.values.get(n) {
            Some(Value::Enumeration("T")) => Ok(true),
            Some(Value::Enumeration("F")) => Ok(false),
            _ => Err(self.wrong(n, ".T. or .F.")),
        }
    }

    /// A text without its escapes; empty where there is none.
    pub(super) fn text(&self, n: usize) -> String {
        match self.values.get(n) {
            Some(Value::Text(text)) => String::from_utf8_lossy(text).replace("''", "'"),
            _ => String::new(),
        }
    }

    pub(super) fn list(&self, n: usize) -> Result<&'e [Value<'a>], StepProblem> {
        match self.values.get(n) {
            Some(Value::List(list)) => Ok(list),
            _ => Err(self.wrong(n, "a list")),
        }
    }

    pub(super) fn references(&self, n: usize) -> Result<Vec<u64>, StepProblem> {
        let reference = |value: &Value<'_>| match value {
            Value::Reference(id) => Ok(*id),
            _ => Err(self.wrong(n, "a list of references")),
        };
        self.list(n)?.iter().map(reference).collect()
    }

    pub(super) fn numbers(&self, n: usize) -> Result<Vec<f64>, StepProblem> {
        let number = |value: &Value<'_>| match value {
            Value::Number(number) => Ok(*number),
            _ => Err(self.wrong(n, "a list of numbers")),
        };
        self.list(n)?.iter().map(number).collect()
    }

    pub(super) fn counts(&self, n: usize) -> Result<Vec<usize>, StepProblem> {
        let numbers = self.numbers(n)?;
        let counts: Option<Vec<usize>> = numbers.into_iter().map(count).collect();
        counts.ok_or_else(|| self.wrong(n, "a list of whole numbers"))
    }

    /// The rows of a net, all of one length, one below the other, and how many there are.
    pub(super) fn net(&self, n: usize) -> Result<(usize, Vec<&'e Value<'a>>), StepProblem> {
        let rows = self.list(n)?;
        let row = |value: &'e Value<'a>| match value {
            Value::List(row) => Ok(row),
            _ => Err(self.wrong(n, "a list of lists")),
        };
        let rows: Vec<&Vec<Value<'a>>> = rows.iter().map(row).collect::<Result<_, _>>()?;
        if rows.windows(2).any(|pair| pair[0].len() != pair[1].len()) {
            return Err(self.wrong(n, "lists of one length"));
        }
        Ok((rows.len(), rows.into_iter().flatten().collect()))
    }

    /// Values of a net that are of one kind.
    pub(super) fn all<T>(
        &self,
        n: usize,
        values: &[&'e Value<'a>],
        expected: &'static str,
        of: impl Fn(&Value<'a>) -> Option<T>,
    ) -> Result<Vec<T>, StepProblem> {
        values.iter().map(|v| of(v).ok_or_else(|| self.wrong(n, expected))).collect()
    }
}

fn count(number: f64) -> Option<usize> {
    let is_count = (0.0..=f64::from(u32::MAX)).contains(&number) && number.fract() == 0.0;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked above")]
    is_count.then_some(number as usize)
}
