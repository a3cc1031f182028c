//! What the service manager is told of a controller that is kept running: sd_notify(3), in a few lines of our own.
//!
//! A thread of its own talks, without real-time priority: a manager that does not listen holds up nobody. It says that the
//! rig lives only if the executor has turned since it said so last, so that one that hangs is missed by the manager.

use document::Diagnostic;
use runtime::Turns;
use std::ffi::{OsStr, OsString};
use std::io;
use std::os::linux::net::SocketAddrExt;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::net::{SocketAddr, UnixDatagram};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Where the manager listens: a path, or `@` and an abstract name.
const SOCKET: &str = "NOTIFY_SOCKET";

/// Microseconds after which it misses a sign of life.
const WATCHDOG: &str = "WATCHDOG_USEC";

/// The process that it misses one of; this one where nothing is said.
const WATCHED: &str = "WATCHDOG_PID";

/// The least time between two looks at the executor, which turns every 50 ms at rest.
const LEAST: Duration = Duration::from_millis(1);

/// Tells the service manager, if there is one, until it is dropped.
#[derive(Debug)]
pub struct Notifier {
    teller: Option<(Teller, JoinHandle<()>)>,
}

/// A way to tell it something, for another thread.
#[derive(Clone, Debug)]
pub struct Teller(Sender<Word>);

/// What it is told.
#[derive(Debug)]
enum Word {
    Ready,
    Status(String),
    Stopping,
    End,
}

/// What the environment says of the manager.
#[derive(Debug, Default, PartialEq, Eq)]
struct Wanted {
    socket: Option<OsString>,
    watchdog: Option<Duration>,
}

impl Wanted {
    /// Reads it, as `get` has the variables, for the process of this number.
    fn read(get: impl Fn(&str) -> Option<OsString>, process: u32) -> Result<Wanted, Diagnostic> {
        let Some(socket) = get(SOCKET).filter(|socket| !socket.is_empty()) else {
            return Ok(Wanted::default());
        };
        let number = |name: &str| match get(name) {
            None => Ok(None),
            Some(text) => match text.to_str().and_then(|text| text.parse::<u64>().ok()) {
                Some(number) => Ok(Some(number)),
                None => {
                    let message = format!("`{name}` is {}, which is no number", text.to_string_lossy());
                    let found = Diagnostic::error("R0341", message);
                    Err(found.help("leave it to the service manager, or unset it"))
                }
            },
        };
        let ours = number(WATCHED)?.is_none_or(|watched| watched == u64::from(process));
        let every = number(WATCHDOG)?.filter(|every| *every > 0 && ours);
        Ok(Wanted { socket: Some(socket), watchdog: every.map(Duration::from_micros) })
    }
}

impl Notifier {
    /// Tells the manager that the environment names, and that the rig lives as long as these turns go on.
    ///
    /// # Errors
    /// What the environment says cannot be, or nobody listens there.
    pub fn start(turns: &'static Turns) -> Result<Notifier, Diagnostic> {
        let wanted = Wanted::read(|name| std::env::var_os(name), std::process::id())?;
        let Some(socket) = wanted.socket else { return Ok(Notifier { teller: None }) };
        let unheard = |error: io::Error| {
            let message =
                format!("the service manager cannot be told at {}: {error}", socket.to_string_lossy());
            let found = Diagnostic::error("R0340", message);
            found.help(format!(
                "start the rig by `systemctl`, or unset `{SOCKET}` where there is no service manager"
            ))
        };
        let socket = connect(&socket).map_err(unheard)?;
        let (sender, words) = mpsc::channel();
        let talk = move || talk(&socket, &words, turns, wanted.watchdog);
        let thread =
            std::thread::Builder::new().name(String::from("notify")).spawn(talk).map_err(|error| {
                Diagnostic::error("R0340", format!("the service manager cannot be told: {error}"))
                    .help("let the service have more threads (`TasksMax`)")
            })?;
        Ok(Notifier { teller: Some((Teller(sender), thread)) })
    }

    /// The controller scans, or waits for its supply.
    pub fn ready(&self) {
        self.tell(Word::Ready);
    }

    /// How it is, in a few words.
    pub fn status(&self, text: &str) {
        // A line is all that a status may be.
        self.tell(Word::Status(text.lines().collect::<Vec<_>>().join(" ")));
    }

    /// For the handler of signals; `None` where nobody is to be told.
    pub fn teller(&self) -> Option<Teller> {
        self.teller.as_ref().map(|(teller, _)| teller.clone())
    }

    fn tell(&self, word: Word) {
        if let Some((teller, _)) = &self.teller {
            // The thread ends only behind the last word.
            let _ = teller.0.send(word);
        }
    }
}

impl Teller {
    /// The rig was asked to end.
    pub fn stopping(&self) {
        let _ = self.0.send(Word::Stopping);
    }
}

impl Drop for Notifier {
    fn drop(&mut self) {
        if let Some((teller, thread)) = self.teller.take() {
            teller.stopping();
            let _ = teller.0.send(Word::End);
            // A panic there has printed its words, and nothing hangs on it here.
            let _ = thread.join();
        }
    }
}

fn connect(name: &OsStr) -> io::Result<UnixDatagram> {
    let socket = UnixDatagram::unbound()?;
    match name.as_bytes() {
        [b'@', name @ ..] => socket.connect_addr(&SocketAddr::from_abstract_name(name)?)?,
        [b'/', ..] => socket.connect(name)?,
        _ => return Err(io::Error::new(io::ErrorKind::InvalidInput, "neither a path nor an abstract name")),
    }
    Ok(socket)
}

/// Talks until the last word, and says in between that the rig lives.
fn talk(socket: &UnixDatagram, words: &Receiver<Word>, turns: &Turns, watchdog: Option<Duration>) {
    // A manager that went away comes back, or ends the rig: neither is for the rig to decide.
    let say = |text: &str| drop(socket.send(text.as_bytes()));
    let mut beat = watchdog.map(|limit| Beat::new(limit, Instant::now()));
    let mut stopping = false;
    loop {
        let word = match &beat {
            Some(beat) => words.recv_timeout(beat.due.saturating_duration_since(Instant::now())),
            None => words.recv().map_err(|_| RecvTimeoutError::Disconnected),
        };
        match word {
            Ok(Word::Ready) => say("READY=1\nSTATUS=ready"),
            Ok(Word::Status(text)) => say(&format!("STATUS={text}")),
            Ok(Word::Stopping) if stopping => {}
            Ok(Word::Stopping) => {
                stopping = true;
                say("STOPPING=1\nSTATUS=stopping");
            }
            Ok(Word::End) | Err(RecvTimeoutError::Disconnected) => return,
            Err(RecvTimeoutError::Timeout) => {}
        }
        if beat.as_mut().is_some_and(|beat| beat.is_due(Instant::now(), turns.count())) {
            say("WATCHDOG=1");
        }
    }
}

/// When a sign of life is due, and whether there is one to give.
#[derive(Debug)]
struct Beat {
    every: Duration,
    due: Instant,
    seen: u64,
}

impl Beat {
    /// Twice in the time that the manager allows, as it advises.
    fn new(limit: Duration, now: Instant) -> Beat {
        let every = (limit / 2).max(LEAST);
        Beat { every, due: now + every, seen: 0 }
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

    fn read(set: &[(&str, &str)]) -> Result<Wanted, Diagnostic> {
        let get =
            |name: &str| set.iter().find(|(known, _)| *known == name).map(|(_, text)| OsString::from(text));
        Wanted::read(get, 7)
    }

    #[test]
    fn a_manager_says_where_it_listens_and_how_long_it_waits() {
        let at = |watchdog| Wanted { socket: Some(OsString::from("/run/n")), watchdog };
        let second = Some(Duration::from_secs(1));
        assert_eq!(read(&[]), Ok(Wanted::default()));
        assert_eq!(read(&[(WATCHDOG, "1000000")]), Ok(Wanted::default()), "nobody listens");
        assert_eq!(read(&[(SOCKET, "/run/n")]), Ok(at(None)));
        assert_eq!(read(&[(SOCKET, "/run/n"), (WATCHDOG, "1000000")]), Ok(at(second)));
        assert_eq!(read(&[(SOCKET, "/run/n"), (WATCHDOG, "1000000"), (WATCHED, "7")]), Ok(at(second)));
        // Another process is watched, such as a shell that the rig was started by.
        assert_eq!(read(&[(SOCKET, "/run/n"), (WATCHDOG, "1000000"), (WATCHED, "8")]), Ok(at(None)));
        assert_eq!(read(&[(SOCKET, "/run/n"), (WATCHDOG, "0")]), Ok(at(None)));
        for wrong in ["", "-1", "1 s", "99999999999999999999"] {
            assert_eq!(read(&[(SOCKET, "/run/n"), (WATCHDOG, wrong)]).unwrap_err().code, "R0341", "{wrong}");
        }
    }

    #[test]
    fn an_executor_that_hangs_is_missed_and_one_that_goes_on_is_not() {
        let start = Instant::now();
        let at = |milliseconds| start + Duration::from_millis(milliseconds);
        let mut beat = Beat::new(Duration::from_secs(2), start);
        assert!(!beat.is_due(at(999), 50));
        assert!(beat.is_due(at(1000), 100));
        assert!(!beat.is_due(at(1500), 150), "not yet");
        assert!(!beat.is_due(at(2000), 100), "it has not turned");
        assert!(!beat.is_due(at(3000), 100), "nor now");
        assert!(beat.is_due(at(4000), 101), "it hung, and goes on");
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
