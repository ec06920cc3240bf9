use crate::case::quote;

/// Why no measurement can be planned.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlanProblem {
    /// A kind, or a form of it, for which nothing can be proposed.
    #[error(
        "no plan can be made for this case of kind {kind}; there are planners for touches \
         (`probe-comp` without neighbours, `pose-icp`), points of two frames (`frame-fit`), presses, \
         poses and displacements (`ft-center`), targets (`positioning`), the runs of one axis \
         (`tracker-lm`), and those of a head (`force-impedance`, `log.csv`)"
    )]
    NoPlanner {
        /// Kind of the case.
        kind: &'static str,
    },
    /// `[plan]` leaves no place.
    #[error(
        "`[plan]` leaves no place to measure at; widen its region or take keep-out circles off"
    )]
    NoPlace,
    /// The answer leaves no question.
    #[error(
        "there is nothing to plan for: the loop named nothing that has rivals, and every effect is \
         observable; say what for by --for"
    )]
    NothingToAsk,
    /// Rivals were asked about, and there are none that a measurement could tell apart.
    #[error("--for rivals: no step of the answer has rivals of the catalogue")]
    NoRivals,
    /// No effect and no quantity of that name.
    #[error("--for {}: no such effect or quantity; there are {}", quote(found), known.join(", "))]
    UnknownAim {
        /// As given.
        found: String,
        /// Those that there are.
        known: Vec<String>,
    },
    /// A budget in minutes without a time per measurement.
    #[error("a budget in minutes needs `[plan] minutes_per_measurement` in case.toml")]
    NoTime,
    /// Less time than one measurement takes, or none at all.
    #[error("the budget is less than one measurement")]
    NoBudget,
    /// The answer is not of these data.
    #[error("the answer is of other data: {} is not the file that it was made from", quote(file))]
    OtherData {
        /// The first file that differs.
        file: String,
    },
    /// The input is wrong.
    #[error("the loop finds the input wrong ({}); mend it first", quote(effect))]
    WrongInput {
        /// What was found.
        effect: String,
    },
}
