//! The project in whose folder a command is given.

use crate::plan_files::find;
use runtime::suite::Disk;
use runtime::suite::suites::{self, SUITE_FILE};
use std::path::{Path, PathBuf};

/// The folder whose plans a command means that names none: the current one, where it is part of a project. That it is where a plan
/// lies in it, or a suite file in it or in a folder above it.
pub fn folder() -> Option<PathBuf> {
    let here = Path::new(".");
    (find::has_plan(here) || suites::is_of_suite(&Disk, SUITE_FILE)).then(|| here.to_owned())
}
