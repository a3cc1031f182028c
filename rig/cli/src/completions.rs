//! `rig completions` and `rig man`: what shells and `man` know of the command, made of its arguments.

use crate::exit::ExitStatus;
use crate::{files, output};
use clap::{Args, Command};
use clap_complete::Shell;
use std::path::PathBuf;

/// `rig completions`.
#[derive(Debug, Args)]
pub struct CompletionsArgs {
    /// The shell.
    #[arg(value_enum)]
    shell: Shell,
}

/// `rig man`.
#[derive(Debug, Args)]
pub struct ManArgs {
    /// The folder; it is made if it is not there. Pages of the same names are replaced.
    dir: PathBuf,
}

/// Prints the completions of a shell for the command line `command`.
pub fn run(args: &CompletionsArgs, mut command: Command) -> ExitStatus {
    let name = command.get_name().to_owned();
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut command, name, &mut text);
    output::print(&String::from_utf8_lossy(&text));
    ExitStatus::Passed
}

/// Writes a page for the command and one for each of its subcommands.
pub fn man(args: &ManArgs, command: Command) -> ExitStatus {
    let written =
        std::fs::create_dir_all(&args.dir).and_then(|()| clap_mangen::generate_to(command, &args.dir));
    match written {
        Ok(()) => ExitStatus::Passed,
        Err(error) => {
            output::findings(&[files::failed(&args.dir, &error)], &[]);
            ExitStatus::UserFiles
        }
    }
}
