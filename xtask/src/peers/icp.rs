//! Registration of clouds, in turn with `Open3D`, `small_gicp` and `threecrate` on the same files.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use super::icp_contest::{Contest, Contestant};
use super::{build_outside, icp_page, overridden, solver, text};
use crate::shell;

/// What is registered; see `xtask/peers/icp/problems.py`.
struct Problem {
    name: &'static str,
    /// Beyond which pairs do not count for peers: one that half an overlap needs, and that the start is
    /// within where all of the source has a partner.
    distance_mm: &'static str,
    /// Step at which a search is over for whom that can be said: far below the error that noise leaves.
    step_mm: &'static str,
    /// Peers that need minutes on it as packaged.
    left_out: &'static [&'static str],
}

const PROBLEMS: [Problem; 3] = [
    Problem { name: "100k", distance_mm: "5", step_mm: "1e-4", left_out: &[] },
    Problem { name: "1m", distance_mm: "5", step_mm: "1e-4", left_out: SLOW },
    Problem { name: "scan", distance_mm: "1", step_mm: "1e-3", left_out: SLOW },
];

/// As packaged, one does not converge and the other takes thirty times as long as the corrected one.
const SLOW: &[&str] = &["small_gicp-plane", "small_gicp-gicp"];

/// Seeds of further drawings of the scan: its error is one of chance.
const DRAWINGS: std::ops::RangeInclusive<u32> = 301..=312;

/// Beyond the size of the face: all pairs count.
const ANY_DISTANCE: &str = "1000";

/// Peers that Python packages bring.
const PYTHON_PEERS: [&str; 3] = ["open3d-plane", "small_gicp-plane", "small_gicp-gicp"];

/// The peer whose factor is put right.
const CORRECTED: &str = "small_gicp-plane, factor corrected";

/// Prepares peers and problems, lets them run in turn, and writes `docs/benchmarks-icp.md`.
pub(super) fn run() -> Result<()> {
    let sources = shell::root().join("xtask/peers/icp");
    let work = shell::root().join("target/peers/icp");
    fs::create_dir_all(&work)?;
    let ours = build_ours(&sources, &work)?;
    let python = python(&sources, &work)?;
    let corrected = build_small_gicp(&python, &sources, &work)?;
    let script = sources.join("python_peers.py");
    let threecrate = ours.with_file_name("threecrate_plane");
    let mut contest = Contest::default();
    for Problem { name, distance_mm, step_mm, left_out } in PROBLEMS {
        let folder = work.join(name);
        write_problem(&python, &sources, name, &folder)?;
        for threads in [1, 2] {
            let mut contestants = vec![
                Contestant::new("pose-icp", &ours, &[]),
                Contestant::new("threecrate-plane", &threecrate, &[distance_mm]),
                Contestant::new(CORRECTED, &corrected, &[distance_mm, step_mm]),
            ];
            for peer in PYTHON_PEERS.into_iter().filter(|peer| !left_out.contains(peer)) {
                let arguments = [text(&script)?, peer, distance_mm];
                contestants.push(Contestant::new(peer, &python, &arguments));
            }
            contest.hold(name, &folder, threads, &contestants)?;
        }
    }
    let mut folders = Vec::new();
    for seed in DRAWINGS {
        let name = format!("scan-{seed}");
        folders.push(work.join(&name));
        write_problem(&python, &sources, &name, &work.join(&name))?;
    }
    let arguments = [text(&script)?, "open3d-plane", "1"];
    for contestant in [
        Contestant::new("pose-icp", &ours, &[]),
        Contestant::new(CORRECTED, &corrected, &["1", "1e-3"]),
        Contestant::new("open3d-plane", &python, &arguments),
    ] {
        contest.drawings(&contestant, &folders)?;
    }
    let folder = work.join("basin");
    write_problem(&python, &sources, "basin", &folder)?;
    contest.basin(
        &Contestant::new("pose-icp", &ours.with_file_name("ours_basin"), &[]),
        &folder,
        &[],
    )?;
    for peer in ["open3d-plane", "small_gicp-gicp"] {
        let contestant = Contestant::new(peer, &python, &[text(&script)?, peer, ANY_DISTANCE]);
        contest.basin(&contestant, &folder, &["basin"])?;
    }
    poses(&python, &sources, &ours, &work, &mut contest)?;
    let page = shell::root().join("docs/benchmarks-icp.md");
    fs::write(&page, icp_page::page(&contest)).with_context(|| page.display().to_string())?;
    eprintln!("wrote {}", page.display());
    Ok(())
}

/// Nine touches of a mirror from further and further off.
fn poses(
    python: &Path,
    sources: &Path,
    ours: &Path,
    work: &Path,
    contest: &mut Contest,
) -> Result<()> {
    let folder = work.join("poses");
    if !folder.join("poses.bin").exists() {
        let script = sources.join("problems.py");
        checked(Command::new(python).arg(script).arg("poses").arg(&folder))?;
    }
    let program = ours.with_file_name("ours_poses");
    let ceres =
        solver::build_ceres("CERES_POSE", "xtask/peers/ceres/pose.cpp", &work.join("ceres-pose"))?;
    for (name, program, way) in [
        ("pose-icp", &program, Some("exact")),
        ("plain Gauss-Newton", &program, Some("gauss-newton")),
        ("Ceres, Levenberg-Marquardt", &ceres, None),
    ] {
        contest.poses(name, program, &folder, way)?;
    }
    Ok(())
}

fn write_problem(python: &Path, sources: &Path, problem: &str, folder: &Path) -> Result<()> {
    if folder.join("T_true.bin").exists() {
        return Ok(());
    }
    checked(Command::new(python).arg(sources.join("problems.py")).arg(problem).arg(folder))
}

/// Builds the programs that run pose-icp and threecrate.
fn build_ours(sources: &Path, work: &Path) -> Result<PathBuf> {
    if let Some(given) = overridden("POSE_ICP") {
        return Ok(given);
    }
    let target = work.join("build");
    build_outside(&sources.join("rust/Cargo.toml"), &target)?;
    Ok(target.join("release/ours"))
}

/// Compiles `small_gicp` from the source that its Python package comes with, with our factor.
fn build_small_gicp(python: &Path, sources: &Path, work: &Path) -> Result<PathBuf> {
    if let Some(given) = overridden("SMALL_GICP") {
        return Ok(given);
    }
    let archive = work.join("small_gicp-1.0.1.tar.gz");
    if !archive.exists() {
        let download =
            ["-m", "pip", "download", "--quiet", "--no-deps", "--no-binary", "small_gicp"];
        checked(
            Command::new(python).args(download).arg("small_gicp==1.0.1").arg("--dest").arg(work),
        )?;
    }
    checked(Command::new("tar").arg("-xzf").arg(&archive).arg("-C").arg(work))?;
    let program = work.join("small_gicp_plane");
    checked(
        Command::new("g++")
            .args(["-O3", "-DNDEBUG", "-march=native", "-std=c++17", "-fopenmp"])
            .arg("-I/usr/include/eigen3")
            .arg(format!("-I{}", work.join("small_gicp-1.0.1/include").display()))
            .arg(sources.join("small_gicp_plane.cpp"))
            .arg("-o")
            .arg(&program),
    )?;
    Ok(program)
}

/// A Python that has the peers.
fn python(sources: &Path, work: &Path) -> Result<PathBuf> {
    if let Some(given) = overridden("PYTHON") {
        return Ok(given);
    }
    let environment = work.join("python");
    let python = environment.join("bin/python");
    if !python.exists() {
        checked(Command::new("python3").args(["-m", "venv"]).arg(&environment))?;
    }
    let requirements = sources.join("requirements.txt");
    let install = ["-m", "pip", "install", "--quiet", "--requirement"];
    checked(Command::new(&python).args(install).arg(requirements)).context(
        "the packages of Open3D and small_gicp are built for some versions of Python only",
    )?;
    Ok(python)
}

fn checked(command: &mut Command) -> Result<()> {
    eprintln!("── {command:?}");
    let status = command.status().with_context(|| format!("cannot start {command:?}"))?;
    ensure!(status.success(), "{command:?} failed ({status})");
    Ok(())
}
