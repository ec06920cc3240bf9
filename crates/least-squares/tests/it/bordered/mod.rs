//! Problems of many small blocks under a few shared parameters.

mod agreement;
mod degenerate;
mod problems;
mod search;
#[cfg(feature = "parallel")]
mod threads;
mod uncertainty;
