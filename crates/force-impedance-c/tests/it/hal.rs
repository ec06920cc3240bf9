//! The LinuxCNC component in a simulated thread of 1 kHz, against a spring.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;

use crate::library::{has, output_of, root};

const COMPONENT: &str = "force_impedance";
/// Modules of LinuxCNC that the run loads beside it.
const MODULES: [&str; 5] = ["threads", "siggen", "scale", "limit1", "hal_lib"];
const MODULE_FOLDER: &str = "/usr/lib/linuxcnc/modules";
/// A user of no rights, under whom LinuxCNC runs where a test is root.
const NOBODY: &str = "65534";

#[test]
fn the_component_reaches_the_reference_on_a_spring() {
    let installed = has("halrun", "-h") && has("halcompile", "--help") && can_shadow_modules();
    if !installed {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    compile(at);
    let said = press(at);
    let pin = |name: &str| -> String {
        let wanted = format!("force-impedance.0.{name}");
        let is_it = |line: &&str| line.split_whitespace().nth(4) == Some(wanted.as_str());
        let line = said.lines().find(is_it).unwrap_or_default();
        line.split_whitespace().nth(3).unwrap_or_default().to_owned()
    };
    assert_eq!((pin("contact").as_str(), pin("fault").as_str()), ("TRUE", "0x00000000"), "{said}");
    let force_n: f64 = pin("force").parse().unwrap_or(f64::NAN);
    // The bracing of the legs wanders by 1 mN, HAL prints seven digits.
    assert!((force_n - 30.0).abs() < 0.01, "{said}");
}

/// Modules are loaded from one folder of the system only: the run shadows it in a mount namespace
/// of its own, so that nothing is installed.
fn can_shadow_modules() -> bool {
    let runs = Command::new("pidof").arg("rtapi_app").output().is_ok_and(|o| o.status.success());
    let shadows = Command::new("unshare")
        .args(["--mount", "mount", "--bind", "/tmp", MODULE_FOLDER])
        .output()
        .is_ok_and(|o| o.status.success());
    if runs || !shadows {
        eprintln!("SKIPPED: LinuxCNC is in use, or its module folder cannot be shadowed here");
    }
    shadows && !runs
}

fn readable(path: &Path) {
    fs::set_permissions(path, fs::Permissions::from_mode(0o777)).unwrap();
}

/// Compiles the component against the library that Cargo built beside this test, copied to where
/// a user of no rights may read it.
fn compile(at: &Path) {
    readable(at);
    for file in ["hal/force_impedance.comp", "hal/press_a_spring.hal", "include/force_impedance.h"]
    {
        let from = root().join(file);
        fs::copy(&from, at.join(from.file_name().unwrap())).unwrap();
    }
    let test = std::env::current_exe().unwrap();
    let library = test.with_file_name("libforce_impedance_c.so");
    fs::copy(&library, at.join(library.file_name().unwrap())).unwrap();
    let folder = at.display();
    let flags = format!("-L{folder} -Wl,--no-as-needed -lforce_impedance_c -Wl,-rpath,{folder}");
    output_of(
        Command::new("halcompile")
            .args(["--compile", &format!("{COMPONENT}.comp")])
            .env("LDFLAGS", flags)
            .current_dir(at),
    );
}

/// Runs it for three seconds; the pins in the end.
fn press(at: &Path) -> String {
    let modules = at.join("modules");
    fs::create_dir(&modules).unwrap();
    for module in MODULES {
        let file = format!("{module}.so");
        fs::copy(Path::new(MODULE_FOLDER).join(&file), modules.join(&file)).unwrap();
    }
    let file = format!("{COMPONENT}.so");
    fs::copy(at.join(&file), modules.join(&file)).unwrap();
    readable(&modules);
    for entry in fs::read_dir(&modules).unwrap().chain(fs::read_dir(at).unwrap()) {
        readable(&entry.unwrap().path());
    }
    let script =
        format!("mount --bind modules {MODULE_FOLDER} && exec halrun -f press_a_spring.hal");
    output_of(
        Command::new("unshare")
            .args(["--mount", "sh", "-c", &script])
            .env("RTAPI_UID", NOBODY)
            .env("RTAPI_FIFO_PATH", at.join("fifo"))
            .env("HOME", at)
            .current_dir(at),
    )
}
