use crate::FileProblem;
use crate::case::quote;

/// Why effects cannot be carried from one case to another.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CarryProblem {
    /// The system refuses to hand the file over.
    #[error("{problem}")]
    Unreadable {
        /// Why.
        problem: FileProblem,
    },
    /// Not JSON.
    #[error("is not JSON: {source}; give what `truing loop OTHER --json` prints")]
    NotJson {
        /// What, with line and column.
        source: serde_json::Error,
    },
    /// JSON of something else.
    #[error("is not an answer of the loop: {source}; give what `truing loop OTHER --json` prints")]
    NotAnAnswer {
        /// What, with line and column.
        source: serde_json::Error,
    },
    /// Learnt on a case of another kind.
    #[error("was learnt on a case of kind {}, and this one is of kind {expected}", quote(found))]
    OtherKind {
        /// Kind of the case that the effects were learnt on.
        found: String,
        /// Kind of the case that they are carried to.
        expected: &'static str,
    },
    /// An answer on other touches than those of the case.
    #[error("was not found on the touches of this case: point {} differs", quote(point))]
    OtherMeasurement {
        /// The first point that is not the same.
        point: String,
    },
    /// No effect of that name.
    #[error(
        "the effect {} is not one of this kind; there are {}",
        quote(effect),
        known.join(", ")
    )]
    UnknownEffect {
        /// Its id.
        effect: String,
        /// Those that there are.
        known: Vec<String>,
    },
    /// No amplitude of that name.
    #[error(
        "`{effect}` has no parameter {}; it has {}",
        quote(parameter),
        known.join(", ")
    )]
    UnknownParameter {
        /// The effect.
        effect: String,
        /// The name given.
        parameter: String,
        /// Those that there are.
        known: Vec<String>,
    },
    /// An amplitude in a unit that this case does not use.
    #[error(
        "`{effect}`, parameter `{parameter}`: expected a value in {expected}, found one in {}",
        quote(found)
    )]
    OtherUnit {
        /// The effect.
        effect: String,
        /// Its parameter.
        parameter: String,
        /// Unit given.
        found: String,
        /// Unit in which this case has it.
        expected: String,
    },
    /// An amplitude that is no finite number.
    #[error("`{effect}`, parameter `{parameter}`: the value is not a finite number")]
    NotFinite {
        /// The effect.
        effect: String,
        /// Its parameter.
        parameter: String,
    },
    /// The same name for something that is counted differently.
    #[error(
        "`{effect}` is another thing there: «{}» there, «{here}» here; carry it between cases that \
         declare the same part",
        there.escape_debug()
    )]
    OtherConditions {
        /// The effect.
        effect: String,
        /// What it is in the case that it was learnt on.
        there: String,
        /// What it is in the case that it is carried to.
        here: String,
    },
    /// The same effect a second time.
    #[error("the effect `{effect}` is there twice")]
    Twice {
        /// The effect.
        effect: String,
    },
    /// None of the steps can be carried.
    #[error(
        "holds no effect to carry: {}",
        if left.is_empty() { "the loop had added nothing".to_owned() } else { left.join("; ") }
    )]
    Nothing {
        /// Why not, one reason per step.
        left: Vec<String>,
    },
}
