use crate::case::{list, quote};

/// Why cases cannot be taken together.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MachineProblem {
    /// Fewer than two cases.
    #[error(
        "{found} cases are listed; a machine needs two at least: give each a `[[case]]` with its \
         `folder`"
    )]
    TooFewCases {
        /// Cases.
        found: usize,
    },
    /// One folder twice.
    #[error("{} is listed twice; its data would count twice", quote(folder))]
    Twice {
        /// The folder.
        folder: String,
    },
    /// A folder outside of that of the machine.
    #[error(
        "{} lies outside of the machine's folder; move it there, or allow it by --allow-outside",
        quote(folder)
    )]
    Outside {
        /// The folder.
        folder: String,
    },
    /// Residuals of several units.
    #[error(
        "residuals of {} cannot be joined: they are in {}; leave out those in another unit",
        list(cases), units.join(" and ")
    )]
    OtherUnits {
        /// Names of the cases.
        cases: Vec<String>,
        /// Their units.
        units: Vec<String>,
    },
    /// A name that fewer than two cases know.
    #[error(
        "`shared`: no two of these cases have {}; two or more have {}",
        quote(effect), if known.is_empty() { "nothing in common".to_owned() } else { list(known) }
    )]
    NotShared {
        /// As given.
        effect: String,
        /// Effects that could be shared.
        known: Vec<String>,
    },
    /// A case whose input is wrong.
    #[error(
        "the input of {} is wrong: {mistake}; correct it first, with the other cases it would pass \
         for the machine's",
        quote(case)
    )]
    InputWrong {
        /// Name of the case.
        case: String,
        /// What its own loop says.
        mistake: String,
    },
    /// A folder of several cases where one is wanted.
    #[error(
        "several cases are listed here, and only `truing loop` takes them together: give one of \
             their folders"
    )]
    NotOneCase,
    /// An option that is about one case.
    #[error("{option} is for single cases: close the loop on the case for it")]
    OneCaseOnly {
        /// As written on the command line.
        option: &'static str,
    },
}
