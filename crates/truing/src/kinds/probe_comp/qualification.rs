use nalgebra::{Unit, Vector3};
use probe_comp::{BallTouch, ProbeError, ProbeTerms, Qualification, Reference, qualify};
use serde::Serialize;

use super::probing_check::ProbingCheckEstimate;
use super::settings::{ArtefactName, QualificationSettings};
use super::tables::{Touches, artefact_touches};
use crate::Error;
use crate::case::{Document, Finite, Folder, Positive, Problem};
use crate::estimated::Estimated;

/// Lobes of a probe on three seats.
const LOBES: [u32; 1] = [3];

/// What the probe adds to a reading, as its artefact says.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct QualificationEstimate {
    /// Touches of the artefact.
    pub touches: usize,
    /// Root mean square of what is left of them.
    pub rms_mm: f64,
    /// Radius of the ball less the travel until the trigger: what the touches are compensated with.
    pub effective_radius_mm: f64,
    /// Standard uncertainty of it, common to all deviations; `None` without redundancy.
    pub std_effective_radius_mm: Option<f64>,
    /// `tip_radius_mm` less the effective radius.
    pub pretravel_mm: f64,
    /// Travel by azimuth about the stylus, one per harmonic.
    pub lobes: Vec<LobeEstimate>,
    /// How far the stylus gives way at right angles to it; `None` where it was not asked for.
    pub bending_mm: Option<f64>,
    /// Standard uncertainty of it.
    pub std_bending_mm: Option<f64>,
    /// The check of the declared ball on the sphere; absent of a ring.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub probing_check: Option<ProbingCheckEstimate>,
}

/// One harmonic of the travel until the trigger.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LobeEstimate {
    /// Lobes around the stylus.
    pub order: u32,
    /// Amplitude of the cosine.
    pub cos_mm: f64,
    /// Amplitude of the sine.
    pub sin_mm: f64,
    /// Standard uncertainties of both.
    pub std_mm: Option<[f64; 2]>,
}

/// Place of the artefact, then the radius, in the covariance.
const RADIUS: usize = 3;

impl QualificationSettings {
    /// Qualifies the probe on its artefact and takes what it adds off the touches of the part, whose
    /// standard uncertainty of a coordinate weighs the artefact's too.
    pub(super) fn apply(
        &self,
        folder: &Folder,
        document: &Document,
        stylus: Unit<Vector3<f64>>,
        tip_radius_mm: f64,
    ) -> Result<(Qualification, QualificationEstimate), Error> {
        let Positive(radius_mm) = self.radius_mm;
        let is_ring = self.shape == ArtefactName::Ring;
        let reference = if is_ring {
            Reference::Ring { radius_mm, axis: self.axis(document, stylus)? }
        } else {
            Reference::Sphere { radius_mm }
        };
        let terms = ProbeTerms {
            stylus,
            lobes: self.lobes.clone().unwrap_or_else(|| LOBES.to_vec()),
            // A ring does not tell it from the radius.
            bending: self.bending.unwrap_or(!is_ring),
        };
        let artefact = artefact_touches(folder)?;
        let found = qualify(&artefact.balls, &reference, &terms).map_err(|source| {
            let line = source.touch().and_then(|row| artefact.lines.get(row));
            let at = match (&source, line) {
                (ProbeError::InvalidOption { .. }, _) => document.at_file(),
                (_, Some(line)) => artefact.file.clone().line(*line),
                (_, None) => artefact.file.clone(),
            };
            super::settings::error(at, source)
        })?;
        let mut estimate = QualificationEstimate::of(&found, &terms, tip_radius_mm);
        estimate.probing_check =
            ProbingCheckEstimate::of(&artefact.balls, &reference, &terms, tip_radius_mm);
        Ok((found, estimate))
    }

    fn axis(
        &self,
        document: &Document,
        stylus: Unit<Vector3<f64>>,
    ) -> Result<Unit<Vector3<f64>>, Error> {
        let Some(axis) = &self.axis else { return Ok(stylus) };
        let [x, y, z] = axis.get_ref().map(|Finite(v)| v);
        Unit::try_new(Vector3::new(x, y, z), f64::MIN_POSITIVE).ok_or_else(|| {
            let message =
                "`axis`: expected the direction of the ring's axis, found the zero vector";
            let problem = Problem::WrongValue { message: message.to_owned() };
            Error::case(document.at(&axis.span()), problem)
        })
    }
}

/// The touches of the part without what the probe added.
pub(super) fn corrected(
    qualification: &Qualification,
    nominal: &probe_comp::Nominal,
    touches: &Touches,
) -> Result<Vec<BallTouch>, Error> {
    qualification.applied(nominal, &touches.balls).map_err(|source| {
        let line = source.touch().and_then(|row| touches.lines.get(row));
        let at = touches.file.clone();
        super::settings::error(
            line.map_or_else(|| at.clone(), |line| at.clone().line(*line)),
            source,
        )
    })
}

impl QualificationEstimate {
    fn of(found: &Qualification, terms: &ProbeTerms, tip_radius_mm: f64) -> Self {
        let is_known = found.variance_factor.is_some();
        let std =
            |index: usize| is_known.then(|| found.covariance_mm2[(index, index)].max(0.0).sqrt());
        let lobe = |(k, lobe): (usize, &probe_comp::Lobe)| {
            let at = RADIUS + 1 + 2 * k;
            let std_mm = std(at).zip(std(at + 1)).map(|(cos, sin)| [cos, sin]);
            LobeEstimate { order: lobe.order, cos_mm: lobe.cos_mm, sin_mm: lobe.sin_mm, std_mm }
        };
        let bending_at = RADIUS + 1 + 2 * found.lobes.len();
        let squares: f64 = found.residuals_mm.iter().map(|r| r * r).sum();
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let count = found.residuals_mm.len() as f64;
        Self {
            touches: found.residuals_mm.len(),
            rms_mm: (squares / count).sqrt(),
            effective_radius_mm: found.effective_radius_mm,
            std_effective_radius_mm: std(RADIUS),
            pretravel_mm: found.pretravel_mm(tip_radius_mm),
            lobes: found.lobes.iter().enumerate().map(lobe).collect(),
            bending_mm: terms.bending.then_some(found.bending_mm),
            std_bending_mm: if terms.bending { std(bending_at) } else { None },
            probing_check: None,
        }
    }

    /// The numbers with their uncertainties, for people.
    pub(super) fn parameters(&self) -> Vec<Estimated> {
        let um = |name: &str, value: f64, std: Option<f64>| {
            Estimated::new(name, "µm", value * 1e3, std.map(|s| s * 1e3))
        };
        let (radius, std) = (self.effective_radius_mm, self.std_effective_radius_mm);
        let mut all = vec![
            Estimated::new("effective radius", "mm", radius, std),
            um("pretravel", self.pretravel_mm, std),
        ];
        for lobe in &self.lobes {
            let [cos, sin] = lobe.std_mm.map_or([None; 2], |std| std.map(Some));
            all.push(um(&format!("lobes {} cos", lobe.order), lobe.cos_mm, cos));
            all.push(um(&format!("lobes {} sin", lobe.order), lobe.sin_mm, sin));
        }
        all.extend(self.bending_mm.map(|mm| um("bending", mm, self.std_bending_mm)));
        all
    }
}
