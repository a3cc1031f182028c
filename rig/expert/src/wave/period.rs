//! One period of a square wave, exact on average.

use super::WaveShape;
use signal::{Span, Time};

/// Nanoseconds of a period at 0.1 Hz. The product of a frequency in tenths of a hertz and its period.
const TENTH: u64 = 10_000_000_000;

/// What a tenth of a percent is of that.
const STEP: u64 = TENTH / 1000;

/// A period. It begins `rest / frequency` nanoseconds after `start`: edges lie at whole nanoseconds, and the next period
/// carries on with what was cut off, so that edge k of a wave lies at the whole nanosecond of k periods.
#[derive(Clone, Copy, Debug)]
pub(super) struct Period {
    pub shape: WaveShape,
    pub start: Time,
    pub rest: u32,
}

impl Period {
    /// Whether the output keeps one level all the time.
    pub fn is_constant(&self) -> bool {
        self.shape.frequency == 0 || self.shape.duty == 0 || self.shape.duty >= 1000
    }

    /// When the output goes to 0; not for constant ones.
    pub fn fall(&self) -> Time {
        self.place(STEP * u64::from(self.shape.duty)).0
    }

    /// When the next one begins, and what it lies after that; not for frequency 0.
    pub fn end(&self) -> (Time, u32) {
        self.place(TENTH)
    }

    /// Its length and how long of it the output is on, to the nanosecond; not for constant ones.
    pub fn rounded(&self) -> (Span, Span) {
        let frequency = u64::from(self.shape.frequency);
        let nearest = |parts: u64| Span::from_nanos(((parts + frequency / 2) / frequency) as i64);
        (nearest(TENTH), nearest(STEP * u64::from(self.shape.duty)))
    }

    /// The instant `parts` after its begin, of which the frequency makes a nanosecond.
    fn place(&self, parts: u64) -> (Time, u32) {
        let (sum, frequency) = (u64::from(self.rest) + parts, u64::from(self.shape.frequency));
        let at = self.start.saturating_add(Span::from_nanos((sum / frequency) as i64));
        (at, (sum % frequency) as u32)
    }

    /// Passes over all periods but the one that ends next, at `now` or after it; not for frequency 0.
    pub fn skip(&mut self, now: Time) {
        let frequency = i128::from(self.shape.frequency);
        let passed = i128::from((now - self.start).as_nanos()) * frequency - i128::from(self.rest);
        let periods = (passed - 1).max(0) / i128::from(TENTH);
        let sum = periods * i128::from(TENTH) + i128::from(self.rest);
        // Not beyond `now`, so it fits.
        self.start = self.start.saturating_add(Span::from_nanos((sum / frequency) as i64));
        self.rest = (sum % frequency) as u32;
    }
}
