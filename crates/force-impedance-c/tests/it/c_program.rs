//! The example in C, compiled and run.

use std::process::Command;

use crate::library::{SYSTEM, archive, has, output_of, root};

/// Compiles `examples/press.c` with a compiler and runs it; what it prints.
fn run(compiler: &str, flags: &[&str]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("press");
    let mut compile = Command::new(compiler);
    compile.args(flags).args(["-Wall", "-Wextra", "-Werror", "-pedantic", "-O1", "-I"]);
    compile.arg(root().join("include")).arg(root().join("examples/press.c"));
    output_of(compile.args(["-x", "none"]).arg(archive()).args(SYSTEM).arg("-o").arg(&program));
    output_of(&mut Command::new(program))
}

#[test]
fn a_program_in_c_reaches_the_reference() {
    if has("cc", "--version") {
        let said = run("cc", &["-std=c99", "-x", "c"]);
        assert!(said.contains("force 30.0 N after 1000 cycles"), "{said}");
    }
}

#[test]
fn the_header_is_good_for_cpp_too() {
    if has("c++", "--version") {
        let said = run("c++", &["-std=c++11", "-x", "c++"]);
        assert!(said.contains("force 30.0 N after 1000 cycles"), "{said}");
    }
}
