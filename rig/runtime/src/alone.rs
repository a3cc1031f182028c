//! A program alone: no controller, no board, only cycles at an interval. For trying a block.

use controller::Memory;
use profile::Profile;
use program::{Host, Machine, Program, Stop, Storage};
use signal::{Address, Cause, Span, Time, Value};
use std::sync::Arc;

/// A program with memory of its own.
#[derive(Debug)]
pub struct Alone {
    machine: Option<Machine>,
    memory: Memory,
    program: Arc<Program>,
}

/// How a run alone ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ended {
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
        /// When it began.
        at: Span,
    },
}

struct Plain<'a>(&'a mut Memory);

impl Host for Plain<'_> {
    fn load(&mut self, at: Address) -> u64 {
        self.0.load(at)
    }

    fn store(&mut self, at: Address, value: u64, file: u8, line: u32) -> bool {
        self.0.set_cause(Cause::Program { task: 0, file, line });
        self.0.store(at, value);
        false
    }
}

impl Alone {
    /// All PROGRAMs in the order of the sources, run by one task.
    pub fn new(program: Arc<Program>, profile: Profile) -> Alone {
        let all = (0..program.programs().len()).collect();
        let machine = Machine::new(Arc::clone(&program), &[all]).ok();
        let mut memory = Memory::new(profile);
        for located in program.located() {
            if let Some(initial) = located.initial {
                memory.store(located.address, initial);
            }
        }
        Alone { machine, memory, program }
    }

    fn located(&self, name: &str) -> Option<(Address, bool)> {
        let variable = self.program.find(name)?;
        match variable.storage {
            Storage::Located(address) => Some((address, address.bit_len() == 1)),
            Storage::Cell(_) => None,
        }
    }

    /// The value of a variable.
    pub fn read(&self, name: &str) -> Option<Value> {
        if let Some((address, bit)) = self.located(name) {
            let raw = self.memory.load(address);
            return Some(if bit { Value::Bool(raw != 0) } else { Value::Word(raw) });
        }
        let machine = self.machine.as_ref()?;
        Some(machine.read(machine.find(name)?))
    }

    /// Sets a variable; FALSE where there is none of this name, or the value is no number.
    pub fn write(&mut self, name: &str, value: Value) -> bool {
        if let (Some((address, _)), Some(number)) = (self.located(name), value.as_int()) {
            self.memory.store(address, number as u64);
            return true;
        }
        let Some(machine) = &mut self.machine else { return false };
        machine.find(name).is_some_and(|variable| machine.write(variable, value))
    }

    /// Runs cycles at `interval` until `duration` is over. A cycle that takes longer is followed at once by the next.
    pub fn run(&mut self, duration: Span, interval: Span) -> Ended {
        let Some(machine) = &mut self.machine else { return Ended::InTime { cycles: 0 } };
        let end = Time::ZERO + duration;
        let (mut now, mut cycles) = (Time::ZERO, 0);
        while now < end {
            let began = now;
            machine.begin(0);
            loop {
                let slice = machine.resume(0, now, end - now, &mut Plain(&mut self.memory));
                now += slice.used;
                match slice.stop {
                    Stop::Done => break,
                    Stop::Touched => {}
                    Stop::Budget { .. } => return Ended::Endless { at: began - Time::ZERO },
                    Stop::Fault(fault) => {
                        let files = self.program.files();
                        let file = files.get(usize::from(fault.file)).map_or("?", String::as_str);
                        let text = format!("{} at {file}:{}", fault.kind, fault.line);
                        return Ended::Fault { at: now - Time::ZERO, text };
                    }
                }
            }
            cycles += 1;
            now = now.max(began.saturating_add(interval));
        }
        Ended::InTime { cycles }
    }
}
