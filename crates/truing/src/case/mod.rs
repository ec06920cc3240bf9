//! Case folders: what is read, and what is said when it cannot be.

mod columns;
mod document;
mod extras;
mod folder;
mod group;
mod location;
mod loop_settings;
mod nearest;
mod number;
mod problem;
mod provenance;
mod quote;
mod read;
mod table;
mod unit;

pub(crate) use columns::Columns;
pub(crate) use document::Document;
pub(crate) use extras::{Extras, NumberColumn};
pub(crate) use folder::Folder;
pub(crate) use group::{group_name, group_names, no_column};
pub use location::Location;
pub(crate) use loop_settings::LoopSettings;
pub(crate) use nearest::nearest;
pub(crate) use number::{Finite, Positive};
pub use problem::Problem;
pub(crate) use quote::quote;
pub use read::{Case, read_case};
pub(crate) use table::Table;
