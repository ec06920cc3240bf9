//! `frame-fit`: the transform between two frames from points known in both.

mod estimates;
mod measured;
mod plan;
mod poses;
mod rematched;
mod set_ups;
mod settings;
mod suspects;
mod tip;

use frame_fit::{Handedness, Transform};

use crate::Error;
use crate::case::{
    Columns, Document, Folder, NumberColumn, Positive, Problem, SESSION, Table, group_names,
    of_names,
};
use crate::kind::Kind;
use crate::kinds::orientation::QUATERNION;
use crate::measured::{Measured, Reading};
use crate::suspect::{Dimension, Readings};
use crate::uncertain::{Std, Uncertain};

pub use estimates::{FrameFitEstimates, PointResidual, ScaleEstimate, TransformStd};
pub use tip::{DistanceResidual, PlaceEstimate, PoseResidual, TipEstimates};

use measured::{FrameCase, Sigma, Use};

use settings::{
    COORDINATES, DISTANCES, FROM, HandednessName, KNOWN, PAIRS, POSES, SIGMA, Settings, TO,
    TransformName,
};

pub(crate) const KIND: Kind = Kind {
    name: "frame-fit",
    summary: "transform between two frames from points known in both",
    read,
    mistakes: suspects::mistakes,
    record: None,
    touches: None,
    readings: &[
        Readings::of(PAIRS, &[(&TO, Dimension::Length), (&FROM, Dimension::Length)]),
        Readings::of(
            POSES,
            &[(&COORDINATES, Dimension::Length), (&QUATERNION, Dimension::Direction)],
        ),
    ],
    typed: &[],
    uncertain: &[
        Uncertain { table: PAIRS, columns: &TO, std: Std::Columns(&SIGMA) },
        Uncertain { table: PAIRS, columns: &TO, std: Std::Columns(&["sigma_mm"]) },
        Uncertain { table: PAIRS, columns: &TO, std: Std::Declared("point_mm") },
        Uncertain {
            table: POSES,
            columns: &["x_mm", "y_mm", "z_mm"],
            std: Std::Declared("point_mm"),
        },
        Uncertain { table: DISTANCES, columns: &["distance_mm"], std: Std::Columns(&["std_mm"]) },
    ],
    example: &[
        ("case.toml", include_str!("../../templates/frame-fit/case.toml")),
        ("pairs.csv", include_str!("../../templates/frame-fit/pairs.csv")),
    ],
};

fn read(folder: &Folder, document: &Document) -> Result<Reading, Error> {
    let settings: Settings = document.settings()?;
    if folder.has(POSES) {
        if folder.has(PAIRS) {
            let problem = Problem::ExclusiveTables { other: PAIRS.to_owned() };
            return Err(Error::case(folder.location(POSES), problem));
        }
        return poses::read(folder, document, settings);
    }
    let table = folder.table(PAIRS, &["point", FROM[0], FROM[1], TO[0], TO[1]])?;
    let mut columns = Columns::new(&table, KNOWN);
    let names = columns.texts("point")?.into_iter().map(str::to_owned).collect();
    let dimension = if columns.has(FROM[2]) || columns.has(TO[2]) { 3 } else { 2 };
    let from_mm = coordinates(&mut columns, &FROM[..dimension])?;
    let to_mm = coordinates(&mut columns, &TO[..dimension])?;
    let mut warnings = Vec::new();
    let sigma = sigma(&mut columns, dimension, settings.noise.point_mm, &mut warnings)?;
    let uses = columns.words("use", &[("fit", Use::Fit), ("check", Use::Check)], Some(Use::Fit))?;
    let bodies = columns.has("body").then(|| columns.texts("body")).transpose()?;
    let extras = columns.rest(&settings.closure.columns)?;
    let sessions = sessions(&table, &extras.labels);
    warnings.extend(extras.warnings);
    let groups = group_names(settings.closure.group.as_ref(), &table, document)?;
    let lines = (0..table.n_rows()).map(|row| table.line(row)).collect();
    let case = FrameCase {
        file: table.at_file(),
        lines,
        dimension,
        names,
        from_mm,
        to_mm,
        sigma,
        uses,
        covariates: extras.covariates,
        sessions,
        bodies: bodies.map(|bodies| bodies.into_iter().map(str::to_owned).collect()),
        groups,
        group_column: settings.closure.group.as_ref().map(|g| g.get_ref().clone()),
        transform: settings.model.transform.into(),
        handedness: settings.model.handedness.into(),
        plan: settings.plan,
        document: document.at_file(),
    };
    let measured: Box<dyn Measured> = Box::new(case);
    Ok(Reading { measured, loop_settings: settings.closure, warnings, tables: vec![PAIRS] })
}

/// Sessions of which each may have been unlike the others.
fn sessions(table: &Table, labels: &[String]) -> Vec<NumberColumn> {
    let label = labels.iter().find(|label| *label == SESSION);
    let column = label.and_then(|label| table.column(label));
    let titled = |name: &str| format!("{SESSION}: {SESSION} {name}");
    column.map_or_else(Vec::new, |column| of_names(table, column, titled))
}

/// One row per point.
fn coordinates(columns: &mut Columns<'_>, names: &[&'static str]) -> Result<Vec<Vec<f64>>, Error> {
    let axes = names.iter().map(|name| columns.numbers(name)).collect::<Result<Vec<_>, _>>()?;
    Ok((0..axes[0].len()).map(|row| axes.iter().map(|axis| axis[row]).collect()).collect())
}

fn sigma(
    columns: &mut Columns<'_>,
    dimension: usize,
    point_mm: Option<Positive>,
    warnings: &mut Vec<String>,
) -> Result<Sigma, Error> {
    let names = &SIGMA[..dimension];
    let per_axis = names.iter().copied().find(|name| columns.has(name));
    if let Some(other) = per_axis
        && columns.has("sigma_mm")
    {
        let (column, other) = ("sigma_mm".to_owned(), other.to_owned());
        let at = columns.at(&column);
        return Err(Error::case(at, Problem::ExclusiveColumns { column, other }));
    }
    let sigma = if per_axis.is_some() {
        Sigma::PerAxis(names.iter().map(|n| columns.positives(n)).collect::<Result<_, _>>()?)
    } else if columns.has("sigma_mm") {
        Sigma::PerPoint(columns.positives("sigma_mm")?)
    } else if let Some(Positive(point_mm)) = point_mm {
        return Ok(Sigma::Same(point_mm));
    } else {
        warnings.push(
            "no `[noise] point_mm` and no sigma column: standard uncertainties are estimated \
             from the residual"
                .to_owned(),
        );
        return Ok(Sigma::Unknown);
    };
    if point_mm.is_some() {
        warnings
            .push("`[noise] point_mm` is not used: the table has its own sigma column".to_owned());
    }
    Ok(sigma)
}

impl From<TransformName> for Transform {
    fn from(name: TransformName) -> Self {
        match name {
            TransformName::None => Self::None,
            TransformName::Translation => Self::Translation,
            TransformName::Rigid => Self::Rigid,
            TransformName::Similarity => Self::Similarity,
            TransformName::Affine => Self::Affine,
        }
    }
}

impl From<HandednessName> for Handedness {
    fn from(name: HandednessName) -> Self {
        match name {
            HandednessName::Proper => Self::Proper,
            HandednessName::Improper => Self::Improper,
        }
    }
}
