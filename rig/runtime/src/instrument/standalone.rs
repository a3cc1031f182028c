//! A program alone: no controller, no board, only its tasks at their intervals. For trying a block.

use crate::application::blocks;
use controller::{Memory, Rtc};
use expert::{ExpertConfig, ExpertFunctions};
use profile::{ExchangeCode, NO_FIRMWARE_VERSION, Profile};
use program::{
    Coverage, Host, Machine, MachineError, Pins, Program, ProgramFault, Service, SetError, ShownVariable,
    StopReason,
};
use signal::{Address, Cause, Span, Time};
use std::sync::Arc;

/// A task of a program alone.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StandaloneTask {
    /// Its name.
    pub name: String,
    /// From one release to the next, above 0.
    pub interval: Span,
    /// Places in [`Program::programs`].
    pub programs: Vec<usize>,
}

/// The tasks of a program alone, of the highest priority first: those that the sources configure, and a last one for
/// the PROGRAMs that none of those runs. `interval` is that of a task that has none of its own.
pub fn tasks(program: &Program, interval: Span) -> Vec<StandaloneTask> {
    let mut known: Vec<_> = program.tasks().iter().filter(|task| !task.programs.is_empty()).collect();
    let lowest = u32::from(profile::DEFAULT_PRIORITY);
    known.sort_by_key(|task| task.priority.unwrap_or(lowest));
    let mut tasks: Vec<StandaloneTask> = known
        .into_iter()
        .map(|task| StandaloneTask {
            name: task.name.clone(),
            interval: task.interval.filter(|interval| *interval > Span::ZERO).unwrap_or(interval),
            programs: task.programs.clone(),
        })
        .collect();
    let taken = |place: &usize| tasks.iter().any(|task| task.programs.contains(place));
    let rest: Vec<usize> = (0..program.programs().len()).filter(|place| !taken(place)).collect();
    if !rest.is_empty() {
        tasks.push(StandaloneTask { name: String::from("MAST"), interval, programs: rest });
    }
    tasks
}

/// What a task is doing.
#[derive(Clone, Debug)]
struct TaskProgress {
    task: StandaloneTask,
    /// The next release.
    release: Time,
    /// When the cycle began that is under way.
    began: Option<Time>,
    /// The cycle under way goes on from then.
    sleeps: Time,
    /// It is the first one.
    first: bool,
}

impl TaskProgress {
    /// When it wants to run.
    fn due(&self) -> Time {
        if self.began.is_some() { self.sleeps } else { self.release }
    }
}

/// A program with memory of its own.
#[derive(Debug)]
pub struct StandaloneRun {
    machine: Machine,
    memory: Memory,
    program: Arc<Program>,
    turns: Vec<TaskProgress>,
    now: Time,
    rtc: Rtc,
    profile: Profile,
    /// No functions: their blocks show an error.
    functions: ExpertFunctions,
}

/// How a run alone ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StandaloneEnd {
    /// All cycles ran.
    InTime {
        /// How many.
        cycles: u64,
    },
    /// The program failed.
    Fault {
        /// When.
        at: Span,
        /// What and where.
        text: String,
    },
    /// A cycle did not end before the run did.
    Endless {
        /// The task.
        task: String,
        /// When it began.
        at: Span,
    },
}

struct Plain<'a>(&'a mut Memory, &'a mut ExpertFunctions);

impl Host for Plain<'_> {
    fn load(&mut self, at: Address) -> u64 {
        self.0.load(at)
    }

    fn store(&mut self, at: Address, value: u64, file: u16, line: u32) -> bool {
        self.0.set_cause(Cause::Program { task: 0, file, line });
        self.0.store(at, value);
        false
    }

    fn block(&mut self, block: u16, pins: &mut Pins<'_>) -> bool {
        blocks::call(block, pins, self.1)
    }
}

impl StandaloneRun {
    /// A program with these tasks, the highest priority first, at the instant 0.
    ///
    /// # Errors
    /// [`MachineError`] where the variables and the stacks of the tasks find no room.
    pub fn new(
        program: Arc<Program>,
        tasks: Vec<StandaloneTask>,
        profile: Profile,
    ) -> Result<StandaloneRun, MachineError> {
        let places: Vec<Vec<usize>> = tasks.iter().map(|task| task.programs.clone()).collect();
        let machine = Machine::new(Arc::clone(&program), &places)?;
        let mut memory = Memory::new(profile);
        for located in program.located() {
            if let Some(initial) = located.initial {
                memory.store(located.address, initial);
            }
        }
        let turns = tasks
            .into_iter()
            .map(|task| TaskProgress {
                task,
                release: Time::ZERO,
                began: None,
                sleeps: Time::MIN,
                first: true,
            })
            .collect();
        Ok(StandaloneRun {
            machine,
            memory,
            program,
            turns,
            now: Time::ZERO,
            rtc: Rtc::default(),
            profile,
            functions: ExpertFunctions::new(&ExpertConfig::default(), &[]),
        })
    }

    /// From now on notes what runs.
    pub fn cover(&mut self) {
        self.machine.set_coverage(true);
    }

    /// What ran since [`StandaloneRun::cover`].
    pub fn coverage(&self) -> Coverage {
        self.machine.coverage()
    }

    /// The variable at a path, of any type.
    pub fn show(&mut self, path: &str) -> Option<ShownVariable> {
        self.machine.show(path, &mut Plain(&mut self.memory, &mut self.functions))
    }

    /// Sets the variable at a path to what a literal says.
    ///
    /// # Errors
    /// [`SetError`] where there is no such variable, or the text is no value of it.
    pub fn set(&mut self, path: &str, text: &str) -> Result<(), SetError> {
        self.machine.set(path, text, &mut Plain(&mut self.memory, &mut self.functions))
    }

    /// Runs the tasks for `duration`. A task of higher priority goes first, between two operations of others. A cycle
    /// that outlasts its interval is followed at once by the next; further releases that it missed are lost.
    pub fn run(&mut self, duration: Span) -> StandaloneEnd {
        let end = self.now.saturating_add(duration);
        let mut cycles = 0;
        while self.now < end {
            let ready = |turn: &TaskProgress| turn.due() <= self.now;
            let Some(task) = self.turns.iter().position(ready) else {
                let Some(next) = self.turns.iter().map(TaskProgress::due).min() else { break };
                self.now = next.min(end);
                continue;
            };
            // What is before it in the list goes before it.
            let higher = self.turns.iter().take(task).map(TaskProgress::due).min().unwrap_or(end).min(end);
            match self.slice(task, higher, end) {
                Ok(true) => cycles += 1,
                Ok(false) => {}
                Err(fault) => return self.failed(fault),
            }
        }
        self.now = self.now.max(end);
        match self
            .turns
            .iter()
            .filter(|turn| turn.due() <= self.now)
            .find_map(|turn| Some((turn, turn.began?)))
        {
            Some((turn, began)) => {
                StandaloneEnd::Endless { task: turn.task.name.clone(), at: began - Time::ZERO }
            }
            None => StandaloneEnd::InTime { cycles },
        }
    }

    /// Lets a task run until its cycle ends (TRUE), or `until` and then to the end of the operation that is under way.
    fn slice(&mut self, task: usize, until: Time, end: Time) -> Result<bool, ProgramFault> {
        let Some(turn) = self.turns.get_mut(task) else { return Ok(false) };
        if turn.began.is_none() {
            turn.began = Some(self.now);
            self.machine.begin(task);
        }
        let mut budget = until - self.now;
        loop {
            let slice = self.machine.resume(
                task,
                self.now,
                budget,
                &mut Plain(&mut self.memory, &mut self.functions),
            );
            self.now += slice.used;
            match slice.stop {
                StopReason::Done => break,
                StopReason::Fault(fault) => return Err(fault),
                StopReason::Service { service, argument } => {
                    let slept = self.serve(task, service, argument);
                    if let (Some(turn), true) = (self.turns.get_mut(task), slept > Span::ZERO) {
                        turn.sleeps = self.now.saturating_add(slept);
                        return Ok(false);
                    }
                    budget = (until - self.now).max(Span::ZERO);
                }
                StopReason::Touched { .. } | StopReason::Break => budget = (until - self.now).max(Span::ZERO),
                StopReason::Budget { .. } if self.now >= until => return Ok(false),
                // The operation that is under way at `until` comes to its end, if it does so before the run does.
                StopReason::Budget { next } if until < end && self.now.saturating_add(next) <= end => {
                    budget = next
                }
                StopReason::Budget { .. } => {
                    self.now = end;
                    return Ok(false);
                }
            }
        }
        let Some(turn) = self.turns.get_mut(task) else { return Ok(false) };
        turn.began = None;
        turn.first = false;
        // On the grid; of the releases that were missed the last one counts.
        let interval = turn.task.interval.as_nanos().max(1);
        let missed = (self.now - turn.release).as_nanos() / interval;
        turn.release += Span::from_nanos(interval.saturating_mul(missed.max(1)));
        Ok(true)
    }

    /// Runs one cycle of every task, one after another and each to its end, and gives their modelled time together.
    /// What takes longer than `most` does not end.
    ///
    /// # Errors
    /// [`StandaloneEnd`] for a cycle that fails or does not end.
    pub fn scan(&mut self, most: Span) -> Result<Span, StandaloneEnd> {
        let began = self.now;
        for task in 0..self.turns.len() {
            self.machine.begin(task);
            loop {
                let left = began.saturating_add(most) - self.now;
                let slice = self.machine.resume(
                    task,
                    self.now,
                    left,
                    &mut Plain(&mut self.memory, &mut self.functions),
                );
                self.now += slice.used;
                match slice.stop {
                    StopReason::Done => break,
                    StopReason::Service { service, argument } => {
                        let slept = self.serve(task, service, argument);
                        self.now += slept;
                    }
                    StopReason::Touched { .. } | StopReason::Break => {}
                    StopReason::Fault(fault) => return Err(self.failed(fault)),
                    StopReason::Budget { .. } => {
                        let name = self.turns.get(task).map_or("?", |turn| turn.task.name.as_str());
                        return Err(StandaloneEnd::Endless { task: name.to_owned(), at: began - Time::ZERO });
                    }
                }
            }
        }
        for turn in &mut self.turns {
            turn.first = false;
        }
        Ok(self.now - began)
    }

    /// Answers what a task asks of a controller: the first cycle of each task is the first one after a cold start,
    /// nothing is forced, and there is a clock. How long the task sleeps.
    fn serve(&mut self, task: usize, service: Service, argument: i64) -> Span {
        let mut slept = Span::ZERO;
        let Some(turn) = self.turns.get_mut(task) else { return slept };
        let answer = match service {
            Service::WaitSleep => {
                slept = Span::from_millis(argument);
                0
            }
            Service::GetTaskCycle => turn.task.interval.as_nanos() / 1_000,
            Service::SetTaskCycle => {
                let interval = Span::from_micros(argument);
                let possible = interval >= profile::MINIMUM_CYCLE;
                if possible {
                    turn.task.interval = interval;
                }
                i64::from(!possible)
            }
            Service::FirstMastCycle | Service::FirstMastColdCycle => i64::from(turn.first),
            Service::FirstMastWarmCycle | Service::HasForcedIo | Service::InhibitBatteryLed => 0,
            // TM3_ERR_PARAMETER: there is no module.
            Service::ModuleInternalStatus => 2,
            Service::ModuleBusStatus => i64::from(ExchangeCode::Parameter.code()),
            Service::ModuleFirmware => i64::from(NO_FIRMWARE_VERSION),
            Service::GetRtc => self.rtc.seconds(self.now),
            Service::SetRtcDrift => self.rtc.set_drift(argument, self.profile, self.now),
        };
        self.machine.answer(task, answer);
        slept
    }

    fn failed(&self, fault: ProgramFault) -> StandaloneEnd {
        let file = self.program.files().get(usize::from(fault.file)).map_or("?", String::as_str);
        StandaloneEnd::Fault {
            at: self.now - Time::ZERO,
            text: format!("{} at {file}:{}", fault.kind, fault.line),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::application::compile;
    use document::SourceFile;

    fn alone(text: &str) -> StandaloneRun {
        let program = Arc::new(compile(&[SourceFile::new("x.st", text)], Profile::default()).unwrap());
        let tasks = tasks(&program, Span::from_millis(20));
        StandaloneRun::new(program, tasks, Profile::default()).unwrap()
    }

    fn shown(alone: &mut StandaloneRun, path: &str) -> String {
        alone.show(path).unwrap().to_string()
    }

    /// The slow task takes 12.3 ms; the quick one notes how far it has come.
    const TWO: &str = "\
        VAR_GLOBAL far : DINT; END_VAR
        PROGRAM quick VAR n, seen : DINT; END_VAR n := n + 1; IF far > 0 THEN seen := far; END_IF; END_PROGRAM
        PROGRAM slow VAR n, i : DINT; END_VAR
        n := n + 1; FOR i := 1 TO 50000 DO far := i; END_FOR; far := 0; END_PROGRAM
        CONFIGURATION x
        TASK late (INTERVAL := T#20ms, PRIORITY := 9); TASK early (INTERVAL := T#5ms, PRIORITY := 1);
        PROGRAM p WITH late : slow; PROGRAM q WITH early : quick;
        END_CONFIGURATION";

    #[test]
    fn a_task_of_higher_priority_cuts_in() {
        let mut alone = alone(TWO);
        assert_eq!(alone.run(Span::from_millis(19)), StandaloneEnd::InTime { cycles: 5 });
        assert_eq!((shown(&mut alone, "quick.n"), shown(&mut alone, "slow.n")), ("4".into(), "1".into()));
        // At 10 ms the loop was under way: a turn takes 195 ns and 49 ns, whatever cut in before.
        let seen: i64 = shown(&mut alone, "quick.seen").parse().unwrap();
        assert!((40_000..41_000).contains(&seen), "{seen}");
        // The run goes on where it stood.
        assert_eq!(alone.run(Span::from_millis(21)), StandaloneEnd::InTime { cycles: 5 });
    }

    #[test]
    fn a_run_may_end_in_the_middle_of_a_cycle() {
        let ended = alone(TWO).run(Span::from_millis(30));
        assert_eq!(ended, StandaloneEnd::Endless { task: "late".into(), at: Span::from_nanos(20_000_175) });
    }

    #[test]
    fn missed_releases_are_lost_but_one() {
        // 24.4 ms at an interval of 20 ms: one after the other, and the grid is kept.
        let mut alone = alone(
            "PROGRAM m VAR n, i, far : DINT; END_VAR n := n + 1; FOR i := 1 TO 100000 DO far := i; END_FOR; END_PROGRAM",
        );
        let _ = alone.run(Span::from_millis(245));
        assert_eq!(shown(&mut alone, "m.n"), "11");
    }

    #[test]
    fn scans_follow_each_other() {
        let mut alone = alone("PROGRAM m VAR n : DINT; END_VAR n := n + 1; END_PROGRAM");
        assert_eq!(alone.scan(Span::from_secs(1)), Ok(Span::from_nanos(90)));
        let ended = alone.scan(Span::from_nanos(50));
        assert_eq!(ended, Err(StandaloneEnd::Endless { task: "MAST".into(), at: Span::from_nanos(90) }));
    }
}
