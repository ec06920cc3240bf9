/// Slot that stands for «nothing within reach».
pub(crate) const NONE: u32 = u32::MAX;

/// Nearest point of one query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Found {
    /// Its slot, or [`NONE`].
    pub(crate) slot: u32,
    /// How much nearer it is than any other point, at least; the query may move by half of it.
    pub(crate) lead_mm: f32,
}

impl Found {
    pub(crate) const NOTHING: Self = Self { slot: NONE, lead_mm: 0.0 };
}
