//! What is left out in turn.

/// What is left out together when the error on unseen data is judged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum HoldOut {
    /// A stop of the axis: its six errors are taken from itself.
    #[default]
    Step,
    /// A reflector: its place is taken from the first stop at which it was seen, and corrected at
    /// every later one by those before.
    Mount,
}
