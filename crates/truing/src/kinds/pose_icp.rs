//! `pose-icp`: where a workpiece lies, from touches of its surface.

mod case;
mod estimates;
mod measured;
mod picture;
mod plan;
mod plausible;
mod pose_numbers;
mod settings;
mod surface;
mod suspects;
mod tables;

use geometry::EulerAngles;
use nalgebra::Vector3;
use pose_icp::{
    EdgeTouches, PoseOptions, PoseParameter, PoseStart, Tip, TipSide, start_from_touches,
};
use toml::Spanned;

use crate::Error;
use crate::case::{Document, Finite, Folder, Location, Positive, Problem};
use crate::kind::Kind;
use crate::measured::{Measured, Reading};
use crate::suspect::{Dimension, Readings};
use crate::uncertain::{Std, Uncertain};

use super::surface::TYPED;
use case::PoseCase;
pub(crate) use estimates::stds;
pub use estimates::{HeightCheck, PoseEstimate, PoseIcpEstimates, PoseIntervals, TouchResidual};
pub(crate) use plausible::plausible_reading;
pub use pose_numbers::PoseNumbers;
use surface::read_surface;
use tables::{Points, XYZ};

use settings::{
    EDGE, NoiseSettings, POINTS, ParameterName, PoseSettings, Settings, SideName, ToolSettings,
    error, zero,
};

pub(crate) const KIND: Kind = Kind {
    name: "pose-icp",
    summary: "pose of a workpiece from touches of its surface",
    read,
    mistakes: suspects::mistakes,
    record: None,
    touches: Some(POINTS),
    readings: &[Readings::of(POINTS, &[(&XYZ, Dimension::Length)])],
    typed: &TYPED,
    uncertain: &[
        Uncertain { table: POINTS, columns: &XYZ, std: Std::Declared("point_mm") },
        Uncertain { table: EDGE, columns: &XYZ, std: Std::Declared("point_mm") },
    ],
    example: &[
        ("case.toml", include_str!("../../templates/pose-icp/case.toml")),
        ("points.csv", include_str!("../../templates/pose-icp/points.csv")),
        ("edge.csv", include_str!("../../templates/pose-icp/edge.csv")),
    ],
};

fn read(folder: &Folder, document: &Document) -> Result<Reading, Error> {
    let settings: Settings = document.settings()?;
    let mut warnings = Vec::new();
    let surface = read_surface(&settings.surface, folder, document, &mut warnings)?;
    let points = Points::read(folder, document, &settings.closure)?;
    warnings.extend(points.warnings.iter().cloned());
    if settings.noise.point_mm.is_none() {
        warnings.push(
            "no `[noise] point_mm`: standard uncertainties are estimated from the residual"
                .to_owned(),
        );
    }
    let Finite(radius_mm) = settings.probe.tip_radius_mm.unwrap_or(zero());
    let side = match settings.probe.side {
        SideName::Above => TipSide::Above,
        SideName::Below => TipSide::Below,
    };
    let tip = Tip { radius_mm, side };
    let gamma_deg = gamma_deg(&settings.pose, document)?;
    // The edge is read wherever it is there.
    let mut tables = vec![POINTS, EDGE];
    tables.extend(&surface.tables);
    let edge = if folder.has(EDGE) { Some(edge(folder, &settings.noise, document)?) } else { None };
    warnings.extend(settings.plan.of_probing_alone());
    let (gamma_rad, at) = (gamma_deg.to_radians(), document.at_file());
    let case = assemble(surface, points, tip, gamma_rad, edge.as_ref(), &settings, at)?;
    let measured: Box<dyn Measured> = Box::new(case);
    Ok(Reading { measured, loop_settings: settings.closure, warnings, tables })
}

/// Where gamma is held, or the search for it starts.
fn gamma_deg(pose: &PoseSettings, document: &Document) -> Result<f64, Error> {
    let start = pose.initial.as_ref().and_then(|initial| initial.gamma_deg.as_ref());
    match (pose.gamma_deg, start) {
        (Some(_), Some(start)) => {
            let message = "`[pose] gamma_deg` holds gamma, and `initial` has another start for it; keep one: \
                           `gamma_deg` where it is known, the start where it is to be found"
                .to_owned();
            Err(Error::case(document.at(&start.span()), Problem::WrongValue { message }))
        }
        (Some(Finite(held)), None) => Ok(held),
        (None, start) => Ok(start.map_or(0.0, |start| start.get_ref().0)),
    }
}

/// Side touches with the file they come from.
struct Edge {
    at: Location,
    touches: EdgeTouches,
}

fn edge(folder: &Folder, noise: &NoiseSettings, document: &Document) -> Result<Edge, Error> {
    if noise.edge_mm.is_some() && noise.point_mm.is_none() {
        let key = "[noise] point_mm".to_owned();
        let purpose = "the uncertainty of the side touches is declared, so that of the points must \
                       be too";
        return Err(Error::case(document.at_file(), Problem::MissingKey { key, purpose }));
    }
    // Undeclared, a side touch is as good as any other.
    let sigma_mm = noise.edge_mm.or(noise.point_mm).map_or(1.0, |Positive(mm)| mm);
    let (at, [first, second, third, fourth, center_mm]) = tables::edge(folder)?;
    let sides_mm = [first, second, third, fourth];
    Ok(Edge { at, touches: EdgeTouches { sides_mm, center_mm, sigma_mm } })
}

fn assemble(
    surface: surface::Surface,
    points: Points,
    tip: Tip,
    gamma_rad: f64,
    edge: Option<&Edge>,
    settings: &Settings,
    document: Location,
) -> Result<PoseCase, Error> {
    let at = points.file.clone();
    let located = edge
        .map(|edge| {
            let located = edge.touches.locate(tip, gamma_rad);
            located.map_err(|source| error(edge.at.clone(), source))
        })
        .transpose()?;
    let known = named(settings.pose.known.as_ref());
    let held = held(&[named(settings.pose.held.as_ref()), known.clone()].concat());
    let is_named = settings.pose.held.is_some() || settings.pose.known.is_some();
    let lateral_held = held.contains(&PoseParameter::X) && held.contains(&PoseParameter::Y);
    let sigma_mm = settings.noise.point_mm.map(|Positive(mm)| mm);
    let start = match (&settings.pose.initial, &located) {
        (Some(initial), _) => PoseStart {
            position_mm: Vector3::new(initial.x_mm.0, initial.y_mm.0, initial.z_mm.0),
            angles: EulerAngles {
                alpha_rad: initial.alpha_deg.0.to_radians(),
                beta_rad: initial.beta_deg.0.to_radians(),
                gamma_rad,
            },
        },
        (None, Some(located)) => located.start,
        (None, None) => {
            let touches = points.touches(sigma_mm.unwrap_or(1.0));
            start_from_touches(&surface.part, &touches, tip, gamma_rad)
                .map_err(|source| error(at, source))?
        }
    };
    let options = PoseOptions {
        tip,
        held,
        known,
        machine_axes: settings.machine.axes.unwrap_or(true),
        lateral: located.filter(|_| !lateral_held).map(|l| l.prior),
        noise: if sigma_mm.is_some() {
            pose_icp::Noise::Declared
        } else {
            pose_icp::Noise::Estimated
        },
    };
    // γ is held by default; a freeform part may show it, and is asked where nobody states it.
    let ask_gamma = surface.shows_gamma && settings.pose.gamma_deg.is_none() && !is_named;
    let plan = settings.plan.clone();
    let tool = settings.tool.as_ref().map(ToolSettings::tool);
    Ok(PoseCase { surface, points, start, options, sigma_mm, ask_gamma, plan, tool, document })
}

fn named(names: Option<&Spanned<Vec<ParameterName>>>) -> Vec<PoseParameter> {
    let names = names.map(|names| names.get_ref().as_slice()).unwrap_or_default();
    names.iter().map(|name| PoseParameter::from(*name)).collect()
}

fn held(names: &[PoseParameter]) -> Vec<PoseParameter> {
    let mut held = vec![PoseParameter::Gamma];
    held.extend(names);
    held.sort_unstable();
    held.dedup();
    held
}

impl From<ParameterName> for PoseParameter {
    fn from(name: ParameterName) -> Self {
        match name {
            ParameterName::X => Self::X,
            ParameterName::Y => Self::Y,
            ParameterName::Z => Self::Z,
            ParameterName::Alpha => Self::Alpha,
            ParameterName::Beta => Self::Beta,
            ParameterName::Gamma => Self::Gamma,
        }
    }
}
