use model_discrepancy::Parameter;

/// A parameter as reported: `internal · report_factor` in `unit`.
pub(crate) fn parameter(name: &str, unit: &str, report_factor: f64) -> Parameter {
    Parameter { name: name.to_owned(), unit: unit.to_owned(), report_factor }
}
