use std::sync::Arc;

use model_discrepancy::{Closure, Covariate, Role};
use probe_comp::{
    BallTouch, Contact, MeasuredTouch, NormalSource, ProbeError, ProbeModel, ProbeSetup, compensate,
};
use truing_report::Fact;

use super::case::ProbeCase;
use super::estimates::{MeasuredNormalEstimate, ProbeCompEstimates, TouchEstimate};
use crate::Error;
use crate::case::NumberColumn;
use crate::estimates::Estimates;
use crate::guide::{GuidePlaces, GuidesOfCase};
use crate::kinds::Offer;
use crate::kinds::surface::yardstick_of;
use crate::measured::{About, Fitted, Measured, Observation, Places, Prepared, Words};
use crate::suspect::Yardstick;

/// Contacts, and what they say of the noise.
struct Compensated {
    contacts: Vec<Contact>,
    /// Standard uncertainties along the normal and along the surface, as the noise was declared.
    sigmas_mm: Vec<[f64; 2]>,
    estimates: ProbeCompEstimates,
    chi2_per_dof: Option<f64>,
    degrees_of_freedom: usize,
}

impl Measured for ProbeCase {
    fn fit(&self) -> Result<Fitted, Error> {
        let Compensated { contacts, estimates, chi2_per_dof, degrees_of_freedom, .. } =
            self.compensated()?;
        let observations = (contacts.iter().zip(&self.touches.is_check))
            .map(|(c, check)| Observation { residual: vec![c.deviation_mm], fitted: !check })
            .collect();
        let outside: Vec<&str> = (contacts.iter().zip(&self.touches.names))
            .filter(|(c, _)| !c.inside_aperture)
            .map(|(_, name)| name.as_str())
            .collect();
        let warnings = match outside[..] {
            [] => Vec::new(),
            [first, ..] => vec![format!(
                "{} touches lie beside the part as drawn, touch {first} the first of them",
                outside.len()
            )],
        };
        Ok(Fitted {
            estimates: Arc::new(estimates),
            observations,
            unit: "mm",
            degrees_of_freedom,
            chi2_per_dof: chi2_per_dof.filter(|_| self.sigma_mm.is_some()),
            warnings,
        })
    }

    fn prepare(&self) -> Result<Prepared<'_>, Error> {
        let Compensated { estimates: declared, sigmas_mm, .. } = self.compensated()?;
        let recorded: Vec<Covariate> =
            (self.touches.covariates.iter()).map(NumberColumn::covariate).collect();
        let setup = ProbeSetup {
            nominal: self.surface.nominal.clone(),
            tip_radius_mm: self.tip_radius_mm,
            stylus: self.stylus,
            source: self.source,
            sigma_declared: self.sigma_mm.is_some(),
            qualification: self.probe.clone(),
        };
        let model = ProbeModel::new(setup, self.measured_touches(), &recorded)
            .map_err(|e| self.error(e, None))?;
        Ok(prepared(model, Arc::new(declared), Arc::new(sigmas_mm)))
    }

    fn offer(&self) -> Result<Option<Offer>, Error> {
        super::plan::offer(self)
    }

    fn guides(&self, of: &GuidePlaces) -> Result<Option<GuidesOfCase>, Error> {
        super::guides::guides(self, of).map(Some)
    }

    fn yardstick(&self, _: &Fitted) -> Yardstick {
        yardstick_of(self.touches.balls.iter().map(|b| b.center_mm.coords.as_slice()))
    }

    fn words(&self) -> Words {
        let fact = |name: &str, value: String| Fact { name: name.to_owned(), value };
        let sigma = match self.sigma_mm {
            Some(mm) => format!("{mm} mm"),
            None => "not declared; estimated from the residual".to_owned(),
        };
        let normal = match self.source {
            NormalSource::Nominal => "of the nominal surface",
            NormalSource::Approach => "the approach, reversed",
            NormalSource::MicroPlane => "of the plane through the touches around each",
            NormalSource::SurfaceFit => "of the surface through each touch and its nearest others",
            NormalSource::Profile => "of the profile through each touch and its two neighbours",
            _ => "of the quadric through the touches around each",
        };
        let mut declared = vec![
            format!(
                "A ball of radius {} mm touches at A = O − r n; n is the normal {normal}.",
                self.printed_radius_mm()
            ),
            format!("The part is the nominal one: {}.", self.surface.words),
        ];
        if let Some(probe) = &self.qualification {
            declared.push(format!(
                "The radius is the effective one that {} touches of an artefact gave; what else the \
                 probe adds to a reading was taken off. What these touches leave uncertain of the \
                 probe is fitted within its covariance.",
                probe.touches
            ));
        }
        Words {
            declared,
            residual: "height of the contact above the nominal surface, along its normal",
            components: &[],
            group_noun: self.touches.group_column.clone().unwrap_or_else(|| "touch".to_owned()),
            measured: vec![
                fact("surface", self.surface.words.clone()),
                fact("tip radius", format!("{} mm", self.printed_radius_mm())),
                fact("normal", normal.to_owned()),
                fact("standard uncertainty of a coordinate", sigma),
            ],
            places: Some(Places {
                x_title: "x, mm",
                y_title: "y, mm",
                at: self.touches.balls.iter().map(|b| [b.center_mm.x, b.center_mm.y]).collect(),
                names: self.touches.names.clone(),
                facets: Vec::new(),
            }),
        }
    }
}

impl ProbeCase {
    /// To a tenth of a nanometre: of a qualified probe the digits beyond say nothing.
    fn printed_radius_mm(&self) -> f64 {
        (self.tip_radius_mm * 1e7).round() / 1e7
    }

    fn compensated(&self) -> Result<Compensated, Error> {
        let balls = self.balls(self.sigma_mm.unwrap_or(1.0));
        let nominal = &self.surface.nominal;
        let mut contacts = compensate(nominal, self.tip_radius_mm, &balls, self.source)
            .map_err(|e| self.error(e, None))?;
        let fitted: Vec<f64> = (contacts.iter().zip(&self.touches.is_check).zip(&balls))
            .filter(|((_, check), _)| !**check)
            .map(|((contact, _), ball)| (contact.deviation_mm / ball.sigma_mm).powi(2))
            .collect();
        let degrees_of_freedom = fitted.len();
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let chi2_per_dof =
            (!fitted.is_empty()).then(|| fitted.iter().sum::<f64>() / degrees_of_freedom as f64);
        // Undeclared, the residual of the touches is all that is known of their noise.
        let scale = if self.sigma_mm.is_some() { Some(1.0) } else { chi2_per_dof };
        let sigmas_mm =
            contacts.iter().map(|c| [c.sigma_deviation_mm(), c.sigma_tangential_mm()]).collect();
        for contact in &mut contacts {
            contact.covariance_mm2 *= scale.unwrap_or(1.0);
        }
        let mut touches = Vec::with_capacity(contacts.len());
        for (row, contact) in contacts.iter().enumerate() {
            let (name, check) = (&self.touches.names[row], self.touches.is_check[row]);
            touches.push(TouchEstimate::of(name, check, contact, scale.is_some()));
        }
        let rows: Vec<usize> =
            (0..balls.len()).filter(|&row| !balls[row].micro_mm.is_empty()).collect();
        let around: Vec<BallTouch> = rows.iter().map(|&row| balls[row].clone()).collect();
        let measured = compensate(nominal, self.tip_radius_mm, &around, NormalSource::MicroPlane);
        for (&row, mut contact) in
            rows.iter().zip(measured.map_err(|e| self.error(e, Some(&rows)))?)
        {
            contact.covariance_mm2 *= scale.unwrap_or(1.0);
            touches[row].measured = Some(MeasuredNormalEstimate::of(&contact, scale.is_some()));
        }
        let qualification = self.qualification.clone();
        let estimates = ProbeCompEstimates { qualification, touches };
        Ok(Compensated { contacts, sigmas_mm, estimates, chi2_per_dof, degrees_of_freedom })
    }

    fn balls(&self, sigma_mm: f64) -> Vec<BallTouch> {
        let balls = self.touches.balls.iter();
        balls.map(|ball| BallTouch { sigma_mm, ..ball.clone() }).collect()
    }

    fn measured_touches(&self) -> Vec<MeasuredTouch> {
        let touches = &self.touches;
        (self.balls(self.sigma_mm.unwrap_or(1.0)).into_iter().enumerate())
            .map(|(row, touch)| MeasuredTouch {
                name: touches.names[row].clone(),
                group: touches.groups.as_ref().unwrap_or(&touches.names)[row].clone(),
                role: if touches.is_check[row] { Role::Check } else { Role::Fit },
                touch,
            })
            .collect()
    }

    /// Puts what is wrong with a touch to its line of the table; `rows` are those given, if not all.
    fn error(&self, source: ProbeError, rows: Option<&[usize]>) -> Error {
        let row = |index: usize| rows.map_or(Some(index), |rows| rows.get(index).copied());
        let line = source.touch().and_then(row).and_then(|row| self.touches.lines.get(row));
        let at = self.touches.file.clone();
        super::settings::error(
            line.map_or_else(|| at.clone(), |line| at.clone().line(*line)),
            source,
        )
    }
}

/// What the loop needs of a model of the touches.
fn prepared<'c>(
    model: ProbeModel,
    declared: Arc<ProbeCompEstimates>,
    sigmas_mm: Arc<Vec<[f64; 2]>>,
) -> Prepared<'c> {
    let covariates = model.all_covariates();
    let model = Arc::new(model);
    let (of, at) = (Arc::clone(&model), Arc::clone(&model));
    let (known, sigmas) = (Arc::clone(&declared), Arc::clone(&sigmas_mm));
    let estimates = Box::new(move |closure: &Closure| closed(&of, closure, &known, &sigmas));
    let about: About<'_> = Box::new(move |found| {
        let there = at.about_found(&found.state);
        Ok(there.map(|there| prepared(there, Arc::clone(&declared), Arc::clone(&sigmas_mm))))
    });
    Prepared { model, covariates, estimates, about: Some(about) }
}

/// Contacts with the accepted effects in the model.
///
/// `sigmas_mm` are the uncertainties of every declared contact along the normal and the surface.
fn closed(
    model: &ProbeModel,
    closure: &Closure,
    declared: &ProbeCompEstimates,
    sigmas_mm: &[[f64; 2]],
) -> Arc<dyn Estimates> {
    let mut estimates = declared.clone();
    for (row, estimate) in estimates.touches.iter_mut().enumerate() {
        if let Some(change) = model.contact_change(row, closure, sigmas_mm[row]) {
            estimate.change(&change);
        }
        if !closure.empirical.is_empty() {
            estimate.empirical_mm = Some(closure.empirical.iter().map(|e| e.added()[row]).sum());
        }
    }
    Arc::new(estimates)
}
