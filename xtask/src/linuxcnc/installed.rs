//! LinuxCNC of this machine, run in namespaces of its own.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::{Context, Result, ensure};

use crate::shell;

/// Where LinuxCNC looks for realtime modules, and nowhere else.
const MODULES: &str = "/usr/lib/linuxcnc/modules";
/// A user of no rights, under whom it runs where the caller is root: it refuses to be root.
const NOBODY: &str = "65534";
/// A user of the caller's own namespace, where root has none.
const SOMEBODY: &str = "1000";
/// What to do where it is not there.
const ADVICE: &str = "install the Debian packages linuxcnc-uspace and linuxcnc-uspace-dev";

/// What it is run with.
#[derive(Clone, Copy, Debug)]
pub(super) struct Installed {
    is_root: bool,
}

impl Installed {
    /// Where all that is needed is there; else what is not.
    pub(super) fn find() -> Result<Self, String> {
        for program in ["linuxcnc", "halrun", "halcompile", "unshare"] {
            let found = Command::new("sh").args(["-c", &format!("command -v {program}")]).output();
            if !found.is_ok_and(|output| output.status.success()) {
                return Err(format!("no `{program}`; {ADVICE}"));
            }
        }
        let user = shell::output_of("id", &["-u"]).map_err(|error| format!("{error:#}"))?;
        let installed = Self { is_root: user.trim() == "0" };
        let tried = installed.command("true").stdout(Stdio::null()).stderr(Stdio::null()).status();
        if tried.is_ok_and(|status| status.success()) {
            return Ok(installed);
        }
        Err("this user may make no namespaces (`unshare` fails)".to_owned())
    }

    /// A shell script in namespaces of its own: what it mounts, its shared memory, its network and its
    /// processes end with it, and another LinuxCNC of this machine is not disturbed.
    fn command(self, script: &str) -> Command {
        let mut command = Command::new("unshare");
        if !self.is_root {
            command.args(["--user", "--map-root-user"]);
        }
        command.args([
            "--mount",
            "--ipc",
            "--net",
            "--pid",
            "--mount-proc",
            "--fork",
            "--kill-child",
        ]);
        command.args(["sh", "-c", script]);
        command
    }

    /// `program` of LinuxCNC in `folder`, with the components there among its modules.
    pub(super) fn running(self, folder: &Path, program: &str) -> Command {
        let user = if self.is_root {
            String::new()
        } else {
            format!("unshare --user --map-user={SOMEBODY} ")
        };
        let mut command =
            self.command(&format!("mount --bind modules {MODULES} && exec {user}{program}"));
        command
            .env("RTAPI_UID", NOBODY)
            .env("RTAPI_FIFO_PATH", folder.join("fifo"))
            .env("HOME", folder)
            .stdin(Stdio::null())
            .current_dir(folder);
        command
    }
}

/// Empties `folder` and lays into it the files that a run needs, its components compiled, the modules of
/// LinuxCNC beside them.
pub(super) fn lay_out(folder: &Path, files: &[&str], components: &[Component<'_>]) -> Result<()> {
    if folder.exists() {
        fs::remove_dir_all(folder).with_context(|| format!("cannot empty {}", folder.display()))?;
    }
    let modules = folder.join("modules");
    fs::create_dir_all(&modules)?;
    for file in files {
        copy(&shell::root().join(file), folder)?;
    }
    for entry in fs::read_dir(MODULES).context(MODULES)? {
        let module = entry?.path();
        if module.is_file() {
            copy(&module, &modules)?;
        }
    }
    for component in components {
        let source = copy(&shell::root().join(component.source), folder)?;
        let compiled = Command::new("halcompile")
            .args(["--compile", &source])
            .env("LDFLAGS", component.flags)
            .current_dir(folder)
            .output()
            .context("cannot start halcompile")?;
        let said = String::from_utf8_lossy(&compiled.stderr);
        ensure!(compiled.status.success(), "halcompile {source}: {said}");
        copy(&folder.join(&source).with_extension("so"), &modules)?;
    }
    open_to_all(folder)
}

/// Source of a component, and how its library is linked.
pub(super) struct Component<'a> {
    pub(super) source: &'a str,
    pub(super) flags: &'a str,
}

/// Copies a file into a folder; its name.
pub(super) fn copy(from: &Path, folder: &Path) -> Result<String> {
    let name = from.file_name().context("a file has a name")?.to_string_lossy().into_owned();
    fs::copy(from, folder.join(&name))
        .with_context(|| format!("cannot copy {}", from.display()))?;
    Ok(name)
}

/// LinuxCNC runs as a user of no rights.
fn open_to_all(folder: &Path) -> Result<()> {
    let everybody = |path: &Path| fs::set_permissions(path, fs::Permissions::from_mode(0o777));
    everybody(folder)?;
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            open_to_all(&path)?;
        } else {
            everybody(&path)?;
        }
    }
    Ok(())
}
