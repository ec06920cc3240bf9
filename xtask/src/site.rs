//! `cargo xtask site`: the documentation as a site, in `target/site/html`.
//!
//! Pages keep their places and their links: mdBook is given a copy of them with the layout of the
//! repository, in which links to folders lead to their page and links to source files to the
//! repository. What rustdoc writes lies beside, in `api`.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};

use crate::markdown::{is_external, links, resolved, with_links};
use crate::shell;

/// The contents of the site, in mdBook's form, with links that also hold where it lies.
pub(crate) const CONTENTS: &str = "docs/SUMMARY.md";
const README: &str = "README.md";
const REPOSITORY: &str = env!("CARGO_PKG_REPOSITORY");

const BOOK: &str = "[book]
title = \"Truing\"
language = \"en\"
[output.html]
mathjax-support = false
[output.html.search]
limit-results = 20
";

/// Writes the site, with mdBook and rustdoc.
pub(crate) fn run() -> Result<()> {
    ensure!(
        Command::new("mdbook").arg("--version").output().is_ok_and(|o| o.status.success()),
        "mdBook is not installed: cargo install mdbook --locked"
    );
    let root = shell::root();
    let site = root.join("target/site");
    if site.exists() {
        fs::remove_dir_all(&site).context("target/site")?;
    }
    let source = site.join("src");
    let chapters = contents()?;
    for page in &chapters {
        let text = fs::read_to_string(root.join(page)).with_context(|| page.clone())?;
        write(&source.join(page), &with_links(&text, |to| led(page, to, &chapters)))?;
        for picture in links(&text).iter().map(|link| resolved(page, &link.to).0) {
            if is_picture(&picture) && root.join(&picture).is_file() {
                let to = source.join(&picture);
                fs::create_dir_all(to.parent().context("a folder")?)?;
                fs::copy(root.join(&picture), to).with_context(|| picture.clone())?;
            }
        }
    }
    let summary = fs::read_to_string(root.join(CONTENTS)).context(CONTENTS)?;
    let summary = with_links(&summary, |to| Some(resolved(CONTENTS, to).0));
    write(&source.join("SUMMARY.md"), &format!("{summary}\n[Reference of every crate](api.md)\n"))?;
    write(&source.join("api.md"), &reference()?)?;
    write(&site.join("book.toml"), BOOK)?;
    let html = site.join("html");
    let mut mdbook = Command::new("mdbook");
    let built = mdbook.arg("build").arg(&site).arg("--dest-dir").arg(&html).status();
    ensure!(built.context("cannot start mdbook")?.success(), "mdbook failed");
    shell::cargo(&["doc", "--release", "--workspace", "--all-features", "--no-deps"])?;
    copy(&root.join("target/doc"), &html.join("api"))?;
    println!("wrote target/site/html/index.html");
    Ok(())
}

/// Pages of the site, from the root of the repository, in the order of its contents.
pub(crate) fn contents() -> Result<Vec<String>> {
    let summary = fs::read_to_string(shell::root().join(CONTENTS)).context(CONTENTS)?;
    Ok(links(&summary).iter().map(|link| resolved(CONTENTS, &link.to).0).collect())
}

/// Where a link of a page leads in the site; `None`: where it leads in the repository.
fn led(page: &str, to: &str, chapters: &[String]) -> Option<String> {
    if is_external(to) || to.starts_with('#') {
        return None;
    }
    let (path, _) = resolved(page, to);
    let folder = format!("{path}/README.md");
    // mdBook makes the page of a folder of what is called README.
    if chapters.contains(&folder) {
        return Some(format!("{to}/index.html"));
    }
    if chapters.contains(&path) && path.ends_with(README) {
        return Some(to.replacen(README, "index.html", 1));
    }
    let stays = chapters.contains(&path) || is_picture(&path);
    let kind = if shell::root().join(&path).is_dir() { "tree" } else { "blob" };
    (!stays).then(|| format!("{REPOSITORY}/{kind}/main/{path}"))
}

fn is_picture(path: &str) -> bool {
    Path::new(path).extension().is_some_and(|e| ["png", "svg"].iter().any(|known| e == *known))
}

/// The page that leads to what rustdoc wrote.
fn reference() -> Result<String> {
    let metadata = shell::metadata(false)?;
    let mut page = "# Reference of every crate\n\nTypes, functions and their errors, from the \
                    comments of the source.\n\n"
        .to_owned();
    for package in metadata["packages"].as_array().context("no packages")? {
        let targets = package["targets"].as_array().context("no targets")?;
        let is_library = |t: &&serde_json::Value| t["doc"] == true && t["kind"][0] != "bin";
        let (Some(target), Some(name)) =
            (targets.iter().find(is_library), package["name"].as_str())
        else {
            continue;
        };
        let library = target["name"].as_str().unwrap_or(name).replace('-', "_");
        let about = package["description"].as_str().unwrap_or_default();
        writeln!(page, "- [`{name}`](api/{library}/index.html): {about}")?;
    }
    Ok(page)
}

fn write(path: &Path, text: &str) -> Result<()> {
    let Some(folder) = path.parent() else { bail!("{} has no folder", path.display()) };
    fs::create_dir_all(folder)?;
    fs::write(path, text).with_context(|| path.display().to_string())
}

/// A folder with all that it holds.
fn copy(from: &Path, to: &Path) -> Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from).with_context(|| from.display().to_string())? {
        let entry = entry?;
        let to = to.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            copy(&entry.path(), &to)?;
        } else {
            fs::copy(entry.path(), to)?;
        }
    }
    Ok(())
}
