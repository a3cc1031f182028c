//! The loop: what comes from the terminal and from the rig goes into the shell, frames and requests come out.

use crate::glyphs::Look;
use crate::link::{Asking, Came, listen};
use crate::recording::Files;
use crate::shell::{Heard, Shell, Want};
use crate::terminal::Screen;
use crate::views;
use control::{Clock, Message};
use ratatui::crossterm::event::{self, Event, KeyEventKind};
use std::io;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError, SyncSender};
use std::time::{Duration, Instant};

/// The time between two frames while only the rig tells something.
const FRAME: Duration = Duration::from_millis(100);

/// The time between two frames while somebody types.
const QUICK: Duration = Duration::from_millis(25);

/// How long a signal of the system may go unseen, and the time between two frames while the rig says nothing and its
/// indicators flash.
const LOOK_UP: Duration = Duration::from_millis(250);

/// How long the rig may take to answer that somebody leaves.
const GOODBYE: Duration = Duration::from_secs(2);

/// What waits to be taken into account. The thread that listens waits when it is full, and then the rig leaves out what
/// it would tell; nothing grows.
const WAITING: usize = 1_024;

/// How the dashboard is run.
#[derive(Debug)]
pub struct Setting<'a> {
    /// The socket of the rig.
    pub socket: PathBuf,
    /// Who keeps recordings.
    pub files: Box<dyn Files>,
    /// What the terminal can show.
    pub look: Look,
    /// Whether the mouse is used; else it is left to the terminal, which can mark text with it.
    pub mouse: bool,
    /// The rig was started for this dashboard and ends with it.
    pub own: bool,
    /// Set when the dashboard is to end at once.
    pub stop: &'a AtomicBool,
    /// Stops this process until somebody lets it go on, as ctrl-z does.
    pub suspend: fn(),
}

/// What wakes the loop.
#[derive(Debug)]
enum Woken {
    Terminal(io::Result<Event>),
    Rig(Came),
}

impl From<Came> for Woken {
    fn from(came: Came) -> Self {
        Woken::Rig(came)
    }
}

/// Runs the dashboard on this process's terminal until somebody leaves.
///
/// # Errors
/// A terminal that cannot be had, or is gone.
pub fn run(setting: Setting<'_>) -> io::Result<()> {
    let (tell, woken) = mpsc::sync_channel(WAITING);
    // Closed when this function returns.
    let (_end, ended) = mpsc::channel();
    let screen = Screen::take(setting.mouse)?;
    let to_loop = tell.clone();
    let socket = setting.socket.clone();
    std::thread::Builder::new().name("rig".to_owned()).spawn(move || listen(socket, &to_loop, &ended))?;
    std::thread::Builder::new().name("terminal".to_owned()).spawn(move || read(&tell))?;
    let shell = Shell::new(views::all(setting.files), setting.look, setting.own);
    let now = Instant::now();
    let mut dash = Dash { shell, screen, asking: Asking::default(), told: now, leaving: None };
    let mut drawn = now;
    let mut due = Some(now);
    loop {
        let now = Instant::now();
        if due.is_some_and(|due| due <= now) {
            dash.draw()?;
            drawn = now;
            due = dash.is_moving().then(|| drawn + LOOK_UP);
        }
        let wait = due.map_or(LOOK_UP, |due| due.saturating_duration_since(now).min(LOOK_UP));
        match woken.recv_timeout(wait) {
            Ok(first) => {
                // All that waits makes one frame.
                for one in std::iter::once(first).chain(woken.try_iter().take(WAITING)) {
                    let after = drawn + if matches!(one, Woken::Terminal(_)) { QUICK } else { FRAME };
                    due = Some(due.map_or(after, |due| due.min(after)));
                    dash.take(one)?;
                }
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        }
        if dash.settle(setting.suspend)? || setting.stop.load(Ordering::Relaxed) {
            return Ok(());
        }
    }
}

/// Reads keys until the terminal is gone.
fn read(tell: &SyncSender<Woken>) {
    loop {
        let event = event::read();
        let gone = event.is_err();
        if tell.send(Woken::Terminal(event)).is_err() || gone {
            return;
        }
    }
}

/// The shell with its terminal and its connection.
#[derive(Debug)]
struct Dash {
    shell: Shell,
    screen: Screen,
    asking: Asking,
    /// When the rig told something last.
    told: Instant,
    /// When somebody said goodbye.
    leaving: Option<Instant>,
}

impl Dash {
    fn draw(&mut self) -> io::Result<()> {
        let passed = i64::try_from(self.told.elapsed().as_nanos()).unwrap_or(i64::MAX);
        self.shell.pass(passed);
        self.screen.terminal.draw(|frame| self.shell.draw(frame)).map(drop)
    }

    /// Whether something moves on the screen although the rig says nothing: its indicators flash by the clock.
    fn is_moving(&self) -> bool {
        let model = self.shell.model();
        model.description.clock == Clock::Real && model.status.leds.iter().any(|led| led.times.is_some())
    }

    fn take(&mut self, woken: Woken) -> io::Result<()> {
        match woken {
            Woken::Terminal(event) => match event? {
                Event::Key(key) if key.kind != KeyEventKind::Release => self.shell.key(key),
                Event::Mouse(mouse) => self.shell.mouse(mouse),
                Event::Paste(text) => self.shell.paste(&text),
                _ => {}
            },
            Woken::Rig(Came::Found(greeting, sender)) => {
                self.asking.found(sender);
                self.shell.hear(Heard::Found(greeting));
            }
            Woken::Rig(Came::Lost(error)) => {
                self.asking.lost();
                self.shell.hear(Heard::Lost(error.to_string()));
            }
            Woken::Rig(Came::Message(Message::Event(event))) => {
                if let control::Event::Status { .. } = event {
                    self.told = Instant::now();
                }
                self.shell.hear(Heard::Event(event));
            }
            Woken::Rig(Came::Message(Message::Reply(mut reply))) => {
                reply.id = reply.id.and_then(|sent| self.asking.answered(sent));
                self.shell.hear(Heard::Reply(reply));
            }
        }
        Ok(())
    }

    /// Sends what is to be sent, and does what the shell wants of the program around it. Whether it is over.
    fn settle(&mut self, suspend: fn()) -> io::Result<bool> {
        for request in self.shell.take_requests() {
            if let control::Ask::Leave { .. } = request.ask {
                self.leaving.get_or_insert_with(Instant::now);
            }
            self.asking.ask(request.id, request.ask);
        }
        for want in self.shell.take_wants() {
            match want {
                Want::End => return Ok(true),
                Want::Redraw => self.screen.redraw()?,
                Want::Suspend => self.screen.lend(suspend)?,
            }
        }
        Ok(self.leaving.is_some_and(|since| since.elapsed() > GOODBYE))
    }
}
