use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// How far a loop is, for whoever waits: share one with another thread and ask it.
///
/// What takes most of a loop is that the choice is repeated, without each group and with readings
/// moved; these repetitions are counted. Nothing depends on it: two of them are always equal.
#[derive(Clone, Default)]
pub struct Progress {
    counts: Arc<Counts>,
}

#[derive(Default)]
struct Counts {
    done: AtomicUsize,
    known: AtomicUsize,
}

impl Progress {
    /// Repetitions done, and those known of so far; `(0, 0)` before the first.
    #[must_use]
    pub fn repetitions(&self) -> (usize, usize) {
        let known = self.counts.known.load(Ordering::Relaxed);
        (self.counts.done.load(Ordering::Relaxed).min(known), known)
    }

    /// `n` more will be done.
    pub(crate) fn expect(&self, n: usize) {
        self.counts.known.fetch_add(n, Ordering::Relaxed);
    }

    /// One is done.
    pub(crate) fn done(&self) {
        self.counts.done.fetch_add(1, Ordering::Relaxed);
    }
}

impl fmt::Debug for Progress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (done, known) = self.repetitions();
        write!(f, "Progress({done} of {known})")
    }
}

impl PartialEq for Progress {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}
