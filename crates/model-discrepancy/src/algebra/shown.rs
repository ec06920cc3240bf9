//! Effects that no catalogue can list, found by looking at a residual.

use crate::{Course, Patch, State};

/// What a residual shows: patches of a part, and courses of a drift that does not go on evenly.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shown {
    /// Patches of the part.
    pub patches: Vec<Patch>,
    /// Courses of the drift.
    pub courses: Vec<Course>,
}

impl Shown {
    /// How many effects it is.
    #[must_use]
    pub fn effects(&self) -> usize {
        self.patches.len() + self.courses.len()
    }

    /// What shows beside what was found, in place of this; `None` where nothing was found, or nothing
    /// would change.
    ///
    /// The effects of this are the last of the catalogue, patches first; `drift` is the one that goes on
    /// evenly. Patches are looked for anew by `look`, as a place depends on what else is in the model; a
    /// drift that was found stays as it is.
    pub fn beside(
        &self,
        found: &State,
        drift: Option<usize>,
        look: impl Fn(&State) -> Self,
    ) -> Option<Self> {
        let all = found.amplitudes.len();
        if !(0..all).any(|effect| found.has(effect)) {
            return None;
        }
        let (patches, courses) = (all - self.effects(), all - self.courses.len());
        let mut rest = found.clone();
        for patch in patches..courses {
            rest.amplitudes[patch].fill(0.0);
        }
        let mut there = look(&rest);
        if there.patches.is_empty() {
            there.patches.clone_from(&self.patches);
        }
        if there.courses.is_empty() || drift.into_iter().chain(courses..all).any(|d| found.has(d)) {
            there.courses.clone_from(&self.courses);
        }
        (there != *self).then_some(there)
    }
}
