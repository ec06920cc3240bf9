//! Everything that leaves the process, but for files.

use std::fmt::Display;
use std::io::{self, ErrorKind, IsTerminal, Write};

use serde::Serialize;
use truing::Error;

/// One JSON object on standard output.
pub(crate) fn json(answer: &impl Serialize) -> Result<(), Error> {
    let text = serde_json::to_string_pretty(answer).expect("plain data with text keys");
    to_stdout(format_args!("{text}\n"))
}

/// One JSON object on a line of standard output.
pub(crate) fn line(answer: &impl Serialize) -> Result<(), Error> {
    let text = serde_json::to_string(answer).expect("plain data with text keys");
    to_stdout(format_args!("{text}\n"))
}

/// Text for people on standard output.
pub(crate) fn text(text: &impl Display) -> Result<(), Error> {
    to_stdout(format_args!("{text}"))
}

/// An answer for people on standard output, no wider than the terminal there.
pub(crate) fn answer(text: &str) -> Result<(), Error> {
    match columns() {
        Some(columns) => to_stdout(format_args!("{}", folded(text, columns))),
        None => to_stdout(format_args!("{text}")),
    }
}

/// Columns of the terminal that shows standard output; `None` where none does.
pub(crate) fn columns() -> Option<usize> {
    columns_of(&io::stdout())
}

/// Columns of the terminal that shows what is written to `stream`.
fn columns_of(stream: &impl IsTerminal) -> Option<usize> {
    if !stream.is_terminal() {
        return None;
    }
    let (terminal_size::Width(columns), _) = terminal_size::terminal_size()?;
    // One that says it has none, or next to none, does not know.
    Some(usize::from(columns)).filter(|&columns| columns >= LEAST_COLUMNS)
}

const LEAST_COLUMNS: usize = 20;

/// Text whose lines are broken between words where they are wider than `columns`, and go on
/// farther in than they began.
fn folded(text: &str, columns: usize) -> String {
    let fold = |line: &str| {
        let indent = " ".repeat(line.len() - line.trim_start().len() + 4);
        textwrap::fill(line, textwrap::Options::new(columns).subsequent_indent(&indent))
    };
    text.split('\n').map(fold).collect::<Vec<_>>().join("\n")
}

/// How files were understood.
pub(crate) fn notes(notes: &[String]) {
    for note in notes {
        to_stderr("note", note);
    }
}

pub(crate) fn warnings(warnings: &[String]) {
    for warning in warnings {
        to_stderr("warning", warning);
    }
}

pub(crate) fn error(error: &Error) {
    to_stderr("error", &error.to_string());
}

/// Makes a limit on the size of files an error like any other, in place of the end of the process
/// in the middle of a file.
pub(crate) fn survive_size_limit() {
    #[cfg(unix)]
    {
        let seen = std::sync::Arc::default();
        // Where the system refuses, a limit ends the process as it would have before.
        let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, seen);
    }
}

fn to_stdout(text: std::fmt::Arguments<'_>) -> Result<(), Error> {
    let mut stdout = io::stdout().lock();
    match stdout.write_fmt(text).and_then(|()| stdout.flush()) {
        // Whoever read our output has seen enough.
        Err(e) if e.kind() == ErrorKind::BrokenPipe => Ok(()),
        Err(e) => Err(Error::NotWritten { path: "standard output".into(), reason: e.kind() }),
        Ok(()) => Ok(()),
    }
}

/// One line, which names out of files must not break up; a terminal gets it broken between words.
fn to_stderr(label: &str, message: &str) {
    let message: String = message.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let line = format!("{label}: {message}");
    let line =
        columns_of(&io::stderr()).map_or_else(|| line.clone(), |columns| folded(&line, columns));
    // Nobody is left to tell when standard error is closed.
    let _ = writeln!(io::stderr().lock(), "{line}");
}

#[cfg(test)]
mod tests {
    use super::folded;

    #[test]
    fn long_lines_go_on_farther_in() {
        let text = "verdict\n  scale: the two frames differ\n\n";
        assert_eq!(folded(text, 20), "verdict\n  scale: the two\n      frames differ\n\n");
        assert_eq!(folded(text, 80), text);
        // Dashes and dots of a table are one column wide.
        let row = "  -90.000 – – – … 5";
        assert_eq!(folded(row, row.chars().count()), row);
    }
}
