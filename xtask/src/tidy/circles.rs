//! No file of a crate may need another one that needs it.
//!
//! A file needs those whose items it names by `crate::`, `super::` or `self::`. An item that a
//! module passes on (`pub use`) counts where it is written down; what a module says of the files
//! below it when it passes their items on is no need of its own, and tests may look anywhere.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use anyhow::{Context, Result};

use super::Finding;
use super::source::{code_only, is_rust};
use crate::shell;

/// A module's path inside its crate; empty for the root.
type Module = Vec<String>;

/// What a file says, as far as it matters here.
#[derive(Clone, Debug, Default)]
struct Source {
    /// Paths that it names, the passed-on ones with `true`.
    named: Vec<(Module, bool)>,
    /// Name under which an item is passed on, and its path.
    passed_on: BTreeMap<String, Module>,
}

/// Checks the sources of every crate.
pub(super) fn check(files: &[String]) -> Result<Vec<Finding>> {
    let mut crates: BTreeMap<&str, BTreeMap<Module, String>> = BTreeMap::new();
    for file in files.iter().filter(|file| is_rust(file)) {
        let Some((package, inside)) = file.split_once("/src/") else { continue };
        let text = fs::read_to_string(shell::root().join(file)).with_context(|| file.clone())?;
        crates.entry(package).or_default().insert(module(inside), without_tests(&text));
    }
    let finding = |(package, sources): (&str, BTreeMap<Module, String>)| {
        let circle = circle(&needs(&sources))?;
        let names: Vec<String> = circle.iter().map(|module| module.join("::")).collect();
        let text = format!("{package}: files need each other in a circle: {}", names.join(" → "));
        Some(Finding::error(text))
    };
    Ok(crates.into_iter().filter_map(finding).collect())
}

fn module(inside: &str) -> Module {
    let mut parts: Module = inside.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
    if matches!(parts.last().map(String::as_str), Some("mod" | "lib" | "main")) {
        parts.pop();
    }
    parts
}

/// Code up to the tests at its end.
fn without_tests(text: &str) -> String {
    let code = code_only(text);
    let end = code.find("#[cfg(test)]\nmod ").unwrap_or(code.len());
    code[..end].to_owned()
}

/// Which modules each module needs.
fn needs(texts: &BTreeMap<Module, String>) -> BTreeMap<Module, BTreeSet<Module>> {
    let sources: BTreeMap<Module, Source> =
        texts.iter().map(|(of, text)| (of.clone(), source(of, text, texts))).collect();
    let of = |(here, source): (&Module, &Source)| {
        let named = source.named.iter();
        let needed = named.filter_map(|(path, passed_on)| {
            let there = owner(path, &sources)?;
            let is_below = there.starts_with(here);
            (there != *here && !(*passed_on && is_below)).then_some(there)
        });
        (here.clone(), needed.collect())
    };
    sources.iter().map(of).collect()
}

fn source(here: &Module, text: &str, all: &BTreeMap<Module, String>) -> Source {
    let mut source = Source::default();
    let mut rest = String::new();
    for statement in text.split_inclusive([';', '{', '}']) {
        rest.push_str(statement);
        if rest.matches('{').count() > rest.matches('}').count() && is_use(&rest) {
            continue;
        }
        let whole = std::mem::take(&mut rest);
        if let Some(start) = whole.find("use ").filter(|_| is_use(&whole)) {
            let passed_on =
                whole[..start].trim_end().ends_with(['b', ')']) && whole[..start].contains("pub");
            for tree in expand(whole[start + 4..].trim_end_matches(';')) {
                let (path, name) = tree.split_once(" as ").unwrap_or((&tree, ""));
                let Some(path) = absolute(path.trim(), here, all) else { continue };
                let name = if name.is_empty() { path.last().cloned() } else { Some(name.into()) };
                if passed_on && let Some(name) = name {
                    source.passed_on.insert(name.trim().to_owned(), path.clone());
                }
                source.named.push((path, passed_on));
            }
        } else {
            let paths = inline_paths(&whole);
            let known = paths.iter().filter_map(|path| absolute(path, here, all));
            source.named.extend(known.map(|path| (path, false)));
        }
    }
    source
}

/// Whether a statement is a `use`, whatever stands before it.
fn is_use(statement: &str) -> bool {
    let mut lines = statement.lines().map(str::trim_start);
    let line = lines.find(|line| !line.is_empty() && !line.starts_with('#')).unwrap_or_default();
    let line = line.strip_prefix("pub").map_or(line, |rest| {
        let rest = rest.trim_start();
        if rest.starts_with('(') { rest.split_once(')').map_or(rest, |(_, r)| r) } else { rest }
    });
    line.trim_start().starts_with("use ")
}

/// The single paths of a tree of a `use`.
fn expand(tree: &str) -> Vec<String> {
    let tree = tree.split_whitespace().collect::<Vec<_>>().join(" ");
    let Some((before, inside)) = tree.split_once('{') else { return vec![tree] };
    let inside = inside.rsplit_once('}').map_or(inside, |(inside, _)| inside);
    let (mut depth, mut parts) = (0_usize, vec![String::new()]);
    for symbol in inside.chars() {
        match symbol {
            '{' => depth += 1,
            '}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if symbol == ',' && depth == 0 {
            parts.push(String::new());
        } else if let Some(part) = parts.last_mut() {
            part.push(symbol);
        }
    }
    let parts = parts.iter().map(|part| part.trim()).filter(|part| !part.is_empty());
    parts.flat_map(|part| expand(&format!("{before}{part}"))).collect()
}

/// Paths beginning with `crate::` or `super::` in an expression.
fn inline_paths(text: &str) -> Vec<String> {
    let is_path = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    let words = text.split(|c: char| !is_path(c));
    words
        .filter(|w| w.starts_with("crate::") || w.starts_with("super::"))
        .map(str::to_owned)
        .collect()
}

/// A path from the root of the crate; `None` for one into another crate.
fn absolute(path: &str, here: &Module, all: &BTreeMap<Module, String>) -> Option<Module> {
    let mut parts = path.split("::").map(str::to_owned).peekable();
    let mut from = match parts.peek().map(String::as_str)? {
        "crate" => Module::new(),
        "self" | "super" => here.clone(),
        child => {
            let is_child = all.contains_key(&[&here[..], &[child.to_owned()]].concat());
            return is_child.then(|| [here.clone(), parts.collect()].concat());
        }
    };
    while let Some(part) = parts.next_if(|p| matches!(p.as_str(), "crate" | "self" | "super")) {
        if part == "super" {
            from.pop();
        }
    }
    from.extend(parts);
    Some(from)
}

/// The module in which the item at `path` is written down.
fn owner(path: &Module, sources: &BTreeMap<Module, Source>) -> Option<Module> {
    let mut here = Module::new();
    for (i, part) in path.iter().enumerate() {
        let below = [&here[..], std::slice::from_ref(part)].concat();
        if sources.contains_key(&below) {
            here = below;
            continue;
        }
        let elsewhere = sources.get(&here)?.passed_on.get(part);
        return match elsewhere {
            Some(there) if *there != path[..=i] => {
                owner(&[&there[..], &path[i + 1..]].concat(), sources)
            }
            _ => Some(here),
        };
    }
    Some(here)
}

/// Modules that need each other, the first one named again at the end.
fn circle(needs: &BTreeMap<Module, BTreeSet<Module>>) -> Option<Vec<Module>> {
    let mut left = needs.clone();
    loop {
        let free: Vec<Module> = (left.iter())
            .filter(|(_, needed)| needed.iter().all(|n| !left.contains_key(n)))
            .map(|(module, _)| module.clone())
            .collect();
        if free.is_empty() {
            break;
        }
        left.retain(|module, _| !free.contains(module));
    }
    // Everything left needs something that is left: walking on must come back.
    let mut walked = vec![left.keys().next()?.clone()];
    loop {
        let next = left[walked.last()?].iter().find(|n| left.contains_key(*n))?.clone();
        let met = walked.iter().position(|w| *w == next);
        walked.push(next);
        if let Some(first) = met {
            return Some(walked.split_off(first));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(sources: &[(&str, &str)]) -> Option<Vec<String>> {
        let texts = sources.iter().map(|(file, text)| (module(file), without_tests(text)));
        let circle = circle(&needs(&texts.collect()))?;
        Some(circle.iter().map(|module| module.join("::")).collect())
    }

    #[test]
    fn two_files_that_need_each_other_are_a_circle() {
        let a = ("a.rs", "use crate::b::{self, Thing};\nfn f() {}\n");
        assert_eq!(found(&[a, ("b.rs", "fn f() { crate::a::f() }\n")]).unwrap(), ["a", "b", "a"]);
        assert_eq!(found(&[a, ("b.rs", "struct Thing;\n")]), None);
        let in_tests = ("b.rs", "struct Thing;\n#[cfg(test)]\nmod tests { use crate::a::f; }\n");
        assert_eq!(found(&[a, in_tests]), None);
    }

    #[test]
    fn what_a_module_passes_on_belongs_to_where_it_is_written() {
        let root =
            ("lib.rs", "mod a;\nmod b;\npub use a::f;\npub(crate) use b::{Thing as Other};\n");
        let b = ("b.rs", "pub(crate) struct Thing;\n");
        assert_eq!(found(&[root, ("a.rs", "use super::Other;\npub fn f() {}\n"), b]), None);
        let b = ("b.rs", "use crate::f;\npub(crate) struct Thing;\n");
        let a = ("a.rs", "use crate::{\n    Other,\n};\npub fn f() {}\n");
        assert_eq!(found(&[root, a, b]).unwrap(), ["a", "b", "a"]);
        // A file that needs an item of the module above it, which needs the file.
        let m = ("m/mod.rs", "mod n;\nuse n::g;\npub struct Here;\n");
        let n = ("m/n.rs", "use super::Here;\npub fn g() {}\n");
        assert_eq!(found(&[m, n]).unwrap(), ["m", "m::n", "m"]);
    }
}
