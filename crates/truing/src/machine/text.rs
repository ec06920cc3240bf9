//! Machines as text for people.

use std::fmt;

use super::answer::{CaseOfMachine, ClosedMachine, StepByCase};
use crate::layout::written;
use crate::text::{advice, sizes};
use crate::text_table::{Cell, TextTable, with_uncertainty};
use crate::{Detail, JudgedRms, Layout, LoopParameter, LoopStep};

impl fmt::Display for ClosedMachine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(f, Layout::default())
    }
}

impl ClosedMachine {
    /// The answer for people, the verdict first.
    #[must_use]
    pub fn text(&self, layout: Layout) -> String {
        written(|text| self.write(text, layout))
    }

    fn write(&self, f: &mut dyn fmt::Write, layout: Layout) -> fmt::Result {
        let name = self.name.as_deref().unwrap_or("machine");
        writeln!(f, "{name}, {} cases: {}", self.cases.len(), self.verdict)?;
        if self.steps.is_empty() {
            writeln!(f, "  nothing that the cases share")?;
        }
        for step in &self.steps {
            writeln!(f, "  {}", step.in_one_line())?;
            if !step.indistinguishable_from.is_empty() {
                let (rivals, advice) =
                    (step.indistinguishable_from.join(", "), advice(step.separate_by.as_deref()));
                writeln!(f, "  cannot be told apart from: {rivals}{advice}")?;
            }
        }
        if layout.detail == Detail::Headline {
            return Ok(());
        }
        for (step, by_case) in self.steps.iter().zip(&self.by_case) {
            writeln!(f)?;
            by_case.table(step).write(f, layout)?;
        }
        writeln!(f)?;
        self.errors().write(f, layout)?;
        for case in self.cases.iter().filter(|case| !case.steps.is_empty()) {
            writeln!(f, "\n{}, beside it:", case.case)?;
            for step in &case.steps {
                writeln!(f, "  {}", step.in_one_line())?;
            }
        }
        Ok(())
    }

    /// Error of every case on groups that were left out.
    fn errors(&self) -> TextTable {
        let columns = ["case", "kind", "before", "by the others", "after", "unit", "verdict"];
        let mut table = TextTable::new("error on data the fit never saw", &columns);
        let held_out = |e: &JudgedRms| Cell::Number(Some(e.held_out_rms));
        let row = |case: &CaseOfMachine| {
            vec![
                case.case.as_str().into(),
                case.kind.into(),
                held_out(&case.before),
                case.with_others.as_ref().map_or(Cell::Number(None), held_out),
                held_out(&case.after),
                case.before.unit.as_str().into(),
                case.verdict.into(),
            ]
        };
        self.cases.iter().map(row).for_each(|row| table.push(row));
        table
    }
}

impl StepByCase {
    /// What every case says of a step on its own.
    fn table(&self, step: &LoopStep) -> TextTable {
        let columns = ["case", "named alone", "size (k = 2)"];
        let mut table = TextTable::new(step.label(), &columns);
        let is_single = step.parameters.len() == 1;
        let size = |of: &[LoopParameter]| match of {
            [] => "not determined".to_owned(),
            [one] if is_single => with_uncertainty(one.value, one.std, &one.unit),
            several => sizes(several),
        };
        for case in &self.cases {
            let named = if case.named_alone { "yes" } else { "no" };
            table.push(vec![
                case.case.as_str().into(),
                named.into(),
                size(&case.parameters).into(),
            ]);
        }
        table.push(vec!["all".into(), "".into(), size(&step.parameters).into()]);
        table
    }
}
