//! The declared model, as the loop sees it.

use model_discrepancy::{
    Covariate, Effect, Group, Layout, Model, Origin, Parameter, Proposal, Role, Row, State,
};
use nalgebra::{DMatrix, DVector, Point, SMatrix, SVector};

use crate::effects::{self, Entry};
use crate::motion::{self, Motion};
use crate::pair::dynamic;
use crate::spread::Spread;
use crate::term::{self, Place, Term};
use crate::{
    FrameFitError, FrameMap, MeasuredPoint, Noise, Options, Transform, fit_frame, input, proposals,
};

/// `target − T(source)` over named points, and the effects that `T` leaves out.
///
/// Base parameters are those of the transform, as a motion about the centroid after the fit of
/// the declared model: `T = motion(ξ) · T̂`. Rows are x, y, z of each point, in mm.
#[derive(Clone, Debug)]
pub struct FrameModel<const D: usize> {
    pub(crate) transform: Transform,
    pub(crate) options: Options,
    pub(crate) points: Vec<MeasuredPoint<D>>,
    pub(crate) covariates: Vec<Covariate>,
    pub(crate) spread: Spread<D>,
    reference: FrameMap<D>,
    motions: Vec<Motion>,
    pivot_mm: SVector<f64, D>,
    layout: Layout,
    base: Vec<Parameter>,
    effects: Vec<Effect>,
    terms: Vec<Term<D>>,
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
        let reference = fit_frame(&fitted, options)?.target_from_source;
        Ok(Self::about(reference, points, covariates.to_vec(), *options))
    }

    /// The model in a chart about `reference`; everything else is taken as checked.
    pub(crate) fn about(
        reference: FrameMap<D>,
        points: Vec<MeasuredPoint<D>>,
        covariates: Vec<Covariate>,
        options: Options,
    ) -> Self {
        let transform = options.transform;
        let fitted: Vec<Point<f64, D>> =
            points.iter().filter(|p| p.role != Role::Check).map(|p| p.pair.source_mm).collect();
        let spread = Spread::of(fitted.iter().copied());
        let entries = effects::catalogue(transform, &points, &spread, &covariates);
        let motions = motion::motions(transform, D);
        let (effects, terms) =
            entries.into_iter().map(|Entry { effect, term }| (effect, term)).unzip();
        Self {
            pivot_mm: reference.apply(&spread.centroid_mm).coords,
            base: motions.iter().map(|m| base_parameter(*m)).collect(),
            layout: layout(&points, options.noise),
            transform,
            options,
            points,
            covariates,
            spread,
            reference,
            motions,
            effects,
            terms,
        }
    }

    /// The positions at which the points were measured, as covariates: `from_x_mm`, ….
    #[must_use]
    pub fn coordinates(&self) -> Vec<Covariate> {
        let names = ["from_x_mm", "from_y_mm", "from_z_mm"];
        (0..D)
            .map(|axis| Covariate {
                name: names[axis].to_owned(),
                values: self.points.iter().map(|p| p.pair.source_mm[axis]).collect(),
                origin: Origin::Coordinate,
            })
            .collect()
    }

    /// The transform at the base parameters of a [`State`].
    #[must_use]
    pub fn map_at(&self, base: &DVector<f64>) -> FrameMap<D> {
        motion::finite(self.transform, &self.motions, &self.pivot_mm, base).after(&self.reference)
    }

    /// The fit of the declared model that base parameters start from.
    pub(crate) fn reference(&self) -> &FrameMap<D> {
        &self.reference
    }

    /// Effects that act at `place` and are switched on.
    fn active<'a>(&'a self, at: &'a State, place: Place) -> Vec<(&'a Term<D>, &'a DVector<f64>)> {
        let here = self.terms.iter().zip(&at.amplitudes).filter(|(term, _)| term.place() == place);
        here.filter(|(_, amplitude)| amplitude.iter().any(|a| *a != 0.0)).collect()
    }

    /// The source points as the effects of `at` deform them.
    fn deformed(&self, at: &State) -> Vec<Point<f64, D>> {
        let active = self.active(at, Place::Source);
        let deform = |(i, point): (usize, &MeasuredPoint<D>)| {
            let source_mm = point.pair.source_mm;
            source_mm + displacement(&active, i, &source_mm.coords)
        };
        self.points.iter().enumerate().map(deform).collect()
    }

    /// Rotation of the target frame by the effect of that name, and its pivot there.
    fn target_rotation(&self, at: &State) -> (SMatrix<f64, D, D>, SVector<f64, D>) {
        let rotation = self.terms.iter().zip(&at.amplitudes).find_map(|(term, amplitude)| {
            let Term::Rotation { pivot_mm } = term else { return None };
            let pivot_mm = self.reference.apply(&Point::from(*pivot_mm)).coords;
            Some((term::rotation_matrix(amplitude), pivot_mm))
        });
        rotation.unwrap_or_else(|| (SMatrix::identity(), SVector::zeros()))
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
    let (unit, report_factor) = motion.reported();
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

impl<const D: usize> Model for FrameModel<D> {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn base(&self) -> &[Parameter] {
        &self.base
    }

    fn effects(&self) -> &[Effect] {
        &self.effects
    }

    fn start(&self) -> DVector<f64> {
        DVector::zeros(self.motions.len())
    }

    fn residuals(&self, at: &State) -> DVector<f64> {
        let map = self.map_at(&at.base);
        let (rotation, pivot_mm) = self.target_rotation(at);
        let after = self.active(at, Place::Target);
        let mut residuals = DVector::zeros(D * self.points.len());
        for (i, (point, deformed)) in self.points.iter().zip(self.deformed(at)).enumerate() {
            let mapped = map.apply(&deformed).coords;
            let rotated = pivot_mm + rotation * (mapped - pivot_mm);
            let predicted = rotated + displacement(&after, i, &rotated);
            let residual = point.pair.target_mm.coords - predicted;
            residuals.fixed_rows_mut::<D>(D * i).copy_from(&residual);
        }
        residuals
    }

    fn base_jacobian(&self, at: &State) -> DMatrix<f64> {
        let (rotation, _) = self.target_rotation(at);
        let turned = dynamic(&-rotation);
        let deformed = self.deformed(at);
        self.stacked(self.motions.len(), |i| {
            let arm_mm = self.reference.apply(&deformed[i]).coords - self.pivot_mm;
            let moved = motion::finite_jacobian(self.transform, &self.motions, &at.base, &arm_mm);
            Some(&turned * moved)
        })
    }

    fn tangent(&self, at: &State, effect: usize) -> DMatrix<f64> {
        let term = &self.terms[effect];
        let amplitude = &at.amplitudes[effect];
        let map = self.map_at(&at.base);
        let (rotation, pivot_mm) = self.target_rotation(at);
        if term.place() == Place::Rotation {
            let deformed = self.deformed(at);
            return self.stacked(amplitude.len(), |i| {
                let rotated = rotation * (map.apply(&deformed[i]).coords - pivot_mm);
                Some(-term::rotation_columns(amplitude, &rotated))
            });
        }
        let carried = match term.place() {
            Place::Source => dynamic(&-(rotation * map.linear)),
            _ => -DMatrix::identity(D, D),
        };
        self.stacked(amplitude.len(), |i| {
            let source_mm = self.points[i].pair.source_mm.coords;
            term.touches(i).then(|| &carried * term.columns(i, &source_mm))
        })
    }

    fn proposals(&self) -> Vec<Proposal> {
        proposals::proposals(self)
    }
}
