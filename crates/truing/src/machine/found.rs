use model_discrepancy::{Closure, Column, CommonEffect, Joint, Model, ShownAmplitude, State, Step};
use nalgebra::DVector;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::answer::{Agreement, StepByCase, StepInCase};
use super::linear::{OnTheirOwn, on_their_own};
use super::read::Machine;
use crate::carry::{LearntParameter, LearntStep};
use crate::count::count;
use crate::text::labelled;
use crate::{Closed, LoopParameter};

/// What was found with the data of all cases.
pub(super) struct Found<'f, 'm> {
    pub(super) joint: &'f Joint<'m>,
    pub(super) shared: &'f [CommonEffect],
    pub(super) closure: &'f Closure,
}

impl Found<'_, '_> {
    /// Steps that are the machine's, with the index of the common effect.
    pub(super) fn steps(&self) -> impl Iterator<Item = (usize, &Step)> {
        self.closure.steps.iter().filter_map(|step| {
            let is_it =
                |c: &CommonEffect| c.effect.id == step.effect && c.effect.subject == step.subject;
            Some((self.shared.iter().position(is_it)?, step))
        })
    }

    /// Where the amplitudes of a common effect stand among the columns.
    fn columns(&self, common: usize) -> Vec<usize> {
        let is_own =
            |c: &Column| matches!(c, Column::Amplitude { effect, .. } if *effect == common);
        let columns = self.closure.columns.iter().enumerate();
        columns.filter(|(_, c)| is_own(c)).map(|(at, _)| at).collect()
    }

    fn own_solution(&self, is_among: impl Fn(usize) -> bool) -> OnTheirOwn {
        on_their_own(self.closure, &self.joint.declared().layout, is_among)
    }

    /// What every case says of a step.
    pub(super) fn by_case(
        &self,
        (common, step): (usize, &Step),
        machine: &Machine,
        alone: &[Closed],
    ) -> StepByCase {
        let effect = &self.shared[common].effect;
        let columns = self.columns(common);
        let mut cases = Vec::new();
        for (part, member) in machine.members.iter().enumerate() {
            let shown: Vec<&ShownAmplitude> =
                self.shared[common].shown.iter().filter(|s| s.part == part).collect();
            if shown.is_empty() {
                continue;
            }
            let rows = self.joint.rows(part);
            let own = self.own_solution(|row| rows.contains(&row));
            let parameters = columns.iter().zip(&effect.parameters).enumerate();
            let parameters = parameters.filter_map(|(k, (&column, parameter))| {
                let amplitude = self.closure.state.amplitudes[common][k] + own.moved[column];
                Some(LoopParameter {
                    name: parameter.name.clone(),
                    value: amplitude * parameter.report_factor,
                    unit: parameter.unit.clone(),
                    std: own.std[column]? * parameter.report_factor.abs(),
                })
            });
            let named_alone = names(&alone[part], &shown, &self.part_effects(part));
            let case = member.name.clone();
            cases.push(StepInCase { case, named_alone, parameters: parameters.collect() });
        }
        let agreement = effect.parameters.iter().filter_map(|p| agreement(&p.name, &cases));
        let (effect, subject) = (step.effect.clone(), step.subject.clone());
        StepByCase { effect, subject, agreement: agreement.collect(), cases }
    }

    /// Labels of a part's own effects.
    fn part_effects(&self, part: usize) -> Vec<String> {
        let effects = &self.joint.part(part).declared().effects;
        effects.iter().map(|e| labelled(&e.id, e.subject.as_deref())).collect()
    }

    /// The machine's effects in the words of a case.
    pub(super) fn learnt(&self, part: usize) -> Vec<LearntStep> {
        let effects = &self.joint.part(part).declared().effects;
        let own = &self.joint.of_part(part, &self.machine_alone()).amplitudes;
        let is_shown = |effect: &usize| own[*effect].amax() > 0.0;
        (0..effects.len())
            .filter(is_shown)
            .map(|e| LearntStep {
                effect: effects[e].id.clone(),
                subject: effects[e].subject.clone(),
                description: None,
                parameters: (effects[e].parameters.iter().zip(own[e].iter()))
                    .map(|(p, amplitude)| LearntParameter {
                        name: p.name.clone(),
                        value: Some(amplitude * p.report_factor),
                        unit: p.unit.clone(),
                        std: None,
                    })
                    .collect(),
                indistinguishable_from: Vec::new(),
            })
            .collect()
    }

    /// The state with the machine's effects and no others.
    fn machine_alone(&self) -> State {
        let mut state = self.closure.state.clone();
        let steps: Vec<usize> = self.steps().map(|(common, _)| common).collect();
        for (effect, amplitudes) in state.amplitudes.iter_mut().enumerate() {
            if !steps.contains(&effect) {
                amplitudes.fill(0.0);
            }
        }
        state
    }

    /// Amplitudes of a case's effects with the machine's as the other cases alone have them.
    pub(super) fn amplitudes_of_others(&self, part: usize) -> Option<Vec<DVector<f64>>> {
        let rows = self.joint.rows(part);
        let others = self.own_solution(|row| !rows.contains(&row));
        let mut state = self.machine_alone();
        let mut is_any = false;
        for (common, _) in self.steps() {
            let shown = &self.shared[common].shown;
            for (k, &column) in self.columns(common).iter().enumerate() {
                if !shown.iter().any(|s| s.part == part && s.of == k) {
                    continue;
                }
                others.std[column]?;
                state.amplitudes[common][k] += others.moved[column];
                is_any = true;
            }
        }
        is_any.then(|| self.joint.of_part(part, &state).amplitudes)
    }
}

/// Whether the loop on a case alone names what it shows of an effect of the machine.
fn names(alone: &Closed, shown: &[&ShownAmplitude], labels: &[String]) -> bool {
    alone.steps.iter().any(|step| {
        let label = step.label();
        shown.iter().any(|s| labels[s.effect] == label)
    })
}

/// Whether the cases agree about one amplitude; `None` where fewer than two determine it.
fn agreement(parameter: &str, cases: &[StepInCase]) -> Option<Agreement> {
    let own = cases.iter().flat_map(|case| case.parameters.iter().filter(|p| p.name == parameter));
    let known: Vec<[f64; 2]> = own.map(|p| [p.value, p.std.powi(-2)]).collect();
    let dof = known.len().checked_sub(1).filter(|dof| *dof > 0)?;
    let [sum, weight] = known.iter().fold([0.0; 2], |[s, w], [v, of]| [s + v * of, w + of]);
    let chi2 = known.iter().map(|[v, of]| (v - sum / weight).powi(2) * of).sum();
    let p_value = ChiSquared::new(count(dof)).map_or(1.0, |law| law.sf(chi2));
    Some(Agreement { parameter: parameter.to_owned(), chi2, dof, p_value })
}
