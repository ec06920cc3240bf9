//! `cargo xtask fixtures`: writes the committed cases, or says which are stale.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail};

use crate::generators::Case;
use crate::kinds::cases;
use crate::shell;

/// What to do with the fixtures.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Only says what is stale, and fails if anything is.
    #[arg(long)]
    pub(crate) check: bool,
}

/// Writes or checks every generated file of `fixtures/`.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let folder = shell::root().join("fixtures");
    if arguments.check {
        return check(&folder);
    }
    let cases = cases();
    for case in &cases {
        write(&folder, case)?;
    }
    println!("wrote {} cases to fixtures/", cases.len());
    Ok(())
}

/// Writes a case folder under `folder`.
pub(crate) fn write(folder: &Path, case: &Case) -> Result<()> {
    let folder = folder.join(&case.folder);
    fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    for (name, text) in &case.files {
        let path = folder.join(name);
        fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}

fn check(folder: &Path) -> Result<()> {
    let cases = cases();
    let stale: Vec<String> = cases.iter().flat_map(|case| stale_files(folder, case)).collect();
    for line in &stale {
        println!("{line}");
    }
    if !stale.is_empty() {
        bail!("{} stale; `cargo xtask fixtures` writes them anew", stale.len());
    }
    println!("{} cases are as their generators write them", cases.len());
    Ok(())
}

/// Files of a case that are missing, differ by a byte, or that no generator wrote.
fn stale_files(folder: &Path, case: &Case) -> Vec<String> {
    let in_case = folder.join(&case.folder);
    let mut stale = Vec::new();
    for (name, text) in &case.files {
        match fs::read(in_case.join(name)) {
            Ok(bytes) if bytes == text.as_bytes() => {}
            Ok(_) => stale.push(format!("{}/{name} differs", case.folder)),
            Err(_) => stale.push(format!("{}/{name} is missing", case.folder)),
        }
    }
    for entry in fs::read_dir(&in_case).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if !case.files.contains_key(&name) {
            stale.push(format!("{}/{name} has no generator", case.folder));
        }
    }
    stale
}
