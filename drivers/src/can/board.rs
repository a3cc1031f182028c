//! The CAN buses of a board.

use document::Diagnostic;
use host::HostInstant;
use rustix::io::Errno;
use signal::{CanFrame, SerialOutput, SerialSettings, Span, Time, Value};

use super::adapter::{Adapter, Interface};
use super::configure::NotSetUp;
use super::find::find;
use super::node::Node;
use super::shared::ThreadConfig;
use super::spec::{CanBusSpec, CanSpec};
use crate::channel_table::ChannelTable;
use crate::codes;
use crate::run_state::{RunState, START, drives_none};
use crate::{
    Board, BoardContext, BoardError, BoardEvent, Bus, BusEvent, BusId, Buses, Call, Channel, ChannelId,
    DeviceLimits, Health,
};

/// How long an interface may take to be put back as it was.
const PUT_BACK: Span = Span::from_secs(5);

/// How often a start looks for an interface that is wanted back.
const LOOK: Span = Span::from_millis(50);

/// CAN interfaces as a board. Its calls never wait for an interface, but for its start and its safe state: a thread of
/// each talks to it.
#[derive(Debug)]
pub struct CanBoard {
    context: BoardContext,
    limits: DeviceLimits,
    channels: Vec<Channel>,
    buses: Vec<Bus>,
    nodes: Vec<Node>,
    run: RunState,
}

impl CanBoard {
    /// Finds the interfaces of a board's buses, checks how they are set up, and opens them.
    ///
    /// # Errors
    /// All that is not there, down, set up otherwise or not permitted, by place.
    pub fn open(
        table: &ChannelTable,
        spec: &CanSpec,
        limits: DeviceLimits,
        context: &BoardContext,
    ) -> Result<CanBoard, Vec<Diagnostic>> {
        let mut board = CanBoard::without_buses(table, spec, limits, context);
        let mut found = Vec::new();
        for bus in &spec.buses {
            if let Err(wrong) = find(&table.file, bus).and_then(|()| board.add(&table.file, bus)) {
                found.push(wrong);
            }
        }
        if found.is_empty() { Ok(board) } else { Err(found) }
    }

    fn without_buses(
        table: &ChannelTable,
        spec: &CanSpec,
        limits: DeviceLimits,
        context: &BoardContext,
    ) -> CanBoard {
        let mut buses = Vec::new();
        super::describe(spec, &mut buses);
        for bus in &spec.buses {
            buses[usize::from(bus.bus.0)].resolution = context.resolution;
        }
        CanBoard {
            context: context.clone(),
            limits,
            channels: table.blank(),
            buses,
            nodes: Vec::new(),
            run: RunState::default(),
        }
    }

    /// Opens the interface of a bus and starts its thread.
    fn add(&mut self, file: &str, bus: &CanBusSpec) -> Result<(), Diagnostic> {
        let refused = |error: std::io::Error| {
            let message = format!("the interface {} cannot be opened: {error}", bus.interface);
            let help = "see what `ip -details link show` says of it";
            Diagnostic::error(codes::CAN_REFUSED, message)
                .at(file.to_owned(), bus.interface_place.clone(), "")
                .help(help)
        };
        let cannot = |why: NotSetUp| {
            let name = &bus.interface;
            let (message, help) = match why {
                NotSetUp::Refused(error) => (
                    format!("{name} cannot be set up as the board file says: {error}"),
                    "see by `ip -details link show` what its controller can do",
                ),
                NotSetUp::Differs(differ) => (
                    format!("{name} was set up, and differs from the board file: {}", differ.join("; ")),
                    "write bit rates and sample points that its clock can be divided to",
                ),
            };
            Diagnostic::error(codes::CAN_CANNOT, message)
                .at(file.to_owned(), bus.interface_place.clone(), "")
                .help(help)
        };
        let mut interface = Interface::new(bus).map_err(refused)?;
        interface.prepare().map_err(cannot)?;
        let (port, _) = interface.open().map_err(refused)?;
        // What the rig has set up it puts back as it was, and controllers take their time.
        let end = if bus.configure {
            self.limits.unresponsive_after.max(PUT_BACK)
        } else {
            self.limits.unresponsive_after
        };
        let config = ThreadConfig {
            resolution: self.context.resolution,
            limit: self.limits.unresponsive_after,
            patience: end,
            reconnect: self.limits.reconnect,
            realtime: self.context.realtime,
        };
        let adapter = Box::new(interface);
        let node = Node::start(bus.clone(), adapter, port, &self.context.bell, config);
        self.nodes.push(node.map_err(refused)?);
        Ok(())
    }
}

impl Board for CanBoard {
    fn inner(&self) -> Option<&dyn Board> {
        None
    }

    fn inner_mut(&mut self) -> Option<&mut dyn Board> {
        None
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Waits for the interfaces, as long as one may be silent or two seconds.
    fn start(&mut self, now: Time) -> Result<(), BoardError> {
        self.run.end();
        let starts: Vec<u64> = self.nodes.iter_mut().map(Node::ask_start).collect();
        let unresponsive_after = self.limits.unresponsive_after.max(START);
        let patience = || HostInstant::now() + unresponsive_after;
        let due = patience();
        for (node, start) in self.nodes.iter_mut().zip(starts) {
            let mut begun = node.await_start(start, due);
            // An interface that is wanted back may be on its way, and so may a controller that is off its bus, or whose
            // frames of the last run go when somebody acknowledges them.
            let wanted = |node: &Node, begun| match begun {
                true => node.is_behind(),
                false => self.limits.reconnect && node.gone(),
            };
            while wanted(node, begun) && HostInstant::now() < due {
                node.wait(due.min(HostInstant::now() + LOOK));
                let start = node.ask_start();
                // What is asked last gets as long for its answer as what was asked first.
                begun = node.await_start(start, patience());
            }
            if !begun {
                return Err(node.loss());
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

    /// What lies ahead of the last poll, and when an interface whose answer is due counts as lost.
    fn next_event(&self) -> Option<Time> {
        let deadlines = self.nodes.iter().filter_map(Node::overdue);
        self.run.next_event(&self.context.time, deadlines)
    }

    /// Nothing is sent from now on. What the kernel has already may still reach the bus.
    fn safe(&mut self, now: Time) -> Result<(), BoardError> {
        self.run.latch(now);
        let asked: Vec<u64> = self.nodes.iter_mut().map(Node::ask_safe).collect();
        let due = HostInstant::now() + self.limits.unresponsive_after;
        let mut outcome = Ok(());
        for (node, asked) in self.nodes.iter().zip(asked) {
            if !node.await_safe(asked, due) {
                let code = Errno::TIMEDOUT.raw_os_error();
                outcome = outcome.and(Err(BoardError::Os { call: Call::Write, code }));
            }
        }
        outcome
    }

    fn health(&self) -> Health {
        Health {
            lost: self.nodes.iter().filter(|node| node.is_lost()).count() as u32,
            dropped: self.nodes.iter().map(|node| node.dropped).sum(),
            failed_calls: self.nodes.iter().map(Node::failed).sum(),
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

impl Buses for CanBoard {
    fn bus_list(&self) -> &[Bus] {
        &self.buses
    }

    fn bus_device(&self, bus: BusId) -> Option<&str> {
        self.nodes.iter().find(|node| node.spec.bus == bus).map(|node| node.spec.interface.as_str())
    }

    fn send(&mut self, now: Time, bus: BusId, frame: &CanFrame) -> Result<(), BoardError> {
        self.run.drive_at(now)?;
        let stamp = self.context.time.stamp(now);
        let node = self.nodes.iter_mut().find(|node| node.spec.bus == bus).ok_or(BoardError::NoBus(bus))?;
        node.send(stamp, frame)
    }

    fn send_serial(&mut self, now: Time, bus: BusId, _output: &SerialOutput) -> Result<(), BoardError> {
        self.run.drive_at(now)?;
        let known = self.nodes.iter().any(|node| node.spec.bus == bus);
        Err(if known { BoardError::BadFrame(bus) } else { BoardError::NoBus(bus) })
    }

    fn configure(
        &mut self,
        now: Time,
        bus: BusId,
        _settings: &SerialSettings,
        _message_gap: Span,
    ) -> Result<(), BoardError> {
        self.run.drive_at(now)?;
        let known = self.nodes.iter().any(|node| node.spec.bus == bus);
        Err(if known { BoardError::BadSettings(bus) } else { BoardError::NoBus(bus) })
    }

    fn break_off(&mut self, now: Time, bus: BusId) -> Result<(), BoardError> {
        self.run.drive_at(now)?;
        // What is sent is its thread's, and the kernel's.
        if self.nodes.iter().any(|node| node.spec.bus == bus) { Ok(()) } else { Err(BoardError::NoBus(bus)) }
    }

    fn poll_buses(&mut self, now: Time, out: &mut Vec<BusEvent>) -> Result<(), BoardError> {
        self.run.come_to(now)?;
        let first = out.len();
        for node in &mut self.nodes {
            node.poll(&self.context.time, now, out);
        }
        crate::event_collector::sort_by(&mut out[first..], BusEvent::latest);
        self.run.lies_ahead(self.nodes.iter().filter_map(|node| node.ahead).min());
        Ok(())
    }
}
