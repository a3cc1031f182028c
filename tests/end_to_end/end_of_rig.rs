//! The end of a rig that is kept running: whatever its clients do, whatever is read for them, and whoever reads what it
//! prints, an interrupt ends it within a bound, with its outputs safe.

use crate::project_folder::TestProject;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use std::fs::File;
use std::io::{BufRead, BufReader, ErrorKind, Read, Write};
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// How soon a rig must have ended: it waits for some seconds at most, and the machine may be busy.
const SOON: Duration = Duration::from_secs(20);

/// How long anything else may take.
const PATIENCE: Duration = Duration::from_secs(60);

/// What a pipe holds, bytes.
const PIPE: usize = 65_536;

/// Connections of a flood.
const FLOOD: usize = 500;

/// Both ways to end it.
const SIGNALS: [Signal; 2] = [Signal::SIGINT, Signal::SIGTERM];

const BOARD: &str = "format = 1\n[board]\nkind = \"simulated\"\n[control]\nclients = 600\n";

/// Something changes in each cycle.
const PROGRAM: &str = "PROGRAM MAIN\nVAR count : UDINT; END_VAR\ncount := count + 1;\nEND_PROGRAM\n";

/// A rig that runs until it is ended.
struct RunningRig {
    child: Child,
    bench: TestProject,
}

impl RunningRig {
    fn start(more: &[&str]) -> RunningRig {
        RunningRig::with(more, |_| {})
    }

    /// What it prints goes to files, unless `set` has it otherwise.
    fn with(more: &[&str], set: impl FnOnce(&mut Command)) -> RunningRig {
        let bench = TestProject::new();
        bench.write("bench.toml", BOARD);
        bench.write("count.st", PROGRAM);
        let args = ["run", "--board", "bench.toml", "--program", "count.st", "--booted", "--control"];
        let mut command = bench.command(&args);
        command.arg(bench.path("rig.sock")).args(more);
        command.stdout(File::create(bench.path("out")).unwrap());
        command.stderr(File::create(bench.path("err")).unwrap());
        set(&mut command);
        let rig = RunningRig { child: command.spawn().unwrap(), bench };
        wait_for("the socket", || UnixStream::connect(rig.socket()).is_ok());
        rig
    }

    fn socket(&self) -> PathBuf {
        self.bench.path("rig.sock")
    }

    /// A connection whose greeting is read.
    fn client(&self) -> Client {
        let stream = UnixStream::connect(self.socket()).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let mut client = Client(BufReader::new(stream));
        assert!(client.line().contains("\"rig\":\"scanrig\""));
        client
    }

    /// Sends the signal, and returns how long the rig took to end.
    fn end(&mut self, signal: Signal) -> Duration {
        let began = Instant::now();
        kill(Pid::from_raw(self.child.id() as i32), signal).unwrap();
        let status = loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                break status;
            }
            assert!(began.elapsed() < SOON, "the rig does not end");
            std::thread::sleep(Duration::from_millis(2));
        };
        assert_eq!(status.code(), Some(0));
        began.elapsed()
    }

    /// The same, where what it prints can be read.
    fn ends_safe(mut self, signal: Signal, what: &str) {
        let lasted = self.end(signal);
        eprintln!("{what}, {signal}: ended after {} ms", lasted.as_millis());
        let err = self.bench.read("err");
        assert!(err.contains("outputs safe"), "{err}");
        assert!(!self.socket().exists());
    }
}

impl Drop for RunningRig {
    fn drop(&mut self) {
        // After a test that failed; one that has ended cannot be killed.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

struct Client(BufReader<UnixStream>);

impl Client {
    fn line(&mut self) -> String {
        let mut line = String::new();
        self.0.read_line(&mut line).unwrap();
        line
    }

    fn send(&mut self, text: &str) {
        self.0.get_mut().write_all(text.as_bytes()).unwrap();
    }

    fn ask(&mut self, request: &str) -> String {
        self.send(&format!("{request}\n"));
        self.line()
    }
}

fn wait_for(what: &str, mut is: impl FnMut() -> bool) {
    let until = Instant::now() + PATIENCE;
    while !is() {
        assert!(Instant::now() < until, "{what} does not come");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Writes as often as the other side takes some.
fn flood(stream: &mut UnixStream, text: &[u8]) -> usize {
    match stream.write(text) {
        Ok(length) => length,
        Err(error) if error.kind() == ErrorKind::WouldBlock => 0,
        // It was cut off.
        Err(_) => 0,
    }
}

#[test]
fn a_flood_of_clients_that_ask_and_never_read() {
    for signal in SIGNALS {
        let rig = RunningRig::start(&[]);
        let mut streams: Vec<UnixStream> = (0..FLOOD)
            .map(|_| {
                let stream = UnixStream::connect(rig.socket()).unwrap();
                stream.set_nonblocking(true).unwrap();
                stream
            })
            .collect();
        let burst = "{\"id\": 1, \"do\": \"describe\"}\n{\"id\": 2, \"do\": \"read\", \"names\": [\"Q0\"]}\n"
            .repeat(50);
        let mut sent = 0;
        wait_for("the flood", || {
            sent += streams.iter_mut().map(|stream| flood(stream, burst.as_bytes())).sum::<usize>();
            sent > FLOOD * burst.len()
        });
        rig.ends_safe(signal, "500 clients that flood");
    }
}

#[test]
fn clients_that_come_and_go_without_a_pause_write_a_bounded_log() {
    let rig = RunningRig::start(&[]);
    let (began, mut connected) = (Instant::now(), 0_u32);
    while began.elapsed() < Duration::from_secs(2) {
        connected += u32::from(UnixStream::connect(rig.socket()).is_ok());
    }
    let seconds = began.elapsed().as_secs() as usize + 2;
    // The rest is counted in the next second.
    wait_for("the count", || rig.bench.read("err").contains("more lines about clients that came and went"));
    let lines = rig.bench.read("err").lines().count();
    eprintln!("{connected} connections: {lines} lines of the log");
    assert!(lines < 150 * (seconds + 2), "{lines} lines for {connected} connections");
    rig.ends_safe(Signal::SIGINT, "clients that come and go");
}

#[test]
fn clients_that_are_half_open_or_never_read() {
    for signal in SIGNALS {
        let rig = RunningRig::start(&[]);
        let mut half: Vec<UnixStream> = (0..50).map(|_| UnixStream::connect(rig.socket()).unwrap()).collect();
        half.iter_mut().for_each(|stream| stream.write_all(b"{\"id\": 1, \"do").unwrap());
        let mut sleepers: Vec<Client> = (0..50).map(|_| rig.client()).collect();
        for sleeper in &mut sleepers {
            sleeper.send(
                "{\"id\": 1, \"do\": \"subscribe\", \"topic\": {\"of\": \"status\", \"every_ms\": 5}}\n",
            );
            sleeper.send("{\"id\": 2, \"do\": \"subscribe\", \"topic\": {\"of\": \"log\"}}\n");
        }
        rig.ends_safe(signal, "100 clients that are half open or never read");
    }
}

#[test]
fn a_client_that_is_stopped() {
    for signal in SIGNALS {
        let rig = RunningRig::start(&[]);
        let mut command = rig.bench.command(&["ctl", "--socket", "rig.sock", "watch", "--all", "state"]);
        let mut watch = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut first = [0; 1];
        watch.stdout.as_mut().unwrap().read_exact(&mut first).unwrap();
        kill(Pid::from_raw(watch.id() as i32), Signal::SIGSTOP).unwrap();
        rig.ends_safe(signal, "a client that is stopped");
        watch.kill().unwrap();
        watch.wait().unwrap();
    }
}

#[test]
fn a_client_that_leads_the_time_and_does_not_read() {
    for signal in SIGNALS {
        let rig = RunningRig::start(&["--stepped"]);
        let mut client = rig.client();
        let topic = "{\"of\": \"signals\", \"names\": [\"MAIN.count\"], \"every_ms\": 5, \"all\": true}";
        client.ask(&format!("{{\"id\": 1, \"do\": \"subscribe\", \"topic\": {topic}}}"));
        client.send("{\"id\": 2, \"do\": \"advance\", \"by\": 36000000000000}\n");
        // It stands still for this client, which reads so little that it is never cut off.
        let mut piece = [0; 1];
        client.0.read_exact(&mut piece).unwrap();
        rig.ends_safe(signal, "a client that leads the time and does not read");
    }
}

#[test]
fn an_error_stream_that_nobody_reads() {
    for signal in SIGNALS {
        let (_errors, mut stderr) = std::io::pipe().unwrap();
        let (_output, mut stdout) = std::io::pipe().unwrap();
        // Nothing more fits into them.
        let full = [b'\n'; PIPE];
        stderr.write_all(&full).unwrap();
        stdout.write_all(&full).unwrap();
        let mut rig = RunningRig::with(&[], |command| {
            command.stderr(stderr).stdout(stdout);
        });
        for _ in 0..200 {
            rig.client();
        }
        // Clients are served all the same.
        assert!(rig.client().ask("{\"id\": 1, \"do\": \"status\"}").contains("\"ok\""));
        let lasted = rig.end(signal);
        eprintln!("an error stream that nobody reads, {signal}: ended after {} ms", lasted.as_millis());
    }
}

#[test]
fn a_folder_with_a_pipe_and_circles_is_read_beside_the_socket() {
    for signal in SIGNALS {
        let rig = RunningRig::start(&[]);
        std::fs::create_dir(rig.bench.path("plans")).unwrap();
        let folder = rig.bench.path("plans");
        for name in ["one", "other"] {
            std::os::unix::fs::symlink(&folder, folder.join(name)).unwrap();
        }
        let pipes = [folder.join("pipe.toml"), rig.bench.path("pipe.st")];
        assert!(Command::new("mkfifo").args(pipes).status().unwrap().success());
        rig.bench.write_lamp("piped.toml", "lamp.st", "pipe.st");
        let (mut lists, mut chooses) = (rig.client(), rig.client());
        let path = folder.display();
        lists.send(&format!("{{\"id\": 1, \"do\": \"plans\", \"path\": \"{path}\"}}\n"));
        let plan = rig.bench.path("piped").display().to_string();
        chooses.send(&format!("{{\"id\": 1, \"do\": \"plan\", \"name\": \"{plan}\"}}\n"));
        // Others are answered, and so are they, if not with plans.
        let began = Instant::now();
        assert!(rig.client().ask("{\"id\": 1, \"do\": \"status\"}").contains("\"ok\""));
        eprintln!("another client is answered after {} ms", began.elapsed().as_millis());
        assert!(lists.line().starts_with("{\"id\":1,"));
        let refused = chooses.line();
        assert!(refused.contains("\"R061"), "{refused}");
        rig.ends_safe(signal, "files that cannot be read");
    }
}

#[test]
fn a_folder_that_another_program_has_locked() {
    let rig = RunningRig::start(&[]);
    let folder = File::open(rig.bench.path("")).unwrap();
    folder.lock().unwrap();
    let mut rig = rig;
    let lasted = rig.end(Signal::SIGINT);
    eprintln!("a folder that is locked: ended after {} ms", lasted.as_millis());
    assert!(rig.bench.read("err").contains("outputs safe"));
}
