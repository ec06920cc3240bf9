//! A machine as a page.

use truing_report::{MachineAmplitude, MachineCase, MachineEffect, MachinePage, render_machine};

use super::answer::{CaseOfMachine, ClosedMachine, StepByCase};
use crate::text::advice;
use crate::{LoopParameter, LoopStep};

/// The answer as one self-contained HTML page.
#[must_use]
pub fn machine_report(of: &ClosedMachine) -> String {
    let title = of.name.as_deref().unwrap_or("machine");
    let named: Vec<String> = of.steps.iter().map(LoopStep::label).collect();
    let shared = match &named[..] {
        [] => "they share nothing that their declared models lack".to_owned(),
        names => format!("they share {}", names.join(", ")),
    };
    let lede = format!("{} cases: {}; {shared}.", of.cases.len(), of.verdict);
    let effects: Vec<MachineEffect> =
        of.steps.iter().zip(&of.by_case).map(|(step, by_case)| effect(step, by_case)).collect();
    let cases: Vec<MachineCase> = of.cases.iter().map(case).collect();
    let (effects, cases, warnings) = (&effects, &cases, &of.warnings);
    render_machine(&MachinePage { title, lede: &lede, effects, cases, warnings })
}

fn effect(step: &LoopStep, by_case: &StepByCase) -> MachineEffect {
    let rivals = if step.indistinguishable_from.is_empty() {
        String::new()
    } else {
        let (names, advice) =
            (step.indistinguishable_from.join(", "), advice(step.separate_by.as_deref()));
        format!(" It cannot be told apart from {names}{advice}.")
    };
    let words = step.in_words();
    let mut letters = words.chars();
    let first: String = letters.next().into_iter().flat_map(char::to_uppercase).collect();
    MachineEffect {
        name: step.label(),
        description: format!("{first}{}.{rivals}", letters.as_str()),
        amplitudes: step.parameters.iter().map(|p| amplitude(p, by_case)).collect(),
    }
}

fn amplitude(of: &LoopParameter, by_case: &StepByCase) -> MachineAmplitude {
    let own = by_case.cases.iter().filter_map(|case| {
        let found = case.parameters.iter().find(|p| p.name == of.name)?;
        Some((case.case.clone(), found.value, found.std))
    });
    let agreement = by_case.agreement.iter().find(|a| a.parameter == of.name);
    MachineAmplitude {
        name: of.name.clone(),
        unit: of.unit.clone(),
        by_case: own.collect(),
        all: (of.value, of.std),
        agreement_p_value: agreement.map(|a| a.p_value),
    }
}

fn case(of: &CaseOfMachine) -> MachineCase {
    MachineCase {
        name: of.case.clone(),
        kind: of.kind.to_owned(),
        unit: of.before.unit.clone(),
        before: of.before.held_out_rms,
        with_others: of.with_others.as_ref().map(|error| error.held_out_rms),
        after: of.after.held_out_rms,
        beside: of.steps.iter().map(LoopStep::label).collect(),
        named_alone: of.named_alone.clone(),
        verdict: of.verdict.to_owned(),
    }
}
