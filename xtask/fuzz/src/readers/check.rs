//! `truing check` of a case folder.

use truing::{Layout, check, read_case};

use super::bundle::unpack;

pub(super) fn read(bytes: &[u8]) {
    let folder = unpack(bytes);
    match read_case(folder.path()).and_then(|case| check(&case)) {
        Ok(checked) => assert!(!checked.text(Layout::default()).is_empty()),
        Err(error) => assert!(matches!(error.exit_code(), 2 | 3), "{error}"),
    }
}
