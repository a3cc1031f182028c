//! An application of explicit operations, a store in memory, and a clock that drives a controller.

use profile::SystemVariable;
use scanrig_controller::*;
use signal::{Address, Cause, Level, Span, Time, Value};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

/// What an operation does when it completes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Act {
    Nop,
    Store(Address, u64),
    /// Copies a place into another.
    Copy(Address, Address),
    /// Adds to a variable.
    Add(usize, i64),
    /// Copies a variable into another.
    Move(usize, usize),
    Fault(FaultClass),
    /// Calls a block of the expert functions with these pins; all others are 0.
    Block(&'static str, &'static [(usize, i64)]),
    /// Goes back to the first operation of the task.
    Loop,
}

/// An operation: its cost in nanoseconds and what it does.
pub type Op = (i64, Act);

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Keep {
    Plain,
    Retain,
    Persistent,
}

/// An application of explicit operations. Its bundle is its name's bytes.
#[derive(Clone, Debug)]
pub struct Script {
    pub tasks: Vec<Vec<Op>>,
    pub variables: Vec<(i64, Keep)>,
    pub located: Vec<(Address, u64)>,
    pub signature: u64,
}

impl Script {
    pub fn new(tasks: Vec<Vec<Op>>) -> Script {
        Script { tasks, variables: Vec::new(), located: Vec::new(), signature: 1 }
    }
}

/// What the application did: task, instant, start or end of a cycle.
pub type Trail = Arc<Mutex<Vec<(usize, Time, &'static str)>>>;

struct Player {
    script: Script,
    values: Vec<i64>,
    at: Vec<usize>,
    fresh: Vec<bool>,
    watched: Vec<bool>,
    dirty: bool,
    breaks: Vec<u32>,
    steps: Vec<bool>,
    /// It stopped before this operation already.
    stood: Vec<bool>,
    trail: Trail,
}

impl Application for Player {
    fn tasks(&self) -> usize {
        self.script.tasks.len()
    }
    fn begin(&mut self, task: usize) {
        self.at[task] = 0;
        self.fresh[task] = true;
    }
    fn resume(
        &mut self,
        task: usize,
        now: Time,
        budget: Span,
        memory: &mut Memory,
        functions: &mut expert::ExpertFunctions,
    ) -> Slice {
        let mut used = Span::ZERO;
        if std::mem::take(&mut self.fresh[task]) {
            self.trail.lock().unwrap().push((task, now, "start"));
        }
        loop {
            let Some(&(cost, act)) = self.script.tasks[task].get(self.at[task]) else {
                self.trail.lock().unwrap().push((task, now + used, "end"));
                return Slice { used, end: SliceEnd::Done };
            };
            let line = self.at[task] as u32 + 1;
            if (self.breaks.contains(&line) || self.steps[task]) && !std::mem::take(&mut self.stood[task]) {
                (self.stood[task], self.steps[task]) = (true, false);
                return Slice { used, end: SliceEnd::Break };
            }
            let cost = Span::from_nanos(cost);
            if used + cost > budget {
                return Slice { used, end: SliceEnd::Budget { next: cost } };
            }
            used = used + cost;
            self.at[task] += 1;
            memory.set_cause(Cause::Program { task: task as u8, file: 0, line: self.at[task] as u32 });
            let mut touched = false;
            match act {
                Act::Nop => {}
                Act::Store(at, value) => touched = memory.store(at, value),
                Act::Copy(from, to) => touched = memory.store(to, memory.load(from)),
                Act::Add(variable, n) => touched = self.set(variable, self.values[variable] + n),
                Act::Move(from, to) => touched = self.set(to, self.values[from]),
                Act::Block(name, inputs) => touched = call_block(name, inputs, now + used, functions),
                Act::Loop => self.at[task] = 0,
                Act::Fault(class) => {
                    let error = profile::ApplicationError::IntegerDivision;
                    let fault = ApplicationFault { error, class, file: 0, line: self.at[task] as u32 };
                    return Slice { used, end: SliceEnd::Fault(fault) };
                }
            }
            if touched {
                return Slice { used, end: SliceEnd::Touched };
            }
        }
    }
    fn reset(&mut self, reset: VariableReset) {
        for (value, (initial, keep)) in self.values.iter_mut().zip(&self.script.variables) {
            let kept = match keep {
                Keep::Plain => false,
                Keep::Retain => reset.keep_retain,
                Keep::Persistent => reset.keep_persistent,
            };
            if !kept {
                *value = *initial;
            }
        }
    }
    fn initialize(&self, memory: &mut Memory) {
        for &(at, value) in &self.script.located {
            memory.set_cause(Cause::Program { task: 0, file: 0, line: 0 });
            memory.store(at, value);
        }
    }
    fn associates(&self, word: u32) -> bool {
        let word = Address::new(signal::Area::Memory, signal::Size::Word, word).unwrap();
        self.script.located.iter().any(|(at, _)| at.overlaps(&word))
    }
    fn writes_output(&self, task: usize, byte: u32) -> bool {
        let byte = Address::new(signal::Area::Output, signal::Size::Byte, byte).unwrap();
        self.script.tasks[task].iter().any(|(_, act)| match act {
            Act::Store(at, _) | Act::Copy(_, at) => at.overlaps(&byte),
            _ => false,
        })
    }
    fn writes_output_bit(&self, task: usize, bit: u32) -> bool {
        let bit = Address::bit(signal::Area::Output, bit);
        self.script.tasks[task].iter().any(|(_, act)| match act {
            Act::Store(at, _) | Act::Copy(_, at) => at.overlaps(&bit),
            _ => false,
        })
    }
    fn reads_input(&self, task: usize, bit: u32) -> bool {
        let bit = Address::new(signal::Area::Input, signal::Size::Bit, bit).unwrap();
        self.script.tasks[task].iter().any(|(_, act)| match act {
            Act::Copy(from, _) => from.overlaps(&bit),
            _ => false,
        })
    }
    /// `v3` is the fourth variable.
    fn variable(&self, path: &str) -> Option<u32> {
        let n: usize = path.strip_prefix('v')?.parse().ok()?;
        (n < self.values.len()).then_some(n as u32)
    }
    fn retained_len(&self) -> usize {
        self.script.variables.iter().filter(|(_, keep)| *keep != Keep::Plain).count() * 8
    }
    fn save_retained(&self, out: &mut [u8]) {
        let kept =
            self.values.iter().zip(&self.script.variables).filter(|(_, (_, keep))| *keep != Keep::Plain);
        for (place, (value, _)) in out.chunks_exact_mut(8).zip(kept) {
            place.copy_from_slice(&value.to_le_bytes());
        }
    }
    fn restore_retained(&mut self, image: &[u8]) -> bool {
        if image.len() != self.retained_len() {
            return false;
        }
        let kept =
            self.values.iter_mut().zip(&self.script.variables).filter(|(_, (_, keep))| *keep != Keep::Plain);
        for (place, (value, _)) in image.chunks_exact(8).zip(kept) {
            *value = i64::from_le_bytes(place.try_into().unwrap());
        }
        true
    }
    fn retained_map(&self) -> Vec<u8> {
        vec![self.script.variables.len() as u8]
    }
    /// Variables are known by their numbers here.
    fn adopt_retained(&mut self, map: &[u8], image: &[u8]) -> bool {
        let kept = self.values.iter_mut().zip(&self.script.variables);
        let kept = kept.filter(|(_, (_, keep))| *keep != Keep::Plain);
        for (place, (value, (_, keep))) in image.chunks_exact(8).zip(kept) {
            if *keep == Keep::Persistent {
                *value = i64::from_le_bytes(place.try_into().unwrap());
            }
        }
        map.first().is_some_and(|count| usize::from(*count) <= self.script.variables.len())
    }
    fn declarations(&self) -> u64 {
        self.script.variables.len() as u64
    }
    fn retained_dirty(&mut self) -> bool {
        std::mem::take(&mut self.dirty)
    }
    fn signature(&self) -> u64 {
        self.script.signature
    }
    fn locate(&self, path: &str) -> Option<VariableLocation> {
        self.variable(path).map(|number| VariableLocation::Variable(number, RegisterFormat::Whole(2)))
    }
    fn word_of(&self, _: u32, _: u32, _: u16) -> Option<u32> {
        None
    }
    fn read(&self, variable: u32) -> Value {
        self.values.get(variable as usize).map_or(Value::Unknown, |value| Value::Int(*value))
    }
    fn write(&mut self, variable: u32, value: Value) {
        if let Some(n) = value.as_int() {
            self.set(variable as usize, n as i64);
        }
    }
    fn watch(&mut self, variable: u32) {
        self.watched[variable as usize] = true;
    }
    fn unwatch(&mut self, variable: u32) {
        self.watched[variable as usize] = false;
    }
    /// No operation asks for a service.
    fn answer(&mut self, _: usize, _: i64) {}
    /// Operations are lines.
    fn breakpoint(&mut self, _: u16, line: u32) -> Option<u32> {
        self.breaks.push(line);
        Some(line)
    }
    fn clear_breakpoints(&mut self) {
        self.breaks.clear();
    }
    fn step(&mut self, task: usize) {
        self.steps[task] = true;
    }
    fn succeed(&mut self, old: &mut dyn Application) -> Option<bool> {
        let old: &mut Player = old.as_any().downcast_mut()?;
        self.values.clone_from(&old.values);
        Some(true)
    }
    fn as_any(&mut self) -> &mut dyn std::any::Any {
        self
    }
}

/// Pins of a block by place.
struct Values([i64; 32]);

impl expert::BlockPins for Values {
    fn get(&self, pin: usize) -> i64 {
        self.0[pin]
    }
    fn set(&mut self, pin: usize, value: i64) {
        self.0[pin] = value;
    }
}

/// A call of a new instance, as the application does it.
fn call_block(
    name: &str,
    inputs: &[(usize, i64)],
    now: Time,
    functions: &mut expert::ExpertFunctions,
) -> bool {
    let block = expert::BLOCKS.iter().copied().flatten().find(|block| block.name == name).unwrap();
    let mut pins = Values([0; 32]);
    inputs.iter().for_each(|(pin, value)| pins.0[*pin] = *value);
    let before = functions.next();
    (block.run)(&mut expert::BlockCall { now, pins: &mut pins, expert: functions });
    functions.is_observed() || functions.next() < before
}

impl Player {
    fn set(&mut self, variable: usize, value: i64) -> bool {
        let changed = self.values[variable] != value;
        self.values[variable] = value;
        self.dirty |= changed && self.script.variables[variable].1 != Keep::Plain;
        changed && self.watched[variable]
    }
}

/// Loads scripts by name.
pub struct Scripts(pub BTreeMap<Vec<u8>, Script>, pub Trail);

impl Loader for Scripts {
    fn load(&mut self, bundle: &[u8]) -> Result<Box<dyn Application>, LoadError> {
        let script = self.0.get(bundle).cloned().ok_or(LoadError::Bundle)?;
        let values = script.variables.iter().map(|(initial, _)| *initial).collect();
        let tasks = script.tasks.len();
        Ok(Box::new(Player {
            values,
            at: vec![0; tasks],
            fresh: vec![false; tasks],
            watched: vec![false; script.variables.len()],
            dirty: false,
            breaks: Vec::new(),
            steps: vec![false; tasks],
            stood: vec![false; tasks],
            trail: self.1.clone(),
            script,
        }))
    }
}

/// Storage in memory, shared by the controller and the test.
#[derive(Clone, Default)]
pub struct Files(Arc<Mutex<BTreeMap<String, Vec<u8>>>>);

impl NonVolatile for Files {
    fn read(&self, name: &str) -> Option<Vec<u8>> {
        self.0.lock().unwrap().get(name).cloned()
    }
    fn write(&mut self, name: &str, bytes: &[u8]) {
        self.0.lock().unwrap().insert(name.into(), bytes.to_vec());
    }
    fn remove(&mut self, name: &str) {
        self.0.lock().unwrap().remove(name);
    }
    fn list(&self, each: &mut dyn FnMut(&str, u64)) {
        self.0.lock().unwrap().iter().for_each(|(name, bytes)| each(name, bytes.len() as u64));
    }
    fn tear(&mut self, name: &str, bytes: &[u8], kept: usize) {
        let old = self.read(name).unwrap_or_default();
        let mut file = bytes[..kept].to_vec();
        file.extend_from_slice(old.get(kept..).unwrap_or_default());
        self.write(name, &file);
    }
}

/// A controller with its clock.
pub struct Rig {
    pub plc: Controller,
    /// The controller's storage.
    pub files: Files,
    pub now: Time,
    pub fx: Effects,
    /// Everything that happened.
    pub seen: Vec<Effect>,
    pub trail: Trail,
    /// Time is advanced in pieces of these lengths, over and over; whole where empty.
    pub slices: Vec<i64>,
    turn: usize,
}

impl Rig {
    /// A controller of this configuration, off; `app` and `other` can be downloaded.
    pub fn off(config: Config, app: Script) -> Rig {
        Rig::off_with(config, app, Vec::new())
    }

    /// The same with modules after the embedded I/O.
    pub fn off_with(config: Config, app: Script, modules: Vec<Box<dyn TaskModule>>) -> Rig {
        let trail = Trail::default();
        let mut other = app.clone();
        other.signature += 1;
        let scripts = BTreeMap::from([(b"app".to_vec(), app), (b"other".to_vec(), other)]);
        let files = Files::default();
        let loader = Box::new(Scripts(scripts, trail.clone()));
        let plc = Controller::with_modules(config, loader, Box::new(files.clone()), modules);
        Rig {
            plc: plc.unwrap(),
            files,
            now: Time::ZERO,
            fx: Effects::new(),
            seen: Vec::new(),
            trail,
            slices: Vec::new(),
            turn: 0,
        }
    }

    /// The same, booted at 1.5 s into the state that `left` leads to.
    pub fn booted(config: Config, app: Script, left: State) -> Rig {
        Rig::off(config, app).boot(left)
    }

    fn boot(mut self, left: State) -> Rig {
        self.plc.commission(b"app", left).unwrap();
        self.power_on();
        self.after(BOOT);
        // The timers of the instant: the end of the boot.
        self.settle();
        self
    }

    /// Running since 1.5 s, with modules after the embedded I/O.
    pub fn running_with(config: Config, app: Script, modules: Vec<Box<dyn TaskModule>>) -> Rig {
        let rig = Rig::off_with(config, app, modules).boot(State::Running);
        assert_eq!(rig.plc.state(), State::Running);
        rig
    }

    /// Running since 1.5 s.
    pub fn running(config: Config, app: Script) -> Rig {
        let rig = Rig::booted(config, app, State::Running);
        assert_eq!(rig.plc.state(), State::Running);
        rig
    }

    pub fn power_on(&mut self) {
        self.plc.power_on(self.now, &mut self.fx);
        self.drain();
    }

    pub fn power_off(&mut self) {
        self.plc.power_off(self.now, &mut self.fx);
        self.drain();
    }

    pub fn command(&mut self, command: Command) -> Result<(), CommandError> {
        let result = self.plc.command(self.now, command, &mut self.fx);
        self.drain();
        result
    }

    fn drain(&mut self) {
        self.seen.append(&mut self.fx.list);
    }

    /// Lets the timers due now act.
    pub fn settle(&mut self) {
        while self.plc.next_timer().is_some_and(|at| at <= self.now) {
            self.plc.fire(self.now, &mut self.fx);
            self.drain();
        }
    }

    /// Comes to `to`, whose own timers are still to act.
    pub fn to(&mut self, to: Time) {
        let mut piece = self.piece(to);
        while self.now < to {
            self.settle();
            let reached = self.plc.run(piece.min(to), &mut self.fx);
            assert!(
                reached >= self.now && reached <= piece.min(to),
                "{reached} not in {}..{piece}",
                self.now
            );
            self.drain();
            self.now = reached;
            if self.now >= piece {
                piece = self.piece(to);
            }
        }
    }

    fn piece(&mut self, to: Time) -> Time {
        if self.slices.is_empty() {
            return to;
        }
        self.turn += 1;
        self.now + Span::from_nanos(self.slices[self.turn % self.slices.len()].max(1))
    }

    pub fn after(&mut self, span: Span) {
        self.to(self.now + span);
    }

    pub fn system(&self, variable: impl Into<SystemVariable>) -> u64 {
        let variable = variable.into();
        match self.plc.read(&Probe::System(variable)) {
            Value::Word(n) => n,
            other => panic!("{variable:?} is {other:?}"),
        }
    }

    pub fn variable(&self, n: u32) -> i64 {
        match self.plc.read(&Probe::Variable(n)) {
            Value::Int(n) => n,
            other => panic!("variable {n} is {other:?}"),
        }
    }

    pub fn memory(&self, text: &str) -> u64 {
        self.plc.read(&Probe::Address(at(text))).as_int().unwrap() as u64
    }

    pub fn terminal(&self, n: usize) -> Level {
        match self.plc.read(&Probe::Terminal(Terminal::output(n))) {
            Value::Bool(on) => Level::from_bool(on),
            Value::HighZ => Level::HighZ,
            other => panic!("terminal {n} is {other:?}"),
        }
    }

    /// Edges of a terminal: when, and to what.
    pub fn edges(&self, terminal: usize) -> Vec<(Time, Level)> {
        let edge = |effect: &Effect| match *effect {
            Effect::Terminal { at, terminal: it, value, .. } if it == Terminal::output(terminal) => {
                Some((at, level_of(value)))
            }
            _ => None,
        };
        self.seen.iter().filter_map(edge).collect()
    }

    /// The entries of the log.
    pub fn log(&self) -> Vec<LogEntry> {
        let entry = |effect: &Effect| match *effect {
            Effect::Log { entry, .. } => Some(entry),
            _ => None,
        };
        self.seen.iter().filter_map(entry).collect()
    }

    /// When the controller changed its state, and to what.
    pub fn states(&self) -> Vec<(Time, State)> {
        let change = |effect: &Effect| match *effect {
            Effect::State { at, state } => Some((at, state)),
            _ => None,
        };
        self.seen.iter().filter_map(change).collect()
    }
}

/// The three steps of BOOTING.
pub const BOOT: Span = Span::from_millis(1_500);

/// The level that an output shows.
pub fn level_of(value: Value) -> Level {
    match value {
        Value::Bool(on) => Level::from_bool(on),
        Value::HighZ => Level::HighZ,
        other => panic!("{other:?} is no level"),
    }
}

pub fn at(text: &str) -> Address {
    Address::parse(text).unwrap()
}

pub fn ms(n: i64) -> Span {
    Span::from_millis(n)
}

pub fn us(n: i64) -> Span {
    Span::from_micros(n)
}

/// `span` after the start of RUNNING.
pub fn run_at(span: Span) -> Time {
    Time::ZERO + BOOT + span
}

pub fn task(name: &str, priority: u8, interval: Span) -> TaskConfig {
    TaskConfig { name: name.into(), priority, kind: TaskKind::Cyclic { interval }, watchdog: None }
}

pub fn config() -> Config {
    Config::new(profile::Profile::M241_2019)
}
