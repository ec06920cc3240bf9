//! `force-impedance`: the contact force of a polishing head on four legs.

mod along_path;
mod estimates;
mod measured;
mod path_estimates;
mod plan;
mod plan_settings;
mod session;
mod settings;
mod suspects;

use force_impedance::{
    ForceFormula, Head, HeadGeometry, HeadLimits, ImpedanceParameters, LogOptions, LogSample,
};
use nalgebra::{Unit, Vector3};

use crate::Error;
use crate::case::{Columns, Document, Finite, Folder, Positive, Problem, Table, group_names};
use crate::kind::Kind;
use crate::measured::Reading;
use crate::suspect::{Dimension, Readings, Typed};
use measured::LogCase;

pub use estimates::{ContactForceEstimate, ForceBlock, ForceImpedanceEstimates, ImpedanceEstimate};
pub use path_estimates::{PathCell, PathError, PathForceEstimates};

use settings::{
    CELLS, HeadSettings, ImpedanceSettings, KNOWN, LEG_ANGLES_DEG, LENGTH_TOL, LENGTHS, LOG, PATH,
    PAUSE, Settings,
};
use suspects::{NORMAL, REFERENCE};

pub(crate) const KIND: Kind = Kind {
    name: "force-impedance",
    summary: "contact force of a polishing head on four legs",
    read,
    mistakes: suspects::mistakes,
    record: Some((LOG, "segment")),
    touches: None,
    readings: &[
        Readings {
            is_record: true,
            ..Readings::of(
                LOG,
                &[
                    (&CELLS, Dimension::Force),
                    (&[REFERENCE], Dimension::Force),
                    (&LENGTHS, Dimension::Length),
                    (&NORMAL, Dimension::Direction),
                ],
            )
        },
        Readings {
            is_record: true,
            ..Readings::of(
                PATH,
                &[(&["force_n"], Dimension::Force), (&[REFERENCE], Dimension::Force)],
            )
        },
    ],
    typed: &[
        Typed::of(&["head", "tip_to_plane_mm"]),
        Typed::of(&["head", "plane_to_joint_mm"]),
        Typed::of(&["head", "head_radius_mm"]),
        Typed::of(&["head", "bracket_radius_mm"]),
        Typed::of(&["head", "leg_angles_deg"]),
        Typed::of(&["head", "weight_n"]),
        Typed::of(&["head", "center_of_gravity_mm"]),
        Typed::of(&["head", "gravity"]),
    ],
    uncertain: &[],
    example: &[
        ("case.toml", include_str!("../../templates/force-impedance/case.toml")),
        ("log.csv", include_str!("../../templates/force-impedance/log.csv")),
    ],
};

fn read(folder: &Folder, document: &Document) -> Result<Reading, Error> {
    let settings: Settings = document.settings()?;
    match (folder.has(LOG), folder.has(PATH)) {
        (true, true) => {
            let problem = Problem::ExclusiveTables { other: LOG.to_owned() };
            Err(Error::case(folder.location(PATH), problem))
        }
        (false, true) => along_path::read(folder, document, settings),
        _ => read_log(folder, document, settings),
    }
}

fn read_log(folder: &Folder, document: &Document, settings: Settings) -> Result<Reading, Error> {
    let Some(of_head) = &settings.head else {
        let purpose = "the contact force is had from the dimensions of the head; runs along a path, \
                       without a head, go into `path.csv`";
        let problem = Problem::MissingKey { key: "[head]".to_owned(), purpose };
        return Err(Error::case(document.at_file(), problem));
    };
    let head = head(of_head, document)?;
    let table = folder.table(LOG, KNOWN)?;
    let mut columns = Columns::new(&table, KNOWN);
    let segment_names = if columns.has("segment") { Some(columns.texts("segment")?) } else { None };
    let group = settings.closure.group.as_ref();
    let groups = group_names(group, &table, document)?;
    let time_s = columns.numbers("time_s")?;
    let stretches = if segment_names.is_none() { stretches(&time_s) } else { Vec::new() };
    let names = segment_names.as_deref();
    let (segments, of_row) = segments(names, groups.as_deref(), &stretches, &table);
    let unnamed = || of_row.iter().map(|segment| segments[*segment].clone()).collect();
    let unnamed = segment_names.is_none().then(unnamed);
    let samples = samples(&table, &mut columns, (&time_s, &of_row))?;
    let extras = columns.rest(&settings.closure.columns)?;
    let sigma_n = settings.noise.force_n.map(|Positive(sigma)| sigma);
    let mut warnings = noise_warning(sigma_n, samples[0].reference_n.is_some());
    warnings.extend(extras.warnings);
    let formula = settings.model.force.map_or_else(ForceFormula::default, Into::into);
    let noun = match (group, segment_names) {
        (Some(group), _) => group.get_ref().clone(),
        (None, Some(_)) => "segment".to_owned(),
        (None, None) if segments.len() > 1 => "stretch of the log".to_owned(),
        (None, None) => "part of the log".to_owned(),
    };
    let measured = LogCase {
        file: table.at_file(),
        lines: (0..table.n_rows()).map(|row| table.line(row)).collect(),
        head,
        impedance: settings.impedance.as_ref().map(Into::into),
        samples,
        options: LogOptions { formula, sigma_n, segments },
        unnamed,
        plan: settings.plan,
        covariates: extras.covariates,
        groups,
        group_noun: noun,
    };
    Ok(Reading {
        measured: Box::new(measured),
        loop_settings: settings.closure,
        warnings,
        tables: vec![LOG],
    })
}

fn noise_warning(sigma_n: Option<f64>, has_reference: bool) -> Vec<String> {
    let mut warnings = Vec::new();
    if sigma_n.is_none() {
        warnings.push(
            "no `[noise] force_n`: the standard uncertainty is estimated from the residual"
                .to_owned(),
        );
    }
    if !has_reference {
        warnings.push(
            "no column `reference_n`: nothing says what the contact force was, so only the \
             agreement of the four lengths is judged (mm); zeros and gains of the load cells, the \
             head's weight, friction, drift and delay cannot be seen"
                .to_owned(),
        );
    }
    warnings
}

impl From<&ImpedanceSettings> for ImpedanceParameters {
    fn from(s: &ImpedanceSettings) -> Self {
        Self {
            mass_kg: s.mass_kg.0,
            damping_ns_per_mm: s.damping_ns_per_mm.0,
            stiffness_n_per_mm: s.stiffness_n_per_mm.map_or(0.0, |k| k.0),
        }
    }
}

fn head(s: &HeadSettings, document: &Document) -> Result<Head, Error> {
    let angles = s.leg_angles_deg.map_or(LEG_ANGLES_DEG, |a| a.map(|Finite(a)| a));
    let [x, y, z] = s.gravity.map_or([0.0, 0.0, -1.0], |g| g.map(|Finite(g)| g));
    let gravity = Unit::try_new(Vector3::new(x, y, z), LENGTH_TOL).ok_or_else(|| {
        let message = "`[head] gravity` must not be the zero vector; it points down in the Y frame";
        Error::case(document.at_file(), Problem::WrongValue { message: message.to_owned() })
    })?;
    let weight_n = s.weight_n.map_or(0.0, |Finite(w)| w);
    if weight_n != 0.0 && s.center_of_gravity_mm.is_none() {
        let purpose = "a head with weight has a centre of gravity";
        let key = "[head] center_of_gravity_mm".to_owned();
        return Err(Error::case(document.at_file(), Problem::MissingKey { key, purpose }));
    }
    let geometry = HeadGeometry {
        tip_to_plane_mm: s.tip_to_plane_mm.0,
        plane_to_joint_mm: s.plane_to_joint_mm.0,
        head_radius_mm: s.head_radius_mm.0,
        bracket_radius_mm: s.bracket_radius_mm.0,
        leg_angles_rad: angles.map(f64::to_radians),
        weight_n,
        // Without a declared place, a missing weight is looked for in the plane of the legs.
        center_of_gravity_mm: s.center_of_gravity_mm.map_or(s.plane_to_joint_mm.0, |Finite(c)| c),
        gravity_direction: *gravity,
    };
    let source = match Head::new(geometry, HeadLimits::wide(&geometry)) {
        Ok(head) => return Ok(head),
        Err(source) => source,
    };
    Err(Error::ForceImpedance { at: Box::new(document.at_file()), source: Box::new(source) })
}

/// Names of the stretches of a log, and the stretch of each row; a new group is a new stretch.
fn segments(
    names: Option<&[&str]>,
    groups: Option<&[String]>,
    stretches: &[usize],
    table: &Table,
) -> (Vec<String>, Vec<usize>) {
    let key = |row: usize| {
        let stretch = stretches.get(row);
        (names.map(|n| n[row]), groups.map(|g| g[row].as_str()), stretch)
    };
    let mut labels: Vec<String> = Vec::new();
    let mut of_row: Vec<usize> = Vec::with_capacity(table.n_rows());
    for row in 0..table.n_rows() {
        if row == 0 || key(row) != key(row - 1) {
            labels.push(match key(row) {
                (_, Some(name), _) | (Some(name), None, _) => name.to_owned(),
                (None, None, Some(stretch)) => format!("stretch {}", stretch + 1),
                (None, None, None) => "log".to_owned(),
            });
        }
        of_row.push(labels.len() - 1);
    }
    (labels, of_row)
}

/// Which stretch between two pauses each sample belongs to; empty where nobody paused.
fn stretches(time_s: &[f64]) -> Vec<usize> {
    let mut steps: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_by(f64::total_cmp);
    let Some(median_s) = steps.get(steps.len() / 2) else { return Vec::new() };
    let longest_s = PAUSE * median_s;
    let mut stretch = 0;
    let of_sample = (0..time_s.len()).map(|i| {
        stretch += usize::from(i > 0 && time_s[i] - time_s[i - 1] > longest_s);
        stretch
    });
    let of_sample: Vec<usize> = of_sample.collect();
    if stretch > 0 { of_sample } else { Vec::new() }
}

fn samples(
    table: &Table,
    columns: &mut Columns<'_>,
    (time_s, of_row): (&[f64], &[usize]),
) -> Result<Vec<LogSample>, Error> {
    let four = |columns: &mut Columns<'_>, names: [&'static str; 4]| {
        names.into_iter().map(|name| columns.numbers(name)).collect::<Result<Vec<_>, _>>()
    };
    let lengths_mm = four(columns, LENGTHS)?;
    let cells_n = four(columns, CELLS)?;
    let (nx, ny, nz) = (columns.numbers("nx")?, columns.numbers("ny")?, columns.numbers("nz")?);
    let reference_n =
        if columns.has("reference_n") { Some(columns.numbers("reference_n")?) } else { None };
    let sample = |row: usize| {
        let normal = Vector3::new(nx[row], ny[row], nz[row]);
        let length = normal.norm();
        if (length - 1.0).abs() > LENGTH_TOL {
            let message = format!("(nx, ny, nz) has length {length:.4}, expected a unit vector");
            return Err(Error::case(table.at_row(row), Problem::WrongValue { message }));
        }
        Ok(LogSample {
            time_s: time_s[row],
            lengths_mm: std::array::from_fn(|i| lengths_mm[i][row]),
            cells_n: std::array::from_fn(|i| cells_n[i][row]),
            normal: Unit::new_normalize(normal),
            reference_n: reference_n.as_ref().map(|r| r[row]),
            segment: of_row[row],
        })
    };
    (0..table.n_rows()).map(sample).collect()
}

#[cfg(test)]
mod tests {
    use super::stretches;

    #[test]
    fn a_pause_begins_a_stretch_and_a_lost_sample_does_not() {
        assert_eq!(stretches(&[0.0, 0.1, 0.2, 0.5, 0.6, 1.6, 1.7]), [0, 0, 0, 0, 0, 1, 1]);
    }

    #[test]
    fn a_log_without_pauses_has_no_stretches() {
        assert!(stretches(&[0.0, 0.1, 0.2, 0.31]).is_empty());
        assert!(stretches(&[0.0]).is_empty() && stretches(&[]).is_empty());
    }
}
