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
    let Tally { krate, name, runs, before, plans, reached, even, even_twice, .. } = tally;
    let planned = match (tally.planned, tally.planned_alone) {
        (all, alone) if all == alone => all.to_string(),
        (all, alone) => format!("{all}, alone {alone}"),
    };
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let mean = tally.measurements as f64 / (*plans).max(1) as f64;
    format!(
        "| {krate} | {name} | {runs} | {before} | {mean:.1} | {reached} of {plans} | {planned} | \
         {even} | {even_twice} |"
    )
}

/// Rewrites the table of the page.
pub(super) fn write(tallies: &[Tally]) -> Result<()> {
    let path = shell::root().join(PAGE);
    let page = fs::read_to_string(&path).context(PAGE)?;
    let (above, rest) = page.split_once(BEGIN).context("no place for the table")?;
    let (_, below) = rest.split_once(END).context("no end of the table")?;
    let mut table = String::from(
        "| crate | what is wrong | runs | right name alone before | planned, mean | said to reach it | \
         right name or class alone with the plan | with as many spread evenly | with twice as many |\n\
         |---|---|---|---|---|---|---|---|---|\n",
    );
    for tally in tallies {
        let _ = writeln!(table, "{}", line(tally));
    }
    fs::write(&path, format!("{above}{BEGIN}{table}{END}{below}")).context(PAGE)
}
