//! `cargo xtask tidy`: the rules of the house that the compiler does not hold.
//!
//! A finding is an error, or a warning where the rule is a recommendation.

mod dependencies;
mod fixtures;
mod source;
mod suffixes;
mod text;

use anyhow::{Result, bail};

use crate::shell;

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
pub(crate) fn run() -> Result<()> {
    let findings = findings()?;
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

fn findings() -> Result<Vec<Finding>> {
    let files = shell::source_files()?;
    let mut findings = dependencies::check(&shell::metadata(true)?);
    findings.extend(text::check(&files)?);
    findings.extend(source::check(&files)?);
    findings.extend(suffixes::check(&files)?);
    findings.extend(fixtures::check(&files)?);
    Ok(findings)
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_workspace_is_tidy() {
        let findings = super::findings().unwrap();
        let errors: Vec<_> = findings.iter().filter(|f| !f.warning).map(|f| &f.text).collect();
        assert!(errors.is_empty(), "{errors:#?}");
    }
}
