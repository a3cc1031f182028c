//! Notifies the service manager of a controller that is kept running: sd_notify(3).
//!
//! A thread of its own sends, without real-time priority: a manager that does not read delays nothing, and the end of the rig
//! by a few seconds at most. It sends the watchdog's keep-alive only if the executor has turned since the last one, so that the manager notices one that hangs.

use document::Diagnostic;
use runtime::LoopCounter;
use std::ffi::{OsStr, OsString};
use std::io;
use std::os::linux::net::SocketAddrExt;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::net::{SocketAddr, UnixDatagram};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, SyncSender};
use std::time::{Duration, Instant};

/// Where the manager listens: a path, or `@` and an abstract name.
const NOTIFY_SOCKET: &str = "NOTIFY_SOCKET";

/// Microseconds within which it expects a keep-alive.
const WATCHDOG_USEC: &str = "WATCHDOG_USEC";

/// The process that it expects one of; this one where the variable is not set.
const WATCHDOG_PID: &str = "WATCHDOG_PID";

/// The least time between two looks at the executor, which turns every 50 ms at rest.
const SHORTEST_PERIOD: Duration = Duration::from_millis(1);

/// How long the manager may take to take a notification.
const SEND: Duration = Duration::from_secs(1);

/// How long the last notifications are waited for.
const END: Duration = Duration::from_secs(4);

/// Notifications that wait. What a manager does not take in time is left out: the states between the first and the last.
const WAITING: usize = 64;

/// Notifies the service manager, if there is one, until it is dropped.
#[derive(Debug)]
pub struct ServiceNotifier {
    handle: Option<NotifierHandle>,
    /// Nothing comes by it; it ends with the thread.
    ended: Receiver<()>,
}

/// Notifies it from another thread.
#[derive(Clone, Debug)]
pub struct NotifierHandle {
    notifications: SyncSender<Notification>,
    signs: Arc<EndSigns>,
}

/// What the thread sees however many notifications wait.
#[derive(Debug, Default)]
struct EndSigns {
    /// The rig was asked to end.
    stopping: AtomicBool,
    /// It has ended.
    over: AtomicBool,
}

/// What it is notified of.
#[derive(Debug)]
enum Notification {
    Ready,
    Status(String),
    /// Wakes the thread, which looks at the signs of the end.
    Sign,
}

/// What the environment says of the manager.
#[derive(Debug, Default, PartialEq, Eq)]
struct ManagerEnvironment {
    socket: Option<OsString>,
    watchdog: Option<Duration>,
}

impl ManagerEnvironment {
    /// Reads it, as `get` has the variables, for the process of this number.
    fn read(get: impl Fn(&str) -> Option<OsString>, process: u32) -> Result<ManagerEnvironment, Diagnostic> {
        let Some(socket) = get(NOTIFY_SOCKET).filter(|socket| !socket.is_empty()) else {
            return Ok(ManagerEnvironment::default());
        };
        let number = |name: &str| match get(name) {
            None => Ok(None),
            Some(text) => match text.to_str().and_then(|text| text.parse::<u64>().ok()) {
                Some(number) => Ok(Some(number)),
                None => {
                    let message = format!("`{name}` is {}, which is not a number", text.to_string_lossy());
                    let found = Diagnostic::error("R0341", message);
                    Err(found.help("leave it to the service manager, or unset it"))
                }
            },
        };
        let ours = number(WATCHDOG_PID)?.is_none_or(|watched| watched == u64::from(process));
        let every = number(WATCHDOG_USEC)?.filter(|every| *every > 0 && ours);
        Ok(ManagerEnvironment { socket: Some(socket), watchdog: every.map(Duration::from_micros) })
    }
}

impl ServiceNotifier {
    /// Notifies the manager that the environment names, and keeps its watchdog alive as long as these turns go on.
    ///
    /// # Errors
    /// The environment's variables are invalid, or nobody listens there.
    pub fn start(turns: &'static LoopCounter) -> Result<ServiceNotifier, Diagnostic> {
        let wanted = ManagerEnvironment::read(|name| std::env::var_os(name), std::process::id())?;
        let (runs, ended) = mpsc::channel::<()>();
        let Some(socket) = wanted.socket else { return Ok(ServiceNotifier { handle: None, ended }) };
        let unreachable = |error: io::Error| {
            let message =
                format!("the service manager cannot be notified at {}: {error}", socket.to_string_lossy());
            let found = Diagnostic::error("R0340", message);
            found.help(format!(
                "start the rig by `systemctl`, or unset `{NOTIFY_SOCKET}` where there is no service manager"
            ))
        };
        let socket = connect(&socket).map_err(unreachable)?;
        let (sender, notifications) = mpsc::sync_channel(WAITING);
        let handle = NotifierHandle { notifications: sender, signs: Arc::default() };
        let signs = handle.signs.clone();
        let body = move || {
            let _runs = runs;
            notify_loop(&socket, &notifications, &signs, turns, wanted.watchdog);
        };
        std::thread::Builder::new().name(String::from("notify")).spawn(body).map_err(|error| {
            Diagnostic::error("R0340", format!("the service manager cannot be notified: {error}"))
                .help("let the service have more threads (`TasksMax`)")
        })?;
        Ok(ServiceNotifier { handle: Some(handle), ended })
    }

    /// The controller scans, or waits for its supply.
    pub fn ready(&self) {
        self.send(Notification::Ready);
    }

    /// Its status, in a few words.
    pub fn status(&self, text: &str) {
        // A line is all that a status may be.
        self.send(Notification::Status(text.lines().collect::<Vec<_>>().join(" ")));
    }

    /// For the handler of signals; `None` where there is no service manager.
    pub fn handle(&self) -> Option<NotifierHandle> {
        self.handle.clone()
    }

    fn send(&self, notification: Notification) {
        if let Some(handle) = &self.handle {
            // What finds no room is left out: the manager takes nothing.
            let _ = handle.notifications.try_send(notification);
        }
    }
}

impl NotifierHandle {
    /// The rig was asked to end.
    pub fn stopping(&self) {
        self.signs.stopping.store(true, Ordering::Release);
        let _ = self.notifications.try_send(Notification::Sign);
    }
}

impl Drop for ServiceNotifier {
    fn drop(&mut self) {
        if let Some(handle) = self.handle.take() {
            handle.signs.over.store(true, Ordering::Release);
            handle.stopping();
            // The thread ends within this time; one that does not is left.
            let _ = self.ended.recv_timeout(END);
        }
    }
}

fn connect(name: &OsStr) -> io::Result<UnixDatagram> {
    let socket = UnixDatagram::unbound()?;
    socket.set_write_timeout(Some(SEND))?;
    match name.as_bytes() {
        [b'@', name @ ..] => socket.connect_addr(&SocketAddr::from_abstract_name(name)?)?,
        [b'/', ..] => socket.connect(name)?,
        _ => return Err(io::Error::new(io::ErrorKind::InvalidInput, "neither a path nor an abstract name")),
    }
    Ok(socket)
}

/// Sends notifications until the rig has ended, and keep-alives in between.
fn notify_loop(
    socket: &UnixDatagram,
    notifications: &Receiver<Notification>,
    signs: &EndSigns,
    turns: &LoopCounter,
    watchdog: Option<Duration>,
) {
    // A manager that went away comes back, or ends the rig: neither is for the rig to decide. Nor is one that takes nothing.
    let say = |text: &str| drop(socket.send(text.as_bytes()));
    let mut watchdog_timer = watchdog.map(|limit| WatchdogTimer::new(limit, Instant::now()));
    let mut stopping = false;
    loop {
        let mut notification = match &watchdog_timer {
            Some(watchdog_timer) => {
                notifications.recv_timeout(watchdog_timer.due.saturating_duration_since(Instant::now()))
            }
            None => notifications.recv().map_err(|_| RecvTimeoutError::Disconnected),
        };
        let over = signs.over.load(Ordering::Acquire)
            || notification.as_ref().is_err_and(|end| *end == RecvTimeoutError::Disconnected);
        // Of the states that wait at the end the last one counts.
        let mut last = None;
        loop {
            match notification {
                Ok(Notification::Ready) => say("READY=1\nSTATUS=ready"),
                Ok(Notification::Status(text)) if over => last = Some(text),
                Ok(Notification::Status(text)) => say(&format!("STATUS={text}")),
                Ok(Notification::Sign) | Err(_) => {}
            }
            match over.then(|| notifications.try_recv()) {
                Some(Ok(next)) => notification = Ok(next),
                _ => break,
            }
        }
        if let Some(text) = last {
            say(&format!("STATUS={text}"));
        }
        if signs.stopping.load(Ordering::Acquire) && !std::mem::replace(&mut stopping, true) {
            say("STOPPING=1\nSTATUS=stopping");
        }
        if over {
            return;
        }
        if watchdog_timer
            .as_mut()
            .is_some_and(|watchdog_timer| watchdog_timer.is_due(Instant::now(), turns.count()))
        {
            say("WATCHDOG=1");
        }
    }
}

/// When a keep-alive is due, and whether it may be sent.
#[derive(Debug)]
struct WatchdogTimer {
    every: Duration,
    due: Instant,
    seen: u64,
}

impl WatchdogTimer {
    /// Twice in the time that the manager allows, as it advises.
    fn new(limit: Duration, now: Instant) -> WatchdogTimer {
        let every = (limit / 2).max(SHORTEST_PERIOD);
        WatchdogTimer { every, due: now + every, seen: 0 }
    }

    /// Whether one is due and the executor has turned since the last.
    fn is_due(&mut self, now: Instant, turns: u64) -> bool {
        if now < self.due {
            return false;
        }
        self.due = now + self.every;
        std::mem::replace(&mut self.seen, turns) != turns
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(set: &[(&str, &str)]) -> Result<ManagerEnvironment, Diagnostic> {
        let get =
            |name: &str| set.iter().find(|(known, _)| *known == name).map(|(_, text)| OsString::from(text));
        ManagerEnvironment::read(get, 7)
    }

    #[test]
    fn a_manager_says_where_it_listens_and_how_long_it_waits() {
        let at = |watchdog| ManagerEnvironment { socket: Some(OsString::from("/run/n")), watchdog };
        let second = Some(Duration::from_secs(1));
        assert_eq!(read(&[]), Ok(ManagerEnvironment::default()));
        assert_eq!(read(&[(WATCHDOG_USEC, "1000000")]), Ok(ManagerEnvironment::default()), "nobody listens");
        assert_eq!(read(&[(NOTIFY_SOCKET, "/run/n")]), Ok(at(None)));
        assert_eq!(read(&[(NOTIFY_SOCKET, "/run/n"), (WATCHDOG_USEC, "1000000")]), Ok(at(second)));
        assert_eq!(
            read(&[(NOTIFY_SOCKET, "/run/n"), (WATCHDOG_USEC, "1000000"), (WATCHDOG_PID, "7")]),
            Ok(at(second))
        );
        // Another process is watched, such as a shell that the rig was started by.
        assert_eq!(
            read(&[(NOTIFY_SOCKET, "/run/n"), (WATCHDOG_USEC, "1000000"), (WATCHDOG_PID, "8")]),
            Ok(at(None))
        );
        assert_eq!(read(&[(NOTIFY_SOCKET, "/run/n"), (WATCHDOG_USEC, "0")]), Ok(at(None)));
        for wrong in ["", "-1", "1 s", "99999999999999999999"] {
            assert_eq!(
                read(&[(NOTIFY_SOCKET, "/run/n"), (WATCHDOG_USEC, wrong)]).unwrap_err().code,
                "R0341",
                "{wrong}"
            );
        }
    }

    #[test]
    fn an_executor_that_hangs_is_missed_and_one_that_goes_on_is_not() {
        let start = Instant::now();
        let at = |milliseconds| start + Duration::from_millis(milliseconds);
        let mut watchdog_timer = WatchdogTimer::new(Duration::from_secs(2), start);
        assert!(!watchdog_timer.is_due(at(999), 50));
        assert!(watchdog_timer.is_due(at(1000), 100));
        assert!(!watchdog_timer.is_due(at(1500), 150), "not yet");
        assert!(!watchdog_timer.is_due(at(2000), 100), "it has not turned");
        assert!(!watchdog_timer.is_due(at(3000), 100), "nor now");
        assert!(watchdog_timer.is_due(at(4000), 101), "it hung, and goes on");
    }

    #[test]
    fn a_name_is_a_path_or_abstract() {
        let listener =
            UnixDatagram::bind_addr(&SocketAddr::from_abstract_name(b"scanrig-notify-test").unwrap());
        let listener = listener.unwrap();
        connect(OsStr::new("@scanrig-notify-test")).unwrap().send(b"READY=1").unwrap();
        let mut room = [0; 16];
        assert_eq!(listener.recv(&mut room).unwrap(), 7);
        assert_eq!(connect(OsStr::new("relative")).unwrap_err().kind(), io::ErrorKind::InvalidInput);
        assert_eq!(connect(OsStr::new("/nobody/listens")).unwrap_err().kind(), io::ErrorKind::NotFound);
    }
}
