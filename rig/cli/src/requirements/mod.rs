//! `rig requirements`.

#[cfg(test)]
mod shipped;
mod status;

use crate::exit::ExitStatus;
use crate::output::OutputFormat;
use crate::plan_files::library::{self, REGISTER, ShippedFiles};
use crate::{output, saved_runs};
use clap::Args;
use document::Diagnostic;
use plans::register::RequirementRegister;
use profile::Profile;
use record::{ClauseFact, RequirementFact, RunRecord};
use runtime::case::jobs::{self, JobResult};
use runtime::suite;
use runtime::{ClockKind, RunOptions};
use serde_json::json;
use status::{ProofStatus, RegisterRow};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

/// `rig requirements`.
#[derive(Debug, Args)]
pub struct RequirementsArgs {
    /// How to print.
    #[arg(long, value_enum, default_value_t)]
    pub format: OutputFormat,
    /// Take the last verdicts from this folder, which `rig test --report DIR` wrote, instead of running the library.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
}

/// Prints the register with what proves it.
pub fn run(args: &RequirementsArgs) -> ExitStatus {
    let register = match RequirementRegister::read(REGISTER) {
        Ok(register) => register,
        Err(error) => {
            output::error(&format!("the register of requirements is broken: {error}"));
            return ExitStatus::Error;
        }
    };
    let record = match &args.report {
        Some(folder) => saved_runs::load(folder).map(|run| run.record),
        None => run_library(),
    };
    let record = match record {
        Ok(record) => record,
        Err(found) => {
            output::findings(&[found], &[]);
            return ExitStatus::UserFiles;
        }
    };
    let proofs = status::proofs(&record);
    let unknown: Vec<&str> = proofs.keys().map(String::as_str).filter(|id| !register.knows(id)).collect();
    if !unknown.is_empty() {
        output::error(&format!("cited, but not in the register: {}", unknown.join(", ")));
        return ExitStatus::UserFiles;
    }
    let rows = status::rows(&register, &proofs);
    match args.format {
        OutputFormat::Json => json(&rows),
        OutputFormat::Table => table(&rows),
    }
    ExitStatus::Passed
}

fn json(rows: &[RegisterRow<'_>]) {
    let rows: Vec<serde_json::Value> = rows
        .iter()
        .map(|row| {
            let profiles = row.profiles.iter().map(|(profile, status, cases)| {
                json!({ "profile": profile.name(), "status": status.word(), "cases": cases })
            });
            let mut value = json!({
                "id": row.id,
                "status": row.status.word(),
                "class": row.proof.class.word(),
                "asks": row.asks,
                "source": row.entry.source,
                "cases": cases(row),
                "profiles": profiles.collect::<Vec<_>>(),
                "lacks": row.lacks,
            });
            // What the register does not say is left out.
            for (key, text) in [
                ("reason", Some(&row.proof.reason)),
                ("open", row.proof.open.as_ref()),
                ("stand-in", Some(&row.proof.stand_in)),
            ] {
                if let Some(text) = text.filter(|text| !text.is_empty()) {
                    value[key] = json!(text);
                }
            }
            if let Some(number) = row.proof.decision {
                value["decision"] = json!(number);
            }
            value
        })
        .collect();
    let text = serde_json::to_string_pretty(&rows).unwrap_or_default();
    output::print(&format!("{text}\n"));
}

/// The names of all cases that say something of a row.
fn cases<'a>(row: &RegisterRow<'a>) -> BTreeSet<&'a str> {
    row.profiles.iter().flat_map(|(.., cases)| cases).copied().collect()
}

fn table(rows: &[RegisterRow<'_>]) {
    let width = rows.iter().map(|row| row.id.len()).max().unwrap_or(0);
    let names = Profile::ALL.map(Profile::name).join(", ");
    output::print(&format!(
        "{:width$}  proven by cases of {names}: + all pass, ~ of some clauses, ! one does not, - none\n",
        ""
    ));
    for row in rows {
        let signs = Profile::ALL.map(|profile| {
            row.profiles
                .iter()
                .find(|(known, ..)| *known == profile)
                .map_or(" ", |(_, status, _)| status.sign())
        });
        let by = match cases(row).len() {
            0 => String::new(),
            count => format!(" ({count} cases)"),
        };
        let note = match row.note() {
            empty if empty.is_empty() => empty,
            note => format!(" [{note}]"),
        };
        let (id, signs, status) = (&row.id, signs.concat(), row.status.word());
        output::print(&format!("{id:width$}  {signs}  {status:18}  {}{by}{note}\n", row.asks));
    }
    output::print(&totals(rows));
}

/// How many requirements of each area have which status, and how many clauses and requirements in all.
fn totals(rows: &[RegisterRow<'_>]) -> String {
    let (clauses, requirements): (Vec<_>, Vec<_>) = rows.iter().partition(|row| row.id.contains('#'));
    let counts = |rows: &[&RegisterRow<'_>]| {
        ProofStatus::ALL.map(|status| rows.iter().filter(|row| row.status == status).count())
    };
    let mut areas: BTreeMap<&str, Vec<&RegisterRow<'_>>> = BTreeMap::new();
    for row in &requirements {
        areas.entry(row.id.split(':').next().unwrap_or_default()).or_default().push(row);
    }
    let width = areas.keys().map(|area| area.len()).max().unwrap_or(0);
    let line = |name: &str, cells: [String; ProofStatus::ALL.len()]| {
        let cells = cells
            .iter()
            .zip(ProofStatus::ALL)
            .map(|(cell, status)| format!("  {cell:>width$}", width = status.word().len()));
        format!("{name:width$}{}\n", cells.collect::<String>())
    };
    let mut text = line("", ProofStatus::ALL.map(|status| status.word().to_owned()));
    for (area, rows) in &areas {
        text.push_str(&line(area, counts(rows).map(|count| count.to_string())));
    }
    for (what, rows) in [("clauses", &clauses), ("requirements", &requirements)] {
        let counts: Vec<String> = counts(rows)
            .into_iter()
            .zip(ProofStatus::ALL)
            .filter(|(count, _)| *count > 0)
            .map(|(count, status)| format!("{count} {}", status.word()))
            .collect();
        text.push_str(&format!("{} {what}: {}\n", rows.len(), counts.join(", ")));
    }
    text
}

/// What the register says of the requirements that the cases of a run cite, in its order, and how far the run proves
/// them; for reports, which read nothing but the record.
pub fn facts(run: &RunRecord) -> Vec<RequirementFact> {
    let requirement = |cited: &str| cited.split('#').next().unwrap_or_default().to_owned();
    let cited: BTreeSet<String> =
        run.cases.iter().flat_map(|case| case.proves.iter().map(|id| requirement(id))).collect();
    // A register that cannot be read is no trouble of the run: the command that prints it says so.
    let register = RequirementRegister::read(REGISTER).unwrap_or_default();
    let proofs = status::proofs(run);
    let mut facts: Vec<RequirementFact> = Vec::with_capacity(cited.len());
    for row in status::rows(&register, &proofs).iter().filter(|row| cited.contains(&row.entry.id)) {
        let (asks, status, note) = (row.asks.to_owned(), row.status.word().to_owned(), row.note());
        match (row.id.split_once('#'), facts.last_mut()) {
            // The rows of clauses come after that of their requirement.
            (Some((_, id)), Some(of)) => {
                of.clauses.push(ClauseFact { id: id.to_owned(), asks, status, note })
            }
            _ => facts.push(RequirementFact { id: row.id.clone(), asks, status, note, clauses: Vec::new() }),
        }
    }
    facts
}

/// Runs the shipped library for its verdicts.
fn run_library() -> Result<RunRecord, Diagnostic> {
    let (mut loaded, mut jobs, mut sources) = (Vec::new(), Vec::new(), Vec::new());
    for (place, path) in library::plans().iter().enumerate() {
        let plan = suite::load_plan(&ShippedFiles, path, None, &[], 1, &mut sources).map_err(|found| {
            let lost = || Diagnostic::error("R0201", format!("the shipped plan {path} does not read"));
            found.into_iter().next().unwrap_or_else(lost)
        })?;
        jobs.extend(plan.jobs(place, 1, 1));
        loaded.push(plan);
    }
    let interrupt = AtomicBool::new(false);
    let options = RunOptions::new(ClockKind::Virtual, &interrupt);
    let at_once = std::thread::available_parallelism().map_or(1, usize::from);
    let mut run = RunRecord::default();
    jobs::run(&loaded, &jobs, at_once, false, &options, &mut |_, done| {
        if let JobResult::Case(result) = done {
            run.push(result.record);
        }
    });
    Ok(run)
}
