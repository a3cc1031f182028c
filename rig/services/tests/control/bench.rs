//! A rig that is served on a real socket, and clients of it.

use std::io::{BufRead, BufReader, Write};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use scanrig_services::control::{Serving, SocketSettings, serve};
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::fake::Fake;

/// How long anything may take before it counts as not coming: far more than it takes on a loaded machine.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// A rig that is served.
pub struct Bench {
    pub rig: Fake,
    pub folder: TempDir,
    pub socket: PathBuf,
    pub serving: Option<Serving>,
    pub log: Arc<Mutex<Vec<String>>>,
}

impl Bench {
    pub fn new() -> Bench {
        Bench::of(Fake::default(), |_| {})
    }

    pub fn of(rig: Fake, settings: impl FnOnce(&mut SocketSettings)) -> Bench {
        let folder = tempfile::tempdir().expect("a folder");
        let socket = folder.path().join("rig.sock");
        let mut bench = Bench { rig, folder, socket, serving: None, log: Arc::default() };
        bench.start(settings);
        bench
    }

    pub fn start(&mut self, settings: impl FnOnce(&mut SocketSettings)) {
        let mut all = SocketSettings::of(self.socket.clone());
        settings(&mut all);
        let log = self.log.clone();
        let write = move |line: &str| log.lock().expect("nobody panicked").push(line.into());
        self.serving = Some(serve(self.rig.clone(), all, write).expect("a socket"));
    }

    pub fn client(&self) -> Client {
        let mut client = Client::connect(&self.socket);
        assert_eq!(client.line()["rig"], "scanrig");
        client
    }

    /// The log has a line with these words.
    pub fn logged(&self, words: &str) {
        wait_for(|| self.log.lock().expect("nobody panicked").iter().any(|line| line.contains(words)), words);
    }

    /// After this nobody is connected.
    pub fn is_empty(&self) {
        let mut client = self.client();
        wait_for(|| client.ok(json!({"do": "status"}))["clients"] == 1, "the others to be gone");
    }
}

pub fn wait_for(mut holds: impl FnMut() -> bool, what: &str) {
    let began = Instant::now();
    while !holds() {
        assert!(began.elapsed() < PATIENCE, "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// A client.
pub struct Client {
    pub stream: UnixStream,
    reader: BufReader<UnixStream>,
    last: u64,
    /// Events that came while an answer was waited for.
    pub events: Vec<Value>,
}

impl Client {
    pub fn connect(socket: &Path) -> Client {
        let stream = UnixStream::connect(socket).expect("a connection");
        stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
        stream.set_write_timeout(Some(PATIENCE)).expect("a timeout");
        let reader = BufReader::new(stream.try_clone().expect("a second handle"));
        Client { stream, reader, last: 0, events: Vec::new() }
    }

    pub fn send(&mut self, bytes: &[u8]) {
        self.stream.write_all(bytes).expect("bytes are taken");
    }

    /// The next line; null at the end of the connection.
    pub fn line(&mut self) -> Value {
        let mut line = String::new();
        self.reader.read_line(&mut line).expect("a line");
        if line.is_empty() { Value::Null } else { serde_json::from_str(&line).expect(&line) }
    }

    /// The answer to a request.
    pub fn ask(&mut self, mut request: Value) -> Value {
        self.last += 1;
        request["id"] = self.last.into();
        self.send(format!("{request}\n").as_bytes());
        loop {
            let line = self.line();
            if line.get("event").is_some() {
                self.events.push(line);
                continue;
            }
            assert_eq!(line["id"], self.last, "{request}: {line}");
            return line;
        }
    }

    /// What was asked for.
    pub fn ok(&mut self, request: Value) -> Value {
        let reply = self.ask(request.clone());
        assert!(reply.get("error").is_none(), "{request}: {reply}");
        reply["ok"].clone()
    }

    /// The code and the message of a refusal.
    pub fn refused(&mut self, request: Value) -> String {
        let reply = self.ask(request.clone());
        let error = &reply["error"];
        format!(
            "{} {}",
            error["code"].as_str().expect("a code"),
            error["message"].as_str().expect("a message")
        )
    }

    /// The next event.
    pub fn event(&mut self) -> Value {
        if !self.events.is_empty() {
            return self.events.remove(0);
        }
        self.line()
    }

    /// The next event of a kind.
    pub fn event_of(&mut self, kind: &str) -> Value {
        loop {
            let event = self.event();
            assert_ne!(event, Value::Null, "the connection ended before an event of {kind}");
            if event["event"] == kind {
                return event;
            }
        }
    }

    /// Ends its side.
    pub fn says_nothing_more(&self) {
        self.stream.shutdown(std::net::Shutdown::Write).expect("its side");
    }
}

/// A subscription to signals.
pub fn signals(names: &[&str], every_ms: u32, all: bool) -> Value {
    json!({"do": "subscribe", "topic": {"of": "signals", "names": names, "every_ms": every_ms, "all": all}})
}
