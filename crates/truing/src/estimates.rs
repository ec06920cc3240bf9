//! What was solved for: one type per kind of data, and what the program asks of each.

use std::any::Any;
use std::fmt;
use std::sync::Arc;

use model_discrepancy::Step;
use serde::Serializer;
use truing_report::{ExtraPlot, Form};

use crate::estimated::{Estimated, Export};
use crate::implausible::ImplausibleResult;
use crate::text_table::{Cell, EXPANDED, TextTable};

/// What was solved for in a case of one kind; serialises as its own object.
///
/// Which type it is follows from the kind and the tables of the case:
/// `solved.estimates.downcast_ref::<PoseIcpEstimates>()`.
pub trait Estimates: Any + erased_serde::Serialize + fmt::Debug + Send + Sync {
    /// The numbers that describe the whole case, with their uncertainties.
    fn parameters(&self) -> Vec<Estimated>;

    /// Tables for people, beside that of the parameters.
    fn tables(&self) -> Vec<TextTable>;

    /// When what is handed back holds, and what of the accepted effects it leaves to corrections.
    fn conditions(&self) -> &[String] {
        &[]
    }

    /// Gives steps the uncertainty that what they found has in these estimates, where that is larger.
    fn widen(&self, _steps: &mut [Step]) {}

    /// Pictures that only this kind has.
    fn plots(&self) -> Vec<ExtraPlot> {
        Vec::new()
    }

    /// The form of the test that the case is: title, conditions, results; `None` of other data.
    fn form(&self) -> Option<Form> {
        None
    }

    /// The estimates as a file of that format; `None` where the kind has nothing to put there.
    fn export(&self, _format: Export) -> Option<String> {
        None
    }

    /// The same of a second axis, with its letter; it goes to a file of its own.
    fn export_of_second(&self, _format: Export) -> Option<(char, String)> {
        None
    }

    /// What of them can be true of no machine; `max_correction_deg` replaces the bound of a
    /// compensation.
    fn implausible(&self, max_correction_deg: Option<f64>) -> Option<ImplausibleResult>;
}

impl dyn Estimates {
    /// The estimates as those of one kind; `None` where they are another's.
    #[must_use]
    pub fn downcast_ref<T: Estimates>(&self) -> Option<&T> {
        (self as &dyn Any).downcast_ref()
    }
}

/// Serialises what is shared as what it is.
pub(crate) fn serialize<S: Serializer>(
    estimates: &Arc<dyn Estimates>,
    to: S,
) -> Result<S::Ok, S::Error> {
    erased_serde::serialize(&**estimates, to)
}

/// All tables for people: the parameters, where there are any, and those of the kind.
pub(crate) fn tables(estimates: &dyn Estimates) -> Vec<TextTable> {
    let parameters = estimates.parameters();
    if parameters.is_empty() {
        return estimates.tables();
    }
    let columns = ["parameter", "value", EXPANDED, "unit"];
    let mut table = TextTable::of_quantities("estimates", &columns);
    for p in &parameters {
        table.push(vec![
            p.name.clone().into(),
            Cell::Known(p.value, p.std),
            Cell::Expanded(p.std),
            p.unit.to_owned().into(),
        ]);
    }
    [table].into_iter().chain(estimates.tables()).collect()
}
