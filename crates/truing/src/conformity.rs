//! Results held against their limits (JCGM 106:2012).

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

use crate::case::{ConformitySettings, Positive, Problem, nearest};
use crate::count::count;
use crate::estimates::Estimates;
use crate::{Case, Error, IntervalWidth};

/// What is decided of one result.
///
/// What is known of the true value is a normal distribution about the estimate, Student's where the
/// noise was estimated. A result passes where its true value is within ± its limit with at least the
/// required probability, and fails where it is outside with at least that: guarded acceptance and
/// guarded rejection. Between the two nothing is decided.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LimitDecision {
    /// Name of the result.
    pub parameter: String,
    /// Its unit; empty for a pure number.
    pub unit: String,
    /// Its value; `None` where the data do not give it.
    pub value: Option<f64>,
    /// Its standard uncertainty; nothing is decided without one.
    pub std: Option<f64>,
    /// Largest magnitude allowed.
    pub limit: f64,
    /// Probability from which on it passes.
    pub required: f64,
    /// By how much a magnitude has to stay below the limit to pass, and exceed it to fail.
    pub guard_band: Option<f64>,
    /// Probability that the true value is within the limit.
    pub probability: Option<f64>,
    /// `pass`, `fail` or `undecided`.
    pub decision: &'static str,
}

/// A result that can have a limit.
struct Held {
    name: String,
    unit: String,
    value: Option<f64>,
    std: Option<f64>,
}

/// Decisions on the results that `[conformity] limits` names.
pub(crate) fn decisions(
    case: &Case,
    estimates: &dyn Estimates,
    interval: IntervalWidth,
) -> Result<Vec<LimitDecision>, Error> {
    let settings: &ConformitySettings = &case.conformity;
    let Some(limits) = &settings.limits else { return Ok(Vec::new()) };
    let results = results(estimates);
    let decided = |(name, limit): (&String, &Positive)| {
        let held = results.iter().find(|held| held.name == *name).ok_or_else(|| {
            let expected: Vec<String> = results.iter().map(|held| held.name.clone()).collect();
            let found = name.clone();
            let nearest = nearest(&found, expected.iter().map(String::as_str)).map(str::to_owned);
            let problem = Problem::UnknownWord { found, nearest, expected };
            Error::case(case.files.document.at(&limits.span()), problem)
        })?;
        Ok(LimitDecision::of(held, limit.0, settings.required(), interval.degrees_of_freedom))
    };
    limits.get_ref().iter().map(decided).collect()
}

/// The numbers that describe a case, and further results of its form.
fn results(estimates: &dyn Estimates) -> Vec<Held> {
    let mut results: Vec<Held> = (estimates.parameters().into_iter())
        .map(|p| Held { name: p.name, unit: p.unit.to_owned(), value: Some(p.value), std: p.std })
        .collect();
    for result in estimates.form().into_iter().flat_map(|form| form.results) {
        if results.iter().all(|held| held.name != result.symbol) {
            let (value, std) = (result.value, result.std);
            results.push(Held { name: result.symbol, unit: result.unit, value, std });
        }
    }
    results
}

impl LimitDecision {
    fn of(held: &Held, limit: f64, required: f64, degrees_of_freedom: Option<usize>) -> Self {
        let known = held.value.zip(held.std.filter(|std| *std > 0.0 && std.is_finite()));
        let law = Law::of(degrees_of_freedom);
        let probability = known.map(|(value, std)| {
            law.below((limit - value) / std) - law.below((-limit - value) / std)
        });
        Self {
            parameter: held.name.clone(),
            unit: held.unit.clone(),
            value: held.value,
            std: held.std,
            limit,
            required,
            guard_band: known.map(|(_, std)| law.quantile(required) * std),
            probability,
            decision: match probability {
                Some(p) if p >= required => "pass",
                Some(p) if p <= 1.0 - required => "fail",
                _ => "undecided",
            },
        }
    }
}

/// What is known of a true value, in standard uncertainties from the estimate.
struct Law(Box<dyn ContinuousCDF<f64, f64>>);

impl Law {
    fn of(degrees_of_freedom: Option<usize>) -> Self {
        let students = degrees_of_freedom.and_then(|dof| StudentsT::new(0.0, 1.0, count(dof)).ok());
        match students {
            Some(law) => Self(Box::new(law)),
            None => Self(Box::new(Normal::standard())),
        }
    }

    fn below(&self, at: f64) -> f64 {
        self.0.cdf(at)
    }

    fn quantile(&self, probability: f64) -> f64 {
        self.0.inverse_cdf(probability)
    }
}

#[cfg(test)]
mod tests {
    use super::{Held, LimitDecision};

    /// Five digits of the tables of the normal and of Student's distribution.
    const TABLE: f64 = 2e-5;

    fn of(value: f64, std: Option<f64>, dof: Option<usize>) -> LimitDecision {
        let held = Held { name: "A".to_owned(), unit: "mm".to_owned(), value: Some(value), std };
        LimitDecision::of(&held, 10.0, 0.95, dof)
    }

    #[test]
    fn guard_bands_are_those_of_the_tables() {
        let normal = of(8.0, Some(1.0), None);
        assert!((normal.guard_band.unwrap() - 1.644_85).abs() < TABLE, "{normal:?}");
        assert!((normal.probability.unwrap() - 0.977_25).abs() < TABLE, "{normal:?}");
        let few = of(8.0, Some(1.0), Some(5));
        assert!((few.guard_band.unwrap() - 2.015_05).abs() < TABLE, "{few:?}");
        assert_eq!((normal.decision, few.decision), ("pass", "undecided"));
    }

    #[test]
    fn both_signs_are_held_and_nothing_is_decided_without_an_uncertainty() {
        assert_eq!(of(-12.0, Some(1.0), None).decision, "fail");
        assert_eq!(of(-8.0, Some(1.0), None).decision, "pass");
        // As wide as the limit: outside on either side once in three.
        assert_eq!(of(0.0, Some(10.0), None).decision, "undecided");
        let unknown = of(0.0, None, None);
        assert_eq!((unknown.decision, unknown.probability), ("undecided", None));
    }
}
