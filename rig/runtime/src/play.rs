//! The model kept running on a board: a controller that the rig plays, for a machine or for another rig.
//!
//! It has the lines of a controller beside its terminals: a supply, a Run/Stop switch, and a line that is 1 in RUNNING.

use crate::capability::Capability;
use crate::case::{CaseFiles, RunOptions, clock};
use crate::configure::initial_state;
use crate::executor::{Executor, Limits, Parts, Ran};
use crate::hardware::Hardware;
use crate::hook::HookError;
use crate::prepare::Prepared;
use crate::recorder::Recorder;
use crate::schedule::{FileAct, Schedule};
use crate::spill;
use crate::stage::{Stage, stage};
use crate::subject::{Observable, Subject};
use crate::trouble::Trouble;
use controller::{
    Command, Disturbance, Effect, Effects, Entry, FileError, FileFact, Probe, ProbeId, Refusal, State,
    TaskFigures, WriteError,
};
use document::Diagnostic;
use drivers::{RealtimeSettings, SubjectLines};
use plans::Case;
use plans::judge::Judge;
use plans::lang::{Anchor, Base};
use signal::{Cause, Level, Span, Time, Trace, Value, When};
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::SyncSender;

/// Longer than any rig is kept running: 100 years.
const AGES: Span = Span::from_secs(100 * 365 * 86_400);

/// The longest that a boot takes, in modelled time.
const LONGEST_BOOT: Span = Span::from_secs(60);

/// How long a controller is kept running, and from where.
#[derive(Clone, Copy, Debug, Default)]
pub struct Course {
    /// How long; until it is interrupted if nothing is said.
    pub lasts: Option<Span>,
    /// Its first boot takes no time.
    pub booted: bool,
}

/// What a controller that runs tells whoever watches it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Told {
    /// The outputs are claimed, and the controller waits for its supply or boots.
    Ready,
    /// It has another state.
    State(Time, State),
    /// A line of its log.
    Log(Time, String),
}

/// How a controller that was kept running did.
#[derive(Debug)]
pub struct Played {
    /// What the executor says.
    pub ran: Ran,
    /// How late the rig was at worst.
    pub late: Span,
    /// What its tasks did: name, interval, figures.
    pub tasks: Vec<(String, Span, TaskFigures)>,
    /// Trouble of the rig, in words.
    pub trouble: Option<String>,
}

/// Keeps the controller of a case running, with the case's program and settings and nothing else of it, until it is
/// interrupted or its time is over. What it has to tell goes to `tell`, which never keeps it waiting: what finds no room is
/// left out.
///
/// # Errors
/// Findings in the user's files.
pub fn play(
    case: &Case,
    files: &CaseFiles,
    options: &RunOptions<'_>,
    course: Course,
    tell: SyncSender<Told>,
) -> Result<Played, Vec<Diagnostic>> {
    let case = bare(case, course.lasts);
    let mut stage = stage(&case, files, None)?;
    let hardware = options.hardware.filter(|hardware| hardware.name() == files.board.name);
    if let Some(hardware) = hardware {
        stage.board = Box::new(hardware.lend());
    }
    let mut clock = clock(options.clock, files.seed, hardware);
    let trace = Trace::with_spill(options.trace_memory, spill::temporary());
    let Prepared { trace, mut wiring, .. } = stage.prepare(&case, files, trace, clock.is_exact())?;
    let Stage { subject, mut board, .. } = stage;
    let lines = files.board.lines;
    let places = Places { inputs: files.reference.input_count(), outputs: files.reference.output_count() };
    for (channel, input) in [(lines.power, places.power()), (lines.run_stop, places.run_stop())] {
        if let Some(inputs) = channel.and_then(|channel| wiring.inputs.get_mut(usize::from(channel.0))) {
            inputs.push(input);
        }
    }
    wiring.outputs.push(lines.alarm);
    let mut subject = Kept::new(subject, lines, places, initial_state(case.settings.initial), tell);
    subject.quick = course.booted;
    let judge = Judge::new(case.scenario(), trace.signals())?;
    let mut recorder = Recorder::new(trace, judge);
    let mut schedule = Schedule::new(Vec::new(), case.ends.clone());
    let limits = Limits {
        initial: State::Off,
        // Nobody judges it: how late it was is told at the end.
        late: Span::MAX,
        slice: options.slice,
        horizon: hardware.map_or_else(RealtimeSettings::default, |hardware| *hardware.settings()).horizon,
        fail_fast: false,
        on_loss: files.board.on_loss,
        retake: files.board.retakes(),
        timeout: case.timeout,
        teardown: case.teardown,
    };
    let parts = Parts {
        clock: &mut *clock,
        subject: &mut subject,
        board: &mut *board,
        recorder: &mut recorder,
        schedule: &mut schedule,
        wiring: &mut wiring,
        alarms: &mut Vec::new(),
        interrupt: options.interrupt,
        operator: None,
        heart: hardware.and_then(Hardware::heart),
    };
    let entered = hardware.map(Hardware::enter);
    let ran = Executor::new(parts, limits).run();
    drop(entered);
    let trouble = ran.trouble.as_ref().filter(|trouble| **trouble != Trouble::Interrupted);
    let trouble = trouble.map(|trouble| trouble.show(board.channels()).to_string());
    Ok(Played { late: recorder.late(), tasks: subject.figures(), trouble, ran })
}

/// A case without all that is done and claimed in it.
fn bare(case: &Case, lasts: Option<Span>) -> Case {
    let mut case = case.clone();
    case.signals.clear();
    case.unspoken.clear();
    case.steps.clear();
    case.expectations.clear();
    case.measurements.clear();
    case.invariants.clear();
    case.alarms.clear();
    case.ends = Anchor { base: Base::Start, offset: lasts.unwrap_or(AGES) };
    case.timeout = Span::MAX;
    case
}

/// Where its lines stand, behind its terminals.
#[derive(Clone, Copy, Debug)]
struct Places {
    inputs: usize,
    outputs: usize,
}

impl Places {
    const fn power(self) -> usize {
        self.inputs
    }

    const fn run_stop(self) -> usize {
        self.inputs + 1
    }

    const fn alarm(self) -> usize {
        self.outputs
    }
}

/// The model with the lines that it has beside its terminals.
struct Kept {
    model: Box<dyn Subject>,
    lines: SubjectLines,
    places: Places,
    /// The state that it is to come into first.
    initial: Option<State>,
    /// It gets its supply as soon as its time begins: it has no line for it, or the line was on before.
    waits: bool,
    begun: bool,
    /// Its next boot takes no time.
    quick: bool,
    /// What came of a boot before its time began.
    booted: Vec<Effect>,
    /// By how much its own time is ahead, behind a boot that took none.
    ahead: Span,
    supply: bool,
    alarm: bool,
    tell: SyncSender<Told>,
}

impl std::fmt::Debug for Kept {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Kept").field("lines", &self.lines).finish_non_exhaustive()
    }
}

impl Kept {
    fn new(
        model: Box<dyn Subject>,
        lines: SubjectLines,
        places: Places,
        initial: State,
        tell: SyncSender<Told>,
    ) -> Kept {
        let (initial, waits) = (Some(initial), lines.power.is_none());
        Kept {
            model,
            lines,
            places,
            initial,
            waits,
            begun: false,
            quick: false,
            booted: Vec::new(),
            ahead: Span::ZERO,
            supply: false,
            alarm: false,
            tell,
        }
    }

    fn say(&self, told: Told) {
        // Whoever watches may be slow, or gone.
        let _ = self.tell.try_send(told);
    }

    fn switch(&mut self, now: Time, on: bool, effects: &mut Effects) {
        if self.supply != on {
            self.supply = on;
            let before = effects.list.len();
            self.model.power(self.own(now), on, effects);
            if std::mem::take(&mut self.quick) {
                self.boot(now, before, effects);
            }
            self.follow(now, before, effects);
        }
    }

    /// An instant in the model's own time.
    fn own(&self, at: Time) -> Time {
        at.saturating_add(self.ahead)
    }

    /// Lets the model boot at once: its time runs ahead by what that takes.
    fn boot(&mut self, now: Time, before: usize, effects: &mut Effects) {
        let limit = now.saturating_add(LONGEST_BOOT);
        while self.model.state() == State::Booting {
            let Some(next) = self.model.next_timer().filter(|next| *next <= limit) else { break };
            self.model.run(next, effects);
            self.model.fire(next, effects);
            self.ahead = self.ahead.max(next - now);
        }
        // All of it happens now.
        for effect in effects.list.iter_mut().skip(before) {
            *instant(effect) = self.own(now);
        }
    }

    /// Tells what the effects behind the first `before` say, and lets the alarm line follow.
    fn follow(&mut self, now: Time, before: usize, effects: &mut Effects) {
        let mut place = before;
        while let Some(effect) = effects.list.get_mut(place) {
            place += 1;
            let at = instant(effect);
            *at = at.saturating_add(-self.ahead);
            let effect = *effect;
            match effect {
                Effect::State { at, state } => {
                    self.say(Told::State(at, state));
                    let alarm = state == State::Running;
                    if self.alarm != alarm {
                        self.alarm = alarm;
                        let (output, level) = (self.places.alarm(), Level::from_bool(alarm));
                        let (at, cause) = (self.own(at), Cause::Controller);
                        effects.list.push(Effect::Terminal { at, output, level, cause });
                    }
                    self.settle(now.max(at), state, effects);
                }
                // Changes of the state are told already.
                Effect::Log { entry: Entry::State { .. }, .. } => {}
                Effect::Log { at, entry } => self.say(Told::Log(at, crate::log::show(&entry, &*self.model))),
                _ => {}
            }
        }
    }

    /// Where its first boot ends in another state than the case begins in, it is commanded there.
    fn settle(&mut self, now: Time, state: State, effects: &mut Effects) {
        if !matches!(state, State::Stopped | State::Running | State::Empty) {
            return;
        }
        let command = match self.initial.take() {
            Some(State::Running) if state == State::Stopped => Command::Run,
            Some(State::Stopped) if state == State::Running => Command::Stop,
            _ => return,
        };
        if let Err(refusal) = self.model.command(self.own(now), &command, effects) {
            self.say(Told::Log(now, refusal.to_string()));
        }
    }
}

/// The instant of an effect.
fn instant(effect: &mut Effect) -> &mut Time {
    match effect {
        Effect::Terminal { at, .. }
        | Effect::State { at, .. }
        | Effect::Changed { at, .. }
        | Effect::Log { at, .. } => at,
    }
}

impl Subject for Kept {
    fn capabilities(&self) -> &'static [Capability] {
        self.model.capabilities()
    }

    fn power(&mut self, now: Time, on: bool, effects: &mut Effects) {
        self.switch(now, on, effects);
    }

    fn load(&mut self, _interrupt: &AtomicBool) -> Result<(), HookError> {
        // Its program is loaded now where it can be: that takes the host's time, and none of its own.
        if self.quick && std::mem::take(&mut self.waits) {
            self.quick = false;
            self.supply = true;
            let mut effects = Effects::new();
            self.model.power(Time::ZERO, true, &mut effects);
            self.boot(Time::ZERO, 0, &mut effects);
            self.booted = effects.list;
        }
        self.say(Told::Ready);
        Ok(())
    }

    fn notice(&mut self, at: Time, text: &str) {
        self.say(Told::Log(at, text.to_owned()));
    }

    fn loaded(&mut self, now: Time, effects: &mut Effects) {
        if self.booted.is_empty() {
            return;
        }
        // Its time goes on where the boot ended.
        self.ahead = self.ahead + -(now - Time::ZERO);
        let before = effects.list.len();
        effects.list.append(&mut self.booted);
        for effect in effects.list.iter_mut().skip(before) {
            *instant(effect) = self.own(now);
        }
        self.follow(now, before, effects);
    }

    fn begin(&mut self) -> Option<(Time, Value)> {
        self.begun = true;
        None
    }

    fn run(&mut self, limit: Time, effects: &mut Effects) -> Time {
        let before = effects.list.len();
        let reached = self.model.run(self.own(limit), effects).saturating_add(-self.ahead);
        self.follow(reached, before, effects);
        reached
    }

    fn is_computing(&self) -> bool {
        self.model.is_computing()
    }

    fn is_played(&self) -> bool {
        true
    }

    fn next_timer(&self) -> Option<Time> {
        if self.waits {
            return Some(Time::ZERO);
        }
        Some(self.model.next_timer()?.saturating_add(-self.ahead))
    }

    fn fire(&mut self, now: Time, effects: &mut Effects) {
        if std::mem::take(&mut self.waits) {
            self.switch(now, true, effects);
            return;
        }
        let before = effects.list.len();
        self.model.fire(self.own(now), effects);
        self.follow(now, before, effects);
    }

    fn input(&mut self, now: Time, at: When, input: usize, level: Level, effects: &mut Effects) {
        let before = effects.list.len();
        if input == self.places.power() {
            match self.begun {
                true => self.switch(now, level.is_high(), effects),
                false => self.waits = level.is_high(),
            }
        } else if input == self.places.run_stop() {
            let moved = self.model.command(self.own(now), &Command::Switch(level.is_high()), effects);
            if let Err(refusal) = moved {
                self.say(Told::Log(now, refusal.to_string()));
            }
            self.follow(now, before, effects);
        } else {
            self.model.input(self.own(now), at, input, level, effects);
        }
    }

    fn command(&mut self, now: Time, command: &Command, effects: &mut Effects) -> Result<(), Refusal> {
        self.model.command(now, command, effects)
    }

    fn file(&mut self, now: Time, act: &FileAct, effects: &mut Effects) -> Result<(), FileError> {
        self.model.file(now, act, effects)
    }

    fn file_probe(&mut self, fact: FileFact) -> Probe {
        self.model.file_probe(fact)
    }

    fn disturb(&mut self, now: Time, disturbance: Disturbance, effects: &mut Effects) {
        self.model.disturb(now, disturbance, effects);
    }

    fn overload(&mut self, task: usize, cycle: Span, times: u32) {
        self.model.overload(task, cycle, times);
    }

    fn suspend(&mut self, task: usize, until: Time) {
        self.model.suspend(task, until);
    }

    fn task(&self, name: &str) -> Option<usize> {
        self.model.task(name)
    }

    fn task_name(&self, task: usize) -> Option<&str> {
        self.model.task_name(task)
    }

    fn file_name(&self, file: u16) -> Option<&str> {
        self.model.file_name(file)
    }

    fn source_files(&self) -> Vec<(u16, String)> {
        self.model.source_files()
    }

    fn names(&self) -> Vec<String> {
        self.model.names()
    }

    fn observable(&self, name: &str) -> Option<Observable> {
        self.model.observable(name)
    }

    fn watch(&mut self, probe: Probe) -> ProbeId {
        self.model.watch(probe)
    }

    fn read(&self, probe: &Probe) -> Value {
        match *probe {
            Probe::Terminal(output) if output == self.places.alarm() => Value::Bool(self.alarm),
            ref probe => self.model.read(probe),
        }
    }

    fn write(
        &mut self,
        now: Time,
        probe: &Probe,
        value: Value,
        cause: Cause,
        effects: &mut Effects,
    ) -> Result<(), WriteError> {
        self.model.write(now, probe, value, cause, effects)
    }

    fn state(&self) -> State {
        // Whatever comes of its supply comes when its time has begun.
        if self.begun { self.model.state() } else { State::Off }
    }

    fn figures(&self) -> Vec<(String, Span, TaskFigures)> {
        self.model.figures()
    }
}
