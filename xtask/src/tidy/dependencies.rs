//! Who may depend on whom, under which licences, in how many versions and from where.

use std::collections::BTreeMap;

use serde_json::Value;

use super::Finding;
use super::deny::Deny;

/// Members that a crate may depend on.
///
/// A crate that is not listed is a domain crate.
const ALLOWED_MEMBERS: [(&str, &[&str]); 6] = [
    ("truing-geometry", &[]),
    ("least-squares", &[]),
    ("model-discrepancy", &["least-squares"]),
    ("force-impedance-c", &["force-impedance"]),
    ("truing-report", &["model-discrepancy"]),
    ("xtask", &[]),
];
/// Members that a domain crate may depend on.
const ALLOWED_TO_DOMAINS: [&str; 3] = ["truing-geometry", "least-squares", "model-discrepancy"];
/// Third-party numerics that the two lowest crates may use, plumbing aside.
const ALLOWED_NUMERICS: [(&str, &[&str]); 2] =
    [("truing-geometry", &["nalgebra"]), ("least-squares", &["nalgebra", "faer", "pulp", "rayon"])];
/// Every crate may use these.
const PLUMBING: [&str; 2] = ["thiserror", "serde"];
/// Where dependencies may come from: the registry that a version in a manifest means.
const REGISTRY: &str = "registry+https://github.com/rust-lang/crates.io-index";

/// Checks the output of `cargo metadata`.
pub(super) fn check(metadata: &Value, deny: &Deny) -> Vec<Finding> {
    let packages = metadata["packages"].as_array().map_or(&[][..], Vec::as_slice);
    let members: Vec<&str> = packages.iter().filter(|p| is_member(p)).map(name).collect();
    let mut findings = Vec::new();
    for package in packages {
        if is_member(package) {
            findings.extend(arrows(package, &members, deny));
            findings.extend(complete(package));
        } else {
            findings.extend(licence(package, deny));
            findings.extend(source(package));
        }
    }
    findings.extend(duplicates(packages, deny));
    findings
}

/// Crates in more than one version, those aside that are listed.
fn duplicates(packages: &[Value], deny: &Deny) -> Vec<Finding> {
    let mut versions: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    let others = packages.iter().filter(|p| !is_member(p) && !deny.skips(name(p), version(p)));
    for package in others {
        versions.entry(name(package)).or_default().push(version(package));
    }
    let several = versions.into_iter().filter(|(_, versions)| versions.len() > 1);
    several
        .map(|(name, versions)| {
            let versions = versions.join(", ");
            Finding::error(format!("{name} is linked in several versions: {versions}"))
        })
        .collect()
}

fn source(package: &Value) -> Option<Finding> {
    let source = package["source"].as_str().unwrap_or_default();
    let text = format!("{} comes from {source}, not from the registry", name(package));
    (source != REGISTRY).then(|| Finding::error(text))
}

fn version(package: &Value) -> &str {
    package["version"].as_str().unwrap_or_default()
}

fn is_member(package: &Value) -> bool {
    package["source"].is_null()
}

fn name(package: &Value) -> &str {
    package["name"].as_str().unwrap_or_default()
}

/// Normal and build dependencies; what only tests use may point anywhere but to other domains.
fn arrows(package: &Value, members: &[&str], deny: &Deny) -> Vec<Finding> {
    let from = name(package);
    let dependencies = package["dependencies"].as_array().map_or(&[][..], Vec::as_slice);
    let mut findings = Vec::new();
    for dependency in dependencies {
        let to = name(dependency);
        let for_tests = dependency["kind"] == "dev";
        if members.contains(&to) && !member_allowed(from, to) {
            findings.push(Finding::error(format!("{from} must not depend on {to}")));
        }
        if deny.is_tool(to) && !for_tests {
            findings.push(Finding::error(format!("{from} must not link {to}: it is for tests")));
        }
        let numerics = ALLOWED_NUMERICS.iter().find(|(krate, _)| *krate == from);
        if let Some((_, allowed)) = numerics
            && !for_tests
            && !members.contains(&to)
            && !allowed.contains(&to)
            && !PLUMBING.contains(&to)
        {
            findings.push(Finding::error(format!("{from} must not depend on {to}")));
        }
    }
    findings
}

fn member_allowed(from: &str, to: &str) -> bool {
    if from == "truing" {
        return to != "xtask";
    }
    let listed = ALLOWED_MEMBERS.iter().find(|(krate, _)| *krate == from);
    listed.map_or(&ALLOWED_TO_DOMAINS[..], |(_, allowed)| allowed).contains(&to)
}

fn complete(package: &Value) -> Vec<Finding> {
    let published = package["publish"].as_array().is_none_or(|registries| !registries.is_empty());
    let mut keys = vec!["description", "license", "repository", "rust_version"];
    if published {
        keys.push("readme");
    }
    let missing = keys.into_iter().filter(|&key| package[key].is_null());
    missing.map(|key| Finding::error(format!("{} has no {key}", name(package)))).collect()
}

/// An expression passes where every `AND` part has an allowed alternative.
fn licence(package: &Value, deny: &Deny) -> Option<Finding> {
    let expression = package["license"].as_str().unwrap_or("none").replace('/', " OR ");
    let passes = expression.split(" AND ").all(|part| {
        part.split(" OR ").any(|licence| {
            let licence = licence.trim_matches(|c: char| c.is_whitespace() || "()".contains(c));
            deny.allows(name(package), licence.split(" WITH ").next().unwrap_or(licence))
        })
    });
    let text = format!("{} is under {expression}, which is not on the list", name(package));
    (!passes).then(|| Finding::error(text))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn member(name: &str, dependencies: &[&str]) -> Value {
        let dependencies: Vec<Value> =
            dependencies.iter().map(|d| json!({ "name": d, "kind": null })).collect();
        json!({
            "name": name, "source": null, "dependencies": dependencies, "publish": null,
            "description": "", "license": "", "repository": "", "rust_version": "", "readme": ""
        })
    }

    #[test]
    fn domains_may_not_lean_on_each_other_nor_the_core_on_domains() {
        let bad = [
            ("frame-fit", "ft-center"),
            ("least-squares", "truing-geometry"),
            ("least-squares", "csv"),
            ("model-discrepancy", "frame-fit"),
            ("truing-report", "frame-fit"),
            ("frame-fit", "truing-report"),
            ("truing", "xtask"),
            ("xtask", "truing"),
        ];
        for (from, to) in bad {
            let metadata = json!({ "packages": [member(from, &[to]), member(to, &[])] });
            let mut metadata = metadata;
            if to == "csv" {
                metadata["packages"][1]["source"] = json!(REGISTRY);
                metadata["packages"][1]["license"] = json!("MIT");
            }
            let found = check(&metadata, &Deny::default().with("MIT"));
            assert_eq!(found.len(), 1, "{from} → {to}: {found:?}");
        }
        let good = json!({ "packages": [member("frame-fit", &["truing-geometry"]), member("truing-geometry", &[])] });
        assert!(check(&good, &Deny::default()).is_empty());
    }

    #[test]
    fn licences_are_read_as_expressions() {
        let deny =
            ["MIT", "Apache-2.0", "Unicode-3.0"].into_iter().fold(Deny::default(), Deny::with);
        let with = |text: &str| licence(&json!({ "name": "x", "license": text }), &deny).is_none();
        assert!(with("MIT/Apache-2.0"));
        assert!(with("(MIT OR GPL-3.0) AND Unicode-3.0"));
        assert!(with("Apache-2.0 WITH LLVM-exception OR GPL-3.0"));
        assert!(!with("GPL-3.0"));
        assert!(!with("MIT AND GPL-3.0"));
    }

    #[test]
    fn second_versions_and_other_sources_are_found() {
        let package = |version: &str, source: &str| json!({ "name": "x", "version": version, "source": source, "license": "MIT" });
        let deny = Deny::default().with("MIT");
        let found = |packages: &[Value]| check(&json!({ "packages": packages }), &deny).len();
        assert_eq!(found(&[package("1.0.0", REGISTRY)]), 0);
        assert_eq!(found(&[package("1.0.0", REGISTRY), package("2.0.0", REGISTRY)]), 1);
        assert_eq!(found(&[package("1.0.0", "git+https://example.org/x")]), 1);
    }
}
