//! Orders that are under way: whose they are, and whose turn it is to give the next one.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use control::RequestFault;
use signal::Time;

use super::client::ClientId;
use super::forces::ForcedBy;
use super::hub::Hub;
use super::log_limit::LogTopic;
use super::rig::{Answer, MOST_ORDERS, RigOrder, Ticket};

/// Orders that are under way.
#[derive(Debug, Default)]
pub(super) struct Orders {
    /// The orders that are given and not answered.
    open: BTreeMap<Ticket, OpenOrder>,
    last: u64,
    /// Orders of the rig's own, for clients that are gone.
    own: VecDeque<RigOrder>,
    /// Who has orders to give.
    waiting: BTreeSet<ClientId>,
    /// Who gave the last one.
    served: ClientId,
}

/// An order that is given.
#[derive(Debug)]
struct OpenOrder {
    /// By whom; none for the rig's own.
    by: Option<ClientId>,
    /// The address that it forces, and who had forced it before.
    forces: Option<(String, Option<ForcedBy>)>,
    /// What it releases.
    releases: Releases,
}

#[derive(Debug)]
enum Releases {
    None,
    One(String),
    All,
}

impl Orders {
    /// Whether orders wait to be given or answered.
    pub(super) fn any(&self) -> bool {
        !self.open.is_empty() || !self.own.is_empty() || !self.waiting.is_empty()
    }

    /// A client has orders to give.
    pub(super) fn ask(&mut self, client: ClientId) {
        self.waiting.insert(client);
    }

    /// The rig itself has one.
    pub(super) fn add_own(&mut self, order: RigOrder) {
        self.own.push_back(order);
    }

    /// A client is gone.
    pub(super) fn forget(&mut self, client: ClientId) {
        self.waiting.remove(&client);
    }

    /// Who is next: everyone gives one order, then it begins again.
    fn next(&self) -> Option<ClientId> {
        self.waiting.range(self.served + 1..).next().or(self.waiting.first()).copied()
    }
}

impl Hub {
    /// Gives the rig as many orders as it takes.
    pub(super) fn give(&mut self, now: Time) {
        while self.orders.open.len() < MOST_ORDERS && !self.over {
            let by = if self.orders.own.is_empty() { self.orders.next() } else { None };
            let order = match by {
                None => self.orders.own.pop_front(),
                Some(id) => {
                    self.orders.served = id;
                    let work = self.clients.get_mut(&id).and_then(|client| client.work.as_mut());
                    work.and_then(|work| work.orders.pop_front())
                }
            };
            let Some(order) = order else {
                // Nothing at all, or a client without orders.
                match by {
                    None => return,
                    Some(id) => self.orders.forget(id),
                }
                continue;
            };
            self.give_one(by, order, now);
        }
    }

    fn give_one(&mut self, by: Option<ClientId>, order: RigOrder, now: Time) {
        self.orders.last += 1;
        let ticket = Ticket(self.orders.last);
        if let Some(work) = self.work_of(by) {
            work.open += 1;
        }
        match self.rig.order(ticket, order.clone()) {
            Ok(()) => {
                let given = self.note(by, &order);
                self.orders.open.insert(ticket, given);
            }
            Err(fault) => self.carried_out(by, Err(fault), now),
        }
    }

    /// Notes who forces what.
    fn note(&mut self, by: Option<ClientId>, order: &RigOrder) -> OpenOrder {
        let mut given = OpenOrder { by, forces: None, releases: Releases::None };
        match (order, by) {
            (RigOrder::Force(signal, _), Some(client)) => {
                let by = ForcedBy { client, signal: *signal };
                let address = self.addresses.get(signal).cloned().unwrap_or_default();
                let before = self.forces.insert(address.clone(), by);
                given.forces = Some((address, before));
            }
            (RigOrder::Release(signal), _) => {
                given.releases = Releases::One(self.addresses.get(signal).cloned().unwrap_or_default());
            }
            (RigOrder::ReleaseAll, _) => given.releases = Releases::All,
            _ => {}
        }
        given
    }

    /// An order is answered.
    pub(super) fn answered(&mut self, ticket: Ticket, answer: Result<Answer, RequestFault>, now: Time) {
        let Some(given) = self.orders.open.remove(&ticket) else { return };
        self.status_cache.fresh = false;
        let OpenOrder { by, forces, releases } = given;
        match (&answer, forces, releases) {
            (Err(_), Some((address, before)), _) => {
                match before {
                    Some(by) => self.forces.insert(address, by),
                    None => self.forces.remove(&address),
                };
            }
            (Ok(_), _, Releases::One(address)) => {
                self.forces.remove(&address);
            }
            (Ok(_), _, Releases::All) => self.forces.clear(),
            _ => {}
        }
        self.carried_out(by, answer, now);
    }

    /// An order of a client, or of the rig itself, is carried out or refused.
    fn carried_out(&mut self, by: Option<ClientId>, answer: Result<Answer, RequestFault>, now: Time) {
        let Some(id) = by else {
            if let Err(fault) = answer {
                let text = format!("for a client that is gone: {} ({})", fault.message, fault.code);
                self.say(LogTopic::Actions, &text, now);
            }
            return;
        };
        let Some(work) = self.work_of(by) else { return };
        work.open = work.open.saturating_sub(1);
        match answer {
            Ok(Answer::Value(value)) => work.values.push(value),
            Ok(Answer::Plans(plans)) => work.plans = plans,
            Ok(Answer::Done) => {}
            Err(fault) => {
                // What follows would be done in vain: the request has failed.
                work.orders.clear();
                work.fault.get_or_insert(fault);
            }
        }
        if work.open == 0 && work.orders.is_empty() {
            self.orders.forget(id);
            self.complete(id, now);
        }
    }

    pub(super) fn work_of(&mut self, by: Option<ClientId>) -> Option<&mut super::client::Work> {
        by.and_then(|id| self.clients.get_mut(&id)).and_then(|client| client.work.as_mut())
    }
}
