use serde::Serialize;

use crate::{Header, JudgedRms, LoopParameter, LoopStep};

/// Answer of `truing loop` on a machine; serialises as its JSON.
#[derive(Clone, Debug, Serialize)]
pub struct ClosedMachine {
    /// `machine`.
    pub kind: &'static str,
    /// Version of this crate.
    pub version: &'static str,
    /// Form, program and inputs of all cases.
    #[serde(flatten)]
    pub header: Header,
    /// Name of the machine, as its file says it.
    pub name: Option<String>,
    /// Effects of the machine, with one amplitude for the data of all cases.
    pub steps: Vec<LoopStep>,
    /// What the cases say of each step on their own.
    pub by_case: Vec<StepByCase>,
    /// Every case with them.
    pub cases: Vec<CaseOfMachine>,
    /// Error of all declared models together.
    pub before: JudgedRms,
    /// Error with the machine's effects, and what the cases need beside them.
    pub after: JudgedRms,
    /// `nothing-missing`, `explained`, or what the worst of the cases ends with.
    pub verdict: &'static str,
    /// Notes the user should read.
    pub warnings: Vec<String>,
}

/// An effect of the machine, case by case.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StepByCase {
    /// Catalogue id, as in the step.
    pub effect: String,
    /// Subject, as in the step.
    pub subject: Option<String>,
    /// What the data of each case say of it on their own.
    pub cases: Vec<StepInCase>,
    /// Whether they agree, one entry per amplitude that two cases or more determine.
    pub agreement: Vec<Agreement>,
}

/// An effect of the machine in the data of one case alone.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StepInCase {
    /// Folder of the case.
    pub case: String,
    /// Whether the loop on this case alone names it.
    pub named_alone: bool,
    /// Amplitudes that its data determine.
    pub parameters: Vec<LoopParameter>,
}

/// Whether cases agree about an amplitude.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Agreement {
    /// The amplitude.
    pub parameter: String,
    /// Sum of squares about their weighted mean, in units of their standard uncertainties.
    pub chi2: f64,
    /// Cases less one.
    pub dof: usize,
    /// Chance of more where all measure the same.
    pub p_value: f64,
}

/// A case of a machine.
#[derive(Clone, Debug, Serialize)]
pub struct CaseOfMachine {
    /// Its folder.
    pub case: String,
    /// Its kind.
    pub kind: &'static str,
    /// Verdict of the loop on it alone.
    pub verdict_alone: &'static str,
    /// What that names.
    pub named_alone: Vec<String>,
    /// Error of its declared model.
    pub before: JudgedRms,
    /// Error with the machine's effects as the other cases have them; `None` where they do not
    /// determine them.
    pub with_others: Option<JudgedRms>,
    /// Error with the machine's effects, and what it needs beside them.
    pub after: JudgedRms,
    /// What it needs beside them.
    pub steps: Vec<LoopStep>,
    /// Verdict of the loop on it, the machine's effects taken as declared.
    pub verdict: &'static str,
}
