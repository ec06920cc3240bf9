//! One situation, what is true in it, and what was counted.

use std::collections::BTreeMap;

/// Files of a case, and the truths that belong to it.
pub(crate) type Simulated = (Vec<(&'static str, String)>, Vec<Truth>);

/// One situation.
pub(crate) struct Situation {
    pub(crate) krate: &'static str,
    /// In words.
    pub(crate) name: &'static str,
    /// What the loop must have accepted for its answer to count, with its subject in brackets where
    /// another subject's size is another quantity; `None`: nothing.
    pub(crate) effect: Option<&'static str>,
    pub(crate) make: fn(u64) -> Simulated,
}

/// A number whose truth the simulator knows.
#[derive(Clone, Debug)]
pub(crate) struct Truth {
    /// What it is called in the table; several of one name are counted together.
    pub(crate) name: &'static str,
    /// Where the answer has it.
    pub(crate) value: String,
    /// Where the answer has its standard uncertainty.
    pub(crate) std: String,
    /// Where the answer has its 95 % interval, if it may have one that is not symmetric.
    pub(crate) interval: Option<String>,
    /// What it should be.
    pub(crate) known: f64,
}

/// What the loops of one situation gave.
pub(crate) struct Tally {
    pub(crate) situation: Situation,
    /// Loops in which the right effect, and nothing else, was accepted.
    pub(crate) named: usize,
    pub(crate) loops: usize,
    /// Of every quantity, loop by loop.
    pub(crate) held: BTreeMap<&'static str, Vec<Held>>,
}

/// One quantity in one loop.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Held {
    /// Intervals that hold the truth.
    pub(crate) held: u32,
    /// Intervals.
    pub(crate) all: u32,
}

/// How often intervals of one quantity hold the truth.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coverage {
    pub(crate) share: f64,
    /// Standard error of the share; intervals of one loop are not independent, loops are.
    pub(crate) std: f64,
    pub(crate) intervals: u32,
}

/// The share of all intervals, and its standard error by loops (a ratio estimate).
pub(crate) fn coverage(loops: &[Held]) -> Coverage {
    let intervals = loops.iter().map(|l| l.all).sum();
    let share = f64::from(loops.iter().map(|l| l.held).sum::<u32>()) / f64::from(intervals);
    let square = |l: &Held| (f64::from(l.held) - share * f64::from(l.all)).powi(2);
    let std = loops.iter().map(square).sum::<f64>().sqrt() / f64::from(intervals);
    Coverage { share, std, intervals }
}

pub(crate) fn truth(name: &'static str, value: String, std: String, known: f64) -> Truth {
    Truth { name, value, std, interval: None, known }
}

/// Amplitude `k` of the effect that was accepted.
pub(crate) fn size_of_effect(k: usize, size: f64) -> Truth {
    let (value, std) =
        (format!("steps.0.parameters.{k}.value"), format!("steps.0.parameters.{k}.std"));
    truth("size of the effect", value, std, size)
}
