//! Case folders: `case.toml`, its tables and whatever it names.

use truing::read_case;

use super::bundle::unpack;

pub(super) fn read(bytes: &[u8]) {
    let folder = unpack(bytes);
    match read_case(folder.path()) {
        Ok(case) => assert_eq!(case.sha256().len(), 64, "SHA-256 in hexadecimal digits"),
        Err(error) => assert!(matches!(error.exit_code(), 2 | 3), "{error}"),
    }
}
