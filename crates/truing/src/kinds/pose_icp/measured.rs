use std::sync::Arc;
use std::time::Instant;

use model_discrepancy::{
    Closure, Column, Covariate, EmpiricalCorrection, Model, Role, State, coverage_factor,
};
use nalgebra::{Point3, Vector3};
use pose_icp::{
    Fitted as FittedPose, MeasuredTouch, PoseError, PoseFit, PoseModel, PoseOptions, PoseParameter,
    Tip, Touch, fit_pose, height_at,
};
use truing_report::Fact;

use super::case::PoseCase;
use super::estimates::{HeightCheck, PoseEstimate, PoseIcpEstimates, TouchResidual, rows, stds};
use super::picture::{Picture, picture};
use crate::Error;
use crate::case::NumberColumn;
use crate::depth::Polished;
use crate::estimates::Estimates;
use crate::itlicp::SampledCase;
use crate::kinds::Offer;
use crate::kinds::surface::yardstick_of;
use crate::measured::{About, Fitted, Measured, Observation, Places, Prepared, Words};
use crate::suspect::Yardstick;

/// The pose with the options under which it was found.
struct Located {
    fit: PoseFit,
    options: PoseOptions,
    warnings: Vec<String>,
}

impl PoseCase {
    /// The fit with what `estimate` says of the pose.
    fn fitted(
        &self,
        estimate: impl Fn(&PoseFit, &PoseOptions) -> PoseEstimate,
    ) -> Result<Fitted, Error> {
        let Located { fit, options, mut warnings } = self.locate()?;
        let mut residuals_mm = Vec::with_capacity(self.points.names.len());
        let mut checks = Vec::new();
        let mut fitted = fit.residuals_mm.iter();
        for row in 0..self.points.names.len() {
            if self.points.is_check[row] {
                let (residual_mm, check) = self.judged(&fit, row)?;
                residuals_mm.push(residual_mm);
                checks.push(check);
            } else {
                residuals_mm.extend(fitted.next().copied());
            }
        }
        warnings.extend(fit.weak_directions.iter().map(|weak| format!("hardly visible: {weak}")));
        let observations = (residuals_mm.iter().zip(&self.points.is_check))
            .map(|(r, check)| Observation { residual: vec![*r], fitted: !check })
            .collect();
        let declared = self.sigma_mm.is_some();
        Ok(Fitted {
            estimates: Arc::new(PoseIcpEstimates {
                pose: estimate(&fit, &options),
                matrix: rows(&fit.pose.machine_from_workpiece().to_homogeneous()),
                reference_mm: None,
                checks,
                points: self.residuals(|row| residuals_mm[row], |_| None),
                singular_values: fit.singular_values.clone(),
                weak_directions: fit.weak_directions.iter().map(ToString::to_string).collect(),
            }),
            observations,
            unit: "mm",
            degrees_of_freedom: fit.degrees_of_freedom,
            chi2_per_dof: fit.variance_factor.filter(|_| declared),
            warnings,
        })
    }
}

impl Measured for PoseCase {
    fn fit(&self) -> Result<Fitted, Error> {
        self.fitted(|fit, options| self.estimate(fit, options))
    }

    /// Without the intervals of a pose that is hardly seen.
    fn fit_alone(&self) -> Result<Fitted, Error> {
        self.fitted(|fit, _| PoseEstimate::of(&fit.pose, fit.standard_uncertainties()))
    }

    fn prepare(&self) -> Result<Prepared<'_>, Error> {
        let Located { fit, options, .. } = self.locate()?;
        let recorded: Vec<Covariate> =
            (self.points.covariates.iter()).map(NumberColumn::covariate).collect();
        let part = self.surface.part.clone();
        let model = PoseModel::new(part, self.measured_touches(), &recorded, &fit.pose, &options)
            .map_err(|e| self.error(e, None))?;
        Ok(self.prepared(model, Arc::new(fit)))
    }

    fn offer(&self) -> Result<Option<Offer>, Error> {
        let Located { fit, options, .. } = self.locate()?;
        super::plan::offer(self, &fit.machine_from_workpiece, options.tip).map(Some)
    }

    fn sampled(&self) -> Result<Option<SampledCase>, Error> {
        let started = Instant::now();
        let Located { fit, options, .. } = self.locate()?;
        let exact_s = started.elapsed().as_secs_f64();
        let points = &self.points;
        let of =
            |row: usize| (points.names[row].clone(), points.centers_mm[row], points.is_check[row]);
        Ok(Some(SampledCase {
            part: self.surface.part.clone(),
            tip: options.tip,
            touches: self.touches(),
            start: self.start,
            exact: fit,
            exact_s,
            points: (0..points.names.len()).map(of).collect(),
        }))
    }

    fn polished(&self) -> Result<Option<Polished>, Error> {
        let Located { fit, options, .. } = self.locate()?;
        let with_larger_tip = match self.tool.filter(|tool| tool.std_tip_mm > 0.0) {
            None => None,
            Some(tool) => {
                let tip = Tip { radius_mm: options.tip.radius_mm + tool.std_tip_mm, ..options.tip };
                let options = PoseOptions { tip, ..options.clone() };
                let (part, touches) = (&self.surface.part, self.touches());
                let fit = fit_pose(part, &touches, &self.start, &options);
                Some(fit.map_err(|e| self.error(e, Some(&self.points.fitted())))?)
            }
        };
        let (part, side) = (self.surface.part.clone(), options.tip.side);
        Ok(Some(Polished { part, side, fit, with_larger_tip, tool: self.tool }))
    }

    fn yardstick(&self, _: &Fitted) -> Yardstick {
        yardstick_of(self.points.centers_mm.iter().map(|p| p.coords.as_slice()))
    }

    fn words(&self) -> Words {
        let fact = |name: &str, value: String| Fact { name: name.to_owned(), value };
        let held: Vec<&str> = self.options.held.iter().map(|p| p.name()).collect();
        let sigma = match self.sigma_mm {
            Some(mm) => format!("{mm} mm"),
            None => "not declared; estimated from the residual".to_owned(),
        };
        let sides = match self.options.lateral {
            Some(_) => "four, as prior knowledge of where the axis is",
            None => "none, or not used",
        };
        Words {
            declared: vec![
                format!("p_machine = Rz(γ) Ry(β) Rx(α) p + d; held: {}.", held.join(", ")),
                format!("The part is the nominal one: {}.", self.surface.words),
            ],
            residual: "distance from the surface − tip radius",
            components: &[],
            group_noun: self.points.group_column.clone().unwrap_or_else(|| "point".to_owned()),
            measured: vec![
                fact("surface", self.surface.words.clone()),
                fact("tip radius", format!("{} mm", self.options.tip.radius_mm)),
                fact("standard uncertainty of a point", sigma),
                fact("side touches", sides.to_owned()),
            ],
            places: self.places(),
        }
    }
}

impl PoseCase {
    fn prepared(&self, model: PoseModel, fit: Arc<PoseFit>) -> Prepared<'_> {
        let covariates = model.all_covariates();
        let model = Arc::new(model);
        let (of, at) = (Arc::clone(&model), Arc::clone(&model));
        let declared = Arc::clone(&fit);
        let estimates = Box::new(move |closure: &Closure| self.closed(&of, closure, &declared));
        let about: About<'_> = Box::new(move |found| {
            let there = at.about_found(&found.state);
            Ok(there.map(|there| self.prepared(there, Arc::clone(&fit))))
        });
        Prepared { model, covariates, estimates, about: Some(about) }
    }

    fn touches(&self) -> Vec<Touch> {
        self.points.touches(self.sigma_mm.unwrap_or(1.0))
    }

    /// The touches on the part where it was found to lie; nothing where it was not found.
    fn places(&self) -> Option<Places> {
        let Located { fit, options, .. } = self.locate().ok()?;
        let (part, centers_mm) = (&self.surface.part, &self.points.centers_mm);
        let Picture { at, facets } =
            picture(part, options.tip.side, &fit.machine_from_workpiece, centers_mm);
        Some(Places {
            x_title: "x, and y into the picture, mm",
            y_title: "z enlarged, and y into the picture, mm",
            at,
            names: self.points.names.clone(),
            facets,
        })
    }

    /// Fits the pose; γ of a freeform part is estimated where it shows.
    fn locate(&self) -> Result<Located, Error> {
        let touches = self.touches();
        let fit =
            |options: &PoseOptions| fit_pose(&self.surface.part, &touches, &self.start, options);
        let mut warnings = Vec::new();
        if self.ask_gamma {
            let mut options = self.options.clone();
            options.held.retain(|p| *p != PoseParameter::Gamma);
            match fit(&options) {
                Ok(fit) => {
                    warnings.extend(self.beside(&fit));
                    return Ok(Located { fit, options, warnings });
                }
                Err(PoseError::Undetermined { .. } | PoseError::TooFewTouches { .. }) => warnings
                    .push("the points do not show the rotation γ: it is held at 0".to_owned()),
                Err(source) => return Err(self.error(source, Some(&self.points.fitted()))),
            }
        }
        let fit = fit(&self.options).map_err(|e| self.error(e, Some(&self.points.fitted())))?;
        warnings.extend(self.beside(&fit));
        Ok(Located { fit, options: self.options.clone(), warnings })
    }

    /// Says which touches the estimate puts beside the part, where its place is too uncertain to
    /// refuse them.
    fn beside(&self, fit: &PoseFit) -> Option<String> {
        let fitted = self.points.fitted();
        let mut outside = fit.contacts.iter().zip(&fitted).filter(|(c, _)| !c.inside_aperture);
        let (_, &first) = outside.next()?;
        Some(format!(
            "the pose found puts {} touches beside the part as drawn, {} the first of them: the \
             touches hardly show where the part lies to the side; touch its side (edge.csv), and \
             do not rely on x and y before",
            outside.count() + 1,
            self.points.names[first],
        ))
    }

    /// Residual and height of a point that was not fitted.
    fn judged(&self, fit: &PoseFit, row: usize) -> Result<(f64, HeightCheck), Error> {
        let at = self.points.centers_mm[row];
        let rows = [row];
        let fail = |source: PoseError| self.error(source, Some(&rows));
        let tip = self.options.tip;
        let part = &self.surface.part;
        let local = fit.machine_from_workpiece.inverse_transform_point(&at);
        let foot = part
            .surface()
            .closest_point(&local)
            .map_err(|source| fail(PoseError::NoFoot { index: 0, source }))?;
        let height = height_at(part, fit, tip, at.x, at.y, at.z).map_err(fail)?;
        let check = HeightCheck {
            point: self.points.names[row].clone(),
            z_measured_mm: at.z,
            z_computed_mm: height.z_mm,
            dz_mm: height.z_mm - at.z,
            std_mm: height.sigma_mm,
        };
        Ok((foot.signed_distance_mm - tip.signed_radius_mm(), check))
    }

    fn residuals(
        &self,
        residual_mm: impl Fn(usize) -> f64,
        contact: impl Fn(usize) -> Option<(Point3<f64>, Vector3<f64>)>,
    ) -> Vec<TouchResidual> {
        (0..self.points.names.len())
            .map(|row| TouchResidual {
                point: self.points.names[row].clone(),
                usage: if self.points.is_check[row] { "check" } else { "fit" },
                x_mm: self.points.centers_mm[row].x,
                y_mm: self.points.centers_mm[row].y,
                z_mm: self.points.centers_mm[row].z,
                residual_mm: residual_mm(row),
                declared_contact_mm: contact(row).map(|(at, _)| at.into()),
                declared_normal: contact(row).map(|(_, normal)| normal.into()),
                empirical_mm: None,
            })
            .collect()
    }

    fn measured_touches(&self) -> Vec<MeasuredTouch> {
        let points = &self.points;
        let sigma_mm = self.sigma_mm.unwrap_or(1.0);
        (0..points.names.len())
            .map(|row| MeasuredTouch {
                name: points.names[row].clone(),
                group: points.groups.as_ref().map_or(&points.names, |groups| groups)[row].clone(),
                role: if points.is_check[row] { Role::Check } else { Role::Fit },
                touch: Touch::new(points.centers_mm[row], sigma_mm),
            })
            .collect()
    }

    /// The pose of the declared model; where the touches hardly show it, with the intervals that the
    /// profile of χ² gives.
    fn estimate(&self, fit: &PoseFit, options: &PoseOptions) -> PoseEstimate {
        let sigmas = fit.standard_uncertainties();
        let estimate = PoseEstimate::of(&fit.pose, sigmas);
        let (Some(sigmas), false) = (sigmas, fit.weak_directions.is_empty()) else {
            return estimate;
        };
        let is_declared = self.sigma_mm.is_some();
        let part = self.surface.part.clone();
        let model = PoseModel::new(part, self.measured_touches(), &[], &fit.pose, options);
        let Ok(model) = model else { return estimate };
        let state = State::start(&model);
        let columns: Vec<Column> = (0..model.declared().base.len()).map(Column::Base).collect();
        let fitted = FittedPose {
            state: &state,
            columns: &columns,
            empirical: &[],
            variance_factor: if is_declared { 1.0 } else { fit.variance_factor.unwrap_or(1.0) },
            sigmas,
        };
        let factor = coverage_factor(Some(fit.degrees_of_freedom).filter(|_| !is_declared));
        match model.profile(&fitted, factor) {
            Some(reach) => estimate.within(&reach, factor),
            None => estimate,
        }
    }

    /// Estimates with the accepted effects in the model.
    fn closed(
        &self,
        model: &PoseModel,
        closure: &Closure,
        declared: &PoseFit,
    ) -> Arc<dyn Estimates> {
        let (state, columns) = (&closure.state, &closure.columns);
        let pose = model.pose_at(state);
        let sigmas = stds(&model.pose_covariance(state, columns, &closure.covariance));
        let mut estimate = PoseEstimate::of(&pose, Some(sigmas));
        if !declared.weak_directions.is_empty() {
            let (empirical, variance_factor) = (&closure.empirical, closure.variance_factor);
            let fitted = FittedPose { state, columns, empirical, variance_factor, sigmas };
            let factor = coverage_factor(closure.degrees_of_freedom);
            if let Some(reach) = model.profile(&fitted, factor) {
                estimate = estimate.within(&reach, factor);
            }
        }
        let from_machine = pose.machine_from_workpiece();
        let check = |row: usize| {
            let at = self.points.centers_mm[row];
            let local = from_machine.inverse_transform_point(&at);
            // Along z the surface is as far as along its normal over the normal's z.
            let foot = self.surface.part.surface().closest_point(&local).ok()?;
            let along_z = (from_machine.rotation * foot.normal).z;
            let dz_mm = -closure.residuals_after[row] / along_z;
            let by_model = closure.jacobian.row(row);
            let variance = (by_model * &closure.covariance * by_model.transpose())[0];
            Some(HeightCheck {
                point: self.points.names[row].clone(),
                z_measured_mm: at.z,
                z_computed_mm: at.z + dz_mm,
                dz_mm,
                std_mm: Some(variance.max(0.0).sqrt() / along_z.abs()),
            })
        };
        let judged = (0..self.points.names.len()).filter(|row| self.points.is_check[*row]);
        let contact = |row: usize| Some(model.declared_contact(row));
        let mut points = self.residuals(|row| closure.residuals_after[row], contact);
        if !closure.empirical.is_empty() {
            let added: Vec<_> = closure.empirical.iter().map(EmpiricalCorrection::added).collect();
            for (row, point) in points.iter_mut().enumerate() {
                point.empirical_mm = Some(added.iter().map(|a| a[row]).sum());
            }
        }
        Arc::new(PoseIcpEstimates {
            pose: estimate,
            matrix: rows(&model.reading_from_workpiece(state)),
            reference_mm: model.has_reference(state).then(|| model.reference_mm().into()),
            checks: judged.filter_map(check).collect(),
            points,
            singular_values: Vec::new(),
            weak_directions: declared.weak_directions.iter().map(ToString::to_string).collect(),
        })
    }

    /// `rows` are those that the solver was given; messages speak of rows of the table.
    fn error(&self, mut source: PoseError, rows: Option<&[usize]>) -> Error {
        let mut at = self.points.file.clone();
        if let PoseError::InvalidTouch { index, .. }
        | PoseError::NoFoot { index, .. }
        | PoseError::OutsideAperture { index, .. }
        | PoseError::TipTooLarge { index, .. } = &mut source
        {
            *index = rows.and_then(|rows| rows.get(*index).copied()).unwrap_or(*index);
            if let Some(line) = self.points.lines.get(*index) {
                at = at.line(*line);
            }
        }
        super::settings::error(at, source)
    }
}
