//! `truing register` of one shape onto another.

use truing::pose_icp::{Objective, RegisterOptions};
use truing::{RegisterSettings, register};

use super::bundle::unpack;

/// The first file of the folder onto the last, by name.
pub(super) fn read(bytes: &[u8]) {
    let folder = unpack(bytes);
    let Ok(entries) = folder.path().read_dir() else { return };
    let mut files: Vec<_> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    files.sort();
    let (Some(source), Some(target)) = (files.first(), files.last()) else { return };
    for objective in [Objective::PointToPlane, Objective::Symmetric, Objective::PointToPoint] {
        let options = RegisterOptions { objective, ..RegisterOptions::default() };
        let settings = RegisterSettings { options, ..RegisterSettings::default() };
        if let Err(error) = register(source, target, &settings) {
            assert!(matches!(error.exit_code(), 2 | 3), "{error}");
        }
    }
}
