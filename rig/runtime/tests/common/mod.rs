//! The shipped library in process, and small rigs whose parts a test can take in hand.

// Each test binary uses a part of it.
#![allow(dead_code)]

use controller::{Config, Probe, State};
use document::SourceFile;
use drivers::file::{BoardFile, Terminals, read as read_board};
use drivers::{Board, ChannelId};
use plans::Case;
use plans::judge::Judge;
use profile::{Profile, Reference};
use scanrig_runtime::application::compile;
use scanrig_runtime::bundle::Bundle;
use scanrig_runtime::clock::Clock;
use scanrig_runtime::executor::{Executor, Limits, Parts, Ran};
use scanrig_runtime::prepare::{Bench, Prepared, prepare};
use scanrig_runtime::recorder::Recorder;
use scanrig_runtime::schedule::Schedule;
use scanrig_runtime::store::MemoryStore;
use scanrig_runtime::subject::{Model, Subject};
use scanrig_runtime::suite::{self, Disk, Job, LoadedPlan};
use scanrig_runtime::{CaseResult, RunOptions, run_case};
use signal::{Cause, Span, Time, Trace, Value, When};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

const LIBRARY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../plans/library");

fn collect(folder: &Path, found: &mut Vec<String>) {
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            collect(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "toml") {
            let text = std::fs::read_to_string(&path).unwrap();
            // A board file stands beside its plans.
            if !text.contains("[board]") {
                found.push(path.to_string_lossy().into_owned());
            }
        }
    }
}

/// The plans that ship, with all their cases.
pub struct Library {
    pub plans: Vec<LoadedPlan>,
    pub jobs: Vec<Job>,
}

impl Library {
    pub fn load() -> Library {
        let (mut paths, mut sources) = (Vec::new(), Vec::new());
        collect(Path::new(LIBRARY), &mut paths);
        let load = |path: &String| {
            suite::load_plan(&Disk, path, None, &[], 1, &mut sources)
                .unwrap_or_else(|found| panic!("{found:#?}"))
        };
        let plans: Vec<LoadedPlan> = paths.iter().map(load).collect();
        let jobs = plans.iter().enumerate().flat_map(|(place, plan)| plan.jobs(place, 1, 1)).collect();
        Library { plans, jobs }
    }

    pub fn case(&self, job: &Job) -> Case {
        self.plans[job.plan].plan.case(job.case).unwrap()
    }

    pub fn run(&self, job: &Job, options: &RunOptions<'_>) -> CaseResult {
        let case = self.case(job);
        let files = self.plans[job.plan].files(&case, job).unwrap();
        run_case(&case, &files, options).unwrap_or_else(|found| panic!("{}: {found:#?}", job.name))
    }
}

/// A controller with its program, and a board file, before power-on.
pub struct Small {
    pub case: Case,
    pub plan: SourceFile,
    pub board_file: BoardFile,
    pub model: Model,
    bundle: Vec<u8>,
}

const PROFILE: Profile = Profile::M241_2019;

fn reference() -> &'static Reference {
    Reference::find("TM241CEC24T").unwrap()
}

fn terminals() -> Terminals {
    suite::terminals(&drivers::Subject::default()).unwrap()
}

impl Small {
    /// The first case of a plan, with a program and the text of a board file; no text is the board without wires.
    pub fn new(plan: &str, program: &str, board: &str) -> Small {
        let plan = SourceFile::new("small.toml", plan.to_owned());
        let case =
            plans::read(&plan, &[], 1).unwrap_or_else(|found| panic!("{found:#?}")).cases().next().unwrap();
        let sources = vec![SourceFile::new("small.st", program.to_owned())];
        let board_file = if board.is_empty() {
            BoardFile::default_for(&terminals().inputs, &terminals().outputs)
        } else {
            let file = SourceFile::new("board.toml", board.to_owned());
            read_board(&file, &|_: &drivers::Subject| Ok(terminals()))
                .unwrap_or_else(|found| panic!("{found:#?}"))
        };
        let program = Arc::new(compile(&sources, PROFILE).unwrap_or_else(|found| panic!("{found:#?}")));
        let mut config = Config::new(PROFILE);
        config.reference = reference();
        let tasks = config.tasks.iter().map(|task| (task.name.clone(), Vec::new())).collect();
        let bundle = Bundle { sources, tasks }.to_bytes();
        let mut model = Model::new(config, program, Box::new(MemoryStore::default())).unwrap();
        model.commission(&bundle, State::Running).unwrap();
        Small { case, plan, board_file, model, bundle }
    }

    /// Runs the case with these parts; the model may be inside the subject.
    pub fn run(
        &self,
        clock: &mut dyn Clock,
        subject: &mut dyn Subject,
        board: &mut dyn Board,
        late: Span,
    ) -> (Ran, Trace) {
        let mut bench = Bench {
            subject: &mut *subject,
            board: &*board,
            file: &self.board_file,
            profile: PROFILE,
            reference: reference(),
            bundle: &self.bundle,
            exact: clock.is_exact(),
        };
        let Prepared { trace, mut wiring, steps, probes, .. } =
            prepare(&self.case, &self.plan, Trace::new(), &mut bench)
                .unwrap_or_else(|found| panic!("{found:#?}"));
        let judge = Judge::new(self.case.scenario(), trace.signals()).unwrap().unhurried();
        let mut recorder = Recorder::new(trace, judge);
        for (probe, signal) in &probes {
            let value: Value = subject.read(probe);
            recorder.record(*signal, When::exactly(Time::ZERO), value, Cause::Controller);
        }
        let mut schedule = Schedule::new(steps, self.case.ends.clone(), 1);
        let limits = Limits {
            initial: State::Running,
            late,
            slice: Span::MAX,
            fail_fast: false,
            timeout: self.case.timeout,
        };
        let interrupt = AtomicBool::new(false);
        let parts = Parts {
            clock,
            subject,
            board,
            recorder: &mut recorder,
            schedule: &mut schedule,
            wiring: &mut wiring,
            interrupt: &interrupt,
        };
        let ran = Executor::new(parts, limits).run();
        (ran, recorder.into_parts().0)
    }

    /// A model that has nothing to do, in exchange for the model.
    pub fn take_model(&mut self) -> Model {
        let program = Arc::new(
            compile(&[SourceFile::new("idle.st", "PROGRAM MAIN END_PROGRAM".to_owned())], PROFILE).unwrap(),
        );
        let idle = Model::new(Config::new(PROFILE), program, Box::new(MemoryStore::default())).unwrap();
        std::mem::replace(&mut self.model, idle)
    }

    pub fn channel(&self, name: &str) -> ChannelId {
        self.board_file.find(name).unwrap()
    }
}

/// Every event of a trace, in its order.
pub fn events(trace: &Trace) -> Vec<signal::Event> {
    trace.events().map(|event| event.unwrap()).collect()
}

/// What an output terminal shows inside the subject.
pub const fn terminal(output: usize) -> Probe {
    Probe::Terminal(output)
}
