//! LinuxCNC switched on, running one program after another.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::thread::sleep;
use std::time::Duration;

use anyhow::{Context, Result, bail, ensure};

use super::installed::{Component, Installed, lay_out};

const FILES: [&str; 3] =
    ["xtask/linuxcnc/machine.ini", "xtask/linuxcnc/machine.hal", "xtask/linuxcnc/run_programs.py"];
const COMPONENT: &str = "xtask/linuxcnc/touched_part.comp";
/// What the controller and the screen said.
const SAID: &str = "said.txt";
const LOOK_AGAIN: Duration = Duration::from_millis(20);

/// The machine of `xtask/linuxcnc/machine.ini`.
pub(super) struct Machine {
    folder: PathBuf,
    process: Child,
}

impl Machine {
    /// Switches it on in `folder`, which is emptied.
    pub(super) fn start(installed: Installed, folder: &Path) -> Result<Self> {
        lay_out(folder, &FILES, &[Component { source: COMPONENT, flags: "" }])?;
        fs::write(folder.join("tool.tbl"), "")?;
        let programs = folder.join("programs");
        fs::create_dir(&programs)?;
        fs::set_permissions(&programs, fs::Permissions::from_mode(0o777))?;
        let said = fs::File::create(folder.join(SAID))?;
        let process = installed
            .running(folder, "linuxcnc -r machine.ini")
            .stdout(Stdio::from(said.try_clone()?))
            .stderr(Stdio::from(said))
            .spawn()
            .context("cannot start linuxcnc")?;
        Ok(Self { folder: folder.to_owned(), process })
    }

    /// Runs a program to its end and returns the log that it wrote, by the name in its `PROBEOPEN`.
    pub(super) fn run(&mut self, name: &str, program: &str) -> Result<PathBuf> {
        let start = program.split_once("(PROBEOPEN ").context("a program without PROBEOPEN")?.1;
        let log = self.folder.join(start.split_once(')').context("PROBEOPEN without an end")?.0);
        if log.exists() {
            fs::remove_file(&log)?;
        }
        let at = self.folder.join("programs").join(name);
        fs::write(at.with_extension("ngc"), program)?;
        fs::write(at.with_extension("go"), "")?;
        let done = at.with_extension("done");
        while !done.exists() {
            if let Some(status) = self.process.try_wait()? {
                let said = fs::read_to_string(self.folder.join(SAID)).unwrap_or_default();
                bail!("LinuxCNC ended during {name} ({status}):\n{said}");
            }
            sleep(LOOK_AGAIN);
        }
        let said = fs::read_to_string(&done)?;
        ensure!(said.is_empty(), "{name}: LinuxCNC says: {said}");
        fs::remove_file(&done)?;
        Ok(log)
    }

    /// Switches it off.
    pub(super) fn end(mut self) -> Result<()> {
        fs::write(self.folder.join("end"), "")?;
        let status = self.process.wait()?;
        ensure!(
            status.success(),
            "LinuxCNC ended with {status}, see {}",
            self.folder.join(SAID).display()
        );
        Ok(())
    }
}

impl Drop for Machine {
    /// Whatever happened, nothing is left running: the kernel ends all of its namespace.
    fn drop(&mut self) {
        if matches!(self.process.try_wait(), Ok(None)) {
            let _ = self.process.kill();
            let _ = self.process.wait();
        }
    }
}
