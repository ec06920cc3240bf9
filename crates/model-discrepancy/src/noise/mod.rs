//! What the noise may be: white, or depending on what was measured before.

pub(crate) mod linear;
pub(crate) mod neighbours;
pub(crate) mod noise_models;
pub(crate) mod reach;
pub(crate) mod whitening;
