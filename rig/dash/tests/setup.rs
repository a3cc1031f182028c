//! A dashboard on a terminal that is none, and a rig that answers from what it was set up to say.

use control::{
    Description, Greeting, PROTOCOL, PlanEvent, Plans, Reply, Request, RequestFault, RequestOperation,
    RigLogLine, Signal, SignalChange, SignalKind, Status, Subscribed, SubscriptionEvent, Topic, WireValue,
};
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers, MouseButton, MouseEvent, MouseEventKind};
use scanrig_dash::frame_decoder::FrameDecoder;
use scanrig_dash::glyphs::TerminalFeatures;
use scanrig_dash::recording::{TrendFiles, TrendRecording};
use scanrig_dash::views::View;
use scanrig_dash::{LoopCommand, RigMessage, Shell};
use std::cell::RefCell;
use std::collections::BTreeMap;

/// A terminal with everything but colours.
pub const LOOK: TerminalFeatures = TerminalFeatures { utf8: true, color: false };

/// A terminal with nothing.
pub const PLAIN: TerminalFeatures = TerminalFeatures { utf8: false, color: false };

/// The smallest window.
pub const SMALL: (u16, u16) = (80, 24);

/// Files that are kept as long as the test runs.
#[derive(Debug, Default)]
pub struct MemoryFiles(RefCell<BTreeMap<String, TrendRecording>>);

impl TrendFiles for MemoryFiles {
    fn extensions(&self) -> &[&str] {
        &["vcd", "csv"]
    }

    fn save(&self, path: &str, recording: &TrendRecording) -> Result<(), RequestFault> {
        if self.0.borrow_mut().insert(path.to_owned(), recording.clone()).is_some() {
            let message = format!("there is a file {path}");
            return Err(RequestFault { code: "R0680".to_owned(), message, help: String::new() });
        }
        Ok(())
    }

    fn load(&self, path: &str) -> Result<TrendRecording, RequestFault> {
        let message = format!("there is no file {path}");
        let none = RequestFault { code: "R0681".to_owned(), message, help: String::new() };
        self.0.borrow().get(path).cloned().ok_or(none)
    }

    fn decoder(&self, path: &str) -> Result<Box<dyn FrameDecoder>, RequestFault> {
        let (code, message) = ("R0683".to_owned(), format!("{path} cannot be read"));
        Err(RequestFault { code, message, help: String::new() })
    }
}

/// Every view.
pub fn views() -> Vec<Box<dyn View>> {
    scanrig_dash::views::all(Box::new(MemoryFiles::default()))
}

/// What the rig is and says.
#[derive(Debug, Default)]
pub struct ScriptedRig {
    pub description: Description,
    pub status: Status,
    /// Signals by their names, with their values and since when.
    pub signals: BTreeMap<String, (i64, WireValue)>,
    pub log: Vec<RigLogLine>,
    pub plan: Vec<PlanEvent>,
    pub plans: Vec<String>,
    /// What it answers to an order in place of doing it.
    pub fault: Option<RequestFault>,
}

/// A dashboard before such a rig.
#[derive(Debug)]
pub struct DashboardSetup {
    pub shell: Shell,
    pub rig: ScriptedRig,
    /// What the rig was asked, subscriptions apart.
    pub asked: Vec<RequestOperation>,
    pub wants: Vec<LoopCommand>,
    /// Names of the subscriptions to signals, by their numbers.
    pub subscriptions: BTreeMap<u64, (Vec<String>, bool)>,
    pub others: BTreeMap<u64, Topic>,
    next: u64,
    terminal: Terminal<TestBackend>,
}

impl DashboardSetup {
    /// A dashboard that is connected and has everything that it wanted.
    pub fn new(rig: ScriptedRig, (width, height): (u16, u16), features: TerminalFeatures) -> DashboardSetup {
        DashboardSetup::with(Shell::new(views(), features, false), rig, (width, height))
    }

    /// The same of a dashboard that was made otherwise.
    pub fn with(shell: Shell, rig: ScriptedRig, (width, height): (u16, u16)) -> DashboardSetup {
        let mut setup = DashboardSetup {
            shell,
            rig,
            asked: Vec::new(),
            wants: Vec::new(),
            subscriptions: BTreeMap::new(),
            others: BTreeMap::new(),
            next: 0,
            terminal: Terminal::new(TestBackend::new(width, height)).unwrap(),
        };
        setup.connect();
        setup
    }

    /// There is a connection.
    pub fn connect(&mut self) {
        self.shell.receive(RigMessage::Connected(Box::new(Greeting {
            rig: "scanrig".to_owned(),
            protocol: PROTOCOL,
            version: "1".to_owned(),
            board: self.rig.description.board.clone(),
            reference: self.rig.description.reference.clone(),
            client: 1,
        })));
        self.answer();
        self.report_status();
    }

    /// The rig answers whatever was asked.
    pub fn answer(&mut self) {
        loop {
            let requests = self.shell.take_requests();
            self.wants.extend(self.shell.take_loop_commands());
            if requests.is_empty() {
                return;
            }
            for Request { id, ask } in requests {
                let answer = self.answer_to(ask);
                let (ok, error) = match answer {
                    Ok(ok) => (Some(ok), None),
                    Err(fault) => (None, Some(fault)),
                };
                self.shell.receive(RigMessage::Reply(Reply { id: Some(id), ok, error }));
            }
        }
    }

    fn answer_to(&mut self, ask: RequestOperation) -> Result<serde_json::Value, RequestFault> {
        let json = |of: serde_json::Result<serde_json::Value>| Ok(of.unwrap());
        match ask {
            RequestOperation::Hello { .. } => Ok(serde_json::json!({})),
            RequestOperation::Describe => json(serde_json::to_value(&self.rig.description)),
            RequestOperation::Subscribe { topic } => {
                self.next += 1;
                let mut answer = Subscribed { subscription: self.next, ..Subscribed::default() };
                match &topic {
                    Topic::Signals { names, all, .. } => {
                        for name in names {
                            let place = self.rig.signals.keys().position(|known| known == name);
                            let Some(place) = place else {
                                let message = format!("nothing is called `{name}`");
                                return Err(RequestFault {
                                    code: "R0600".to_owned(),
                                    message,
                                    help: String::new(),
                                });
                            };
                            let (at, value) = self.rig.signals[name];
                            answer.signals.push(signal(place as u32, name));
                            answer.values.push(SignalChange(place as u32, at, at, value));
                        }
                        self.subscriptions.insert(self.next, (names.clone(), *all));
                    }
                    Topic::Log => answer.log = self.rig.log.clone(),
                    Topic::Plan => answer.plan = self.rig.plan.clone(),
                    Topic::Status { .. } | Topic::Frames => {}
                }
                self.others.insert(self.next, topic);
                json(serde_json::to_value(&answer))
            }
            RequestOperation::Unsubscribe { subscription } => {
                self.subscriptions.remove(&subscription);
                self.others.remove(&subscription);
                Ok(serde_json::json!({}))
            }
            RequestOperation::Plans { .. } => {
                json(serde_json::to_value(Plans { plans: self.rig.plans.clone() }))
            }
            other => {
                self.asked.push(other);
                self.rig.fault.take().map_or(Ok(serde_json::json!({})), Err)
            }
        }
    }

    /// The rig sends its status.
    pub fn report_status(&mut self) {
        self.report(SubscriptionEvent::Status { subscription: 0, status: Box::new(self.rig.status.clone()) });
    }

    /// A signal changes; all who subscribed to it are sent it.
    pub fn change(&mut self, name: &str, at: i64, value: WireValue) {
        let place = self.rig.signals.keys().position(|known| known == name).unwrap() as u32;
        self.rig.signals.insert(name.to_owned(), (at, value));
        let whose: Vec<u64> = self
            .subscriptions
            .iter()
            .filter_map(|(number, (names, _))| names.iter().any(|n| n == name).then_some(*number))
            .collect();
        for subscription in whose {
            let changes = vec![SignalChange(place, at, at, value)];
            self.report(SubscriptionEvent::Signals { subscription, changes, missed: 0 });
        }
    }

    /// The rig sends something.
    pub fn report(&mut self, event: SubscriptionEvent) {
        self.shell.receive(RigMessage::Event(event));
        self.answer();
    }

    /// A key.
    pub fn key(&mut self, code: KeyCode) -> &mut DashboardSetup {
        self.shell.key(KeyEvent::new(code, KeyModifiers::NONE));
        self.answer();
        self
    }

    /// A key with Control.
    pub fn control(&mut self, key: char) -> &mut DashboardSetup {
        self.shell.key(KeyEvent::new(KeyCode::Char(key), KeyModifiers::CONTROL));
        self.answer();
        self
    }

    /// Characters, one key after the other.
    pub fn press(&mut self, keys: &str) -> &mut DashboardSetup {
        for key in keys.chars() {
            self.key(KeyCode::Char(key));
        }
        self
    }

    /// A line after a prompt.
    pub fn enter(&mut self, line: &str) -> &mut DashboardSetup {
        self.press(line).key(KeyCode::Enter)
    }

    /// The left button of the mouse, on the first place where the screen shows this.
    pub fn click(&mut self, text: &str) -> &mut DashboardSetup {
        let screen = self.screen();
        let found = screen.lines().enumerate().find_map(|(row, line)| {
            line.find(text).map(|at| (line[..at].chars().count() as u16, row as u16))
        });
        let (column, row) = found.unwrap_or_else(|| panic!("no `{text}` in\n{screen}"));
        let kind = MouseEventKind::Down(MouseButton::Left);
        self.shell.mouse(MouseEvent { kind, column, row, modifiers: KeyModifiers::NONE });
        self.answer();
        self
    }

    /// What is shown, without spaces at the ends of rows.
    pub fn screen(&mut self) -> String {
        self.terminal.draw(|frame| self.shell.draw(frame)).unwrap();
        let buffer = self.terminal.backend().buffer();
        let width = usize::from(buffer.area.width);
        let rows = buffer.content.chunks(width).map(|row| {
            let row: String = row.iter().map(|cell| cell.symbol()).collect();
            format!("{}\n", row.trim_end())
        });
        rows.collect()
    }

    /// Whether some part of a row is shown in reverse, or with a weight, that holds this text.
    pub fn stands_out(&mut self, text: &str) -> bool {
        let screen = self.screen();
        let buffer = self.terminal.backend().buffer();
        screen.lines().enumerate().any(|(row, line)| {
            line.find(text).is_some_and(|at| {
                let column = line[..at].chars().count() as u16;
                let style = buffer[(column, row as u16)].style();
                !style.add_modifier.is_empty()
                    || style.bg.is_some_and(|bg| bg != ratatui::style::Color::Reset)
            })
        })
    }
}

/// A signal as a rig describes it.
fn signal(number: u32, name: &str) -> Signal {
    let (kind, name) = (SignalKind::Int, name.to_owned());
    Signal { number, name, kind, unit: String::new(), labels: Vec::new(), writable: false }
}
