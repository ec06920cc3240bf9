//! What was found, how sure it is, and what it is worth.

pub(crate) mod assess;
mod changing_size;
pub(crate) mod close_loop;
pub(crate) mod closure;
mod common_errors;
pub(crate) mod confounded;
pub(crate) mod confusable;
mod constancy;
pub(crate) mod contradiction;
pub(crate) mod estimate;
pub(crate) mod external_validation;
pub(crate) mod foreseen;
mod found_again;
pub(crate) mod left_over;
mod named_size;
pub(crate) mod opened;
pub(crate) mod separation;
pub(crate) mod structure;
pub(crate) mod summary;
pub(crate) mod unseen;
pub(crate) mod unsupported;
pub(crate) mod verdict;
mod without_tails;
