//! A board of one converter.

use devices::{Lab, PATIENCE, bind_spi};
use document::{Diagnostic, SourceFile};
use drivers::{Board, BoardContext, BoardEvent, BoardExt, BoardFile, LossReason, Terminals, read};
use host::Realtime;
use signal::{Span, Time, Value, When};
use std::time::Instant;

/// Where nothing is to be lost or missed however the machine stands still.
pub const PATIENT: &str = "unresponsive-after = \"30 s\"";

/// A board file of real devices.
pub fn file(board: &str, converter: &str, channels: &str) -> BoardFile {
    let text = format!(
        "format = 1\n[board]\nkind = \"real\"\n{board}\n[converters]\nadc = {{ kind = \"spi\", {converter} }}\n\
         [channels]\n{channels}\n"
    );
    read(&SourceFile::new("adc.toml", text), &|_| Ok(Terminals::default()))
        .unwrap_or_else(|found| panic!("{found:#?}"))
}

/// Channels of these inputs, named by them, in volts.
pub fn volts(inputs: impl IntoIterator<Item = u8>) -> String {
    inputs
        .into_iter()
        .map(|input| format!("a{input} = {{ kind = \"analog\", unit = \"V\", input = {input} }}\n"))
        .collect()
}

/// A board at work, and what it reported.
pub struct Bench {
    pub board: Box<dyn Board>,
    pub at: BoardContext,
    pub events: Vec<BoardEvent>,
    _lab: Lab,
}

impl Bench {
    /// Opens the board of a file and starts it.
    pub fn started(file: &BoardFile) -> Bench {
        let lab = Lab::enter();
        bind_spi();
        let (board, at) = open(file).unwrap_or_else(|found| panic!("{found:#?}"));
        let mut bench = Bench { board, at, events: Vec::new(), _lab: lab };
        bench.start();
        bench
    }

    /// A new run.
    pub fn start(&mut self) {
        self.events.clear();
        self.at.time.restart();
        self.board.start(Time::ZERO).unwrap();
        self.poll();
    }

    fn poll(&mut self) {
        self.board.poll(self.at.time.now(), &mut self.events).unwrap();
    }

    /// Polls until this is so.
    pub fn until(&mut self, what: &str, holds: impl Fn(&Bench) -> bool) {
        let due = Instant::now() + PATIENCE;
        self.poll();
        while !holds(self) {
            assert!(Instant::now() < due, "never: {what}; {:?} {:?}", self.board.health(), self.events);
            let next = self.at.time.now() + Span::from_millis(5);
            let next = self.board.next_event().map_or(next, |at| at.min(next));
            self.at.bell.wait_until(self.at.time.stamp(next));
            self.poll();
        }
    }

    /// Waits until a channel shows about this.
    pub fn shows(&mut self, name: &str, volts: f64, within: f64) {
        self.until(&format!("{name} at {volts} V"), |bench| {
            bench.last(name).and_then(Value::as_real).is_some_and(|now| (now - volts).abs() <= within)
        });
    }

    pub fn changes(&self, name: &str) -> Vec<(When, Value)> {
        let id = self.board.find(name).unwrap();
        let of = |event: &BoardEvent| match *event {
            BoardEvent::Changed { channel, at, value, .. } if channel == id => Some((at, value)),
            _ => None,
        };
        self.events.iter().filter_map(of).collect()
    }

    pub fn last(&self, name: &str) -> Option<Value> {
        self.changes(name).last().map(|(_, value)| *value)
    }

    /// Losses and returns of a channel, in order.
    pub fn fate(&self, name: &str) -> Vec<Option<LossReason>> {
        let id = self.board.find(name).unwrap();
        let of = |event: &BoardEvent| match *event {
            BoardEvent::Lost { channel, reason, .. } if channel == id => Some(Some(reason)),
            BoardEvent::Returned { channel, .. } if channel == id => Some(None),
            _ => None,
        };
        self.events.iter().filter_map(of).collect()
    }
}

/// Opens the board of a file.
pub fn open(file: &BoardFile) -> Result<(Box<dyn Board>, BoardContext), Vec<Diagnostic>> {
    let at = BoardContext::new(Realtime::default());
    let board = drivers::open(file, &at)?.expect("a real board");
    Ok((board, at))
}
