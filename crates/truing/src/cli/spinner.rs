use std::io::{self, IsTerminal, Write};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use truing::model_discrepancy::Progress;

/// Shorter work needs no sign of life.
const QUIET: Duration = Duration::from_secs(1);

/// Often enough to look alive.
const TICK: Duration = Duration::from_millis(250);

/// Shows on standard error, if that is a terminal, how long a command works and, where repetitions
/// are counted, how long it will.
#[derive(Debug)]
pub(crate) struct Spinner {
    running: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Spinner {
    pub(crate) fn start(doing: &'static str, quiet: bool, progress: &Progress) -> Self {
        if quiet || !io::stderr().is_terminal() {
            return Self { running: None };
        }
        let (stop, stopped) = mpsc::channel::<()>();
        let progress = progress.clone();
        let thread = std::thread::Builder::new().spawn(move || {
            let started = Instant::now();
            let mut repeating: Option<Instant> = None;
            let mut wait = QUIET;
            let mut shown = false;
            while stopped.recv_timeout(wait) == Err(RecvTimeoutError::Timeout) {
                let counted = progress.repetitions();
                if counted.1 > 0 {
                    repeating.get_or_insert_with(Instant::now);
                }
                let repeating = repeating.map_or(Duration::ZERO, |since| since.elapsed());
                show(&line(doing, started.elapsed(), counted, repeating));
                shown = true;
                wait = TICK;
            }
            if shown {
                show("");
            }
        });
        // Where there are no threads, as in a browser, nobody watches.
        Self { running: thread.ok().map(|thread| (stop, thread)) }
    }
}

impl Drop for Spinner {
    fn drop(&mut self) {
        if let Some((stop, thread)) = self.running.take() {
            drop(stop);
            // A spinner that failed must not fail the command.
            let _ = thread.join();
        }
    }
}

/// What is shown: time so far, repetitions done of those known, and the time that the rest takes if
/// each takes as long as those before it.
fn line(
    doing: &str,
    elapsed: Duration,
    (done, known): (usize, usize),
    repeating: Duration,
) -> String {
    let elapsed = elapsed.as_secs();
    if known == 0 {
        return format!("{doing} … {elapsed} s");
    }
    let counted = format!("{doing} … {elapsed} s, repetition {done} of {known}");
    let Ok(n) = u32::try_from(done) else { return counted };
    if n == 0 || done >= known {
        return counted;
    }
    let rest = u32::try_from(known - done).unwrap_or(u32::MAX);
    let left = repeating.saturating_mul(rest) / n;
    format!("{counted}, about {} s left", left.as_secs() + 1)
}

fn show(text: &str) {
    let mut stderr = io::stderr().lock();
    // A carriage return and «erase to the end of the line».
    let _ = write!(stderr, "\r\x1b[K{text}").and_then(|()| stderr.flush());
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::line;

    #[test]
    fn the_rest_takes_as_long_as_what_was_done() {
        let s = Duration::from_secs;
        assert_eq!(line("closing the loop", s(3), (0, 0), s(0)), "closing the loop … 3 s");
        assert_eq!(line("x", s(9), (0, 24), s(4)), "x … 9 s, repetition 0 of 24");
        let expected = "x … 9 s, repetition 6 of 24, about 13 s left";
        assert_eq!(line("x", s(9), (6, 24), s(4)), expected);
        assert_eq!(line("x", s(9), (24, 24), s(4)), "x … 9 s, repetition 24 of 24");
    }
}
