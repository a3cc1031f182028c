//! What passes between the scan of a rig that is kept running and the handle that others hold of it. Nothing in here owns
//! memory but lines of the log and what is reported of a plan.

use super::snapshot::Snapshot;
use control::{ControllerAction, PlanEvent};
use controller::{CommandError, Probe, WriteError};
use drivers::{BoardError, BusId, ChannelId};
use rtrb::{Consumer, Producer, RingBuffer};
use signal::{Address, CanFrame, SerialMessage, Span, Time, Value, When};

/// Requests that wait for the scan: all orders under way, and as many changes of what is watched.
const REQUESTS: usize = 1_024;

/// What happened and nobody took yet: a busy second.
const EVENTS: usize = 16_384;

/// Snapshots under way: one that is filled, one that waits, one that is looked at.
const SNAPSHOTS: usize = 3;

/// What is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ObservedSource {
    /// A channel of the board.
    Channel(ChannelId),
    /// Something inside the controller.
    Inside(Probe),
}

/// What is asked of the scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ScanRequest {
    /// Changes of this are reported from now on, under this number; its present value at once.
    Watch(u32, ObservedSource),
    /// No more.
    Unwatch(u32),
    /// An order; its outcome comes under this number.
    Command(u64, ScanCommand),
}

/// An order, with every name resolved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ScanCommand {
    /// A value.
    Read(ObservedSource),
    /// Something is written.
    Write(ObservedSource, Value),
    /// An input or output is forced, by its place in %I or %Q.
    Force(Address, u64),
    /// No more.
    Release(Address),
    /// None at all.
    ReleaseAll,
    /// A command.
    Command(ControllerAction),
    /// Time passes, where clients lead it.
    Advance(Span),
    /// The plan that waits is run.
    Plan,
    /// The one that runs is ended.
    Abort,
}

/// What an order came to.
pub type OrderOutcome = Result<Option<Value>, ScanCommandError>;

/// Why an order was not carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScanCommandError {
    /// The controller does not obey.
    Command(CommandError),
    /// It cannot be written.
    Write(WriteError),
    /// The board does not do it.
    Board(BoardError),
    /// Nobody leads the time of this rig.
    NotStepped,
    /// There is no controller that the rig plays.
    NoModel,
    /// A plan has the board.
    PlanRuns,
    /// None does.
    NoPlan,
}

/// What happened.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "copied between queues that never allocate")]
pub enum ScanEvent {
    /// Something that is watched changed.
    Change(u32, When, Value),
    /// A line of the log.
    Log(Time, String),
    /// A frame was on a bus; the rig's own where the last says so.
    Frame(BusId, Time, CanFrame, bool),
    /// Characters were on a serial line; the rig's own where the last says so.
    SerialMessage(BusId, SerialMessage, bool),
    /// A step of the case that runs began, or is done: its place, the instant in the case.
    Step(u32, Span, bool),
    /// Something else of a plan.
    Plan(Box<PlanEvent>),
}

/// The ends of the scan.
#[derive(Debug)]
pub struct ScanEnd {
    /// What is asked.
    pub requests: Consumer<ScanRequest>,
    /// What came of it.
    pub outcomes: Producer<(u64, OrderOutcome)>,
    /// What happened.
    pub events: Producer<ScanEvent>,
    /// Snapshots to be filled.
    pub empty: Consumer<Box<Snapshot>>,
    /// Those that are.
    pub full: Producer<Box<Snapshot>>,
}

/// The other ends.
#[derive(Debug)]
pub struct HandleEnd {
    /// See [`ScanEnd`].
    pub requests: Producer<ScanRequest>,
    /// See [`ScanEnd`].
    pub outcomes: Consumer<(u64, OrderOutcome)>,
    /// See [`ScanEnd`].
    pub events: Consumer<ScanEvent>,
    /// See [`ScanEnd`].
    pub empty: Producer<Box<Snapshot>>,
    /// See [`ScanEnd`].
    pub full: Consumer<Box<Snapshot>>,
}

/// Both ends, with all memory that they will ever take. Snapshots are like this one.
pub fn queues(snapshot: &Snapshot) -> (ScanEnd, HandleEnd) {
    let (requests, wished) = RingBuffer::new(REQUESTS);
    let (outcomes, came) = RingBuffer::new(REQUESTS);
    let (events, heard) = RingBuffer::new(EVENTS);
    let (mut empty, to_fill) = RingBuffer::new(SNAPSHOTS);
    let (full, filled) = RingBuffer::new(SNAPSHOTS);
    for _ in 0..SNAPSHOTS {
        // There is room for all of them.
        let _ = empty.push(Box::new(snapshot.clone()));
    }
    (
        ScanEnd { requests: wished, outcomes, events, empty: to_fill, full },
        HandleEnd { requests, outcomes: came, events: heard, empty, full: filled },
    )
}
