//! Tip of a tool from poses, as the loop sees it.

use model_discrepancy::{
    Course, Covariate, Declared, Group, Inside, Layout, Model, Parameter, Proposal, Quantity, Role,
    Row, Shown, Sought, State, resolution_of,
};
use nalgebra::{DMatrix, DVector, Matrix3, Point3, Vector3};

use crate::missing::tip_effects::{Drifting, Term, catalogue, parameter};
use crate::tip::{Design, place_mm};
use crate::{FrameFitError, KnownDistance, TipFit, TipPose, fit_tip};

/// `p + R·t − c` over poses, and what tip and places leave out.
///
/// Base parameters are the changes of tip and places from the fit. Rows are x, y, z of each pose, in
/// mm, base frame; known distances follow, always fitted and never judged.
#[derive(Clone, Debug)]
pub struct TipModel {
    design: Design,
    fit: TipFit,
    start: DVector<f64>,
    declared: Declared,
    terms: Vec<Term>,
    shown: Shown,
}

impl TipModel {
    /// Model of `poses`, in the order measured; `labels` name them, `groups` are left out together.
    ///
    /// Of `covariates`, one value per pose, `time_s` drives the drifts.
    ///
    /// # Errors
    ///
    /// As [`fit_tip`], and [`FrameFitError::InvalidCovariate`].
    pub fn new(
        poses: &[TipPose],
        labels: &[String],
        groups: &[String],
        distances: &[KnownDistance],
        sigma_mm: Option<f64>,
        covariates: &[Covariate],
    ) -> Result<Self, FrameFitError> {
        for covariate in covariates {
            let finite = covariate.values.iter().all(|v| v.is_finite());
            if !finite || covariate.values.len() != poses.len() {
                let (covariate, needed) = (covariate.name.clone(), poses.len());
                return Err(FrameFitError::InvalidCovariate { covariate, needed });
            }
        }
        let fit = fit_tip(poses, distances, sigma_mm)?;
        let design = Design::of(poses, distances)?;
        let mut start = DVector::zeros(3 + 3 * fit.places.len());
        start.fixed_rows_mut::<3>(0).copy_from(&fit.tip_mm);
        for (k, (_, place_mm)) in fit.places.iter().enumerate() {
            start.fixed_rows_mut::<3>(3 + 3 * k).copy_from(place_mm);
        }
        let (effects, terms) = catalogue(&design, labels, covariates).into_iter().unzip();
        let layout = layout(&design, groups, fit.sigma_mm, sigma_mm.is_some());
        let model = Self {
            declared: Declared {
                resolution: resolution_of(poses.iter().flat_map(|p| p.position_mm.data.0[0])),
                ..Declared::new(layout, base(&fit), effects)
            },
            design,
            fit,
            start,
            terms,
            shown: Shown::default(),
        };
        let places = model.places();
        let shown = Shown::of(&model, &State::start(&model), &model.sought(&places));
        let shown = model.without_slips(shown);
        Ok(model.with_shown(shown))
    }

    /// The model with the courses of its drifts that the residual shows beside what was found; `None`
    /// where these are the ones that it has.
    #[must_use]
    pub fn about_found(&self, found: &State) -> Option<Self> {
        let shown = self.shown.beside(self, found, &self.sought(&self.places()));
        let shown = self.without_slips(shown);
        if shown == self.shown {
            return None;
        }
        let mut plain = self.clone();
        self.shown.take_off(&mut plain.declared, &mut plain.terms);
        Some(plain.with_shown(shown))
    }

    /// Place that each pose touches, base frame.
    fn places(&self) -> Vec<Option<Point3<f64>>> {
        self.design.at.iter().map(|&place| Some(self.fit.places[place].1.into())).collect()
    }

    /// What is looked for in the residual.
    fn sought<'a>(&'a self, places: &'a [Option<Point3<f64>>]) -> Sought<'a> {
        let catalogue = &self.terms[..self.terms.len() - self.shown.effects()];
        let drifts = catalogue.iter().enumerate().filter_map(|(index, term)| match term {
            Term::Drift(_, elapsed) => Some((index, &**elapsed)),
            _ => None,
        });
        Sought { places, ..Sought::of_drifts(drifts) }
    }

    /// A tip that is elsewhere all at once has slipped, which the catalogue has.
    fn without_slips(&self, mut shown: Shown) -> Shown {
        let is_tip = |of: usize| matches!(self.terms[of], Term::Drift(Drifting::Tip, _));
        shown.courses.retain(|(of, course)| !(is_tip(*of) && matches!(course, Course::Session(_))));
        shown
    }

    /// The model with what its residual shows in the catalogue.
    fn with_shown(mut self, shown: Shown) -> Self {
        for (of, course) in &shown.courses {
            let Term::Drift(what, elapsed) = self.terms[*of].clone() else { continue };
            let is_timed = self.declared.effects[*of].driver.is_some();
            let unit = if is_timed { "s" } else { "poses" };
            let effect = course.effect(&self, *of, &elapsed, unit, ("mm", 1.0));
            self.declared.effects.push(effect);
            self.terms.push(Term::Drift(what, course.come(&elapsed)));
        }
        self.shown = shown;
        self
    }

    /// Tip and places at the base parameters of a [`State`].
    #[must_use]
    pub fn at(&self, base: &DVector<f64>) -> (Vector3<f64>, Vec<(String, Vector3<f64>)>) {
        let x = &self.start + base;
        let place = |(k, name): (usize, &String)| (name.clone(), place_mm(&x, k));
        let places = self.design.names.iter().enumerate().map(place).collect();
        (x.fixed_rows::<3>(0).into_owned(), places)
    }

    /// The fit of the declared model.
    #[must_use]
    pub fn fit(&self) -> &TipFit {
        &self.fit
    }

    /// Positions of the flange as covariates, zero for distances: `x_mm`, ….
    #[must_use]
    pub fn coordinates(&self) -> Vec<Covariate> {
        let of = |axis: usize| {
            let poses = self.design.positions_mm.iter().map(|p| p[axis]);
            poses.chain(self.design.distances.iter().map(|_| 0.0)).collect()
        };
        ["x_mm", "y_mm", "z_mm"]
            .into_iter()
            .enumerate()
            .map(|(axis, name)| Covariate::coordinate(name, Quantity::Position, of(axis)))
            .collect()
    }

    /// What a term adds to the residual of a pose, one column per amplitude.
    fn columns(&self, term: &Term, pose: usize) -> Option<DMatrix<f64>> {
        let three = |m: Matrix3<f64>| DMatrix::from_column_slice(3, 3, m.as_slice());
        let one = |v: Vector3<f64>| DMatrix::from_column_slice(3, 1, v.as_slice());
        let rotation = &self.design.rotations[pose];
        Some(match term {
            Term::Drift(Drifting::Places, come) => three(come[pose] * Matrix3::identity()),
            Term::Drift(Drifting::Tip, come) => three(come[pose] * rotation),
            Term::TipSlip(from) if pose >= *from => three(*rotation),
            Term::Sag => one(self.sag(rotation)),
            Term::BadPose(bad) if pose == *bad => three(Matrix3::identity()),
            Term::TipSlip(_) | Term::BadPose(_) => return None,
        })
    }

    /// Gravity across the tool, base frame with z up; zero where the tool hangs or stands.
    fn sag(&self, rotation: &Matrix3<f64>) -> Vector3<f64> {
        let axis = rotation * self.fit.tip_mm.try_normalize(0.0).unwrap_or_else(Vector3::z);
        let down = -Vector3::z();
        down - axis * axis.dot(&down)
    }

    fn stacked(
        &self,
        columns: usize,
        of_pose: impl Fn(usize) -> Option<DMatrix<f64>>,
    ) -> DMatrix<f64> {
        let mut stacked = DMatrix::zeros(self.declared.layout.rows.len(), columns);
        for pose in 0..self.design.at.len() {
            if let Some(block) = of_pose(pose) {
                stacked.rows_mut(3 * pose, 3).copy_from(&block);
            }
        }
        stacked
    }
}

fn layout(design: &Design, groups: &[String], sigma_mm: f64, declared: bool) -> Layout {
    let mut layout =
        Layout { unit: "mm".to_owned(), sigma_declared: declared, ..Layout::default() };
    for (pose, group) in groups.iter().enumerate() {
        let known = layout.groups.iter().position(|g| g.name == *group);
        let group = known.unwrap_or_else(|| {
            layout.groups.push(Group { name: group.clone(), role: Role::Fit });
            layout.groups.len() - 1
        });
        layout.observations.push(group);
        let row = |component| Row { observation: pose, component, sigma: sigma_mm, reported: true };
        layout.rows.extend((0..3).map(row));
    }
    if !design.distances.is_empty() {
        layout.groups.push(Group { name: "distances".to_owned(), role: Role::Prior });
    }
    for between in &design.distances {
        let observation = layout.observations.len();
        layout.observations.push(layout.groups.len() - 1);
        let sigma = between.sigma_mm;
        layout.rows.push(Row { observation, component: 0, sigma, reported: false });
    }
    layout
}

fn base(fit: &TipFit) -> Vec<Parameter> {
    let names = fit.places.iter().map(|(name, _)| format!("of {name}"));
    let things = std::iter::once("of the tip".to_owned()).chain(names);
    things
        .flat_map(|thing| ["x", "y", "z"].map(|axis| parameter(&format!("{axis} {thing}"), "mm")))
        .collect()
}

impl Model for TipModel {
    fn declared(&self) -> &Declared {
        &self.declared
    }

    fn residuals(&self, at: &State) -> DVector<f64> {
        let x = &self.start + &at.base;
        let poses = self.design.misses(&x);
        let distances = self.design.distance_errors_mm(&x);
        let mut residuals = DVector::zeros(self.declared.layout.rows.len());
        residuals.rows_mut(0, poses.len()).copy_from(&poses);
        for (row, error) in distances.into_iter().enumerate() {
            residuals[poses.len() + row] = error;
        }
        // An amplitude is what the residual grows by, so the model with it takes it off.
        for (term, amplitude) in self.terms.iter().zip(&at.amplitudes) {
            if amplitude.iter().all(|a| *a == 0.0) {
                continue;
            }
            for pose in 0..self.design.at.len() {
                if let Some(columns) = self.columns(term, pose) {
                    let mut of_pose = residuals.rows_mut(3 * pose, 3);
                    of_pose -= columns * amplitude;
                }
            }
        }
        residuals
    }

    fn base_jacobian(&self, at: &State) -> DMatrix<f64> {
        let x = &self.start + &at.base;
        let mut jacobian = self.stacked(x.len(), |pose| {
            let mut block = DMatrix::zeros(3, x.len());
            block.fixed_view_mut::<3, 3>(0, 0).copy_from(&self.design.rotations[pose]);
            let place = 3 + 3 * self.design.at[pose];
            block.fixed_view_mut::<3, 3>(0, place).copy_from(&-Matrix3::identity());
            Some(block)
        });
        for (row, between) in self.design.distances.iter().enumerate() {
            let derivative = between.row(&x);
            jacobian.row_mut(3 * self.design.at.len() + row).tr_copy_from(&derivative);
        }
        jacobian
    }

    fn tangent(&self, _at: &State, effect: usize) -> DMatrix<f64> {
        let term = &self.terms[effect];
        if let Term::BadPose(_) = term {
            return -DMatrix::identity(3, 3);
        }
        let columns = self.declared.effects[effect].parameters.len();
        self.stacked(columns, |pose| self.columns(term, pose).map(|c| -c))
    }

    fn inside(&self, _: &State) -> Option<Inside> {
        None
    }

    fn proposals(&self) -> Vec<Proposal<'_>> {
        Vec::new()
    }
}
