//! The connection to the rig: a thread that listens, and tries again where there is none.

use control::client::{ClientError, ControlClient, Sender};
use control::{Greeting, RequestOperation, ServerMessage};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender};
use std::time::Duration;

/// What the dashboard is called in the rig's log.
const NAME: &str = "rig dash";

/// How long after a connection was lost, or could not be had, it is tried again.
const RECONNECT_AFTER: Duration = Duration::from_secs(1);

/// What comes from the thread that listens.
#[derive(Debug)]
pub(crate) enum LinkEvent {
    /// There is a connection.
    Connected(Box<Greeting>, Sender),
    /// Something was sent.
    Message(ServerMessage),
    /// There is none.
    Disconnected(ClientError),
}

/// Listens to the rig at a socket until nobody wants it any more: `end` is closed, or nothing takes what it hands on.
pub(crate) fn listen<T: From<LinkEvent>>(socket: PathBuf, events: &SyncSender<T>, end: &Receiver<()>) {
    loop {
        let disconnected = match ControlClient::connect(&socket, NAME) {
            Ok(client) => {
                let greeting = Box::new(client.greeting().clone());
                let (sender, mut receiver) = client.split();
                if events.send(LinkEvent::Connected(greeting, sender).into()).is_err() {
                    return;
                }
                loop {
                    match receiver.next(None) {
                        Ok(Some(message)) => {
                            if events.send(LinkEvent::Message(message).into()).is_err() {
                                return;
                            }
                        }
                        Ok(None) => {}
                        Err(error) => break error,
                    }
                }
            }
            Err(error) => error,
        };
        if events.send(LinkEvent::Disconnected(disconnected).into()).is_err() {
            return;
        }
        match end.recv_timeout(RECONNECT_AFTER) {
            Err(RecvTimeoutError::Timeout) => {}
            Ok(()) | Err(RecvTimeoutError::Disconnected) => return,
        }
    }
}

/// The half that asks, as long as there is a connection.
#[derive(Debug, Default)]
pub(crate) struct RequestSender {
    sender: Option<Sender>,
    /// The dashboard's numbers of requests by those of the connection.
    numbers: BTreeMap<u64, u64>,
}

impl RequestSender {
    /// There is a connection.
    pub fn connected(&mut self, sender: Sender) {
        self.numbers.clear();
        self.sender = Some(sender);
    }

    /// There is none.
    pub fn disconnected(&mut self) {
        self.numbers.clear();
        self.sender = None;
    }

    /// Sends a request. One that cannot be sent ends the connection, which the other half reports.
    pub fn send(&mut self, number: u64, ask: RequestOperation) {
        let Some(sender) = &mut self.sender else { return };
        match sender.send(ask) {
            Ok(sent) => drop(self.numbers.insert(sent, number)),
            Err(_) => sender.close(),
        }
    }

    /// The dashboard's number of a request that was answered.
    pub fn number_of(&mut self, sent: u64) -> Option<u64> {
        self.numbers.remove(&sent)
    }
}
