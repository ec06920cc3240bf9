//! Rules for Rust source: who may touch the outside world, and how long things get.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};

use super::Finding;
use crate::shell;

/// Code lines at which a file is talked about.
const LONG_FILE: usize = 400;
/// Lines at which a function is talked about.
const LONG_FUNCTION: usize = 60;

/// What only `truing` and `xtask` may do.
const OUTSIDE_WORLD: [&str; 12] = [
    "std::fs",
    "std::env",
    "std::net",
    "std::process",
    "std::io::std",
    "SystemTime",
    "Instant::now",
    "File::open",
    "print!(",
    "println!(",
    "eprint!(",
    "eprintln!(",
];
/// Modules that gather whatever has no name.
const GRAB_BAGS: [&str; 6] = ["prelude", "utils", "util", "common", "helpers", "misc"];

/// Checks all Rust files.
pub(super) fn check(files: &[String]) -> Result<Vec<Finding>> {
    let mut findings = Vec::new();
    for file in files.iter().filter(|file| is_rust(file)) {
        let text = fs::read_to_string(shell::root().join(file)).with_context(|| file.clone())?;
        let code = code_only(&text);
        findings.extend(sizes(file, &code));
        findings.extend(grab_bag(file));
        if is_library(file) {
            findings.extend(outside_world(file, &code));
        }
    }
    Ok(findings)
}

/// Whether a file is Rust source.
pub(super) fn is_rust(file: &str) -> bool {
    Path::new(file).extension().is_some_and(|extension| extension == "rs")
}

/// Library source that must leave the outside world alone.
pub(super) fn is_library(file: &str) -> bool {
    file.starts_with("crates/") && file.contains("/src/") && !file.starts_with("crates/truing/")
}

fn sizes(file: &str, code: &str) -> Vec<Finding> {
    let mut findings = Vec::new();
    let n_lines = code.lines().filter(|line| !line.trim().is_empty()).count();
    if n_lines > LONG_FILE {
        findings.push(Finding::warning(format!("{file} has {n_lines} code lines")));
    }
    for (line, name, length) in functions(code) {
        if length > LONG_FUNCTION {
            findings.push(Finding::warning(format!("{file}:{line} {name} has {length} lines")));
        }
    }
    findings
}

fn grab_bag(file: &str) -> Option<Finding> {
    let mut parts = file.split('/').map(|part| part.trim_end_matches(".rs"));
    let bag = parts.find(|part| GRAB_BAGS.contains(part))?;
    Some(Finding::error(format!("{file}: `{bag}` says nothing of what is inside")))
}

fn outside_world(file: &str, code: &str) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (index, line) in code.lines().enumerate() {
        // `eprintln!(` holds `println!(`: one finding a line is enough.
        if let Some(word) = OUTSIDE_WORLD.iter().find(|word| line.contains(**word)) {
            let text = format!("{file}:{} uses `{word}`: only truing may", index + 1);
            findings.push(Finding::error(text));
        }
    }
    findings
}

/// First line, name and number of lines of every function with a body.
fn functions(code: &str) -> Vec<(usize, String, usize)> {
    let lines: Vec<&str> = code.lines().collect();
    let mut functions = Vec::new();
    for (start, line) in lines.iter().enumerate() {
        let Some(name) = name_after_fn(line) else { continue };
        let mut depth = 0_usize;
        let mut opened = false;
        'body: for (offset, line) in lines[start..].iter().enumerate() {
            for symbol in line.chars() {
                match symbol {
                    '{' => (depth, opened) = (depth + 1, true),
                    '}' => depth = depth.saturating_sub(1),
                    ';' if !opened => break 'body,
                    _ => {}
                }
                if opened && depth == 0 {
                    functions.push((start + 1, name.clone(), offset + 1));
                    break 'body;
                }
            }
        }
    }
    functions
}

fn name_after_fn(line: &str) -> Option<String> {
    let (before, after) = line.split_once("fn ")?;
    let starts_word = before.is_empty() || before.ends_with(' ') || before.ends_with('"');
    let name: String = after.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    (starts_word && !name.is_empty()).then_some(name)
}

/// The text with comments and the insides of strings blanked, lines kept.
pub(super) fn code_only(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(symbol) = rest.chars().next() {
        let length = match symbol {
            '/' if rest.starts_with("//") => rest.find('\n').unwrap_or(rest.len()),
            '/' if rest.starts_with("/*") => rest.find("*/").map_or(rest.len(), |end| end + 2),
            '"' => string_length(rest),
            'r' if raw_string_hashes(rest).is_some() && !ends_in_word(&out) => {
                raw_string_length(rest)
            }
            '\'' => char_length(rest),
            _ => 0,
        };
        if length == 0 {
            out.push(symbol);
            rest = &rest[symbol.len_utf8()..];
        } else {
            out.extend(rest[..length].chars().map(|c| if c == '\n' { '\n' } else { ' ' }));
            rest = &rest[length..];
        }
    }
    out
}

fn ends_in_word(text: &str) -> bool {
    text.ends_with(|c: char| c.is_alphanumeric() || c == '_')
}

fn string_length(text: &str) -> usize {
    let mut escaped = false;
    for (at, symbol) in text.char_indices().skip(1) {
        match symbol {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '"' => return at + 1,
            _ => {}
        }
    }
    text.len()
}

fn raw_string_hashes(text: &str) -> Option<usize> {
    let after = text.strip_prefix('r')?;
    let n_hashes = after.len() - after.trim_start_matches('#').len();
    after[n_hashes..].starts_with('"').then_some(n_hashes)
}

fn raw_string_length(text: &str) -> usize {
    let n_hashes = raw_string_hashes(text).unwrap_or(0);
    let start = n_hashes + 2;
    let end = format!("\"{}", "#".repeat(n_hashes));
    text[start..].find(&end).map_or(text.len(), |at| start + at + end.len())
}

/// Length of a character literal; zero for a lifetime.
fn char_length(text: &str) -> usize {
    let mut symbols = text.char_indices().skip(1);
    match (symbols.next(), symbols.next()) {
        (Some((_, '\\')), _) => {
            text[2..].find('\'').map_or(0, |at| if at == 0 { 4 } else { at + 3 })
        }
        (Some(_), Some((at, '\''))) => at + 1,
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_strings_are_no_code() {
        let text =
            "let a = \"std::fs \\\" {\"; // println!(\nlet b = '{'; let c: &'a str = r#\"}\"#;";
        let code = code_only(text);
        assert!(!code.contains("std::fs") && !code.contains("println"), "{code}");
        assert!(!code.contains('{') && !code.contains('}'), "{code}");
        assert!(code.contains("&'a str") && code.lines().count() == 2, "{code}");
        assert!(!code_only("let q = '\\''; \"x\"").contains('x'));
    }

    #[test]
    fn the_outside_world_is_seen_in_libraries_only() {
        assert_eq!(outside_world("crates/a/src/lib.rs", "use std::fs::File;").len(), 1);
        assert!(is_library("crates/frame-fit/src/fit.rs"));
        assert!(!is_library("crates/truing/src/main.rs"));
        assert!(!is_library("crates/frame-fit/tests/it/main.rs"));
    }

    #[test]
    fn functions_are_measured_to_their_closing_brace() {
        let code = "fn a() {\n  if x {\n  }\n}\ntrait T {\n  fn b();\n}\npub fn c() { }\n";
        let found = functions(code);
        let lengths: Vec<_> = found.iter().map(|(_, name, n)| (name.as_str(), *n)).collect();
        assert_eq!(lengths, [("a", 4), ("c", 1)]);
    }

    #[test]
    fn grab_bags_are_found_wherever_they_lie() {
        assert!(grab_bag("crates/a/src/utils.rs").is_some());
        assert!(grab_bag("crates/a/src/common/mod.rs").is_some());
        assert!(grab_bag("crates/a/src/uncommon.rs").is_none());
    }
}
