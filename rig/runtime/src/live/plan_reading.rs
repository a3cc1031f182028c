//! Files of plans that are read for clients of a running rig: each by a thread of its own, and within a limit. A disk that
//! does not answer delays those who asked for what is on it, and nobody else.

use super::fault;
use super::plans::{ChosenCases, PlanBench};
use control::RequestFault;
use host::{BackgroundTask, TaskProgress};
use std::io;
use std::sync::Arc;
use std::time::Duration;

/// How long the files of a request may take: a client waits for its answer for 10 s.
const LIMIT: Duration = Duration::from_secs(8);

/// The most threads that read at once, with those that were given up and still hang.
const MOST_THREADS: usize = 4;

/// What is read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PlanRequest {
    /// The cases of a file or folder, or the names of the plans that ship.
    List(Option<String>),
    /// The case of this name, or all cases of the plan.
    Choose(String),
}

/// What was read.
#[derive(Debug)]
pub enum PlansRead {
    /// Names of cases or plans.
    Listed(Vec<String>),
    /// Cases that can be run.
    Chosen(Box<ChosenCases>),
}

/// A result, or why there is none.
pub type PlanAnswer = Result<PlansRead, RequestFault>;

/// The requests whose files are being read.
#[derive(Debug, Default)]
pub struct PlanReadings {
    open: Vec<Reading>,
    /// Held by each thread as long as it runs.
    running: Arc<()>,
}

#[derive(Debug)]
struct Reading {
    ticket: u64,
    /// What is said if it takes too long.
    what: String,
    chooses: bool,
    task: BackgroundTask<PlanAnswer>,
}

impl PlanReadings {
    /// Begins to read for an order.
    ///
    /// # Errors
    /// More is read already, or the machine has no room for a thread.
    pub fn begin(
        &mut self,
        ticket: u64,
        bench: &Arc<PlanBench>,
        request: PlanRequest,
    ) -> Result<(), RequestFault> {
        if Arc::strong_count(&self.running) > MOST_THREADS {
            return Err(fault::plans_are_read(MOST_THREADS));
        }
        let (chooses, what) = match &request {
            PlanRequest::List(path) => (false, path.clone().unwrap_or_default()),
            PlanRequest::Choose(name) => (true, name.clone()),
        };
        let (bench, running) = (bench.clone(), self.running.clone());
        let task = BackgroundTask::start("plan", LIMIT, move |abandoned| {
            let _running = running;
            match request {
                PlanRequest::List(path) => {
                    bench.list(path.as_deref(), &|| !abandoned.is_set()).map(PlansRead::Listed)
                }
                PlanRequest::Choose(name) => {
                    bench.choose(&name).map(|chosen| PlansRead::Chosen(Box::new(chosen)))
                }
            }
        });
        let task = task.map_err(|error: io::Error| fault::plan(&error.to_string()))?;
        self.open.push(Reading { ticket, what, chooses, task });
        Ok(())
    }

    /// Whether cases are being chosen.
    pub fn is_choosing(&self) -> bool {
        self.open.iter().any(|reading| reading.chooses)
    }

    /// The orders that have come to an end, in the order in which they were given.
    pub fn ended(&mut self) -> Vec<(u64, PlanAnswer)> {
        let mut ended = Vec::new();
        self.open.retain(|reading| {
            let answer = match reading.task.progress() {
                TaskProgress::Running => return true,
                TaskProgress::Done(answer) => answer,
                TaskProgress::GivenUp => Err(fault::not_read(&reading.what, LIMIT.as_secs())),
            };
            ended.push((reading.ticket, answer));
            false
        });
        ended
    }
}
