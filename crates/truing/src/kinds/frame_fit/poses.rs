//! The tip of a tool from poses of the flange that hold it at fixed places.

use std::sync::Arc;

use frame_fit::{FrameFitError, KnownDistance, TipFit, TipModel, TipPose, fit_tip};
use model_discrepancy::{Closure, Covariate, Model};
use nalgebra::{DMatrix, Vector3};
use truing_report::Fact;

use super::settings::{COORDINATES, DISTANCES, ModelSettings, POSES, Settings};
use super::tip::{DistanceResidual, PlaceEstimate, PoseResidual, TipEstimates};
use crate::Error;
use crate::case::{
    ColumnKinds, Columns, Document, Folder, Location, NumberColumn, Positive, Problem, group_names,
};
use crate::estimates::Estimates;
use crate::kinds::orientation::orientations;
use crate::measured::{About, Fitted, Measured, Observation, Prepared, Reading, Words};
use crate::suspect::Yardstick;

const KNOWN: &[&str] =
    &["pose", "place", COORDINATES[0], COORDINATES[1], COORDINATES[2], "qw", "qx", "qy", "qz"];
const OF_DISTANCE: &[&str] = &["from", "to", "distance_mm", "std_mm"];

/// Standard uncertainties beyond which a known distance contradicts the poses: once in 16 000.
const CONTRADICTION: f64 = 4.0;

#[derive(Clone, Debug)]
struct PoseCase {
    file: Location,
    distances_file: Location,
    /// Line of each pose.
    lines: Vec<usize>,
    labels: Vec<String>,
    poses: Vec<TipPose>,
    distances: Vec<KnownDistance>,
    sigma_mm: Option<f64>,
    covariates: Vec<NumberColumn>,
    groups: Option<Vec<String>>,
    group_noun: String,
}

pub(super) fn read(
    folder: &Folder,
    document: &Document,
    settings: Settings,
) -> Result<Reading, Error> {
    let table = folder.table(POSES, KNOWN)?;
    let mut columns = Columns::new(&table, KNOWN);
    let places = columns.texts("place")?;
    let labels = if columns.has("pose") {
        columns.ids("pose")?.into_iter().map(str::to_owned).collect()
    } else {
        (0..places.len()).map(|row| format!("pose {}", row + 1)).collect()
    };
    let [x, y, z] = COORDINATES.map(|name| columns.numbers(name));
    let (x, y, z) = (x?, y?, z?);
    let rotations = orientations(&table, &mut columns)?;
    let extras = columns.rest(&settings.closure.columns)?;
    let poses = (places.iter().zip(rotations).enumerate())
        .map(|(row, (place, rotation))| TipPose {
            place: (*place).to_owned(),
            position_mm: Vector3::new(x[row], y[row], z[row]),
            rotation,
        })
        .collect();
    let mut warnings = extras.warnings;
    if settings.model != ModelSettings::default() {
        warnings.push(format!("`[model]` is not used with {POSES}"));
    }
    let sigma_mm = settings.noise.point_mm.map(|Positive(sigma)| sigma);
    if sigma_mm.is_none() {
        warnings.push(
            "no `[noise] point_mm`: the standard uncertainty is estimated from the residual"
                .to_owned(),
        );
    }
    let group = settings.closure.group.as_ref();
    let case = PoseCase {
        file: table.at_file(),
        distances_file: folder.location(DISTANCES),
        lines: (0..table.n_rows()).map(|row| table.line(row)).collect(),
        distances: distances(folder, &places)?,
        groups: group_names(group, &table, document)?,
        group_noun: group.map_or_else(|| "pose".to_owned(), |g| g.get_ref().clone()),
        labels,
        poses,
        sigma_mm,
        covariates: extras.covariates,
    };
    let measured: Box<dyn Measured> = Box::new(case);
    let tables = if folder.has(DISTANCES) { vec![POSES, DISTANCES] } else { vec![POSES] };
    Ok(Reading { measured, loop_settings: settings.closure, warnings, tables })
}

fn distances(folder: &Folder, places: &[&str]) -> Result<Vec<KnownDistance>, Error> {
    if !folder.has(DISTANCES) {
        return Ok(Vec::new());
    }
    let table = folder.table(DISTANCES, OF_DISTANCE)?;
    let mut columns = Columns::new(&table, OF_DISTANCE);
    let (from, to) = (columns.texts("from")?, columns.texts("to")?);
    let (distances_mm, stds_mm) = (columns.positives("distance_mm")?, columns.positives("std_mm")?);
    columns.rest(&ColumnKinds::default())?;
    for (row, name) in from.iter().zip(&to).enumerate().flat_map(|(i, (a, b))| [(i, a), (i, b)]) {
        if !places.contains(name) {
            let message = format!("no pose of {POSES} touches the place `{name}`");
            return Err(Error::case(table.at_row(row), Problem::WrongValue { message }));
        }
    }
    let known = |row: usize| KnownDistance {
        from: from[row].to_owned(),
        to: to[row].to_owned(),
        distance_mm: distances_mm[row],
        sigma_mm: stds_mm[row],
    };
    Ok((0..table.n_rows()).map(known).collect())
}

impl PoseCase {
    fn error(&self, source: FrameFitError) -> Error {
        let at = match source {
            FrameFitError::InvalidPose { index } if index < self.lines.len() => {
                self.file.clone().line(self.lines[index])
            }
            FrameFitError::InvalidDistance { .. } => self.distances_file.clone(),
            _ => self.file.clone(),
        };
        Error::FrameFit { at: Box::new(at), source }
    }

    fn estimates(
        &self,
        (tip_mm, places): (Vector3<f64>, &[(String, Vector3<f64>)]),
        covariance: &DMatrix<f64>,
        residual: impl Fn(usize, usize) -> f64,
    ) -> Arc<dyn Estimates> {
        let std = |i: usize| covariance[(i, i)].sqrt();
        let place = |(k, (name, at)): (usize, &(String, Vector3<f64>))| PlaceEstimate {
            place: name.clone(),
            x_mm: at.x,
            y_mm: at.y,
            z_mm: at.z,
            std_x_mm: std(3 + 3 * k),
            std_y_mm: std(4 + 3 * k),
            std_z_mm: std(5 + 3 * k),
        };
        let at = |name: &str| places.iter().find(|(n, _)| n == name).map(|(_, at)| *at);
        let distance = |known: &KnownDistance| {
            let found = at(&known.from).zip(at(&known.to)).map(|(a, b)| (a - b).norm());
            DistanceResidual {
                from: known.from.clone(),
                to: known.to.clone(),
                known_mm: known.distance_mm,
                found_mm: found.unwrap_or(f64::NAN),
            }
        };
        let pose = |(row, pose): (usize, &TipPose)| PoseResidual {
            pose: self.labels[row].clone(),
            place: pose.place.clone(),
            dx_mm: residual(row, 0),
            dy_mm: residual(row, 1),
            dz_mm: residual(row, 2),
        };
        Arc::new(TipEstimates {
            tip_mm: tip_mm.into(),
            std_tip_mm: [std(0), std(1), std(2)],
            places: places.iter().enumerate().map(place).collect(),
            distances: self.distances.iter().map(distance).collect(),
            poses: self.poses.iter().enumerate().map(pose).collect(),
        })
    }

    fn fit_tip(&self) -> Result<TipFit, Error> {
        fit_tip(&self.poses, &self.distances, self.sigma_mm).map_err(|e| self.error(e))
    }

    /// Known distances that the poses alone contradict.
    fn contradictions(&self, fit: &TipFit) -> Vec<String> {
        let Ok(alone) = fit_tip(&self.poses, &[], Some(fit.sigma_mm)) else { return Vec::new() };
        let index = |name: &str| alone.places.iter().position(|(n, _)| n == name);
        let contradiction = |known: &KnownDistance| {
            let (a, b) = (index(&known.from)?, index(&known.to)?);
            let apart = alone.places[a].1 - alone.places[b].1;
            let along = apart.try_normalize(0.0)?;
            let block = |i: usize, j: usize| {
                alone.covariance.fixed_view::<3, 3>(3 + 3 * i, 3 + 3 * j).into_owned()
            };
            let covariance = block(a, a) + block(b, b) - block(a, b) - block(b, a);
            let sigma_mm = (along.dot(&(covariance * along)).max(0.0)).sqrt().hypot(known.sigma_mm);
            let off_mm = apart.norm() - known.distance_mm;
            (off_mm.abs() > CONTRADICTION * sigma_mm).then(|| {
                format!(
                    "the poses alone put {} and {} {:.3} mm apart, {DISTANCES} says {} mm: {:.1} \
                     standard uncertainties; check the names of the places, or the machine's scale",
                    known.from,
                    known.to,
                    apart.norm(),
                    known.distance_mm,
                    off_mm.abs() / sigma_mm
                )
            })
        };
        self.distances.iter().filter_map(contradiction).collect()
    }

    fn prepared(&self, model: TipModel, covariates: Vec<Covariate>) -> Prepared<'_> {
        let model = Arc::new(model);
        let (of, at) = (Arc::clone(&model), Arc::clone(&model));
        let estimates = Box::new(move |closure: &Closure| {
            let (tip_mm, places) = of.at(&closure.state.base);
            let residual = |row: usize, axis: usize| closure.residuals_after[3 * row + axis];
            self.estimates((tip_mm, &places), &closure.covariance, residual)
        });
        let along = covariates.clone();
        let about: About<'_> = Box::new(move |found| {
            let there = at.about_found(&found.state);
            Ok(there.map(|there| self.prepared(there, along.clone())))
        });
        Prepared { model, covariates, estimates, about: Some(about) }
    }

    /// Recorded columns; known distances have the mean of each.
    fn recorded(&self, n_observations: usize) -> Vec<Covariate> {
        let padded = |c: &NumberColumn| {
            #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
            let mean = c.values.iter().sum::<f64>() / c.values.len() as f64;
            let mut values = c.values.clone();
            values.resize(n_observations, mean);
            c.with(values)
        };
        self.covariates.iter().map(padded).collect()
    }
}

impl Measured for PoseCase {
    fn fit(&self) -> Result<Fitted, Error> {
        let fit = self.fit_tip()?;
        let observations = (fit.residuals_mm.iter())
            .map(|r| Observation { residual: r.iter().copied().collect(), fitted: true })
            .collect();
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let chi2_per_dof = self.sigma_mm.map(|_| fit.chi2 / fit.degrees_of_freedom as f64);
        Ok(Fitted {
            estimates: self.estimates((fit.tip_mm, &fit.places), &fit.covariance, |row, axis| {
                fit.residuals_mm[row][axis]
            }),
            observations,
            unit: "mm",
            degrees_of_freedom: fit.degrees_of_freedom,
            chi2_per_dof,
            warnings: self.contradictions(&fit),
        })
    }

    fn prepare(&self) -> Result<Prepared<'_>, Error> {
        let per_pose = self.recorded(self.poses.len());
        let groups = self.groups.as_ref().unwrap_or(&self.labels);
        let concrete = TipModel::new(
            &self.poses,
            &self.labels,
            groups,
            &self.distances,
            self.sigma_mm,
            &per_pose,
        )
        .map_err(|e| self.error(e))?;
        let mut covariates = concrete.coordinates();
        covariates.extend(self.recorded(concrete.declared().layout.observations.len()));
        Ok(self.prepared(concrete, covariates))
    }

    fn yardstick(&self, _: &Fitted) -> Yardstick {
        super::suspects::pose_yardstick(&self.poses)
    }

    fn words(&self) -> Words {
        let sigma = self
            .sigma_mm
            .map_or_else(|| "estimated from the residual".to_owned(), |s| format!("{s} mm"));
        let fact = |name: &str, value: String| Fact { name: name.to_owned(), value };
        Words {
            declared: vec![
                "p + R·t = c: the tip t is fixed in the flange, every place c in the base; both are \
                 estimated."
                    .to_owned(),
            ],
            residual: "p + R·t − c",
            components: &["x", "y", "z"],
            group_noun: self.group_noun.clone(),
            measured: vec![
                fact("standard uncertainty", sigma),
                fact("known distances", self.distances.len().to_string()),
            ],
            places: None,
        }
    }
}
