//! The table of the statistics, on the screen and in `docs/validation.md`.

use std::fmt::Write as _;

use anyhow::Result;

use crate::generators::sha256;
use crate::kinds::cases;
use crate::page::Block;
use crate::power::Tally;
use crate::power::cell::Question;
use crate::power::wilson::interval;
use crate::shell;

/// Answers printed for a cell that is not good.
const N_ANSWERS: usize = 6;

/// Prints a cell; what was answered instead where it is not as good as it must be.
pub(crate) fn print_line(tally: &Tally) {
    let [krate, situation, question, share, ratio] = columns(tally);
    let mark = if tally.good() { "" } else { "  MISS" };
    println!("{krate:<10} {situation:<46} {question:<34} {share:<24} {ratio}{mark}");
    if !tally.good() {
        for (answer, count) in tally.answers.iter().take(N_ANSWERS) {
            println!("{count:>16} × {answer}");
        }
    }
}

fn columns(tally: &Tally) -> [String; 5] {
    let question = match tally.cell.question {
        Question::FalseAddition => "false additions ≤ 5 %".to_owned(),
        Question::Named(effect) => format!("{effect} named ≥ 95 %"),
        Question::BothNamed([first, second]) => format!("{first} and {second} named ≥ 90 %"),
        Question::ConfidentWrongName => "confident wrong names ≤ 5 %".to_owned(),
        Question::Honest([]) => "left unnamed, and said so ≥ 95 %".to_owned(),
        Question::Honest([effect, ..]) => format!("{effect} named, or said to be left ≥ 95 %"),
        Question::OtherName(effect) => format!("confident names without {effect} ≤ 5 %"),
    };
    let (low, high) = interval(tally.hits, tally.trials);
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let share = 100.0 * tally.hits as f64 / tally.trials as f64;
    [
        tally.cell.krate.to_owned(),
        tally.cell.situation.to_owned(),
        question,
        format!("{share:.1} % [{:.1}, {:.1}]", 100.0 * low, 100.0 * high),
        if tally.ratio.is_finite() { format!("{:.2}", tally.ratio) } else { "–".to_owned() },
    ]
}

/// Replaces the section of each crate in the page; starts one where there is none.
pub(crate) fn write_sections(tallies: &[Tally]) -> Result<()> {
    for of_crate in tallies.chunk_by(|a, b| a.cell.krate == b.cell.krate) {
        let krate = of_crate[0].cell.krate;
        let heading = format!("## {krate}");
        let block = Block { bench: "power", part: Some(krate), heading: &heading };
        block.write(&text(of_crate)?)?;
    }
    Ok(())
}

fn text(tallies: &[Tally]) -> Result<String> {
    let rustc = shell::output_of("rustc", &["--version"])?;
    let fixtures: String =
        cases().iter().map(|case| case.files["provenance.toml"].as_str()).collect();
    let mut block = format!(
        ", {}, fixtures `{}`. {} simulated cases per line through the built program;\n\
         95 % Wilson intervals in brackets. Held out: median over the cases of the error on check\n\
         groups in the end over the error that the noise alone makes there.\n\n\
         | situation | asked | found | held out ÷ noise |\n|---|---|---|---|\n",
        rustc.trim(),
        &sha256(fixtures.as_bytes())[..12],
        tallies.iter().map(|t| t.trials).min().unwrap_or(0),
    );
    for tally in tallies {
        let mark = if tally.good() { "" } else { " **missed**" };
        let [_, situation, question, share, ratio] = columns(tally);
        let _ = writeln!(block, "| {situation} | {question} | {share}{mark} | {ratio} |");
    }
    Ok(block)
}
