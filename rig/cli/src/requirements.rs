//! `rig requirements`.

use crate::exit::ExitStatus;
use crate::output::OutputFormat;
use crate::plan_files::library::{self, REGISTER, ShippedFiles};
use crate::{output, saved_runs};
use clap::Args;
use document::Diagnostic;
use plans::register::{Requirement, RequirementClass, RequirementRegister};
use profile::Profile;
use record::{RequirementFact, RunRecord, Verdict};
use runtime::case::jobs::{self, JobResult};
use runtime::suite;
use runtime::{ClockKind, RunOptions};
use serde_json::json;
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

/// What a requirement or a clause came to under one profile, and by which cases.
#[derive(Debug, Default)]
struct Proof {
    cases: Vec<String>,
    verdict: Verdict,
}

/// What is cited, with its proofs by the names of the profiles.
type Proofs = BTreeMap<String, BTreeMap<String, Proof>>;

/// What can be said of a requirement or a clause. The greatest of several is the one reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum ProofStatus {
    Proven,
    NotReproducible,
    Unproven,
    Failing,
}

impl ProofStatus {
    const fn word(self) -> &'static str {
        match self {
            ProofStatus::Proven => "proven",
            ProofStatus::NotReproducible => "not reproducible",
            ProofStatus::Unproven => "unproven",
            ProofStatus::Failing => "failing",
        }
    }

    /// One column of the table.
    const fn sign(self) -> &'static str {
        match self {
            ProofStatus::Proven => "+",
            ProofStatus::NotReproducible => " ",
            ProofStatus::Unproven => "-",
            ProofStatus::Failing => "!",
        }
    }
}

/// One row of what is printed: a requirement, or one of its clauses.
#[derive(Debug)]
struct PrintedRow<'a> {
    id: String,
    asks: &'a str,
    entry: &'a Requirement,
    status: ProofStatus,
    profiles: Vec<(Profile, ProofStatus, &'a [String])>,
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
    let proofs = proofs(&record);
    let unknown: Vec<&str> = proofs.keys().map(String::as_str).filter(|id| !register.knows(id)).collect();
    if !unknown.is_empty() {
        output::error(&format!("cited, but not in the register: {}", unknown.join(", ")));
        return ExitStatus::UserFiles;
    }
    let rows: Vec<PrintedRow<'_>> = register.entries.iter().flat_map(|entry| rows(entry, &proofs)).collect();
    match args.format {
        OutputFormat::Json => json(&rows),
        OutputFormat::Table => table(&rows),
    }
    ExitStatus::Passed
}

fn proofs(record: &RunRecord) -> Proofs {
    let mut proofs = Proofs::new();
    for case in record.cases.iter().filter(|case| case.is_judged()) {
        for id in &case.proves {
            let proof = proofs.entry(id.clone()).or_default().entry(case.profile.clone()).or_default();
            proof.cases.push(case.name.clone());
            proof.verdict = proof.verdict.max(case.verdict);
        }
    }
    proofs
}

/// The row of a requirement, and after it those of its clauses. With clauses it is proven when each of them is.
fn rows<'a>(entry: &'a Requirement, proofs: &'a Proofs) -> Vec<PrintedRow<'a>> {
    let own = row(entry.id.clone(), &entry.asks, entry, &entry.proof.profiles, proofs);
    if entry.clauses.is_empty() {
        return vec![own];
    }
    let clauses = entry.clauses.iter().map(|clause| {
        let holds =
            if clause.proof.profiles.is_empty() { &entry.proof.profiles } else { &clause.proof.profiles };
        row(format!("{}#{}", entry.id, clause.id), &clause.asks, entry, holds, proofs)
    });
    let clauses: Vec<PrintedRow<'_>> = clauses.collect();
    let least = clauses.iter().map(|row| row.status).max().unwrap_or(ProofStatus::Unproven);
    let failing = own.status == ProofStatus::Failing;
    let mut rows = vec![PrintedRow { status: if failing { ProofStatus::Failing } else { least }, ..own }];
    rows.extend(clauses);
    rows
}

fn row<'a>(
    id: String,
    asks: &'a str,
    entry: &'a Requirement,
    holds: &[Profile],
    proofs: &'a Proofs,
) -> PrintedRow<'a> {
    let known = proofs.get(&id);
    let unproven = match entry.proof.class {
        RequirementClass::NotReproducible => ProofStatus::NotReproducible,
        RequirementClass::Behaviour | RequirementClass::Constant => ProofStatus::Unproven,
    };
    let profiles: Vec<(Profile, ProofStatus, &[String])> = Profile::ALL
        .into_iter()
        .filter(|profile| holds.is_empty() || holds.contains(profile))
        .map(|profile| match known.and_then(|known| known.get(profile.name())) {
            None => (profile, unproven, &[][..]),
            Some(Proof { verdict: Verdict::Pass, cases }) => (profile, ProofStatus::Proven, cases.as_slice()),
            Some(proof) => (profile, ProofStatus::Failing, proof.cases.as_slice()),
        })
        .collect();
    // What one profile shows holds as shown, unless another profile shows the contrary.
    let any = |status: ProofStatus| profiles.iter().any(|(_, found, _)| *found == status);
    let status = [ProofStatus::Failing, ProofStatus::Proven]
        .into_iter()
        .find(|status| any(*status))
        .unwrap_or(unproven);
    PrintedRow { id, asks, entry, status, profiles }
}

/// The cases that prove something of a row: of a requirement also those of its clauses.
fn cases<'a>(row: &PrintedRow<'a>, all: &[PrintedRow<'a>]) -> Vec<&'a str> {
    let of =
        |other: &&PrintedRow<'a>| other.id == row.id || !row.id.contains('#') && other.entry.id == row.id;
    let lists = all.iter().filter(of).flat_map(|row| &row.profiles).map(|(.., cases)| *cases);
    let mut names: Vec<&str> = lists.flatten().map(String::as_str).collect();
    names.sort_unstable();
    names.dedup();
    names
}

fn json(all: &[PrintedRow<'_>]) {
    let rows: Vec<serde_json::Value> = all
        .iter()
        .map(|row| {
            let profiles: Vec<serde_json::Value> = row
                .profiles
                .iter()
                .map(|(profile, status, cases)| {
                    json!({ "profile": profile.name(), "status": status.word(), "cases": cases })
                })
                .collect();
            json!({
                "id": row.id,
                "status": row.status.word(),
                "class": row.entry.proof.class.word(),
                "asks": row.asks,
                "source": row.entry.source,
                "cases": cases(row, all),
                "profiles": profiles,
            })
        })
        .collect();
    let text = serde_json::to_string_pretty(&rows).unwrap_or_default();
    output::print(&format!("{text}\n"));
}

fn table(rows: &[PrintedRow<'_>]) {
    let width = rows.iter().map(|row| row.id.len()).max().unwrap_or(0);
    let names = Profile::ALL.map(Profile::name).join(", ");
    output::print(&format!(
        "{:width$}  proven by cases of {names}: + all pass, ! one does not, - none\n",
        ""
    ));
    let (mut requirements, mut clauses) = (BTreeMap::new(), BTreeMap::new());
    for row in rows {
        let of = if row.id.contains('#') { &mut clauses } else { &mut requirements };
        *of.entry(row.status).or_insert(0) += 1;
        let signs = Profile::ALL.map(|profile| {
            row.profiles
                .iter()
                .find(|(known, ..)| *known == profile)
                .map_or(" ", |(_, status, _)| status.sign())
        });
        let cases = cases(row, rows).len();
        let by = if cases == 0 { String::new() } else { format!(" ({cases} cases)") };
        let (id, signs, status) = (&row.id, signs.concat(), row.status.word());
        output::print(&format!("{id:width$}  {signs}  {status:16}  {}{by}\n", row.asks));
    }
    for (what, counts) in [("clauses", clauses), ("requirements", requirements)] {
        let total: usize = counts.values().sum();
        let counts: Vec<String> =
            counts.iter().map(|(status, count)| format!("{count} {}", status.word())).collect();
        output::print(&format!("{total} {what}: {}\n", counts.join(", ")));
    }
}

/// What the register says of the requirements that the cases of a run prove, in its order; for reports, which read
/// nothing but the record.
pub fn facts(run: &RunRecord) -> Vec<RequirementFact> {
    let requirement = |cited: &str| cited.split('#').next().unwrap_or_default().to_owned();
    let cited: BTreeSet<String> =
        run.cases.iter().flat_map(|case| case.proves.iter().map(|id| requirement(id))).collect();
    // A register that cannot be read is no trouble of the run: the command that prints it says so.
    let register = RequirementRegister::read(REGISTER).unwrap_or_default();
    let fact = |entry: Requirement| RequirementFact {
        id: entry.id,
        asks: entry.asks,
        clauses: entry.clauses.into_iter().map(|clause| (clause.id, clause.asks)).collect(),
    };
    register.entries.into_iter().filter(|entry| cited.contains(&entry.id)).map(fact).collect()
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

#[cfg(test)]
mod tests {
    use super::*;
    use record::CaseRecord;

    fn statuses(cited: &[(&str, &str, Verdict)]) -> Vec<(String, &'static str)> {
        let text = "[\"controller:RB-02\"]\nasks = \"a\"\nsource = \"s\"\n\
                    [\"controller:RB-02\".clauses]\n\"1\" = \"b\"\n\"2\" = \"c\"\n\
                    [\"controller:WD-04\"]\nasks = \"a\"\nsource = \"s\"\nprofiles = [\"m241-2014\"]\n";
        let register = RequirementRegister::read(text).unwrap();
        let mut record = RunRecord::default();
        for (id, profile, verdict) in cited {
            record.push(CaseRecord {
                name: String::from("case"),
                profile: (*profile).to_owned(),
                proves: vec![(*id).to_owned()],
                verdict: *verdict,
                ..CaseRecord::default()
            });
        }
        let proofs = proofs(&record);
        let rows: Vec<PrintedRow<'_>> =
            register.entries.iter().flat_map(|entry| rows(entry, &proofs)).collect();
        rows.iter().map(|row| (row.id.clone(), row.status.word())).collect()
    }

    // A requirement with clauses is proven by all of them only, and one failing case is enough against it.
    #[test]
    fn clauses_decide() {
        let one = ("controller:RB-02#1", "m241-2019", Verdict::Pass);
        let two = ("controller:RB-02#2", "m241-2014", Verdict::Pass);
        let fail = ("controller:RB-02#2", "m251-2024", Verdict::Fail);
        let whole = ("controller:RB-02", "m241-2019", Verdict::Pass);
        assert_eq!(statuses(&[whole, one])[0].1, "unproven");
        assert_eq!(statuses(&[one, two])[0].1, "proven");
        assert_eq!(statuses(&[one, two, fail])[0].1, "failing");
        assert_eq!(
            statuses(&[one])[1..3],
            [("controller:RB-02#1".into(), "proven"), ("controller:RB-02#2".into(), "unproven")]
        );
        assert_eq!(statuses(&[("controller:WD-04", "m241-2014", Verdict::Fail)])[3].1, "failing");
    }
}
