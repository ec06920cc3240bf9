//! The residual in numbers, where there are few enough to read.

use model_discrepancy::Role;

use super::{Cell, Context, Kind, table};
use crate::markup::Markup;
use crate::number::{decade, fixed};
use crate::reading::Reading;

const MOST_ROWS: usize = 60;
const MOST_COLUMNS: usize = 6;

pub(super) fn residual_table(out: &mut Markup, context: &Context) {
    let layout = context.input.layout;
    let components = context.components.len();
    if layout.observations.len() > MOST_ROWS || components > MOST_COLUMNS || components == 0 {
        return;
    }
    let titles = titles(context);
    let mut columns = vec![(context.input.group_noun, Kind::Name), ("use", Kind::Words)];
    columns.extend(titles.iter().map(|t| (t.as_str(), Kind::Number)));
    let rows = layout.observations.iter().enumerate().filter_map(|(observation, group)| {
        let group = layout.groups.get(*group)?;
        let role = match group.role {
            Role::Fit => "fit",
            Role::Check => "check",
            Role::Prior => return None,
        };
        let mut cells = vec![Cell::new(&group.name), Cell::new(role)];
        cells.extend(values(context, &context.before, observation));
        if context.is_extended() {
            cells.extend(values(context, &context.after, observation));
        }
        Some(cells)
    });
    out.open("details", &[]);
    out.element("summary", &[], "The same in numbers");
    table(out, "Residual per observation", &columns, rows);
    out.close("details");
}

fn titles(context: &Context) -> Vec<String> {
    let named = |when: &str| -> Vec<String> {
        let single = context.components.len() == 1 && context.input.components.is_empty();
        let names = context.components.iter();
        let title = |name: &String| {
            let quantity = if single { "residual" } else { name };
            context.shown.title(&format!("{quantity}{when}"))
        };
        names.map(title).collect()
    };
    if context.is_extended() { [named(" before"), named(" after")].concat() } else { named("") }
}

/// One cell per component of an observation.
fn values(context: &Context, readings: &[Reading], observation: usize) -> Vec<Cell> {
    // Three digits of the largest residual, the same decimals in every cell.
    let decimals = 2 - decade(context.range.high.max(-context.range.low));
    let cell = |component| {
        readings
            .iter()
            .find(|r| r.observation == observation && r.component == component)
            .map_or_else(|| Cell::new("–"), |r| Cell::number(fixed(r.value, decimals), r.value))
    };
    (0..context.components.len()).map(cell).collect()
}
