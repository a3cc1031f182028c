//! The hub: all clients and the rig, without a socket and without a clock. Bytes come in, bytes go out, instants of the
//! host's clock are arguments.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fmt;
use std::rc::Rc;

use control::{
    Description, Greeting, PlanEvent, Reply, RequestFault, RigLogLine, Status, SubscriptionEvent, TimeSource,
};
use signal::{Span, Time};

use super::client::{ClientConnection, ClientId, LoggedClient, Peer};
use super::decode::{decode, fault};
use super::forces::ForcedBy;
use super::lines::ClientLine;
use super::lock::Lock;
use super::log_limit::{LogLimit, LogTopic};
use super::orders::Orders;
use super::rig::{Rig, RigEvent};
use super::settings::SocketSettings;
use crate::codes;
use control::LONGEST_LINE;

/// Requests of a client that are done before others have their turn.
const REQUESTS: usize = 16;

/// All clients and the rig.
pub struct Hub {
    pub(super) rig: Box<dyn Rig>,
    pub(super) settings: SocketSettings,
    pub(super) description: Description,
    pub(super) lock: Lock,
    pub(super) clients: BTreeMap<ClientId, ClientConnection>,
    /// How many have connected.
    connected: u64,
    pub(super) orders: Orders,
    /// Who watches a signal: client and subscription.
    pub(super) watched: BTreeMap<u32, BTreeSet<(ClientId, u64)>>,
    /// Who forced what, by its address.
    pub(super) forces: BTreeMap<String, ForcedBy>,
    /// The addresses of signals that were named to be forced or released.
    pub(super) addresses: BTreeMap<u32, String>,
    pub(super) status_cache: StatusCache,
    pub(super) log: VecDeque<RigLogLine>,
    write: Box<dyn FnMut(&str)>,
    log_limit: LogLimit,
    /// What the case that runs has reported.
    pub(super) plan: Vec<PlanEvent>,
    events: Vec<RigEvent>,
    /// Who has something to send or to do.
    pub(super) touched: BTreeSet<ClientId>,
    pub(super) over: bool,
}

/// The status as it was last looked at.
#[derive(Default)]
pub(super) struct StatusCache {
    pub(super) status: Status,
    /// It is still so.
    pub(super) fresh: bool,
    /// Counts the statuses that differ in more than their instant.
    pub(super) edition: u64,
    /// As it stands in a line.
    pub(super) line: Option<Rc<str>>,
}

impl Hub {
    /// A hub without clients. What it has to say goes to `write`, line by line, and to whoever subscribes to the log.
    pub fn new(rig: Box<dyn Rig>, settings: SocketSettings, write: Box<dyn FnMut(&str)>) -> Hub {
        let mut description = rig.describe();
        description.on_disconnect = settings.on_disconnect.name().into();
        let mut hub = Hub {
            lock: Lock::read(settings.state.as_deref(), &settings.socket),
            rig,
            settings,
            description,
            clients: BTreeMap::new(),
            connected: 0,
            orders: Orders::default(),
            watched: BTreeMap::new(),
            forces: BTreeMap::new(),
            addresses: BTreeMap::new(),
            status_cache: StatusCache::default(),
            log: VecDeque::new(),
            write,
            log_limit: LogLimit::default(),
            plan: Vec::new(),
            events: Vec::new(),
            touched: BTreeSet::new(),
            over: false,
        };
        // A lock that outlasted the rig before, or whose file cannot be read: else the first client that is refused says so.
        if let Err(locked) = hub.lock.check() {
            (hub.write)(&locked.message);
        }
        hub
    }

    /// Somebody connects.
    ///
    /// # Errors
    /// The line to send to somebody who is one too many.
    pub fn connect(&mut self, peer: Peer, now: Time) -> Result<ClientId, Vec<u8>> {
        let most = self.settings.limits.clients;
        if self.clients.len() >= most || self.over {
            let message =
                if self.over { "the rig ends".into() } else { format!("{most} clients are connected") };
            let help = "end one of them, or raise `clients` under `[control]` of the board file";
            let refusal =
                Reply { id: None, ok: None, error: Some(fault(codes::CLIENTS, message.clone(), help)) };
            let text = format!("a client of user {} is refused: {message}", peer.user);
            self.say(LogTopic::Connections, &text, now);
            let mut line = serde_json::to_vec(&refusal).unwrap_or_default();
            line.push(b'\n');
            return Err(line);
        }
        self.connected += 1;
        let id = self.connected;
        let mut client = ClientConnection::new(peer);
        client.out.put(&Greeting { client: id, ..self.rig.greeting() }, now);
        self.clients.insert(id, client);
        self.status_cache.fresh = false;
        self.touch(id);
        self.say_of_connection(id, "connects", now);
        Ok(id)
    }

    /// The connection is lost or at its end.
    pub fn disconnect(&mut self, id: ClientId, now: Time) {
        if !self.clients.contains_key(&id) {
            return;
        }
        self.say_of_connection(id, "is gone", now);
        self.settle_forces(id, now);
        let Some(client) = self.clients.remove(&id) else { return };
        for (number, subscription) in &client.subscriptions {
            self.unwatch(id, *number, subscription.numbers());
        }
        self.orders.forget(id);
        self.status_cache.fresh = false;
    }

    /// Bytes of a client.
    pub fn receive(&mut self, id: ClientId, bytes: &[u8]) {
        if let Some(client) = self.clients.get_mut(&id) {
            client.lines.put(bytes);
            client.starved = false;
        }
    }

    /// A client sends nothing more. What it asked for is still answered, then the connection ends.
    pub fn input_is_over(&mut self, id: ClientId) {
        if let Some(client) = self.clients.get_mut(&id) {
            client.lines.end();
            client.starved = false;
        }
    }

    /// Whether bytes of a client are to be taken now. Else they stay with the kernel, and its own sending waits.
    pub fn wants_input(&self, id: ClientId) -> bool {
        self.clients.get(&id).is_some_and(|client| client.starved && self.may_ask(client))
    }

    /// What waits to be sent to a client.
    pub fn output(&self, id: ClientId) -> &[u8] {
        self.clients.get(&id).map_or(&[], |client| client.out.waiting())
    }

    /// So many bytes were sent.
    pub fn sent(&mut self, id: ClientId, bytes: usize, now: Time) {
        if let Some(client) = self.clients.get_mut(&id) {
            client.out.forward(bytes, now);
        }
    }

    /// Whether a connection is to be closed.
    pub fn is_done(&self, id: ClientId) -> bool {
        self.clients.get(&id).is_none_or(|client| {
            client.cut || client.leaves && client.work.is_none() && client.out.is_empty()
        })
    }

    /// Does what a client asked for, as much as is its share; reports whether more is left that can be done at once.
    pub fn work(&mut self, id: ClientId, now: Time) -> bool {
        for _ in 0..REQUESTS {
            let Some(client) = self.clients.get(&id).filter(|client| self.may_ask(client)) else {
                return false;
            };
            if client.starved {
                return false;
            }
            let Some(client) = self.clients.get_mut(&id) else { return false };
            match client.lines.next() {
                Some(line) => self.line(id, line, now),
                None => {
                    client.starved = true;
                    if client.lines.is_over() {
                        client.leaves = true;
                        self.touch(id);
                    }
                    return false;
                }
            }
        }
        true
    }

    /// Takes what the rig reports, gives it orders, and reports to clients.
    pub fn turn(&mut self, now: Time) {
        self.status_cache.fresh = false;
        let mut events = std::mem::take(&mut self.events);
        let queue = self.settings.limits.queue;
        let waits = |client: &ClientConnection| client.leads() && !client.cut && client.out.len() >= queue;
        // A rig in stepped time stands still while what it reported finds no room.
        if !self.is_stepped() || !self.clients.values().any(waits) {
            self.rig.poll(&mut |one| events.push(one));
        }
        for one in events.drain(..) {
            self.receive_event(one, now);
        }
        self.events = events;
        self.settle_lock(now);
        self.say_left_out(now);
        self.give(now);
        self.flush(now);
        let patience =
            i64::try_from(self.settings.limits.patience.as_nanos()).map_or(Span::MAX, Span::from_nanos);
        let stuck = |client: &ClientConnection| {
            !client.cut && client.stuck_since().is_some_and(|since| now - since >= patience)
        };
        let stuck: Vec<ClientId> =
            self.clients.iter().filter(|(_, client)| stuck(client)).map(|(id, _)| *id).collect();
        for id in stuck {
            self.say_of(id, "does not read what it is sent, and is cut off", now);
            if let Some(client) = self.clients.get_mut(&id) {
                client.cut = true;
            }
            self.touch(id);
        }
    }

    /// How long the next turn may wait.
    pub fn pause(&self) -> Span {
        if self.is_busy() {
            Span::from_millis(1)
        } else if self.clients.values().any(|client| !client.subscriptions.is_empty()) {
            Span::from_millis(10)
        } else {
            Span::from_millis(50)
        }
    }

    /// Whether orders wait for their answers, or the lock for its file.
    pub fn is_busy(&self) -> bool {
        self.orders.any() || self.lock.is_busy()
    }

    /// The rig ends: everyone is informed, and what was not done will not be.
    pub fn end(&mut self, why: &str, now: Time) {
        if std::mem::replace(&mut self.over, true) {
            return;
        }
        let ids: Vec<ClientId> = self.clients.keys().copied().collect();
        for id in ids {
            self.orders.forget(id);
            let Some(client) = self.clients.get_mut(&id) else { continue };
            if let Some(work) = client.work.take() {
                let fault = fault(codes::OVER, format!("the rig ended: {why}"), "start it again");
                client.out.answer(&Reply { id: Some(work.id), ok: None, error: Some(fault) }, now);
            }
            client.out.put(&SubscriptionEvent::Gone { why: why.into() }, now);
            client.leaves = true;
            self.touch(id);
        }
    }

    /// Whether the rig has ended.
    pub fn is_over(&self) -> bool {
        self.over
    }

    /// How many clients there are.
    pub fn clients(&self) -> usize {
        self.clients.len()
    }

    /// Those who have something to send or to do since the last call.
    pub fn touched(&mut self) -> BTreeSet<ClientId> {
        std::mem::take(&mut self.touched)
    }

    pub(super) fn touch(&mut self, id: ClientId) {
        self.touched.insert(id);
    }

    /// Time stands still until a client asks for more of it.
    pub(super) fn is_stepped(&self) -> bool {
        self.description.clock == TimeSource::Stepped
    }

    /// Writes a line into the log, unless there were too many of its topic within a second.
    pub(super) fn say(&mut self, topic: LogTopic, text: &str, now: Time) {
        if self.log_limit.admits(topic, now) {
            self.say_in_any_case(text, now);
        }
    }

    fn say_in_any_case(&mut self, text: &str, now: Time) {
        (self.write)(text);
        let at = self.current_status().status.at;
        self.log(at, text, now);
    }

    /// Says how many lines were left out.
    fn say_left_out(&mut self, now: Time) {
        for topic in LogTopic::ALL {
            if let Some(lines) = self.log_limit.take_left_out(topic, now) {
                self.say_in_any_case(&topic.left_out(lines), now);
            }
        }
    }

    /// Writes into the log what a client does.
    pub(super) fn say_of(&mut self, id: ClientId, does: &str, now: Time) {
        self.say_of_client(LogTopic::Actions, id, does, now);
    }

    /// Writes into the log that a client comes or goes.
    pub(super) fn say_of_connection(&mut self, id: ClientId, does: &str, now: Time) {
        self.say_of_client(LogTopic::Connections, id, does, now);
    }

    fn say_of_client(&mut self, topic: LogTopic, id: ClientId, does: &str, now: Time) {
        if let Some(client) = self.clients.get(&id) {
            let text = format!("{} {does}", LoggedClient(id, client));
            self.say(topic, &text, now);
        }
    }

    /// Answers a client.
    pub(super) fn answer(
        &mut self,
        id: ClientId,
        number: u64,
        what: Result<&impl serde::Serialize, RequestFault>,
        now: Time,
    ) {
        let Some(client) = self.clients.get_mut(&id) else { return };
        match what {
            Ok(ok) => client.out.answer(&Answered { id: number, ok }, now),
            Err(error) => client.out.answer(&Reply { id: Some(number), ok: None, error: Some(error) }, now),
        }
        self.touch(id);
    }

    /// Whether the next request of a client can be looked at.
    fn may_ask(&self, client: &ClientConnection) -> bool {
        client.work.is_none()
            && !client.leaves
            && !client.cut
            && client.out.len() < self.settings.limits.queue
    }

    fn line(&mut self, id: ClientId, line: ClientLine, now: Time) {
        let refused = match line {
            ClientLine::Whole(bytes) => match decode(&bytes) {
                Ok(request) => return self.request(id, request, now),
                Err(refused) => Reply { id: refused.id, ok: None, error: Some(refused.fault) },
            },
            ClientLine::TooLong => {
                let message = format!("the line is longer than {LONGEST_LINE} bytes");
                let help = "split the request, as into several subscriptions";
                Reply { id: None, ok: None, error: Some(fault(codes::LINE, message, help)) }
            }
        };
        if let Some(client) = self.clients.get_mut(&id) {
            client.out.answer(&refused, now);
            self.touch(id);
        }
    }
}

impl fmt::Debug for Hub {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Hub")
            .field("settings", &self.settings)
            .field("clients", &self.clients)
            .finish_non_exhaustive()
    }
}

/// An answer, without a copy of what it holds.
#[derive(serde::Serialize)]
pub(super) struct Answered<'a, T> {
    pub(super) id: u64,
    pub(super) ok: &'a T,
}
