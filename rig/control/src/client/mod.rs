//! A client that waits for its answers: [`ControlClient`] for whoever asks one thing after the other, and [`ControlClient::split`] for
//! whoever listens in one thread and asks from another.

mod connect;
mod error;
mod find;
mod lines;

pub use connect::{Connection, connect};
pub use error::ClientError;
pub use find::{by_name, only, running};

use crate::{Done, Greeting, PROTOCOL, Reply, Request, RequestOperation, ServerMessage, SubscriptionEvent};
use lines::LineStream;
use serde::de::DeserializeOwned;
use std::collections::VecDeque;
use std::io::Write;
use std::net::Shutdown;
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// How long an answer may take, and how long a rig may take to read a request.
pub const PATIENCE: Duration = Duration::from_secs(10);

/// Events that are kept while an answer is awaited.
const MOST_ASIDE: usize = 65_536;

/// A connection to a rig.
#[derive(Debug)]
pub struct ControlClient {
    sender: Sender,
    receiver: ControlReceiver,
    greeting: Greeting,
    aside: VecDeque<SubscriptionEvent>,
    unseen: u64,
}

/// The half that asks.
#[derive(Debug)]
pub struct Sender {
    stream: UnixStream,
    socket: PathBuf,
    asked: u64,
}

/// The half that listens.
#[derive(Debug)]
pub struct ControlReceiver {
    lines: LineStream,
    socket: PathBuf,
}

impl ControlClient {
    /// Connects to a rig, looks at its greeting and says hello under this name.
    ///
    /// # Errors
    /// No rig there, one of another protocol, or one that takes nobody more.
    pub fn connect(socket: &Path, name: &str) -> Result<ControlClient, ClientError> {
        let mut client = ControlClient::meet(socket, PATIENCE)?;
        client.hello(name)?;
        Ok(client)
    }

    /// Says who asks: the rig's log and its status name it.
    ///
    /// # Errors
    /// See [`ControlClient::ask`].
    pub fn hello(&mut self, name: &str) -> Result<(), ClientError> {
        self.ask::<Done>(RequestOperation::Hello { protocol: PROTOCOL, name: name.to_owned() }).map(|_| ())
    }

    /// Connects and looks at the greeting, and says nothing.
    ///
    /// # Errors
    /// See [`ControlClient::connect`].
    pub fn meet(socket: &Path, patience: Duration) -> Result<ControlClient, ClientError> {
        let unreachable = |error: std::io::Error| ClientError::Unreachable(socket.to_owned(), error.kind());
        let Connection::Open(stream) = connect(socket, patience).map_err(unreachable)? else {
            return Err(ClientError::Silent(socket.to_owned(), patience));
        };
        stream.set_write_timeout(Some(PATIENCE)).map_err(unreachable)?;
        let write = stream.try_clone().map_err(unreachable)?;
        let mut receiver = ControlReceiver { lines: LineStream::new(stream), socket: socket.to_owned() };
        let greeting = receiver.greeting(patience)?;
        let sender = Sender { stream: write, socket: socket.to_owned(), asked: 0 };
        Ok(ControlClient { sender, receiver, greeting, aside: VecDeque::new(), unseen: 0 })
    }

    /// What the rig said first.
    pub fn greeting(&self) -> &Greeting {
        &self.greeting
    }

    /// Where the rig is.
    pub fn socket(&self) -> &Path {
        &self.receiver.socket
    }

    /// Asks, and waits for the answer. Events that come before it are kept for [`ControlClient::next`].
    ///
    /// # Errors
    /// What the rig refuses, and whatever can become of a connection.
    pub fn ask<T: DeserializeOwned>(&mut self, ask: RequestOperation) -> Result<T, ClientError> {
        self.ask_within(ask, PATIENCE)
    }

    /// Asks what may take longer.
    ///
    /// # Errors
    /// See [`ControlClient::ask`].
    pub fn ask_within<T: DeserializeOwned>(
        &mut self,
        ask: RequestOperation,
        patience: Duration,
    ) -> Result<T, ClientError> {
        let id = self.sender.send(ask)?;
        let until = Instant::now() + patience;
        loop {
            match self.receiver.next_until(Some(until))? {
                Some(ServerMessage::Reply(reply)) if reply.id == Some(id) => return answer(reply),
                // An answer without a number is to a line that the rig could not read, and this client waits for one
                // at a time; any other number is of an answer that was given up.
                Some(ServerMessage::Reply(reply)) if reply.id.is_none() => return answer(reply),
                Some(ServerMessage::Reply(_)) => {}
                Some(ServerMessage::Event(event)) => self.put_aside(event),
                None => return Err(ClientError::Silent(self.receiver.socket.clone(), patience)),
            }
            // Whatever else comes, and however fast, does not put off the end of the wait.
            if Instant::now() >= until {
                return Err(ClientError::Silent(self.receiver.socket.clone(), patience));
            }
        }
    }

    fn put_aside(&mut self, event: SubscriptionEvent) {
        if self.aside.len() < MOST_ASIDE {
            self.aside.push_back(event);
        } else {
            self.unseen += 1;
        }
    }

    /// The next event of the subscriptions; `None` where none comes in this time.
    ///
    /// # Errors
    /// A connection that is lost.
    pub fn next(&mut self, patience: Duration) -> Result<Option<SubscriptionEvent>, ClientError> {
        if let Some(event) = self.aside.pop_front() {
            return Ok(Some(event));
        }
        let until = Instant::now() + patience;
        loop {
            match self.receiver.next_until(Some(until))? {
                Some(ServerMessage::Event(event)) => return Ok(Some(event)),
                Some(ServerMessage::Reply(_)) if Instant::now() < until => {}
                Some(ServerMessage::Reply(_)) | None => return Ok(None),
            }
        }
    }

    /// Hands on the events that have come by now. A rig that never pauses is listened to for as long as an answer may take.
    ///
    /// # Errors
    /// A connection that is lost.
    pub fn take_waiting(&mut self, mut take: impl FnMut(SubscriptionEvent)) -> Result<(), ClientError> {
        let until = Instant::now() + PATIENCE;
        while let Some(event) = self.next(Duration::ZERO)? {
            take(event);
            if Instant::now() >= until {
                break;
            }
        }
        Ok(())
    }

    /// Events that came while an answer was awaited, and were more than are kept.
    pub fn unseen(&self) -> u64 {
        self.unseen
    }

    /// Both halves. What was put aside is lost: split before the first subscription.
    pub fn split(self) -> (Sender, ControlReceiver) {
        (self.sender, self.receiver)
    }
}

/// What an answer holds.
///
/// # Errors
/// What the rig refuses, and an answer to another question.
pub fn answer<T: DeserializeOwned>(reply: Reply) -> Result<T, ClientError> {
    match (reply.error, reply.ok) {
        (Some(fault), _) => Err(ClientError::Refused(fault)),
        (None, ok) => serde_json::from_value(ok.unwrap_or_default())
            .map_err(|error| ClientError::Garbled(error.to_string())),
    }
}

impl Sender {
    /// Asks, and says by which number the answer is known.
    ///
    /// # Errors
    /// A rig that does not take it. The connection is of no use then: the request may be sent in part.
    pub fn send(&mut self, ask: RequestOperation) -> Result<u64, ClientError> {
        self.asked += 1;
        let request = Request { id: self.asked, ask };
        let mut line =
            serde_json::to_vec(&request).map_err(|error| ClientError::Garbled(error.to_string()))?;
        line.push(b'\n');
        self.stream.write_all(&line).map_err(|error| match error.kind() {
            std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut => {
                ClientError::Silent(self.socket.clone(), PATIENCE)
            }
            _ => ClientError::Lost(self.socket.clone()),
        })?;
        Ok(self.asked)
    }

    /// Ends the connection: the other half's wait ends, too.
    pub fn close(&self) {
        // A connection that is lost has nothing to end.
        let _ = self.stream.shutdown(Shutdown::Both);
    }
}

impl ControlReceiver {
    /// The next message; `None` where none comes in this time. Waits for as long as it takes without one. Messages that
    /// are younger than this program are passed over.
    ///
    /// # Errors
    /// A connection that is lost, or that the rig ended.
    pub fn next(&mut self, patience: Option<Duration>) -> Result<Option<ServerMessage>, ClientError> {
        self.next_until(patience.map(|patience| Instant::now() + patience))
    }

    fn next_until(&mut self, until: Option<Instant>) -> Result<Option<ServerMessage>, ClientError> {
        loop {
            let Some(line) = self.lines.next(until).map_err(|broken| broken.of(&self.socket))? else {
                return Ok(None);
            };
            match ServerMessage::read(line).map_err(|error| ClientError::Garbled(error.to_string()))? {
                Some(ServerMessage::Event(SubscriptionEvent::Gone { why })) => {
                    return Err(ClientError::Ended(why));
                }
                Some(message) => return Ok(Some(message)),
                // One of a younger rig.
                None if until.is_some_and(|until| Instant::now() >= until) => return Ok(None),
                None => {}
            }
        }
    }

    fn greeting(&mut self, patience: Duration) -> Result<Greeting, ClientError> {
        let line =
            self.lines.next(Some(Instant::now() + patience)).map_err(|broken| broken.of(&self.socket))?;
        let Some(line) = line else {
            return Err(ClientError::Silent(self.socket.clone(), patience));
        };
        match serde_json::from_slice::<Greeting>(line) {
            Ok(greeting) if greeting.rig != "scanrig" => Err(ClientError::NotARig(self.socket.clone())),
            Ok(greeting) if greeting.protocol != PROTOCOL => {
                Err(ClientError::OtherProtocol(self.socket.clone(), greeting.protocol))
            }
            Ok(greeting) => Ok(greeting),
            // In place of a greeting: why it takes nobody more.
            Err(_) => match ServerMessage::read(line) {
                Ok(Some(ServerMessage::Reply(Reply { error: Some(fault), .. }))) => {
                    Err(ClientError::Refused(fault))
                }
                Ok(Some(ServerMessage::Event(SubscriptionEvent::Gone { why }))) => {
                    Err(ClientError::Ended(why))
                }
                _ => Err(ClientError::NotARig(self.socket.clone())),
            },
        }
    }
}
