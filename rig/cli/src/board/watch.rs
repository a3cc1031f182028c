//! `rig board watch`: lines, quantities and buses as they change, with counts and times.

use super::activity::{ActivityChange, ChannelActivity, loss, quantity, row, table};
use super::real_board_file::{OtherDevices, RealBoardFile, failed, listening, seconds};
use super::traffic::{self, Traffic};
use crate::exit::ExitStatus;
use crate::output;
use clap::Args;
use drivers::{Board, BoardContext, BoardEvent, BoardExt, Bus, Channel, ChannelId, ChannelKind};
use host::HostInstant;
use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use signal::{Span, Time};
use std::io::IsTerminal;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

/// How often a terminal is drawn again at most.
const REDRAW: Span = Span::from_millis(100);

/// Set by the first interrupt.
static INTERRUPT: AtomicBool = AtomicBool::new(false);

/// `rig board watch`.
#[derive(Debug, Args)]
pub struct BoardWatchArgs {
    /// The board file.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Watch for so long [default: until it is interrupted].
    #[arg(long = "for", value_name = "TIME", value_parser = crate::duration::above_zero)]
    lasts: Option<Span>,
}

/// Watches lines. Those that the rig would drive are left alone, unless another line reports them.
pub fn run(args: &BoardWatchArgs) -> ExitStatus {
    try_run(args).unwrap_or_else(|exit| exit)
}

fn try_run(args: &BoardWatchArgs) -> Result<ExitStatus, ExitStatus> {
    let bench = RealBoardFile::read(&args.file)?;
    let watched = bench.subset(|_, line| listening(line), OtherDevices::Included);
    let left: Vec<&str> = (0..bench.file.circuit.channels.len())
        .map(|at| bench.name(at))
        .filter(|name| watched.find(name).is_none())
        .collect();
    if !left.is_empty() {
        let what = if left.len() == 1 { "is an output" } else { "are outputs" };
        output::note(&format!("{} {what} and left alone: to watch would be to let go", left.join(", ")));
    }
    let surroundings = BoardContext::new(host::Realtime::default());
    let bell = surroundings.bell.clone();
    let handled = ctrlc::set_handler(move || {
        INTERRUPT.store(true, Ordering::Relaxed);
        bell.ring();
    });
    if let Err(error) = handled {
        output::error(&format!("interrupts cannot be handled: {error}"));
        return Err(ExitStatus::Error);
    }
    let mut board = bench.open(&watched, &surroundings)?;
    let mut tallies = vec![ChannelActivity::default(); board.channels().len()];
    let mut traffics = vec![Traffic::default(); board.bus_list().len()];
    let outcome = follow(&mut *board, &surroundings, args.lasts, &mut tallies, &mut traffics);
    output::print("\n");
    if !tallies.is_empty() {
        output::print(&table(board.channels(), &tallies));
    }
    let wide = widest(board.channels(), board.bus_list());
    for (bus, traffic) in board.bus_list().iter().zip(&traffics) {
        output::print(&format!("{}\n", traffic::row(bus, traffic, wide)));
    }
    outcome.map(|()| if board.health().is_sound() { ExitStatus::Passed } else { ExitStatus::Error })
}

/// Takes what happens until the end.
fn follow(
    board: &mut dyn Board,
    surroundings: &BoardContext,
    lasts: Option<Span>,
    tallies: &mut [ChannelActivity],
    traffics: &mut [Traffic],
) -> Result<(), ExitStatus> {
    let channels = board.channels().to_vec();
    let buses = board.bus_list().to_vec();
    let mut view = WatchScreen::new(&channels, &buses);
    let (mut events, mut passed) = (Vec::new(), Vec::new());
    let end = lasts.map(|lasts| surroundings.time.now() + lasts);
    loop {
        let now = surroundings.time.now();
        // What happened before the end is shown.
        let over = end.is_some_and(|end| now >= end) || INTERRUPT.load(Ordering::Relaxed);
        board.poll(now, &mut events).map_err(failed)?;
        for event in events.drain(..) {
            let at = usize::from(event.channel().0);
            let (Some(channel), Some(tally)) = (channels.get(at), tallies.get_mut(at)) else { continue };
            let news = tally.take(&event);
            view.show_change(at, channel, news, &event);
        }
        for (at, tally) in (0u16..).zip(tallies.iter_mut()) {
            tally.noise = board.noise(ChannelId(at));
        }
        board.poll_buses(now, &mut passed).map_err(failed)?;
        for event in passed.drain(..) {
            let at = usize::from(event.bus().0);
            let (Some(bus), Some(traffic)) = (buses.get(at), traffics.get_mut(at)) else { continue };
            let text = traffic.take(&event);
            view.pass(channels.len() + at, bus, &text, event.latest());
        }
        view.draw(now, |at| match (channels.get(at), tallies.get(at)) {
            (Some(channel), Some(tally)) => Some(row(channel, tally, widest(&channels, &buses))),
            _ => {
                let at = at - channels.len();
                Some(traffic::row(buses.get(at)?, traffics.get(at)?, widest(&channels, &buses)))
            }
        });
        if over {
            return Ok(());
        }
        let due = [end, view.due(), board.next_event()].into_iter().flatten().min();
        surroundings.bell.wait_until(due.map_or(HostInstant::NEVER, |due| surroundings.time.stamp(due)));
    }
}

/// How wide the column of names is.
fn widest(channels: &[Channel], buses: &[Bus]) -> usize {
    let names =
        channels.iter().map(|channel| channel.name.len()).chain(buses.iter().map(|bus| bus.name.len()));
    names.max().unwrap_or(0).max("channel".len())
}

/// Where changes are shown: a table that is drawn again, or a line each.
#[derive(Debug)]
struct WatchScreen {
    /// The rows on a terminal.
    rows: Option<(MultiProgress, Vec<ProgressBar>)>,
    /// Rows that do not show what is.
    stale: Vec<bool>,
    drawn: Option<Time>,
}

impl WatchScreen {
    fn new(channels: &[Channel], buses: &[Bus]) -> WatchScreen {
        let count = channels.len() + buses.len();
        let terminal = std::io::stdout().is_terminal() && std::io::stderr().is_terminal();
        let rows = terminal.then(|| {
            let screen = MultiProgress::with_draw_target(ProgressDrawTarget::stderr());
            let style = ProgressStyle::with_template("{wide_msg}");
            let style = style.unwrap_or_else(|_| ProgressStyle::default_spinner());
            let row = |_| screen.add(ProgressBar::new_spinner().with_style(style.clone()));
            let rows = (0..count).map(row).collect();
            (screen, rows)
        });
        WatchScreen { rows, stale: vec![false; count], drawn: None }
    }

    /// Something happened on a channel.
    fn show_change(&mut self, at: usize, channel: &Channel, news: ActivityChange, event: &BoardEvent) {
        if news == ActivityChange::Nothing {
            return;
        }
        if let Some(stale) = self.stale.get_mut(at) {
            *stale = true;
        }
        if self.rows.is_none() {
            let what = match news {
                ActivityChange::First(level) | ActivityChange::Change(level, _) => {
                    u8::from(level).to_string()
                }
                ActivityChange::Quantity(now) => match &channel.kind {
                    ChannelKind::Analog { unit } => quantity(now, unit),
                    ChannelKind::Count => quantity(now, ""),
                    ChannelKind::Digital => return,
                },
                ActivityChange::Lost(reason) => loss(reason).to_owned(),
                ActivityChange::Returned => "back".to_owned(),
                ActivityChange::Dropped(count) => format!("{count} missed"),
                ActivityChange::Nothing => return,
            };
            output::print(&format!("{:>14}  {}  {what}\n", seconds(event.latest()), channel.name));
        }
    }

    /// Something passed on a bus.
    fn pass(&mut self, at: usize, bus: &Bus, text: &str, when: Time) {
        if let Some(stale) = self.stale.get_mut(at) {
            *stale = true;
        }
        if self.rows.is_none() {
            output::print(&format!("{:>14}  {}  {text}\n", seconds(when), bus.name));
        }
    }

    /// Draws rows that are not up to date, unless they were drawn a moment ago.
    fn draw(&mut self, now: Time, text: impl Fn(usize) -> Option<String>) {
        let Some((_, rows)) = &self.rows else { return };
        if self.due().is_some_and(|due| now < due) {
            return;
        }
        for (at, row_of) in rows.iter().enumerate() {
            let Some(stale) = self.stale.get_mut(at) else { continue };
            if let (true, Some(text)) = (std::mem::take(stale), text(at)) {
                row_of.set_message(output::harmless(&text).into_owned());
                self.drawn = Some(now);
            }
        }
    }

    /// When rows are to be drawn that wait for it.
    fn due(&self) -> Option<Time> {
        let waits = self.rows.is_some() && self.stale.contains(&true);
        waits.then(|| self.drawn.map_or(Time::ZERO, |drawn| drawn + REDRAW))
    }
}

impl Drop for WatchScreen {
    fn drop(&mut self) {
        if let Some((screen, rows)) = &self.rows {
            rows.iter().for_each(ProgressBar::finish_and_clear);
            // A terminal that cannot be cleared is no fault of the lines.
            let _ = screen.clear();
        }
    }
}
