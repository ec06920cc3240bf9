//! The uncertainty budget of every result.

use super::{Cell, Context, Kind, paragraph, table};
use crate::budget::{Budget, BudgetResult};
use crate::markup::Markup;
use crate::number::{count, significant, with_expanded};

pub(crate) fn budget(out: &mut Markup, context: &Context) {
    let Some(budget) = context.input.budget else { return };
    out.element("h2", &[], "Uncertainty budget");
    paragraph(
        out,
        "",
        &format!(
            "Linear: propagation by derivatives (JCGM 100). By draws: the data are simulated {} times with \
             their declared uncertainties and solved in the same way (JCGM 101); the coverage interval \
             leaves 2.5 % on either side. Where the two differ, rely on the draws.",
            count(budget.draws)
        ),
    );
    let titles: Vec<String> =
        budget.sources.iter().map(|source| format!("± of {source}")).collect();
    let mut columns = vec![
        ("result", Kind::Name),
        ("value", Kind::Number),
        ("± linear", Kind::Number),
        ("± by draws", Kind::Number),
        ("95 % from", Kind::Number),
        ("to", Kind::Number),
    ];
    // One source alone is the whole of it.
    let is_split = budget.sources.len() > 1;
    if is_split {
        columns.extend(titles.iter().map(|title| (title.as_str(), Kind::Number)));
    }
    columns.push(("unit", Kind::Unit));
    let rows = budget.results.iter().map(|result| row(result, is_split));
    let caption = "Results, ± expanded uncertainties (k\u{a0}=\u{a0}2)";
    table(out, caption, &columns, rows);
    paragraph(out, "quiet", &sources(budget));
}

fn row(result: &BudgetResult, is_split: bool) -> Vec<Cell> {
    let (value, by_draws) = with_expanded(result.value, result.std);
    let expanded = |std: f64| {
        let written =
            if std > 0.0 { with_expanded(result.value, std).1 } else { significant(std, 2) };
        Cell::number(written, std)
    };
    let end = |v: f64| Cell::number(with_expanded(v, result.std).0, v);
    let [low, high] = result.interval_95;
    let mut cells = vec![
        Cell::new(&result.name),
        Cell::number(value, result.value),
        expanded(result.linear_std),
        Cell::number(by_draws, result.std),
        end(low),
        end(high),
    ];
    if is_split {
        cells.extend(result.by_source.iter().map(|std| expanded(*std)));
    }
    cells.push(Cell::new(&result.unit));
    cells
}

fn sources(budget: &Budget) -> String {
    let failed = match budget.failed {
        0 => String::new(),
        n => format!(" {} draws had no solution and are in no figure.", count(n)),
    };
    let all = budget.sources.join(", ");
    if budget.sources.len() > 1 {
        format!(
            "Simulated: {all}. A column of its own shows what each contributes alone: the squares of these \
             columns add up to about that of all together.{failed}"
        )
    } else {
        format!("Simulated: {all}.{failed}")
    }
}
