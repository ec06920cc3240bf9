//! The declared model, as the loop sees it.

mod discrepancy;

use model_discrepancy::{
    Covariate, Declared, Group, Layout, Parameter, Quantity, Role, Row, Shown, Sought, State,
    resolution_of,
};
use nalgebra::{DMatrix, DVector, Point, Point3, SMatrix, SVector};

use crate::missing::effects::{self, Entry};
use crate::missing::finite_motion::reported;
use crate::missing::term::{self, Place, Term};
use crate::motion::{self, Motion, Moved};
use crate::spread::Spread;
use crate::{FrameFitError, FrameMap, MeasuredPoint, Noise, Options, Transform, fit_frame, input};

/// `target − T(source)` over named points, and the effects that `T` leaves out.
///
/// Base parameters are those of the transform, as a motion about the centroid after the fit of
/// the declared model: `T = motion(ξ) · T̂`. Rows are x, y, z of each point, in mm.
#[derive(Clone, Debug)]
pub struct FrameModel<const D: usize> {
    pub(crate) transform: Transform,
    pub(crate) options: Options,
    /// Whether the points fit a frame of the other handedness decisively better.
    pub(crate) mirrored: bool,
    pub(crate) points: Vec<MeasuredPoint<D>>,
    pub(crate) covariates: Vec<Covariate>,
    pub(crate) spread: Spread<D>,
    reference: FrameMap<D>,
    /// Images of the source points under `reference`.
    images_mm: Vec<SVector<f64, D>>,
    pub(crate) motions: Vec<Motion>,
    pub(crate) pivot_mm: SVector<f64, D>,
    /// Point of the source frame that rotations, scales and shears leave where it is.
    pub(crate) fixed_mm: SVector<f64, D>,
    /// The last effects of the catalogue.
    pub(crate) shown: Shown,
    pub(crate) declared: Declared,
    pub(crate) terms: Vec<Term<D>>,
}

impl<const D: usize> FrameModel<D> {
    /// Model of `points`, in the order measured.
    ///
    /// `covariates` are the columns recorded beside the points, one value per point: `time_s`
    /// drives the drift, every column ending in `_c` a thermal expansion. The loss of `options`
    /// serves only to find the start; of a full covariance the loop uses the variances.
    ///
    /// # Errors
    ///
    /// As [`fit_frame`] on the points to be fitted, and [`FrameFitError::InvalidCovariate`].
    pub fn new(
        points: Vec<MeasuredPoint<D>>,
        covariates: &[Covariate],
        options: &Options,
    ) -> Result<Self, FrameFitError> {
        let all: Vec<_> = points.iter().map(|p| p.pair).collect();
        input::check_pairs(&all)?;
        for covariate in covariates {
            let finite = covariate.values.iter().all(|v| v.is_finite());
            if !finite || covariate.values.len() != points.len() {
                return Err(FrameFitError::InvalidCovariate {
                    covariate: covariate.name.clone(),
                    needed: points.len(),
                });
            }
        }
        let fitted: Vec<_> =
            points.iter().filter(|p| p.role != Role::Check).map(|p| p.pair).collect();
        let fit = fit_frame(&fitted, options)?;
        let mirrored = matches!(options.transform, Transform::Rigid | Transform::Similarity)
            && fit.reflection.is_some_and(|r| r.speaks_against(options.handedness));
        let reference = fit.target_from_source;
        let model = Self::about(reference, points, covariates.to_vec(), *options, mirrored);
        let places = model.places();
        let shown = Shown::of(&model, &State::start(&model), &model.sought(&places));
        Ok(model.with_shown(shown))
    }

    /// The model in a chart about `reference`; everything else is taken as checked.
    pub(crate) fn about(
        reference: FrameMap<D>,
        points: Vec<MeasuredPoint<D>>,
        covariates: Vec<Covariate>,
        options: Options,
        mirrored: bool,
    ) -> Self {
        let transform = options.transform;
        let fitted: Vec<Point<f64, D>> =
            points.iter().filter(|p| p.role != Role::Check).map(|p| p.pair.source_mm).collect();
        let spread = Spread::of(fitted.iter().copied());
        let entries = effects::catalogue(transform, &points, &spread, &covariates, mirrored);
        let motions = motion::motions(transform, D);
        let (effects, terms) =
            entries.into_iter().map(|Entry { effect, term }| (effect, term)).unzip();
        let base = motions.iter().map(|m| base_parameter(*m)).collect();
        let measured = points.iter().flat_map(|p| p.pair.target_mm.iter().copied());
        let declared = Declared {
            resolution: resolution_of(measured),
            ..Declared::new(layout(&points, options.noise), base, effects)
        };
        Self {
            pivot_mm: reference.apply(&spread.centroid_mm).coords,
            fixed_mm: effects::fixed_point(transform, &spread),
            images_mm: points.iter().map(|p| reference.apply(&p.pair.source_mm).coords).collect(),
            transform,
            options,
            mirrored,
            points,
            covariates,
            spread,
            reference,
            motions,
            shown: Shown::default(),
            declared,
            terms,
        }
    }

    /// Place of each point in the source frame; in the plane the third coordinate is nought.
    fn places(&self) -> Vec<Option<Point3<f64>>> {
        let place = |p: &MeasuredPoint<D>| {
            let axis = |k: usize| p.pair.source_mm.coords.get(k).copied().unwrap_or(0.0);
            Some(Point3::new(axis(0), axis(1), axis(2)))
        };
        self.points.iter().map(place).collect()
    }

    /// What is looked for in the residual.
    fn sought<'a>(&'a self, places: &'a [Option<Point3<f64>>]) -> Sought<'a> {
        Sought { places, ..Sought::of_drifts(self.drift().into_iter()) }
    }

    /// The drift of the catalogue, and the time that had passed at each point.
    fn drift(&self) -> Option<(usize, &[f64])> {
        let all = self.declared.effects.iter().zip(&self.terms).enumerate();
        let mut drifts = all.filter(|(_, (effect, _))| effect.id == "drift");
        drifts.find_map(|(index, (_, term))| match term {
            Term::Drift { elapsed } => Some((index, &**elapsed)),
            _ => None,
        })
    }

    /// The model with what its residual shows in the catalogue.
    pub(crate) fn with_shown(mut self, shown: Shown) -> Self {
        for (drift, course) in &shown.courses {
            let Term::Drift { elapsed } = &self.terms[*drift] else { continue };
            let is_timed = self.declared.effects[*drift].driver.is_some();
            let unit = if is_timed { "s" } else { "points" };
            let effect = course.effect(&self, *drift, elapsed, unit, ("mm", 1.0));
            let elapsed = course.come(elapsed);
            self.declared.effects.push(effect);
            self.terms.push(Term::Drift { elapsed });
        }
        self.shown = shown;
        self
    }

    /// The model with the courses of its drift that the residual shows beside what was found; `None`
    /// where these are the ones that it has.
    #[must_use]
    pub fn about_found(&self, found: &State) -> Option<Self> {
        let shown = self.shown.beside(self, found, &self.sought(&self.places()));
        if shown == self.shown {
            return None;
        }
        let mut plain = self.clone();
        self.shown.take_off(&mut plain.declared, &mut plain.terms);
        Some(plain.with_shown(shown))
    }

    /// The positions at which the points were measured, as covariates: `from_x_mm`, ….
    #[must_use]
    pub fn coordinates(&self) -> Vec<Covariate> {
        let names = ["from_x_mm", "from_y_mm", "from_z_mm"];
        (0..D)
            .map(|axis| {
                Covariate::coordinate(
                    names[axis],
                    Quantity::Position,
                    self.points.iter().map(|p| p.pair.source_mm[axis]).collect(),
                )
            })
            .collect()
    }

    /// The transform at the base parameters of a [`State`].
    #[must_use]
    pub fn map_at(&self, base: &DVector<f64>) -> FrameMap<D> {
        self.moved_at(base).map(&self.pivot_mm).after(&self.reference)
    }

    /// The fit of the declared model that base parameters start from.
    pub(crate) fn reference(&self) -> &FrameMap<D> {
        &self.reference
    }

    /// Effects that act at `place` and are switched on.
    pub(crate) fn active<'a>(
        &'a self,
        at: &'a State,
        place: Place,
    ) -> Vec<(&'a Term<D>, &'a DVector<f64>)> {
        let here = self.terms.iter().zip(&at.amplitudes).filter(|(term, _)| term.place() == place);
        here.filter(|(_, amplitude)| amplitude.iter().any(|a| *a != 0.0)).collect()
    }

    pub(crate) fn moved_at(&self, base: &DVector<f64>) -> Moved<D> {
        motion::finite(self.transform, &self.motions, base)
    }

    /// By how much the effects of `at` move the images of the source points under `reference`.
    fn deformations(&self, at: &State) -> Vec<SVector<f64, D>> {
        let active = self.active(at, Place::Source);
        let sources = self.points.iter().map(|p| p.pair.source_mm.coords);
        sources
            .enumerate()
            .map(|(i, source)| self.reference.linear * displacement(&active, i, &source))
            .collect()
    }

    /// Rotation of the target frame by the effect of that name, less identity, and its pivot.
    pub(crate) fn target_rotation(&self, at: &State) -> (SMatrix<f64, D, D>, SVector<f64, D>) {
        let rotation = self.terms.iter().zip(&at.amplitudes).find_map(|(term, amplitude)| {
            let Term::Rotation { pivot_mm } = term else { return None };
            let pivot_mm = self.reference.apply(&Point::from(*pivot_mm)).coords;
            Some((term::rotation_strain(amplitude), pivot_mm))
        });
        rotation.unwrap_or_else(|| (SMatrix::zeros(), SVector::zeros()))
    }

    /// Rows of every point; zero where `of_point` has none.
    fn stacked(
        &self,
        columns: usize,
        of_point: impl Fn(usize) -> Option<DMatrix<f64>>,
    ) -> DMatrix<f64> {
        let mut stacked = DMatrix::zeros(D * self.points.len(), columns);
        for i in 0..self.points.len() {
            if let Some(rows) = of_point(i) {
                stacked.rows_mut(D * i, D).copy_from(&rows);
            }
        }
        stacked
    }
}

/// What the `active` effects together add to a point.
fn displacement<const D: usize>(
    active: &[(&Term<D>, &DVector<f64>)],
    observation: usize,
    point_mm: &SVector<f64, D>,
) -> SVector<f64, D> {
    let touching = active.iter().filter(|(term, _)| term.touches(observation));
    touching.fold(SVector::zeros(), |sum, (term, amplitude)| {
        let moved = term.columns(observation, point_mm) * *amplitude;
        sum + SVector::<f64, D>::from_column_slice(moved.as_slice())
    })
}

fn base_parameter(motion: Motion) -> Parameter {
    let (unit, report_factor) = reported(motion);
    Parameter { name: motion.name().to_owned(), unit: unit.to_owned(), report_factor }
}

fn layout<const D: usize>(points: &[MeasuredPoint<D>], noise: Noise) -> Layout {
    let mut groups: Vec<Group> = Vec::new();
    let mut observations = Vec::with_capacity(points.len());
    let mut index = std::collections::HashMap::new();
    let mut rows = Vec::with_capacity(D * points.len());
    for (observation, point) in points.iter().enumerate() {
        let check = point.role == Role::Check;
        let group = *index.entry((point.group.as_str(), check)).or_insert_with(|| {
            groups.push(Group { name: point.group.clone(), role: point.role });
            groups.len() - 1
        });
        observations.push(group);
        let sigma = point.pair.uncertainty.sigma_mm();
        rows.extend((0..D).map(|component| Row {
            observation,
            component,
            sigma: sigma[component],
            reported: true,
        }));
    }
    let sigma_declared = noise == Noise::Declared;
    Layout { rows, observations, groups, unit: "mm".to_owned(), sigma_declared }
}
