//! The map with the accepted effects in it: what a user applies to further points.
//!
//! Effects that are affine maps of the point are part of the map. What else there is depends on
//! when a point was read, how warm it was, which body carries it, or on its place in a way that is
//! not affine: that is left to the corrections of the single points, and a sentence says under
//! which condition the map holds.

use model_discrepancy::{Column, Role, State};
use nalgebra::{DMatrix, DVector, Point, SMatrix, SVector};

use crate::missing::finite_motion::derivatives;
use crate::missing::term;
use crate::motion;
use crate::{FrameMap, FrameModel, Noise, PointPair, Transform, closed_form, shape_of};

/// A map, what it depends on, and when it holds.
#[derive(Clone, Debug)]
pub struct MapWithEffects<const D: usize> {
    /// Maps source to target, with every effect that is affine in the point.
    pub map: FrameMap<D>,
    /// Covariance of the entries of `[L | t]`, row by row: `1`, `mm` and `mm²`.
    pub covariance: DMatrix<f64>,
    /// Point of the source frame to which rotations, scales and shears refer.
    pub reference_mm: Point<f64, D>,
    /// What the map leaves out, and when it holds as it is; one sentence each.
    pub conditions: Vec<String>,
    /// The similarity nearest to map and distortion, where a distortion is among the effects.
    pub nearest_similarity: Option<NearestSimilarity>,
}

/// Scale of the similarity nearest to a distorted map over the fitted points, all weighing alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestSimilarity {
    /// Its scale, `1`.
    pub scale: f64,
    /// Standard uncertainty of it.
    pub std_scale: f64,
}

impl<const D: usize> FrameModel<D> {
    /// The map at `at`, with the `covariance` of the parameters that `columns` name.
    ///
    /// Both are those of a [`Closure`](model_discrepancy::Closure).
    #[must_use]
    pub fn with_effects(
        &self,
        at: &State,
        columns: &[Column],
        covariance: &DMatrix<f64>,
    ) -> MapWithEffects<D> {
        let entries = self.entry_jacobian(at, columns);
        let nearest_similarity = self.nearest_similarity(at, columns, covariance);
        let mut conditions = self.conditions(at);
        if nearest_similarity.is_some() {
            conditions.push(
                "the matrix has its scale without the distortion; the scale of the similarity nearest \
                 to both together is listed separately"
                    .to_owned(),
            );
        }
        MapWithEffects {
            map: self.affine_map(at),
            covariance: &entries * covariance * entries.transpose(),
            reference_mm: Point::from(self.fixed_mm),
            conditions,
            nearest_similarity,
        }
    }

    /// Every effect that is affine in the point, and the transform.
    fn affine_map(&self, at: &State) -> FrameMap<D> {
        let shift = |p: &SVector<f64, D>, place| -> SVector<f64, D> {
            let all = self.active(at, place).into_iter();
            all.filter_map(|(term, amplitude)| Some(fixed(&(term.affine(p)? * amplitude)))).sum()
        };
        let origin = SVector::zeros();
        let at_origin = shift(&origin, term::Place::Source);
        let mut deformed = FrameMap { translation_mm: at_origin, ..FrameMap::identity() };
        for axis in 0..D {
            let strain = shift(&unit(axis), term::Place::Source) - at_origin;
            let column = deformed.linear.column(axis) + strain;
            deformed.linear.set_column(axis, &column);
        }
        let (rotation, pivot_mm) = self.target_rotation(at);
        let turned = FrameMap {
            linear: SMatrix::identity() + rotation,
            translation_mm: -(rotation * pivot_mm),
        };
        let mut map = turned.after(&self.map_at(&at.base)).after(&deformed);
        map.translation_mm += shift(&origin, term::Place::Target);
        map
    }

    /// Derivative of the entries of `[L | t]`, row by row, by what `columns` name.
    ///
    /// An affine map is known by the images of the origin and of one point along every axis.
    fn entry_jacobian(&self, at: &State, columns: &[Column]) -> DMatrix<f64> {
        let origin = self.image_jacobian(at, columns, &SVector::zeros());
        let mut entries = DMatrix::zeros(D * (D + 1), columns.len());
        for axis in 0..D {
            let along = self.image_jacobian(at, columns, &unit(axis)) - &origin;
            for row in 0..D {
                entries.row_mut(row * (D + 1) + axis).copy_from(&along.row(row));
            }
        }
        for row in 0..D {
            entries.row_mut(row * (D + 1) + D).copy_from(&origin.row(row));
        }
        entries
    }

    /// Derivative of the image of a source point under the affine map, `D × columns`.
    fn image_jacobian(
        &self,
        at: &State,
        columns: &[Column],
        source_mm: &SVector<f64, D>,
    ) -> DMatrix<f64> {
        let moved = self.moved_at(&at.base);
        let (rotation, rotation_pivot_mm) = self.target_rotation(at);
        let turned = SMatrix::<f64, D, D>::identity() + rotation;
        let deformation: SVector<f64, D> = (self.active(at, term::Place::Source).into_iter())
            .filter_map(|(term, a)| Some(fixed::<D>(&(term.affine(source_mm)? * a))))
            .sum();
        let deformed = source_mm + deformation;
        let arm_mm = self.reference().apply(&Point::from(deformed)).coords - self.pivot_mm;
        let base = derivatives::<D>(self.transform, &self.motions, &at.base);
        let mapped = arm_mm + self.pivot_mm + moved.displacement(&arm_mm);
        let into_target = turned * (SMatrix::identity() + moved.strain) * self.reference().linear;
        let amplitude = |effect: usize, parameter: usize| -> SVector<f64, D> {
            let term = &self.terms[effect];
            let column = |all: DMatrix<f64>| fixed(&all.column(parameter).into_owned());
            match term.place() {
                term::Place::Rotation => column(term::rotation_columns(
                    &at.amplitudes[effect],
                    &(turned * (mapped - rotation_pivot_mm)),
                )),
                term::Place::Target => term.affine(source_mm).map_or_else(SVector::zeros, column),
                term::Place::Source => {
                    into_target * term.affine(source_mm).map_or_else(SVector::zeros, column)
                }
            }
        };
        let mut jacobian = DMatrix::zeros(D, columns.len());
        for (k, column) in columns.iter().enumerate() {
            let derivative = match *column {
                Column::Base(parameter) => turned * base[parameter].displacement(&arm_mm),
                Column::Amplitude { effect, parameter } => amplitude(effect, parameter),
                Column::Empirical { .. } | Column::Place { .. } => SVector::zeros(),
            };
            jacobian.fixed_view_mut::<D, 1>(0, k).copy_from(&derivative);
        }
        jacobian
    }

    fn conditions(&self, at: &State) -> Vec<String> {
        let active = |amplitude: &DVector<f64>| amplitude.iter().any(|a| *a != 0.0);
        let all = self.terms.iter().zip(&self.declared.effects).zip(&at.amplitudes);
        all.filter(|(_, amplitude)| active(amplitude))
            .filter_map(|((term, effect), _)| {
                let subject = effect.subject.as_deref().unwrap_or_default();
                term.condition(subject, effect.driver.as_deref())
            })
            .collect()
    }

    /// The scale that another person gets who fits a similarity to what the model predicts.
    fn nearest_similarity(
        &self,
        at: &State,
        columns: &[Column],
        covariance: &DMatrix<f64>,
    ) -> Option<NearestSimilarity> {
        let distorting: Vec<usize> =
            (0..self.terms.len()).filter(|&e| self.terms[e].distorts()).collect();
        if distorting.iter().all(|&e| at.amplitudes[e].iter().all(|a| *a == 0.0)) {
            return None;
        }
        let map = self.affine_map(at);
        let into_target = map.linear;
        let fitted = || self.points.iter().enumerate().filter(|(_, p)| p.role != Role::Check);
        let image = |i: usize, source_mm: &SVector<f64, D>| -> SVector<f64, D> {
            let field = |e: &usize| {
                fixed::<D>(&(self.terms[*e].columns(i, source_mm) * &at.amplitudes[*e]))
            };
            let distortion: SVector<f64, D> = distorting.iter().map(field).sum();
            map.apply(&Point::from(*source_mm)).coords + into_target * distortion
        };
        let pairs: Vec<PointPair<D>> = fitted()
            .map(|(i, p)| {
                let target_mm = Point::from(image(i, &p.pair.source_mm.coords));
                PointPair::isotropic(p.pair.source_mm, target_mm, 1.0)
            })
            .collect();
        let handedness = map.handedness();
        let nearest = closed_form::estimate(&pairs, Transform::Similarity, handedness).map;
        let shape = shape_of(&nearest);
        // s = Σ a·Rᵀy / Σ a², of which to first order only y changes: R is at an extremum of it.
        let centroid_mm = self.spread.centroid_mm.coords;
        let mut derivative = DVector::zeros(columns.len());
        let mut square = 0.0;
        for (i, p) in fitted() {
            let source_mm = p.pair.source_mm.coords;
            let arm_mm = source_mm - centroid_mm;
            let mut rows = self.image_jacobian(at, columns, &source_mm);
            for (k, column) in columns.iter().enumerate() {
                if let Column::Amplitude { effect, parameter } = *column
                    && distorting.contains(&effect)
                {
                    let all = self.terms[effect].columns(i, &source_mm);
                    let moved = into_target * fixed::<D>(&all.column(parameter).into_owned());
                    rows.column_mut(k).copy_from(&moved);
                }
            }
            derivative += rows.transpose() * (shape.rotation * arm_mm);
            square += arm_mm.norm_squared();
        }
        derivative /= square;
        let variance = derivative.dot(&(covariance * &derivative));
        Some(NearestSimilarity { scale: shape.mean_scale, std_scale: variance.max(0.0).sqrt() })
    }
}

fn unit<const D: usize>(axis: usize) -> SVector<f64, D> {
    SVector::from_fn(|k, _| if k == axis { 1.0 } else { 0.0 })
}

fn fixed<const D: usize>(vector: &DVector<f64>) -> SVector<f64, D> {
    SVector::from_column_slice(vector.as_slice())
}

/// The uncertainties of a fitted transform, in the same form.
impl<const D: usize> crate::FrameFit<D> {
    /// Covariance of the entries of `[L | t]`, row by row; a posteriori where the noise is
    /// estimated. `None` as for [`FrameFit::standard_uncertainties`](crate::FrameFit::standard_uncertainties).
    #[must_use]
    pub fn map_covariance(&self) -> Option<DMatrix<f64>> {
        let motions = motion::motions(self.transform, D);
        let map = &self.target_from_source;
        let image = |source_mm: SVector<f64, D>| {
            let arm_mm = map.apply(&Point::from(source_mm)) - self.pivot_mm;
            motion::jacobian(&motions, &arm_mm)
        };
        let origin = image(SVector::zeros());
        let mut entries = DMatrix::zeros(D * (D + 1), motions.len());
        for row in 0..D {
            entries.row_mut(row * (D + 1) + D).copy_from(&origin.row(row));
            for axis in 0..D {
                let along = image(unit(axis));
                let difference = along.row(row) - origin.row(row);
                entries.row_mut(row * (D + 1) + axis).copy_from(&difference);
            }
        }
        let factor = match self.noise {
            Noise::Declared => 1.0,
            Noise::Estimated => self.variance_factor?,
        };
        Some(&entries * &self.covariance * entries.transpose() * factor)
    }
}
