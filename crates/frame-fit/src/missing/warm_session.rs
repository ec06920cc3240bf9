//! Points measured warmer or colder from one on, by a temperature that nobody recorded.

use model_discrepancy::{Course, Effect, Scope, State, clearest_courses};

use super::effects::{expansion, parameter};
use crate::FrameModel;

impl<const D: usize> FrameModel<D> {
    /// The session from whose first point on the residual shows another length.
    pub(super) fn clearest_warm_session(&self) -> Option<Course> {
        let (_, elapsed) = self.drift()?;
        let evenly = self.growing(elapsed);
        let growth = evenly.terms.len() - 1;
        let all = clearest_courses(&evenly, &State::start(&evenly), growth, elapsed);
        all.into_iter().find(|course| matches!(course, Course::Session(_)))
    }

    /// The model with that session in its catalogue.
    pub(crate) fn with_warm_session(self, warm: Option<Course>) -> Self {
        let Some((course, (_, elapsed))) = warm.zip(self.drift()) else { return self };
        let mut model = self.growing(&course.come(elapsed));
        let index = model.terms.len() - 1;
        let mut effect = course.effect(&model, index, elapsed, "s", ("ppm", 1e6));
        let subject = effect.subject.as_deref().unwrap_or_default();
        effect.description = format!(
            "the points {subject} were measured warmer or colder than those before, by a temperature \
             that was not recorded"
        );
        "session-temperature".clone_into(&mut effect.id);
        model.declared.effects[index] = effect;
        model.warm = warm;
        model
    }

    /// The model with a growth that follows `course` last in its catalogue.
    fn growing(&self, course: &[f64]) -> Self {
        let mut model = self.clone();
        let text = "the points grow while they are measured";
        let effect = Effect::new("growth", text, vec![parameter("growth", "ppm", 1e6)]);
        model.declared.effects.push(effect.within(Scope::SomeDesigns));
        model.terms.push(expansion(self.transform, &self.points, course.to_vec()));
        model
    }
}
