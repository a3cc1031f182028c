//! Plans out of texts, and their cases in parts that a test looks into.

// Each test is a crate of its own and uses a part of this.
#![allow(dead_code)]

use controller::{Config, State, TaskModule};
use document::{Diagnostic, SourceFile};
use drivers::{Board, BoardFile, OnLoss};
use plans::judge::CaseJudge;
use record::Verdict;
use scanrig_runtime::application::bundle::{Bundle, TaskPrograms};
use scanrig_runtime::application::compile;
use scanrig_runtime::application::functions;
use scanrig_runtime::application::store::MemoryStore;
use scanrig_runtime::case::check_case;
use scanrig_runtime::case::jobs::{self, JobResult};
use scanrig_runtime::executor::clock::Clock;
use scanrig_runtime::executor::recorder::Recorder;
use scanrig_runtime::executor::{Executor, ExecutorLimits, ExecutorReport, Parts};
use scanrig_runtime::prepare::{ArmedAlarm, PreparedCase, TestBench, prepare};
use scanrig_runtime::scan_port::{ExecutorRole, ScanPort};
use scanrig_runtime::schedule::Schedule;
use scanrig_runtime::subject::Subject;
use scanrig_runtime::subject::model::ModelledController;
use scanrig_runtime::suite::{self, FileSource, Job, LoadedPlan};
use scanrig_runtime::wiring::Wiring;
use scanrig_runtime::{CaseResult, RunOptions};
use signal::{Area, Span, Trace};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Files that a test holds as pairs of a name and a text. The plan is `plan.toml`.
#[derive(Clone, Copy, Debug)]
pub struct Texts<'a>(pub &'a [(&'a str, &'a str)]);

impl FileSource for Texts<'_> {
    fn read(&self, path: &str) -> Result<String, String> {
        let found = self.0.iter().find(|(name, _)| *name == path);
        found.map(|(_, text)| (*text).to_owned()).ok_or_else(|| format!("the test has no file {path}"))
    }
}

impl Texts<'_> {
    /// The plan and its jobs.
    pub fn load(&self, seed: u64) -> (LoadedPlan, Vec<Job>) {
        let mut sources: Vec<SourceFile> = Vec::new();
        let loaded = suite::load_plan(self, "plan.toml", None, &[], seed, &mut sources);
        let loaded = loaded.unwrap_or_else(|found| panic!("{found:#?}"));
        let jobs = loaded.jobs(0, seed, 1);
        (loaded, jobs)
    }

    /// What the check finds of the plan's first case; `Err` where it is refused.
    pub fn checked(&self) -> Result<Vec<Diagnostic>, Vec<Diagnostic>> {
        let (loaded, jobs) = self.load(1);
        let case = loaded.plan.case(jobs[0].case).unwrap();
        let files = loaded.files(&case, &jobs[0]).unwrap();
        check_case(&case, &files)
    }

    /// What became of the plan's only case.
    pub fn done(&self, seed: u64, options: &RunOptions<'_>) -> JobResult {
        let (loaded, jobs) = self.load(seed);
        assert_eq!(jobs.len(), 1);
        let mut last = None;
        jobs::run(&[loaded], &jobs, 1, false, options, &mut |_, done| last = Some(done));
        last.unwrap()
    }

    /// The result of the plan's only case.
    pub fn run(&self, seed: u64, options: &RunOptions<'_>) -> Box<CaseResult> {
        match self.done(seed, options) {
            JobResult::Case(result) => result,
            other => panic!("{other:#?}"),
        }
    }

    /// The plan's only case in parts, with the usual configuration of the controller.
    pub fn parts(&self, seed: u64) -> (ModelledController, Parted) {
        self.parts_with(seed, |_| {})
    }

    /// The same with another configuration of the controller.
    pub fn parts_with(&self, seed: u64, change: impl FnOnce(&mut Config)) -> (ModelledController, Parted) {
        self.parts_on(seed, change, |board| board).unwrap_or_else(|found| panic!("{found:#?}"))
    }

    /// The same on another board in the place of the one in the file, or what does not fit it.
    pub fn parts_on(
        &self,
        seed: u64,
        change: impl FnOnce(&mut Config),
        other: impl FnOnce(Box<dyn Board>) -> Box<dyn Board>,
    ) -> Result<(ModelledController, Parted), Vec<Diagnostic>> {
        self.parts_of(seed, change, other, Vec::new())
    }

    /// The same on `board.toml`, with modules after the embedded inputs and outputs. The plan names no board: what it names is
    /// read for the reference alone.
    pub fn parts_with_modules(
        &self,
        seed: u64,
        modules: Vec<Box<dyn TaskModule>>,
    ) -> Result<(ModelledController, Parted), Vec<Diagnostic>> {
        self.parts_of(seed, |_| {}, |board| board, modules)
    }

    /// `board.toml` of a controller with modules.
    fn board_with(&self, modules: &[Box<dyn TaskModule>]) -> Result<BoardFile, Vec<Diagnostic>> {
        let file = SourceFile::new("board.toml", self.read("board.toml").unwrap());
        drivers::read(&file, &|subject| {
            let mut terminals = suite::terminals(subject)?;
            for channel in modules.iter().flat_map(|module| module.channels()) {
                match channel.address.area() {
                    Area::Output => terminals.outputs.push(channel.address),
                    _ => terminals.inputs.push(channel.address),
                }
            }
            Ok(terminals)
        })
    }

    fn parts_of(
        &self,
        seed: u64,
        change: impl FnOnce(&mut Config),
        other: impl FnOnce(Box<dyn Board>) -> Box<dyn Board>,
        modules: Vec<Box<dyn TaskModule>>,
    ) -> Result<(ModelledController, Parted), Vec<Diagnostic>> {
        let (loaded, jobs) = self.load(seed);
        let case = loaded.plan.case(jobs[0].case).unwrap();
        let mut files = loaded.files(&case, &jobs[0]).unwrap();
        if !modules.is_empty() {
            files.board = self.board_with(&modules)?;
        }
        let program = Arc::new(compile(&files.sources, files.profile).unwrap());
        let mut config = Config::new(files.profile);
        config.reference = files.reference;
        config.expert = functions::configure(&case.settings, &files.plan.name).unwrap();
        change(&mut config);
        let tasks = vec![TaskPrograms { task: "MAST".to_owned(), programs: None }];
        let bundle = Bundle { sources: files.sources.clone(), tasks }.to_bytes();
        let board = other(drivers::build(&files.board, seed).unwrap());
        let store = Box::new(MemoryStore::default());
        let mut model =
            ModelledController::with_modules(config, Some(program), store, None, modules).unwrap();
        model.commission(&bundle, State::Running).unwrap();
        let mut bench = TestBench {
            modules: &[],
            linked: false,
            subject: &mut model,
            board: &*board,
            file: &files.board,
            profile: files.profile,
            reference: files.reference,
            bundle: &bundle,
            others: &[],
            seed,
            exact: true,
        };
        let prepared = prepare(&case, &files.plan, Trace::new(), &mut bench)?;
        let PreparedCase { trace, wiring, steps, alarms, warnings, .. } = prepared;
        let judge = CaseJudge::new(case.scenario(), trace.signals()).unwrap();
        let schedule = Schedule::new(steps, case.ends.clone());
        let recorder = Recorder::new(trace, judge);
        let (timeout, teardown) = (case.timeout, case.teardown);
        let late = Span::from_millis(20);
        let on_loss = files.board.on_loss;
        let parts = Parted {
            board,
            recorder,
            schedule,
            wiring,
            warnings,
            alarms,
            timeout,
            teardown,
            late,
            slice: Span::MAX,
            on_loss,
        };
        Ok((model, parts))
    }
}

/// What is around the subject of a case.
#[derive(Debug)]
pub struct Parted {
    pub board: Box<dyn Board>,
    pub recorder: Recorder,
    pub schedule: Schedule,
    pub wiring: Wiring,
    /// What is wrong with the plan on this board and does not keep it from running.
    pub warnings: Vec<Diagnostic>,
    alarms: Vec<ArmedAlarm>,
    timeout: Span,
    teardown: Span,
    /// How late the rig may be.
    pub late: Span,
    /// The longest that the application runs at a stretch.
    pub slice: Span,
    on_loss: OnLoss,
}

impl Parted {
    /// Runs it on this clock; the parts are there to be looked into afterwards.
    pub fn run(&mut self, clock: &mut dyn Clock, subject: &mut dyn Subject) -> ExecutorReport {
        self.serve(clock, subject, None)
    }

    /// The same, and clients are served.
    pub fn serve(
        &mut self,
        clock: &mut dyn Clock,
        subject: &mut dyn Subject,
        port: Option<&mut ScanPort>,
    ) -> ExecutorReport {
        let interrupt = AtomicBool::new(false);
        let limits = ExecutorLimits {
            initial: State::Running,
            late: self.late,
            slice: self.slice,
            horizon: Span::from_micros(100),
            fail_fast: false,
            on_loss: self.on_loss,
            reconnect: false,
            timeout: self.timeout,
            teardown: self.teardown,
        };
        let parts = Parts {
            clock,
            subject,
            board: &mut *self.board,
            recorder: &mut self.recorder,
            schedule: &mut self.schedule,
            wiring: &mut self.wiring,
            alarms: &mut self.alarms,
            interrupt: &interrupt,
            operator: None,
            heartbeat: None,
            loop_counter: None,
        };
        Executor::new(parts, limits).serving(port, ExecutorRole::Rig).run()
    }
}

/// Panics unless the result has this verdict.
pub fn expect(result: &CaseResult, verdict: Verdict) {
    let record = &result.record;
    assert_eq!(record.verdict, verdict, "{}: {}\n{:#?}", record.name, record.reason, record.claims);
}
