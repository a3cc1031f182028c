//! The shell around the hub: the socket, the connections, the clock.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::future::{Future, poll_fn};
use std::io;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll, Waker};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use control::RequestFault;
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use signal::{Span, Time};
use tokio::net::{UnixListener, UnixStream};
use tokio::sync::Notify;
use tokio::task::LocalSet;
use tokio::time::{sleep, timeout};

use super::client::{ClientId, Peer};
use super::decode::fault;
use super::hub::Hub;
use super::rig::Rig;
use super::settings::SocketSettings;
use super::socket::Socket;
use crate::codes;

/// Bytes that are read of a client at once.
const CHUNK: usize = 16 * 1024;
/// How long those who do not read are waited for at the end.
const FAREWELL: Duration = Duration::from_secs(1);
/// How long the thread is waited for at the end: what it does in vain is over long before.
const END: Duration = Duration::from_secs(5);
/// How long nobody is let in when the machine has no room for another connection.
const NO_ROOM: Duration = Duration::from_millis(100);
/// Files that the process has open beside the connections.
const OTHER_FILES: u64 = 512;

/// A socket that is served by a thread of its own, until this is ended or dropped.
#[derive(Debug)]
pub struct Serving {
    path: PathBuf,
    stop: Arc<Stop>,
    thread: Option<JoinHandle<()>>,
    /// Nothing comes by it; it ends with the thread.
    ended: Mutex<Receiver<()>>,
}

#[derive(Debug, Default)]
struct Stop {
    why: Mutex<Option<String>>,
    bell: Notify,
    /// The socket's file, until somebody removes it.
    socket: Mutex<Option<Socket>>,
}

impl Stop {
    fn why(&self) -> Option<String> {
        self.why.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn remove_socket(&self) {
        drop(self.socket.lock().unwrap_or_else(PoisonError::into_inner).take());
    }
}

impl Serving {
    /// Where the socket is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether it is over: the rig reported its end.
    pub fn is_over(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Informs every client that the rig ends, and why, and waits until they know, but no longer than a second. The
    /// socket's file is gone then. A thread that hangs all the same is left after some seconds.
    pub fn end(mut self, why: &str) {
        self.finish(why);
    }

    fn finish(&mut self, why: &str) {
        self.stop.why.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert_with(|| why.into());
        self.stop.bell.notify_one();
        if let Some(thread) = self.thread.take() {
            let ended = self.ended.get_mut().unwrap_or_else(PoisonError::into_inner);
            if ended.recv_timeout(END) == Err(RecvTimeoutError::Timeout) {
                tracing::warn!("the thread of the control socket hangs, and is left");
                return self.stop.remove_socket();
            }
            // A thread that panicked has nothing left to end; the socket's file went with it.
            let _ = thread.join();
        }
    }
}

impl Drop for Serving {
    fn drop(&mut self) {
        self.finish("the rig ends");
    }
}

/// Serves a rig on a socket. What it has to say goes to `log`, line by line.
///
/// # Errors
/// The socket cannot be made, or somebody serves it.
pub fn serve(
    rig: impl Rig + 'static,
    settings: SocketSettings,
    log: impl FnMut(&str) + Send + 'static,
) -> Result<Serving, RequestFault> {
    let (socket, listener) = Socket::bind(&settings.socket, settings.group.as_deref())?;
    let cannot = |error: io::Error| {
        let message = format!("the socket {} cannot be served: {error}", settings.socket.display());
        fault(codes::SOCKET, message, "free memory and threads of the machine")
    };
    make_room(settings.limits.clients);
    let runtime =
        tokio::runtime::Builder::new_current_thread().enable_io().enable_time().build().map_err(cannot)?;
    let path = socket.path().to_path_buf();
    let stop = Arc::new(Stop { socket: Mutex::new(Some(socket)), ..Stop::default() });
    let (runs, ended) = mpsc::channel::<()>();
    tracing::info!(socket = %path.display(), "clients are served");
    let (ends, kept) = (stop.clone(), settings.clone());
    let thread = std::thread::Builder::new()
        .name("control".into())
        .spawn(move || {
            let _runs = runs;
            let _socket = SocketFile(&ends);
            let hub = Hub::new(Box::new(rig), kept, Box::new(log));
            let shared = Rc::new(Shared::new(hub));
            LocalSet::new().block_on(&runtime, async {
                if let Ok(listener) = UnixListener::from_std(listener) {
                    run(&shared, listener, &ends).await;
                }
            });
        })
        .map_err(cannot)?;
    Ok(Serving { path, stop, thread: Some(thread), ended: Mutex::new(ended) })
}

/// Removes the socket's file, however the thread ends.
struct SocketFile<'a>(&'a Stop);

impl Drop for SocketFile<'_> {
    fn drop(&mut self) {
        self.0.remove_socket();
    }
}

/// Lets the process have as many connections as there may be clients, as far as its own limit goes.
fn make_room(clients: usize) {
    let limit = getrlimit(Resource::Nofile);
    let wanted = u64::try_from(clients).unwrap_or(u64::MAX).saturating_add(OTHER_FILES);
    if limit.current.is_some_and(|current| current < wanted) {
        let current = limit.maximum.map_or(wanted, |maximum| maximum.min(wanted));
        // Where it is refused the clients that are too many wait until there is room.
        let _ = setrlimit(Resource::Nofile, Rlimit { current: Some(current), maximum: limit.maximum });
    }
}

/// What the tasks of the thread share. None keeps it borrowed while it waits.
struct Shared {
    hub: RefCell<Hub>,
    wakers: RefCell<BTreeMap<ClientId, Waker>>,
    /// Rung when orders were given, whose answers will come soon.
    ordered: Notify,
    began: Instant,
    /// What is read lands here first.
    chunk: RefCell<Vec<u8>>,
}

impl Shared {
    fn new(hub: Hub) -> Shared {
        Shared {
            hub: RefCell::new(hub),
            wakers: RefCell::new(BTreeMap::new()),
            ordered: Notify::new(),
            began: Instant::now(),
            chunk: RefCell::new(vec![0; CHUNK]),
        }
    }

    /// Nanoseconds since the thread began.
    fn now(&self) -> Time {
        Time::from_nanos(i64::try_from(self.began.elapsed().as_nanos()).unwrap_or(i64::MAX))
    }

    /// Does something with the hub, then wakes whom it concerns.
    fn with<T>(&self, act: impl FnOnce(&mut Hub, Time) -> T) -> T {
        let mut hub = self.hub.borrow_mut();
        let result = act(&mut hub, self.now());
        let wakers = self.wakers.borrow();
        for id in hub.touched() {
            if let Some(waker) = wakers.get(&id) {
                waker.wake_by_ref();
            }
        }
        if hub.is_busy() {
            self.ordered.notify_one();
        }
        result
    }
}

async fn run(shared: &Rc<Shared>, listener: UnixListener, stop: &Stop) {
    let accept = tokio::task::spawn_local(accept(shared.clone(), listener));
    let mut stopped = std::pin::pin!(stop.bell.notified());
    loop {
        shared.with(Hub::turn);
        if let Some(why) = stop.why() {
            shared.with(|hub, now| hub.end(&why, now));
        }
        if shared.hub.borrow().is_over() {
            break;
        }
        let (pause, busy) = {
            let hub = shared.hub.borrow();
            (std_duration(hub.pause()), hub.is_busy())
        };
        let turn = async {
            // With orders under way the turn comes soon anyway; else as soon as there are some.
            if busy || timeout(pause, shared.ordered.notified()).await.is_ok() {
                sleep(Duration::from_millis(1)).await;
            }
        };
        either(stopped.as_mut(), turn).await;
    }
    accept.abort();
    let farewell = Instant::now();
    while shared.hub.borrow().clients() > 0 && farewell.elapsed() < FAREWELL {
        sleep(Duration::from_millis(1)).await;
    }
}

fn std_duration(span: Span) -> Duration {
    Duration::from_nanos(u64::try_from(span.as_nanos()).unwrap_or(0))
}

/// Waits for either.
async fn either(mut one: std::pin::Pin<&mut impl Future>, other: impl Future) {
    let mut other = std::pin::pin!(other);
    poll_fn(|cx| {
        if one.as_mut().poll(cx).is_ready() || other.as_mut().poll(cx).is_ready() {
            return Poll::Ready(());
        }
        Poll::Pending
    })
    .await;
}

async fn accept(shared: Rc<Shared>, listener: UnixListener) {
    loop {
        let stream = match listener.accept().await {
            Ok((stream, _)) => stream,
            Err(error) => {
                // Most likely too many files are open.
                tracing::warn!(%error, "no client can be let in");
                sleep(NO_ROOM).await;
                continue;
            }
        };
        let peer = stream.peer_cred().map_or(Peer::default(), |peer| Peer {
            user: peer.uid(),
            process: peer.pid().filter(|&process| process > 0),
        });
        match shared.with(|hub, now| hub.connect(peer, now)) {
            Ok(id) => {
                tracing::info!(client = id, user = peer.user, process = ?peer.process, "a client connected");
                tokio::task::spawn_local(client(shared.clone(), id, stream));
            }
            // The line fits into the empty buffer of a new connection, or nobody is there to read it.
            Err(line) => {
                tracing::info!(user = peer.user, "a client was refused");
                drop(stream.try_write(&line));
            }
        }
    }
}

async fn client(shared: Rc<Shared>, id: ClientId, stream: UnixStream) {
    poll_fn(|cx| {
        shared.wakers.borrow_mut().insert(id, cx.waker().clone());
        poll_client(&shared, id, &stream, cx)
    })
    .await;
    shared.wakers.borrow_mut().remove(&id);
    tracing::info!(client = id, "a client is gone");
    shared.with(|hub, now| hub.disconnect(id, now));
}

/// Sends what waits, does what was asked for, reads what comes; ready when the connection is over.
fn poll_client(shared: &Shared, id: ClientId, stream: &UnixStream, cx: &mut Context) -> Poll<()> {
    if !send(shared, id, stream, cx) || shared.hub.borrow().is_done(id) {
        return Poll::Ready(());
    }
    if shared.with(|hub, now| hub.work(id, now)) {
        // Others have their turn first.
        cx.waker().wake_by_ref();
        return Poll::Pending;
    }
    let mut chunk = shared.chunk.borrow_mut();
    while shared.hub.borrow().wants_input(id) {
        match stream.poll_read_ready(cx) {
            Poll::Pending => return Poll::Pending,
            Poll::Ready(Err(_)) => return Poll::Ready(()),
            Poll::Ready(Ok(())) => {}
        }
        match stream.try_read(&mut chunk) {
            Ok(0) => shared.hub.borrow_mut().input_is_over(id),
            Ok(bytes) => shared.hub.borrow_mut().receive(id, &chunk[..bytes]),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => continue,
            Err(_) => return Poll::Ready(()),
        }
        cx.waker().wake_by_ref();
        return Poll::Pending;
    }
    Poll::Pending
}

/// Sends what waits, as far as the kernel takes it; reports whether the connection still holds.
fn send(shared: &Shared, id: ClientId, stream: &UnixStream, cx: &mut Context) -> bool {
    loop {
        let mut hub = shared.hub.borrow_mut();
        if hub.output(id).is_empty() {
            return true;
        }
        match stream.poll_write_ready(cx) {
            Poll::Pending => return true,
            Poll::Ready(Err(_)) => return false,
            Poll::Ready(Ok(())) => {}
        }
        match stream.try_write(hub.output(id)) {
            Ok(bytes) => hub.sent(id, bytes, shared.now()),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
            Err(_) => return false,
        }
    }
}
