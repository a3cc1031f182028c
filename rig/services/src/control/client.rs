//! A client, as the hub knows it.

use std::collections::{BTreeMap, VecDeque};
use std::fmt;

use control::{RequestFault, Signal};
use signal::{Time, Value};

use super::lines::ClientLines;
use super::outbox::ClientOutbox;
use super::rig::RigOrder;
use super::topic::Subscription;

/// The number of a connection.
pub type ClientId = u64;

/// Who is at the other end of a connection, as the kernel says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Peer {
    /// The user.
    pub user: u32,
    /// The process, where it is known.
    pub process: Option<i32>,
}

/// A client.
#[derive(Debug)]
pub(super) struct ClientConnection {
    pub(super) peer: Peer,
    /// What it calls itself.
    pub(super) name: Option<String>,
    pub(super) lines: ClientLines,
    /// All that came is looked at: no whole line is left.
    pub(super) starved: bool,
    pub(super) out: ClientOutbox,
    /// The request that is under way: one at a time, so that answers come in the order of requests, a read sees the
    /// write before it, and whoever asks a thousand things at once does not keep others waiting.
    pub(super) work: Option<Work>,
    pub(super) subscriptions: BTreeMap<u64, Subscription>,
    /// The number of the last subscription.
    pub(super) subscribed: u64,
    /// The connection ends as soon as everything is sent.
    pub(super) leaves: bool,
    /// It said what becomes of its forces.
    pub(super) goodbye: bool,
    /// The connection ends at once.
    pub(super) cut: bool,
}

impl ClientConnection {
    pub(super) fn new(peer: Peer) -> ClientConnection {
        ClientConnection {
            peer,
            name: None,
            lines: ClientLines::default(),
            starved: true,
            out: ClientOutbox::default(),
            work: None,
            subscriptions: BTreeMap::new(),
            subscribed: 0,
            leaves: false,
            goodbye: false,
            cut: false,
        }
    }

    /// How many signals it is subscribed to.
    pub(super) fn names(&self) -> usize {
        self.subscriptions.values().map(|one| one.numbers().len()).sum()
    }

    /// Since when it has not read what it has to read: an answer; and anything if the connection is about to end, or if
    /// the rig's time waits for it.
    pub(super) fn stuck_since(&self) -> Option<Time> {
        self.out.stuck_since(self.leaves || self.leads())
    }

    /// It has asked for time that has not passed yet.
    pub(super) fn leads(&self) -> bool {
        self.work.as_ref().is_some_and(|work| matches!(work.then, Then::Advanced))
    }

    /// Whether events may be put into its queue. Whoever leads time is sent everything: time waits for it to read.
    pub(super) fn has_room(&self, queue: usize) -> bool {
        self.out.len() < queue || self.leads()
    }
}

/// A client as the log calls it.
pub(super) struct LoggedClient<'a>(pub(super) ClientId, pub(super) &'a ClientConnection);

impl fmt::Display for LoggedClient<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let LoggedClient(id, ClientConnection { peer, name, .. }) = self;
        write!(f, "client {id} (")?;
        if let Some(name) = name {
            write!(f, "{name}, ")?;
        }
        write!(f, "user {}", peer.user)?;
        if let Some(process) = peer.process {
            write!(f, ", process {process}")?;
        }
        f.write_str(")")
    }
}

/// A request that is under way.
#[derive(Debug)]
pub(super) struct Work {
    /// Its number.
    pub(super) id: u64,
    /// What its answer is made of.
    pub(super) then: Then,
    /// Orders that are not given yet.
    pub(super) orders: VecDeque<RigOrder>,
    /// Orders that are given and not answered.
    pub(super) open: usize,
    /// What was read, in the order in which it was asked.
    pub(super) values: Vec<Value>,
    /// What can be run.
    pub(super) plans: Vec<String>,
    /// What went wrong first.
    pub(super) fault: Option<RequestFault>,
}

impl Work {
    /// A request of this number of which nothing is done yet.
    pub(super) fn new(id: u64, then: Then, orders: VecDeque<RigOrder>) -> Work {
        Work { id, then, orders, open: 0, values: Vec::new(), plans: Vec::new(), fault: None }
    }
}

/// What becomes of a request when its orders are carried out.
#[derive(Debug)]
pub(super) enum Then {
    /// It is done.
    Done,
    /// The lock is kept or gone, which is said of the client in these words.
    Locked(String),
    /// Values are reported.
    Values,
    /// What can be run is reported.
    Plans,
    /// The instant is reported.
    Advanced,
    /// The subscription begins. Signals without a value so far were read.
    Subscribed { subscription: u64, signals: Vec<Signal>, read: Vec<u32> },
    /// The client leaves.
    Leave,
}
