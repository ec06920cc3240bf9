//! Which effects are added, one a pass.

pub(crate) mod additivity;
pub(crate) mod beside;
pub(crate) mod blocks;
pub(crate) mod candidate;
pub(crate) mod context;
pub(crate) mod detectable;
pub(crate) mod exchange;
pub(crate) mod grown;
pub(crate) mod interruption;
pub(crate) mod level;
pub(crate) mod masked;
pub(crate) mod one_observation;
pub(crate) mod pair;
pub(crate) mod ranking;
pub(crate) mod replace;
pub(crate) mod score;
pub(crate) mod score_shapes;
pub(crate) mod screening;
pub(crate) mod select;
pub(crate) mod selected;
pub(crate) mod sets;
pub(crate) mod shape;
pub(crate) mod shapes;
pub(crate) mod tail;
