//! The loop: what comes from the terminal and from the rig goes into the shell, frames and requests come out.

use crate::glyphs::TerminalFeatures;
use crate::link::{LinkEvent, RequestSender, listen};
use crate::recording::TrendFiles;
use crate::shell::{LoopCommand, RigMessage, Shell};
use crate::terminal::TerminalScreen;
use crate::views;
use control::{ServerMessage, TimeSource};
use ratatui::crossterm::event::{self, Event, KeyEventKind};
use std::io;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError, SyncSender};
use std::time::{Duration, Instant};

/// The time between two frames while only the rig sends something.
const FRAME: Duration = Duration::from_millis(100);

/// The time between two frames while somebody types.
const TYPING_FRAME: Duration = Duration::from_millis(25);

/// How long a signal of the system may go unseen, and the time between two frames while the rig says nothing and its
/// indicators flash.
const IDLE_FRAME: Duration = Duration::from_millis(250);

/// How long the rig may take to answer that somebody leaves.
const LEAVE_TIMEOUT: Duration = Duration::from_secs(2);

/// What waits to be taken into account. The thread that listens waits when it is full, and then the rig leaves out what
/// it would send; nothing grows.
const QUEUE: usize = 1_024;

/// How the dashboard is run.
#[derive(Debug)]
pub struct DashboardSettings<'a> {
    /// The socket of the rig.
    pub socket: PathBuf,
    /// Who keeps recordings.
    pub files: Box<dyn TrendFiles>,
    /// What the terminal can show.
    pub features: TerminalFeatures,
    /// Whether the mouse is used; else it is left to the terminal, which can mark text with it.
    pub mouse: bool,
    /// The rig was started for this dashboard and ends with it.
    pub owns_rig: bool,
    /// Set when the dashboard is to end at once.
    pub stop: &'a AtomicBool,
    /// Stops this process until somebody lets it go on, as ctrl-z does.
    pub suspend: fn(),
}

/// What wakes the loop.
#[derive(Debug)]
enum LoopEvent {
    Terminal(io::Result<Event>),
    Rig(LinkEvent),
}

impl From<LinkEvent> for LoopEvent {
    fn from(came: LinkEvent) -> Self {
        LoopEvent::Rig(came)
    }
}

/// Runs the dashboard on this process's terminal until somebody leaves.
///
/// # Errors
/// A terminal that cannot be had, or is gone.
pub fn run(settings: DashboardSettings<'_>) -> io::Result<()> {
    let (events_in, events) = mpsc::sync_channel(QUEUE);
    // Closed when this function returns.
    let (_end, ended) = mpsc::channel();
    let screen = TerminalScreen::take(settings.mouse)?;
    let to_loop = events_in.clone();
    let socket = settings.socket.clone();
    std::thread::Builder::new().name("rig".to_owned()).spawn(move || listen(socket, &to_loop, &ended))?;
    std::thread::Builder::new().name("terminal".to_owned()).spawn(move || read(&events_in))?;
    let shell = Shell::new(views::all(settings.files), settings.features, settings.owns_rig);
    let now = Instant::now();
    let mut dash =
        Dashboard { shell, screen, requests: RequestSender::default(), last_status: now, leaving: None };
    let mut drawn = now;
    let mut due = Some(now);
    loop {
        let now = Instant::now();
        if due.is_some_and(|due| due <= now) {
            dash.draw()?;
            drawn = now;
            due = dash.is_moving().then(|| drawn + IDLE_FRAME);
        }
        let wait = due.map_or(IDLE_FRAME, |due| due.saturating_duration_since(now).min(IDLE_FRAME));
        match events.recv_timeout(wait) {
            Ok(first) => {
                // All that waits makes one frame.
                for one in std::iter::once(first).chain(events.try_iter().take(QUEUE)) {
                    let after =
                        drawn + if matches!(one, LoopEvent::Terminal(_)) { TYPING_FRAME } else { FRAME };
                    due = Some(due.map_or(after, |due| due.min(after)));
                    dash.take(one)?;
                }
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        }
        if dash.settle(settings.suspend)? || settings.stop.load(Ordering::Relaxed) {
            return Ok(());
        }
    }
}

/// Reads keys until the terminal is gone.
fn read(events_in: &SyncSender<LoopEvent>) {
    loop {
        let event = event::read();
        let gone = event.is_err();
        if events_in.send(LoopEvent::Terminal(event)).is_err() || gone {
            return;
        }
    }
}

/// The shell with its terminal and its connection.
#[derive(Debug)]
struct Dashboard {
    shell: Shell,
    screen: TerminalScreen,
    requests: RequestSender,
    /// When the rig sent its last status.
    last_status: Instant,
    /// When somebody said goodbye.
    leaving: Option<Instant>,
}

impl Dashboard {
    fn draw(&mut self) -> io::Result<()> {
        let passed = i64::try_from(self.last_status.elapsed().as_nanos()).unwrap_or(i64::MAX);
        self.shell.pass(passed);
        self.screen.terminal.draw(|frame| self.shell.draw(frame)).map(drop)
    }

    /// Whether something moves on the screen although the rig says nothing: its indicators flash by the clock.
    fn is_moving(&self) -> bool {
        let model = self.shell.model();
        model.description.clock == TimeSource::Real && model.status.leds.iter().any(|led| led.times.is_some())
    }

    fn take(&mut self, event: LoopEvent) -> io::Result<()> {
        match event {
            LoopEvent::Terminal(event) => match event? {
                Event::Key(key) if key.kind != KeyEventKind::Release => self.shell.key(key),
                Event::Mouse(mouse) => self.shell.mouse(mouse),
                Event::Paste(text) => self.shell.paste(&text),
                _ => {}
            },
            LoopEvent::Rig(LinkEvent::Connected(greeting, sender)) => {
                self.requests.connected(sender);
                self.shell.receive(RigMessage::Connected(greeting));
            }
            LoopEvent::Rig(LinkEvent::Disconnected(error)) => {
                self.requests.disconnected();
                self.shell.receive(RigMessage::Disconnected(error.to_string()));
            }
            LoopEvent::Rig(LinkEvent::Message(ServerMessage::Event(event))) => {
                if let control::SubscriptionEvent::Status { .. } = event {
                    self.last_status = Instant::now();
                }
                self.shell.receive(RigMessage::Event(event));
            }
            LoopEvent::Rig(LinkEvent::Message(ServerMessage::Reply(mut reply))) => {
                reply.id = reply.id.and_then(|sent| self.requests.number_of(sent));
                self.shell.receive(RigMessage::Reply(reply));
            }
        }
        Ok(())
    }

    /// Sends what is to be sent, and does what the shell wants of the program around it. Whether it is over.
    fn settle(&mut self, suspend: fn()) -> io::Result<bool> {
        for request in self.shell.take_requests() {
            if let control::RequestOperation::Leave { .. } = request.ask {
                self.leaving.get_or_insert_with(Instant::now);
            }
            self.requests.send(request.id, request.ask);
        }
        for want in self.shell.take_loop_commands() {
            match want {
                LoopCommand::End => return Ok(true),
                LoopCommand::Redraw => self.screen.redraw()?,
                LoopCommand::Suspend => self.screen.lend(suspend)?,
            }
        }
        Ok(self.leaving.is_some_and(|since| since.elapsed() > LEAVE_TIMEOUT))
    }
}
