//! Views before a rig that is made by hand, for what no rig on a simulated board does. What they look like otherwise is
//! shown by goldens of a rig that runs: `tests/end_to_end/dashboard`.

mod scene;

use super::{View, ViewRequest};
use crate::frame_decoder::{DecodedFrame, FrameDecoder};
use crate::glyphs::TerminalFeatures;
use crate::model::RigModel;
use crate::recording::{TrendFiles, TrendRecording};
use control::{FrameSeen, RequestFault, Value, WireValue};
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers, MouseButton, MouseEvent, MouseEventKind};
use ratatui::layout::Rect;

/// What the shell leaves to a view on the smallest screen and on a large one.
const SIZES: [(u16, u16); 2] = [(80, 19), (200, 55)];

const FULL: TerminalFeatures = TerminalFeatures { utf8: true, color: true };

/// A view with its rig.
struct ViewSetup {
    view: Box<dyn View>,
    model: RigModel,
}

/// Files that hold one recording and take all.
#[derive(Debug)]
struct MemoryFiles(Option<TrendRecording>);

impl TrendFiles for MemoryFiles {
    fn extensions(&self) -> &[&str] {
        &["vcd", "csv"]
    }

    fn save(&self, _: &str, _: &TrendRecording) -> Result<(), RequestFault> {
        Ok(())
    }

    fn load(&self, path: &str) -> Result<TrendRecording, RequestFault> {
        let (code, help) = ("R0681".to_owned(), "look at its name".to_owned());
        self.0.clone().ok_or(RequestFault { code, message: format!("{path} cannot be read"), help })
    }

    fn decoder(&self, path: &str) -> Result<Box<dyn FrameDecoder>, RequestFault> {
        let (code, message) = ("R0683".to_owned(), format!("{path} cannot be read"));
        let fault = RequestFault { code, message, help: String::new() };
        if path == "drive.dbc" { Ok(Box::new(DriveDecoder)) } else { Err(fault) }
    }
}

/// Knows one message.
#[derive(Debug)]
struct DriveDecoder;

impl FrameDecoder for DriveDecoder {
    fn decode(&self, frame: &FrameSeen) -> Option<DecodedFrame> {
        let field = |name: &str, value: &str| (name.to_owned(), value.to_owned());
        let fields = vec![field("Mode", "on"), field("Speed", &format!("{} 1/min", frame.data))];
        (frame.id == "18F").then(|| DecodedFrame { name: "Drive".to_owned(), fields })
    }
}

impl ViewSetup {
    fn new(name: &str) -> ViewSetup {
        ViewSetup::with(name, None)
    }

    fn with(name: &str, recording: Option<TrendRecording>) -> ViewSetup {
        let view = super::all(Box::new(MemoryFiles(recording))).into_iter().find(|view| view.name() == name);
        let mut setup = ViewSetup { view: view.unwrap(), model: scene::model() };
        setup.view.shown(true);
        setup.view.opened(&setup.model);
        setup
    }

    fn draw(&mut self, (width, height): (u16, u16), features: TerminalFeatures) -> String {
        let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
        terminal
            .draw(|frame| self.view.draw(frame, Rect::new(0, 0, width, height), &self.model, features))
            .unwrap();
        text(terminal.backend())
    }

    /// What it shows on the smallest screen.
    fn screen(&mut self) -> String {
        self.draw(SIZES[0], FULL)
    }

    fn key(&mut self, code: KeyCode) {
        self.view.key(KeyEvent::new(code, KeyModifiers::NONE), &self.model);
    }

    fn keys(&mut self, keys: &str) {
        for key in keys.chars() {
            match key {
                '\n' => self.key(KeyCode::Enter),
                '\x1b' => self.key(KeyCode::Esc),
                'v' => self.key(KeyCode::Down),
                '^' => self.key(KeyCode::Up),
                '<' => self.key(KeyCode::Left),
                '>' => self.key(KeyCode::Right),
                letter => self.key(KeyCode::Char(letter)),
            }
        }
    }

    /// Chooses signals of the trend by parts of their names, and lets them change as the scene has it.
    fn trend(&mut self, names: &[&str]) {
        for name in names {
            self.keys("i");
            for letter in name.chars() {
                self.key(KeyCode::Char(letter));
            }
            self.keys("\n\x1b");
        }
        for (name, at, value) in scene::changes() {
            self.view.changed(name, (at - 500_000, at), value);
        }
        // A key finds the place that was drawn last.
        self.draw(SIZES[0], FULL);
    }
}

/// What stands on a screen, without the spaces at the ends of its rows.
fn text(backend: &TestBackend) -> String {
    let buffer = backend.buffer();
    let rows = (0..buffer.area.height).map(|y| {
        let row: String = (0..buffer.area.width).map(|x| buffer[(x, y)].symbol()).collect();
        format!("{}\n", row.trim_end())
    });
    rows.collect()
}

/// Whether a row of a screen has all these words, in this order.
fn has_row(screen: &str, words: &str) -> bool {
    screen.lines().any(|row| row.split_whitespace().collect::<Vec<_>>().join(" ").contains(words))
}

#[test]
fn tasks_that_overrun_and_lose() {
    let screen = ViewSetup::new("Tasks").screen();
    assert!(has_row(&screen, "FAST 1 2 ms 310 us 300 us 335 us 4.6 ms 90 us 2 1"), "{screen}");
    assert!(has_row(&screen, "Free 31 free - - - - - 0 0"), "{screen}");
}

#[test]
fn measured_values_show_how_well_they_are_known() {
    let screen = ViewSetup::new("Expert").screen();
    assert!(has_row(&screen, "Frequency 49998.2 +-12 Hz"), "{screen}");
    assert!(has_row(&screen, "State COUNTING"), "{screen}");
}

#[test]
fn bytes_of_serial_lines_and_strange_frames() {
    let mut setup = ViewSetup::new("Buses");
    let screen = setup.screen();
    for row in [
        "scale serial 19200 8E1 open 88 0",
        "3 errors, 0 dropped",
        "9.910000 scale 2 0D 0A [parity]",
        "9.920000 drive 7E8 5 48 65 6C 6C 6F [fd] [brs]",
        "9.930000 drive 7DF 0 [remote]",
    ] {
        assert!(has_row(&screen, row), "{row}:\n{screen}");
    }
    setup.keys("ox");
    let screen = setup.screen();
    assert!(has_row(&screen, "scale 2 10 ms 2 .. [parity]"), "{screen}");
    setup.keys("d");
    let wrong = setup.view.typed("none.dbc", &setup.model);
    assert!(matches!(&wrong[..], [ViewRequest::Fault(fault)] if fault.code == "R0683"));
}

/// Whatever is pressed and clicked in whatever order, on whatever screen, at whatever time.
#[test]
fn no_key_breaks_a_view() {
    // A generator of the simplest kind: the same keys with every run.
    let mut state = 1_u64;
    let mut chance = move |of: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % of
    };
    let codes = [
        KeyCode::Up,
        KeyCode::Down,
        KeyCode::Left,
        KeyCode::Right,
        KeyCode::PageUp,
        KeyCode::PageDown,
        KeyCode::Home,
        KeyCode::End,
        KeyCode::Enter,
        KeyCode::Esc,
        KeyCode::Delete,
        KeyCode::Backspace,
    ];
    let letters: Vec<char> = "abcdefhilostTxyE+- /%q1X0.".chars().collect();
    let typed = ["", "0..10", "9e999", "-1e308 .. 1e308", "level", "old.vcd", "drive.dbc", "-5", "auto"];
    for name in ["Trend", "Tasks", "Expert", "Buses", "Plan"] {
        let mut setup = ViewSetup::with(name, Some(scene::recording()));
        if name == "Trend" {
            setup.trend(&["lamp", "level", "state", "%IX0.1"]);
        }
        let changes = scene::changes();
        for round in 0..3_000 {
            match chance(8) {
                0..=3 => setup.key(KeyCode::Char(letters[chance(letters.len())])),
                4 => setup.key(codes[chance(codes.len())]),
                5 => {
                    setup.view.typed(typed[chance(typed.len())], &setup.model);
                }
                6 => {
                    let (name, at, value) = changes[chance(changes.len())];
                    let strange = [i64::MIN, -1, 0, at, i64::MAX - 1][chance(5)];
                    let at = if round % 7 == 0 { strange } else { at };
                    setup.view.changed(name, (at.saturating_sub(1), at), value);
                }
                _ => {
                    let kinds = [
                        MouseEventKind::Down(MouseButton::Left),
                        MouseEventKind::Down(MouseButton::Right),
                        MouseEventKind::ScrollUp,
                        MouseEventKind::ScrollDown,
                    ];
                    let kind = kinds[chance(kinds.len())];
                    let (column, row) = (chance(90) as u16, chance(30) as u16);
                    let modifiers = KeyModifiers::NONE;
                    setup.view.mouse(MouseEvent { kind, column, row, modifiers }, &setup.model);
                }
            }
            if round % 97 == 0 {
                // The rig is another one, or has nothing any more.
                setup.model = if chance(2) == 0 { scene::model() } else { RigModel::default() };
                setup.view.reconnected();
            }
            if round % 5 == 0 {
                setup.draw([(80, 19), (200, 55), (24, 6), (2, 2)][chance(4)], FULL);
            }
        }
    }
}

#[test]
fn a_measurement_that_was_not_taken_is_said() {
    let mut setup = ViewSetup::new("Plan");
    setup.keys("^");
    let screen = setup.screen();
    assert!(has_row(&screen, "delay: 562.1 .. 562.3 ms (500 .. 550"), "{screen}");
    assert!(has_row(&screen, "inconcl current: not taken (<= 0.5 A)"), "{screen}");
}

#[test]
fn levels_that_nobody_drives_and_times_that_are_not_exact() {
    let mut setup = ViewSetup::new("Trend");
    setup.trend(&["lamp", "%IX0.1"]);
    setup.keys("a<<<eb>>>ee");
    let screen = setup.screen();
    assert!(has_row(&screen, "B-A 1.5 s +-500 us"), "{screen}");
    assert!(has_row(&screen, "%IX0.1"), "{screen}");
}

#[test]
fn what_a_trigger_shows_makes_no_room_for_what_comes() {
    let mut setup = ViewSetup::new("Trend");
    setup.trend(&["level", "lamp"]);
    setup.keys("t>>>v>\n");
    let second = 1_000_000_000;
    setup.view.changed("lamp", (11 * second, 11 * second), WireValue(Value::Bool(true)));
    setup.model.now = 17 * second;
    let before = setup.screen();
    assert!(before.contains("done: lamp rises"), "{before}");
    // More than are kept.
    for n in 0..40_000 {
        let at = 18 * second + n;
        setup.view.changed("level", (at, at), WireValue(Value::Real((n % 2) as f64)));
    }
    assert_eq!(setup.screen(), before);
}

#[test]
fn a_file_is_looked_at() {
    let mut setup = ViewSetup::with("Trend", Some(scene::recording()));
    setup.keys("o");
    setup.view.typed("old.vcd", &setup.model);
    assert!(has_row(&setup.screen(), "FILE window"));
    setup.keys("c");
    assert!(setup.draw(SIZES[0], FULL).contains("No signals yet"));
}
