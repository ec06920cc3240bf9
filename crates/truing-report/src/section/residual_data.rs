//! The numbers behind the pictures of a residual: one row per observation.

use model_discrepancy::{Covariate, Role};

use super::Context;
use crate::data_table::{DataTable, Datum};
use crate::reading::Reading;
use crate::unit::column_title;

/// Every residual with the quantities against which it is drawn.
pub(super) fn residual_data(
    context: &Context,
    readings: &[Reading],
    drawn: &[&Covariate],
) -> DataTable {
    let layout = context.input.layout;
    let components = context.components.len();
    let residuals = context.components.iter().map(|name| {
        let single = components == 1 && context.input.components.is_empty();
        context.shown.title(&if single {
            "residual".to_owned()
        } else {
            format!("residual {name}")
        })
    });
    let mut columns = vec![context.input.group_noun.to_owned(), "use".to_owned()];
    columns.extend(residuals);
    columns.extend(drawn.iter().map(|covariate| column_title(&covariate.name)));
    let mut table = DataTable::new(columns);
    let mut values = vec![f64::NAN; layout.observations.len() * components];
    for reading in readings {
        if let Some(value) = values.get_mut(reading.observation * components + reading.component) {
            *value = reading.value;
        }
    }
    for (observation, group) in layout.observations.iter().enumerate() {
        let own = &values[observation * components..(observation + 1) * components];
        let Some(group) = layout.groups.get(*group).filter(|group| group.role != Role::Prior)
        else {
            continue;
        };
        let usage = if group.role == Role::Check { "check" } else { "fit" };
        let beside = drawn.iter().map(|covariate| covariate.values.get(observation));
        let names = [group.name.as_str(), usage].map(Datum::from);
        let numbers = own.iter().copied().chain(beside.map(|v| v.copied().unwrap_or(f64::NAN)));
        table.push(names.into_iter().chain(numbers.map(Datum::from)));
    }
    table
}
