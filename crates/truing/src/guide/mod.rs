//! Guide points of document \[E\]: where a ball is sent, moving along z, and where it will touch the part as
//! drawn.

mod answer;
mod text;

use std::path::{Path, PathBuf};

use nalgebra::Point3;
use probe_comp::GuidePoint;
use serde::Deserialize;

use crate::file::{InputFile, MAX_BYTES, read_text};
use crate::{Case, Error, Header};

pub use answer::{Guide, Guides};

/// Which places are asked for.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum GuideSource {
    /// An even lattice over the part, of the region and spacing in `[plan]`.
    #[default]
    Lattice,
    /// Above the touches of the case.
    Touches,
    /// The touches of a plan: what `truing plan --json` printed.
    Plan(PathBuf),
}

/// Places above which guide points are asked for.
#[derive(Clone, Debug)]
pub(crate) enum GuidePlaces {
    Lattice,
    Touches,
    /// Of touches that are planned.
    Named(Vec<NamedBall>),
}

/// Name of a touch, and the ball's centre.
pub(crate) type NamedBall = (String, Point3<f64>);

/// What a kind that probes answers.
pub(crate) struct GuidesOfCase {
    pub(crate) tip_radius_mm: f64,
    pub(crate) points: Vec<(String, GuidePoint)>,
    /// Places of a lattice where a ball that moves along z does not touch the part.
    pub(crate) beside: usize,
}

/// What is read of a plan.
#[derive(Deserialize)]
struct PlanAnswer {
    kind: String,
    plan: Vec<PlanMeasurement>,
}

#[derive(Deserialize)]
struct PlanMeasurement {
    name: String,
    touch: Option<PlanTouch>,
}

#[derive(Deserialize)]
struct PlanTouch {
    ball_mm: [f64; 3],
}

/// The guide points of a `probe-comp` case.
///
/// # Errors
///
/// [`Error::NoGuides`] for another kind of case or where there is none, [`Error::NotAPlan`],
/// [`Error::NotRead`]; of touches and plans the first one without a guide point.
pub fn guides(case: &Case, source: &GuideSource) -> Result<Guides, Error> {
    let mut input = None;
    let places = match source {
        GuideSource::Lattice => GuidePlaces::Lattice,
        GuideSource::Touches => GuidePlaces::Touches,
        GuideSource::Plan(path) => {
            let (named, read) = planned(case, path)?;
            input = Some(read);
            GuidePlaces::Named(named)
        }
    };
    let none = || Error::NoGuides { kind: case.kind };
    let found = case.measured.guides(&places)?.ok_or_else(none)?;
    if found.points.is_empty() {
        return Err(none());
    }
    let mut header = Header::of("truing/guide/1", case);
    header.inputs.extend(input);
    Ok(Guides {
        kind: case.kind,
        version: env!("CARGO_PKG_VERSION"),
        header,
        tip_radius_mm: found.tip_radius_mm,
        beside_the_part: found.beside,
        guides: found.points.iter().map(|(name, point)| Guide::of(name, point)).collect(),
        warnings: case.warnings.clone(),
    })
}

/// Names and balls of the touches that a plan holds.
fn planned(case: &Case, path: &Path) -> Result<(Vec<NamedBall>, InputFile), Error> {
    let wrong = |reason: String| Error::NotAPlan { path: path.to_owned(), reason };
    let text = read_text(path, MAX_BYTES).map_err(|problem| Error::not_read(path, problem))?;
    let answer: PlanAnswer = serde_json::from_str(&text).map_err(|e| wrong(e.to_string()))?;
    if answer.kind != case.kind {
        return Err(wrong(format!("it is of a case of kind `{}`", answer.kind)));
    }
    let touch = |one: PlanMeasurement| {
        let touch = one.touch.ok_or_else(|| wrong(format!("{} is no touch", one.name)))?;
        Ok((one.name, Point3::from(touch.ball_mm)))
    };
    let named = answer.plan.into_iter().map(touch).collect::<Result<Vec<_>, Error>>()?;
    Ok((named, InputFile::given(path, text.as_bytes())))
}
