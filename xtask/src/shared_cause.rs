//! `cargo xtask bench machine`: cases of several kinds that were measured on one machine, alone and
//! together.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use serde_json::Value;

use crate::kinds::frame_fit::survey::{self, Defect, Survey};
use crate::kinds::pose_icp::mirror::{self, Mirror};
use crate::kinds::positioning::axis_run::{AxisRun, Fault};
use crate::kinds::probe_comp::probe::{self, Session};
use crate::kinds::probe_comp::probe_tables::{case_toml, touches_csv};
use crate::page::Block;
use crate::program::{Truing, label_of, strings, write_case};
use crate::shell;

/// How much to run.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Machines per situation.
    #[arg(long, default_value_t = 100)]
    machines: u64,
    /// Only situations whose name contains this; writes no page.
    #[arg(long)]
    only: Option<String>,
    /// A built program, in place of building one.
    #[arg(long)]
    program: Option<PathBuf>,
}

const BLOCK: Block =
    Block { bench: "machine", part: None, heading: "## Cases of one machine, taken together" };

/// The first seed, far from those of the other benches.
const FIRST_SEED: u64 = 1_310_000_000;
/// Distance between the first seeds of situations.
const SEEDS_APART: u64 = 10_000;
/// Distance between the seeds of the cases of one machine.
const CASES_APART: u64 = 1_000_000;

/// What is wrong with a machine.
#[derive(Clone, Copy, Debug)]
enum Cause {
    Nothing,
    /// The x axis reads long, ratio.
    Scale(f64),
    /// The same, and a laser measured it along x as well.
    ScaleByLaser(f64),
    /// x and y are not square, rad.
    Square(f64),
    /// Not the machine: the conic of the mirror.
    Conic(f64),
}

/// A machine with such a cause, and what is to be named as the machine's.
struct Situation {
    name: &'static str,
    cause: Cause,
    named: Option<&'static str>,
}

const SITUATIONS: [Situation; 5] = [
    Situation { name: "nothing", cause: Cause::Nothing, named: None },
    Situation {
        name: "x reads long by 14 ppm",
        cause: Cause::Scale(14e-6),
        named: Some("axis-scale [machine, x]"),
    },
    Situation {
        name: "x reads long by 9 ppm, sent along a laser as well",
        cause: Cause::ScaleByLaser(9e-6),
        named: Some("axis-scale [machine, x]"),
    },
    Situation {
        name: "x and y out of square by 30 µrad",
        cause: Cause::Square(30e-6),
        named: Some("squareness [machine]"),
    },
    Situation {
        name: "conic of the mirror 0.04 too large, the machine sound",
        cause: Cause::Conic(0.04),
        named: None,
    },
];

/// What the machines of a situation gave.
#[derive(Debug, Default)]
struct Tally {
    machines: u64,
    cases: u64,
    /// Those whose own loop names the cause.
    alone: u64,
    /// Machines whose answer names what it should, and nothing else, as the machine's.
    right: u64,
    /// Machines of which something else is named.
    wrong: u64,
    /// Amplitudes within k = 2 of the truth, and all.
    covered: [u64; 2],
    /// Mean squares on unseen data of all cases: before, by what the others found, after.
    squares: [f64; 3],
    judged: u64,
}

/// Runs the situations and writes the page.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let truing = Truing::given(arguments.program.as_deref())?;
    let folder = shell::scratch("machine")?;
    let mut table = String::from(
        ". A mirror, a sphere under a touch probe and points of a laser tracker, each measured on one \
         machine; in every\nsituation the tables are of the physics, and each case is too weak to show \
         the cause in most of them.\n\n\
         | the machine | cases that name it alone | named with all data, and nothing else of the \
         machine | something else named | size within U (k = 2) | error on unseen data, with the cause \
         as the *other* cases have it |\n|---|---|---|---|---|---|\n",
    );
    for (index, situation) in (0..).zip(&SITUATIONS) {
        if arguments.only.as_ref().is_some_and(|part| !situation.name.contains(part.as_str())) {
            continue;
        }
        let mut tally = Tally::default();
        let first = FIRST_SEED + index * SEEDS_APART;
        for seed in first..first + arguments.machines {
            one(&truing, situation, seed, folder.path(), &mut tally)?;
        }
        let line = line(situation, &tally);
        println!("{line}");
        let _ = writeln!(table, "{line}");
    }
    if arguments.only.is_none() { BLOCK.write(&table) } else { Ok(()) }
}

fn one(
    truing: &Truing,
    situation: &Situation,
    seed: u64,
    folder: &Path,
    tally: &mut Tally,
) -> Result<()> {
    write_machine(situation.cause, seed, folder)?;
    let path = folder.to_str().context("a folder in UTF-8")?;
    let answer = truing.run(&["loop", path, "--json", "--threads", "1"])?;
    anyhow::ensure!(answer.code == Some(0), "seed {seed}: {}", answer.message);
    let steps = answer.json["steps"].as_array().context("no steps")?;
    let labels: Vec<String> = steps.iter().filter_map(label_of).collect();
    let is_right = labels.iter().map(String::as_str).eq(situation.named);
    tally.machines += 1;
    tally.right += u64::from(is_right);
    tally.wrong += u64::from(labels.iter().any(|l| Some(l.as_str()) != situation.named));
    for case in answer.json["cases"].as_array().context("no cases")? {
        tally.cases += 1;
        tally.alone += u64::from(names_alone(case, situation.cause));
        let error = |key: &str| case[key]["held_out_rms"].as_f64();
        if let Some(by_others) = error("with_others") {
            let all = [error("before").context("no error")?, by_others];
            let after = error("after").context("no error")?;
            // In units of the case's own, so that each counts alike.
            for (sum, value) in tally.squares.iter_mut().zip([all[0], all[1], after]) {
                *sum += (value / all[0]).powi(2);
            }
            tally.judged += 1;
        }
    }
    for step in steps.iter().filter(|_| is_right) {
        let truth = match situation.cause {
            Cause::Scale(ratio) | Cause::ScaleByLaser(ratio) => [ratio * 1e6, 0.0, 0.0],
            Cause::Square(rad) => [rad * 1e6, 0.0, 0.0],
            Cause::Nothing | Cause::Conic(_) => [0.0; 3],
        };
        for (found, truth) in step["parameters"].as_array().into_iter().flatten().zip(truth) {
            let number = |key: &str| found[key].as_f64().context("no number");
            let is_within = (number("value")? - truth).abs() <= 2.0 * number("std")?;
            tally.covered[0] += u64::from(is_within);
            tally.covered[1] += 1;
        }
    }
    Ok(())
}

fn names_alone(case: &Value, cause: Cause) -> bool {
    let ids: &[&str] = match cause {
        Cause::Nothing => &[],
        Cause::Scale(_) | Cause::ScaleByLaser(_) => {
            &["axis-scale", "anisotropic-scale", "pitch-error"]
        }
        Cause::Square(_) => &["squareness", "shear"],
        Cause::Conic(_) => &["conic"],
    };
    strings(&case["named_alone"], None).iter().any(|name| ids.iter().any(|id| name.starts_with(id)))
}

#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
fn line(situation: &Situation, tally: &Tally) -> String {
    let Tally { machines, cases, alone, right, wrong, covered, squares, judged } = tally;
    let rms = |k: usize| (squares[k] / *judged as f64).sqrt();
    let error = if *judged > 0 {
        format!("{:.2} of before ({:.2} with all)", rms(1), rms(2))
    } else {
        "–".to_owned()
    };
    let sizes =
        if covered[1] > 0 { format!("{} of {}", covered[0], covered[1]) } else { "–".to_owned() };
    format!(
        "| {} | {alone} of {cases} | {right} of {machines} | {wrong} | {sizes} | {error} |",
        situation.name,
    )
}

/// The machine's file and its three cases.
fn write_machine(cause: Cause, seed: u64, folder: &Path) -> Result<()> {
    if folder.exists() {
        fs::remove_dir_all(folder).context("the machine before")?;
    }
    let (scale, square) = match cause {
        Cause::Scale(ratio) | Cause::ScaleByLaser(ratio) => (Some([ratio, 0.0, 0.0]), None),
        Cause::Square(rad) => (None, Some([rad, 0.0, 0.0])),
        Cause::Nothing | Cause::Conic(_) => (None, None),
    };
    let flaw = match (cause, scale, square) {
        (Cause::Conic(conic), ..) => mirror::Flaw::Conic(conic),
        (_, Some(scale), _) => mirror::Flaw::MachineScale(scale),
        (_, _, Some(square)) => mirror::Flaw::Squareness(square),
        _ => mirror::Flaw::None,
    };
    let touched = mirror::simulate(&Mirror { flaw, ..Mirror::new(seed) });
    let mut files = vec![("case.toml", touched.case_toml), ("points.csv", touched.points_csv)];
    files.extend(touched.edge_csv.map(|edge| ("edge.csv", edge)));
    write_case(files, &folder.join("mirror"))?;

    let flaw = match (scale, square) {
        (Some(scale), _) => probe::Flaw::AxisScale(scale),
        (_, Some(square)) => probe::Flaw::Squareness(square),
        _ => probe::Flaw::None,
    };
    let shape = probe::Shape::Sphere { radius_mm: 60.0 };
    let session = Session { shape, flaw, ..Session::new(seed + CASES_APART) };
    let touches = touches_csv(&session, &probe::simulate(&session));
    let files = [("case.toml", case_toml(&session)), ("touches.csv", touches)];
    write_case(files, &folder.join("sphere"))?;

    // The machine's word comes first: what it reads long, the tracker reads short of it.
    let defect = match (scale, square) {
        (Some(scale), _) => Defect::AxisScale(scale.map(|s| 1.0 / (1.0 + s) - 1.0)),
        (_, Some(square)) => Defect::Squareness(square.map(|s| -s)),
        _ => Defect::None,
    };
    let surveyed = survey::simulate(&Survey { defect, ..Survey::new(seed + 2 * CASES_APART) });
    let files = [("case.toml", surveyed.case_toml), ("pairs.csv", surveyed.pairs_csv)];
    write_case(files, &folder.join("points"))?;

    let mut toml = String::from("name = \"mill\"\n");
    for name in ["mirror", "sphere", "points"] {
        let _ = write!(toml, "\n[[case]]\nfolder = \"{name}\"\n");
    }
    if let Cause::ScaleByLaser(ratio) = cause {
        let run = AxisRun { fault: Fault::Long(ratio), seed: seed + 3 * CASES_APART };
        write_case(run.files(&[], 0), &folder.join("along-x"))?;
        toml += "\n[[case]]\nfolder = \"along-x\"\naxis = \"x\"\n";
    }
    fs::write(folder.join("machine.toml"), toml).context("machine.toml")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schema::Schemas;

    /// Machines of which the axis is named in all that are tried: 20 of 20 at this size.
    const MACHINES: u64 = 3;

    fn answers(situation: &Situation, folder: &str) -> Vec<Value> {
        let truing = Truing::beside_the_tests().unwrap();
        let schemas = Schemas::read().unwrap();
        let folder = shell::root().join("target/machine-test").join(folder);
        let answer = |seed| {
            write_machine(situation.cause, seed, &folder).unwrap();
            let answer = truing.run(&["loop", folder.to_str().unwrap(), "--json"]).unwrap();
            assert_eq!(answer.code, Some(0), "{}", answer.message);
            assert_eq!(schemas.mismatches(&answer.json).unwrap(), Vec::<String>::new());
            answer.json
        };
        (FIRST_SEED..FIRST_SEED + MACHINES).map(answer).collect()
    }

    #[test]
    fn an_axis_that_reads_long_is_the_machines() {
        for json in answers(&SITUATIONS[1], "scale") {
            let labels: Vec<String> =
                json["steps"].as_array().unwrap().iter().filter_map(label_of).collect();
            assert_eq!(labels, ["axis-scale [machine, x]"]);
            assert_eq!(json["verdict"], "explained");
            assert_eq!(json["by_case"][0]["cases"].as_array().unwrap().len(), 3);
            assert_eq!(json["by_case"][0]["agreement"][0]["dof"], 2);
            // Three cases agree within chance of a thousandth.
            assert!(json["by_case"][0]["agreement"][0]["p_value"].as_f64().unwrap() > 1e-3);
        }
    }

    #[test]
    fn a_part_that_is_not_as_declared_is_not_the_machines() {
        for json in answers(&SITUATIONS[4], "conic") {
            assert_eq!(json["steps"], Value::Array(Vec::new()));
        }
    }
}
