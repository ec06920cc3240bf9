//! `cargo xtask linuxcnc`: a real controller works by what `truing` hands out.
//!
//! LinuxCNC runs on simulated axes. A touch probe whose ball, pretravel and latency no case knows meets a
//! reference sphere and a part (`xtask/linuxcnc/touched_part.comp`); a polishing head presses on a moving
//! spring (`xtask/linuxcnc/pressed_part.comp`). Every figure comes from the machine's own moves.

mod answer;
mod drawing;
mod head;
mod installed;
mod machine;
mod part;
mod sphere;
mod touch;

use std::path::PathBuf;

use anyhow::{Result, bail};

use crate::program::Truing;
use crate::shell;
use installed::Installed;
use machine::Machine;

/// What to run.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Seconds that the head presses.
    #[arg(long, default_value_t = SECONDS)]
    seconds: u32,
    /// Leaves out the touches.
    #[arg(long)]
    head_only: bool,
    /// A built program, in place of building one.
    #[arg(long)]
    program: Option<PathBuf>,
}

/// Long enough for the head to press steadily on every place of its spring.
const SECONDS: u32 = 10;

/// Touches and presses; an error where LinuxCNC is not there.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    match Installed::find() {
        Ok(installed) => all(installed, arguments),
        Err(reason) => bail!("LinuxCNC cannot be run here: {reason}"),
    }
}

/// The same among the checks, which go on without it.
pub(crate) fn run_where_installed() -> Result<()> {
    match Installed::find() {
        Ok(installed) => {
            all(installed, &Arguments { seconds: SECONDS, head_only: false, program: None })
        }
        Err(reason) => {
            println!("── left out: cargo xtask linuxcnc ({reason})");
            Ok(())
        }
    }
}

fn all(installed: Installed, arguments: &Arguments) -> Result<()> {
    let folder = shell::root().join("target/linuxcnc");
    if !arguments.head_only {
        let truing = Truing::given(arguments.program.as_deref())?;
        let mut machine = Machine::start(installed, &folder.join("machine"))?;
        let radius_mm = sphere::qualify(&truing, &mut machine, &folder.join("sphere"))?;
        part::locate(&truing, &mut machine, &folder.join("part"), radius_mm)?;
        machine.end()?;
    }
    head::press(installed, &folder.join("head"), arguments.seconds)
}
