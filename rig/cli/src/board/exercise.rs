//! `rig board exercise`: one output at a time, and what comes back.

use super::activity::{ActivityChange, ChannelActivity, loss};
use super::real_board_file::{OtherDevices, RealBoardFile, failed, listening};
use crate::bench_lock::BenchLockArgs;
use crate::exit::ExitStatus;
use crate::operator::TerminalOperator;
use crate::output;
use clap::Args;
use document::{Diagnostic, suggest};
use drivers::gpio::{Direction, LineSpec};
use drivers::{Board, BoardEvent, BoardExt, Channel, ChannelId};
use guard::GuardError;
use plans::steps::Question;
use runtime::{AskError, Hardware, Operator};
use signal::{Span, Time, Value, When};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

/// Nobody is there to agree.
const NO_CONSENT: &str = "R0245";
/// A channel that no output is.
const NO_OUTPUT: &str = "R0246";

/// How long an interrupt may go unseen while an output has its turn.
const LOOK_UP: Span = Span::from_millis(50);

/// Set by the first interrupt.
static INTERRUPT: AtomicBool = AtomicBool::new(false);

/// `rig board exercise`.
#[derive(Debug, Args)]
pub struct ExerciseArgs {
    /// The board file.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Drive these outputs without asking, and no others.
    #[arg(long, value_name = "CHANNEL,...", value_delimiter = ',')]
    yes: Vec<String>,
    /// How long an output stays at its other level.
    #[arg(long, value_name = "TIME", default_value = "500 ms", value_parser = crate::duration::above_zero)]
    hold: Span,
    /// What it does while another run uses the lines.
    #[command(flatten)]
    wait: BenchLockArgs,
}

/// Drives outputs, one after the other, each only with consent. An output is claimed while it has its turn, and safe
/// before and after it; no other one is touched.
pub fn run(args: &ExerciseArgs) -> ExitStatus {
    try_run(args).unwrap_or_else(|exit| exit)
}

fn try_run(args: &ExerciseArgs) -> Result<ExitStatus, ExitStatus> {
    let bench = RealBoardFile::read(&args.file)?;
    let outputs: Vec<usize> = (0..bench.file.circuit.channels.len())
        .filter(|at| bench.line(*at).is_some_and(|line| line.direction == Direction::Output))
        .collect();
    let operator = consent(args, &bench, &outputs)?;
    let handled = ctrlc::set_handler(|| INTERRUPT.store(true, Ordering::Relaxed));
    if let Err(error) = handled {
        output::error(&format!("interrupts cannot be handled: {error}"));
        return Err(ExitStatus::Error);
    }
    let _lock = args.wait.take(&bench.file, &INTERRUPT)?;
    let mut sound = true;
    for at in outputs {
        let agreed = match &operator {
            None => args.yes.iter().any(|name| name == bench.name(at)),
            Some(operator) => match ask_consent(operator, &bench, at, args.hold) {
                Ok(answer) => answer,
                Err(AskError::Interrupted) => return Err(ExitStatus::Interrupted),
                Err(AskError::Nobody) => return Err(nobody()),
            },
        };
        if agreed {
            sound &= exercise_output(&bench, at, args.hold)?;
        }
        if INTERRUPT.load(Ordering::Relaxed) {
            return Err(ExitStatus::Interrupted);
        }
    }
    Ok(if sound { ExitStatus::Passed } else { ExitStatus::Error })
}

/// Who is asked: nobody where the command line agrees for them.
fn consent(
    args: &ExerciseArgs,
    bench: &RealBoardFile,
    outputs: &[usize],
) -> Result<Option<TerminalOperator>, ExitStatus> {
    let names: Vec<&str> = outputs.iter().map(|at| bench.name(*at)).collect();
    let wrong = |name: &String| {
        let help = match (suggest(name, names.iter().copied()), names.is_empty()) {
            (Some(meant), _) => format!("did you mean `{meant}`?"),
            (None, false) => format!("its outputs are {}", names.join(", ")),
            (None, true) => {
                "it has no outputs: a channel is one with `drives = true`, or bound to a %Q".to_owned()
            }
        };
        Diagnostic::error(NO_OUTPUT, format!("`{name}` is no output of the board")).help(help)
    };
    let strange: Vec<Diagnostic> =
        args.yes.iter().filter(|name| !names.contains(&name.as_str())).map(wrong).collect();
    if !strange.is_empty() {
        return Err(bench.wrong(&strange));
    }
    if !args.yes.is_empty() {
        return Ok(None);
    }
    match (TerminalOperator::if_present(), names.is_empty()) {
        (_, true) => {
            output::note("the board has no outputs, so there is nothing to exercise");
            Err(ExitStatus::Passed)
        }
        (Some(operator), false) => Ok(Some(operator)),
        (None, false) => Err(nobody()),
    }
}

fn nobody() -> ExitStatus {
    let found =
        Diagnostic::error(NO_CONSENT, "an output moves only with consent, and nobody can be asked here")
            .help("run it on a terminal, or name the outputs that may move: --yes CHANNEL,...");
    output::findings(&[found], &[]);
    ExitStatus::UserFiles
}

fn ask_consent(
    operator: &TerminalOperator,
    bench: &RealBoardFile,
    at: usize,
    hold: Span,
) -> Result<bool, AskError> {
    let safe = bench.line(at).is_some_and(|line| line.safe);
    let what = bench.relay(at).map_or_else(String::new, |what| format!("it {what}: "));
    let text = format!("{what}drive it from {} to {} for {hold}, and back?", u8::from(safe), u8::from(!safe));
    let answers = ["no", "yes"].map(str::to_owned).to_vec();
    let question = Question { text, photo: None, answers, pass: 1 };
    operator.ask(bench.name(at), &question, &INTERRUPT).map(|answer| answer == 1)
}

/// Drives an output and reports what came back. `false` where the rig lost something on the way.
fn exercise_output(bench: &RealBoardFile, at: usize, hold: Span) -> Result<bool, ExitStatus> {
    let keep = |other, line: &LineSpec| if other == at { Some(line.clone()) } else { listening(line) };
    let board = bench.subset(keep, OtherDevices::Excluded);
    // As in a run: with the guard watching the output, if the file has one.
    let opened = Hardware::open(&board).map_err(|found| bench.wrong(&found))?;
    // Only a simulated board has nothing to open, and such files were refused.
    let hardware = opened.ok_or(ExitStatus::UserFiles)?;
    // A host that is busy is not to look like a rig that hangs.
    let _entered = hardware.enter();
    let mut board = hardware.lease();
    let time = &hardware.surroundings().time;
    board.start(time.now()).map_err(failed)?;
    let name = bench.name(at);
    let driven = board.find(name).ok_or(ExitStatus::Error)?;
    let safe = bench.line(at).is_some_and(|line| line.safe);
    let mut responses = ResponseRecorder::new(board.channels());
    if let Some(heartbeat) = hardware.heartbeat() {
        heartbeat.begin().map_err(unguarded)?;
    }
    let outcome = (|| {
        // What moves by itself is no answer.
        responses.listen(&mut board, &hardware, hold)?;
        responses.note_restless();
        let what = bench.relay(at).map_or_else(String::new, |what| format!(", which {what}"));
        output::print(&format!("{name}{what}\n"));
        for level in [!safe, safe] {
            let now = time.now();
            board.write(now, &[(driven, Value::Bool(level))]).map_err(failed)?;
            responses.began(now);
            responses.listen(&mut board, &hardware, hold)?;
            output::print(&responses.answer(board.channels(), driven, level));
        }
        Ok(())
    })();
    // Whatever happened, the output is left safe; and what happened first is what is said.
    let made_safe = board.safe(time.now()).map_err(failed);
    let let_go = hardware.heartbeat().map_or(Ok(()), |heartbeat| heartbeat.end().map_err(unguarded));
    outcome.and(made_safe).and(let_go)?;
    Ok(board.health().is_sound())
}

/// Reports why the guard does not watch over the output.
fn unguarded(error: GuardError) -> ExitStatus {
    let found = Diagnostic::error(error.code(), error.to_string()).help(error.help());
    output::findings(&[found], &[]);
    ExitStatus::Error
}

/// What the channels answer.
#[derive(Debug)]
struct ResponseRecorder {
    activities: Vec<ChannelActivity>,
    /// Channels that moved while nothing was driven.
    restless: Vec<bool>,
    /// The first change of each channel since the output was driven.
    first: Vec<Option<(bool, When)>>,
    lost: Vec<ActivityChange>,
    driven: Time,
    events: Vec<BoardEvent>,
}

impl ResponseRecorder {
    fn new(channels: &[Channel]) -> ResponseRecorder {
        let count = channels.len();
        ResponseRecorder {
            activities: vec![ChannelActivity::default(); count],
            restless: vec![false; count],
            first: vec![None; count],
            lost: vec![ActivityChange::Nothing; count],
            driven: Time::ZERO,
            events: Vec::new(),
        }
    }

    /// Records what happens for so long, or until an interrupt.
    fn listen(&mut self, board: &mut dyn Board, hardware: &Hardware, lasts: Span) -> Result<(), ExitStatus> {
        let (surroundings, heartbeat) = (hardware.surroundings(), hardware.heartbeat());
        let end = surroundings.time.now() + lasts;
        let look_up = heartbeat.map_or(LOOK_UP, |heartbeat| heartbeat.every().min(LOOK_UP));
        loop {
            let now = surroundings.time.now();
            if let Some(heartbeat) = heartbeat {
                heartbeat.beat().map_err(unguarded)?;
            }
            let over = now >= end || INTERRUPT.load(Ordering::Relaxed);
            board.poll(now, &mut self.events).map_err(failed)?;
            for event in self.events.drain(..) {
                let at = usize::from(event.channel().0);
                let Some(tally) = self.activities.get_mut(at) else { continue };
                match tally.take(&event) {
                    ActivityChange::Change(level, when) => {
                        if let Some(first) = self.first.get_mut(at) {
                            first.get_or_insert((level, when));
                        }
                    }
                    news @ (ActivityChange::Lost(_) | ActivityChange::Dropped(_)) => {
                        if let Some(lost) = self.lost.get_mut(at) {
                            *lost = news;
                        }
                    }
                    ActivityChange::First(_)
                    | ActivityChange::Quantity(_)
                    | ActivityChange::Returned
                    | ActivityChange::Nothing => {}
                }
            }
            if over {
                return Ok(());
            }
            surroundings.bell.wait_until(surroundings.time.stamp(end.min(now + look_up)));
        }
    }

    /// What changed so far moves by itself.
    fn note_restless(&mut self) {
        for (restless, first) in self.restless.iter_mut().zip(&self.first) {
            *restless |= first.is_some();
        }
    }

    /// The output was driven at this instant: what is heard from now on may be an answer.
    fn began(&mut self, now: Time) {
        self.driven = now;
        self.first.fill(None);
        self.lost.fill(ActivityChange::Nothing);
    }

    /// What came back, in lines.
    fn answer(&self, channels: &[Channel], driven: ChannelId, level: bool) -> String {
        let mut lines = Vec::new();
        for (at, channel) in channels.iter().enumerate() {
            let own = usize::from(driven.0) == at;
            match self.lost.get(at) {
                Some(ActivityChange::Lost(reason)) => {
                    lines.push(format!("{} is {}", channel.name, loss(*reason)))
                }
                Some(ActivityChange::Dropped(count)) => {
                    lines.push(format!("{}: {count} missed", channel.name))
                }
                _ => {}
            }
            let Some(Some((to, when))) = self.first.get(at) else { continue };
            let within = when.latest - self.driven;
            let what = match (own, *to) {
                // An output says when it was driven, or what the line that reads it back saw.
                (true, _) => continue,
                (false, true) => "rises",
                (false, false) => "falls",
            };
            let restless =
                if self.restless.get(at) == Some(&true) { ", but it moves by itself, too" } else { "" };
            lines.push(format!("{} {what} within {within}{restless}", channel.name));
        }
        let came = self.activities.get(usize::from(driven.0)).and_then(|tally| tally.level);
        if came != Some(level) {
            lines.insert(0, "the line did not follow".to_owned());
        }
        if lines.is_empty() {
            lines.push("nothing else moved".to_owned());
        }
        let first = format!("  to {}: ", u8::from(level));
        let rest = " ".repeat(first.len());
        let line = |(at, line): (usize, &String)| format!("{}{line}\n", if at == 0 { &first } else { &rest });
        lines.iter().enumerate().map(line).collect()
    }
}
