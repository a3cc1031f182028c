//! `rig requirements`.

use crate::args::{Format, RequirementsArgs};
use crate::exit::Exit;
use crate::library::{self, Embedded, REGISTER};
use crate::output;
use plans::register::{Class, Register};
use record::{RunRecord, Verdict};
use runtime::suite::{self, Done};
use runtime::{ClockKind, RunOptions};
use serde_json::json;
use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

/// What a requirement came to, and by which cases.
#[derive(Default)]
struct Proof {
    cases: Vec<String>,
    verdict: Verdict,
}

/// Prints the register with what proves it.
pub fn run(args: &RequirementsArgs) -> Exit {
    let register = match Register::read(REGISTER) {
        Ok(register) => register,
        Err(error) => {
            output::complain(&format!("the register of requirements is broken: {error}"));
            return Exit::Error;
        }
    };
    let record = match &args.report {
        Some(folder) => read(folder),
        None => run_library(),
    };
    let record = match record {
        Ok(record) => record,
        Err(error) => {
            output::complain(&error);
            return Exit::UserFiles;
        }
    };
    let mut proofs: BTreeMap<&str, Proof> = BTreeMap::new();
    let mut unknown = Vec::new();
    for case in record.cases.iter().filter(|case| case.is_judged()) {
        for id in &case.proves {
            if register.find(id).is_none() && !unknown.contains(id) {
                unknown.push(id.clone());
            }
            let proof = proofs.entry(id).or_default();
            proof.cases.push(case.name.clone());
            proof.verdict = proof.verdict.max(case.verdict);
        }
    }
    if !unknown.is_empty() {
        output::complain(&format!("cited, but not in the register: {}", unknown.join(", ")));
        return Exit::UserFiles;
    }
    match args.format {
        Format::Json => json(&register, &proofs),
        Format::Table => table(&register, &proofs),
    }
    Exit::Passed
}

fn status(class: Class, proof: Option<&Proof>) -> &'static str {
    match proof {
        Some(Proof { verdict: Verdict::Pass, .. }) => "proven",
        Some(_) => "failing",
        None if class == Class::NotReproducible => "not reproducible",
        None => "unproven",
    }
}

fn json(register: &Register, proofs: &BTreeMap<&str, Proof>) {
    let rows: Vec<serde_json::Value> = register
        .entries
        .iter()
        .map(|entry| {
            let proof = proofs.get(entry.id.as_str());
            json!({
                "id": entry.id,
                "status": status(entry.class, proof),
                "class": entry.class.word(),
                "asks": entry.asks,
                "source": entry.source,
                "profiles": entry.profiles.iter().map(|profile| profile.name()).collect::<Vec<_>>(),
                "cases": proof.map(|proof| proof.cases.clone()).unwrap_or_default(),
            })
        })
        .collect();
    let text = serde_json::to_string_pretty(&rows).unwrap_or_default();
    output::print(&format!("{text}\n"));
}

fn table(register: &Register, proofs: &BTreeMap<&str, Proof>) {
    let width = register.entries.iter().map(|entry| entry.id.len()).max().unwrap_or(0);
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for entry in &register.entries {
        let proof = proofs.get(entry.id.as_str());
        let status = status(entry.class, proof);
        *counts.entry(status).or_default() += 1;
        let cases = proof.map_or(0, |proof| proof.cases.len());
        let by = if cases == 0 { String::new() } else { format!(" ({cases} cases)") };
        output::print(&format!("{:width$}  {status:16}  {}{by}\n", entry.id, entry.asks));
    }
    let counts: Vec<String> = counts.iter().map(|(status, count)| format!("{count} {status}")).collect();
    output::print(&format!("{} requirements: {}\n", register.entries.len(), counts.join(", ")));
}

fn read(folder: &std::path::Path) -> Result<RunRecord, String> {
    let path = folder.join("record.json");
    let text = std::fs::read_to_string(&path)
        .map_err(|error| format!("{} cannot be read: {error}", path.display()))?;
    RunRecord::from_json(&text).map_err(|error| format!("{}: {error}", path.display()))
}

/// Runs the shipped library for its verdicts.
fn run_library() -> Result<RunRecord, String> {
    let (mut loaded, mut jobs, mut sources) = (Vec::new(), Vec::new(), Vec::new());
    for (place, path) in library::plans().iter().enumerate() {
        let plan = suite::load_plan(&Embedded, path, None, &[], 1, &mut sources)
            .map_err(|_| format!("the shipped plan {path} does not read: run `rig test`"))?;
        jobs.extend(plan.jobs(place, 1, 1));
        loaded.push(plan);
    }
    let interrupt = AtomicBool::new(false);
    let options = RunOptions::new(ClockKind::Virtual, &interrupt);
    let at_once = std::thread::available_parallelism().map_or(1, usize::from);
    let mut run = RunRecord::default();
    suite::run(&loaded, &jobs, at_once, false, &options, &mut |_, done| {
        if let Done::Case(result) = done {
            run.push(result.record);
        }
    });
    Ok(run)
}
