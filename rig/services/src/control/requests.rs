//! What is done for each request.

use std::collections::VecDeque;

use control::{
    Advanced, Done, Forces, Greeting, Locked, PROTOCOL, Plans, Request, RequestFault, RequestOperation,
    Signal, SignalChange, SignalValues, Subscribed, Topic, WireValue,
};
use signal::{Span, Time, Value, When};

use super::client::{ClientConnection, ClientId, Then, Work};
use super::decode::{fault, short};
use super::hub::Hub;
use super::log_limit::LogTopic;
use super::rig::RigOrder;
use super::topic::{Of, Subscription, Waiting};
use crate::codes;

/// What a request comes to at once.
enum Outcome {
    /// It is done.
    Done,
    /// It is done when these orders are.
    Orders(VecDeque<RigOrder>, Then),
    /// It is answered already.
    Answered,
}

impl Outcome {
    fn order(order: RigOrder) -> Outcome {
        Outcome::Orders([order].into(), Then::Done)
    }
}

impl Hub {
    /// Does what a client asks.
    pub(super) fn request(&mut self, id: ClientId, Request { id: number, ask }: Request, now: Time) {
        match self.ask(id, number, ask, now) {
            Ok(Outcome::Answered) => {}
            Ok(Outcome::Done) => {
                if self.is_stepped() {
                    self.flush_all(Some(id), now);
                }
                self.answer(id, number, Ok(&Done {}), now);
            }
            Ok(Outcome::Orders(orders, then)) => {
                let Some(client) = self.clients.get_mut(&id) else { return };
                let none = orders.is_empty();
                client.work = Some(Work::new(number, then, orders));
                if none {
                    self.complete(id, now);
                } else {
                    self.orders.ask(id);
                    self.give(now);
                }
            }
            Err(fault) => self.answer(id, number, Err::<&Done, _>(fault), now),
        }
    }

    fn ask(
        &mut self,
        id: ClientId,
        number: u64,
        ask: RequestOperation,
        now: Time,
    ) -> Result<Outcome, RequestFault> {
        if changes(&ask) {
            self.lock.check()?;
        }
        match ask {
            RequestOperation::Hello { protocol, name } => {
                return self.hello(id, number, protocol, &name, now);
            }
            RequestOperation::Describe => {
                let Some(client) = self.clients.get_mut(&id) else { return Ok(Outcome::Answered) };
                client.out.answer(&super::hub::Answered { id: number, ok: &self.description }, now);
                self.touch(id);
            }
            RequestOperation::Status => {
                let line = self.status_line();
                let Some(client) = self.clients.get_mut(&id) else { return Ok(Outcome::Answered) };
                client.out.answer_written(&[&format!("{{\"id\":{number},\"ok\":"), &line, "}"], now);
                self.touch(id);
            }
            RequestOperation::Read { names } => {
                self.few(names.len())?;
                let mut orders = VecDeque::new();
                for name in &names {
                    orders.push_back(RigOrder::Read(self.rig.find(name)?.number));
                }
                return Ok(Outcome::Orders(orders, Then::Values));
            }
            RequestOperation::Write { name, value } => {
                let signal = self.rig.find(&name)?.number;
                return Ok(Outcome::order(RigOrder::Write(signal, value.0)));
            }
            RequestOperation::Force { name, value } => {
                let signal = self.find_forced(&name)?;
                self.say_of(id, &format!("forces {} = {}", signal.name, shown(value)), now);
                return Ok(Outcome::order(RigOrder::Force(signal.number, value.0)));
            }
            RequestOperation::Release { name } => {
                let signal = self.find_forced(&name)?;
                self.say_of(id, &format!("releases {}", signal.name), now);
                return Ok(Outcome::order(RigOrder::Release(signal.number)));
            }
            RequestOperation::ReleaseAll => {
                self.say_of(id, "releases everything", now);
                return Ok(Outcome::order(RigOrder::ReleaseAll));
            }
            RequestOperation::Command { action } => {
                self.say_of(id, &format!("commands {}", action.name()), now);
                return Ok(Outcome::order(RigOrder::Command(action)));
            }
            RequestOperation::Subscribe { topic } => return self.subscribe(id, &topic, now),
            RequestOperation::Unsubscribe { subscription } => {
                let client = self.clients.get_mut(&id);
                let Some(ended) = client.and_then(|client| client.subscriptions.remove(&subscription)) else {
                    let message = format!("this connection has no subscription {subscription}");
                    let help = "a subscription is known by the number in the answer to `subscribe`";
                    return Err(fault(codes::SUBSCRIPTION, message, help));
                };
                self.unwatch(id, subscription, ended.numbers());
                return Ok(Outcome::Done);
            }
            RequestOperation::Plans { path } => {
                return Ok(Outcome::Orders([RigOrder::Plans(path)].into(), Then::Plans));
            }
            RequestOperation::Plan { name } => {
                self.say_of(id, &format!("runs the plan {}", short(&name)), now);
                return Ok(Outcome::order(RigOrder::Plan(name)));
            }
            RequestOperation::Abort => {
                self.say_of(id, "ends the plan", now);
                return Ok(Outcome::order(RigOrder::Abort));
            }
            RequestOperation::Lock { note } => {
                let by = self.called(id);
                return self.set_lock(id, number, Some(Locked { by, note: short(&note) }), now);
            }
            RequestOperation::Unlock => return self.set_lock(id, number, None, now),
            RequestOperation::Leave { forces } => {
                let mut orders = VecDeque::new();
                if forces == Forces::Release {
                    orders.extend(self.forced_by(id).map(RigOrder::Release));
                }
                if !orders.is_empty() {
                    self.lock.check()?;
                }
                return Ok(Outcome::Orders(orders, Then::Leave));
            }
            RequestOperation::Advance { by } => {
                let order = RigOrder::Advance(Span::from_nanos(by));
                return Ok(Outcome::Orders([order].into(), Then::Advanced));
            }
        }
        Ok(Outcome::Answered)
    }

    /// Locks the rig, or ends that. The answer comes once it is kept.
    fn set_lock(
        &mut self,
        id: ClientId,
        number: u64,
        to: Option<Locked>,
        now: Time,
    ) -> Result<Outcome, RequestFault> {
        let does = match &to {
            Some(Locked { note, .. }) => format!("locks the rig: {note}"),
            None => "unlocks the rig".into(),
        };
        if self.lock.set(to)? {
            self.locked(id, &does, now);
            return Ok(Outcome::Done);
        }
        if let Some(client) = self.clients.get_mut(&id) {
            client.work = Some(Work::new(number, Then::Locked(does), VecDeque::new()));
        }
        Ok(Outcome::Answered)
    }

    fn locked(&mut self, id: ClientId, does: &str, now: Time) {
        self.status_cache.fresh = false;
        self.say_of(id, does, now);
    }

    /// Answers who locked or unlocked the rig, once that is kept or failed.
    pub(super) fn settle_lock(&mut self, now: Time) {
        let Some(kept) = self.lock.poll() else { return };
        self.status_cache.fresh = false;
        let waits = |client: &ClientConnection| {
            client.work.as_ref().is_some_and(|work| matches!(work.then, Then::Locked(_)))
        };
        let Some(id) = self.clients.iter().find(|(_, client)| waits(client)).map(|(id, _)| *id) else {
            if kept.is_ok() {
                let now_is = if self.lock.now().is_some() { "locked" } else { "unlocked" };
                let text = format!("the rig is {now_is} for a client that is gone");
                self.say(LogTopic::Actions, &text, now);
            }
            return;
        };
        if let (Err(fault), Some(work)) = (kept, self.work_of(Some(id))) {
            work.fault = Some(fault);
        }
        self.complete(id, now);
    }

    fn hello(
        &mut self,
        id: ClientId,
        number: u64,
        protocol: u32,
        name: &str,
        now: Time,
    ) -> Result<Outcome, RequestFault> {
        if protocol != PROTOCOL {
            if let Some(client) = self.clients.get_mut(&id) {
                client.leaves = true;
            }
            let message = format!("the client speaks version {protocol} of the protocol, the rig {PROTOCOL}");
            return Err(fault(codes::PROTOCOL, message, "use the `rig` that the rig was started with"));
        }
        if let Some(client) = self.clients.get_mut(&id) {
            client.name = (!name.trim().is_empty()).then(|| short(name.trim()));
        }
        self.status_cache.fresh = false;
        self.say_of_connection(id, "says hello", now);
        let greeting = Greeting { client: id, ..self.rig.greeting() };
        self.answer(id, number, Ok(&greeting), now);
        Ok(Outcome::Answered)
    }

    fn subscribe(&mut self, id: ClientId, topic: &Topic, now: Time) -> Result<Outcome, RequestFault> {
        let limits = self.settings.limits;
        let Some(client) = self.clients.get(&id) else { return Ok(Outcome::Answered) };
        if client.subscriptions.len() >= limits.subscriptions {
            let message = format!("a client has at most {} subscriptions", limits.subscriptions);
            return Err(fault(
                codes::TOO_MUCH,
                message,
                "end one with `unsubscribe`, or put signals together",
            ));
        }
        let mut signals: Vec<Signal> = Vec::new();
        if let Topic::Signals { names, .. } = topic {
            self.few(client.names() + names.len())?;
            for name in names {
                signals.push(self.rig.find(name)?);
            }
        }
        let mut numbers: Vec<u32> = signals.iter().map(|signal| signal.number).collect();
        numbers.sort_unstable();
        numbers.dedup();
        for (place, &signal) in numbers.iter().enumerate() {
            if let Err(fault) = self.rig.watch(signal) {
                numbers[..place].iter().for_each(|&watched| self.rig.unwatch(watched));
                return Err(fault);
            }
        }
        // A value that nobody reported so far is read; it comes with the answer.
        let read: Vec<u32> =
            numbers.iter().copied().filter(|&signal| self.rig.last(signal).is_none()).collect();
        let orders = read.iter().map(|&signal| RigOrder::Read(signal)).collect();
        let Some(client) = self.clients.get_mut(&id) else { return Ok(Outcome::Answered) };
        client.subscribed += 1;
        let subscription = client.subscribed;
        for &signal in &numbers {
            self.watched.entry(signal).or_default().insert((id, subscription));
        }
        let mut begun = Subscription::new(topic, numbers, limits.changes, now);
        // Nothing is reported of it before the answer.
        begun.due = Time::MAX;
        client.subscriptions.insert(subscription, begun);
        Ok(Outcome::Orders(orders, Then::Subscribed { subscription, signals, read }))
    }

    /// All orders of a request are carried out, or one was refused.
    pub(super) fn complete(&mut self, id: ClientId, now: Time) {
        let Some(client) = self.clients.get_mut(&id) else { return };
        let Some(Work { id: number, then, values, plans, fault, .. }) = client.work.take() else { return };
        self.status_cache.fresh = false;
        if self.is_stepped() {
            // Whatever comes of the request is reported before its answer: so a client that leads time knows it all.
            self.flush_all(Some(id), now);
        }
        if let Some(fault) = fault {
            if let Then::Subscribed { subscription, .. } = then {
                self.end_subscription(id, subscription);
            }
            return self.answer(id, number, Err::<&Done, _>(fault), now);
        }
        match then {
            Then::Done => self.answer(id, number, Ok(&Done {}), now),
            Then::Locked(does) => {
                self.locked(id, &does, now);
                self.answer(id, number, Ok(&Done {}), now);
            }
            Then::Values => {
                let values = values.into_iter().map(WireValue).collect();
                self.answer(id, number, Ok(&SignalValues { values }), now);
            }
            Then::Plans => self.answer(id, number, Ok(&Plans { plans }), now),
            Then::Advanced => {
                let at = self.current_status().status.at;
                self.answer(id, number, Ok(&Advanced { at }), now);
            }
            Then::Subscribed { subscription, signals, read } => {
                let read: Vec<(u32, Value)> = read.into_iter().zip(values).collect();
                let begun = self.begin(id, subscription, signals, &read, now);
                self.answer(id, number, Ok(&begun), now);
            }
            Then::Leave => {
                self.answer(id, number, Ok(&Done {}), now);
                if let Some(client) = self.clients.get_mut(&id) {
                    (client.goodbye, client.leaves) = (true, true);
                }
            }
        }
    }

    /// The answer to a subscription. From now on its events come.
    fn begin(
        &mut self,
        id: ClientId,
        subscription: u64,
        signals: Vec<Signal>,
        read: &[(u32, Value)],
        now: Time,
    ) -> Subscribed {
        let latest = Time::from_nanos(self.current_status().status.at);
        let mut begun = Subscribed { subscription, signals, ..Subscribed::default() };
        let limits = self.settings.limits;
        let stepped = self.is_stepped();
        let subscriptions = self.clients.get_mut(&id).map(|client| &mut client.subscriptions);
        let Some(of) = subscriptions.and_then(|all| all.get_mut(&subscription)) else { return begun };
        of.due = if stepped { latest + of.every } else { now };
        match &mut of.of {
            Of::Signals { numbers, waiting } => {
                // What came meanwhile is in these values.
                *waiting = Waiting::new(if waiting.wants_all() { limits.changes } else { 0 });
                for &mut signal in numbers {
                    let read = read.iter().find(|(one, _)| *one == signal);
                    let known =
                        self.rig.last(signal).or(read.map(|(_, value)| (When::exactly(latest), *value)));
                    if let Some((at, value)) = known {
                        let (earliest, latest) = (at.earliest.as_nanos(), at.latest.as_nanos());
                        begun.values.push(SignalChange(signal, earliest, latest, WireValue(value)));
                    }
                }
            }
            Of::Log => begun.log = self.log.iter().cloned().collect(),
            Of::Plan => begun.plan = self.plan.clone(),
            Of::Status { .. } | Of::Frames => {}
        }
        begun
    }

    fn end_subscription(&mut self, id: ClientId, subscription: u64) {
        let ended = self.clients.get_mut(&id).and_then(|client| client.subscriptions.remove(&subscription));
        if let Some(ended) = ended {
            self.unwatch(id, subscription, ended.numbers());
        }
    }

    /// Ends the watch over signals of a subscription.
    pub(super) fn unwatch(&mut self, id: ClientId, subscription: u64, numbers: &[u32]) {
        for signal in numbers {
            if let Some(watchers) = self.watched.get_mut(signal) {
                watchers.remove(&(id, subscription));
                if watchers.is_empty() {
                    self.watched.remove(signal);
                }
            }
            self.rig.unwatch(*signal);
        }
    }

    /// Refuses more names than one client may have.
    fn few(&self, names: usize) -> Result<(), RequestFault> {
        let most = self.settings.limits.names;
        if names <= most {
            return Ok(());
        }
        let message = format!("{names} names are more than the {most} that a client may have");
        Err(fault(codes::TOO_MUCH, message, "ask for fewer at once, or end subscriptions"))
    }

    /// What a client is called where it is reported to others.
    pub(super) fn called(&self, id: ClientId) -> String {
        let name = self.clients.get(&id).and_then(|client| client.name.clone());
        name.unwrap_or_else(|| format!("client {id}"))
    }
}

/// Whether a request changes something that a lock freezes. To end a plan is always allowed: it leads to the safe side.
fn changes(ask: &RequestOperation) -> bool {
    match ask {
        RequestOperation::Write { .. }
        | RequestOperation::Force { .. }
        | RequestOperation::Release { .. }
        | RequestOperation::ReleaseAll
        | RequestOperation::Command { .. }
        | RequestOperation::Plan { .. }
        | RequestOperation::Lock { .. } => true,
        RequestOperation::Hello { .. }
        | RequestOperation::Describe
        | RequestOperation::Status
        | RequestOperation::Read { .. }
        | RequestOperation::Subscribe { .. }
        | RequestOperation::Unsubscribe { .. }
        | RequestOperation::Plans { .. }
        | RequestOperation::Abort
        | RequestOperation::Unlock
        | RequestOperation::Leave { .. }
        | RequestOperation::Advance { .. } => false,
    }
}

/// A value as it stands in a line.
fn shown(value: WireValue) -> String {
    serde_json::to_string(&value).unwrap_or_default()
}
