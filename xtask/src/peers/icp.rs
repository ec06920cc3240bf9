//! Registration of clouds, in turn with `Open3D`, `small_gicp` and `threecrate` on the same files.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use super::icp_contest::{Contest, Contestant, ONCE, USUAL};
use super::{build_outside, icp_page, solver, text};
use crate::shell;

/// What is registered; see `xtask/peers/icp/problems.py`.
const PROBLEMS: [&str; 3] = ["100k", "1m", "scan"];

/// Peers whose registration of a million points takes minutes are asked for one.
const SLOW: [&str; 2] = ["small_gicp-plane", "small_gicp-gicp"];

/// Peers that Python packages bring.
const PYTHON_PEERS: [&str; 3] = ["open3d-plane", "small_gicp-plane", "small_gicp-gicp"];

/// Prepares peers and problems, lets them run in turn, and writes `docs/benchmarks-icp.md`.
pub(super) fn run() -> Result<()> {
    let sources = shell::root().join("xtask/peers/icp");
    let work = shell::root().join("target/peers/icp");
    fs::create_dir_all(&work)?;
    let ours = build_ours(&sources, &work)?;
    let python = python(&sources, &work)?;
    let mut contest = Contest::default();
    for problem in PROBLEMS {
        let folder = work.join(problem);
        write_problem(&python, &sources, problem, &folder)?;
        for threads in [1, 2] {
            let mut contestants = vec![Contestant::new("pose-icp", &ours, &[])];
            let threecrate = ours.with_file_name("threecrate_plane");
            contestants.push(Contestant::new("threecrate-plane", &threecrate, &[]));
            let script = sources.join("python_peers.py");
            let mut slow = Vec::new();
            for peer in PYTHON_PEERS {
                let is_slow = problem == "1m" && SLOW.contains(&peer);
                let list = if is_slow { &mut slow } else { &mut contestants };
                list.push(Contestant::new(peer, &python, &[text(&script)?, peer]));
            }
            contest.hold(problem, &folder, threads, &contestants, USUAL)?;
            if threads == 2 {
                contest.hold(problem, &folder, threads, &slow, ONCE)?;
            }
        }
    }
    let folder = work.join("basin");
    write_problem(&python, &sources, "basin", &folder)?;
    contest.basin(
        &Contestant::new("pose-icp", &ours.with_file_name("ours_basin"), &[]),
        &folder,
        &[],
    )?;
    let script = sources.join("python_peers.py");
    for peer in ["open3d-plane", "small_gicp-gicp"] {
        let contestant = Contestant::new(peer, &python, &[text(&script)?, peer]);
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
    let target = work.join("build");
    build_outside(&sources.join("rust/Cargo.toml"), &target)?;
    Ok(target.join("release/ours"))
}

/// A Python that has the peers.
fn python(sources: &Path, work: &Path) -> Result<PathBuf> {
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
