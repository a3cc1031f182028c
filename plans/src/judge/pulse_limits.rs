//! Lines of which a board reports every pulse only up to a frequency: what is counted of faster pulses is open.
//!
//! A trace says so in a note for each such signal, so that a recorded trace is judged as the run was. What the board
//! did not report nobody sees, so two things are looked at: how fast the pulses of the trace are, and how fast a claim wants
//! them to be.

use record::Window;
use signal::{Event, SignalInfo, Span, Value};

/// What the notes of such signals are called; their names come after it, the value is in Hz.
const NOTE: &str = "counts-up-to:";
/// Stretches of too fast pulses that are kept of a signal. What comes after them widens the last one.
const MOST: usize = 64;
/// A period counts as too short from this part of the shortest promised one on: stamps are not exact, and a line may be
/// used up to what is promised of it.
const PART: (i64, i64) = (9, 10);

/// The note by which a trace says up to how many Hz every pulse of a signal is reported.
pub fn note_of(signal: &str) -> String {
    format!("{NOTE}{signal}")
}

/// Pulses that came faster than a board promises to report them.
#[derive(Clone, Copy, Debug)]
struct FastStretch {
    from: i64,
    until: i64,
    /// The shortest period of it, in nanoseconds.
    period: i64,
}

/// A signal of which a board reports every pulse up to a frequency.
#[derive(Clone, Debug)]
struct CountedSignal {
    hz: u64,
    /// Periods below this are too short, in nanoseconds.
    shortest: i64,
    level: Option<bool>,
    /// The earliest instants of the last rising and the last falling edge.
    edges: [Option<i64>; 2],
    fast: Vec<FastStretch>,
}

impl CountedSignal {
    fn see(&mut self, event: &Event) {
        let Some(high) = event.value.as_bool() else {
            (self.level, self.edges) = (None, [None; 2]);
            return;
        };
        if self.level.replace(high).is_none_or(|before| before == high) {
            return;
        }
        let [earliest, latest] = [event.at.earliest.as_nanos(), event.at.latest.as_nanos()];
        let before = self.edges[usize::from(high)].replace(earliest);
        let Some(from) = before.filter(|before| latest - before < self.shortest) else { return };
        let period = (latest - from).max(1);
        let full = self.fast.len() == MOST;
        match self.fast.last_mut() {
            Some(last) if from <= last.until || full => {
                last.until = latest;
                last.period = last.period.min(period);
            }
            _ => self.fast.push(FastStretch { from, until: latest, period }),
        }
    }
}

/// The signals of a trace whose boards promise to report pulses up to a frequency.
#[derive(Clone, Debug, Default)]
pub(super) struct PulseLimits(Vec<Option<CountedSignal>>);

impl PulseLimits {
    /// By the notes of a trace.
    pub(super) fn new(signals: &[SignalInfo], note: &dyn Fn(&str) -> Option<String>) -> PulseLimits {
        let line = |info: &SignalInfo| {
            let hz: u64 = note(&note_of(&info.name))?.parse().ok().filter(|hz| *hz > 0)?;
            let period = 1_000_000_000 / i64::try_from(hz).unwrap_or(i64::MAX);
            let shortest = period * PART.0 / PART.1;
            Some(CountedSignal { hz, shortest, level: None, edges: [None; 2], fast: Vec::new() })
        };
        let lines: Vec<Option<CountedSignal>> = signals.iter().map(line).collect();
        // As a rule nobody promised anything.
        PulseLimits(if lines.iter().any(Option::is_some) { lines } else { Vec::new() })
    }

    /// The next event of the trace.
    #[inline]
    pub(super) fn see(&mut self, event: &Event) {
        if let Some(Some(line)) = self.0.get_mut(event.signal.0 as usize)
            && !matches!(event.value, Value::Int(_) | Value::Real(_))
        {
            line.see(event);
        }
    }

    /// Why a figure of these signals is open where each of their pulses counts; `wanted` is how fast they have to be in
    /// Hz for the claim to hold, at least.
    pub(super) fn doubt(
        &self,
        signals: &[SignalInfo],
        names: &[String],
        window: Option<&Window>,
        wanted: f64,
    ) -> Option<String> {
        let lines = self.0.iter().zip(signals).filter(|(_, info)| names.contains(&info.name));
        lines.filter_map(|(line, info)| Some((line.as_ref()?, info))).find_map(|(line, info)| {
            let (name, hz) = (&info.name, line.hz);
            let fix = "lower the frequency, raise `counts-up-to` as far as `rig bench counts` allows, or count with a \
                counter of the kernel";
            if wanted > hz as f64 {
                return Some(format!(
                    "pulses of {wanted} Hz are wanted of `{name}`, whose board counts up to {hz} Hz: {fix}"
                ));
            }
            let inside = |fast: &&FastStretch| {
                window.is_none_or(|window| {
                    fast.from <= window.until_ns[1] && fast.until >= window.from_ns[0]
                })
            };
            let fast = line.fast.iter().find(inside)?;
            let (at, period) = (Span::from_nanos(fast.from), Span::from_nanos(fast.period));
            Some(format!(
                "`{name}` has pulses {period} apart from {at} on, and its board counts up to {hz} Hz: {fix}"
            ))
        })
    }
}
