//! The sections of a page, in reading order.

mod added;
mod apart;
mod budget;
mod context;
mod covariates;
mod declared;
mod error_path;
mod form;
mod headline;
mod left;
mod measured;
mod observable;
mod order;
mod residual;
mod residual_data;
mod residual_table;
mod score;
mod score_table;
mod table;
mod verdict;
mod views;

pub(crate) use added::{added, step_name};
pub(crate) use apart::apart;
pub(crate) use budget::budget;
pub(crate) use context::Context;
pub(crate) use declared::declared;
pub(crate) use error_path::error_path;
pub(crate) use form::form;
pub(crate) use headline::headline;
pub(crate) use left::{left, warnings};
pub(crate) use measured::measured;
pub(crate) use observable::observable;
pub(crate) use residual::{residual_after, residual_before};
pub(crate) use score::scores;
pub(crate) use table::{Cell, Kind, facts, table};
pub(crate) use verdict::{INPUT_WRONG, change, lede, verdict_words};
pub(crate) use views::views;

use super::markup::Markup;

/// Width of a drawing that spans the page, and of its stand-in on a narrow screen.
const WIDE: f64 = 900.0;
const NARROW: f64 = 352.0;
/// Width of a drawing that shares the page with text.
const HALF: f64 = 460.0;
/// Width of a drawing of which several stand side by side.
const SMALL: f64 = 340.0;
/// Components drawn: as many as there are colours.
const MOST_COMPONENTS: usize = 6;

/// Draws for a wide and for a narrow page; the style sheet shows one of the two.
fn for_both(out: &mut Markup, draw: impl Fn(f64, &str) -> Markup) {
    out.append(&draw(WIDE, "plot wide"));
    out.append(&draw(NARROW, "plot narrow"));
}

/// A description as a sentence: catalogues write them without capital and full stop.
fn sentence(text: &str) -> String {
    let mut characters = text.chars();
    let Some(first) = characters.next() else {
        return String::new();
    };
    let end = if text.ends_with(['.', '!', '?']) { "" } else { "." };
    first.to_uppercase().chain(characters).chain(end.chars()).collect()
}

fn paragraph(out: &mut Markup, class: &str, text: &str) {
    if class.is_empty() {
        out.open("p", &[]);
    } else {
        out.open("p", &[("class", &class)]);
    }
    out.prose(text);
    out.close("p");
}
