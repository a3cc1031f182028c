//! `rig board watch`: lines as they change, with counts and times.

use super::bench::{Bench, failed, listening, seconds};
use super::tally::{News, Tally, loss, row, table};
use crate::exit::Exit;
use crate::output;
use clap::Args;
use drivers::{Board, BoardEvent, Channel, Surroundings};
use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use signal::{Span, Time};
use std::io::IsTerminal;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

/// How often a terminal is drawn anew at most.
const REDRAW: Span = Span::from_millis(100);

/// Set by the first interrupt.
static INTERRUPT: AtomicBool = AtomicBool::new(false);

/// `rig board watch`.
#[derive(Debug, Args)]
pub struct WatchArgs {
    /// The board file.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Watch for so long [default: until it is interrupted].
    #[arg(long = "for", value_name = "TIME", value_parser = super::above_zero)]
    lasts: Option<Span>,
}

/// Watches lines. Those that the rig would drive are left alone, unless another line tells of them.
pub fn run(args: &WatchArgs) -> Exit {
    try_run(args).unwrap_or_else(|exit| exit)
}

fn try_run(args: &WatchArgs) -> Result<Exit, Exit> {
    let bench = Bench::read(&args.file)?;
    let watched = bench.some(|_, line| listening(line));
    let left: Vec<&str> = (0..bench.file.circuit.channels.len())
        .map(|at| bench.name(at))
        .filter(|name| watched.find(name).is_none())
        .collect();
    if !left.is_empty() {
        let what = if left.len() == 1 { "is an output" } else { "are outputs" };
        output::note(&format!("{} {what} and left alone: to watch would be to let go", left.join(", ")));
    }
    let surroundings = Surroundings::new(host::Realtime::default());
    let bell = surroundings.bell.clone();
    let handled = ctrlc::set_handler(move || {
        INTERRUPT.store(true, Ordering::Relaxed);
        bell.ring();
    });
    if let Err(error) = handled {
        output::complain(&format!("interrupts cannot be handled: {error}"));
        return Err(Exit::Error);
    }
    let mut board = bench.open(&watched, &surroundings)?;
    let mut tallies = vec![Tally::default(); board.channels().len()];
    let outcome = follow(&mut *board, &surroundings, args.lasts, &mut tallies);
    output::print(&format!("\n{}", table(board.channels(), &tallies)));
    outcome.map(|()| if board.health().is_sound() { Exit::Passed } else { Exit::Error })
}

/// Takes what happens until the end.
fn follow(
    board: &mut dyn Board,
    surroundings: &Surroundings,
    lasts: Option<Span>,
    tallies: &mut [Tally],
) -> Result<(), Exit> {
    let channels = board.channels().to_vec();
    let mut view = View::new(&channels);
    let mut events = Vec::new();
    let end = lasts.map(|lasts| surroundings.time.now() + lasts);
    loop {
        let now = surroundings.time.now();
        // What happened before the end is told.
        let over = end.is_some_and(|end| now >= end) || INTERRUPT.load(Ordering::Relaxed);
        board.poll(now, &mut events).map_err(failed)?;
        for event in events.drain(..) {
            let at = usize::from(event.channel().0);
            let (Some(channel), Some(tally)) = (channels.get(at), tallies.get_mut(at)) else { continue };
            let news = tally.take(&event);
            view.tell(at, channel, news, &event);
        }
        view.draw(&channels, tallies, now);
        if over {
            return Ok(());
        }
        let due = [end, view.due()].into_iter().flatten().min();
        surroundings.bell.wait_until(due.map_or(i64::MAX, |due| surroundings.time.stamp(due)));
    }
}

/// Where changes are shown: a table that is drawn anew, or a line each.
#[derive(Debug)]
struct View {
    /// The rows on a terminal.
    rows: Option<(MultiProgress, Vec<ProgressBar>)>,
    wide: usize,
    /// Rows that do not show what is.
    stale: Vec<bool>,
    drawn: Option<Time>,
}

impl View {
    fn new(channels: &[Channel]) -> View {
        let wide = channels.iter().map(|channel| channel.name.len()).max().unwrap_or(0);
        let terminal = std::io::stdout().is_terminal() && std::io::stderr().is_terminal();
        let rows = terminal.then(|| {
            let screen = MultiProgress::with_draw_target(ProgressDrawTarget::stderr());
            let style = ProgressStyle::with_template("{wide_msg}");
            let style = style.unwrap_or_else(|_| ProgressStyle::default_spinner());
            let row = |_: &Channel| screen.add(ProgressBar::new_spinner().with_style(style.clone()));
            let rows = channels.iter().map(row).collect();
            (screen, rows)
        });
        View { rows, wide, stale: vec![false; channels.len()], drawn: None }
    }

    /// Something happened on a channel.
    fn tell(&mut self, at: usize, channel: &Channel, news: News, event: &BoardEvent) {
        if news == News::Nothing {
            return;
        }
        if let Some(stale) = self.stale.get_mut(at) {
            *stale = true;
        }
        if self.rows.is_none() {
            let what = match news {
                News::First(level) | News::Change(level, _) => u8::from(level).to_string(),
                News::Lost(reason) => loss(reason).to_owned(),
                News::Returned => "back".to_owned(),
                News::Dropped(count) => format!("{count} missed"),
                News::Nothing => return,
            };
            output::print(&format!("{:>14}  {}  {what}\n", seconds(event.latest()), channel.name));
        }
    }

    /// Draws rows that are not up to date, unless they were drawn a moment ago.
    fn draw(&mut self, channels: &[Channel], tallies: &[Tally], now: Time) {
        let Some((_, rows)) = &self.rows else { return };
        if self.due().is_some_and(|due| now < due) {
            return;
        }
        for (at, row_of) in rows.iter().enumerate() {
            let (Some(stale), Some(channel), Some(tally)) =
                (self.stale.get_mut(at), channels.get(at), tallies.get(at))
            else {
                continue;
            };
            if std::mem::take(stale) {
                row_of.set_message(row(channel, tally, self.wide));
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

impl Drop for View {
    fn drop(&mut self) {
        if let Some((screen, rows)) = &self.rows {
            rows.iter().for_each(ProgressBar::finish_and_clear);
            // A terminal that cannot be cleared is no fault of the lines.
            let _ = screen.clear();
        }
    }
}
