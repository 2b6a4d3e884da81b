//! Arguments to the command line or the window; nothing else.

use std::process::ExitCode;

use inhabit::cli;

fn main() -> ExitCode {
    let arguments = cli::parse();
    match arguments.command {
        Some(command) => cli::run(command),
        None => cli::run_without_display("not built yet", &arguments.window),
    }
}
