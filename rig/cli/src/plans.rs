//! `rig plans`: the plans that ship.

use crate::exit::ExitStatus;
use crate::output::OutputFormat;
use crate::plan_files::library::{self, ShippedFiles};
use crate::{files, output};
use clap::{Args, Subcommand};
use plans::Plan;
use runtime::suite;
use serde_json::{Value as Json, json};
use std::path::PathBuf;

/// `rig plans`.
#[derive(Debug, Subcommand)]
pub enum PlansCommand {
    /// List them with the number of their cases and their titles.
    List(PlansListArgs),
    /// Write them into an empty folder, with the programs and boards that they name.
    Export(ExportArgs),
}

/// `rig plans list`.
#[derive(Debug, Args)]
pub struct PlansListArgs {
    /// How to print.
    #[arg(long, value_enum, default_value_t)]
    format: OutputFormat,
}

/// `rig plans export`.
#[derive(Debug, Args)]
pub struct ExportArgs {
    /// The folder; it is made if it is not there, and must be empty if it is.
    dir: PathBuf,
}

/// Lists or exports.
pub fn run(command: &PlansCommand) -> ExitStatus {
    match command {
        PlansCommand::List(args) => list(args.format),
        PlansCommand::Export(args) => export(args),
    }
}

fn list(format: OutputFormat) -> ExitStatus {
    let mut listed = Vec::new();
    for path in library::plans() {
        let mut sources = Vec::new();
        match suite::load_plan(&ShippedFiles, &path, None, &[], 1, &mut sources) {
            Ok(loaded) => listed.push(loaded.plan),
            Err(found) => {
                output::findings(&found, &sources);
                return ExitStatus::Error;
            }
        }
    }
    match format {
        OutputFormat::Table => table(&listed),
        OutputFormat::Json => output::print(&format!(
            "{}\n",
            serde_json::to_string_pretty(&listed.iter().map(describe).collect::<Vec<_>>())
                .unwrap_or_default()
        )),
    }
    ExitStatus::Passed
}

fn table(plans: &[Plan]) {
    let width = plans.iter().map(|plan| plan.path.len()).max().unwrap_or_default();
    for plan in plans {
        output::print(&format!("{:width$}  {:>4}  {}\n", plan.path, plan.len(), plan.title));
    }
    let cases: u64 = plans.iter().map(Plan::len).sum();
    output::print(&format!("{} plans of {cases} cases\n", plans.len()));
}

fn describe(plan: &Plan) -> Json {
    json!({
        "path": plan.path,
        "title": plan.title,
        "description": plan.description,
        "cases": plan.len(),
        "proves": plan.proves,
        "profiles": plan.profiles.iter().map(|profile| profile.name()).collect::<Vec<_>>(),
    })
}

fn export(args: &ExportArgs) -> ExitStatus {
    let library = library::files();
    let files =
        library.iter().map(|(path, content)| (path.to_path_buf(), content.to_vec())).collect::<Vec<_>>();
    match files::write_new(&args.dir, &files) {
        Err(found) => {
            output::findings(&[found], &[]);
            ExitStatus::UserFiles
        }
        Ok(()) => {
            output::print(&format!("{} files in {}\n", files.len(), args.dir.display()));
            ExitStatus::Passed
        }
    }
}
