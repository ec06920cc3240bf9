//! Case folders: what is read, and what is said when it cannot be.

mod columns;
mod dialect;
mod document;
mod edit;
mod encoding;
mod extras;
mod folder;
mod group;
mod ledger;
mod location;
mod loop_settings;
mod nearest;
mod number;
mod problem;
mod provenance;
mod quote;
mod table;
mod unit;

pub(crate) use columns::Columns;
pub(crate) use dialect::{Writing, with_point, writing};
pub(crate) use document::{CASE_FILE, Document};
pub(crate) use edit::{Change, Edit};
pub(crate) use encoding::decode;
pub(crate) use extras::{Extras, NumberColumn};
pub(crate) use folder::Folder;
pub use folder::ReadOptions;
pub(crate) use group::{group_name, group_names, no_column};
pub(crate) use ledger::Ledger;
pub use location::Location;
pub(crate) use loop_settings::LoopSettings;
pub(crate) use nearest::nearest;
pub(crate) use number::{Finite, Positive};
pub use problem::Problem;
pub use provenance::Provenance;
pub(crate) use quote::{list, quote};
pub(crate) use table::Table;
