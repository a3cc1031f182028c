//! Plans on a rig that is kept running: chosen beside the scan, run in its place, reported as they go.

use super::fault;
use crate::case::{ClockKind, RunOptions, run_case};
use crate::scan_port::{ScanPort, lock};
use crate::soft_plc::{self, SoftPlcEvent, SoftPlcReport, SoftPlcSettings};
use crate::suite::case_files::CaseFiles;
use crate::suite::{self, FileSource, Job, LoadedPlan};
use control::{Measured, PlanEvent, RequestFault};
use document::Diagnostic;
use drivers::BoardFile;
use plans::Case;
use record::{CaseRecord, CaseStatus, MeasurementRecord, Verdict};
use signal::Span;
use std::sync::atomic::Ordering;
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// Where the plans are that a rig can run.
pub trait PlanSource: Send + Sync + std::fmt::Debug {
    /// The plans of a file or folder, or those that ship. A search ends early where `is_wanted` says that nobody waits for it.
    ///
    /// # Errors
    /// Why there are none.
    fn plans(&self, path: Option<&str>, is_wanted: &dyn Fn() -> bool) -> Result<Vec<String>, String>;

    /// Where the files of a plan are.
    fn files(&self, plan: &str) -> &'static dyn FileSource;
}

/// What plans are chosen with.
#[derive(Clone, Debug)]
pub struct PlanBench {
    /// The plans.
    pub source: Arc<dyn PlanSource>,
    /// The board that they run on, with its text.
    pub board: (BoardFile, String),
    /// The seed of what they leave to chance.
    pub seed: u64,
}

/// Cases that were chosen, and wait for the scan to end.
#[derive(Debug)]
pub struct ChosenCases {
    loaded: LoadedPlan,
    jobs: Vec<Job>,
}

/// The place where they wait.
#[derive(Clone, Debug, Default)]
pub struct PlanSlot(Arc<Mutex<Option<ChosenCases>>>);

impl PlanSlot {
    /// Leaves cases for the rig to run, in place of those that were left before.
    pub(super) fn put(&self, chosen: ChosenCases) {
        *lock(&self.0) = Some(chosen);
    }

    fn take(&self) -> Option<ChosenCases> {
        lock(&self.0).take()
    }
}

impl PlanBench {
    /// The cases of the plans of a file or folder; without one the plans that ship, which are too many to be read for it.
    /// Ends early where `is_wanted` says that nobody waits for them.
    ///
    /// # Errors
    /// There are none.
    pub fn list(
        &self,
        path: Option<&str>,
        is_wanted: &dyn Fn() -> bool,
    ) -> Result<Vec<String>, RequestFault> {
        let plans = self.source.plans(path, is_wanted).map_err(|why| fault::plan(&why))?;
        if path.is_none() {
            let named = |plan: String| plan.strip_suffix(".toml").map(str::to_owned).unwrap_or(plan);
            return Ok(plans.into_iter().map(named).collect());
        }
        let mut names = Vec::new();
        for plan in plans.into_iter().take_while(|_| is_wanted()) {
            // One that cannot be read does not keep the others from being listed.
            let Ok(loaded) = self.load(&plan) else { continue };
            names.extend(loaded.jobs(0, self.seed, 1).into_iter().map(|job| job.name));
        }
        Ok(names)
    }

    /// The case of this name, or all cases of the plan.
    ///
    /// # Errors
    /// A plan that cannot be read, or a case that it does not have.
    pub fn choose(&self, name: &str) -> Result<ChosenCases, RequestFault> {
        let plan = name.split('[').next().unwrap_or(name);
        let plan = plan.strip_suffix(".toml").unwrap_or(plan);
        let loaded = self.load(&format!("{plan}.toml")).map_err(|found| {
            let worst = found.iter().find(|found| found.is_error()).or(found.first());
            fault::plan(&worst.map_or_else(String::new, |found| format!("{}: {}", found.code, found.message)))
        })?;
        let mut jobs = loaded.jobs(0, self.seed, 1);
        if name.contains('[') || jobs.iter().any(|job| job.name == name) {
            let names: Vec<String> = jobs.iter().map(|job| job.name.clone()).collect();
            jobs.retain(|job| job.name == name);
            if jobs.is_empty() {
                let meant = document::suggest(name, names.iter().map(String::as_str));
                return Err(fault::no_case(name, meant));
            }
        }
        if jobs.is_empty() {
            return Err(fault::plan("it has no case"));
        }
        Ok(ChosenCases { loaded, jobs })
    }

    fn load(&self, plan: &str) -> Result<LoadedPlan, Vec<Diagnostic>> {
        suite::load_plan(self.source.files(plan), plan, Some(&self.board), &[], self.seed, &mut Vec::new())
    }
}

/// Keeps a controller running as [`soft_plc::run`] does, and runs what clients choose in between: the controller is stopped
/// for it, with its outputs safe, and begins again after it.
///
/// # Errors
/// Findings in the user's files.
pub fn run_with_plans(
    case: &Case,
    files: &CaseFiles,
    options: &RunOptions<'_>,
    settings: SoftPlcSettings,
    slot: &PlanSlot,
    events: &SyncSender<SoftPlcEvent>,
) -> Result<SoftPlcReport, Vec<Diagnostic>> {
    let began = Instant::now();
    loop {
        let passed = i64::try_from(began.elapsed().as_nanos()).map_or(Span::MAX, Span::from_nanos);
        let left = settings.duration.map(|lasts| if lasts > passed { lasts - passed } else { Span::ZERO });
        let lasts = if options.clock == ClockKind::Real { left } else { settings.duration };
        let played = soft_plc::run(
            case,
            files,
            options,
            SoftPlcSettings { duration: lasts, ..settings },
            events.clone(),
        )?;
        let Some(port) = options.live.filter(|port| lock(port).take_plan_request()) else {
            return Ok(played);
        };
        let Some(chosen) = slot.take() else { return Ok(played) };
        run(&chosen, options, port);
        if options.interrupt.load(Ordering::Relaxed) {
            return Ok(played);
        }
    }
}

/// Runs the cases one after the other.
fn run(chosen: &ChosenCases, options: &RunOptions<'_>, port: &Mutex<ScanPort>) {
    let most = chosen.jobs.len() as u32;
    let mut verdicts = Vec::new();
    for (place, job) in (1..).zip(&chosen.jobs) {
        if lock(port).between() || options.interrupt.load(Ordering::Relaxed) {
            break;
        }
        let record = run_job(chosen, job, (place, most), options, port);
        verdicts.push(record.verdict);
        lock(port).plan(verdict_of(&record));
        if lock(port).is_aborted() {
            break;
        }
    }
    let mut port = lock(port);
    let whole = verdicts.len() == chosen.jobs.len() && !port.is_aborted();
    let all = Verdict::fold(verdicts);
    let verdict = if whole { all } else { all.max(Verdict::Inconclusive) };
    port.plan(PlanEvent::Over { verdict: verdict.word().into(), report: None });
    port.ends_plan();
}

fn run_job(
    chosen: &ChosenCases,
    job: &Job,
    place: (u32, u32),
    options: &RunOptions<'_>,
    port: &Mutex<ScanPort>,
) -> CaseRecord {
    let run = || {
        let case = chosen.loaded.plan.case_with(job.case, job.seed)?;
        let files = chosen.loaded.files(&case, job)?;
        lock(port).plan(begin_of(&case, &files, job, place));
        run_case(&case, &files, options)
    };
    match run() {
        Ok(result) => result.record,
        Err(found) => {
            let worst = found.iter().find(|found| found.is_error()).or(found.first());
            CaseRecord {
                name: job.name.clone(),
                verdict: Verdict::Error,
                reason: worst.map_or_else(String::new, |found| format!("{}: {}", found.code, found.message)),
                ..CaseRecord::default()
            }
        }
    }
}

fn begin_of(case: &Case, files: &CaseFiles, job: &Job, place: (u32, u32)) -> PlanEvent {
    let record = crate::suite::describe::record_of(case, files);
    let claims = case.expectations.iter().map(|claim| {
        let asks = claim.claim.expected();
        // As the verdict names it.
        let name = if claim.name.is_empty() { asks.clone() } else { claim.name.clone() };
        (name, asks)
    });
    let measured = case.measurements.iter().map(|known| (known.name.clone(), known.quantity.to_string()));
    PlanEvent::Case {
        name: job.name.clone(),
        place,
        steps: record.steps.into_iter().map(|step| (step.id, step.what)).collect(),
        claims: claims.chain(measured).collect(),
    }
}

fn verdict_of(record: &CaseRecord) -> PlanEvent {
    let (verdict, reason) = match &record.status {
        CaseStatus::NotApplicable { reason } => ("not applicable", reason.clone()),
        CaseStatus::Skipped { reason } => ("skipped", reason.clone()),
        CaseStatus::Judged => (record.verdict.word(), record.reason.clone()),
    };
    let claims = record.claims.iter();
    PlanEvent::Verdict {
        name: record.name.clone(),
        verdict: verdict.into(),
        reason,
        claims: claims.map(|it| (it.name.clone(), it.verdict.word().into(), it.reason.clone())).collect(),
        measured: record.measurements.iter().map(measured).collect(),
    }
}

fn measured(it: &MeasurementRecord) -> Measured {
    let around = |sign: f64| Some(it.nominal? + sign * it.tolerance?);
    Measured {
        name: it.name.clone(),
        value: it.value.map(|[from, to]| (from, to)),
        low: it.min.or_else(|| around(-1.0)),
        high: it.max.or_else(|| around(1.0)),
        unit: it.unit.clone(),
        verdict: it.verdict.word().into(),
    }
}
