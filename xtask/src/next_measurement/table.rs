//! The table of plans, printed and in `docs/plan.md`.

use std::fmt::Write as _;
use std::fs;

use anyhow::{Context, Result};

use super::Tally;
use crate::shell;

const PAGE: &str = "docs/plan.md";
const BEGIN: &str = "<!-- table: `cargo xtask bench plan` -->\n";
const END: &str = "<!-- end -->";

pub(super) fn print_line(tally: &Tally) {
    println!("{}", line(tally));
}

fn line(tally: &Tally) -> String {
    let Tally { runs, before, plans, reached, even, even_twice, .. } = tally;
    let planned = match (tally.planned, tally.planned_alone) {
        (all, alone) if all == alone => all.to_string(),
        (all, alone) => format!("{all}, alone {alone}"),
    };
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let mean = tally.measurements as f64 / (*plans).max(1) as f64;
    format!(
        "{}{runs} | {before} | {mean:.1} | {reached} of {plans} | {planned} | {even} | {even_twice} |",
        beginning((tally.krate, tally.name))
    )
}

/// Cells that say which situation a line is of.
fn beginning((krate, name): (&str, &str)) -> String {
    format!("| {krate} | {name} | ")
}

/// Writes the line of one situation into the table of the page, with the commit of the tree; of the
/// other `situations` stays what there is.
pub(super) fn write(tally: &Tally, situations: &[(&str, &str)]) -> Result<()> {
    let commit = shell::output_of("git", &["rev-parse", "--short=8", "HEAD"])?;
    let path = shell::root().join(PAGE);
    let page = fs::read_to_string(&path).context(PAGE)?;
    let new = format!("{} `{}` |", line(tally), commit.trim());
    fs::write(&path, replaced(&page, (tally.krate, tally.name), &new, situations)?).context(PAGE)
}

fn replaced(
    page: &str,
    of: (&str, &str),
    new: &str,
    situations: &[(&str, &str)],
) -> Result<String> {
    let (above, rest) = page.split_once(BEGIN).context("no place for the table")?;
    let (old, below) = rest.split_once(END).context("no end of the table")?;
    let mut table = String::from(
        "| crate | what is wrong | runs | right name alone before | planned, mean | said to reach it | \
         right name or class alone with the plan | with as many spread evenly | with twice as many | commit |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
    );
    for situation in situations {
        let is_it = |line: &&str| line.starts_with(&beginning(*situation));
        let line = if *situation == of { Some(new) } else { old.lines().find(is_it) };
        if let Some(line) = line {
            let _ = writeln!(table, "{line}");
        }
    }
    Ok(format!("{above}{BEGIN}{table}{END}{below}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_line_is_replaced_and_those_without_a_situation_go() {
        let situations = [("a", "one"), ("a", "two"), ("b", "one")];
        let page = format!("above\n{BEGIN}head\n| a | gone | 1 |\n| b | one | 1 |\n{END}\nbelow\n");
        let page = replaced(&page, ("a", "two"), "| a | two | 100 |", &situations).unwrap();
        let lines: Vec<&str> = page.lines().collect();
        assert_eq!(lines[4..], ["| a | two | 100 |", "| b | one | 1 |", "<!-- end -->", "below"]);
        assert!(lines[2].starts_with("| crate |"), "{page}");
    }
}
