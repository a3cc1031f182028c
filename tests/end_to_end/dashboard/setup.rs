//! A rig in stepped time, and a dashboard before it.

use crate::project_folder::{TestProject, root};
use control::client::{ControlClient, ControlReceiver, Sender};
use control::{FrameSeen, Reply, RequestFault, RequestOperation, ServerMessage};
use dash::frame_decoder::{DecodedFrame, FrameDecoder};
use dash::glyphs::TerminalFeatures;
use dash::recording::{TrendFiles, TrendRecording};
use dash::{RigMessage, Shell};
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::process::{Child, Stdio};
use std::rc::Rc;
use std::time::{Duration, Instant};

/// Far above what an answer takes, on a machine that does much else.
const PATIENCE: Duration = Duration::from_secs(120);

pub const MS: i64 = 1_000_000;

pub const SMALL: (u16, u16) = (80, 24);
pub const LARGE: (u16, u16) = (200, 60);

/// Files that last as long as the test.
#[derive(Clone, Debug, Default)]
pub struct MemoryFiles(Rc<RefCell<BTreeMap<String, TrendRecording>>>);

impl MemoryFiles {
    /// What was saved.
    pub fn saved(&self, path: &str) -> TrendRecording {
        self.0.borrow()[path].clone()
    }
}

impl TrendFiles for MemoryFiles {
    fn extensions(&self) -> &[&str] {
        &["vcd"]
    }

    fn save(&self, path: &str, recording: &TrendRecording) -> Result<(), RequestFault> {
        self.0.borrow_mut().insert(path.to_owned(), recording.clone());
        Ok(())
    }

    fn load(&self, path: &str) -> Result<TrendRecording, RequestFault> {
        Ok(self.saved(path))
    }

    fn decoder(&self, _: &str) -> Result<Box<dyn FrameDecoder>, RequestFault> {
        Ok(Box::new(DriveDecoder))
    }
}

/// Knows one message, the speed of a drive in its first byte.
#[derive(Debug)]
struct DriveDecoder;

impl FrameDecoder for DriveDecoder {
    fn decode(&self, frame: &FrameSeen) -> Option<DecodedFrame> {
        let speed = u8::from_str_radix(frame.data.get(..2)?, 16).ok()?;
        let fields = vec![("Speed".to_owned(), format!("{speed} 1/min"))];
        (frame.id == "18F").then(|| DecodedFrame { name: "Drive".to_owned(), fields })
    }
}

/// A rig that stands still, and a dashboard before it.
pub struct DashboardSetup {
    rig: Child,
    sender: Sender,
    receiver: ControlReceiver,
    pub shell: Shell,
    pub files: MemoryFiles,
    features: TerminalFeatures,
    /// Requests under way: the dashboard's numbers by those of the connection; none for those of this test.
    open: BTreeMap<u64, Option<u64>>,
    _folder: TestProject,
}

impl Drop for DashboardSetup {
    fn drop(&mut self) {
        let _ = self.rig.kill();
        let _ = self.rig.wait();
    }
}

impl DashboardSetup {
    /// The rig of the demonstration.
    pub fn conveyor(features: TerminalFeatures) -> DashboardSetup {
        let folder = TestProject::new();
        for name in ["sim.toml", "conveyor.toml", "conveyor.st"] {
            let path = root().join("rig/cli/demo").join(name);
            folder.write(name, &std::fs::read_to_string(path).unwrap());
        }
        DashboardSetup::of(folder, &["--board", "sim.toml", "--case", "conveyor", "--booted"], features)
    }

    /// A rig of these files.
    pub fn of(folder: TestProject, words: &[&str], features: TerminalFeatures) -> DashboardSetup {
        let socket = folder.path("rig.sock");
        let mut command = folder.command(&["run", "--stepped"]);
        command.args(words).arg("--control").arg(&socket).stdout(Stdio::null());
        let mut rig = command.spawn().unwrap();
        let until = Instant::now() + PATIENCE;
        let client = loop {
            match ControlClient::connect(&socket, "rig dash") {
                Ok(client) => break client,
                Err(error) => assert!(Instant::now() < until, "{error}"),
            }
            assert!(matches!(rig.try_wait(), Ok(None)), "the rig ended");
            std::thread::sleep(Duration::from_millis(10));
        };
        let files = MemoryFiles::default();
        let mut shell = Shell::new(dash::views::all(Box::new(files.clone())), features, false);
        shell.receive(RigMessage::Connected(Box::new(client.greeting().clone())));
        let (sender, receiver) = client.split();
        let open = BTreeMap::new();
        let mut setup =
            DashboardSetup { rig, sender, receiver, shell, files, features, open, _folder: folder };
        setup.settle();
        setup
    }

    /// Until everything that was asked is answered.
    pub fn settle(&mut self) {
        loop {
            for request in self.shell.take_requests() {
                let sent = self.sender.send(request.ask).unwrap();
                self.open.insert(sent, Some(request.id));
            }
            if self.open.is_empty() {
                return;
            }
            self.hear();
        }
    }

    /// Takes the next message.
    pub fn hear(&mut self) {
        match self.receiver.next(Some(PATIENCE)).unwrap().expect("a message in time") {
            ServerMessage::Event(event) => self.shell.receive(RigMessage::Event(event)),
            ServerMessage::Reply(reply) => {
                let Some(asked) = reply.id.and_then(|id| self.open.remove(&id)) else { return };
                match asked {
                    Some(id) => self.shell.receive(RigMessage::Reply(Reply { id: Some(id), ..reply })),
                    None => assert_eq!(reply.error, None),
                }
            }
        }
    }

    /// Hears until something is so.
    pub fn until(&mut self, is: impl Fn(&DashboardSetup) -> bool) {
        while !is(self) {
            self.hear();
            self.settle();
        }
    }

    /// Asks the rig for something beside what the dashboard does, and waits for the answer.
    pub fn ask(&mut self, ask: RequestOperation) {
        let sent = self.sender.send(ask).unwrap();
        self.open.insert(sent, None);
        self.settle();
    }

    /// Lets time pass. Everything that happens until then is sent before it is answered.
    pub fn advance(&mut self, by: i64) {
        self.ask(RequestOperation::Advance { by });
    }

    pub fn key(&mut self, code: KeyCode) {
        self.shell.key(KeyEvent::new(code, KeyModifiers::NONE));
        self.settle();
        // A key finds what was drawn last.
        self.screen(SMALL);
    }

    /// Keys, one after the other: Enter, Escape and the arrows by signs that no view has a use for.
    pub fn keys(&mut self, keys: &str) {
        for key in keys.chars() {
            self.key(match key {
                '\n' => KeyCode::Enter,
                '\x1b' => KeyCode::Esc,
                '<' => KeyCode::Left,
                '>' => KeyCode::Right,
                '^' => KeyCode::Up,
                '|' => KeyCode::Down,
                '$' => KeyCode::End,
                letter => KeyCode::Char(letter),
            });
        }
    }

    pub fn screen(&mut self, (width, height): (u16, u16)) -> String {
        let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
        terminal.draw(|frame| self.shell.draw(frame)).unwrap();
        let buffer = terminal.backend().buffer();
        let rows = (0..height).map(|y| {
            let row: String = (0..width).map(|x| buffer[(x, y)].symbol()).collect();
            format!("{}\n", row.trim_end())
        });
        rows.collect()
    }

    /// Compares with `tests/end_to_end/goldens/dashboard/NAME-WIDTHxHEIGHT.txt`, or `NAME-ascii.txt`.
    pub fn golden(&mut self, name: &str) {
        let sizes = if self.features.utf8 { vec![SMALL, LARGE] } else { vec![SMALL] };
        for size @ (width, height) in sizes {
            let screen = self.screen(size);
            let file = match self.features.utf8 {
                true => format!("{name}-{width}x{height}.txt"),
                false => format!("{name}-ascii.txt"),
            };
            assert!(self.features.utf8 || screen.is_ascii(), "{file} is no ASCII:\n{screen}");
            let folder = root().join("tests/end_to_end/goldens/dashboard");
            let path = folder.join(&file);
            if std::env::var_os("SCANRIG_BLESS").is_some() {
                std::fs::create_dir_all(&folder).unwrap();
                std::fs::write(&path, &screen).unwrap();
            }
            let golden = std::fs::read_to_string(&path).unwrap_or_default();
            assert!(screen == golden, "{file} shows now:\n{screen}\nand should show:\n{golden}");
        }
        // However small the window is.
        for size in [(1, 1), (3, 2), (20, 4), (30, 40), (79, 3)] {
            self.screen(size);
        }
        self.screen(SMALL);
    }

    /// Takes a signal into the trend, which is shown.
    pub fn choose(&mut self, name: &str) {
        self.keys("i");
        self.keys(name);
        self.keys("\n\x1b");
    }

    /// Lets time pass in steps, each of which is drawn.
    pub fn play(&mut self, steps: usize, by: i64) {
        for _ in 0..steps {
            self.advance(by);
        }
    }
}

/// Plays a scene on a terminal with everything, and on one with nothing.
pub fn scene(play: impl Fn(TerminalFeatures)) {
    play(TerminalFeatures { utf8: true, color: true });
    play(TerminalFeatures { utf8: false, color: false });
}
