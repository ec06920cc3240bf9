//! Plans as text for people.

use std::fmt;

use super::planned::{PlanFigure, Planned};
use crate::layout::written;
use crate::text_table::{Cell, TextTable};
use crate::{Detail, Layout};

impl fmt::Display for Planned {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(f, Layout { detail: Detail::Full, columns: None })
    }
}

impl Planned {
    /// The plan for people.
    #[must_use]
    pub fn text(&self, layout: Layout) -> String {
        written(|text| self.write(text, layout))
    }

    fn write(&self, f: &mut dyn fmt::Write, layout: Layout) -> fmt::Result {
        writeln!(f, "{}\n", self.kind)?;
        let time = self.minutes.map_or_else(String::new, |m| format!(", {m:.0} minutes"));
        let (planned, noun, measured) =
            (counted(self.planned, self.noun), self.noun, self.measured);
        let already = counted(measured, noun);
        writeln!(f, "plan for {}: {planned} beside {already} measured{time}", self.aim)?;
        if let Some(would) = &self.would {
            writeln!(f, "the aim is not reached: {would}")?;
        }
        writeln!(f)?;
        for figure in &self.figures {
            writeln!(f, "  {}", figure.line())?;
        }
        let first = self.plan.first().filter(|_| layout.detail > Detail::Headline);
        let Some(first) = first else { return Ok(()) };
        let columns: Vec<&'static str> =
            [noun].into_iter().chain(first.cells.keys().copied()).collect();
        let mut table = TextTable::new("to be measured, in this order", &columns);
        for one in &self.plan {
            let cells = one.cells.values().map(|value| Cell::from(*value));
            table.push(std::iter::once(one.name.clone().into()).chain(cells).collect());
        }
        writeln!(f)?;
        table.write(f, layout)
    }
}

impl PlanFigure {
    /// The figure without and with the plan, in words.
    fn line(&self) -> String {
        let Self { of, before, after, unit, .. } = self;
        match self.measure {
            "probability" => {
                let percent = |p: &Option<f64>| format!("{:.0} %", 100.0 * p.unwrap_or(0.0));
                let (before, after) = (percent(before), percent(after));
                format!("{of}: told with a probability of {before} now, {after} with the plan")
            }
            "detectable" => {
                let size = |size: &Option<f64>| match size {
                    Some(size) => format!("from {} {unit} on", significant(*size)),
                    None => "not observable".to_owned(),
                };
                format!(
                    "{of}: found nine times in ten {} now, {} with the plan",
                    size(before),
                    size(after)
                )
                .replace("found nine times in ten not observable now", "not observable now")
            }
            _ => {
                let u = |u: &Option<f64>| u.map_or_else(|| "–".to_owned(), significant);
                format!(
                    "{of}: U = {} {unit} now, {} {unit} with the plan (k = 2)",
                    u(before),
                    u(after)
                )
            }
        }
    }
}

/// Two significant digits.
fn significant(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    #[expect(clippy::cast_possible_truncation, reason = "decades of sizes are small")]
    let decimals = (1 - value.abs().log10().floor() as i32).max(0);
    format!("{value:.*}", usize::try_from(decimals).unwrap_or(0))
}

/// So many of a thing.
pub(super) fn counted(n: usize, noun: &str) -> String {
    let plural = if noun.ends_with("ch") || noun.ends_with('s') { "es" } else { "s" };
    if n == 1 { format!("1 {noun}") } else { format!("{n} {noun}{plural}") }
}
