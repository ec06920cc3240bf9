//! The page that shows which crate depends on which.

use std::collections::BTreeMap;
use std::fs;

use anyhow::{Context, Result};
use serde_json::Value;

use super::Finding;
use crate::shell;

const PAGE: &str = "docs/architecture.md";
/// What the generated part of the page stands between.
const MARKS: [&str; 2] = ["<!-- crates: `cargo xtask tidy --write` -->\n", "<!-- end -->\n"];

/// Says where the page is not what `cargo metadata` says; with `write` the diagram is drawn anew.
pub(super) fn check(metadata: &Value, write: bool) -> Result<Vec<Finding>> {
    let path = shell::root().join(PAGE);
    let page = fs::read_to_string(&path).context(PAGE)?;
    let arrows = arrows(metadata);
    let mut findings = Vec::new();
    for name in arrows.keys().filter(|name| !page.contains(&format!("\n| `{name}` |"))) {
        findings.push(Finding::error(format!("{PAGE} does not say what `{name}` knows")));
    }
    let Some(drawn) = with_diagram(&page, &diagram(&arrows)) else {
        findings.push(Finding::error(format!("{PAGE} has no place for the diagram of the crates")));
        return Ok(findings);
    };
    if drawn != page {
        if write {
            fs::write(&path, drawn).context(PAGE)?;
        } else {
            let text = format!("{PAGE} is stale: draw it with `cargo xtask tidy --write`");
            findings.push(Finding::error(text));
        }
    }
    Ok(findings)
}

/// Members, and the members that each depends on; what only tests use is left out.
fn arrows(metadata: &Value) -> BTreeMap<String, Vec<String>> {
    let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let name = |value: &Value| value["name"].as_str().unwrap_or_default().to_owned();
    let packages = list(&metadata["packages"]);
    let members: Vec<&Value> = packages.iter().filter(|p| p["source"].is_null()).collect();
    let names: Vec<String> = members.iter().map(|p| name(p)).collect();
    let of = |package: &&Value| {
        let linked = list(&package["dependencies"]).into_iter().filter(|d| d["kind"] != "dev");
        let mut to: Vec<String> = linked.map(|d| name(&d)).filter(|d| names.contains(d)).collect();
        to.sort();
        to.dedup();
        (name(package), to)
    };
    members.iter().map(of).collect()
}

/// One line per crate, each above all that it depends on.
fn diagram(arrows: &BTreeMap<String, Vec<String>>) -> String {
    let mut layers: BTreeMap<&str, usize> = BTreeMap::new();
    while layers.len() < arrows.len() {
        let before = layers.len();
        for (name, to) in arrows {
            let below: Option<Vec<usize>> =
                to.iter().map(|t| layers.get(t.as_str()).copied()).collect();
            if let Some(below) = below {
                layers.insert(name, below.into_iter().max().map_or(0, |layer| layer + 1));
            }
        }
        if layers.len() == before {
            break;
        }
    }
    let mut order: Vec<&String> = arrows.keys().collect();
    order.sort_by_key(|name| std::cmp::Reverse(layers.get(name.as_str())));
    let width = order.iter().map(|name| name.len()).max().unwrap_or(0);
    let mut text = "```text\n".to_owned();
    let mut last = None;
    for name in order {
        let layer = layers.get(name.as_str());
        if last.is_some_and(|last| last != layer) {
            text += &"─".repeat(width + 2);
            text += "\n";
        }
        last = Some(layer);
        let to = arrows[name].join(", ");
        text += format!("{name:width$}  → {to}").trim_end_matches(['→', ' ']);
        text += "\n";
    }
    text + "```\n"
}

/// The page with the diagram between its marks.
fn with_diagram(page: &str, diagram: &str) -> Option<String> {
    let (before, rest) = page.split_once(MARKS[0])?;
    let (_, after) = rest.split_once(MARKS[1])?;
    Some([before, MARKS[0], diagram, MARKS[1], after].concat())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn member(name: &str, dependencies: &[(&str, Option<&str>)]) -> Value {
        let dependencies: Vec<Value> =
            dependencies.iter().map(|(name, kind)| json!({ "name": name, "kind": kind })).collect();
        json!({ "name": name, "source": null, "dependencies": dependencies })
    }

    #[test]
    fn a_crate_stands_above_what_it_depends_on() {
        let metadata = json!({ "packages": [
            member("low", &[]),
            member("top", &[("middle", None), ("low", None)]),
            member("middle", &[("low", None), ("top", Some("dev"))]),
        ] });
        let drawn = diagram(&arrows(&metadata));
        let lines = ["top     → low, middle", "────────", "middle  → low", "────────", "low"];
        assert_eq!(drawn, format!("```text\n{}\n```\n", lines.join("\n")));
        let page = format!("a\n{}old\n{}b\n", MARKS[0], MARKS[1]);
        let new = with_diagram(&page, &drawn).unwrap();
        assert_eq!(new, format!("a\n{}{drawn}{}b\n", MARKS[0], MARKS[1]));
    }
}
