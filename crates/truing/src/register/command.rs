use std::path::{Path, PathBuf};
use std::time::Instant;

use nalgebra::Isometry3;
use pose_icp::{
    CloudTarget, Holes, MeshTarget, Objective, PointCloud, RegisterError, RegisterOptions,
    Registration, Side, estimate_normals, find_start, register_to_cloud, register_to_mesh,
    sample_surface,
};

use super::answer::{RegisterTiming, Registered, pose_of};
use crate::shape::{Shape, read_given};
use crate::{Error, Header, InputFile};

/// Neighbours of a normal: two rings about a point.
const NEIGHBOURS: usize = 12;

/// Points taken from a mesh that is the source, at least one a face.
const SAMPLES: usize = 20_000;

/// How `truing register` goes about it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RegisterSettings {
    /// How to register.
    pub options: RegisterOptions,
    /// What to do about holes in a target mesh.
    pub holes: Holes,
    /// Whether nothing is known of the start, so that one is looked for; that of `options` does not
    /// count then.
    pub start_unknown: bool,
}

/// Registers a file onto another.
///
/// Normals that the objective needs and a cloud does not have are estimated from its neighbours.
///
/// # Errors
///
/// [`Error::NotRead`], [`Error::Shape`] and [`Error::Register`]. A search that runs out of passes is
/// an answer whose `converged` is false.
pub fn register(
    source: &Path,
    target: &Path,
    settings: &RegisterSettings,
) -> Result<Registered, Error> {
    let started = Instant::now();
    let ((from, source_file), (onto, target_file)) = (read_given(source)?, read_given(target)?);
    let read_s = started.elapsed().as_secs_f64();
    let blame = |error: RegisterError| Error::Register {
        path: PathBuf::from(if blames_target(&error) { target } else { source }),
        source: Box::new(error),
    };
    let inputs = vec![source_file, target_file];
    Job { settings, read_s, inputs }.run(&from, onto).map_err(blame)
}

fn blames_target(error: &RegisterError) -> bool {
    use RegisterError as E;
    match error {
        E::Empty { side }
        | E::InvalidPoint { side, .. }
        | E::NormalCount { side, .. }
        | E::InvalidNormal { side, .. }
        | E::TooManyPoints { side, .. }
        | E::MissingNormals { side }
        | E::NoPlane { side, .. }
        | E::NoSuchVertex { side, .. }
        | E::ZeroAreaFaces { side, .. } => *side == Side::Target,
        E::MeshHoles { .. } | E::Undetermined { .. } => true,
        _ => false,
    }
}

struct Job<'a> {
    settings: &'a RegisterSettings,
    read_s: f64,
    inputs: Vec<InputFile>,
}

impl Job<'_> {
    fn run(self, from: &Shape, onto: Shape) -> Result<Registered, RegisterError> {
        let started = Instant::now();
        let mut warnings = Vec::new();
        let is_symmetric = self.settings.options.objective == Objective::Symmetric;
        let source = match from {
            Shape::Cloud(cloud) if is_symmetric => {
                with_normals(cloud.clone(), Side::Source, &mut warnings)?
            }
            Shape::Cloud(cloud) => cloud.clone(),
            Shape::Mesh(mesh) => sample_surface(mesh, SAMPLES)?,
        };
        let mut options = self.settings.options.clone();
        let (found, build_s, align_s) = match onto {
            Shape::Cloud(cloud) => {
                let cloud = with_normals(cloud, Side::Target, &mut warnings)?;
                let target = CloudTarget::new(&cloud)?;
                let build_s = started.elapsed().as_secs_f64();
                if self.settings.start_unknown {
                    options.start = find_start(&source, &target, &options)?;
                }
                let found = register_to_cloud(&source, &target, &options);
                (found, build_s, started.elapsed().as_secs_f64() - build_s)
            }
            Shape::Mesh(mesh) => {
                let target = MeshTarget::new(&mesh, self.settings.holes)?;
                let build_s = started.elapsed().as_secs_f64();
                if self.settings.start_unknown {
                    let cloud = CloudTarget::new(&sample_surface(&mesh, SAMPLES)?)?;
                    options.start = find_start(&source, &cloud, &options)?;
                }
                let found = register_to_mesh(&source, &target, &options);
                (found, build_s, started.elapsed().as_secs_f64() - build_s)
            }
        };
        let timing = RegisterTiming { read_s: self.read_s, build_s, align_s };
        match found {
            Ok(found) => Ok(answer(&found, &source, true, timing, (self.inputs, warnings))),
            Err(error @ RegisterError::NotConverged { .. }) => {
                warnings.push(error.to_string());
                let RegisterError::NotConverged { best } = error else {
                    unreachable!("matched above")
                };
                Ok(answer(&best, &source, false, timing, (self.inputs, warnings)))
            }
            Err(error) => Err(error),
        }
    }
}

fn with_normals(
    mut cloud: PointCloud,
    side: Side,
    warnings: &mut Vec<String>,
) -> Result<PointCloud, RegisterError> {
    if cloud.normals.is_none() {
        cloud.check(side)?;
        let neighbours = NEIGHBOURS.min(cloud.points_mm.len());
        cloud.normals = Some(estimate_normals(&cloud.points_mm, neighbours, None, side)?);
        warnings
            .push(format!("normals of the {side} are estimated from {neighbours} neighbours each"));
    }
    Ok(cloud)
}

fn answer(
    found: &Registration,
    source: &PointCloud,
    converged: bool,
    timing: RegisterTiming,
    (inputs, warnings): (Vec<InputFile>, Vec<String>),
) -> Registered {
    let shape = found.observability.as_ref();
    Registered {
        version: env!("CARGO_PKG_VERSION"),
        header: Header::without_case("truing/register/1", inputs),
        pose: pose_of(found),
        matrix: rows(&found.target_from_source),
        rms_mm: found.rms_mm,
        sigma_mm: found.sigma_mm,
        points: source.points_mm.len(),
        used: found.used,
        iterations: found.iterations,
        converged,
        timing: Some(timing),
        weak_directions: shape
            .map_or_else(Vec::new, |shape| shape.weak.iter().map(ToString::to_string).collect()),
        singular_values: shape.map_or_else(Vec::new, |shape| shape.singular_values.clone()),
        warnings,
    }
}

fn rows(pose: &Isometry3<f64>) -> [[f64; 4]; 4] {
    let matrix = pose.to_homogeneous();
    std::array::from_fn(|row| std::array::from_fn(|column| matrix[(row, column)]))
}
