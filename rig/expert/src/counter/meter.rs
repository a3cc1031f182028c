//! Windows of pulses, and times between edges (io: section 17.3).

use super::config::{CounterMode, PeriodMeasurement};
use signal::{Span, Time};

/// A measurement that a meter completed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct MeterReading {
    pub value: i64,
    pub valid: bool,
}

/// What measures, where a mode does.
#[derive(Clone, Debug)]
pub(super) enum Meter {
    /// The mode counts.
    None,
    /// Pulses of successive windows, each of which begins with its first instant and ends before the next one's.
    Window {
        window: Span,
        /// What a pulse adds to the value, as a quotient: for a frequency, 1 s by the window.
        scale: i64,
        /// Pulses of the window that goes on.
        pulses: i64,
        /// When it ends; [`Time::MAX`] while there is none.
        end: Time,
        /// The last window was empty, so that all up to the next pulse are the same, and nobody looks at their ends.
        empty: bool,
    },
    /// The time between edges.
    Period {
        measures: PeriodMeasurement,
        resolution: i64,
        timeout: Span,
        /// The rising edge that the measurement began with.
        from: Option<Time>,
        /// When the value stops being valid without an edge.
        end: Time,
    },
}

impl Meter {
    pub fn new(mode: CounterMode) -> Meter {
        let windows =
            |window, scale| Meter::Window { window, scale, pulses: 0, end: Time::MAX, empty: false };
        match mode {
            CounterMode::EventCounting { window } => windows(window, 1),
            CounterMode::Frequency { window } => windows(window, 1_000_000_000 / window.as_nanos().max(1)),
            CounterMode::Period { measures, resolution, timeout } => Meter::Period {
                measures,
                resolution: resolution.as_nanos().max(1),
                timeout,
                from: None,
                end: Time::MAX,
            },
            _ => Meter::None,
        }
    }

    /// When something happens without an edge.
    pub const fn next(&self) -> Time {
        match self {
            Meter::None | Meter::Window { empty: true, .. } => Time::MAX,
            Meter::Window { end, .. } | Meter::Period { end, .. } => *end,
        }
    }

    /// It measures again from `now` on; what it had begun is lost.
    pub fn begin(&mut self, now: Time) {
        match self {
            Meter::None => {}
            Meter::Window { window, pulses, end, empty, .. } => {
                (*pulses, *end, *empty) = (0, now.saturating_add(*window), false);
            }
            Meter::Period { timeout, from, end, .. } => (*from, *end) = (None, expiry(now, *timeout)),
        }
    }

    /// It measures no more; what it had begun is lost.
    pub fn stop(&mut self) {
        match self {
            Meter::None => {}
            Meter::Window { end, .. } | Meter::Period { end, .. } => *end = Time::MAX,
        }
    }

    /// What is due at [`Meter::next`] happens.
    pub fn elapse(&mut self) -> Option<MeterReading> {
        match self {
            Meter::None => None,
            Meter::Window { window, scale, pulses, end, empty } => {
                *empty = *pulses == 0;
                let value = (std::mem::take(pulses) * *scale).min(i64::from(i32::MAX));
                *end = end.saturating_add(*window);
                Some(MeterReading { value, valid: true })
            }
            Meter::Period { from, end, .. } => {
                (*from, *end) = (None, Time::MAX);
                Some(MeterReading { value: 0, valid: false })
            }
        }
    }

    /// An edge of A while it measures.
    #[inline]
    pub fn edge(&mut self, at: Time, rises: bool) -> Option<MeterReading> {
        match self {
            Meter::None => None,
            Meter::Window { window, pulses, end, empty, .. } => {
                if *empty && at >= *end {
                    let over = (at - *end).as_nanos() / window.as_nanos().max(1);
                    *end = end.saturating_add(*window * (over + 1));
                }
                *empty &= !rises;
                *pulses += i64::from(rises);
                None
            }
            Meter::Period { measures, resolution, timeout, from, end } => {
                *end = expiry(at, *timeout);
                let begun = match (*measures, rises) {
                    (_, true) => from.replace(at).filter(|_| *measures == PeriodMeasurement::Period),
                    (PeriodMeasurement::PulseWidth, false) => from.take(),
                    (PeriodMeasurement::Period, false) => None,
                }?;
                let value = (at - begun).as_nanos() / *resolution;
                // Longer than a DINT can hold: what it shows is too short.
                let most = i64::from(i32::MAX);
                Some(MeterReading { value: value.min(most), valid: value <= most })
            }
        }
    }
}

/// When a timeout that begins at `from` ends; never where there is none.
fn expiry(from: Time, timeout: Span) -> Time {
    if timeout == Span::ZERO { Time::MAX } else { from.saturating_add(timeout) }
}
