//! How a drift of an axis goes, where it does not go on evenly.

use model_discrepancy::{
    Course, Declared, Effect, Layout, LinearModel, Model, Scope, Shown, Sought, State,
    whole_tangent,
};
use nalgebra::{DMatrix, DVector, Point3};

use crate::AxisReading;
use crate::missing::axis_effects::MIN_VISITS;
use crate::missing::axis_run::{AxisRun, AxisTerm};
use crate::missing::parameter::parameter;

impl AxisRun<'_> {
    /// The courses that are left about the mean of every target and side, which is all that a profile,
    /// a pitch error or a reversal could be; those that are not clear there, about a line for either
    /// side.
    #[must_use]
    pub fn shown(&self) -> Shown {
        let (elapsed, places) = (self.elapsed(), self.places());
        let about = |base: DMatrix<f64>| {
            let model = self.beside(base, vec![self.even()]);
            Shown::of(&model, &State::start(&model), &sought(&elapsed, &places)).courses
        };
        let mut courses = self.means().map_or_else(Vec::new, about);
        let is_known = |known: &[(usize, Course)], course: &Course| {
            known.iter().any(|(_, k)| std::mem::discriminant(k) == std::mem::discriminant(course))
        };
        for (drift, course) in about(self.lines()) {
            if !is_known(&courses, &course) {
                courses.push((drift, course));
            }
        }
        Shown { courses: either_way(courses), ..Shown::default() }
    }

    /// The same beside what was found in a model whose rows are the readings, and whose last effects
    /// are the courses shown.
    #[must_use]
    pub fn shown_beside(&self, shown: &Shown, model: &dyn Model, found: &State) -> Shown {
        let effects = &model.declared().effects;
        let Some(drift) = effects.iter().position(|effect| effect.id == "drift") else {
            return shown.clone();
        };
        let courses = effects.len() - shown.effects();
        let is_one = |&effect: &usize| effect != drift && found.has(effect);
        let others: Vec<usize> = (0..courses).filter(is_one).collect();
        let has_profile = others.iter().any(|&effect| effects[effect].id == "profile");
        let base = self.means().filter(|_| has_profile).unwrap_or_else(|| self.lines());
        let all: Vec<usize> =
            std::iter::once(drift).chain(others).chain(courses..effects.len()).collect();
        let of = |&effect: &usize| {
            // Of all rows, also where it is about one.
            let whole = effects[effect].clone().within(Scope::SomeDesigns);
            (whole, whole_tangent(model, found, effect))
        };
        let about = self.beside(base, all.iter().map(of).collect());
        let amplitudes = all.iter().map(|&effect| found.amplitudes[effect].clone()).collect();
        let found = State { amplitudes, ..State::start(&about) };
        let shown = shown.beside(&about, &found, &sought(&self.elapsed(), &self.places()));
        Shown { courses: either_way(shown.courses), ..shown }
    }

    /// The drift along these courses.
    pub(super) fn courses(&self, shown: &Shown) -> Vec<AxisTerm> {
        if self.is_one_pass() {
            return Vec::new();
        }
        let elapsed = self.elapsed();
        let model = self.beside(self.lines(), vec![self.even()]);
        let unit = if self.time().is_some() { "s" } else { "readings" };
        let along = |(_, course): &(usize, Course)| {
            let mut effect = course.effect(&model, 0, &elapsed, unit, self.motion.reported());
            // Zero and length have a unit each.
            effect.parameters = self.growing(&format!(", {}", course.seen_in_full()));
            AxisTerm { effect, columns: self.grown(course.come(&elapsed)) }
        };
        shown.courses.iter().map(along).collect()
    }

    /// Zero and length that go with the time itself. It is not driven by it: what is read in the order
    /// of its targets may as well be one of those, so that a session has to lie among the others.
    fn even(&self) -> (Effect, DMatrix<f64>) {
        let text = "zero and length of the axis drift";
        let effect = Effect::new("drift", text, self.growing(", in the end"));
        let term = AxisTerm { effect, columns: self.grown(self.elapsed()) };
        let tangent = term.tangent();
        (term.effect, tangent)
    }

    /// Effects, and their tangents, beside free columns.
    fn beside(&self, base: DMatrix<f64>, effects: Vec<(Effect, DMatrix<f64>)>) -> LinearModel {
        let unit = self.motion.deviation_unit();
        let names = self.readings.iter().map(|r| r.name.clone());
        let free = (0..base.ncols()).map(|k| parameter(&k.to_string(), unit, 1.0)).collect();
        let (effects, tangents) = effects.into_iter().unzip();
        let deviations = self.readings.iter().map(|r| r.deviation);
        LinearModel {
            declared: Declared::new(Layout::scalars(names, unit, None), free, effects),
            residual: DVector::from_iterator(self.readings.len(), deviations),
            base,
            tangents,
            extended: Vec::new(),
        }
    }

    /// A mean for every target and side; `None` where too few readings repeat to tell.
    fn means(&self) -> Option<DMatrix<f64>> {
        let place =
            |r: &AxisReading| (r.target.to_bits(), r.approach.map(|a| a.sign().is_sign_positive()));
        let mut places: Vec<_> = self.readings.iter().map(place).collect();
        let of_reading = places.clone();
        places.sort_unstable();
        places.dedup();
        let n = self.readings.len();
        let is_there = |i: usize, k: usize| f64::from(u8::from(of_reading[i] == places[k]));
        (n >= MIN_VISITS * places.len()).then(|| DMatrix::from_fn(n, places.len(), is_there))
    }

    /// A line for each side.
    fn lines(&self) -> DMatrix<f64> {
        let column = |k: usize, r: &AxisReading| {
            let side = r.approach.map_or(0.0, crate::Approach::sign);
            [1.0, r.target, side, side * r.target][k]
        };
        DMatrix::from_fn(self.readings.len(), 4, |i, k| column(k, &self.readings[i]))
    }

    /// Every target, as a place.
    fn places(&self) -> Vec<Option<Point3<f64>>> {
        self.readings.iter().map(|r| Some(Point3::new(r.target, 0.0, 0.0))).collect()
    }
}

/// Courses that come to rest, away from zero and at zero: of the lines and means that they are looked for beside
/// a zero is one, an axis has none of its own.
fn either_way(courses: Vec<(usize, Course)>) -> Vec<(usize, Course)> {
    let mut all: Vec<(usize, Course)> = Vec::with_capacity(2 * courses.len());
    for (drift, course) in courses {
        let both = std::iter::once(course).chain(course.the_other_way());
        for one in both.map(|course| (drift, course)) {
            if !all.contains(&one) {
                all.push(one);
            }
        }
    }
    all
}

fn sought<'a>(elapsed: &'a [f64], places: &'a [Option<Point3<f64>>]) -> Sought<'a> {
    Sought { drifts: vec![0], elapsed, places, has_surface: false }
}
