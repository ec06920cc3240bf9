//! Units of length.

use super::StepProblem;
use super::entity::Entity;
use super::exchange::Exchange;
use super::value::Value;

const MM_PER_METRE: f64 = 1000.0;
/// An inch is given by millimetres, and these by metres; nothing goes farther.
const MAX_DEPTH: usize = 4;

impl Exchange<'_> {
    /// Length of the unit that a representation's context declares, mm.
    pub(super) fn unit_mm(&self, context: u64, by: u64) -> Result<f64, StepProblem> {
        let context = self.entity(context, by)?;
        let none = StepProblem::NoUnit { line: context.line, id: context.id };
        let Some(assigned) = context.named("GLOBAL_UNIT_ASSIGNED_CONTEXT") else {
            return Err(none);
        };
        // One of its own has an identifier and a type first.
        let units = assigned.references(if context.is_complex() { 0 } else { 2 })?;
        for unit in units {
            let entity = self.entity(unit, context.id)?;
            if entity.named("LENGTH_UNIT").is_some() {
                return self.length_mm(&entity, MAX_DEPTH);
            }
        }
        Err(none)
    }

    fn length_mm(&self, unit: &Entity<'_>, depth: usize) -> Result<f64, StepProblem> {
        let none = || StepProblem::NoUnit { line: unit.line, id: unit.id };
        if let Some(si) = unit.named("SI_UNIT") {
            let [prefix, name] = si.values else { return Err(none()) };
            let is_metre = *name == Value::Enumeration("METRE");
            let factor = power_of(prefix).filter(|_| is_metre).ok_or_else(none)?;
            return Ok(factor * MM_PER_METRE);
        }
        let Some(converted) = unit.named("CONVERSION_BASED_UNIT").filter(|_| depth > 0) else {
            return Err(none());
        };
        let measure = self.entity(converted.reference(1)?, unit.id)?;
        let record = measure
            .named("MEASURE_WITH_UNIT")
            .or_else(|| measure.named("LENGTH_MEASURE_WITH_UNIT"))
            .ok_or_else(none)?;
        let value = record.number(0)?;
        let base = self.entity(record.reference(1)?, measure.id)?;
        let length_mm = value * self.length_mm(&base, depth - 1)?;
        if length_mm > 0.0 && length_mm.is_finite() { Ok(length_mm) } else { Err(none()) }
    }
}

/// What a prefix of the SI multiplies by.
fn power_of(prefix: &Value<'_>) -> Option<f64> {
    match prefix {
        Value::Absent => Some(1.0),
        Value::Enumeration("KILO") => Some(1e3),
        Value::Enumeration("DECI") => Some(1e-1),
        Value::Enumeration("CENTI") => Some(1e-2),
        Value::Enumeration("MILLI") => Some(1e-3),
        Value::Enumeration("MICRO") => Some(1e-6),
        Value::Enumeration("NANO") => Some(1e-9),
        _ => None,
    }
}
