//! The command line: `truing solve`, `loop`, `check` and `init`.

mod cli;

fn main() -> std::process::ExitCode {
    cli::run()
}
