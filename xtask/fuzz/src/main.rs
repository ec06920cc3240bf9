//! A reader under libFuzzer, the one that the environment variable `READER` names.

#![no_main]

mod readers;

use std::sync::OnceLock;

use libfuzzer_sys::fuzz_target;
use readers::{READERS, Reader};

static READER: OnceLock<Reader> = OnceLock::new();

fuzz_target!(init: {
    let name = std::env::var("READER").expect("READER names the reader");
    let found = READERS.iter().find(|(known, _)| *known == name);
    let (_, reader) = found.unwrap_or_else(|| panic!("there is no reader `{name}`"));
    READER.get_or_init(|| *reader);
}, |bytes: &[u8]| READER.get().expect("set before the first input")(bytes));
