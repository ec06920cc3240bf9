//! The loop on simulated data whose truth is known.
#![expect(clippy::cast_precision_loss, reason = "counts are small")]

mod classes;
mod contradicted;
mod covariates;
mod declared_variance;
mod degenerate;
mod doubtful;
mod exchange;
mod few_groups;
mod foreseen;
mod interruption;
mod joint;
mod judged;
mod laws;
mod linear_model;
mod local;
mod memory;
mod odd_stretch;
mod patch;
mod position_noise;
mod power;
mod repeats;
mod session;
mod settling;
mod shown;
mod superfluous;
mod unforeseen;
