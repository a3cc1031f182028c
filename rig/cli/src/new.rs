//! `rig new`: a project whose first run passes.

use crate::exit::ExitStatus;
use crate::schema::{SchemaFormat, text as schema};
use crate::{files, output};
use clap::Args;
use std::path::{Path, PathBuf};

/// `rig new`.
#[derive(Debug, Args)]
pub struct NewArgs {
    /// The folder; it is made if it is not there, and must be empty if it is.
    dir: PathBuf,
}

/// The files of a project as they are, by their paths in it.
const TEMPLATE: &[(&str, &str)] = &[
    ("README.md", include_str!("../template/README.md")),
    ("src/motor.st", include_str!("../template/src/motor.st")),
    ("suite.toml", include_str!("../template/suite.toml")),
    ("boards/bench.toml", include_str!("../template/boards/bench.toml")),
    ("plans/start-stop.toml", include_str!("../template/plans/start-stop.toml")),
    ("plans/contactor.toml", include_str!("../template/plans/contactor.toml")),
    (".gitlab-ci.yml", include_str!("../template/gitlab-ci.yml")),
    (".github/workflows/rig.yml", include_str!("../template/github.yml")),
    (".taplo.toml", include_str!("../template/taplo.toml")),
    (".gitignore", "report/\n"),
];

/// The schemas of a project.
const SCHEMAS: &[(&str, SchemaFormat)] = &[
    ("schemas/plan.schema.json", SchemaFormat::Plan),
    ("schemas/board.schema.json", SchemaFormat::Board),
    ("schemas/suite.schema.json", SchemaFormat::Suite),
];

/// Makes a project.
pub fn run(args: &NewArgs) -> ExitStatus {
    let name = name(&args.dir);
    let mut project: Vec<(PathBuf, Vec<u8>)> = TEMPLATE
        .iter()
        .map(|(path, text)| (PathBuf::from(path), text.replace("{{name}}", &name).into_bytes()))
        .collect();
    for (path, of) in SCHEMAS {
        project.push((PathBuf::from(path), schema(*of).into_bytes()));
    }
    if let Err(found) = files::write_new(&args.dir, &project) {
        output::findings(&[found], &[]);
        return ExitStatus::UserFiles;
    }
    for (path, _) in &project {
        output::print(&format!("{}\n", args.dir.join(path).display()));
    }
    output::print(&format!("\nNow run: rig test {}\n", args.dir.display()));
    ExitStatus::Passed
}

/// What the project is called: as its folder.
fn name(folder: &Path) -> String {
    let whole = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
    whole.file_name().map_or_else(|| String::from("Plans"), |name| name.to_string_lossy().into_owned())
}
