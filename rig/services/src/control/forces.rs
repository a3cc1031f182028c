//! Who forced what, and what becomes of it when a client is gone.

use control::{ControllerAction, RequestFault, Signal};
use signal::Time;

use super::client::ClientId;
use super::hub::Hub;
use super::rig::RigOrder;
use super::settings::OnDisconnect;

/// Who forced something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ForcedBy {
    /// The client.
    pub(super) client: ClientId,
    /// The signal, as it was named.
    pub(super) signal: u32,
}

impl Hub {
    /// The signal of a name that is to be forced or released. A terminal and its address are two names of one thing.
    pub(super) fn find_forced(&mut self, name: &str) -> Result<Signal, RequestFault> {
        let signal = self.rig.find(name)?;
        let is = |one: &Option<String>| one.as_deref() == Some(&*signal.name);
        let mut points = self.description.points.iter();
        let point = points.find(|point| point.name == signal.name || is(&point.address) || is(&point.image));
        let address = point.and_then(|point| point.address.clone()).unwrap_or_else(|| signal.name.clone());
        self.addresses.insert(signal.number, address);
        Ok(signal)
    }

    /// The signals that a client forced.
    pub(super) fn forced_by(&self, id: ClientId) -> impl Iterator<Item = u32> + '_ {
        self.forces.values().filter(move |by| by.client == id).map(|by| by.signal)
    }

    /// A client is gone: its forces stay or end as the settings or its goodbye say.
    pub(super) fn settle_forces(&mut self, id: ClientId, now: Time) {
        let forced: Vec<u32> = self.forced_by(id).collect();
        self.forces.retain(|_, by| by.client != id);
        let goodbye = self.clients.get(&id).is_some_and(|client| client.goodbye);
        if forced.is_empty() || goodbye || self.over {
            return;
        }
        let count = forced.len();
        let policy = self.settings.on_disconnect;
        if policy != OnDisconnect::Keep && self.lock.now().is_some() {
            return self.say_of(id, &format!("forced {count}, which stay: the rig is locked"), now);
        }
        match policy {
            OnDisconnect::Keep => self.say_of(id, &format!("forced {count}, which stay"), now),
            OnDisconnect::Release => self.say_of(id, &format!("forced {count}, which are released"), now),
            OnDisconnect::Stop => {
                let text = format!("forced {count}, which are released, and the application is stopped");
                self.say_of(id, &text, now);
            }
        }
        if policy == OnDisconnect::Keep {
            return;
        }
        if policy == OnDisconnect::Stop {
            self.orders.add_own(RigOrder::Command(ControllerAction::Stop));
        }
        for signal in forced {
            self.orders.add_own(RigOrder::Release(signal));
        }
        self.give(now);
    }

    /// Adds to what is forced who forced it.
    pub(super) fn name_forces(&mut self) {
        let mut forced = std::mem::take(&mut self.status_cache.status.forced);
        for one in &mut forced {
            let by = self.forces.get(&one.address).map(|by| by.client);
            one.by = by.filter(|id| self.clients.contains_key(id)).map(|id| self.called(id));
        }
        self.status_cache.status.forced = forced;
    }
}
