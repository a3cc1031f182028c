//! A rig that does what it is asked: signals `m0` to `m999`, orders that are carried out at the next turn, and a clock
//! that clients step where the test wants it.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard};

use control::{
    Description, ForcedPoint, FrameSeen, Greeting, PROTOCOL, PlanEvent, PointDirection, PointInfo,
    RequestFault, Signal, SignalKind, Status, TimeSource, WireValue,
};
use scanrig_services::control::{Answer, MOST_ORDERS, Rig, RigEvent, RigOrder, Ticket};
use signal::{Time, Value, When};

/// How many signals there are.
pub const SIGNALS: u32 = 1_000;

/// The rig as the test holds it.
#[derive(Clone, Default)]
pub struct Fake(Arc<Mutex<State>>);

#[derive(Default)]
pub struct State {
    pub led: bool,
    /// Nothing is carried out.
    pub hangs: bool,
    pub now: i64,
    pub values: BTreeMap<u32, Value>,
    pub watched: BTreeMap<u32, usize>,
    pub forced: BTreeMap<u32, Value>,
    pub orders: VecDeque<(Ticket, RigOrder)>,
    /// What was carried out.
    pub done: Vec<RigOrder>,
    pub reported: Vec<RigEvent>,
    pub state: String,
}

impl Fake {
    pub fn led() -> Fake {
        let fake = Fake::default();
        fake.state().led = true;
        fake
    }

    pub fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().expect("nobody panicked")
    }

    /// A signal changes.
    pub fn change(&self, signal: u32, value: Value) {
        self.state().change(signal, value);
    }

    pub fn log(&self, text: &str) {
        let mut state = self.state();
        let now = Time::from_nanos(state.now);
        state.reported.push(RigEvent::Log(now, text.into()));
    }

    pub fn frame(&self, frame: FrameSeen) {
        self.state().reported.push(RigEvent::Frame(frame));
    }

    pub fn plan(&self, event: PlanEvent) {
        self.state().reported.push(RigEvent::Plan(event));
    }
}

impl State {
    fn change(&mut self, signal: u32, value: Value) {
        self.values.insert(signal, value);
        if self.watched.contains_key(&signal) {
            let at = When::exactly(Time::from_nanos(self.now));
            self.reported.push(RigEvent::Change { signal, at, value });
        }
    }

    fn carry_out(&mut self, order: &RigOrder) -> Result<Answer, RequestFault> {
        match *order {
            RigOrder::Read(signal) => return Ok(Answer::Value(self.value(signal))),
            RigOrder::Write(_, Value::Unknown) => return Err(refused("nothing to write")),
            RigOrder::Write(signal, value) => self.change(signal, value),
            RigOrder::Force(_, Value::Unknown) => return Err(refused("nothing to force")),
            RigOrder::Force(signal, value) => {
                self.forced.insert(signal % SIGNALS, value);
            }
            RigOrder::Release(signal) => {
                self.forced.remove(&(signal % SIGNALS));
            }
            RigOrder::ReleaseAll => self.forced.clear(),
            RigOrder::Advance(by) => {
                // Signal 0 counts milliseconds.
                for _ in 0..by.as_nanos() / 1_000_000 {
                    self.now += 1_000_000;
                    self.change(0, Value::Int(self.now / 1_000_000));
                }
            }
            RigOrder::Command(action) => self.state = action.name().into(),
            RigOrder::Plans(ref path) => {
                return Ok(Answer::Plans(vec![path.clone().unwrap_or_else(|| "shipped".into())]));
            }
            RigOrder::Plan(_) | RigOrder::Abort => {}
        }
        Ok(Answer::Done)
    }

    fn value(&self, signal: u32) -> Value {
        self.values.get(&signal).copied().unwrap_or(Value::Int(0))
    }
}

impl Rig for Fake {
    fn greeting(&self) -> Greeting {
        Greeting {
            rig: "scanrig".into(),
            protocol: PROTOCOL,
            version: "0.0.0".into(),
            board: "fake".into(),
            reference: "TM241CEC24T".into(),
            client: 0,
        }
    }

    fn describe(&self) -> Description {
        let clock = if self.state().led { TimeSource::Stepped } else { TimeSource::Real };
        let point = PointInfo {
            name: "t5".into(),
            address: Some("m5".into()),
            variable: None,
            direction: PointDirection::Output,
            kind: SignalKind::Bool,
            channel: None,
            image: Some("m5".into()),
            forcible: true,
            writable: false,
            scale: None,
        };
        Description { board: "fake".into(), clock, points: vec![point], ..Description::default() }
    }

    fn status(&self) -> Status {
        let state = self.state();
        let forced = state.forced.iter().map(|(signal, value)| ForcedPoint {
            address: format!("m{signal}"),
            value: WireValue(*value),
            by: None,
        });
        Status { at: state.now, state: state.state.clone(), forced: forced.collect(), ..Status::default() }
    }

    fn find(&mut self, name: &str) -> Result<Signal, RequestFault> {
        if name == "t5" {
            // What is on the line of a terminal is another signal than its image.
            return Ok(Signal { number: SIGNALS + 5, name: name.into(), ..self.find("m5")? });
        }
        let number = name.strip_prefix('m').and_then(|digits| digits.parse().ok());
        let Some(number) = number.filter(|number| *number < SIGNALS) else {
            return Err(refused(&format!("there is no {name}")));
        };
        Ok(Signal {
            number,
            name: format!("m{number}"),
            kind: SignalKind::Int,
            unit: String::new(),
            labels: Vec::new(),
            writable: true,
        })
    }

    fn watch(&mut self, signal: u32) -> Result<(), RequestFault> {
        if signal == SIGNALS - 1 {
            return Err(refused("that is one too many"));
        }
        *self.state().watched.entry(signal).or_default() += 1;
        Ok(())
    }

    fn unwatch(&mut self, signal: u32) {
        let mut state = self.state();
        let times = state.watched.get_mut(&signal).expect("what is not watched cannot be left");
        *times -= 1;
        if *times == 0 {
            state.watched.remove(&signal);
        }
    }

    fn last(&self, _: u32) -> Option<(When, Value)> {
        None
    }

    fn order(&mut self, ticket: Ticket, order: RigOrder) -> Result<(), RequestFault> {
        let mut state = self.state();
        assert!(state.orders.len() < MOST_ORDERS, "more orders than agreed");
        if order == RigOrder::Plan("unknown".into()) {
            return Err(refused("there is no such plan"));
        }
        state.orders.push_back((ticket, order));
        Ok(())
    }

    fn poll(&mut self, reported: &mut dyn FnMut(RigEvent)) {
        let mut state = self.state();
        while !state.hangs
            && let Some((ticket, order)) = state.orders.pop_front()
        {
            let answer = state.carry_out(&order);
            state.done.push(order);
            state.reported.push(RigEvent::Answer(ticket, answer));
        }
        for one in std::mem::take(&mut state.reported) {
            reported(one);
        }
    }
}

pub fn refused(message: &str) -> RequestFault {
    RequestFault { code: "R0600".into(), message: message.into(), help: String::new() }
}
