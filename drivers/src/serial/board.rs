//! The serial lines of a board.

use document::Diagnostic;
use host::HostInstant;
use rustix::io::Errno;
use signal::{CanFrame, SerialOutput, SerialSettings, Span, Time, Value};

use super::SerialSpec;
use super::handle::SerialHandle;
use crate::channel_table::ChannelTable;
use crate::run_state::{RunState, START, drives_none};
use crate::{
    Board, BoardContext, BoardError, BoardEvent, Bus, BusEvent, BusId, Buses, Call, Channel, ChannelId,
    DeviceLimits, Health,
};

/// The serial lines of a board: held for the rig alone while it lives, each by a thread of its own, which receives and
/// sends.
#[derive(Debug)]
pub struct SerialBoard {
    channels: Vec<Channel>,
    buses: Vec<Bus>,
    lines: Vec<SerialHandle>,
    context: BoardContext,
    limits: DeviceLimits,
    run: RunState,
}

impl SerialBoard {
    /// Opens the ports of a board.
    ///
    /// # Errors
    /// All that are not there, not free, not permitted or cannot do what is asked, by place.
    pub fn open(
        table: &ChannelTable,
        spec: &[SerialSpec],
        limits: DeviceLimits,
        context: &BoardContext,
    ) -> Result<SerialBoard, Vec<Diagnostic>> {
        let mut buses = Vec::new();
        super::describe(spec, &mut buses);
        let mut lines = Vec::with_capacity(spec.len());
        let mut found = Vec::new();
        for line in spec {
            match SerialHandle::open(&table.file, line, limits, context) {
                Ok(line) => lines.push(line),
                Err(refused) => found.extend(refused),
            }
        }
        if !found.is_empty() {
            return Err(found);
        }
        let (channels, context, run) = (table.blank(), context.clone(), RunState::default());
        Ok(SerialBoard { channels, buses, lines, context, limits, run })
    }
}

impl Board for SerialBoard {
    fn inner(&self) -> Option<&dyn Board> {
        None
    }

    fn inner_mut(&mut self) -> Option<&mut dyn Board> {
        None
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Waits for the ports, and for those that are being opened again, for two seconds or as long as one may be unresponsive.
    fn start(&mut self, now: Time) -> Result<(), BoardError> {
        self.run.end();
        let requests: Vec<u64> = self.lines.iter_mut().map(SerialHandle::ask_start).collect();
        let due = HostInstant::now() + self.limits.unresponsive_after.max(START);
        for (line, request) in self.lines.iter_mut().zip(requests) {
            if !line.await_start(request, due, self.limits.reconnect) {
                return Err(line.loss());
            }
        }
        self.run.begin(now);
        Ok(())
    }

    fn write(&mut self, now: Time, writes: &[(ChannelId, Value)]) -> Result<(), BoardError> {
        self.run.come_to(now)?;
        drives_none(&self.channels, writes)
    }

    fn poll(&mut self, now: Time, _out: &mut Vec<BoardEvent>) -> Result<(), BoardError> {
        self.run.come_to(now)
    }

    /// When a port whose call is under way counts as lost.
    fn next_event(&self) -> Option<Time> {
        let deadlines = self.lines.iter().filter_map(SerialHandle::overdue);
        self.run.next_event(&self.context.time, deadlines)
    }

    /// What waits is not sent, and what is being sent is cut off: a line that nobody sends on is idle. Waits for the ports,
    /// at most as long as one may be unresponsive.
    fn safe(&mut self, now: Time) -> Result<(), BoardError> {
        self.run.latch(now);
        let requests: Vec<u64> = self.lines.iter_mut().map(SerialHandle::ask_safe).collect();
        let due = HostInstant::now() + self.limits.unresponsive_after;
        let mut outcome = Ok(());
        for (line, request) in self.lines.iter().zip(requests) {
            if !line.await_safe(request, due) {
                let code = Errno::TIMEDOUT.raw_os_error();
                outcome = outcome.and(Err(BoardError::Os { call: Call::Write, code }));
            }
        }
        outcome
    }

    fn health(&self) -> Health {
        Health {
            lost: self.lines.iter().filter(|line| line.is_lost()).count() as u32,
            dropped: self.lines.iter().map(|line| line.dropped).sum(),
            failed_calls: self.lines.iter().map(SerialHandle::failed_calls).sum(),
            latched_safe: self.run.is_latched(),
            ..Health::default()
        }
    }

    fn buses(&self) -> Option<&dyn Buses> {
        Some(self)
    }

    fn buses_mut(&mut self) -> Option<&mut dyn Buses> {
        Some(self)
    }
}

impl Buses for SerialBoard {
    fn bus_list(&self) -> &[Bus] {
        &self.buses
    }

    fn bus_device(&self, bus: BusId) -> Option<&str> {
        self.lines.iter().find(|line| line.bus == bus).map(|line| line.device.as_str())
    }

    fn send(&mut self, now: Time, bus: BusId, _frame: &CanFrame) -> Result<(), BoardError> {
        self.run.come_to(now)?;
        let known = self.lines.iter().any(|line| line.bus == bus);
        Err(if known { BoardError::BadFrame(bus) } else { BoardError::NoBus(bus) })
    }

    fn send_serial(&mut self, now: Time, bus: BusId, output: &SerialOutput) -> Result<(), BoardError> {
        self.run.drive_at(now)?;
        let line = self.lines.iter_mut().find(|line| line.bus == bus).ok_or(BoardError::NoBus(bus))?;
        line.send(output)
    }

    fn configure(
        &mut self,
        now: Time,
        bus: BusId,
        settings: &SerialSettings,
        message_gap: Span,
    ) -> Result<(), BoardError> {
        self.run.drive_at(now)?;
        let line = self.lines.iter().find(|line| line.bus == bus).ok_or(BoardError::NoBus(bus))?;
        // Its board file says what the port was found to be able to do.
        if line.has(settings, message_gap) { Ok(()) } else { Err(BoardError::BadSettings(bus)) }
    }

    fn break_off(&mut self, now: Time, bus: BusId) -> Result<(), BoardError> {
        self.run.drive_at(now)?;
        // What is sent is its thread's, and the kernel's.
        if self.lines.iter().any(|line| line.bus == bus) { Ok(()) } else { Err(BoardError::NoBus(bus)) }
    }

    fn poll_buses(&mut self, now: Time, out: &mut Vec<BusEvent>) -> Result<(), BoardError> {
        self.run.come_to(now)?;
        let first = out.len();
        for line in &mut self.lines {
            line.poll(&self.context.time, now, out);
        }
        crate::event_collector::sort_by(&mut out[first..], BusEvent::latest);
        self.run.lies_ahead(self.lines.iter().filter_map(|line| line.ahead).min());
        Ok(())
    }
}
