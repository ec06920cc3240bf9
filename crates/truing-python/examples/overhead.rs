//! The Rust half of `overhead.py`: reads what that wrote into a folder, and times calls when told.
//!
//! `overhead CALL FOLDER`; every line on the standard input is a number of repetitions, and is
//! answered by as many times in seconds. Records are made before; results are dropped within, as
//! Python drops those of the call before.

use std::error::Error;
use std::hint::black_box;
use std::io::{BufRead, Write};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use nalgebra::{Isometry3, Point3, SVector, Unit, Vector3};
use truing::force_impedance::{ForceFormula, Head, HeadGeometry, HeadLimits, LogSample, solve_log};
use truing::frame_fit::{Options, PointPair, Transform, Uncertainty, fit_frame};
use truing::ft_center::{WrenchArrays, solve_batch};
use truing::geometry::{Asphere, AsphereShape};
use truing::pose_icp::{CloudTarget, PointCloud, RegisterOptions, register_to_cloud};
use truing::probe_comp::{BallTouch, Nominal, NormalSource, Side, compensate};

type Failure = Box<dyn Error>;

pub(crate) fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [call, folder] = &arguments[..] else { return Err("overhead CALL FOLDER".into()) };
    let given = Given(Path::new(folder));
    match call.as_str() {
        "locate-contact" => locate_contact(&given),
        "compensate" => compensated(&given),
        "register" => registered(&given),
        "contact-force" => contact_force(&given),
        transform => fitted(&given, transform),
    }
}

/// Arrays of a folder, one file each, as they lie in memory.
struct Given<'a>(&'a Path);

impl Given<'_> {
    fn numbers(&self, name: &str) -> Result<Vec<f64>, Failure> {
        let bytes = std::fs::read(self.0.join(name))?;
        Ok(bytes.as_chunks().0.iter().map(|number| f64::from_ne_bytes(*number)).collect())
    }

    fn rows<const D: usize>(&self, name: &str) -> Result<Vec<[f64; D]>, Failure> {
        Ok(self.numbers(name)?.as_chunks::<D>().0.to_vec())
    }

    fn points(&self, name: &str) -> Result<Vec<Point3<f64>>, Failure> {
        Ok(self.rows::<3>(name)?.into_iter().map(Point3::from).collect())
    }
}

/// Answers every line until there are no more.
fn timed<T>(call: impl Fn() -> T) -> Result<(), Failure> {
    for line in std::io::stdin().lock().lines() {
        let mut out = std::io::stdout().lock();
        for _ in 0..line?.trim().parse()? {
            let started = Instant::now();
            drop(black_box(call()));
            writeln!(out, "{}", started.elapsed().as_secs_f64())?;
        }
        out.flush()?;
    }
    Ok(())
}

fn fitted(given: &Given<'_>, transform: &str) -> Result<(), Failure> {
    let (to, std_mm) = (given.points("to_mm")?, given.numbers("std_mm")?);
    let pairs: Vec<PointPair<3>> = (given.points("from_mm")?.into_iter().zip(to).enumerate())
        .map(|(i, (source_mm, target_mm))| PointPair {
            target_mm,
            source_mm,
            uncertainty: match std_mm[..] {
                [sigma_mm] => Uncertainty::Isotropic { sigma_mm },
                ref all => Uncertainty::PerAxis {
                    sigma_mm: SVector::from_column_slice(&all[3 * i..3 * i + 3]),
                },
            },
        })
        .collect();
    let named = Transform::ALL.into_iter().find(|t| t.to_string() == transform);
    let options = Options::of(named.ok_or("no such transform")?);
    timed(|| fit_frame(black_box(&pairs), &options))
}

fn locate_contact(given: &Given<'_>) -> Result<(), Failure> {
    let all = given.numbers("wrenches")?;
    let of = |k: usize| &all[k * all.len() / 6..(k + 1) * all.len() / 6];
    let arrays = WrenchArrays {
        fx_n: of(0),
        fy_n: of(1),
        fz_n: of(2),
        mx_nmm: of(3),
        my_nmm: of(4),
        mz_nmm: of(5),
    };
    timed(|| solve_batch(black_box(&arrays), 30.0, 5.0))
}

fn compensated(given: &Given<'_>) -> Result<(), Failure> {
    let shape = AsphereShape::on_axis(480.0, -1.0, Vec::new(), 320.0);
    let nominal = Nominal::new(Arc::new(Asphere::new(shape)?), Side::Along);
    let touches: Vec<BallTouch> =
        given.points("centers_mm")?.into_iter().map(|at| BallTouch::new(at, 1e-3)).collect();
    timed(|| compensate(&nominal, 3.0, black_box(&touches), NormalSource::Nominal))
}

fn registered(given: &Given<'_>) -> Result<(), Failure> {
    let normals = given.points("normals")?.into_iter().map(|n| Unit::new_unchecked(n.coords));
    let target = PointCloud::with_normals(given.points("target_mm")?, normals.collect());
    let source = PointCloud::new(given.points("source_mm")?);
    let options = RegisterOptions { start: Isometry3::identity(), ..RegisterOptions::default() };
    timed(|| register_to_cloud(black_box(&source), &CloudTarget::new(&target)?, &options))
}

fn contact_force(given: &Given<'_>) -> Result<(), Failure> {
    let geometry = HeadGeometry {
        tip_to_plane_mm: 120.0,
        plane_to_joint_mm: 180.0,
        head_radius_mm: 40.0,
        bracket_radius_mm: 110.0,
        leg_angles_rad: [90.0_f64, 210.0, 330.0].map(f64::to_radians),
        weight_n: 60.0,
        center_of_gravity_mm: 150.0,
        gravity_direction: -Vector3::z(),
    };
    let head = Head::new(geometry, HeadLimits::wide(&geometry))?;
    let lengths = given.rows::<4>("lengths_mm")?;
    let readings = given.rows::<4>("cells_n")?.into_iter().zip(given.rows::<3>("normals")?);
    let samples: Vec<LogSample> = (lengths.into_iter().zip(readings).enumerate())
        .map(|(i, (lengths_mm, (cells_n, normal)))| LogSample {
            time_s: f64::from(u32::try_from(i).unwrap_or(u32::MAX)),
            lengths_mm,
            cells_n,
            normal: Unit::new_normalize(Vector3::from(normal)),
            reference_n: None,
            segment: 0,
        })
        .collect();
    timed(|| solve_log(&head, black_box(&samples), ForceFormula::FullBalance))
}
