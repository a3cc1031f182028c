//! `rig program check`.

use super::compile;
use crate::exit::Exit;
use crate::output;
use profile::Profile;
use runtime::tasks;
use std::path::PathBuf;

/// Compiles files and says what is wrong: with the program, and with its tasks for the default controller.
pub fn check(files: &[PathBuf]) -> Exit {
    let (program, sources) = match compile(files) {
        Ok(compiled) => compiled,
        Err(exit) => return exit,
    };
    if let Err(found) = tasks::check(&program, Profile::default()) {
        output::findings(&found, &sources);
        return Exit::UserFiles;
    }
    output::findings(&runtime::application::notes(&program, Profile::default()), &sources);
    let count = program.variables().len();
    output::print(&format!("no errors: programs {}, {count} variables\n", program.programs().join(", ")));
    Exit::Passed
}
