//! A board of one generator.

use devices::{Lab, PATIENCE};
use document::{Diagnostic, SourceFile};
use drivers::{
    Board, BoardContext, BoardEvent, BoardExt, BoardFile, ChannelId, Emission, LossReason, Terminals, read,
};
use host::Realtime;
use signal::{Span, Time, Value, When};
use std::time::Instant;

/// Where nothing is to be lost or missed however the machine stands still.
pub const PATIENT: &str = "unresponsive-after = \"30 s\"";

/// A board file of real devices.
pub fn file(board: &str, generator: &str, channels: &str) -> BoardFile {
    let text = format!(
        "format = 1\n[board]\nkind = \"real\"\n{board}\n[generators]\nit = {{ {generator} }}\n[channels]\n{channels}\n"
    );
    read(&SourceFile::new("emit.toml", text), &|_| Ok(Terminals::default()))
        .unwrap_or_else(|found| panic!("{found:#?}"))
}

/// A square wave, in ns.
pub fn square(period: i64, high: i64) -> Emission {
    Emission::Square { period: Span::from_nanos(period), high: Span::from_nanos(high) }
}

/// Pulses, in ns.
pub fn pulses(edges: impl IntoIterator<Item = i64>) -> Emission {
    Emission::Pulses(edges.into_iter().map(Span::from_nanos).collect())
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

    pub fn poll(&mut self) {
        self.board.poll(self.at.time.now(), &mut self.events).unwrap();
    }

    pub fn id(&self, name: &str) -> ChannelId {
        self.board.find(name).unwrap()
    }

    pub fn emit(&mut self, name: &str, emission: &Emission) {
        self.board.emit(self.at.time.now(), self.id(name), emission).unwrap();
    }

    pub fn write(&mut self, name: &str, high: bool) {
        self.board.write(self.at.time.now(), &[(self.id(name), Value::Bool(high))]).unwrap();
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

    pub fn changes(&self, name: &str) -> Vec<(When, Value)> {
        let id = self.id(name);
        let of = |event: &BoardEvent| match *event {
            BoardEvent::Changed { channel, at, value, .. } if channel == id => Some((at, value)),
            _ => None,
        };
        self.events.iter().filter_map(of).collect()
    }

    /// Losses and returns of a channel, in order.
    pub fn fate(&self, name: &str) -> Vec<Option<LossReason>> {
        let id = self.id(name);
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
