//! The `meniscus` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(meniscus_cli::main(std::env::args_os(), None))
}
