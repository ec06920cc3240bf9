//! Everything that leaves the process, but for files.

use std::fmt::Display;
use std::io::{self, ErrorKind, Write};

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

/// One line: names out of files must not break it up.
fn to_stderr(label: &str, message: &str) {
    let message: String = message.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    // Nobody is left to tell when standard error is closed.
    let _ = writeln!(io::stderr().lock(), "{label}: {message}");
}
