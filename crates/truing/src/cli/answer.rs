//! Answers of commands, as the command line shows them.

use serde::Serialize;
use truing::{Estimates, Layout};

/// An answer that can be shown as text, as JSON, and as a page.
pub(super) trait Answer: Serialize {
    fn warnings(&self) -> &[String];
    /// How tables were understood that are not written as the format says.
    fn notes(&self) -> &[String];
    /// For people.
    fn text(&self, layout: Layout) -> String;
    /// Leaves out what differs from run to run.
    fn forget_timing(&mut self);
}

/// What every answer has under the same names; those with a time have `timed` behind them.
macro_rules! answers {
    ($($answer:ident $($timed:ident)?),* $(,)?) => { $(
        impl Answer for truing::$answer {
            fn warnings(&self) -> &[String] {
                &self.warnings
            }

            fn notes(&self) -> &[String] {
                &self.header.notes
            }

            fn text(&self, layout: Layout) -> String {
                self.text(layout)
            }

            fn forget_timing(&mut self) {
                $( let $timed = &mut self.timing; *$timed = None; )?
            }
        }
    )* };
}

answers! {
    Solved timed,
    Closed timed,
    ClosedMachine,
    Depth,
    Guides,
    Itlicp timed,
    Registered timed,
    Planned,
    Checked,
}

/// An answer with estimates.
pub(super) trait Estimated: Answer {
    fn kind(&self) -> &'static str;
    fn estimates(&self) -> &dyn Estimates;
}

macro_rules! estimated {
    ($($answer:ident),*) => { $(
        impl Estimated for truing::$answer {
            fn kind(&self) -> &'static str {
                self.kind
            }

            fn estimates(&self) -> &dyn Estimates {
                &*self.estimates
            }
        }
    )* };
}

estimated!(Solved, Closed);
