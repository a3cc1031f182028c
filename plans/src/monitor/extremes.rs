//! The least and the greatest value of a signal in a window, and its mean over the time.
//!
//! A value that lies in the window in every placement counts for certain, one that lies there in some counts as
//! possible. A number that was measured counts with all that it may be, a whole one that no float is with the floats beside it. The mean weighs each value with the time that it certainly lasts in the window; what is left of the
//! window may have any of the possible values.

use signal::Value;

use super::{Number, TimedValue, UncertainWindow};

/// Follows the values of one window.
#[derive(Clone, Debug)]
pub struct Extremes {
    window: UncertainWindow,
    last: Option<TimedValue>,
    /// What the least value is at most, and the greatest one at least.
    certain: Option<(f64, f64)>,
    possible: Option<(f64, f64)>,
    unknown: bool,
    /// Certain time in nanoseconds, and with it the sums of the values and of their squares: the least and the greatest
    /// that they may be.
    time: f64,
    sum: (f64, f64),
    squares: (f64, f64),
    /// Where the least and the greatest value began.
    at_least: Option<TimedValue>,
    at_most: Option<TimedValue>,
}

/// What the values of a window came to; each as the least and the greatest that some placement has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// The least value.
    pub least: (f64, f64),
    /// The greatest value.
    pub most: (f64, f64),
    /// The mean over the time.
    pub mean: (f64, f64),
    /// The root of the mean square over the time.
    pub rms: (f64, f64),
    /// Where the least and the greatest value began.
    pub at: (TimedValue, TimedValue),
    /// For a part of the window the value is not known, or no number.
    pub unknown: bool,
}

impl Extremes {
    /// Nothing is known of the signal before its first event.
    pub fn new(window: UncertainWindow) -> Extremes {
        Extremes {
            window,
            last: None,
            certain: None,
            possible: None,
            unknown: false,
            time: 0.0,
            sum: (0.0, 0.0),
            squares: (0.0, 0.0),
            at_least: None,
            at_most: None,
        }
    }

    /// The window's end is still to come, at `now` or later.
    pub fn advance(&mut self, now: i64) {
        self.window.advance(now);
    }

    /// The next event.
    #[inline]
    pub fn see(&mut self, seen: &TimedValue) {
        self.until((seen.a, seen.b));
        self.last = Some(*seen);
    }

    /// The last value lasted until here.
    fn until(&mut self, end: (i64, i64)) {
        let seen = self.last.unwrap_or(TimedValue::NOTHING);
        if !self.window.can_meet(seen.a, end.1) {
            return;
        }
        let number = match seen.value {
            Value::Unknown | Value::HighZ => None,
            value => {
                Number::of(value).map(Number::reals).filter(|(low, high)| low.is_finite() && high.is_finite())
            }
        };
        let Some((low, high)) = number else {
            self.unknown = true;
            return;
        };
        let (low, high) = (low - seen.value.uncertainty(), high + seen.value.uncertainty());
        let widened = |range: Option<(f64, f64)>, (low, high): (f64, f64)| match range {
            Some((least, most)) => (least.min(low), most.max(high)),
            None => (low, high),
        };
        if self.possible.is_none_or(|(least, _)| low < least) {
            self.at_least = Some(seen);
        }
        if self.possible.is_none_or(|(_, most)| high > most) {
            self.at_most = Some(seen);
        }
        self.possible = Some(widened(self.possible, (low, high)));
        if self.window.must_meet(seen.b, end.0) {
            self.certain = Some(widened(self.certain, (high, low)));
            let lasts = end.0.min(self.window.until.a).saturating_sub(seen.b.max(self.window.from.b));
            let lasts = lasts.max(0) as f64;
            self.time += lasts;
            self.sum = (self.sum.0 + lasts * low, self.sum.1 + lasts * high);
            let (near, far) = magnitudes(low, high);
            self.squares = (self.squares.0 + lasts * near * near, self.squares.1 + lasts * far * far);
        }
    }

    /// What it came to when nothing comes any more; `None` if no number can lie in the window.
    pub fn finish(mut self) -> Option<Summary> {
        self.until((i64::MAX, i64::MAX));
        let (low, high) = self.possible?;
        let at = (self.at_least?, self.at_most?);
        let (least, most) = match self.certain {
            Some((least, most)) => ((low, least), (most, high)),
            None => ((low, high), (low, high)),
        };
        let longest = match self.window.link {
            Some(length) => length,
            None => self.window.until.b.saturating_sub(self.window.from.a),
        };
        let rest = (longest as f64 - self.time).max(0.0);
        let whole = self.time + rest;
        let mean = |sums: (f64, f64), (low, high): (f64, f64)| {
            let mean = |sum: f64, value: f64| if whole > 0.0 { (sum + rest * value) / whole } else { value };
            (mean(sums.0, low), mean(sums.1, high))
        };
        let (near, far) = magnitudes(low, high);
        let squares = mean(self.squares, (near * near, far * far));
        Some(Summary {
            least,
            most,
            mean: mean(self.sum, (low, high)),
            rms: (squares.0.max(0.0).sqrt(), squares.1.max(0.0).sqrt()),
            at,
            unknown: self.unknown,
        })
    }
}

/// The least and the greatest magnitude of the numbers from `low` to `high`.
fn magnitudes(low: f64, high: f64) -> (f64, f64) {
    let near = if low <= 0.0 && high >= 0.0 { 0.0 } else { low.abs().min(high.abs()) };
    (near, low.abs().max(high.abs()))
}
