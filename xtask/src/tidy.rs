//! `cargo xtask tidy`: the rules of the house that the compiler does not hold.
//!
//! A finding is an error, or a warning where the rule is a recommendation.

mod architecture;
mod circles;
mod deny;
mod dependencies;
mod fixtures;
mod links;
mod source;
mod suffixes;
mod tested;
mod text;
mod toolchain;

use anyhow::{Result, bail};
use clap::Args;

use crate::shell;

/// What to do beside looking.
#[derive(Clone, Copy, Debug, Default, Args)]
pub(crate) struct Arguments {
    /// Draw the diagram of the crates anew.
    #[arg(long)]
    write: bool,
}

/// Something that is not as it should be.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Finding {
    /// Whether it is only a recommendation.
    warning: bool,
    /// What and where.
    text: String,
}

impl Finding {
    fn error(text: String) -> Self {
        Self { warning: false, text }
    }

    fn warning(text: String) -> Self {
        Self { warning: true, text }
    }
}

/// Prints every finding and fails if there is an error among them.
pub(crate) fn run(arguments: Arguments) -> Result<()> {
    let findings = findings(arguments.write)?;
    for finding in &findings {
        println!("{}: {}", if finding.warning { "warning" } else { "error" }, finding.text);
    }
    let errors = findings.iter().filter(|f| !f.warning).count();
    if errors > 0 {
        bail!("tidy found {errors} errors");
    }
    println!("tidy: no errors, {} warnings", findings.len());
    Ok(())
}

fn findings(write: bool) -> Result<Vec<Finding>> {
    let files = shell::source_files()?;
    let metadata = shell::metadata(true)?;
    let mut findings = dependencies::check(&metadata, &deny::Deny::read()?);
    findings.extend(architecture::check(&metadata, write)?);
    findings.extend(circles::check(&files)?);
    findings.extend(text::check(&files)?);
    findings.extend(source::check(&files)?);
    findings.extend(suffixes::check(&files)?);
    findings.extend(fixtures::check(&files)?);
    findings.extend(links::check(&files)?);
    findings.extend(tested::check(&metadata, &files)?);
    findings.extend(toolchain::check(&metadata)?);
    Ok(findings)
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_workspace_is_tidy() {
        let findings = super::findings(false).unwrap();
        let errors: Vec<_> = findings.iter().filter(|f| !f.warning).map(|f| &f.text).collect();
        assert!(errors.is_empty(), "{errors:#?}");
    }
}
