//! The fibre-by-fibre simulator of hair and other slender fibres: the command line.

mod arguments;
mod check;
mod failure;
mod info;
mod new;
mod run;
mod solve;
mod templates;
mod words;

use arguments::{Arguments, Command};
use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let json = arguments.json;
    let result = match arguments.command {
        Command::Run(options) => run::run(&options, json),
        Command::Check { scene } => check::check(&scene, json),
        Command::New(options) => new::new(&options, json),
        Command::Solve(options) => solve::solve(&options, json),
        Command::Info { folder } => info::info(&folder, json),
    };
    result.unwrap_or_else(|failure| failure.tell(json))
}
