//! What the dashboard costs: ten messages a second with 200 signals that all change, and a status each time, read from
//! their lines, taken into account and drawn on a terminal of 200 x 60. The goal is 2 % of one core.
//!
//!     cargo bench -p scanrig-dash --bench frames

use control::{
    ChannelInfo, Description, Greeting, PROTOCOL, PointDirection, PointInfo, PointStatus, Reply, Request,
    RequestFault, RequestOperation, ServerMessage, Signal, SignalChange, SignalKind, Status, Subscribed,
    SubscriptionEvent, Topic, Value, WireValue,
};
use ratatui::crossterm::event::{KeyCode, KeyEvent};
use ratatui::{Terminal, TerminalOptions, Viewport, backend::CrosstermBackend, layout::Rect};
use scanrig_dash::frame_decoder::FrameDecoder;
use scanrig_dash::glyphs::TerminalFeatures;
use scanrig_dash::recording::{TrendFiles, TrendRecording};
use scanrig_dash::{RigMessage, Shell, views};
use std::cell::Cell;
use std::io::Write;
use std::rc::Rc;
use std::time::Duration;

const SIGNALS: u32 = 200;
const FRAMES: i64 = 1_000;
const A_SECOND: u32 = 10;

/// No bench saves anything.
#[derive(Debug)]
struct None;

impl TrendFiles for None {
    fn extensions(&self) -> &[&str] {
        &[]
    }

    fn save(&self, _: &str, _: &TrendRecording) -> Result<(), RequestFault> {
        Ok(())
    }

    fn load(&self, _: &str) -> Result<TrendRecording, RequestFault> {
        Ok(TrendRecording::default())
    }

    fn decoder(&self, path: &str) -> Result<Box<dyn FrameDecoder>, RequestFault> {
        panic!("nobody asks for {path}")
    }
}

/// How long this program ran on a processor by now, in nanoseconds: what else the machine does makes no difference.
fn on_processor() -> u64 {
    let stat = std::fs::read_to_string("/proc/self/schedstat").expect("a Linux kernel");
    stat.split(' ').next().and_then(|nanos| nanos.parse().ok()).expect("nanoseconds")
}

/// Counts what is written.
struct Counted(Rc<Cell<usize>>);

impl Write for Counted {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.set(self.0.get() + bytes.len());
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

fn point(number: u32) -> PointInfo {
    let channel = ChannelInfo {
        name: format!("line-{number}"),
        unit: String::new(),
        device: Option::None,
        drives: true,
    };
    PointInfo {
        name: format!("I{number}"),
        address: Some(format!("%IX{}.{}", number / 8, number % 8)),
        variable: Some(format!("MAIN.variable_{number}")),
        direction: PointDirection::Input,
        kind: SignalKind::Bool,
        channel: Some(channel),
        image: Option::None,
        forcible: true,
        writable: false,
        scale: Option::None,
    }
}

fn status(at: i64) -> Status {
    let points = vec![PointStatus { rising: at as u64, falling: at as u64, lost: false }; SIGNALS as usize];
    Status { at: at * 100_000_000, state: "RUNNING".to_owned(), points, clients: 1, ..Status::default() }
}

/// Answers what the dashboard asks; the subscription to its signals.
fn answer(shell: &mut Shell) -> u64 {
    let mut signals = 0;
    loop {
        let requests = shell.take_requests();
        if requests.is_empty() {
            return signals;
        }
        for Request { id, ask } in requests {
            let ok = match ask {
                RequestOperation::Describe => serde_json::to_value(Description {
                    points: (0..SIGNALS).map(point).collect(),
                    ..Description::default()
                }),
                RequestOperation::Subscribe { topic } => {
                    let mut answer = Subscribed { subscription: id, ..Subscribed::default() };
                    if let Topic::Signals { names, .. } = topic {
                        signals = id;
                        let number = |name: &str| name.rsplit('-').next().and_then(|n| n.parse().ok());
                        answer.signals = names
                            .into_iter()
                            .map(|name| Signal {
                                number: number(&name).unwrap_or_default(),
                                name,
                                kind: SignalKind::Bool,
                                unit: String::new(),
                                labels: Vec::new(),
                                writable: false,
                            })
                            .collect();
                    }
                    serde_json::to_value(answer)
                }
                _ => Ok(serde_json::json!({})),
            };
            shell.receive(RigMessage::Reply(Reply { id: Some(id), ok: ok.ok(), error: Option::None }));
        }
    }
}

fn main() {
    let features = TerminalFeatures { utf8: true, color: true };
    let mut shell = Shell::new(views::all(Box::new(None)), features, false);
    shell.receive(RigMessage::Connected(Box::new(Greeting {
        rig: "scanrig".to_owned(),
        protocol: PROTOCOL,
        version: String::new(),
        board: "bench".to_owned(),
        reference: String::new(),
        client: 1,
    })));
    let subscription = answer(&mut shell);
    let written = Rc::new(Cell::new(0));
    // What a frame comes to is counted and thrown away; a terminal of a fixed size needs no file to ask.
    let options = TerminalOptions { viewport: Viewport::Fixed(Rect::new(0, 0, 200, 60)) };
    let backend = CrosstermBackend::new(Counted(written.clone()));
    let mut terminal = Terminal::with_options(backend, options).expect("a terminal in memory");
    for name in ["I/O", "Trend"] {
        if name == "Trend" {
            let keys = "2i".chars().map(KeyCode::Char).chain([KeyCode::Enter, KeyCode::Down, KeyCode::Enter]);
            for key in keys.chain([KeyCode::Esc]) {
                shell.key(KeyEvent::from(key));
                answer(&mut shell);
            }
        }
        let mut spent = 0;
        written.set(0);
        for frame in 0..FRAMES {
            let on = WireValue(Value::Bool(frame % 2 == 0));
            let at = frame * 100_000_000;
            let changes = (0..SIGNALS).map(|number| SignalChange(number, at, at, on)).collect();
            let lines = [
                serde_json::to_vec(&SubscriptionEvent::Signals { subscription, changes, missed: 0 }),
                serde_json::to_vec(&SubscriptionEvent::Status {
                    subscription: 0,
                    status: Box::new(status(frame)),
                }),
            ];
            let lines = lines.map(|line| line.expect("a line"));
            let began = on_processor();
            for line in lines {
                if let Some(ServerMessage::Event(event)) = ServerMessage::read(&line).expect("an event") {
                    shell.receive(RigMessage::Event(event));
                }
            }
            terminal.draw(|frame| shell.draw(frame)).expect("a frame in memory");
            spent += on_processor() - began;
        }
        let each = Duration::from_nanos(spent / FRAMES as u64);
        let share = (each * A_SECOND).as_secs_f64() * 100.0;
        let bytes = written.get() / FRAMES as usize;
        println!("{name}: {each:?} and {bytes} bytes a frame, {share:.3} % of a core at {A_SECOND} a second");
        assert!(share < 2.0, "{name} costs more than 2 % of a core");
    }
}
