//! What a plan is worth: the same figures without it and with it.

use model_discrepancy::{Assessment, Model, Visibility};
use nalgebra::DMatrix;

use super::design::{Design, Goal};
use super::foreseen::ToldApart;
use super::linear::Linear;
use super::planned::PlanFigure;
use super::power::power;
use super::question::{Ask, DECIDED, Question};

/// Coverage factor of expanded uncertainties.
const COVERAGE: f64 = 2.0;

/// A plan on the model of the case with it.
pub(super) struct Outlook<'a> {
    question: &'a Question,
    model: &'a dyn Model,
    design: Design,
    /// Information without the plan, and with it.
    stages: [DMatrix<f64>; 2],
    /// Rows without the plan, and with it.
    rows: [usize; 2],
}

impl<'a> Outlook<'a> {
    pub(super) fn of(question: &'a Question, model: &'a dyn Model, linear: &Linear) -> Self {
        let design = Design::of(&linear.measured, &linear.planned, linear.n_base);
        let stages = [design.with(&[]), design.with_all().clone()];
        let planned: usize = linear.planned.iter().map(DMatrix::nrows).sum();
        let measured = linear.measured.nrows();
        Self { question, model, design, stages, rows: [measured, measured + planned] }
    }

    /// Whether a goal is met with the plan.
    pub(super) fn meets(&self, goal: &Goal) -> bool {
        self.design.is_met(goal, &self.stages[1])
    }

    /// Figures of every ask; `assessed` is what the design sees without the plan, and with it,
    /// `told_apart` what loops on simulated data make of the plan.
    pub(super) fn figures(
        &self,
        goals: &[(usize, Goal)],
        assessed: [&[Assessment]; 2],
        told_apart: &ToldApart,
    ) -> Vec<PlanFigure> {
        let mut figures = Vec::new();
        for (index, ask) in self.question.asks.iter().enumerate() {
            let own = goals.iter().find(|(ask, _)| *ask == index).map(|(_, goal)| goal);
            match ask {
                Ask::Apart { truth, rival, .. } => {
                    let most = told_apart.share(index).unwrap_or(1.0);
                    figures.push(self.apart((truth, rival), own, most));
                }
                Ask::Visible { effect } => figures.extend(detectable(effect, assessed)),
                Ask::Known { .. } => figures.extend(own.and_then(|goal| self.known(goal))),
                Ask::All => figures.extend(own.into_iter().flat_map(|goal| self.all(goal))),
            }
        }
        figures
    }

    /// With what probability one name stays beside another; with the plan, not above `most`.
    fn apart(&self, (truth, rival): (&str, &str), goal: Option<&Goal>, most: f64) -> PlanFigure {
        let probability = |stage: usize| {
            let Some(goal @ Goal::Seen { of, beside, .. }) = goal else { return 0.0 };
            let dof = self.rows[stage].saturating_sub(of.len() + beside.len());
            power(self.design.value(goal, &self.stages[stage]), of.len(), dof, DECIDED)
        };
        PlanFigure {
            of: format!("{truth}, not {rival}"),
            measure: "probability",
            before: Some(probability(0)),
            after: Some(probability(1).min(most)),
            unit: "1".to_owned(),
        }
    }

    /// Expanded uncertainty of a parameter of the declared model.
    fn known(&self, goal: &Goal) -> Option<PlanFigure> {
        let Goal::Known { of, .. } = goal else { return None };
        let known = self.model.declared().base.get(*of)?;
        let factor = COVERAGE * known.report_factor.abs();
        let u = |stage: usize| Some(factor * self.design.value(goal, &self.stages[stage]).sqrt());
        Some(PlanFigure {
            of: known.name.clone(),
            measure: "uncertainty",
            before: u(0),
            after: u(1),
            unit: known.unit.clone(),
        })
    }

    /// The same of every one of them.
    fn all(&self, goal: &Goal) -> Vec<PlanFigure> {
        let Goal::Determined { columns } = goal else { return Vec::new() };
        let one = |of: &usize| {
            let beside = columns.iter().copied().filter(|column| column != of).collect();
            self.known(&Goal::Known { of: *of, beside, needed: 0.0 })
        };
        columns.iter().filter_map(one).collect()
    }
}

/// Amplitudes of an effect by name, with the smallest size that is found nine times in ten and its
/// unit; none where it is hidden.
pub(super) fn sizes<'a>(effect: &str, assessed: &'a [Assessment]) -> &'a [(String, f64, String)] {
    let is_it = |a: &&Assessment| match &a.subject {
        Some(subject) => format!("{} [{subject}]", a.effect) == effect,
        None => a.effect == effect,
    };
    match assessed.iter().find(is_it).map(|a| &a.sight) {
        Some(Visibility::Visible { detectable, .. }) => detectable.as_slice(),
        _ => &[],
    }
}

/// Smallest sizes that are found nine times in ten.
fn detectable(effect: &str, assessed: [&[Assessment]; 2]) -> Vec<PlanFigure> {
    let sizes = assessed.map(|all| sizes(effect, all));
    let size = |stage: usize, name: &str| {
        sizes[stage].iter().find(|(known, ..)| known == name).map(|(_, size, _)| *size)
    };
    // Amplitudes that are seen with the plan; where none is, those that are seen without it.
    let named = if sizes[1].is_empty() { sizes[0] } else { sizes[1] };
    let figure = |(name, _, unit): &(String, f64, String)| PlanFigure {
        of: format!("{effect}: {name}"),
        measure: "detectable",
        before: size(0, name),
        after: size(1, name),
        unit: unit.clone(),
    };
    if named.is_empty() {
        let of = effect.to_owned();
        return vec![PlanFigure {
            of,
            measure: "detectable",
            before: None,
            after: None,
            unit: String::new(),
        }];
    }
    named.iter().map(figure).collect()
}
