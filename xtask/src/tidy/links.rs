//! Links of the documentation lead somewhere; other sites are not asked.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};

use super::Finding;
use crate::markdown::{anchors, is_external, links, resolved};
use crate::{shell, site};

/// Looks up every relative link and anchor of every page, and every page in the contents.
pub(super) fn check(files: &[String]) -> Result<Vec<Finding>> {
    let mut findings = Vec::new();
    let pages = files.iter().filter(|file| is_page(file));
    for page in pages {
        let text = fs::read_to_string(shell::root().join(page)).with_context(|| page.clone())?;
        for link in links(&text).into_iter().filter(|link| !is_external(&link.to)) {
            let line = text[..link.at.start].lines().count().max(1);
            if let Some(wrong) = dead(page, &link.to)? {
                let text = format!("{page}:{line} links to {}, {wrong}", link.to);
                findings.push(Finding::error(text));
            }
        }
    }
    let contents = site::contents()?;
    let is_chapter = |file: &&String| file.starts_with("docs/") && is_page(file);
    for page in files.iter().filter(is_chapter).filter(|page| !contents.contains(page)) {
        let text = format!("{page} is not in the contents of the site, {}", site::CONTENTS);
        findings.extend((*page != site::CONTENTS).then(|| Finding::error(text)));
    }
    Ok(findings)
}

/// Whether a file is a page of the documentation.
fn is_page(file: &str) -> bool {
    Path::new(file).extension().is_some_and(|extension| extension == "md")
}

/// What is wrong with a link.
fn dead(page: &str, to: &str) -> Result<Option<String>> {
    let (path, anchor) = resolved(page, to);
    let target = shell::root().join(&path);
    if !target.exists() {
        return Ok(Some("which is not there".to_owned()));
    }
    let Some(anchor) = anchor.filter(|_| is_page(&path)) else { return Ok(None) };
    let text = fs::read_to_string(&target).with_context(|| path.clone())?;
    let found = anchors(&text).iter().any(|known| known == anchor);
    Ok((!found).then(|| format!("and {path} has no heading of that name")))
}
