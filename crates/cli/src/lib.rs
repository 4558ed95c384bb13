//! The `meniscus` command as a library: the Python package is the command, too, and uses the parts that are re-exported here.

mod args;
mod commands;
mod failure;
mod own_program;
mod progress;
mod scenes;
mod stop;
mod values;

use crate::args::{Cli, Command, LogFormat};
use crate::failure::Result;
use clap::Parser;
use std::ffi::OsString;

pub use crate::args::{Quality, SceneArgs};
pub use crate::commands::export::stored_frame;
pub use crate::commands::run::{conclude, duration, show};
pub use crate::commands::sweep::{Cell, Ended, Parameter, Row, Runner, Sweep, Table, Vary};
pub use crate::commands::version;
pub use crate::commands::view::{DEFAULT_PAGE_MB, make_page};
pub use crate::commands::with_threads;
pub use crate::failure::{Failure, Place};
pub use crate::scenes::{Loaded, check_runnable, load, prepare};
pub use crate::values::wall_time;

/// The command with arguments, of which the first is the name of the program. Returns the exit status. `program` are the words that start
/// this program again, for commands that start processes; by default the executable file of this process.
pub fn main(arguments: impl IntoIterator<Item = OsString>, program: Option<Vec<OsString>>) -> u8 {
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(told) => {
            // Help and version are told in the same way; where they cannot be printed, nobody listens.
            let _ = told.print();
            return u8::try_from(told.exit_code()).unwrap_or(2);
        }
    };
    if let Some(program) = program {
        own_program::set(program);
    }
    let json = matches!(&cli.command, Command::Run(run) if run.log == LogFormat::Json);
    let done = std::panic::catch_unwind(|| dispatch(cli.command));
    let done = done.unwrap_or_else(|_| {
        let help = "this is a bug: please report it with the scene and the message above";
        Err(Failure::new(1, "internal error").help(help))
    });
    match done {
        Ok(status) => status,
        Err(failure) => fail(failure, json),
    }
}

/// Reports a failure. Returns its exit status.
fn fail(failure: Failure, json: bool) -> u8 {
    let status = failure.status;
    if json {
        eprintln!("{}", failure.json());
    } else {
        eprintln!("{:?}", miette::Report::new(failure));
    }
    status
}

fn dispatch(command: Command) -> Result {
    match command {
        Command::Run(args) => commands::run::run(&args),
        Command::Scenes(args) => commands::scenes::list(&args),
        Command::New(args) => commands::scenes::new(&args),
        Command::Check(args) => commands::check::check(&args),
        Command::Verify(args) => commands::verify::verify(&args),
        Command::Soak(args) => commands::soak::soak(&args),
        Command::Bench(args) => commands::bench::bench(&args),
        Command::Page(args) => commands::view::page(&args),
        Command::View(args) => commands::view::view(&args),
        Command::Render(args) => commands::view::render(&args),
        Command::Schema(args) => commands::info::schema(args.markdown),
        Command::Info(args) => commands::info::info(args.json),
        Command::Completions { shell } => commands::info::completions(shell),
        Command::Export(args) => commands::export::export(&args),
        Command::Sweep(args) => commands::sweep::sweep(&args),
        Command::Measure(args) => commands::measure::measure(&args),
    }
}
