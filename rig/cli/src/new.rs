//! `rig new`: a project whose first run passes.

use crate::exit::ExitStatus;
use crate::schema::{SchemaFormat, text as schema};
use crate::{files, output};
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};

/// `rig new`.
#[derive(Debug, Args)]
pub struct NewArgs {
    /// The folder; it is made if it is not there, and must be empty if it is.
    dir: PathBuf,
    /// What the project controls.
    #[arg(long, value_enum, default_value_t = TemplateName::Motor)]
    template: TemplateName,
}

/// The projects that there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum TemplateName {
    /// A motor with two buttons, and a contactor that must answer.
    Motor,
    /// The level of a tank: a PI controller with an input and an output of 4 to 20 mA; a broken wire.
    Tank,
    /// A belt with photo eyes: parts are counted; a jam.
    Conveyor,
    /// A press: two hands, a light curtain, end switches; a cylinder that does not arrive.
    Press,
}

/// Files of a project by their paths in it.
type ProjectFiles = &'static [(&'static str, &'static str)];

/// A table of files: paths in the project, and where below `template` their texts are.
macro_rules! project_files {
    ($($path:literal = $from:literal),+ $(,)?) => {
        &[$(($path, include_str!(concat!("../template/", $from)))),+]
    };
}

/// What every project has.
const COMMON: ProjectFiles = project_files!(
    ".gitlab-ci.yml" = "common/gitlab-ci.yml",
    ".github/workflows/rig.yml" = "common/github.yml",
    ".taplo.toml" = "common/taplo.toml",
    ".gitignore" = "common/gitignore",
);

const MOTOR: ProjectFiles = project_files!(
    "README.md" = "motor/README.md",
    "src/motor.st" = "motor/src/motor.st",
    "suite.toml" = "motor/suite.toml",
    "boards/bench.toml" = "motor/boards/bench.toml",
    "plans/start-stop.toml" = "motor/plans/start-stop.toml",
    "plans/contactor.toml" = "motor/plans/contactor.toml",
);

const TANK: ProjectFiles = project_files!(
    "README.md" = "tank/README.md",
    "src/level.st" = "tank/src/level.st",
    "suite.toml" = "tank/suite.toml",
    "boards/tank.toml" = "tank/boards/tank.toml",
    "controller/tank.toml" = "tank/controller/tank.toml",
    "plans/fill.toml" = "tank/plans/fill.toml",
    "plans/set-point.toml" = "tank/plans/set-point.toml",
    "plans/consumer.toml" = "tank/plans/consumer.toml",
    "plans/broken-wire.toml" = "tank/plans/broken-wire.toml",
    "plans/high-level.toml" = "tank/plans/high-level.toml",
);

const CONVEYOR: ProjectFiles = project_files!(
    "README.md" = "conveyor/README.md",
    "src/conveyor.st" = "conveyor/src/conveyor.st",
    "suite.toml" = "conveyor/suite.toml",
    "boards/conveyor.toml" = "conveyor/boards/conveyor.toml",
    "plans/count.toml" = "conveyor/plans/count.toml",
    "plans/jam.toml" = "conveyor/plans/jam.toml",
    "plans/stop.toml" = "conveyor/plans/stop.toml",
);

const PRESS: ProjectFiles = project_files!(
    "README.md" = "press/README.md",
    "src/press.st" = "press/src/press.st",
    "suite.toml" = "press/suite.toml",
    "boards/press.toml" = "press/boards/press.toml",
    "plans/cycle.toml" = "press/plans/cycle.toml",
    "plans/two-hands.toml" = "press/plans/two-hands.toml",
    "plans/light-curtain.toml" = "press/plans/light-curtain.toml",
    "plans/failed.toml" = "press/plans/failed.toml",
);

/// What stands in every README in place of `{{usage}}`.
const USAGE: &str = include_str!("../template/common/usage.md");

/// The schemas of a project.
const SCHEMAS: &[(&str, SchemaFormat)] = &[
    ("schemas/plan.schema.json", SchemaFormat::Plan),
    ("schemas/board.schema.json", SchemaFormat::Board),
    ("schemas/suite.schema.json", SchemaFormat::Suite),
    ("schemas/included.schema.json", SchemaFormat::Included),
];

impl TemplateName {
    fn files(self) -> ProjectFiles {
        match self {
            TemplateName::Motor => MOTOR,
            TemplateName::Tank => TANK,
            TemplateName::Conveyor => CONVEYOR,
            TemplateName::Press => PRESS,
        }
    }
}

/// Makes a project.
pub fn run(args: &NewArgs) -> ExitStatus {
    let name = name(&args.dir);
    let mut project: Vec<(PathBuf, Vec<u8>)> = Vec::new();
    for (path, text) in args.template.files().iter().chain(COMMON) {
        let text = text.replace("{{usage}}\n", USAGE).replace("{{name}}", &name);
        project.push((PathBuf::from(path), text.into_bytes()));
    }
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
