//! `truing register`: where one cloud or mesh lies on another.

mod answer;
mod command;

pub use answer::{RegisterTiming, Registered};
pub use command::{RegisterSettings, register};
