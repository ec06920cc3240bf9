//! frame-fit
