//! What several sections need to know of a case.

use model_discrepancy::{Closure, Role};

use crate::axis::Range;
use crate::input::{Evidence, ReportInput};
use crate::reading::{Reading, component_count, component_name, readings, rms};
use crate::unit::Shown;

/// A case with its residual in the unit shown.
pub(crate) struct Context<'a> {
    pub(crate) input: &'a ReportInput<'a>,
    pub(crate) closure: Option<&'a Closure>,
    pub(crate) shown: Shown,
    pub(crate) before: Vec<Reading>,
    /// Empty where nothing was added.
    pub(crate) after: Vec<Reading>,
    /// Rows left out of the plots because their residual is no number.
    pub(crate) undrawable: usize,
    /// Of every residual plot of the page.
    pub(crate) range: Range,
    pub(crate) components: Vec<String>,
}

impl<'a> Context<'a> {
    pub(crate) fn new(input: &'a ReportInput<'a>) -> Self {
        let (closure, residuals) = match input.evidence {
            Evidence::Solved { residuals } => (None, residuals),
            Evidence::Closed(closure) => (Some(closure), closure.residuals_before.as_slice()),
        };
        let layout = input.layout;
        let typical = rms(&readings(layout, residuals, 1.0)).unwrap_or(0.0);
        let held_out = closure.map_or(0.0, |c| finite(c.before.held_out_rms));
        let shown = Shown::for_size(&layout.unit, typical.max(held_out));
        let before = readings(layout, residuals, shown.factor);
        let added = closure.filter(|c| !c.steps.is_empty());
        let after =
            added.map_or(Vec::new(), |c| readings(layout, &c.residuals_after, shown.factor));
        let values = before.iter().chain(&after).map(|r| r.value);
        let range = Range::of(values.chain([0.0])).unwrap_or(Range { low: -1.0, high: 1.0 });
        let n = component_count(&before);
        let undrawable = residuals.iter().filter(|r| !r.is_finite()).count();
        Self {
            input,
            closure,
            shown,
            after,
            undrawable,
            range: range.padded(0.06),
            components: (0..n).map(|i| component_name(input.components, i)).collect(),
            before,
        }
    }

    /// Number of groups of a role.
    pub(crate) fn group_count(&self, role: Role) -> usize {
        self.input.layout.groups.iter().filter(|g| g.role == role).count()
    }

    /// An error in the layout's unit as a number in the unit shown.
    pub(crate) fn show(&self, error: f64) -> f64 {
        error * self.shown.factor
    }

    /// Whether anything was added to the declared model.
    pub(crate) fn is_extended(&self) -> bool {
        self.closure.is_some_and(|c| !c.steps.is_empty())
    }
}

fn finite(value: f64) -> f64 {
    if value.is_finite() { value } else { 0.0 }
}
