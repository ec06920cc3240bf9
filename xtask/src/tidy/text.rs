//! Rules for every text file: where it lies, and words it must not hold.

use std::fs;

use anyhow::{Context, Result};

use super::Finding;
use crate::shell;

/// What may lie in the root.
const ROOT: [&str; 19] = [
    ".cargo",
    ".ci",
    ".gitattributes",
    ".gitignore",
    "CHANGELOG.md",
    "CITATION.cff",
    "CONTRIBUTING.md",
    "Cargo.lock",
    "Cargo.toml",
    "LICENSE-APACHE",
    "LICENSE-MIT",
    "README.md",
    "SECURITY.md",
    "clippy.toml",
    "crates",
    "docs",
    "fixtures",
    "rust-toolchain.toml",
    "rustfmt.toml",
];
/// The page that names every crate.
const ARCHITECTURE: &str = "docs/architecture.md";

/// Words that mean unfinished work, skipped tests or somebody's machine; cut in two so that this
/// list does not find itself.
const FORBIDDEN: [(&str, &str); 9] = [
    ("todo", "!("),
    ("unimplemented", "!("),
    ("dbg", "!("),
    ("#[ign", "ore"),
    ("TO", "DO"),
    ("FIX", "ME"),
    ("/ho", "me/"),
    ("/tm", "p/"),
    ("/wo", "rk/"),
];

/// Checks places, words and the list of crates.
pub(super) fn check(files: &[String]) -> Result<Vec<Finding>> {
    let mut findings: Vec<Finding> = files.iter().filter_map(|file| misplaced(file)).collect();
    for file in files {
        let bytes = fs::read(shell::root().join(file)).with_context(|| file.clone())?;
        // Pictures and the lock file hold what they hold.
        if let (Ok(text), false) = (String::from_utf8(bytes), file == "Cargo.lock") {
            findings.extend(forbidden(file, &text));
        }
    }
    findings.extend(unlisted_crates(files)?);
    Ok(findings)
}

fn misplaced(file: &str) -> Option<Finding> {
    let first = file.split('/').next().unwrap_or(file);
    let known = ROOT.contains(&first) || first == "xtask";
    (!known).then(|| Finding::error(format!("{file} does not belong in the root")))
}

fn forbidden(file: &str, text: &str) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (index, line) in text.lines().enumerate() {
        for (start, end) in FORBIDDEN {
            let word = format!("{start}{end}");
            if line.contains(&word) {
                findings.push(Finding::error(format!("{file}:{} holds `{word}`", index + 1)));
            }
        }
    }
    findings
}

fn unlisted_crates(files: &[String]) -> Result<Vec<Finding>> {
    let path = shell::root().join(ARCHITECTURE);
    if !path.is_file() {
        return Ok(vec![Finding::error(format!("{ARCHITECTURE} is missing"))]);
    }
    let page = fs::read_to_string(path).context(ARCHITECTURE)?;
    let crates = files
        .iter()
        .filter_map(|file| file.strip_prefix("crates/")?.strip_suffix("/Cargo.toml"))
        .chain(["xtask"]);
    let unlisted = crates.filter(|krate| !page.contains(&format!("`{krate}`")));
    Ok(unlisted.map(|k| Finding::error(format!("{ARCHITECTURE} does not name `{k}`"))).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unfinished_work_and_stray_files_are_found() {
        let text = format!("fn f() {{ {}{}) }}", "todo", "!(");
        assert_eq!(forbidden("a.rs", &text).len(), 1);
        assert!(forbidden("a.rs", "fn f() {}").is_empty());
        assert!(misplaced("notes.txt").is_some());
        assert!(misplaced("crates/geometry/src/lib.rs").is_none());
    }
}
