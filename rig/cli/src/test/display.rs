//! Arguments: how a run is displayed, and which traces are kept.

use clap::{Args, ValueEnum};
use record::{CaseRecord, Verdict};
use signal::Span;
use std::time::Duration;

/// The part of `rig test`'s arguments that is about showing.
#[derive(Clone, Debug, Args)]
pub struct DisplayArgs {
    /// What to print on standard output: text for a person, or an event a line for a program.
    #[arg(long, value_enum, value_name = "FORMAT", default_value_t)]
    pub format: TestOutput,
    /// Which cases get a line; each level has those before it, too [default: slow beside a progress bar, else all].
    #[arg(long, value_enum, value_name = "LEVEL")]
    pub status_level: Option<StatusLevel>,
    /// Whether to draw a progress bar on standard error.
    #[arg(long, value_enum, value_name = "WHEN", default_value_t)]
    pub progress: ProgressMode,
    /// A case that takes longer than this on the host is reported as slow.
    #[arg(long, value_name = "TIME", default_value = "10 s", value_parser = duration)]
    pub slow: Duration,
    /// Which traces the report keeps.
    #[arg(long, value_enum, value_name = "CASES", default_value_t, requires = "report")]
    pub trace_on: TraceOn,
}

fn duration(text: &str) -> Result<Duration, String> {
    let span = Span::parse(text).map_err(|error| error.to_string())?;
    match u64::try_from(span.as_nanos()) {
        Ok(nanos) if nanos > 0 => Ok(Duration::from_nanos(nanos)),
        _ => Err("the time must be above 0".to_owned()),
    }
}

/// What goes to standard output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum TestOutput {
    /// Lines for a person.
    #[default]
    Text,
    /// One JSON object a line for each event.
    Json,
}

/// Which cases get a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum StatusLevel {
    /// None.
    None,
    /// Those that failed, are inconclusive or had trouble.
    Fail,
    /// And those that took long on the host.
    Slow,
    /// And those that passed.
    Pass,
    /// And those that do not apply or were skipped.
    All,
}

impl StatusLevel {
    /// The level from which a case has a line.
    pub fn of(record: &CaseRecord, slow: bool) -> StatusLevel {
        match (record.is_judged(), record.verdict > Verdict::Pass) {
            (true, true) => StatusLevel::Fail,
            (true, false) if slow => StatusLevel::Slow,
            (true, false) => StatusLevel::Pass,
            (false, _) => StatusLevel::All,
        }
    }
}

/// When to draw a progress bar.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum ProgressMode {
    /// On a terminal, unless the variable CI is set.
    #[default]
    Auto,
    /// On every terminal.
    Bar,
    /// Never.
    None,
}

/// Which traces a report keeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum TraceOn {
    /// Those of cases that did not pass.
    Fail,
    /// Those of all cases.
    #[default]
    All,
    /// None.
    None,
}

impl TraceOn {
    /// Whether the trace of this case is kept.
    pub fn keeps(self, record: &CaseRecord) -> bool {
        match self {
            TraceOn::All => true,
            TraceOn::Fail => record.verdict > Verdict::Pass,
            TraceOn::None => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_case_has_its_level() {
        let case = |verdict| CaseRecord { verdict, ..CaseRecord::default() };
        assert_eq!(StatusLevel::of(&case(Verdict::Pass), false), StatusLevel::Pass);
        assert_eq!(StatusLevel::of(&case(Verdict::Pass), true), StatusLevel::Slow);
        for verdict in [Verdict::Inconclusive, Verdict::Fail, Verdict::Error] {
            assert_eq!(StatusLevel::of(&case(verdict), true), StatusLevel::Fail);
            assert!(TraceOn::Fail.keeps(&case(verdict)) && !TraceOn::None.keeps(&case(verdict)));
        }
        assert_eq!(StatusLevel::of(&CaseRecord::skipped("a", ""), false), StatusLevel::All);
        assert!(!TraceOn::Fail.keeps(&case(Verdict::Pass)) && TraceOn::All.keeps(&case(Verdict::Pass)));
    }

    #[test]
    fn a_slow_case_takes_some_time() {
        assert_eq!(duration("2.5 s"), Ok(Duration::from_millis(2_500)));
        assert!(duration("0 s").is_err() && duration("-1 s").is_err() && duration("soon").is_err());
    }
}
