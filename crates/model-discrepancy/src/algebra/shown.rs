//! Effects that no catalogue can list, found by looking at a residual.

use nalgebra::Point3;

use crate::algebra::course::{clearest_courses, likeliest_courses};
use crate::algebra::patch::clearest_patches;
use crate::{Course, Declared, Model, Patch, State};

/// What a residual shows: patches of a part, and courses of a drift that does not go on evenly.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shown {
    /// Patches of the part.
    pub patches: Vec<Patch>,
    /// Courses of a drift, each with the effect of the catalogue that goes on evenly.
    pub courses: Vec<(usize, Course)>,
}

/// What is looked for in the residual of a model.
#[derive(Clone, Debug, Default)]
pub struct Sought<'a> {
    /// The effects of the catalogue that go on evenly.
    pub drifts: Vec<usize>,
    /// What their amplitudes are multiplied by: the time since the start of the series, one value per
    /// observation.
    pub elapsed: &'a [f64],
    /// Place of each observation, as far as there is one.
    pub places: &'a [Option<Point3<f64>>],
    /// Whether it is a surface that was measured, which may be higher in one place.
    pub has_surface: bool,
}

impl Shown {
    /// What shows in a model at a solution of its declared part, or of that and the effects that `at`
    /// has, where white noise hardly ever shows it as clear.
    #[must_use]
    pub fn of(model: &dyn Model, at: &State, sought: &Sought<'_>) -> Self {
        let courses = sought.courses(model, at, clearest_courses);
        Self { patches: sought.patches(model, at), courses }
    }

    /// How many effects it is.
    #[must_use]
    pub fn effects(&self) -> usize {
        self.patches.len() + self.courses.len()
    }

    /// Takes its effects off the end of a catalogue, and of what the model keeps beside each effect.
    pub fn take_off<T>(&self, declared: &mut Declared, terms: &mut Vec<T>) {
        let listed = declared.effects.len() - self.effects();
        declared.effects.truncate(listed);
        terms.truncate(listed);
    }

    /// What shows beside what was found in a model, in place of this, whose effects are the last of the
    /// catalogue, patches first; the same where nothing was found.
    ///
    /// Each sort is looked for without those of its own that were found, as where a patch lies, and how
    /// a drift goes, depends on what else is in the model. Where one drifts at all, the likeliest other
    /// courses are shown as rivals, whether they are clear or not.
    #[must_use]
    pub fn beside(&self, model: &dyn Model, found: &State, sought: &Sought<'_>) -> Self {
        let all = found.amplitudes.len();
        if !(0..all).any(|effect| found.has(effect)) {
            return self.clone();
        }
        let (patches, courses) = (all - self.effects(), all - self.courses.len());
        let patches = sought.patches(model, &without(found, patches..courses));
        let of_time = || (courses..all).chain(sought.drifts.iter().copied());
        let look =
            if of_time().any(|e| found.has(e)) { likeliest_courses } else { clearest_courses };
        let courses = sought.courses(model, &without(found, of_time()), look);
        let courses = courses.into_iter().map(|(drift, course)| {
            let is_it = |(of, known): &(usize, Course)| *of == drift && known.is_like(&course);
            self.courses.iter().copied().find(is_it).unwrap_or((drift, course))
        });
        Self {
            patches: not_empty(patches, &self.patches),
            courses: not_empty(courses.collect(), &self.courses),
        }
    }
}

/// Courses along which a drift takes most of the residual of a model at a state: the effect that goes on evenly, the time
/// that had passed, and places.
type Look = fn(&dyn Model, &State, usize, &[f64], &[Option<Point3<f64>>]) -> Vec<Course>;

impl<'a> Sought<'a> {
    /// Courses of some effects that go on evenly, each with the time since the start, which is that of all.
    #[must_use]
    pub fn of_drifts(drifts: impl Iterator<Item = (usize, &'a [f64])>) -> Self {
        let (drifts, elapsed): (Vec<usize>, Vec<&[f64]>) = drifts.unzip();
        Self { drifts, elapsed: elapsed.first().copied().unwrap_or_default(), ..Self::default() }
    }

    fn courses(&self, model: &dyn Model, at: &State, look: Look) -> Vec<(usize, Course)> {
        let of = |drift: &usize| look(model, at, *drift, self.elapsed, self.places);
        let each = self.drifts.iter().map(|drift| (*drift, of(drift)));
        each.flat_map(|(drift, all)| all.into_iter().map(move |course| (drift, course))).collect()
    }

    fn patches(&self, model: &dyn Model, at: &State) -> Vec<Patch> {
        if self.has_surface { clearest_patches(model, at, self.places) } else { Vec::new() }
    }
}

fn without(found: &State, effects: impl Iterator<Item = usize>) -> State {
    let mut rest = found.clone();
    for effect in effects {
        rest.amplitudes[effect].fill(0.0);
    }
    rest
}

/// What shows no more beside what was found may be what that stands for: it stays in question.
fn not_empty<T: Clone>(there: Vec<T>, known: &[T]) -> Vec<T> {
    if there.is_empty() { known.to_vec() } else { there }
}
