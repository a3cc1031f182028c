//! The board of several devices.

use document::Diagnostic;
use signal::{CanFrame, SerialOutput, SerialSettings, Span, Time, Value};

use super::{RealSpec, channels, relays};
use crate::channel_table::ChannelTable;
use crate::event_collector::sort_by;
use crate::{
    Board, BoardContext, BoardError, BoardEvent, BoardExt, Bus, BusEvent, BusId, Buses, Channel, ChannelId,
    Descriptions, Emission, Health, OutputClaim, PulseOutputs,
};

/// Finds and claims the devices of a file, outputs at their safe values.
///
/// # Errors
/// All that is not there, not free, not permitted or cannot be done, by place.
pub fn open(
    table: &ChannelTable,
    spec: &RealSpec,
    context: &BoardContext,
) -> Result<Box<dyn Board>, Vec<Diagnostic>> {
    let mut board = RealBoard::new(channels(table, spec));
    let mut found = Vec::new();
    for devices in spec.devices.iter().filter(|devices| devices.is_used()) {
        match devices.open(table, spec.limits, context) {
            Ok(part) => board.add(part, devices.serves()),
            Err(more) => found.extend(more),
        }
    }
    if found.is_empty() { Ok(relays::around(board.alone(), spec, context)) } else { Err(found) }
}

/// Several devices as one board. Each is a board of its own that speaks of the channels and buses of the whole.
#[derive(Debug)]
pub struct RealBoard {
    channels: Vec<Channel>,
    buses: Vec<Bus>,
    parts: Vec<Box<dyn Board>>,
    /// The part behind each channel, and behind each bus.
    behind: Vec<Option<u16>>,
    carries: Vec<Option<u16>>,
    /// What one part is asked to write.
    writes: Vec<(ChannelId, Value)>,
}

impl RealBoard {
    /// A board whose channels are described, and which has no device yet.
    pub fn new(channels: Vec<Channel>) -> RealBoard {
        let (behind, writes) = (vec![None; channels.len()], Vec::with_capacity(channels.len()));
        RealBoard { channels, buses: Vec::new(), parts: Vec::new(), behind, carries: Vec::new(), writes }
    }

    /// Adds a device that serves these channels, and every bus that it describes: those of the whole board, of which a
    /// device leaves the names of others empty.
    pub fn add(&mut self, part: Box<dyn Board>, serves: impl IntoIterator<Item = ChannelId>) {
        let number = self.parts.len() as u16;
        for channel in serves {
            let at = usize::from(channel.0);
            self.channels[at] = part.channels()[at].clone();
            self.behind[at] = Some(number);
        }
        for (at, bus) in part.bus_list().iter().enumerate() {
            if self.buses.len() <= at {
                self.buses.push(bus.clone());
                self.carries.push(None);
            }
            if !bus.name.is_empty() {
                self.buses[at] = bus.clone();
                self.carries[at] = Some(number);
            }
        }
        self.parts.push(part);
    }

    /// The board: a device that is alone on it needs nobody to speak for it.
    pub fn alone(mut self) -> Box<dyn Board> {
        match self.parts.pop() {
            Some(only) if self.parts.is_empty() => only,
            Some(last) => {
                self.parts.push(last);
                Box::new(self)
            }
            None => Box::new(self),
        }
    }
}

impl Board for RealBoard {
    fn inner(&self) -> Option<&dyn Board> {
        None
    }

    fn inner_mut(&mut self) -> Option<&mut dyn Board> {
        None
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn start(&mut self, now: Time) -> Result<(), BoardError> {
        self.parts.iter_mut().try_for_each(|part| part.start(now))
    }

    fn write(&mut self, now: Time, writes: &[(ChannelId, Value)]) -> Result<(), BoardError> {
        for (channel, _) in writes {
            let behind = self.behind.get(usize::from(channel.0)).ok_or(BoardError::NoChannel(*channel))?;
            let of = &self.channels[usize::from(channel.0)];
            // A write ends what a channel emits by itself, even where it can be driven no other way.
            if behind.is_none() || !of.drives && of.emits.is_none() {
                return Err(BoardError::NotDriven(*channel));
            }
        }
        for (number, part) in self.parts.iter_mut().enumerate() {
            let mine = |channel: ChannelId| self.behind[usize::from(channel.0)] == Some(number as u16);
            self.writes.clear();
            self.writes.extend(writes.iter().copied().filter(|(channel, _)| mine(*channel)));
            if !self.writes.is_empty() {
                part.write(now, &self.writes)?;
            }
        }
        Ok(())
    }

    fn poll(&mut self, now: Time, out: &mut Vec<BoardEvent>) -> Result<(), BoardError> {
        let first = out.len();
        let mut outcome = Ok(());
        for part in &mut self.parts {
            outcome = outcome.and(part.poll(now, out));
        }
        sort_by(&mut out[first..], BoardEvent::latest);
        outcome
    }

    fn next_event(&self) -> Option<Time> {
        self.parts.iter().filter_map(|part| part.next_event()).min()
    }

    fn safe(&mut self, now: Time) -> Result<(), BoardError> {
        let mut outcome = Ok(());
        for part in &mut self.parts {
            let made = part.safe(now);
            outcome = outcome.and(made);
        }
        outcome
    }

    fn health(&self) -> Health {
        self.parts.iter().map(|part| part.health()).fold(Health::default(), Health::and)
    }

    fn output_claims(&self) -> Result<Vec<OutputClaim>, BoardError> {
        let mut all = Vec::new();
        for part in &self.parts {
            all.extend(part.output_claims()?);
        }
        Ok(all)
    }

    fn pulse_outputs(&mut self) -> Option<&mut dyn PulseOutputs> {
        Some(self)
    }

    fn descriptions(&self) -> Option<&dyn Descriptions> {
        Some(self)
    }

    fn buses(&self) -> Option<&dyn Buses> {
        Some(self)
    }

    fn buses_mut(&mut self) -> Option<&mut dyn Buses> {
        Some(self)
    }
}

impl PulseOutputs for RealBoard {
    fn emit(&mut self, now: Time, channel: ChannelId, emission: &Emission) -> Result<(), BoardError> {
        match self.behind.get(usize::from(channel.0)) {
            None => Err(BoardError::NoChannel(channel)),
            Some(None) => Err(BoardError::NotDriven(channel)),
            Some(Some(part)) => self.parts[usize::from(*part)].emit(now, channel, emission),
        }
    }
}

impl Descriptions for RealBoard {
    fn device(&self, channel: ChannelId) -> Option<&str> {
        let part = self.behind.get(usize::from(channel.0)).copied().flatten()?;
        self.parts[usize::from(part)].device(channel)
    }

    fn device_kind(&self, channel: ChannelId) -> Option<&'static str> {
        let part = self.behind.get(usize::from(channel.0)).copied().flatten()?;
        self.parts[usize::from(part)].device_kind(channel)
    }

    fn noise(&self, channel: ChannelId) -> Option<f64> {
        let part = self.behind.get(usize::from(channel.0)).copied().flatten()?;
        self.parts[usize::from(part)].noise(channel)
    }
}

impl Buses for RealBoard {
    fn bus_list(&self) -> &[Bus] {
        &self.buses
    }

    fn bus_device(&self, bus: BusId) -> Option<&str> {
        let part = self.carries.get(usize::from(bus.0)).copied().flatten()?;
        self.parts[usize::from(part)].bus_device(bus)
    }

    fn send(&mut self, now: Time, bus: BusId, frame: &CanFrame) -> Result<(), BoardError> {
        let part = self.carries.get(usize::from(bus.0)).copied().flatten().ok_or(BoardError::NoBus(bus))?;
        self.parts[usize::from(part)].send(now, bus, frame)
    }

    fn send_serial(&mut self, now: Time, bus: BusId, output: &SerialOutput) -> Result<(), BoardError> {
        let part = self.carries.get(usize::from(bus.0)).copied().flatten().ok_or(BoardError::NoBus(bus))?;
        self.parts[usize::from(part)].send_serial(now, bus, output)
    }

    fn configure(
        &mut self,
        now: Time,
        bus: BusId,
        settings: &SerialSettings,
        message_gap: Span,
    ) -> Result<(), BoardError> {
        let part = self.carries.get(usize::from(bus.0)).copied().flatten().ok_or(BoardError::NoBus(bus))?;
        self.parts[usize::from(part)].configure(now, bus, settings, message_gap)
    }

    fn break_off(&mut self, now: Time, bus: BusId) -> Result<(), BoardError> {
        let part = self.carries.get(usize::from(bus.0)).copied().flatten().ok_or(BoardError::NoBus(bus))?;
        self.parts[usize::from(part)].break_off(now, bus)
    }

    fn poll_buses(&mut self, now: Time, out: &mut Vec<BusEvent>) -> Result<(), BoardError> {
        let first = out.len();
        let mut outcome = Ok(());
        for part in &mut self.parts {
            outcome = outcome.and(part.poll_buses(now, out));
        }
        sort_by(&mut out[first..], BusEvent::latest);
        outcome
    }
}
