use std::io::{self, IsTerminal, Write};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Shorter work needs no sign of life.
const QUIET: Duration = Duration::from_secs(1);

/// Often enough to look alive.
const TICK: Duration = Duration::from_millis(250);

/// Shows elapsed time on standard error while it lives, if that is a terminal.
#[derive(Debug)]
pub(crate) struct Spinner {
    running: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Spinner {
    pub(crate) fn start(doing: &'static str) -> Self {
        if !io::stderr().is_terminal() {
            return Self { running: None };
        }
        let (stop, stopped) = mpsc::channel::<()>();
        let thread = std::thread::spawn(move || {
            let started = Instant::now();
            let mut wait = QUIET;
            let mut shown = false;
            while stopped.recv_timeout(wait) == Err(RecvTimeoutError::Timeout) {
                show(&format!("{doing} … {} s", started.elapsed().as_secs()));
                shown = true;
                wait = TICK;
            }
            if shown {
                show("");
            }
        });
        Self { running: Some((stop, thread)) }
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

fn show(text: &str) {
    let mut stderr = io::stderr().lock();
    // A carriage return and «erase to the end of the line».
    let _ = write!(stderr, "\r\x1b[K{text}").and_then(|()| stderr.flush());
}
