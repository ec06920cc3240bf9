//! One simulated case through the loop.

use std::path::Path;

use anyhow::Result;

use crate::power::cell::{Cell, Question};
use crate::program::{Truing, class_of, number_at};

/// What one case gave.
#[derive(Clone, Debug)]
pub(crate) struct Trial {
    /// Whether the question of the cell is answered with yes.
    pub(crate) hit: bool,
    /// Held-out error in the end over what the noise alone makes.
    pub(crate) ratio: Option<f64>,
    /// The answer in a line: effects and verdict, or why there is none.
    pub(crate) answer: String,
}

/// Simulates, runs and judges one seed, in a folder of the caller's own.
pub(crate) fn run(truing: &Truing, cell: &Cell, seed: u64, folder: &Path) -> Result<Trial> {
    let simulated = cell.scene(seed).simulate();
    let case = folder.join(cell.krate);
    let answer = truing.asked("loop", simulated.files, &case)?;
    if answer.code != Some(0) {
        // No answer counts against every question.
        let asks_for_names = matches!(
            cell.question,
            Question::Named(_) | Question::BothNamed(_) | Question::Honest(_)
        );
        let hit = !asks_for_names;
        return Ok(Trial { hit, ratio: None, answer: failure(&answer.message) });
    }
    let steps = answer.json["steps"].as_array().cloned().unwrap_or_default();
    let classes: Vec<Vec<&str>> = steps.iter().map(class_of).collect();
    let verdict = answer.json["verdict"].as_str().unwrap_or("none");
    let names: Vec<&str> = classes.iter().filter_map(|class| class.last().copied()).collect();
    let hit = match cell.question {
        Question::FalseAddition => !names.is_empty(),
        Question::Named(truth) => {
            !classes.is_empty() && classes.iter().all(|class| class.contains(&truth))
        }
        Question::BothNamed(truths) => {
            let names_one = |class: &Vec<&str>| truths.iter().any(|truth| class.contains(truth));
            let is_named = |truth: &&str| classes.iter().any(|class| class.contains(truth));
            classes.len() >= truths.len()
                && classes.iter().all(names_one)
                && truths.iter().all(is_named)
        }
        Question::Honest(truths) => {
            let is_true = |class: &&Vec<&str>| {
                class.iter().any(|name| truths.iter().any(|truth| name.contains(truth)))
            };
            let n_true = classes.iter().filter(is_true).count();
            let rest: Vec<_> = classes.iter().filter(|class| !is_true(class)).collect();
            let says_so = ["structure-remains", "noise-larger-than-declared"].contains(&verdict);
            rest.iter().all(|class| is_column(class)) && (n_true > 0 || says_so)
        }
        Question::ConfidentWrongName => {
            verdict == "explained" && classes.iter().any(|class| names_catalogue_alone(class))
        }
        Question::OtherName(truth) => {
            let is_other = |class: &Vec<&str>| !class.contains(&truth);
            let wrong = |class| is_other(class) && names_catalogue_alone(class);
            verdict == "explained" && classes.iter().any(wrong)
        }
    };
    let held_out = number_at(&answer.json, "after.held_out_rms");
    Ok(Trial {
        hit,
        ratio: held_out.map(|error| error / simulated.noise),
        answer: format!("{} → {verdict}", names.join(" + ")),
    })
}

/// Whether a class holds columns of the data alone, and not the order of the readings.
fn is_column(class: &[&str]) -> bool {
    class.iter().all(|name| name.starts_with("covariate:") && !name.contains("order"))
}

/// Whether a class holds names of the catalogue and no covariate: one with a covariate among its
/// rivals says itself that the name is not sure.
fn names_catalogue_alone(class: &[&str]) -> bool {
    class.iter().all(|name| !name.starts_with("covariate:"))
}

/// The first two lines of a message without the numbers of processes, so that equal ones count
/// together.
fn failure(message: &str) -> String {
    let is_number = |c: char| c.is_ascii_digit();
    let lines = message.lines().take(2).map(|line| line.replace(is_number, ""));
    format!("failed: {}", lines.collect::<Vec<_>>().join(" "))
}
