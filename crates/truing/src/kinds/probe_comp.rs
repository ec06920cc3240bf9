//! `probe-comp`: where a ball probe really touched, and how far the part is off there.

mod around;
mod case;
mod estimates;
mod guides;
mod measured;
mod plan;
mod probing_check;
mod qualification;
mod settings;
mod surface;
mod suspects;
mod tables;

use nalgebra::{Unit, Vector3};
use probe_comp::{NormalSource, Side};

use crate::Error;
use crate::case::{Document, Finite, Folder, Positive, Problem};
use crate::kind::Kind;
use crate::measured::Reading;
use crate::suspect::{Dimension, Readings, Samples};
use crate::uncertain::{Std, Uncertain};

use super::surface::TYPED;
use case::ProbeCase;
pub use estimates::{
    MeasuredNormalEstimate, PlannedContactEstimate, ProbeCompEstimates, TouchEstimate,
};
pub use probing_check::ProbingCheckEstimate;
use qualification::corrected;
pub use qualification::{LobeEstimate, QualificationEstimate};
use surface::{PartSurface, read_surface};
use tables::{Touches, XYZ};

use settings::{MICRO, NormalName, ProbeSettings, QUALIFICATION, Settings, SideName, TOUCHES};

pub(crate) const KIND: Kind = Kind {
    name: "probe-comp",
    summary: "contacts and deviations from the ball centres of a touch probe",
    read,
    mistakes: suspects::mistakes,
    record: None,
    touches: Some(TOUCHES),
    readings: &[Readings {
        samples: Some(Samples { file: MICRO, label: "touch", sets: &[(&XYZ, Dimension::Length)] }),
        ..Readings::of(TOUCHES, &[(&XYZ, Dimension::Length)])
    }],
    typed: &TYPED,
    uncertain: &[
        Uncertain { table: TOUCHES, columns: &XYZ, std: Std::Declared("point_mm") },
        Uncertain { table: MICRO, columns: &XYZ, std: Std::Declared("point_mm") },
        Uncertain { table: QUALIFICATION, columns: &XYZ, std: Std::Declared("point_mm") },
    ],
    example: &[
        ("case.toml", include_str!("../../templates/probe-comp/case.toml")),
        ("touches.csv", include_str!("../../templates/probe-comp/touches.csv")),
    ],
};

fn read(folder: &Folder, document: &Document) -> Result<Reading, Error> {
    let settings: Settings = document.settings()?;
    let mut warnings = Vec::new();
    let tip_radius_mm = settings.probe.radius_mm(document)?;
    let stylus = settings.probe.stylus(document)?;
    let mut touches = Touches::read(folder, document, &settings.closure)?;
    warnings.extend(touches.warnings.iter().cloned());
    let mut surface = read_surface(&settings.surface, folder, document, &mut warnings)?;
    let side = side(&settings, &surface, &touches, tip_radius_mm, &mut warnings);
    surface.nominal = surface.nominal.from_side(side);
    if settings.noise.point_mm.is_none() {
        warnings.push(
            "no `[noise] point_mm`: standard uncertainties are estimated from the residual"
                .to_owned(),
        );
    }
    let source = settings.model.normal.into();
    if source == NormalSource::Approach && !touches.have_approach {
        let key = "nx, ny, nz".to_owned();
        let purpose = "`[model] normal = \"approach\"` compensates along these columns of \
                       `touches.csv`";
        return Err(Error::case(document.at_file(), Problem::MissingKey { key, purpose }));
    }
    let sigma_mm = settings.noise.point_mm.map(|Positive(mm)| mm);
    let (mut effective_radius_mm, mut qualification, mut probe) = (tip_radius_mm, None, None);
    if let Some(artefact) = &settings.qualification {
        let (found, estimate) = artefact.apply(folder, document, stylus, tip_radius_mm)?;
        touches.balls = corrected(&found, &surface.nominal, &touches)?;
        effective_radius_mm = found.effective_radius_mm;
        qualification = Some(estimate);
        // The larger of what was declared and what was found: few touches find little by chance.
        let found_mm2 = found.variance_factor.unwrap_or(0.0);
        probe = Some(found.uncertainty(sigma_mm.map_or(1.0, |mm| found_mm2.max(mm * mm))));
    }
    // Touches around others are read wherever they are there.
    let mut tables = vec![TOUCHES, MICRO];
    tables.extend(&surface.tables);
    tables.extend(qualification.as_ref().map(|_| QUALIFICATION));
    let case = ProbeCase {
        surface,
        touches,
        tip_radius_mm: effective_radius_mm,
        qualification,
        probe,
        stylus,
        source,
        sigma_mm,
        plan: settings.plan,
        document: document.at_file(),
    };
    let loop_settings = settings.closure;
    Ok(Reading { measured: Box::new(case), loop_settings, warnings, tables })
}

/// Side on which the ball is: as stated, else as the touches say.
fn side(
    settings: &Settings,
    surface: &PartSurface,
    touches: &Touches,
    tip_radius_mm: f64,
    warnings: &mut Vec<String>,
) -> Side {
    let nominal = &surface.nominal;
    if surface.has_own_side {
        if settings.probe.side.is_some() {
            let text = "`[probe] side` is not used with shape `sphere`: `[surface] side` is";
            warnings.push(text.to_owned());
        }
        return nominal.side();
    }
    match settings.probe.side {
        Some(SideName::Above) => Side::Along,
        Some(SideName::Below) => Side::Against,
        None if touches.are_behind(nominal, tip_radius_mm) => {
            warnings.push(
                "the ball's centres are on the −z side of the surface: taken for side = \"-z\""
                    .to_owned(),
            );
            Side::Against
        }
        None => nominal.side(),
    }
}

impl ProbeSettings {
    fn radius_mm(&self, document: &Document) -> Result<f64, Error> {
        let Finite(radius_mm) = *self.tip_radius_mm.get_ref();
        if radius_mm >= 0.0 {
            return Ok(radius_mm);
        }
        let message = format!("`tip_radius_mm`: expected a radius, 0 or more, found {radius_mm}");
        let at = document.at(&self.tip_radius_mm.span());
        Err(Error::case(at, Problem::WrongValue { message }))
    }

    fn stylus(&self, document: &Document) -> Result<Unit<Vector3<f64>>, Error> {
        let Some(stylus) = &self.stylus else { return Ok(Vector3::z_axis()) };
        let [x, y, z] = stylus.get_ref().map(|Finite(v)| v);
        Unit::try_new(Vector3::new(x, y, z), f64::MIN_POSITIVE).ok_or_else(|| {
            let message = "`stylus`: expected the direction of the stylus, found the zero vector";
            let problem = Problem::WrongValue { message: message.to_owned() };
            Error::case(document.at(&stylus.span()), problem)
        })
    }
}

impl From<NormalName> for NormalSource {
    fn from(name: NormalName) -> Self {
        match name {
            NormalName::Nominal => Self::Nominal,
            NormalName::Approach => Self::Approach,
            NormalName::MicroPlane => Self::MicroPlane,
            NormalName::Quadric => Self::Quadric,
            NormalName::SurfaceFit => Self::SurfaceFit,
            NormalName::Profile => Self::Profile,
        }
    }
}
