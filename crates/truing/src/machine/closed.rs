use std::collections::BTreeSet;

use model_discrepancy::{CommonEffect, Joint, JointPart, Options};
use nalgebra::DVector;

use super::MachineProblem;
use super::amplitude::{Catalogue, MACHINE, common};
use super::answer::{CaseOfMachine, ClosedMachine, StepByCase};
use super::found::Found;
use super::read::{Machine, Member};
use crate::carry::{Learnt, carrying};
use crate::case::Location;
use crate::closed::INPUT_WRONG;
use crate::measured::Prepared;
use crate::suspect::Suspect;
use crate::text::labelled;
use crate::{Closed, Error, Header, JudgedRms, LoopStep, close_loop};

/// Chance of a disagreement between cases below which it is said.
const DISAGREES: f64 = 0.01;

/// Verdicts from the best to the worst; a machine ends as the worst of its cases.
const VERDICTS: [&str; 5] = [
    "nothing-missing",
    "explained",
    "noise-larger-than-declared",
    "structure-remains",
    INPUT_WRONG,
];

/// Closes the loop on all cases of a machine: what they share has one amplitude with the data of all.
///
/// Each case is closed alone first, and at last with the machine's effects taken as declared, once as
/// all cases have them and once as the other cases alone have them.
///
/// # Errors
///
/// [`Error::Machine`] where the cases cannot be joined; as [`close_loop`] for each.
pub fn close_machine(machine: &Machine) -> Result<ClosedMachine, Error> {
    let alone = machine.alone()?;
    let prepared = (machine.members.iter().zip(&alone))
        .map(|(member, closed)| {
            let prepared = member.case.measured.prepare()?;
            Ok(prepared.there(&closed.closure.solution())?.unwrap_or(prepared))
        })
        .collect::<Result<Vec<Prepared<'_>>, Error>>()?;
    let shared = machine.common(&prepared)?;
    let mut parts = Vec::new();
    for ((member, closed), prepared) in machine.members.iter().zip(&alone).zip(&prepared) {
        let (name, noise_ratio) = (member.name.clone(), closed.closure.variance_factor.sqrt());
        parts.push(JointPart { name, model: &*prepared.model, noise_ratio });
    }
    let joint = Joint::new(parts, shared.clone()).ok_or_else(|| {
        let unit = |p: &Prepared<'_>| p.model.declared().layout.unit.clone();
        let units: BTreeSet<String> = prepared.iter().map(unit).collect();
        let cases = machine.members.iter().map(|m| m.name.clone()).collect();
        machine.fail(MachineProblem::OtherUnits { cases, units: units.into_iter().collect() })
    })?;
    let closure = model_discrepancy::close_loop(&joint, &[], &Options::default())
        .map_err(|source| Error::Loop { at: Box::new(Location::file(&machine.path)), source })?;
    let of_all = Found { joint: &joint, shared: &shared, closure: &closure };

    let (mut cases, mut warnings) = (Vec::new(), Vec::new());
    for (part, (member, closed)) in machine.members.iter().zip(&alone).enumerate() {
        let (case, own) = machine.with_machine(part, member, closed, &of_all)?;
        warnings.extend(own.into_iter().map(|warning| format!("{}: {warning}", member.name)));
        cases.push(case);
    }
    let by_case: Vec<StepByCase> =
        of_all.steps().map(|found| of_all.by_case(found, machine, &alone)).collect();
    let steps: Vec<LoopStep> = of_all.steps().map(|(_, step)| LoopStep::of(step)).collect();
    warnings.extend(by_case.iter().flat_map(disagreements));
    warnings.extend(machine.silent(&shared));
    let found = usize::from(!steps.is_empty());
    let rank = |case: &CaseOfMachine| VERDICTS.iter().position(|v| *v == case.verdict);
    let worst = cases.iter().filter_map(rank).max().unwrap_or(0).max(found);
    Ok(ClosedMachine {
        kind: MACHINE,
        version: env!("CARGO_PKG_VERSION"),
        header: Header::without_case("truing/machine/1", machine.inputs()),
        name: machine.name.clone(),
        steps,
        by_case,
        cases,
        before: JudgedRms::of(&closure.before),
        after: JudgedRms::of(&closure.after),
        verdict: VERDICTS[worst],
        warnings,
    })
}

impl Machine {
    /// The loop on every case alone, with its input in order.
    fn alone(&self) -> Result<Vec<Closed>, Error> {
        let one = |member: &Member| {
            let closed = close_loop(&member.case)?;
            if closed.verdict == INPUT_WRONG {
                let mistake = closed.suspects.first().map_or_else(String::new, Suspect::warning);
                let case = member.name.clone();
                return Err(self.fail(MachineProblem::InputWrong { case, mistake }));
            }
            Ok(closed)
        };
        self.members.iter().map(one).collect()
    }

    /// Effects that are the machine's; what the user calls so must be in two cases.
    fn common(&self, prepared: &[Prepared<'_>]) -> Result<Vec<CommonEffect>, Error> {
        let mut catalogues = Vec::new();
        for (member, prepared) in self.members.iter().zip(prepared) {
            let (kind, axis) = (member.case.kind, member.axis);
            catalogues.push(Catalogue { kind, axis, model: &*prepared.model });
        }
        let mut all = common(&catalogues);
        let known: BTreeSet<String> = all.iter().map(|c| c.effect.id.clone()).collect();
        let unknown = self.shared.iter().find(|id| self.is_said && !known.contains(*id));
        all.retain(|common| self.shared.contains(&common.effect.id));
        if unknown.is_some() || all.is_empty() {
            let effect = unknown.cloned().unwrap_or_else(|| self.shared.join(" or "));
            let known = known.into_iter().collect();
            return Err(self.fail(MachineProblem::NotShared { effect, known }));
        }
        Ok(all)
    }

    /// Cases that show nothing of what is shared.
    fn silent(&self, shared: &[CommonEffect]) -> Vec<String> {
        let shows = |part: usize| shared.iter().any(|c| c.shown.iter().any(|s| s.part == part));
        let why = |member: &Member| match member.case.kind {
            "positioning" if member.axis.is_none() => "; say which axis it is by `axis = \"x\"`",
            _ => "",
        };
        (self.members.iter().enumerate())
            .filter(|(part, _)| !shows(*part))
            .map(|(_, m)| format!("{}: shows nothing that is shared{}", m.name, why(m)))
            .collect()
    }

    /// A case with the machine's effects taken as declared, and what is to be said of it.
    fn with_machine(
        &self,
        part: usize,
        member: &Member,
        alone: &Closed,
        found: &Found<'_, '_>,
    ) -> Result<(CaseOfMachine, Vec<String>), Error> {
        let named_alone = alone.steps.iter().map(LoopStep::label).collect();
        let learnt = found.learnt(part);
        let closed;
        let closed = if learnt.is_empty() {
            alone
        } else {
            let mut case = member.case.with(&[])?;
            case.learnt = Some(Learnt {
                from: self.input.path.clone(),
                input: self.input.clone(),
                kind: case.kind.to_owned(),
                steps: learnt,
            });
            closed = close_loop(&case)?;
            &closed
        };
        let before = closed.carried.as_ref().map_or(&alone.before, |carried| &carried.without);
        let with_others = match found.amplitudes_of_others(part) {
            Some(amplitudes) => Some(judged(member, amplitudes)?),
            None => None,
        };
        let case = CaseOfMachine {
            case: member.name.clone(),
            kind: member.case.kind,
            verdict_alone: alone.verdict,
            named_alone,
            before: before.clone(),
            with_others,
            after: closed.after.clone(),
            steps: closed.steps.clone(),
            verdict: closed.verdict,
        };
        Ok((case, closed.warnings.clone()))
    }
}

/// Error of a case's declared model with amplitudes that count as declared.
fn judged(member: &Member, amplitudes: Vec<DVector<f64>>) -> Result<JudgedRms, Error> {
    let prepared = carrying(member.case.measured.prepare()?, amplitudes);
    let options = Options { max_steps: 0, ..member.case.loop_settings.options() };
    let closure = model_discrepancy::close_loop(&*prepared.model, &prepared.covariates, &options)
        .map_err(|source| member.case.loop_error(source))?;
    Ok(JudgedRms::of(&closure.before))
}

/// What cases do not agree about.
fn disagreements(step: &StepByCase) -> Vec<String> {
    let name = labelled(&step.effect, step.subject.as_deref());
    let doubtful = step.agreement.iter().filter(|a| a.p_value < DISAGREES);
    doubtful
        .map(|a| {
            format!(
                "{name}: the cases do not agree about {} (p = {:.1e}): it may have changed between \
                 them, or something else be in one of them",
                a.parameter, a.p_value
            )
        })
        .collect()
}
