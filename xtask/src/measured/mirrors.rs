//! SO LAT: the panels of two mirrors, touched with a tracker's ball on several days.
//!
//! The figure of a mirror belongs to the mirror, so what one session shows of it must hold in the
//! next: each session is closed by itself, and what it found is carried to the session after it.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};

use super::fiducials::Fiducials;
use super::photogrammetry::{LAT, LAT_LICENCE};
use super::readings::shots;
use super::{Case, Set};

/// Readings further than this from the first of a spot belong to the next one, mm.
const SPOT_MM: f64 = 10.0;
/// Spots of one panel, touched one after the other.
const SPOTS_PER_PANEL: usize = 5;
const BALL_MM: f64 = 19.05;
/// Length by which the published surfaces divide x and y.
const UNIT_MM: f64 = 3000.0;
const SURFACES: &str = "geometry/mirror_polynomials.txt";

pub(super) const SET: Set = Set {
    name: "lat-mirrors",
    source: LAT,
    licence: LAT_LICENCE,
    place: "so_lat_tracker",
    reference: "0.0928 mm, 0.0393 with focus and astigmatism learnt on another session",
    left_out: "session; panel for the pose",
    convert,
};

/// One mirror, and how its own frame lies in the optics' frame of the tables.
struct Mirror {
    name: &'static str,
    fiducials: &'static str,
    origin_mm: [f64; 3],
    /// Rotation about x.
    tilt_rad: f64,
    /// Side of the surface on which the ball is.
    side: &'static str,
    sessions: &'static [&'static str],
}

fn mirrors() -> [Mirror; 2] {
    [
        Mirror {
            name: "M1",
            fiducials: "primary",
            origin_mm: [0.0, 0.0, 3600.0],
            tilt_rad: -0.5_f64.atan(),
            side: "-z",
            sessions: &["M1_20250828", "M1_20250831_1", "M1_20250831_2"],
        },
        Mirror {
            name: "M2",
            fiducials: "secondary",
            origin_mm: [0.0, -4800.0, 0.0],
            tilt_rad: (1.0_f64 / 3.0).atan() - std::f64::consts::FRAC_PI_2,
            side: "+z",
            sessions: &["M2_20250824", "M2_20250828"],
        },
    ]
}

/// Every session by itself; every session but the first with what the one before it showed; and
/// the first mirror once with nothing known of where it lies.
fn convert(folder: &Path) -> Result<Vec<Case>> {
    let mut cases = Vec::new();
    for mirror in &mirrors() {
        let surface = surface(&folder.join(SURFACES), mirror.name)?;
        let mut before: Option<&str> = None;
        for &session in mirror.sessions {
            let place = folder.join(format!("surface_{session}"));
            let (table, mut notes) = spots(&place, mirror)?;
            notes.push(Fiducials::read(folder, &place, mirror.fiducials)?.words(|p| mirror.own(p)));
            let case = |name: String, pose: &str| Case {
                name,
                settings: settings(mirror, &surface, pose),
                tables: vec![("points.csv", table.clone())],
                notes: notes.clone(),
                carry: None,
            };
            cases.push(case(session.to_owned(), KNOWN));
            if let Some(earlier) = before {
                let name = format!("{session}-after-{earlier}");
                cases.push(Case { carry: Some(earlier.to_owned()), ..case(name, KNOWN) });
            } else if mirror.name == "M1" {
                cases.push(case(format!("{session}-anywhere"), ANYWHERE));
            }
            before = Some(session);
        }
    }
    Ok(cases)
}

/// The tables are in the frame of the fiducials.
const KNOWN: &str = "gamma_deg = 0.0\nknown = [\"x\", \"y\", \"gamma\"]   # by the fiducials\n";
/// All six are asked for where nothing is said.
const ANYWHERE: &str = "";

fn settings(mirror: &Mirror, surface: &str, pose: &str) -> String {
    let side = mirror.side;
    format!(
        "kind = \"pose-icp\"\n\n[surface]\nshape = \"polynomial\"\nunit_mm = {UNIT_MM:.1}\n\
         terms = [{surface}]\n\n[pose]\n{pose}initial = {{ x_mm = 0.0, y_mm = 0.0, z_mm = 0.0 }}\n\n\
         [probe]\ntip_radius_mm = {BALL_MM}\nside = \"{side}\"\n\n[machine]\naxes = false\n\n[loop]\ngroup = \"panel\"\n"
    )
}

/// Terms of the published surface: lines of name, i, j, coefficient.
fn surface(path: &Path, mirror: &str) -> Result<String> {
    let text =
        fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let term = |line: &str| {
        let cells: Vec<&str> = line.split_whitespace().collect();
        let [name, i, j, a] = cells[..] else { return None };
        (name == mirror).then(|| format!("[{i}, {j}, {a}]"))
    };
    let terms: Vec<String> = text.lines().filter_map(term).collect();
    ensure!(!terms.is_empty(), "{} has no surface of {mirror}", path.display());
    Ok(terms.join(", "))
}

/// The table of one session, a row per spot, in the mirror's own frame.
fn spots(place: &Path, mirror: &Mirror) -> Result<(String, Vec<String>)> {
    let mut table = "point,x_mm,y_mm,z_mm,panel,section\n".to_owned();
    let (mut n_spots, mut n_readings, mut uneven, mut dropped) = (0, 0, 0, 0);
    let mut squares_mm2 = 0.0;
    for section in 1..=5 {
        let (readings, bad) = shots(&place.join(format!("{}_{section}.txt", mirror.name)))?;
        dropped += bad;
        n_readings += readings.len();
        let mut spots: Vec<Vec<[f64; 3]>> = Vec::new();
        for reading in readings {
            match spots.last_mut().filter(|spot| distance(spot[0], reading.at_mm) < SPOT_MM) {
                Some(spot) => spot.push(reading.at_mm),
                None => spots.push(vec![reading.at_mm]),
            }
        }
        uneven += spots.iter().filter(|spot| spot.len() != 3).count();
        for (index, spot) in spots.iter().enumerate() {
            // The mean of points of a flat piece is on it; medians of coordinates are not.
            #[expect(clippy::cast_precision_loss, reason = "a few readings")]
            let n = spot.len() as f64;
            let middle: [f64; 3] =
                std::array::from_fn(|k| spot.iter().map(|at| at[k]).sum::<f64>() / n);
            squares_mm2 += spot.iter().map(|at| distance(*at, middle).powi(2)).sum::<f64>();
            let [x, y, z] = mirror.own(middle);
            let panel = index / SPOTS_PER_PANEL + 1;
            // A string takes every character.
            let _ = writeln!(
                table,
                "{section}_{index},{x:.5},{y:.5},{z:.5},{section}p{panel:02},s{section}"
            );
        }
        n_spots += spots.len();
    }
    #[expect(clippy::cast_precision_loss, reason = "some thousand readings")]
    let scatter_mm = (squares_mm2 / n_readings.max(1) as f64).sqrt();
    let notes = vec![
        format!(
            "{n_spots} spots, means of {n_readings} readings; {uneven} spots not of three; \
             {dropped} rows not enabled or unreadable"
        ),
        format!("readings scatter about their spot by {scatter_mm:.4} mm rms"),
    ];
    Ok((table, notes))
}

impl Mirror {
    /// A point of the optics' frame in that of the mirror.
    fn own(&self, p: [f64; 3]) -> [f64; 3] {
        let [x, y, z]: [f64; 3] = std::array::from_fn(|k| p[k] - self.origin_mm[k]);
        let (sin, cos) = self.tilt_rad.sin_cos();
        [x, cos * y + sin * z, cos * z - sin * y]
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}
