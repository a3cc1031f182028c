//! What every board is to the rest of the rig: channels, writes, events, faults and a safe state.

use std::fmt;

use crate::{Bus, BusEvent, BusId, Frame, HeldLines};
use signal::{Span, Time, Value, When};

/// The place of a channel in [`Board::channels`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ChannelId(pub u16);

/// What a channel carries.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum ChannelKind {
    /// A level: [`Value::Bool`], or [`Value::HighZ`] where nobody drives.
    Digital,
    /// A measured or set quantity: [`Value::Real`] in this unit.
    Analog {
        /// Unit as it is written, as in `V` or `degC`; empty for none.
        unit: String,
    },
}

/// Where the instants of a channel's events come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TimestampSource {
    /// Modelled time: exact.
    Virtual,
    /// The kernel stamps each edge.
    Kernel,
    /// A device stamps each edge with a clock of its own.
    Device,
    /// Changes are found by reading the line every `period`.
    Sampled {
        /// Time between two samples.
        period: Span,
    },
}

/// One channel of a board: a terminal with a line on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// The name that bindings, wires and plants use, as in `I0`, `Q4` or `temp`.
    pub name: String,
    /// What it carries.
    pub kind: ChannelKind,
    /// Whether [`Board::write`] may drive it.
    pub drives: bool,
    /// Whether [`Board::poll`] reports it.
    pub senses: bool,
    /// Where the instants of its events come from.
    pub timestamp: TimestampSource,
    /// Width of the interval in which an event is stamped (0 = exact).
    pub resolution: Span,
    /// The shortest pulse that is certain to be seen; [`Span::MAX`] where the board cannot tell.
    pub shortest_pulse: Span,
    /// The fastest pulse train that [`Board::write`] can emit on it, in Hz (0 = none).
    pub max_pulse_hz: u64,
    /// The faults that can be injected on it.
    pub faults: FaultSet,
    /// What a driven line is left at by [`Board::start`] and [`Board::safe`].
    pub safe: Value,
    /// How far an analog channel can move from what was told of it without being told again, in its unit; 0 for not at
    /// all.
    pub deadband: f64,
}

impl Channel {
    /// Whether the channel carries a level.
    pub fn is_digital(&self) -> bool {
        self.kind == ChannelKind::Digital
    }

    /// Unit of an analog channel; empty for none and for a level.
    pub fn unit(&self) -> &str {
        match &self.kind {
            ChannelKind::Digital => "",
            ChannelKind::Analog { unit } => unit,
        }
    }
}

/// What an injected fault does to a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultKind {
    /// The line keeps this value, whoever drives it.
    StuckAt(Value),
    /// The line is cut at the terminal: nothing drives it any more, an input reads its pull.
    Open,
    /// The line is at 0 V.
    ShortToGround,
    /// The line is at the supply.
    ShortToSupply,
    /// The line has this value for this time, then follows its drivers again.
    Glitch {
        /// Value during the glitch.
        value: Value,
        /// Length of the glitch, above 0.
        width: Span,
    },
    /// Every change of the line comes this much later.
    Late(Span),
    /// The device behind the channel is gone: its value is unknown and writes do not reach the line.
    Lost,
}

impl FaultKind {
    /// The flag of this kind in a [`FaultSet`].
    const fn bit(self) -> u8 {
        match self {
            FaultKind::StuckAt(Value::Bool(true)) => 128,
            FaultKind::StuckAt(_) => 1,
            FaultKind::Open => 2,
            FaultKind::ShortToGround => 4,
            FaultKind::ShortToSupply => 8,
            FaultKind::Glitch { .. } => 16,
            FaultKind::Late(_) => 32,
            FaultKind::Lost => 64,
        }
    }
}

/// A fault on one channel, from the instant of its injection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Where.
    pub channel: ChannelId,
    /// What.
    pub kind: FaultKind,
    /// How long it stays; `None`: until [`Board::clear`]. A glitch ends after its width in any case.
    pub lasts: Option<Span>,
}

/// Which kinds of fault a channel can have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct FaultSet(u8);

impl FaultSet {
    /// No fault can be injected.
    pub const NONE: FaultSet = FaultSet(0);
    /// Every fault of a digital line.
    pub const DIGITAL: FaultSet = FaultSet(255);
    /// Every fault of an analog line: as [`FaultSet::DIGITAL`] but without a short to the supply, which has no
    /// value in the channel's unit.
    pub const ANALOG: FaultSet = FaultSet(127 - 8);

    /// Whether faults of this kind can be injected. Being stuck at 1 is a kind of its own; other values and times do not
    /// count.
    pub const fn contains(self, kind: FaultKind) -> bool {
        self.0 & kind.bit() != 0
    }

    /// The set with this kind added.
    #[must_use]
    pub const fn with(self, kind: FaultKind) -> Self {
        FaultSet(self.0 | kind.bit())
    }
}

/// Who made a line change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Origin {
    /// [`Board::write`] on this very channel; at the start, the safe value.
    Write,
    /// A wire from another channel.
    Wire,
    /// A plant.
    Plant,
    /// A fault that came or went on this channel.
    Fault,
    /// The world outside: all that a real board can say.
    Outside,
}

/// Why a device is gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LossReason {
    /// A fault that was asked for: no trouble of the rig.
    Injected,
    /// The device was unplugged or its driver unbound.
    Gone,
    /// The device does not answer any more.
    Silent,
}

impl fmt::Display for LossReason {
    /// What became of the device, as in `it is gone`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            LossReason::Injected => "is cut off, as asked",
            LossReason::Gone => "is gone",
            LossReason::Silent => "does not answer",
        })
    }
}

/// What a board has to tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoardEvent {
    /// A line has another value.
    Changed {
        /// Which channel.
        channel: ChannelId,
        /// When it happened.
        at: When,
        /// What it is from then on. [`Value::HighZ`] only on channels without a pull.
        value: Value,
        /// Who did it.
        origin: Origin,
    },
    /// The device behind a channel is gone: its value is [`Value::Unknown`] until it returns. A device of many
    /// channels reports each of them.
    Lost {
        /// Which channel.
        channel: ChannelId,
        /// When it was noticed.
        at: Time,
        /// Why.
        reason: LossReason,
    },
    /// The device behind a channel is back; a `Changed` with its present value follows.
    Returned {
        /// Which channel.
        channel: ChannelId,
        /// When it was noticed.
        at: Time,
    },
    /// Events of a channel were lost (a full kernel buffer, a gap in sequence numbers) before this place in the
    /// stream: no verdict that rests on this channel around `at` holds.
    Dropped {
        /// Which channel.
        channel: ChannelId,
        /// When the loss was noticed.
        at: Time,
        /// How many events, at least.
        count: u32,
    },
}

impl BoardEvent {
    /// The channel that it concerns.
    pub fn channel(&self) -> ChannelId {
        match *self {
            BoardEvent::Changed { channel, .. }
            | BoardEvent::Lost { channel, .. }
            | BoardEvent::Returned { channel, .. }
            | BoardEvent::Dropped { channel, .. } => channel,
        }
    }

    /// The latest instant at which it can have happened: what poll orders by.
    pub fn latest(&self) -> Time {
        match *self {
            BoardEvent::Changed { at, .. } => at.latest,
            BoardEvent::Lost { at, .. }
            | BoardEvent::Returned { at, .. }
            | BoardEvent::Dropped { at, .. } => at,
        }
    }
}

/// The state of a board, counted since its start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Health {
    /// Channels that are lost now through an injected fault: no trouble of the rig.
    pub lost_on_purpose: u32,
    /// Channels that are lost now by themselves: the rig's error.
    pub lost: u32,
    /// Events that the board knows to have missed.
    pub dropped: u64,
    /// Times that two drivers began to pull one line both ways.
    pub contentions: u64,
    /// Calls that failed.
    pub failed_calls: u64,
    /// Whether the outputs are latched at their safe values.
    pub latched_safe: bool,
}

impl Health {
    /// What two parts of a board have to say together.
    #[must_use]
    pub fn and(self, other: Health) -> Health {
        Health {
            lost_on_purpose: self.lost_on_purpose + other.lost_on_purpose,
            lost: self.lost + other.lost,
            dropped: self.dropped + other.dropped,
            contentions: self.contentions + other.contentions,
            failed_calls: self.failed_calls + other.failed_calls,
            latched_safe: self.latched_safe || other.latched_safe,
        }
    }

    /// Whether verdicts can rest on this board: nothing missed, nothing lost but on purpose, no call failed.
    pub fn is_sound(&self) -> bool {
        self.lost == 0 && self.dropped == 0 && self.failed_calls == 0
    }
}

/// The call of the operating system that failed on a real board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Call {
    /// Claiming lines or opening the device.
    Open,
    /// Driving lines.
    Write,
    /// Reading lines or events.
    Read,
    /// Changing the device's settings.
    Configure,
}

/// Why a board did not do what it was asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BoardError {
    /// [`Board::start`] was not called yet.
    NotStarted,
    /// Outputs are latched at their safe values until the next start.
    Latched,
    /// The board has no such channel.
    NoChannel(ChannelId),
    /// The board cannot drive this channel.
    NotDriven(ChannelId),
    /// The value does not fit the channel: a level for an analog one, a number for a digital one, not finite.
    BadValue(ChannelId),
    /// This fault cannot be injected on this channel.
    NoSuchFault(ChannelId),
    /// A time of the fault is not above 0, or ends beyond the range of time.
    BadFaultTime(ChannelId),
    /// The channel has as many faults at once as can be.
    TooManyFaults {
        /// Which channel.
        channel: ChannelId,
        /// The limit.
        limit: u8,
    },
    /// A fault on one channel that may not be there together with one on another.
    FaultsApart {
        /// Where it was to be.
        channel: ChannelId,
        /// Where the other one is.
        other: ChannelId,
    },
    /// The call is older than one that was answered already.
    Backwards {
        /// Time of this call.
        now: Time,
        /// Time of the newest call before it.
        last: Time,
    },
    /// More changes in one call, or more on their way through delays, than the board holds: an oscillating
    /// circuit or a delay far longer than the pulses that it carries.
    Storm {
        /// When the limit was reached.
        at: Time,
        /// The limit.
        limit: u32,
    },
    /// The board has no such bus.
    NoBus(BusId),
    /// The frame does not fit the bus: too long, or CAN FD on a bus without it.
    BadFrame(BusId),
    /// The queue of the bus is full: it takes no frame before others are on the bus.
    BusFull(BusId),
    /// The device behind a channel is lost since before the start.
    Lost {
        /// The first of its channels.
        channel: ChannelId,
        /// Why.
        reason: LossReason,
        /// For how long, as far as that is known.
        since: Span,
    },
    /// The device of a bus is lost since before the start.
    BusLost {
        /// Which bus.
        bus: BusId,
        /// Why.
        reason: LossReason,
        /// For how long, as far as that is known.
        since: Span,
    },
    /// A call of the operating system failed.
    Os {
        /// Which one.
        call: Call,
        /// Its error number, as in `errno`.
        code: i32,
    },
}

impl fmt::Display for BoardError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotStarted => write!(f, "the board is not started"),
            Self::Latched => {
                write!(f, "the outputs are latched at their safe values until the board is started again")
            }
            Self::NoChannel(id) => write!(f, "the board has no channel {}", id.0),
            Self::NotDriven(id) => write!(f, "the board cannot drive channel {}", id.0),
            Self::BadValue(id) => write!(f, "the value does not fit channel {}", id.0),
            Self::NoSuchFault(id) => write!(f, "this fault cannot be injected on channel {}", id.0),
            Self::BadFaultTime(id) => write!(f, "the times of a fault on channel {} must be above 0", id.0),
            Self::TooManyFaults { channel, limit } => {
                write!(f, "channel {} has {limit} faults already: clear it first", channel.0)
            }
            Self::FaultsApart { channel, other } => {
                write!(f, "channel {} takes no fault while one is on channel {}", channel.0, other.0)
            }
            Self::Backwards { now, last } => write!(f, "a call at {now} comes after one at {last}"),
            Self::Storm { at, limit } => {
                write!(f, "more than {limit} changes at once at {at}: look for wires that oscillate")
            }
            Self::NoBus(id) => write!(f, "the board has no bus {}", id.0),
            Self::BadFrame(id) => write!(f, "the frame does not fit bus {}", id.0),
            Self::BusFull(id) => write!(f, "the queue of bus {} is full", id.0),
            Self::Lost { channel, reason, since } => {
                write!(f, "channel {} is lost for {since}: its device {reason}", channel.0)
            }
            Self::BusLost { bus, reason, since } => {
                write!(f, "bus {} is lost for {since}: its device {reason}", bus.0)
            }
            Self::Os { call, code } => {
                let call = match call {
                    Call::Open => "claiming the lines",
                    Call::Write => "driving the lines",
                    Call::Read => "reading the lines",
                    Call::Configure => "setting up the device",
                };
                write!(f, "{call} failed with error number {code}")
            }
        }
    }
}

impl std::error::Error for BoardError {}

/// A board: the rig's terminals, simulated or real.
///
/// Time is an argument and never goes backwards from call to call. Calls do not wait for anything and, once the
/// board has run for a while, do not allocate.
///
/// With the model as subject the model's output terminals are written by [`Board::write`] and every line,
/// those included, is reported by [`Board::poll`]: what a plan sees of `%QX0.4` is the line behind the terminal,
/// with its wires and faults. With an external controller only its inputs are written.
pub trait Board: Send + fmt::Debug {
    /// The board's channels; a [`ChannelId`] is a place in this slice. Fixed from the making of the board.
    fn channels(&self) -> &[Channel];

    /// Claims the lines, drives safe values, forgets faults, events and health of what was before, and lifts the
    /// latch of [`Board::safe`]. The value of every sensed channel at `now` is the first that a poll reports.
    ///
    /// # Errors
    /// [`BoardError::Os`] where a device refuses.
    fn start(&mut self, now: Time) -> Result<(), BoardError>;

    /// Drives the channels to these values, all at once; [`Value::HighZ`] lets go. Later entries for the same
    /// channel win. Changes that the board had due before `now` happen first; those due at `now` happen after.
    ///
    /// # Errors
    /// Nothing is written where one entry is refused: [`BoardError::NoChannel`], [`BoardError::NotDriven`],
    /// [`BoardError::BadValue`], [`BoardError::Latched`], [`BoardError::NotStarted`], [`BoardError::Backwards`],
    /// [`BoardError::Storm`], [`BoardError::Os`].
    fn write(&mut self, now: Time, writes: &[(ChannelId, Value)]) -> Result<(), BoardError>;

    /// Appends to `out` all that happened up to and including `now` and was not reported yet, oldest first.
    ///
    /// # Errors
    /// [`BoardError::NotStarted`], [`BoardError::Backwards`], [`BoardError::Storm`], [`BoardError::Os`]. What had
    /// happened before the error is in `out`.
    fn poll(&mut self, now: Time, out: &mut Vec<BoardEvent>) -> Result<(), BoardError>;

    /// When the board will next have something to report if nobody writes: an instant already passed where a
    /// report is waiting. `None`: never by itself, and always for a real board, whose poll waits on readiness.
    fn next_event(&self) -> Option<Time>;

    /// Injects a fault from `now` on.
    ///
    /// # Errors
    /// [`BoardError::NoSuchFault`] where the channel's [`Channel::faults`] lacks it, [`BoardError::BadValue`],
    /// [`BoardError::BadFaultTime`], [`BoardError::TooManyFaults`], and as [`Board::write`].
    fn inject(&mut self, now: Time, fault: Fault) -> Result<(), BoardError>;

    /// Ends every injected fault of the channel, if it has any.
    ///
    /// # Errors
    /// [`BoardError::NoChannel`], and as [`Board::write`].
    fn clear(&mut self, now: Time, channel: ChannelId) -> Result<(), BoardError>;

    /// The longest that a fault on this channel takes to come or to go, beyond the call of a device: the time of a relay.
    /// A fault that lasts less than twice as long cannot be injected.
    fn settle(&self, channel: ChannelId) -> Span {
        let _ = channel;
        Span::ZERO
    }

    /// When the faults of this channel came to be what was asked for last; `None` while that is not known yet, because
    /// a relay moves, and where faults take no time.
    fn came(&self, channel: ChannelId) -> Option<When> {
        let _ = channel;
        None
    }

    /// Drives every driven line to its safe value and latches it there until the next start.
    ///
    /// # Errors
    /// [`BoardError::Os`]; the lines that could be made safe are.
    fn safe(&mut self, now: Time) -> Result<(), BoardError>;

    /// What went wrong since the start.
    fn health(&self) -> Health;

    /// The device behind a channel in words, as in `/dev/gpiochip0 (pinctrl-bcm2711)`. `None` where there is none.
    fn device(&self, channel: ChannelId) -> Option<&str> {
        let _ = channel;
        None
    }

    /// The device of a bus in words, as in `can0`. `None` where there is none.
    fn bus_device(&self, bus: BusId) -> Option<&str> {
        let _ = bus;
        None
    }

    /// The board's buses; a [`BusId`] is a place in this slice. Fixed from the making of the board.
    fn buses(&self) -> &[Bus] {
        &[]
    }

    /// Puts a frame into the queue of a bus. It is on the bus when [`Board::poll_buses`] tells it as its own.
    ///
    /// # Errors
    /// [`BoardError::NoBus`], [`BoardError::BadFrame`], [`BoardError::BusFull`], [`BoardError::Latched`],
    /// [`BoardError::NotStarted`], [`BoardError::Backwards`], [`BoardError::Os`].
    fn send(&mut self, now: Time, bus: BusId, frame: &Frame) -> Result<(), BoardError> {
        let _ = (now, frame);
        Err(BoardError::NoBus(bus))
    }

    /// As [`Board::poll`], of what the buses have to tell. [`Board::next_event`] speaks for both.
    ///
    /// # Errors
    /// As [`Board::poll`].
    fn poll_buses(&mut self, now: Time, out: &mut Vec<BusEvent>) -> Result<(), BoardError> {
        let _ = (now, out);
        Ok(())
    }

    /// A claim of their own on the output lines, for whoever makes them safe when the rig cannot any more. Empty for a
    /// board without real lines.
    ///
    /// # Errors
    /// [`BoardError::Os`] where the claim cannot be shared.
    fn held(&self) -> Result<Vec<HeldLines>, BoardError> {
        Ok(Vec::new())
    }

    /// The channel of this name.
    fn find(&self, name: &str) -> Option<ChannelId> {
        let place = self.channels().iter().position(|channel| channel.name == name)?;
        u16::try_from(place).ok().map(ChannelId)
    }
}

impl<B: Board + ?Sized> Board for Box<B> {
    fn channels(&self) -> &[Channel] {
        (**self).channels()
    }
    fn start(&mut self, now: Time) -> Result<(), BoardError> {
        (**self).start(now)
    }
    fn write(&mut self, now: Time, writes: &[(ChannelId, Value)]) -> Result<(), BoardError> {
        (**self).write(now, writes)
    }
    fn poll(&mut self, now: Time, out: &mut Vec<BoardEvent>) -> Result<(), BoardError> {
        (**self).poll(now, out)
    }
    fn next_event(&self) -> Option<Time> {
        (**self).next_event()
    }
    fn inject(&mut self, now: Time, fault: Fault) -> Result<(), BoardError> {
        (**self).inject(now, fault)
    }
    fn clear(&mut self, now: Time, channel: ChannelId) -> Result<(), BoardError> {
        (**self).clear(now, channel)
    }
    fn settle(&self, channel: ChannelId) -> Span {
        (**self).settle(channel)
    }
    fn came(&self, channel: ChannelId) -> Option<When> {
        (**self).came(channel)
    }
    fn safe(&mut self, now: Time) -> Result<(), BoardError> {
        (**self).safe(now)
    }
    fn health(&self) -> Health {
        (**self).health()
    }
    fn held(&self) -> Result<Vec<HeldLines>, BoardError> {
        (**self).held()
    }
    fn device(&self, channel: ChannelId) -> Option<&str> {
        (**self).device(channel)
    }
    fn bus_device(&self, bus: BusId) -> Option<&str> {
        (**self).bus_device(bus)
    }
    fn buses(&self) -> &[Bus] {
        (**self).buses()
    }
    fn send(&mut self, now: Time, bus: BusId, frame: &Frame) -> Result<(), BoardError> {
        (**self).send(now, bus, frame)
    }
    fn poll_buses(&mut self, now: Time, out: &mut Vec<BusEvent>) -> Result<(), BoardError> {
        (**self).poll_buses(now, out)
    }
}
