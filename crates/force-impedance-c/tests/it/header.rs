//! The committed header is what the source says.

use std::path::Path;

use cbindgen::{Builder, Config};

/// Public items, in the order of the header.
const SOURCES: [&str; 7] = [
    "error.rs",
    "head.rs",
    "contact.rs",
    "settings.rs",
    "command.rs",
    "controller.rs",
    "explain.rs",
];
/// Set to write the header instead of comparing.
const WRITE: &str = "WRITE_C_HEADER";

#[test]
fn the_header_is_up_to_date() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut builder =
        Builder::new().with_config(Config::from_file(root.join("cbindgen.toml")).unwrap());
    for source in SOURCES {
        builder = builder.with_src(root.join("src").join(source));
    }
    let mut written = Vec::new();
    builder.generate().unwrap().write(&mut written);
    let path = root.join("include/force_impedance.h");
    if std::env::var_os(WRITE).is_some() {
        std::fs::write(&path, &written).unwrap();
    }
    let committed = std::fs::read(&path).unwrap();
    assert!(
        committed == written,
        "include/force_impedance.h is out of date: \
         {WRITE}=1 cargo test --package force-impedance-c header"
    );
}

/// Every function of the source is in the header: a new file that is not listed would not be.
#[test]
fn no_function_is_missing() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let header = std::fs::read_to_string(root.join("include/force_impedance.h")).unwrap();
    let mut found = 0;
    for entry in std::fs::read_dir(root.join("src")).unwrap() {
        let text = std::fs::read_to_string(entry.unwrap().path()).unwrap();
        for (_, after) in
            text.match_indices("extern \"C\" fn ").map(|(at, m)| text.split_at(at + m.len()))
        {
            let name = after.split('(').next().unwrap();
            assert!(
                header.contains(&format!(" {name}(")) || header.contains(&format!("*{name}(")),
                "{name}"
            );
            found += 1;
        }
    }
    assert!(found >= 14, "{found}");
}
