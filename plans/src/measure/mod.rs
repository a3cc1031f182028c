//! Measurements: how long something took, or how large it was, against limits if it has any.
//!
//! ```toml
//! measure = [
//!   { name = "reflex latency", from = "train.pulse[1000]", to = { signal = "out", edge = "rises" }, max = "6 us" },
//!   { name = "speed", frequency-of = "pulses", from = "run", nominal = "50 Hz", tolerance = "1 %" },
//!   { name = "ripple", value-of = "u24", take = "span", from = "run", until = "stop", max = "0.5 V" },
//!   { name = "supply", value-of = "u24", when = "busy", nominal = "24 V", tolerance = "1.2 V" },
//! ]
//! ```
//! A measurement that was never taken never passes. One without limits that was taken has no verdict.

mod gauge;
mod read;
mod window;

use std::fmt;
use std::sync::Arc;

use document::Diagnostic;
use record::{GuardBand, MeasurementRecord, Verdict};
use signal::{SignalInfo, Span, ValueKind};

use crate::expect::FilePlace;
use crate::expect::band::{NEVER_NEGATIVE, WHOLE_PART, figure};
use crate::expect::profile::ShapedTrain;
use crate::expect::train::TrainLines;
use crate::lang::{Anchor, Literal};
use crate::meaning::what_to_write;
use crate::monitor::edges::CountedEdge;
use crate::monitor::jitter::JitterQuery;
use crate::monitor::{
    CaseTimeline, ClockedFigure, NotJudged, NumberLimits, PulseRule, TraceSignals, UnseenPulses,
};

pub use gauge::Gauge;
pub(crate) use read::{GUARD, GUARDS, LIMITS, guard};
pub use read::{KEYS, read};

/// What is measured.
#[derive(Clone, Debug, PartialEq)]
pub enum MeasuredQuantity {
    /// The time from one instant to another.
    Between {
        /// Where it begins.
        from: Anchor,
        /// Where it ends.
        to: Anchor,
    },
    /// The time from an instant to the first such edge at or after it.
    ToEdge {
        /// Where it begins.
        from: Anchor,
        /// The signal.
        signal: String,
        /// Which edge.
        edge: crate::monitor::edges::CountedEdge,
    },
    /// The value of a signal at an instant.
    Value {
        /// The signal.
        signal: String,
        /// The instant.
        when: Anchor,
    },
    /// What a signal came to over a window.
    Over {
        /// The signal.
        signal: String,
        /// Where the window begins.
        from: Anchor,
        /// Where it ends, itself not included.
        until: Anchor,
        /// What is asked.
        figure: WindowFigure,
    },
    /// By how much a pulse train went forwards over a window.
    Position {
        /// The train.
        train: TrainLines,
        /// Where the window begins.
        from: Anchor,
        /// Where it ends, itself not included.
        until: Anchor,
    },
    /// By how much the frequency of a pulse train is off its shape at most, over a window.
    Profile {
        /// The train and its shape.
        shaped: Box<ShapedTrain>,
        /// Where the window and the shape begin.
        from: Anchor,
        /// Where the window ends, itself not included.
        until: Anchor,
    },
}

/// What is asked of a signal over a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WindowFigure {
    /// The mean frequency of its whole cycles.
    Frequency,
    /// The part of their time in which it is TRUE.
    Duty,
    /// The lengths of its cycles.
    Period(Statistic),
    /// The widths of its pulses.
    Width {
        /// Those at which it is TRUE, else those at which it is FALSE.
        high: bool,
        /// Which of them.
        take: Statistic,
    },
    /// How far it comes off an even grid.
    Jitter(JitterQuery),
    /// Its values.
    Value(Statistic),
    /// Its change per second.
    Speed,
}

/// What is taken of several figures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Statistic {
    /// The first one.
    First,
    /// The least.
    Min,
    /// The greatest.
    Max,
    /// The mean; of values the mean over the time.
    Mean,
    /// The root of the mean square over the time.
    Rms,
    /// The greatest less the least.
    Span,
}

impl Statistic {
    /// The names in plans, in the order of [`Statistic::ALL`].
    pub const NAMES: &[&str] = &["first", "min", "max", "mean", "rms", "span"];

    /// Every one.
    pub const ALL: [Statistic; 6] =
        [Statistic::First, Statistic::Min, Statistic::Max, Statistic::Mean, Statistic::Rms, Statistic::Span];

    /// The one of this name.
    pub fn find(name: &str) -> Option<Statistic> {
        Self::ALL.into_iter().zip(Self::NAMES).find_map(|(take, known)| (*known == name).then_some(take))
    }

    fn name(self) -> &'static str {
        Self::ALL
            .into_iter()
            .zip(Self::NAMES)
            .find_map(|(take, name)| (take == self).then_some(*name))
            .unwrap_or("")
    }
}

impl WindowFigure {
    /// What it is a number of, for its unit.
    ///
    /// # Errors
    /// Why the signal has no such figure, one sentence.
    pub(crate) fn info(self, signal: &SignalInfo) -> Result<SignalInfo, String> {
        match self {
            WindowFigure::Frequency => Ok(figure("frequency", "Hz")),
            WindowFigure::Speed => {
                crate::expect::speed::countable(signal)?;
                Ok(figure("speed", crate::expect::speed::UNIT))
            }
            WindowFigure::Duty => Ok(figure("duty", "%")),
            WindowFigure::Period(_) | WindowFigure::Width { .. } | WindowFigure::Jitter(_) => {
                Ok(gauge::time())
            }
            WindowFigure::Value(_) if matches!(signal.kind, ValueKind::State | ValueKind::Mark) => {
                Err(format!("`{}` has named values, of which there is no least or mean one", signal.name))
            }
            WindowFigure::Value(_) => {
                let mut info = signal.clone();
                if info.kind == ValueKind::Bool {
                    // The mean of a line is the part of the time in which it is TRUE.
                    info.kind = ValueKind::Real;
                }
                Ok(info)
            }
        }
    }

    /// The unit that it has whatever the signal's is.
    pub(crate) fn own_unit(self) -> Option<&'static str> {
        match self {
            WindowFigure::Frequency | WindowFigure::Speed => Some("Hz"),
            WindowFigure::Duty => Some("%"),
            WindowFigure::Period(_) | WindowFigure::Width { .. } | WindowFigure::Jitter(_) => Some("ns"),
            WindowFigure::Value(_) => None,
        }
    }
}

impl MeasuredQuantity {
    /// How the figure depends on the clock; a value, a count and a part of a time do not.
    fn by_clock(&self) -> Option<ClockedFigure> {
        match self {
            MeasuredQuantity::ToEdge { .. } => Some(ClockedFigure::Time),
            MeasuredQuantity::Profile { .. } => Some(ClockedFigure::Rate),
            // The true time between two instants is asked for as such, and so is that of a speed.
            MeasuredQuantity::Between { .. }
            | MeasuredQuantity::Value { .. }
            | MeasuredQuantity::Position { .. } => None,
            MeasuredQuantity::Over { figure, .. } => match figure {
                WindowFigure::Duty | WindowFigure::Value(_) | WindowFigure::Speed => None,
                WindowFigure::Frequency => Some(ClockedFigure::Rate),
                WindowFigure::Period(_) | WindowFigure::Width { .. } | WindowFigure::Jitter(_) => {
                    Some(ClockedFigure::Time)
                }
            },
        }
    }

    /// What no figure of the kind is below or above.
    fn natural(&self) -> NumberLimits {
        match self {
            MeasuredQuantity::Between { .. }
            | MeasuredQuantity::ToEdge { .. }
            | MeasuredQuantity::Profile { .. } => NEVER_NEGATIVE,
            MeasuredQuantity::Value { .. } | MeasuredQuantity::Position { .. } => NumberLimits::default(),
            MeasuredQuantity::Over { figure, .. } => match figure {
                WindowFigure::Frequency
                | WindowFigure::Period(_)
                | WindowFigure::Width { .. }
                | WindowFigure::Jitter(_) => NEVER_NEGATIVE,
                WindowFigure::Duty => WHOLE_PART,
                WindowFigure::Value(_) | WindowFigure::Speed => NumberLimits::default(),
            },
        }
    }
}

impl fmt::Display for MeasuredQuantity {
    /// `time from press until `lamp` rises`, `mean of `pressure` from press until end`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            MeasuredQuantity::Between { from, to } => write!(f, "time from {from} until {to}"),
            MeasuredQuantity::ToEdge { from, signal, edge } => {
                let edge = match edge {
                    CountedEdge::Rises => "rises",
                    CountedEdge::Falls => "falls",
                    CountedEdge::Changes | CountedEdge::Becomes(_) => "changes",
                };
                write!(f, "time from {from} until `{signal}` {edge}")
            }
            MeasuredQuantity::Value { signal, when } => write!(f, "`{signal}` at {when}"),
            MeasuredQuantity::Over { signal, from, until, figure } => {
                match figure {
                    WindowFigure::Frequency => write!(f, "frequency of `{signal}`")?,
                    WindowFigure::Duty => write!(f, "duty of `{signal}`")?,
                    WindowFigure::Period(take) => write!(f, "{} period of `{signal}`", take.name())?,
                    WindowFigure::Width { high, take } => {
                        let low = if *high { "" } else { "low " };
                        write!(f, "{} width of the {low}pulses of `{signal}`", take.name())?;
                    }
                    WindowFigure::Jitter(asked) => write!(f, "{asked} of `{signal}`")?,
                    WindowFigure::Value(take) => write!(f, "{} of `{signal}`", take.name())?,
                    WindowFigure::Speed => write!(f, "speed of `{signal}`")?,
                }
                write!(f, " from {from} until {until}")
            }
            MeasuredQuantity::Position { train, from, until } => {
                write!(f, "position of {} from {from} until {until}", train.words())
            }
            MeasuredQuantity::Profile { shaped, from, until } => {
                let train = shaped.train.words();
                write!(f, "distance of the frequency of {train} from its shape from {from} until {until}")
            }
        }
    }
}

/// Limits of a measurement, as written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeasurementLimits {
    /// The least value allowed.
    pub min: Option<Literal>,
    /// The greatest value allowed.
    pub max: Option<Literal>,
    /// The value wanted, and how far from it is allowed.
    pub nominal: Option<(Literal, Literal)>,
}

/// A measurement of one case.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// Its name.
    pub name: String,
    /// What is measured.
    pub quantity: MeasuredQuantity,
    /// What it should be.
    pub limits: Arc<MeasurementLimits>,
    /// How the uncertainty of its figure counts against them.
    pub guard: GuardBand,
    /// `pulses-longer-than`; of a pulse train, that of its lines.
    pub longer_than: Option<Span>,
    /// Where it stands; `None` for a measurement that is in no plan file.
    pub place: Option<FilePlace>,
}

impl Measurement {
    /// The instants that it depends on.
    pub fn anchors(&self) -> Vec<&Anchor> {
        match &self.quantity {
            MeasuredQuantity::Between { from, to } => vec![from, to],
            MeasuredQuantity::ToEdge { from, .. } => vec![from],
            MeasuredQuantity::Value { when, .. } => vec![when],
            MeasuredQuantity::Over { from, until, .. }
            | MeasuredQuantity::Position { from, until, .. }
            | MeasuredQuantity::Profile { from, until, .. } => vec![from, until],
        }
    }

    /// Of a figure for which every pulse counts: how fast they have to be in Hz for its limits to hold, at least; 0 where
    /// that is not said.
    pub(crate) fn counts(&self) -> Option<f64> {
        let MeasuredQuantity::Over { figure, .. } = &self.quantity else { return None };
        match figure {
            WindowFigure::Value(_) => None,
            _ => Some(0.0),
        }
    }

    /// How it looks at the pulses of one of its signals: what those that nobody saw could do to its figure.
    pub(crate) fn pulses(&self, info: &SignalInfo) -> PulseRule {
        let of_edges = PulseRule::decides(self.longer_than);
        match &self.quantity {
            MeasuredQuantity::Between { .. } | MeasuredQuantity::Value { .. } => PulseRule::SEEN,
            // An edge that nobody saw could have come first; one that did not come is not taken to have come unseen.
            MeasuredQuantity::ToEdge { .. } => PulseRule::breaks(self.longer_than),
            MeasuredQuantity::Over { figure: WindowFigure::Speed, .. } => PulseRule::SEEN,
            MeasuredQuantity::Over { .. } => of_edges,
            MeasuredQuantity::Position { train, .. } => train.pulses(info),
            MeasuredQuantity::Profile { shaped, .. } => shaped.train.pulses(info),
        }
    }

    /// What unseen pulses of its signals could do, and why, if anything.
    pub(crate) fn doubt(&self, signals: &[SignalInfo]) -> Option<(UnseenPulses, String)> {
        let names = self.signals();
        let own = signals.iter().filter(|info| names.contains(&info.name));
        own.filter_map(|info| self.pulses(info).doubt(info)).max_by_key(|(unseen, _)| *unseen)
    }

    /// The signals that it looks at.
    pub fn signals(&self) -> Vec<String> {
        match &self.quantity {
            MeasuredQuantity::Between { .. } => Vec::new(),
            MeasuredQuantity::ToEdge { signal, .. }
            | MeasuredQuantity::Value { signal, .. }
            | MeasuredQuantity::Over { signal, .. } => vec![signal.clone()],
            MeasuredQuantity::Position { train, .. } => train.signals(),
            MeasuredQuantity::Profile { shaped, .. } => shaped.train.signals(),
        }
    }

    /// Finds what cannot be measured with these signals.
    pub fn check(&self, wiring: &TraceSignals<'_>, out: &mut Vec<Diagnostic>) {
        let mut info = gauge::time();
        if let Some(name) = self.signals().first() {
            let Some(known) = crate::expect::known(name, wiring, out) else { return };
            match &self.quantity {
                MeasuredQuantity::Value { .. } => info = known.clone(),
                MeasuredQuantity::Over { figure, .. } => match figure.info(known) {
                    Ok(asked) => info = asked,
                    Err(why) => {
                        let help =
                            "name a signal of which this can be taken: a line, or a variable with a number";
                        return crate::expect::meant(Err(why), help, out);
                    }
                },
                MeasuredQuantity::Position { train, .. } => {
                    train.check(wiring, out);
                    info = figure("position", "");
                }
                MeasuredQuantity::Profile { shaped, .. } => {
                    shaped.check(wiring, out);
                    info = figure("frequency", "Hz");
                }
                MeasuredQuantity::Between { .. } | MeasuredQuantity::ToEdge { .. } => {}
            }
        }
        let ordered = if self.limits.min.is_some() && self.limits.max.is_some() {
            ", `min` no greater than `max`"
        } else {
            ""
        };
        let help = format!("{}{ordered}", what_to_write(&info));
        crate::expect::meant(gauge::LimitNumbers::new(&self.limits, &info).map(drop), &help, out);
    }

    /// Starts measuring.
    ///
    /// # Errors
    /// [`NotJudged`] if an instant never came.
    pub fn start(&self, scene: &CaseTimeline<'_>) -> Result<Gauge, NotJudged> {
        Gauge::new(self, scene)
    }

    pub(crate) fn line(&self) -> u32 {
        self.place.as_ref().map_or(0, |place| place.line)
    }

    /// The record of a measurement that was never taken.
    pub fn untaken(&self, why: &str) -> MeasurementRecord {
        MeasurementRecord {
            name: self.name.clone(),
            verdict: Verdict::Inconclusive,
            reason: why.to_owned(),
            signal: self.signals().into_iter().next(),
            what: self.quantity.to_string(),
            guard_band: self.guard,
            line: self.line(),
            ..MeasurementRecord::default()
        }
    }
}
