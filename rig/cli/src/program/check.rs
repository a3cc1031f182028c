//! `rig program check`.

use super::compile_with;
use crate::exit::ExitStatus;
use crate::output;
use profile::Profile;
use runtime::application::tasks;
use std::path::PathBuf;

/// Compiles files and says what is wrong: with the program, and with its tasks for the default controller.
pub fn check(files: &[PathBuf]) -> ExitStatus {
    let (program, sources) = match compile_with(files, runtime::application::compile_library) {
        Ok(compiled) => compiled,
        Err(exit) => return exit,
    };
    if let Err(found) = tasks::check(&program, Profile::default()) {
        output::findings(&found, &sources);
        return ExitStatus::UserFiles;
    }
    output::findings(&runtime::application::notes(&program, Profile::default()), &sources);
    let count = program.variables().len();
    let what = match program.programs() {
        [] => "a library without a PROGRAM".to_owned(),
        programs => format!("programs {}", programs.join(", ")),
    };
    output::print(&format!("no errors: {what}, {count} variables\n"));
    ExitStatus::Passed
}
