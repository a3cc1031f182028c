//! Modules of inputs and outputs, from the board to the program and back: terminals that a board file binds to channels.

use crate::texts::Texts;
use controller::{
    ExchangeCycle, IoModule, Memory, ModuleChannel, OutputChanges, Sharing, TaskModule, Terminal, Written,
};
use profile::{IoChannel, IoStatus};
use scanrig_runtime::executor::clock::VirtualClock;
use scanrig_runtime::subject::Subject;
use signal::{Address, Cause, Span, Time, Value};

/// From what is at the input to its conversion.
const CONVERSION: Span = Span::from_millis(5);
/// From a command to the output.
const SETTLING: Span = Span::from_millis(2);

/// An input of 0 bar to 10 bar at %IW3, in millibars, and an output of 0 % to 100 % at %QW2, in hundredths.
#[derive(Debug)]
struct Loop {
    channels: [ModuleChannel; 2],
    /// Which ranks exchange the two.
    shared: Vec<[bool; 2]>,
    pressure: f64,
    converted: u64,
    conversion: Time,
    command: u64,
    shown: Option<u64>,
    due: Time,
}

impl Loop {
    fn boxed() -> Box<dyn TaskModule> {
        let channel = |channel, text| ModuleChannel::new(channel, Address::parse(text).unwrap());
        Box::new(Loop {
            channels: [channel(IoChannel::Input(0), "%IW3"), channel(IoChannel::Output(0), "%QW2")],
            shared: Vec::new(),
            pressure: 0.0,
            converted: 0,
            conversion: Time::MAX,
            command: 0,
            shown: None,
            due: Time::MAX,
        })
    }
}

impl IoModule for Loop {
    fn channels(&self) -> &[ModuleChannel] {
        &self.channels
    }

    fn power_on(&mut self, now: Time) {
        self.conversion = now.saturating_add(CONVERSION);
    }

    fn power_off(&mut self, _: Time) {
        (self.conversion, self.due) = (Time::MAX, Time::MAX);
    }

    fn set_input(&mut self, now: Time, _: usize, value: Value) {
        if let Some(bar) = value.as_real() {
            (self.pressure, self.conversion) = (bar, now.saturating_add(CONVERSION));
        }
    }

    fn initialize(&mut self, _: Time) {
        (self.command, self.shown, self.due) = (0, None, Time::MAX);
    }

    fn next(&self) -> Time {
        self.conversion.min(self.due)
    }

    fn fire(&mut self, now: Time, changes: &mut OutputChanges<'_>) {
        if self.conversion <= now {
            self.conversion = Time::MAX;
            self.converted = (self.pressure * 1_000.0) as u64;
        }
        if self.due <= now {
            let at = std::mem::replace(&mut self.due, Time::MAX);
            self.shown = Some(self.command);
            changes.push(at, 0, self.output(0), Cause::Controller);
        }
    }

    fn output(&self, _: usize) -> Value {
        self.shown.map_or(Value::HighZ, |command| Value::Real(command as f64 / 100.0))
    }
}

impl TaskModule for Loop {
    fn share(&mut self, sharing: &Sharing<'_>) {
        let of = |rank| self.channels.map(|channel| sharing.exchanges(rank, channel.address));
        self.shared = (0..sharing.tasks()).map(of).collect();
    }

    fn sample(&mut self, _: Time, cycle: ExchangeCycle, memory: &mut Memory) -> bool {
        let address = self.channels[0].address;
        let changed =
            cycle.rank.is_none_or(|rank| self.shared[rank][0]) && memory.load(address) != self.converted;
        if changed {
            memory.store(address, self.converted);
        }
        changed
    }

    fn drive(&mut self, now: Time, cycle: ExchangeCycle, memory: &mut Memory) -> Written {
        let command = memory.load(self.channels[1].address);
        if cycle.rank.is_none_or(|rank| self.shared[rank][1]) && command != self.command {
            (self.command, self.due) = (command, now.saturating_add(SETTLING));
        }
        Written::default()
    }

    fn status(&self) -> IoStatus {
        IoStatus::Ok
    }
}

const PLAN: &str = "format = 1
title = \"A valve follows a pressure\"
program = \"valve.st\"
ends = \"start + 1 s\"
signals = { pressure = \"pressure\", valve = \"valve\" }
steps = [{ id = \"rises\", at = \"start + 505 ms\", set = { signal = \"pressure\", value = \"4.7 bar\" } }]
expect = [{ state = { stays = \"RUNNING\" } }]
";

const PROGRAM: &str = "PROGRAM MAIN
VAR
    measured AT %IW3 : WORD;
    command AT %QW2 : WORD;
END_VAR
command := measured;
END_PROGRAM
";

const BOARD: &str = "format = 1
[board]
kind = \"simulated\"
[channels]
pressure = { kind = \"analog\", unit = \"bar\" }
valve = { kind = \"analog\", unit = \"%\" }
[bind]
\"%IW3\" = \"pressure\"
\"%QW2\" = \"valve\"
";

#[test]
fn an_analogue_value_goes_from_the_board_through_the_program_and_back() {
    let texts = [("plan.toml", PLAN), ("valve.st", PROGRAM), ("board.toml", BOARD)];
    let (mut model, mut parts) = Texts(&texts).parts_with_modules(1, vec![Loop::boxed()]).unwrap();
    let terminal = |channel| Terminal { module: 1, channel };
    let at = |text: &str| Address::parse(text).unwrap();
    assert_eq!(model.terminal(at("%IW3")), Some(terminal(IoChannel::Input(0))));
    assert_eq!(model.terminal(at("%QW2")), Some(terminal(IoChannel::Output(0))));
    let ran = parts.run(&mut VirtualClock::default(), &mut model);
    assert_eq!(ran.fault, None);
    let trace = parts.recorder.trace();
    let start = ran.start.unwrap();
    let of = |name: &str| {
        let signal = trace.find(name).unwrap();
        let events = trace
            .events()
            .map(Result::unwrap)
            .filter(|event| event.signal == signal && event.at.latest > start);
        events.map(|event| (event.at.latest - start, event.value)).collect::<Vec<_>>()
    };
    assert_eq!(of("pressure"), [(Span::from_millis(505), Value::Real(4.7))]);
    // Converted at 510 ms, read and written in the cycle at 520 ms, shown after the settling time.
    let [(shown, value)] = of("valve")[..] else { panic!("{:?}", of("valve")) };
    assert_eq!(value, Value::Real(47.0));
    let earliest = Span::from_millis(520) + SETTLING;
    assert!(shown > earliest && shown < earliest + Span::from_millis(1), "{shown}");
}

#[test]
fn a_terminal_that_the_reference_does_not_have_is_a_finding_that_lists_those_it_has() {
    let plan = PLAN.replace("program", "board = \"board.toml\"\nprogram");
    let texts = [("plan.toml", plan.as_str()), ("valve.st", PROGRAM), ("board.toml", BOARD)];
    let mut sources = Vec::new();
    let found = scanrig_runtime::suite::load_plan(&Texts(&texts), "plan.toml", None, &[], 1, &mut sources);
    let found = found.unwrap_err();
    assert_eq!(found[0].code, "B0302");
    assert_eq!(found[0].message, "the controller has no terminal %IW3");
    let help = &found[0].help;
    assert!(help.starts_with("its inputs are %IX0.0 to %IX1.5, its outputs %QX0.0 to %QX1.1; "), "{help}");
    assert!(help.ends_with("M1.IW0 = { kind = \"analog\", unit = \"V\" } under `channels`"), "{help}");
}

/// Channels of the wrong kind: a number has no place on a line of levels.
#[test]
fn a_number_is_not_bound_to_a_line() {
    let board = BOARD
        .replace("pressure = { kind = \"analog\", unit = \"bar\" }", "pressure = { kind = \"digital\" }");
    let texts = [("plan.toml", PLAN), ("valve.st", PROGRAM), ("board.toml", board.as_str())];
    let found = Texts(&texts).parts_with_modules(1, vec![Loop::boxed()]).unwrap_err();
    assert_eq!(found[0].message, "%IW3 is a number, `pressure` a digital channel");
}
