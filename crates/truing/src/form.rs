//! The form of a test, filled in for a report.

use truing_report::{COMPENSATED, Form, FormLimit, FormResult};

use crate::case::Provenance;
use crate::conformity::LimitDecision;

/// The form of the kind, or one of the results that have limits; `None` where there is neither.
pub(crate) fn filled(
    of_kind: Option<Form>,
    decisions: &[LimitDecision],
    provenance: Option<&Provenance>,
) -> Option<Form> {
    if of_kind.is_none() && decisions.is_empty() {
        return None;
    }
    let title = "Conformity with limits (JCGM 106)";
    let mut form = of_kind.unwrap_or_else(|| Form { title: title.to_owned(), ..Form::default() });
    form.header = header(provenance);
    for decision in decisions {
        let limit = FormLimit {
            limit: decision.limit,
            probability: decision.probability,
            decision: decision.decision,
        };
        let (results, symbol) = match decision.parameter.strip_suffix(COMPENSATED) {
            Some(symbol) => (&mut form.compensated, symbol),
            None => (&mut form.results, decision.parameter.as_str()),
        };
        match results.iter_mut().find(|result| result.symbol == symbol) {
            Some(result) => result.limit = Some(limit),
            None => results.push(FormResult {
                symbol: symbol.to_owned(),
                name: String::new(),
                unit: decision.unit.clone(),
                value: decision.value,
                std: decision.std,
                limit: Some(limit),
            }),
        }
    }
    form.rule = decisions.first().map(|decision| rule(decision.required));
    Some(form)
}

/// What is written over every certificate, declared or not.
fn header(provenance: Option<&Provenance>) -> Vec<(String, Option<String>)> {
    let of = |field: fn(&Provenance) -> &Option<String>| provenance.and_then(|p| field(p).clone());
    let temperatures = provenance.filter(|p| !p.temperatures.is_empty()).map(|p| {
        let each = p.temperatures.iter().map(|(place, value)| {
            format!("{} {value} °C", place.strip_suffix("_c").unwrap_or(place))
        });
        each.collect::<Vec<_>>().join(", ")
    });
    let fields = [
        ("date", of(|p| &p.date)),
        ("machine", of(|p| &p.machine)),
        ("instrument", of(|p| &p.instrument)),
        ("operator", of(|p| &p.operator)),
        ("temperatures", temperatures),
    ];
    fields.map(|(name, value)| (name.to_owned(), value)).into()
}

fn rule(required: f64) -> String {
    format!(
        "A result passes where its true value is within ± its limit with a probability of at least \
         {required}, and fails where it is outside with at least that probability (JCGM 106: guarded \
         acceptance and guarded rejection, one guard band on either side of the limit). Between the two \
         nothing is decided: measure with a smaller uncertainty, or agree on another rule."
    )
}
