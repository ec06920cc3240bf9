use std::collections::HashMap;
use std::sync::Arc;

use frame_fit::{
    FrameFit, FrameFitError, FrameModel, Handedness, MapWithEffects, MeasuredPoint, Noise, Options,
    PointPair, Transform, Uncertainty, fit_frame,
};
use model_discrepancy::{Closure, Covariate, Role};
use nalgebra::{Point, SVector};
use truing_report::Fact;

use super::estimates::{FrameFitEstimates, HandedBack, PointResidual};
use super::plan::offer;
use super::settings::FramePlanSettings;
use super::suspects;
use crate::Error;
use crate::case::{Location, NumberColumn};
use crate::estimates::Estimates;
use crate::kinds::Offer;
use crate::measured::{
    About, Fitted, Measured, Observation, Places, Prepared, Words, empirical_conditions,
};
use crate::suspect::Yardstick;

/// A `frame-fit` case as read.
#[derive(Clone, Debug)]
pub(crate) struct FrameCase {
    pub(crate) file: Location,
    /// Line of each point.
    pub(crate) lines: Vec<usize>,
    /// 2 or 3.
    pub(crate) dimension: usize,
    /// Name of the place of each row; equal names are repeats of one place.
    pub(crate) names: Vec<String>,
    pub(crate) from_mm: Vec<Vec<f64>>,
    pub(crate) to_mm: Vec<Vec<f64>>,
    pub(crate) sigma: Sigma,
    pub(crate) uses: Vec<Use>,
    pub(crate) covariates: Vec<NumberColumn>,
    /// One per session: 1 in its rows.
    pub(crate) sessions: Vec<NumberColumn>,
    /// Sub-assembly of each point.
    pub(crate) bodies: Option<Vec<String>>,
    pub(crate) groups: Option<Vec<String>>,
    pub(crate) group_column: Option<String>,
    pub(crate) transform: Transform,
    pub(crate) handedness: Handedness,
    /// Where points can be measured.
    pub(crate) plan: FramePlanSettings,
    /// Where that is declared.
    pub(crate) document: Location,
}

/// What is known of the noise.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Sigma {
    /// Nothing.
    Unknown,
    /// The same for all coordinates of all points.
    Same(f64),
    /// One per point.
    PerPoint(Vec<f64>),
    /// One column per axis.
    PerAxis(Vec<Vec<f64>>),
}

/// What a point is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Use {
    Fit,
    Check,
}

impl Use {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Fit => "fit",
            Self::Check => "check",
        }
    }
}

impl Measured for FrameCase {
    fn fit(&self) -> Result<Fitted, Error> {
        if self.dimension == 2 { self.fit_in::<2>() } else { self.fit_in::<3>() }
    }

    fn prepare(&self) -> Result<Prepared<'_>, Error> {
        if self.dimension == 2 { self.prepare_in::<2>() } else { self.prepare_in::<3>() }
    }

    fn offer(&self) -> Result<Option<Offer>, Error> {
        if self.dimension == 2 { self.offer_in::<2>() } else { self.offer_in::<3>() }
    }

    fn yardstick(&self, fitted: &Fitted) -> Yardstick {
        suspects::yardstick([&self.from_mm, &self.to_mm], self.transform, fitted)
    }

    fn words(&self) -> Words {
        let transform = match self.transform {
            Transform::None => "nothing is estimated: both frames are claimed to be one",
            Transform::Translation => "a translation is estimated",
            Transform::Rigid => "a rotation and a translation are estimated",
            Transform::Similarity => "a rotation, a translation and one scale are estimated",
            Transform::Affine => "an affine map is estimated",
        };
        let sigma = match &self.sigma {
            Sigma::Unknown => "not declared; estimated from the residual".to_owned(),
            Sigma::Same(sigma_mm) => format!("{sigma_mm} mm per coordinate"),
            Sigma::PerPoint(_) => "declared per point".to_owned(),
            Sigma::PerAxis(_) => "declared per point and axis".to_owned(),
        };
        let fact = |name: &str, value: String| Fact { name: name.to_owned(), value };
        Words {
            declared: vec![format!("to = T(from) with T {}: {transform}.", self.transform)],
            residual: "to − T(from)",
            components: &["x", "y", "z"][..self.dimension],
            group_noun: self.group_column.clone().unwrap_or_else(|| "point".to_owned()),
            measured: vec![
                fact("dimension", format!("{}", self.dimension)),
                fact("standard uncertainty", sigma),
            ],
            places: Some(Places {
                x_title: "to x, mm",
                y_title: "to y, mm",
                at: self.to_mm.iter().map(|to| [to[0], to[1]]).collect(),
                names: self.names.clone(),
                facets: Vec::new(),
            }),
        }
    }
}

impl FrameCase {
    fn options(&self) -> Options {
        let noise = match self.sigma {
            Sigma::Unknown => Noise::Estimated,
            _ => Noise::Declared,
        };
        Options { handedness: self.handedness, noise, ..Options::of(self.transform) }
    }

    fn pair<const D: usize>(&self, row: usize) -> PointPair<D> {
        let point = |mm: &[f64]| Point::from(SVector::from_column_slice(mm));
        let uncertainty = match &self.sigma {
            Sigma::Unknown => Uncertainty::Isotropic { sigma_mm: 1.0 },
            Sigma::Same(sigma_mm) => Uncertainty::Isotropic { sigma_mm: *sigma_mm },
            Sigma::PerPoint(all) => Uncertainty::Isotropic { sigma_mm: all[row] },
            Sigma::PerAxis(axes) => {
                Uncertainty::PerAxis { sigma_mm: SVector::from_fn(|axis, _| axes[axis][row]) }
            }
        };
        PointPair {
            target_mm: point(&self.to_mm[row]),
            source_mm: point(&self.from_mm[row]),
            uncertainty,
        }
    }

    fn rows_to_fit(&self) -> Vec<usize> {
        (0..self.names.len()).filter(|row| self.uses[*row] == Use::Fit).collect()
    }

    fn fit_frame<const D: usize>(&self) -> Result<FrameFit<D>, Error> {
        let rows = self.rows_to_fit();
        let pairs: Vec<PointPair<D>> = rows.iter().map(|row| self.pair(*row)).collect();
        fit_frame(&pairs, &self.options()).map_err(|e| self.error(e, &rows))
    }

    fn offer_in<const D: usize>(&self) -> Result<Option<Offer>, Error> {
        let map = self.fit_frame::<D>()?.target_from_source;
        offer((&self.plan, &self.document), &self.from_mm, |from| map.apply(from)).map(Some)
    }

    /// `rows` are those that the solver was given.
    fn error(&self, source: FrameFitError, rows: &[usize]) -> Error {
        let mut at = self.file.clone();
        if let FrameFitError::InvalidPair { index, .. } = source
            && let Some(row) = rows.get(index)
        {
            at = at.line(self.lines[*row]);
        }
        Error::FrameFit { at: Box::new(at), source }
    }

    fn fit_in<const D: usize>(&self) -> Result<Fitted, Error> {
        let fit = self.fit_frame::<D>()?;
        let residuals: Vec<SVector<f64, D>> =
            (0..self.names.len()).map(|row| fit.residual_mm(&self.pair(row))).collect();
        let observations = (residuals.iter().zip(&self.uses))
            .map(|(r, usage)| Observation {
                residual: r.iter().copied().collect(),
                fitted: *usage == Use::Fit,
            })
            .collect();
        let points = self.points(|row, axis| residuals[row][axis], |_, _| 0.0);
        let declared = fit.noise == Noise::Declared;
        let handed_back = HandedBack {
            map: fit.target_from_source,
            covariance: fit.map_covariance(),
            reference_mm: self.centroid_mm::<D>().iter().copied().collect(),
            conditions: Vec::new(),
            nearest_similarity: None,
        };
        Ok(Fitted {
            estimates: Arc::new(FrameFitEstimates::of(handed_back, points)),
            observations,
            unit: "mm",
            degrees_of_freedom: fit.degrees_of_freedom,
            chi2_per_dof: fit.variance_factor.filter(|_| declared),
            warnings: self.reflection_warning(&fit).into_iter().collect(),
        })
    }

    fn reflection_warning<const D: usize>(&self, fit: &FrameFit<D>) -> Option<String> {
        let reflection = fit.reflection.as_ref()?;
        let has_rotation = matches!(self.transform, Transform::Rigid | Transform::Similarity);
        let other = self.handedness.opposite();
        let [rms_mm, other_rms_mm] = [self.handedness, other].map(|h| reflection.rms_mm(h));
        let mirrored = reflection.speaks_against(self.handedness);
        (mirrored && has_rotation).then(|| {
            format!(
                "the points fit a mirrored frame better: rms {other_rms_mm:.4} mm against \
                 {rms_mm:.4} mm; check the signs of the axes, or set `[model] handedness = \
                 \"{other}\"`"
            )
        })
    }

    /// Centroid of the fitted points in the first frame.
    fn centroid_mm<const D: usize>(&self) -> SVector<f64, D> {
        let rows = self.rows_to_fit();
        let sum = rows.iter().fold(SVector::zeros(), |sum, row| {
            sum + SVector::<f64, D>::from_column_slice(&self.from_mm[*row])
        });
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let count = rows.len().max(1) as f64;
        sum / count
    }

    fn points(
        &self,
        residual: impl Fn(usize, usize) -> f64,
        correction: impl Fn(usize, usize) -> f64,
    ) -> Vec<PointResidual> {
        let point = |row: usize| PointResidual {
            point: self.names[row].clone(),
            usage: self.uses[row].name(),
            dx_mm: residual(row, 0),
            dy_mm: residual(row, 1),
            dz_mm: (self.dimension == 3).then(|| residual(row, 2)),
            correction_x_mm: correction(row, 0),
            correction_y_mm: correction(row, 1),
            correction_z_mm: (self.dimension == 3).then(|| correction(row, 2)),
        };
        (0..self.names.len()).map(point).collect()
    }

    fn prepare_in<const D: usize>(&self) -> Result<Prepared<'_>, Error> {
        let labels = numbered(&self.names);
        let point = |row: usize| MeasuredPoint {
            name: labels[row].clone(),
            group: self.groups.as_ref().map_or_else(|| self.names[row].clone(), |g| g[row].clone()),
            role: match self.uses[row] {
                Use::Fit => Role::Fit,
                Use::Check => Role::Check,
            },
            body: self.bodies.as_ref().map(|bodies| bodies[row].clone()),
            pair: self.pair::<D>(row),
        };
        let points = (0..self.names.len()).map(point).collect();
        let covariate = |c: &NumberColumn| c.covariate();
        let recorded: Vec<Covariate> = self.covariates.iter().map(covariate).collect();
        let sessions = self.sessions.iter().map(covariate);
        let all: Vec<Covariate> = recorded.iter().cloned().chain(sessions).collect();
        let model = FrameModel::new(points, &all, &self.options())
            .map_err(|e| self.error(e, &self.rows_to_fit()))?;
        let mut covariates = model.coordinates();
        covariates.extend(recorded);
        Ok(self.prepared(model, covariates))
    }

    fn prepared<const D: usize>(
        &self,
        model: FrameModel<D>,
        covariates: Vec<Covariate>,
    ) -> Prepared<'_> {
        let model = Arc::new(model);
        let (of, at) = (Arc::clone(&model), Arc::clone(&model));
        let estimates = Box::new(move |closure: &Closure| {
            let of = of.with_effects(&closure.state, &closure.columns, &closure.covariance);
            self.with_effects(of, closure)
        });
        let along = covariates.clone();
        let about: About<'_> = Box::new(move |found| {
            let there = at.about_found(&found.state);
            Ok(there.map(|there| self.prepared(there, along.clone())))
        });
        Prepared { model, covariates, estimates, about: Some(about) }
    }

    /// The map with the accepted effects, and for every point what it leaves to a correction.
    fn with_effects<const D: usize>(
        &self,
        of: MapWithEffects<D>,
        closure: &Closure,
    ) -> Arc<dyn Estimates> {
        let mut residuals = vec![SVector::<f64, D>::zeros(); self.names.len()];
        for (row, residual) in residuals.iter_mut().enumerate() {
            residual.copy_from_slice(&closure.residuals_after[D * row..D * (row + 1)]);
        }
        let corrected = !of.conditions.is_empty() || !closure.empirical.is_empty();
        let correction = |row: usize, axis: usize| {
            if !corrected {
                return 0.0;
            }
            let pair = self.pair::<D>(row);
            let image_mm = of.map.apply(&pair.source_mm);
            pair.target_mm[axis] - residuals[row][axis] - image_mm[axis]
        };
        let points = self.points(|row, axis| residuals[row][axis], correction);
        let mut conditions = of.conditions;
        conditions.extend(empirical_conditions(closure));
        let handed_back = HandedBack {
            map: of.map,
            covariance: Some(of.covariance),
            reference_mm: of.reference_mm.iter().copied().collect(),
            conditions,
            nearest_similarity: of.nearest_similarity,
        };
        Arc::new(FrameFitEstimates::of(handed_back, points))
    }
}

/// Names of single rows: those of a place that recurs are numbered, `P1 #2` for its second.
fn numbered(names: &[String]) -> Vec<String> {
    let mut seen: HashMap<&str, usize> = HashMap::new();
    let mut labels = Vec::with_capacity(names.len());
    for name in names {
        let count = seen.entry(name).or_default();
        *count += 1;
        labels.push(if *count == 1 { name.clone() } else { format!("{name} #{count}") });
    }
    labels
}
