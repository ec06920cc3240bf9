//! The table of coverage, printed and in `docs/validation.md`.

use std::fmt::Write as _;

use anyhow::Result;

use super::situation::{Tally, coverage};
use crate::page::Block;

/// Coverage that is asked of a 95 % interval.
const ASKED: std::ops::RangeInclusive<f64> = 0.93..=0.97;

/// One line per quantity.
pub(crate) fn print_lines(tally: &Tally) {
    for (name, loops) in &tally.held {
        let covered = coverage(loops);
        println!(
            "{}  {}  {name}  {:.1} ± {:.1} % of {} ({} of {} loops)",
            tally.situation.krate,
            tally.situation.name,
            100.0 * covered.share,
            100.0 * covered.std,
            covered.intervals,
            tally.named,
            tally.loops
        );
    }
}

/// Rewrites the block of every crate that was run.
pub(crate) fn write_blocks(tallies: &[Tally]) -> Result<()> {
    for of_crate in tallies.chunk_by(|a, b| a.situation.krate == b.situation.krate) {
        let krate = of_crate[0].situation.krate;
        let heading = format!("### {krate}");
        let block = Block { bench: "coverage", part: Some(krate), heading: &heading };
        block.write(&text(of_crate))?;
    }
    Ok(())
}

fn text(tallies: &[Tally]) -> String {
    let mut block =
        ". Loops in which the right effect and nothing else was accepted, and how many of \
         their 95 % intervals hold the truth, ± one standard error by loops.\n\n\
         | situation | loops | quantity | hold the truth |\n|---|---|---|---|\n"
            .to_owned();
    for tally in tallies {
        for (name, loops) in &tally.held {
            let covered = coverage(loops);
            let mark = if ASKED.contains(&covered.share) { "" } else { " **missed**" };
            let (percent, std) = (100.0 * covered.share, 100.0 * covered.std);
            let (named, loops, all) = (tally.named, tally.loops, covered.intervals);
            let _ = writeln!(
                block,
                "| {} | {named} of {loops} | {name} | {percent:.1} ± {std:.1} % of {all}{mark} |",
                tally.situation.name
            );
        }
    }
    block
}
