//! What is shown where a case stands still, and the commands that are read there.

use crate::output;
use crate::typed_lines::{TypedLine, TypedLines};
use plans::Case;
use plans::judge::{ClaimProgress, Scenario};
use record::Verdict;
use reports::text::clean;
use runtime::executor::stepping::{Pause, StepTarget, Stepper};
use runtime::suite::board_instrument::clock_error;
use runtime::suite::describe;
use signal::{SignalInfo, Span, Time, Trace, ValueKind};
use std::io::{self, IsTerminal};
use std::sync::atomic::AtomicBool;

/// The commands, as `--help` and `help` list them.
pub const HELP: &str = "\
Commands, also from a script on standard input:
  next, n, an empty line  to the next step of the plan
  until TIME              to an instant, counted from start: until 1.5 s
  run, r                  to the end of the case; the end of the input does the same
  values, v               the values of all signals
  claims, c               what is expected, and how far it is
  quit, q                 end here, with the outputs safe
  help, h                 these commands";

/// What a command asks for.
#[derive(Clone, Debug, PartialEq, Eq)]
enum StepCommand {
    Next,
    Until(Span),
    Run,
    Values,
    Claims,
    Quit,
    Help,
}

impl StepCommand {
    fn parse(line: &str) -> Result<StepCommand, String> {
        let line = line.trim();
        let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let command = match word {
            "" | "n" | "next" => StepCommand::Next,
            "u" | "until" => {
                let time = rest.trim();
                let time =
                    time.strip_prefix("start").map_or(time, |after| after.trim_start_matches([' ', '+']));
                return match Span::parse(time) {
                    Ok(span) => Ok(StepCommand::Until(span)),
                    Err(_) => Err(format!("`{rest}` is not a time: write until 1.5 s, counted from start")),
                };
            }
            "r" | "run" => StepCommand::Run,
            "v" | "values" => StepCommand::Values,
            "c" | "claims" => StepCommand::Claims,
            "q" | "quit" => StepCommand::Quit,
            "h" | "help" | "?" => StepCommand::Help,
            other => {
                let words = ["next", "until", "run", "values", "claims", "quit", "help"];
                let near = document::suggest(other, words).map(|near| format!(": did you mean `{near}`?"));
                return Err(format!("there is no command `{other}`{}", near.unwrap_or_default()));
            }
        };
        if rest.trim().is_empty() { Ok(command) } else { Err(format!("`{word}` takes no argument")) }
    }
}

/// Shows where the case stands and reads commands.
pub struct StepShell<'a> {
    case: &'a Case,
    scenario: Scenario,
    /// Verdicts that were shown, in the order of the claims.
    shown: Vec<bool>,
    quit: bool,
    lines: TypedLines,
    /// Ends a wait for a command.
    interrupt: &'a AtomicBool,
}

impl<'a> StepShell<'a> {
    /// For this case.
    ///
    /// # Errors
    /// The machine has no room for another thread.
    pub fn new(case: &'a Case, interrupt: &'a AtomicBool) -> io::Result<StepShell<'a>> {
        let lines = TypedLines::start()?;
        Ok(StepShell { case, scenario: case.scenario(), shown: Vec::new(), quit: false, lines, interrupt })
    }

    /// Whether the user had enough.
    pub fn has_quit(&self) -> bool {
        self.quit
    }

    /// Where the case stands, what comes, what changed.
    fn show(&mut self, pause: &Pause<'_>) {
        let at = anchor(pause.now, pause.start);
        let what = match pause.step.map(|id| (id, self.case.steps.iter().find(|step| step.id == id))) {
            Some((id, Some(step))) => format!("  before {id}: {}", describe::what(&step.stimulus)),
            Some((id, None)) => format!("  before {id}"),
            None => String::new(),
        };
        output::print(&format!("{}\n", clean(&format!("{at}{what}"))));
        self.values(pause);
        let standings = self.standings(pause);
        self.shown.resize(standings.len(), false);
        for (standing, shown) in standings.iter().zip(&mut self.shown) {
            if let (Some(verdict), false) =
                (standing.verdict, std::mem::replace(shown, standing.verdict.is_some()))
            {
                output::print(&format!("  decided: {}\n", line(&standing.name, Some(verdict))));
            }
        }
        let decided = standings.iter().filter(|standing| standing.verdict.is_some()).count();
        output::print(&format!("  {decided} of {} claims decided\n", standings.len()));
    }

    /// The signals of the plan, and since when they are what they are.
    fn values(&self, pause: &Pause<'_>) {
        let signals: Vec<&SignalInfo> =
            pause.trace.signals().iter().filter(|info| info.kind != ValueKind::Mark).collect();
        let width = signals.iter().map(|info| info.name.chars().count()).max().unwrap_or(0);
        for info in signals {
            output::print(&format!("  {:<width$}  {}\n", clean(&info.name), value(info, pause)));
        }
    }

    fn standings(&self, pause: &Pause<'_>) -> Vec<ClaimProgress> {
        let clock = clock_error(pause.trace);
        ClaimProgress::of(&self.scenario, pause.trace, clock, pause.now).unwrap_or_else(|error| {
            output::error(&error.to_string());
            Vec::new()
        })
    }

    fn claims(&self, pause: &Pause<'_>) {
        for standing in self.standings(pause) {
            output::print(&format!("  {}\n", line(&standing.name, standing.verdict)));
        }
    }
}

/// What a signal is, and since when.
fn value(info: &SignalInfo, pause: &Pause<'_>) -> String {
    let last = last_of(pause.trace, &info.name);
    let Some(event) = last else { return String::from("not known") };
    let since = anchor(event.at.latest, pause.start);
    format!("{} since {since}", clean(&info.show(event.value)))
}

fn last_of(trace: &Trace, name: &str) -> Option<signal::Event> {
    trace.last(trace.find(name)?)
}

/// A claim with what it came to.
fn line(name: &str, verdict: Option<Verdict>) -> String {
    let word = verdict.map_or("open", Verdict::word);
    format!("{word:>12}  {}", clean(name))
}

/// An instant as plans write it.
fn anchor(at: Time, start: Time) -> String {
    match at - start {
        Span::ZERO => String::from("start"),
        before if before.is_negative() => format!("start - {}", -before),
        after => format!("start + {after}"),
    }
}

impl Stepper for StepShell<'_> {
    fn pause(&mut self, pause: &Pause<'_>) -> StepTarget {
        self.show(pause);
        loop {
            if io::stdin().is_terminal() {
                output::print("> ");
            }
            let line = match self.lines.next(self.interrupt) {
                TypedLine::Line(line) => line,
                // The script is over.
                TypedLine::End => return StepTarget::ToEnd,
                TypedLine::Failed(error) => {
                    output::error(&format!("standard input cannot be read: {error}"));
                    self.quit = true;
                    return StepTarget::Quit;
                }
                TypedLine::Interrupted => {
                    self.quit = true;
                    return StepTarget::Quit;
                }
            };
            match StepCommand::parse(&line) {
                Ok(StepCommand::Next) => return StepTarget::Next,
                Ok(StepCommand::Until(span)) => match pause.start.saturating_add(span) {
                    at if at > pause.now => return StepTarget::Until(at),
                    _ => output::error(&format!("the case is at {} already", anchor(pause.now, pause.start))),
                },
                Ok(StepCommand::Run) => return StepTarget::ToEnd,
                Ok(StepCommand::Values) => self.values(pause),
                Ok(StepCommand::Claims) => self.claims(pause),
                Ok(StepCommand::Quit) => {
                    self.quit = true;
                    return StepTarget::Quit;
                }
                Ok(StepCommand::Help) => output::print(&format!("{HELP}\n")),
                Err(why) => output::error(&why),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_read() {
        for (line, command) in [
            ("", StepCommand::Next),
            ("n\n", StepCommand::Next),
            (" until 1.5 s \r\n", StepCommand::Until(Span::from_millis(1_500))),
            ("until start + 2 s", StepCommand::Until(Span::from_secs(2))),
            ("q", StepCommand::Quit),
        ] {
            assert_eq!(StepCommand::parse(line), Ok(command), "{line}");
        }
        assert!(StepCommand::parse("vlaues").unwrap_err().contains("did you mean `values`?"));
        assert!(StepCommand::parse("next 2").unwrap_err().contains("takes no argument"));
        assert!(StepCommand::parse("until noon").unwrap_err().contains("not a time"));
    }

    #[test]
    fn instants_are_written_as_in_plans() {
        let at = |ns| anchor(Time::from_nanos(ns), Time::from_nanos(1_000));
        assert_eq!([at(1_000), at(3_000), at(0)], ["start", "start + 2 us", "start - 1 us"]);
    }
}
