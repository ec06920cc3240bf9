//! The motions of successive passes, and what they tell of the next.

/// A motion above this share of the one before does not come from rows that are linearised: those of
/// planes leave far less of it.
const NO_LESS: f64 = 0.5;

/// How far the passes over one level moved the points.
pub(super) struct Motions {
    pub(super) last_mm: f64,
    pub(super) before_mm: f64,
    smallest_mm: f64,
    /// Passes since the smallest.
    pub(super) waited: usize,
    pub(super) last_sigmas: f64,
    pub(super) before_sigmas: f64,
}

impl Default for Motions {
    fn default() -> Self {
        let none = f64::INFINITY;
        Self {
            last_mm: none,
            before_mm: none,
            smallest_mm: none,
            waited: 0,
            last_sigmas: none,
            before_sigmas: none,
        }
    }
}

impl Motions {
    pub(super) fn add(&mut self, motion_mm: f64, sigmas: f64) {
        self.before_sigmas = self.last_sigmas;
        self.last_sigmas = sigmas;
        self.before_mm = self.last_mm;
        self.last_mm = motion_mm;
        self.waited = if motion_mm < self.smallest_mm { 0 } else { self.waited + 1 };
        self.smallest_mm = self.smallest_mm.min(motion_mm);
    }

    /// The next motion, if it becomes smaller as the last one did; `None` before there are two.
    pub(super) fn next_mm(&self) -> Option<f64> {
        let ratio = self.last_mm / self.before_mm;
        (self.before_mm.is_finite() && ratio < NO_LESS).then_some(ratio * self.last_mm)
    }

    /// Whether motions of at most this have stopped to become smaller.
    pub(super) fn are_restless(&self, at_most_sigmas: f64) -> bool {
        self.last_sigmas.max(self.before_sigmas) <= at_most_sigmas
            && self.last_mm >= NO_LESS * self.before_mm
    }
}
