//! Does one of the two frames mirror the other?

/// Evidence for and against a mirrored frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Reflection {
    /// What the data say.
    pub verdict: ReflectionVerdict,
    /// Root-mean-square distance left by the best proper map of the family.
    pub proper_rms_mm: f64,
    /// Root-mean-square distance left by the best improper map of the family.
    pub improper_rms_mm: f64,
    /// Log-likelihood of the improper map over that of the proper one.
    pub log_likelihood_ratio: f64,
}

/// What the data say about a mirrored frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum ReflectionVerdict {
    /// A proper map fits decisively better, or the family has no choice.
    Proper,
    /// An improper map fits decisively better: one frame is mirrored.
    Improper,
    /// Both fit about equally well: the points lie in a plane (planar: on a line), or the noise
    /// hides it.
    Undecided,
}
