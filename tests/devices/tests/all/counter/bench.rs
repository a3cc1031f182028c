//! A board of one counter.

use devices::{Counter, Lab, PATIENCE};
use document::{Diagnostic, SourceFile};
use drivers::{Board, BoardContext, BoardEvent, BoardFile, LossReason, Terminals, read};
use host::Realtime;
use signal::{Span, Time, Value, When};
use std::time::Instant;

/// Where nothing is to be lost however the machine stands still.
pub const PATIENT: &str = "unresponsive-after = \"30 s\"";

/// A board file with a count `shaft`.
pub fn file(board: &str, counter: &str) -> BoardFile {
    let text = format!(
        "format = 1\n[board]\nkind = \"real\"\n{board}\n[counters]\n\
         wheel = {{ path = \"/dev/counter0\", {counter} }}\n[channels]\nshaft = {{ kind = \"count\" }}\n"
    );
    read(&SourceFile::new("counter.toml", text), &|_| Ok(Terminals::default()))
        .unwrap_or_else(|found| panic!("{found:#?}"))
}

/// A board at work, and what it reported.
pub struct Bench {
    pub board: Box<dyn Board>,
    pub at: BoardContext,
    pub events: Vec<BoardEvent>,
    pub counter: Counter,
    pub lab: Lab,
}

impl Bench {
    /// Opens the board of a file and starts it.
    pub fn started(file: &BoardFile) -> Bench {
        let lab = Lab::enter();
        let counter = Counter::enter();
        Bench::on(file, counter, lab)
    }

    /// The same with a counter that was set up.
    pub fn on(file: &BoardFile, counter: Counter, lab: Lab) -> Bench {
        let (board, at) = open(file).unwrap_or_else(|found| panic!("{found:#?}"));
        let mut bench = Bench { board, at, events: Vec::new(), counter, lab };
        bench.start();
        bench
    }

    /// A new run.
    pub fn start(&mut self) {
        self.events.clear();
        self.at.time.restart();
        self.board.start(Time::ZERO).unwrap();
        self.poll();
        assert_eq!(self.changes().first().map(|(_, value)| *value), Some(Value::Int(0)));
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

    /// Waits until the count is this.
    pub fn counts(&mut self, total: i64) {
        self.until(&format!("a count of {total}"), |bench| bench.last() == Some(total));
    }

    /// What the channel reported.
    pub fn changes(&self) -> Vec<(When, Value)> {
        let of = |event: &BoardEvent| match *event {
            BoardEvent::Changed { at, value, .. } => Some((at, value)),
            _ => None,
        };
        self.events.iter().filter_map(of).collect()
    }

    /// The count that was reported last.
    pub fn last(&self) -> Option<i64> {
        match self.changes().last()?.1 {
            Value::Int(count) => Some(count),
            _ => None,
        }
    }

    /// Losses and returns, in order.
    pub fn fate(&self) -> Vec<Option<LossReason>> {
        let of = |event: &BoardEvent| match *event {
            BoardEvent::Lost { reason, .. } => Some(Some(reason)),
            BoardEvent::Returned { .. } => Some(None),
            _ => None,
        };
        self.events.iter().filter_map(of).collect()
    }

    /// Losses of counts.
    pub fn dropped(&self) -> usize {
        self.events.iter().filter(|event| matches!(event, BoardEvent::Dropped { .. })).count()
    }
}

/// Opens the board of a file.
pub fn open(file: &BoardFile) -> Result<(Box<dyn Board>, BoardContext), Vec<Diagnostic>> {
    let at = BoardContext::new(Realtime::default());
    let board = drivers::open(file, &at)?.expect("a real board");
    Ok((board, at))
}
