//! The handle of a rig that runs, as the control socket holds it. None of its calls waits for the scan.

use super::describe;
use super::directory::Directory;
use super::fault;
use super::plan_reading::{PlanReadings, PlanRequest, PlansRead};
use super::plans::{PlanBench, PlanSlot};
use super::status::StatusSource;
use crate::application::taken_values::TakenValues;
use crate::scan_port::{HandleEnd, OrderOutcome, ScanCommand, ScanEvent, ScanRequest};
use control::{
    Description, FrameSeen, Greeting, PROTOCOL, PlanEvent, PlanStatus, RequestFault, Signal, Status,
};
use host::Bell;
use services::control::{Answer, MOST_ORDERS, Rig, RigEvent, RigOrder, Ticket};
use signal::{Value, When};
use std::collections::{BTreeSet, VecDeque};
use std::sync::Arc;

/// Sources that can be watched at once.
pub(super) const MOST_WATCHED: usize = 1_024;

/// How a source is watched.
#[derive(Clone, Copy, Debug, Default)]
struct Watched {
    /// As often as clients want it.
    wanted: u32,
    /// The scan knows of it.
    known: bool,
    last: Option<(When, Value)>,
}

/// How plans are chosen, and where those that were wait.
#[derive(Debug)]
pub(super) struct PlanOrders {
    pub bench: Option<Arc<PlanBench>>,
    pub slot: PlanSlot,
}

/// The handle.
pub struct LiveRig {
    pub(super) ends: HandleEnd,
    pub(super) bell: Arc<Bell>,
    pub(super) description: Description,
    pub(super) version: String,
    pub(super) directory: Directory,
    pub(super) instruments: StatusSource,
    /// By source.
    watched: Vec<Watched>,
    /// How often each signal is wanted.
    signals: Vec<u32>,
    /// Sources that are watched, or will be.
    watching: usize,
    /// Sources of which the scan does not know yet how they are wanted.
    stale: BTreeSet<u32>,
    /// Requests that found no room.
    waiting: VecDeque<ScanRequest>,
    /// What is reported with the next call although the scan does not report it.
    own: Vec<RigEvent>,
    outcomes: Vec<(u64, OrderOutcome)>,
    orders: PlanOrders,
    readings: PlanReadings,
    plan: Option<PlanStatus>,
    ended: bool,
}

impl std::fmt::Debug for LiveRig {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("LiveRig").field("board", &self.description.board).finish_non_exhaustive()
    }
}

impl LiveRig {
    pub(super) fn new(
        ends: HandleEnd,
        bell: Arc<Bell>,
        description: Description,
        version: &str,
        directory: Directory,
        instruments: StatusSource,
        orders: PlanOrders,
    ) -> LiveRig {
        LiveRig {
            watched: vec![Watched::default(); directory.most()],
            signals: vec![0; directory.most()],
            ends,
            bell,
            description,
            version: version.to_owned(),
            directory,
            instruments,
            watching: 0,
            stale: BTreeSet::new(),
            waiting: VecDeque::with_capacity(MOST_ORDERS),
            own: Vec::new(),
            outcomes: Vec::new(),
            orders,
            readings: PlanReadings::default(),
            plan: None,
            ended: false,
        }
    }

    /// Hands the scan what waits for it, as far as there is room.
    fn flush(&mut self) {
        let mut rings = false;
        while let Some(source) = self.stale.first().copied() {
            let place = source as usize;
            let wanted = self.watched.get(place).is_some_and(|watched| watched.wanted > 0);
            let of = self.directory.of(source);
            let (Some(watched), Some(of)) = (self.watched.get_mut(place), of) else {
                self.stale.pop_first();
                continue;
            };
            if watched.known != wanted {
                let request =
                    if wanted { ScanRequest::Watch(source, of) } else { ScanRequest::Unwatch(source) };
                if self.ends.requests.push(request).is_err() {
                    break;
                }
                watched.known = wanted;
                rings = true;
            }
            self.stale.pop_first();
        }
        // An order sees what was watched before it.
        while self.stale.is_empty()
            && let Some(request) = self.waiting.pop_front()
        {
            if let Err(rtrb::PushError::Full(request)) = self.ends.requests.push(request) {
                self.waiting.push_front(request);
                break;
            }
            rings = true;
        }
        if rings {
            self.bell.ring();
        }
    }

    /// The order with its names resolved.
    fn command(&self, order: &RigOrder) -> Result<ScanCommand, RequestFault> {
        let source = |signal: u32| {
            let found = self.directory.source(signal);
            found.ok_or_else(|| fault::unknown(&signal.to_string(), None)).map(|(_, of)| of)
        };
        let terminal = |signal: u32| {
            let name = self.directory.signal(signal).map_or("", |signal| signal.name.as_str());
            self.directory
                .forced_place(signal)
                .ok_or_else(|| fault::not_forced(name))
                .map(|found| (found, name))
        };
        Ok(match *order {
            RigOrder::Read(signal) => ScanCommand::Read(source(signal)?),
            RigOrder::Write(signal, value) => {
                ScanCommand::Write(source(signal)?, self.directory.fitting(signal, value)?)
            }
            RigOrder::Force(signal, value) => {
                let (address, name) = terminal(signal)?;
                let taken = TakenValues::of_place(address);
                let forced = taken.forced(value);
                let value = forced.ok_or_else(|| fault::bad_value(name, &taken.to_string()))?;
                ScanCommand::Force(address, value)
            }
            RigOrder::Release(signal) => ScanCommand::Release(terminal(signal)?.0),
            RigOrder::ReleaseAll => ScanCommand::ReleaseAll,
            RigOrder::Command(action) => ScanCommand::Command(action),
            RigOrder::Advance(by) => ScanCommand::Advance(by),
            // Its words do not go into the scan: the plan waits in its slot.
            RigOrder::Plan(_) | RigOrder::Plans(_) => return Err(fault::no_plans()),
            RigOrder::Abort => ScanCommand::Abort,
        })
    }

    /// Has plans read for an order, which may take its time.
    fn read_plans(&mut self, ticket: Ticket, request: PlanRequest) -> Result<(), RequestFault> {
        let bench = self.orders.bench.as_ref().ok_or_else(fault::no_plans)?;
        let chooses = matches!(request, PlanRequest::Choose(_));
        if chooses && (self.readings.is_choosing() || self.plan.is_some()) {
            return Err(fault::plan_runs());
        }
        self.readings.begin(ticket.0, bench, request)
    }

    /// Takes what was read.
    fn take_plans(&mut self, report: &mut dyn FnMut(RigEvent)) {
        for (ticket, answer) in self.readings.ended() {
            let answer = match answer {
                Ok(PlansRead::Chosen(chosen)) => {
                    self.orders.slot.put(*chosen);
                    self.waiting.push_back(ScanRequest::Command(ticket, ScanCommand::Plan));
                    continue;
                }
                Ok(PlansRead::Listed(names)) => Ok(Answer::Plans(names)),
                Err(fault) => Err(fault),
            };
            report(RigEvent::Answer(Ticket(ticket), answer));
        }
    }

    fn receive_plan_event(&mut self, event: PlanEvent, report: &mut dyn FnMut(RigEvent)) {
        match &event {
            PlanEvent::Case { name, place, .. } => {
                self.plan = Some(PlanStatus::of(name, *place));
            }
            PlanEvent::Over { .. } => self.plan = None,
            _ => {}
        }
        report(RigEvent::Plan(event));
    }

    fn frame(&self, bus: drivers::BusId, at: signal::Time, frame: &signal::CanFrame, own: bool) -> FrameSeen {
        let info = self.description.buses.get(usize::from(bus.0));
        describe::frame(info, at, frame, own)
    }

    fn serial(&self, bus: drivers::BusId, message: &signal::SerialMessage, own: bool) -> FrameSeen {
        let info = self.description.buses.get(usize::from(bus.0));
        describe::serial_message(info, message, own)
    }
}

impl Rig for LiveRig {
    fn greeting(&self) -> Greeting {
        Greeting {
            rig: "scanrig".into(),
            protocol: PROTOCOL,
            version: self.version.clone(),
            board: self.description.board.clone(),
            reference: self.description.reference.clone(),
            client: 0,
        }
    }

    fn describe(&self) -> Description {
        self.description.clone()
    }

    fn status(&self) -> Status {
        Status { plan: self.plan.clone(), ..self.instruments.status(&self.description) }
    }

    fn find(&mut self, name: &str) -> Result<Signal, RequestFault> {
        self.directory.find(name)
    }

    fn watch(&mut self, signal: u32) -> Result<(), RequestFault> {
        let Some((source, _)) = self.directory.source(signal) else {
            return Err(fault::unknown(&signal.to_string(), None));
        };
        let (Some(watched), Some(count)) =
            (self.watched.get_mut(source as usize), self.signals.get_mut(signal as usize))
        else {
            return Err(fault::too_many("signals"));
        };
        if watched.wanted == 0 {
            if self.watching >= MOST_WATCHED {
                return Err(fault::too_many(&format!("{MOST_WATCHED} signals are watched")));
            }
            self.watching += 1;
            self.stale.insert(source);
        } else if *count == 0
            && let Some((at, value)) = watched.last
        {
            // Another name of what is watched already.
            self.own.push(RigEvent::Change { signal, at, value });
        }
        watched.wanted += 1;
        *count += 1;
        Ok(())
    }

    fn unwatch(&mut self, signal: u32) {
        let Some((source, _)) = self.directory.source(signal) else { return };
        let (Some(watched), Some(count)) =
            (self.watched.get_mut(source as usize), self.signals.get_mut(signal as usize))
        else {
            return;
        };
        if *count == 0 {
            return;
        }
        *count -= 1;
        watched.wanted -= 1;
        if watched.wanted == 0 {
            watched.last = None;
            self.watching -= 1;
            self.stale.insert(source);
        }
    }

    fn last(&self, signal: u32) -> Option<(When, Value)> {
        let (source, _) = self.directory.source(signal)?;
        self.watched.get(source as usize)?.last
    }

    fn order(&mut self, ticket: Ticket, order: RigOrder) -> Result<(), RequestFault> {
        let order = match order {
            RigOrder::Plan(name) => return self.read_plans(ticket, PlanRequest::Choose(name)),
            RigOrder::Plans(path) => return self.read_plans(ticket, PlanRequest::List(path)),
            order => order,
        };
        let command = self.command(&order)?;
        if self.waiting.len() >= MOST_ORDERS {
            return Err(fault::too_many("orders wait"));
        }
        self.waiting.push_back(ScanRequest::Command(ticket.0, command));
        self.flush();
        Ok(())
    }

    fn poll(&mut self, report: &mut dyn FnMut(RigEvent)) {
        self.take_plans(report);
        self.flush();
        for own in self.own.drain(..) {
            report(own);
        }
        let gone = self.ends.events.is_abandoned();
        // What is answered by now was reported before.
        while let Ok(outcome) = self.ends.outcomes.pop() {
            self.outcomes.push(outcome);
        }
        while let Ok(event) = self.ends.events.pop() {
            match event {
                ScanEvent::Change(source, at, value) => {
                    let Some(watched) = self.watched.get_mut(source as usize) else { continue };
                    if watched.wanted == 0 {
                        continue;
                    }
                    watched.last = Some((at, value));
                    for signal in self.directory.shown(source) {
                        if self.signals.get(*signal as usize).is_some_and(|count| *count > 0) {
                            report(RigEvent::Change { signal: *signal, at, value });
                        }
                    }
                }
                ScanEvent::Log(at, text) => report(RigEvent::Log(at, text)),
                ScanEvent::Frame(bus, at, frame, own) => {
                    report(RigEvent::Frame(self.frame(bus, at, &frame, own)))
                }
                ScanEvent::SerialMessage(bus, message, own) => {
                    report(RigEvent::Frame(self.serial(bus, &message, own)))
                }
                ScanEvent::Step(step, at, done) => {
                    report(RigEvent::Plan(PlanEvent::Step { step, at: at.as_nanos(), done }));
                }
                ScanEvent::Plan(event) => self.receive_plan_event(*event, report),
            }
        }
        while let Ok(snapshot) = self.ends.full.pop() {
            if let Some(back) = self.instruments.take(snapshot) {
                // It came from there.
                let _ = self.ends.empty.push(back);
            }
        }
        for (ticket, outcome) in self.outcomes.drain(..) {
            let answer = match outcome {
                Ok(Some(value)) => Ok(Answer::Value(value)),
                Ok(None) => Ok(Answer::Done),
                Err(why) => Err(fault::refused(why)),
            };
            report(RigEvent::Answer(Ticket(ticket), answer));
        }
        self.instruments.look_at_host();
        // A rig that is led may wait for room.
        if self.description.clock == control::TimeSource::Stepped {
            self.bell.ring();
        }
        if gone && !std::mem::replace(&mut self.ended, true) {
            report(RigEvent::Ended("the rig ends".into()));
        }
    }
}
