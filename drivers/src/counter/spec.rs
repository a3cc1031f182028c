//! What a board file says of counters.

use std::ops::Range;
use std::path::PathBuf;

use host::CounterEventKind;
use signal::Span;

use super::Way;
use crate::channel::ChannelId;
use crate::counting::{CountEdge, CountFunction};

/// The counters of a board, and the channels behind which they count.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CountersSpec {
    /// The counters.
    pub counters: Vec<CounterSpec>,
    /// The channels, in their order.
    pub counts: Vec<CountSpec>,
}

impl CountersSpec {
    /// The channels with their counters.
    pub fn used(&self) -> impl Iterator<Item = (&CountSpec, &CounterSpec)> {
        self.counts.iter().filter_map(|count| Some((count, self.counters.get(count.counter)?)))
    }
}

/// The channel behind which a counter counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CountSpec {
    /// The channel.
    pub channel: ChannelId,
    /// Place of its counter in [`CountersSpec::counters`].
    pub counter: usize,
}

/// A count of a counter.
#[derive(Clone, Debug, PartialEq)]
pub struct CounterSpec {
    /// Its name in the board file.
    pub name: String,
    /// Where the file names it.
    pub place: Range<usize>,
    /// Which device.
    pub find: FindCounter,
    /// Which of its counts.
    pub count: FindCount,
    /// What it counts; as it is if left out.
    pub function: Option<CountFunction>,
    /// The edge that it counts; as it is if left out.
    pub edge: Option<CountEdge>,
    /// The highest number that it shows; as it is if left out.
    pub ceiling: Option<u64>,
    /// Time between two readings.
    pub period: Span,
    /// What it reports by itself.
    pub events: Vec<CounterEventKind>,
    /// How many events the kernel keeps.
    pub buffer: u32,
    /// The fastest that it has to follow, in counts a second; where the file says so.
    pub counts_hz: Option<u64>,
}

impl CounterSpec {
    /// The most counts a second that it is to follow.
    pub fn fastest(&self) -> u64 {
        self.counts_hz.unwrap_or(FASTEST)
    }

    /// The longest time between two readings that is not reported as a loss, where a call on the device may last so long.
    pub fn longest(&self, unresponsive_after: Span) -> Span {
        let periods = self.period.as_nanos().saturating_mul(2);
        Span::from_nanos(unresponsive_after.as_nanos().saturating_add(periods))
    }

    /// Whether it reports when it wraps.
    pub fn reports_wraps(&self) -> bool {
        let tells = |kind| self.events.contains(&kind);
        tells(CounterEventKind::OverflowUnderflow)
            || tells(CounterEventKind::Overflow)
                && (self.way() == Way::Up || tells(CounterEventKind::Underflow))
    }

    /// Whether it reports every count.
    pub fn reports_steps(&self) -> bool {
        self.events.contains(&CounterEventKind::ChangeOfState)
    }

    /// The ways that it counts, as far as the file says.
    pub fn way(&self) -> Way {
        match self.function {
            Some(CountFunction::Increase) => Way::Up,
            Some(CountFunction::Decrease) => Way::Down,
            _ => Way::Both,
        }
    }
}

/// Faster than any input of a counter: what has to be followed where nobody says how fast it gets.
const FASTEST: u64 = 100_000_000;

/// Events by their names in a board file.
pub(crate) const EVENTS: [(&str, CounterEventKind); 7] = [
    ("overflow", CounterEventKind::Overflow),
    ("underflow", CounterEventKind::Underflow),
    ("overflow-underflow", CounterEventKind::OverflowUnderflow),
    ("threshold", CounterEventKind::Threshold),
    ("index", CounterEventKind::Index),
    ("change-of-state", CounterEventKind::ChangeOfState),
    ("capture", CounterEventKind::Capture),
];

/// The name of an event.
pub(super) fn event_name(kind: CounterEventKind) -> &'static str {
    EVENTS.iter().find(|(_, known)| *known == kind).map_or("", |(name, _)| name)
}

/// How a device is found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FindCounter {
    /// By what its driver calls it.
    Name(String),
    /// By a path in `/dev` or `/sys`.
    Path(PathBuf),
}

/// How a count is found on its device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FindCount {
    /// By its number.
    Number(u8),
    /// By its name.
    Name(String),
}
