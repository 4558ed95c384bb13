//! The `meniscus` command.

mod args;
mod commands;
mod failure;
mod progress;
mod scenes;
mod stop;
mod values;

use crate::args::{Cli, Command, LogFormat};
use crate::failure::{Failure, Result};
use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = Cli::parse();
    let json = matches!(&cli.command, Command::Run(run) if run.log == LogFormat::Json);
    let done = std::panic::catch_unwind(|| dispatch(cli.command));
    let done = done.unwrap_or_else(|_| {
        let help = "this is a bug: please report it with the scene and the message above";
        Err(Failure::new(1, "internal error").help(help))
    });
    match done {
        Ok(status) => ExitCode::from(status),
        Err(failure) => fail(failure, json),
    }
}

/// Reports a failure. Returns its exit status.
fn fail(failure: Failure, json: bool) -> ExitCode {
    let status = failure.status;
    if json {
        eprintln!("{}", failure.json());
    } else {
        eprintln!("{:?}", miette::Report::new(failure));
    }
    ExitCode::from(status)
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
        Command::Render(args) => commands::view::render(&args),
        Command::Schema(args) => commands::info::schema(args.markdown),
        Command::Info(args) => commands::info::info(args.json),
        Command::Completions { shell } => commands::info::completions(shell),
        Command::Export(args) => commands::export::export(&args),
        Command::Sweep(args) => commands::sweep::sweep(&args),
        Command::Measure(args) => commands::measure::measure(&args),
    }
}
