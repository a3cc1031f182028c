//! A board of the test's own, and what it reports.

use std::time::Instant;

use devices::PATIENCE;
use document::{Diagnostic, SourceFile};
use drivers::{
    Board, BoardContext, BoardEvent, BoardExt, BoardFile, ChannelId, Subject, Terminals, UnknownSubject,
};
use host::Realtime;
use signal::{Address, Area, Span, Time, Value};

/// The interfaces of the kernel, by their names in a board file.
pub const BOTH: [&str; 2] = ["v2", "v1"];

fn terminals(_: &Subject) -> Result<Terminals, UnknownSubject> {
    Ok(Terminals {
        inputs: (0..14).map(|bit| Address::bit(Area::Input, bit)).collect(),
        outputs: (0..10).map(|bit| Address::bit(Area::Output, bit)).collect(),
        ports: Vec::new(),
        modules: Vec::new(),
    })
}

pub fn read(text: &str) -> BoardFile {
    drivers::read(&SourceFile::new("bench.toml", text), &terminals)
        .unwrap_or_else(|found| panic!("{found:#?}"))
}

/// A board at work, with the clock that a run would have.
pub struct Bench {
    pub board: Box<dyn Board>,
    pub at: BoardContext,
    pub events: Vec<BoardEvent>,
}

/// What one channel did, loosely.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seen {
    pub changes: u64,
    pub dropped: u64,
}

impl std::ops::Add for Seen {
    type Output = Seen;

    fn add(self, other: Seen) -> Seen {
        Seen { changes: self.changes + other.changes, dropped: self.dropped + other.dropped }
    }
}

impl Bench {
    /// A board of the lab's main chip; `channels` are lines of TOML.
    pub fn of_main(backend: &str, channels: &str) -> Bench {
        Bench::open(&Bench::main(backend, channels))
    }

    /// The board file of such a board. The lab is patient: beside compilers it may stand still for a while.
    pub fn main(backend: &str, channels: &str) -> String {
        format!(
            "format = 1\n[board]\nkind = \"real\"\nbackend = \"{backend}\"\nunresponsive-after = \"5 s\"\n[chips]\nmain = {{ label = \"rig-gpio\" }}\n\
             [channels]\n{channels}\n"
        )
    }

    pub fn open(text: &str) -> Bench {
        Bench::try_open(text).unwrap_or_else(|found| panic!("{found:#?}"))
    }

    pub fn try_open(text: &str) -> Result<Bench, Vec<Diagnostic>> {
        Bench::try_open_with(text, Realtime::with_priority(80))
    }

    pub fn open_with(text: &str, realtime: Realtime) -> Bench {
        Bench::try_open_with(text, realtime).unwrap_or_else(|found| panic!("{found:#?}"))
    }

    fn try_open_with(text: &str, realtime: Realtime) -> Result<Bench, Vec<Diagnostic>> {
        let at = BoardContext::new(realtime);
        let board = drivers::open(&read(text), &at)?.expect("a real board");
        Ok(Bench { board, at, events: Vec::with_capacity(1 << 18) })
    }

    /// Starts a run at time 0.
    pub fn start(&mut self) {
        self.at.time.restart();
        self.board.start(Time::ZERO).unwrap();
        self.poll();
    }

    pub fn channel(&self, name: &str) -> ChannelId {
        self.board.find(name).unwrap_or_else(|| panic!("no channel {name}"))
    }

    pub fn now(&self) -> Time {
        self.at.time.now()
    }

    pub fn write(&mut self, levels: &[(&str, bool)]) {
        let writes: Vec<(ChannelId, Value)> =
            levels.iter().map(|(name, high)| (self.channel(name), Value::Bool(*high))).collect();
        let now = self.now();
        self.board.write(now, &writes).unwrap();
    }

    /// Asks the board what happened.
    pub fn poll(&mut self) {
        let now = self.now();
        self.board.poll(now, &mut self.events).unwrap();
    }

    /// Polls whenever the board rings, until the condition holds.
    pub fn until(&mut self, what: &str, mut holds: impl FnMut(&mut Bench) -> bool) {
        let due = Instant::now() + PATIENCE;
        loop {
            self.poll();
            if holds(self) {
                return;
            }
            assert!(Instant::now() < due, "never: {what}; health {:?}", self.board.health());
            let next = self.now() + Span::from_millis(20);
            let next = self.board.next_event().map_or(next, |at| at.min(next));
            self.at.bell.wait_until(self.at.time.stamp(next));
        }
    }

    /// The last level that was reported of a channel.
    pub fn level(&self, name: &str) -> Option<bool> {
        let id = self.channel(name);
        self.events.iter().rev().find_map(|event| match event {
            BoardEvent::Changed { channel, value: Value::Bool(high), .. } if *channel == id => Some(*high),
            _ => None,
        })
    }

    /// Waits until a channel has this level.
    pub fn until_level(&mut self, name: &str, high: bool) {
        self.until(&format!("{name} is {high}"), |bench| bench.level(name) == Some(high));
    }

    /// Changes of a channel after its first level, and losses of it.
    pub fn seen(&self, name: &str) -> Seen {
        let id = self.channel(name);
        let mut seen = Seen::default();
        for event in self.events.iter().filter(|event| event.channel() == id) {
            match event {
                BoardEvent::Changed { .. } => seen.changes += 1,
                BoardEvent::Dropped { count, .. } => seen.dropped += u64::from(*count),
                _ => {}
            }
        }
        seen.changes = seen.changes.saturating_sub(1);
        seen
    }
}
