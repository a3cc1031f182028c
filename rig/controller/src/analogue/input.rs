//! An analogue input: from the terminal through the filter to the last conversion.
//!
//! Nothing ticks: the value after the filter and the last instant of conversion follow from the time in closed form, when the
//! bus reads and before something changes at the terminal.

use super::sampling::Sampling;
use super::scale::{Converted, InputScale, parts};
use profile::{AnalogueInputSettings, ChannelStatus};
use signal::{Span, Time, Value};

/// After so many time constants what is left of a change is below the rounding of the value.
const SETTLED: i64 = 40;

/// What is at the terminal.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Terminal {
    /// A value in the unit of the mode.
    Value(f64),
    /// A sensor that is not connected.
    Open,
}

/// An input in use.
#[derive(Clone, Debug)]
pub(super) struct AnalogueInput {
    scale: InputScale,
    /// The time constant of the filter; zero for none.
    filter: Span,
    /// When it is converted; none for whenever it is read.
    sampling: Option<Sampling>,
    /// What the terminal of an open line reads.
    open: Terminal,
    powered: Time,
    /// The module has its own supply; without it nothing is converted.
    is_supplied: bool,
    terminal: Terminal,
    /// Since when that is there.
    since: Time,
    /// The value after the filter at that instant.
    from: f64,
    /// Before then a read gives what it gave before: the next conversion of what is at the terminal, [`Time::MAX`] where all of
    /// them give the same until something changes there.
    due: Time,
    converted: Converted,
    /// The same when it was read last.
    read: Converted,
}

impl AnalogueInput {
    /// The input, with nothing connected.
    pub(super) fn new(
        settings: &AnalogueInputSettings<'_>,
        bits: Option<u8>,
        sampling: Option<Sampling>,
    ) -> AnalogueInput {
        // An open loop carries no current, and a voltage input that nothing is connected to measures none (rig definition).
        let open = if settings.mode.is_sensor() { Terminal::Open } else { Terminal::Value(0.0) };
        AnalogueInput {
            scale: InputScale::new(settings, bits),
            filter: settings.filter,
            sampling,
            open,
            powered: Time::MIN,
            is_supplied: true,
            terminal: open,
            since: Time::MIN,
            from: 0.0,
            due: Time::MIN,
            converted: Converted::default(),
            read: Converted::default(),
        }
    }

    /// The electronics come up at `now`: the filter stands at what is at the terminal, and nothing is converted yet.
    pub(super) fn power_on(&mut self, now: Time) {
        (self.powered, self.since) = (now, now);
        self.due = self.conversion_after(now);
        (self.converted, self.read) = (Converted::default(), Converted::default());
        self.from = self.target().unwrap_or(0.0);
        if !self.is_supplied {
            self.supply(now, false);
        }
    }

    /// The supply of the module is there or off from `now` on. Without it the last conversion stands, with its status.
    pub(super) fn supply(&mut self, now: Time, on: bool) {
        let comes = on && !self.is_supplied;
        self.is_supplied = on;
        if comes {
            self.power_on(now);
        } else if !on {
            if now >= self.due {
                self.advance(now);
            }
            self.converted.status = ChannelStatus::Supply;
            self.due = Time::MAX;
        }
    }

    /// What is at the terminal from `now` on. A line that is not known any more keeps its value.
    pub(super) fn set(&mut self, now: Time, value: Value) {
        let terminal = match (value, value.as_real()) {
            (Value::HighZ, _) => self.open,
            (_, Some(real)) if real.is_finite() => Terminal::Value(real),
            _ => return,
        };
        if terminal == self.terminal {
            return;
        }
        if now >= self.due {
            self.advance(now);
        }
        // A sensor that comes back is there at once: the filter had nothing to lag.
        self.from = match (self.target(), terminal) {
            (Some(_), _) => self.filtered(now),
            (None, Terminal::Value(new)) => new,
            (None, Terminal::Open) => 0.0,
        };
        (self.terminal, self.since) = (terminal, now);
        self.due = self.conversion_after(now);
    }

    /// When it is converted first after an instant; an input without instants of its own is whenever it is read.
    fn conversion_after(&self, at: Time) -> Time {
        if !self.is_supplied {
            return Time::MAX;
        }
        self.sampling.map_or(Time::MIN, |sampling| sampling.after(self.powered, at))
    }

    /// The last conversion up to `now`.
    #[inline]
    pub(super) fn read(&mut self, now: Time) -> Converted {
        if now >= self.due {
            self.advance(now);
        }
        self.read = self.converted;
        self.read
    }

    /// What was read last.
    pub(super) fn last_read(&self) -> Converted {
        self.read
    }

    /// What the filter moves to, if a sensor is there.
    fn target(&self) -> Option<f64> {
        match self.terminal {
            Terminal::Value(value) => Some(value),
            Terminal::Open => None,
        }
    }

    /// Converts what was there at the last instant of conversion. What changes at such an instant is converted at the next one.
    fn advance(&mut self, now: Time) {
        let at = match self.sampling {
            None => now,
            Some(sampling) => match sampling.last(self.powered, now) {
                Some(at) if at > self.since => at,
                _ => return,
            },
        };
        let Some(target) = self.target() else {
            (self.converted, self.due) = (self.scale.open(), Time::MAX);
            return;
        };
        let value = parts(self.filtered(at));
        self.converted = self.scale.convert(value);
        self.due = if value == parts(target) { Time::MAX } else { self.conversion_after(at) };
    }

    /// The value after the filter at an instant since the last change.
    fn filtered(&self, at: Time) -> f64 {
        let Some(target) = self.target() else { return self.from };
        let (elapsed, tau) = (at.as_nanos().saturating_sub(self.since.as_nanos()), self.filter.as_nanos());
        if elapsed >= tau.saturating_mul(SETTLED) {
            return target;
        }
        target + (self.from - target) * libm::exp(-(elapsed as f64) / tau as f64)
    }
}
