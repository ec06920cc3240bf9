//! `cargo xtask measured`: public measured data sets through `truing`, beside an
//! independent calculation.
//!
//! One file per set turns its data, as they were published, into case folders. Cases of sets whose
//! licence allows it are committed under `fixtures/`; [`shipped`] writes them. A set that is not in
//! the folder given is named with its source.

mod ball;
mod bearing;
mod elevation;
mod fiducials;
mod gravity;
mod jku;
mod mirrors;
mod photogrammetry;
mod readings;
mod sea_floor;
mod shipped;
mod spots;
mod stability;
mod summary;
mod wheel;

pub(crate) use shipped::folders;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use serde_json::Value;

use crate::program::Truing;
use crate::shell;

/// Closes the loop on public measured data.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Folder that holds the data sets, one folder each.
    #[arg(long)]
    data: PathBuf,
    /// Only sets whose name contains this.
    #[arg(long)]
    only: Option<String>,
    /// Writes the committed cases anew from the published files, and closes no loop.
    #[arg(long)]
    write_fixtures: bool,
}

/// A published data set.
pub(crate) struct Set {
    pub(crate) name: &'static str,
    /// Where it was published, with its version.
    pub(crate) source: &'static str,
    /// Terms under which it was published, and where their text is kept.
    pub(crate) licence: &'static str,
    /// Folder or file under the data folder.
    pub(crate) place: &'static str,
    /// Errors that an independent calculation reached on data its fit had not seen.
    pub(crate) reference: &'static str,
    /// What is left out together.
    pub(crate) left_out: &'static str,
    /// Turns the published files into cases.
    pub(crate) convert: fn(&Path) -> Result<Vec<Case>>,
}

/// A case folder to be written.
pub(crate) struct Case {
    pub(crate) name: String,
    pub(crate) settings: String,
    /// File name and content of each table.
    pub(crate) tables: Vec<(&'static str, String)>,
    /// What was dropped or converted on the way.
    pub(crate) notes: Vec<String>,
    /// An earlier case of the set, whose effects count as declared in this one.
    pub(crate) carry: Option<String>,
}

/// What the loop made of one case.
pub(crate) struct Outcome {
    pub(crate) case: String,
    pub(crate) notes: Vec<String>,
    pub(crate) answer: Value,
}

const SETS: &[Set] = &[
    photogrammetry::SET,
    stability::SET,
    bearing::SET,
    mirrors::SET,
    elevation::BY_TARGET,
    elevation::BY_STOP,
    spots::SET,
    wheel::SET,
    ball::SET,
    gravity::BY_POSE,
    gravity::BY_BLOCK,
    jku::SET,
];

/// Converts every set that is there, closes the loop on it and writes `target/measured`.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    if arguments.write_fixtures {
        return shipped::write(&arguments.data);
    }
    let wanted = |set: &&Set| arguments.only.as_ref().is_none_or(|only| set.name.contains(only));
    let truing = Truing::build()?;
    let folder = shell::root().join("target/measured");
    let mut pages = Vec::new();
    let mut found = Vec::new();
    for set in SETS.iter().filter(wanted) {
        let place = arguments.data.join(set.place);
        if !place.exists() {
            println!("{}: skipped, {} is not there; {}", set.name, place.display(), set.source);
            continue;
        }
        let cases =
            (set.convert)(&place).with_context(|| format!("{}: not converted", set.name))?;
        let mut outcomes = Vec::new();
        for case in cases {
            let written = write(&folder.join(set.name), &case, set)?;
            let page = written.with_extension("html");
            outcomes.push(close(&truing, &written, &page, case)?);
            pages.push(page);
        }
        summary::print(set, &outcomes);
        found.push((set, outcomes));
    }
    let is_wanted = arguments.only.as_ref().is_none_or(|only| "garpos-sea-floor".contains(only));
    let sea_floor = if is_wanted { sea_floor::run(&arguments.data)? } else { None };
    if found.is_empty() && sea_floor.is_none() {
        bail!("none of the data sets is in {}", arguments.data.display());
    }
    let text = summary::markdown(&found) + &sea_floor.unwrap_or_default();
    fs::create_dir_all(&folder).context("cannot make target/measured")?;
    fs::write(folder.join("summary.md"), text).context("cannot write the summary")?;
    if pages.is_empty() {
        return Ok(());
    }
    index(&truing, &folder, &pages)
}

/// Writes the folder of one case, anew.
fn write(folder: &Path, case: &Case, set: &Set) -> Result<PathBuf> {
    let place = folder.join(&case.name);
    if place.exists() {
        fs::remove_dir_all(&place)
            .with_context(|| format!("cannot replace {}", place.display()))?;
    }
    fs::create_dir_all(&place).with_context(|| format!("cannot make {}", place.display()))?;
    let provenance = toml::to_string(&toml::toml! {
        title = (format!("{}: {}", set.name, case.name))
        source = (set.source)
    })?;
    let files = case.tables.iter().map(|(name, text)| (*name, text.as_str()));
    let own = [("case.toml", case.settings.as_str()), ("provenance.toml", provenance.as_str())];
    for (name, text) in files.chain(own) {
        fs::write(place.join(name), text)
            .with_context(|| format!("cannot write {}", place.join(name).display()))?;
    }
    Ok(place)
}

/// Closes the loop on a case, and leaves its answer beside its folder.
fn close(truing: &Truing, folder: &Path, page: &Path, case: Case) -> Result<Outcome> {
    let (at, report) = (folder.to_string_lossy(), page.to_string_lossy());
    let mut arguments = vec!["loop", &*at, "--json", "--report", &*report];
    let carried = case.carry.as_ref().map(|earlier| {
        folder.with_file_name(format!("{earlier}.json")).to_string_lossy().into_owned()
    });
    if let Some(file) = &carried {
        arguments.extend(["--carry", file]);
    }
    let answer = truing.run(&arguments)?;
    if answer.code != Some(0) {
        bail!("truing loop {at} ended with {:?}: {}", answer.code, answer.message);
    }
    let kept = folder.with_file_name(format!("{}.json", case.name));
    fs::write(&kept, answer.json.to_string())
        .with_context(|| format!("cannot write {}", kept.display()))?;
    Ok(Outcome { case: case.name, notes: case.notes, answer: answer.json })
}

fn index(truing: &Truing, folder: &Path, pages: &[PathBuf]) -> Result<()> {
    let mut arguments = vec!["index".into(), "--output".into(), folder.join("report.html")];
    arguments.extend(pages.iter().cloned());
    let answer = truing.run(&arguments)?;
    if answer.code != Some(0) {
        bail!("no index of the reports: {}", answer.message);
    }
    println!("report: {}", folder.join("report.html").display());
    Ok(())
}
