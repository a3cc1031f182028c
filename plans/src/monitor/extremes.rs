//! The least and the greatest value of a signal in a window, and its mean over the time.
//!
//! A value that lies in the window in every placement counts for certain, one that lies there in some counts as
//! possible. A number that was measured counts with all that it may be. The mean weighs each value with the time that it
//! certainly lasts in the window; what is left of the window may have any of the possible values.

use std::cmp::Ordering;

use signal::Value;

use super::means::Means;
use super::{Extent, Number, TimedValue, UncertainWindow};

/// A number and by how much the truth may be above it, or below it where that is negative.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Reach {
    number: Number,
    off: f64,
}

impl Reach {
    fn exact(self) -> Number {
        if self.off == 0.0 { self.number } else { self.number.plus(Number::Real(self.off)) }
    }

    fn compare(self, other: Reach) -> Ordering {
        if self.off == other.off {
            return self.number.compare(other.number).unwrap_or(Ordering::Equal);
        }
        // Sums of decimals take time: where floats lie clearly apart they are not needed.
        let (a, b) = (self.number.as_real() + self.off, other.number.as_real() + other.off);
        match (a - b).abs() > (a.abs() + b.abs()) * 1e-12 {
            true => a.total_cmp(&b),
            false => self.exact().compare(other.exact()).unwrap_or(Ordering::Equal),
        }
    }

    fn least(self, other: Reach) -> Reach {
        if other.compare(self).is_lt() { other } else { self }
    }

    fn most(self, other: Reach) -> Reach {
        if other.compare(self).is_gt() { other } else { self }
    }
}

/// Follows the values of one window.
#[derive(Clone, Debug)]
pub struct Extremes {
    window: UncertainWindow,
    last: Option<TimedValue>,
    /// What the least value is at most, and the greatest one at least.
    certain: Option<(Reach, Reach)>,
    possible: Option<(Reach, Reach)>,
    unknown: bool,
    /// The values with the time that they certainly last, where a mean is asked for.
    means: Option<Box<Means>>,
    /// Where the least and the greatest value began.
    at_least: Option<TimedValue>,
    at_most: Option<TimedValue>,
}

/// What the values of a window came to; each as the least and the greatest that some placement has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// The least value.
    pub(crate) least: Extent,
    /// The greatest value.
    pub(crate) most: Extent,
    /// The mean over the time, or the root of the mean square, where it was asked for.
    pub(crate) mean: Option<Extent>,
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
            means: None,
            at_least: None,
            at_most: None,
        }
    }

    /// The same with the mean over the time, or with `squares` the root of the mean square.
    #[must_use]
    pub(crate) fn with_mean(self, squares: bool) -> Extremes {
        Extremes { means: Some(Box::new(Means::new(squares))), ..self }
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
            value => Number::of(value).filter(|number| number.as_real().is_finite()),
        };
        let Some(number) = number else {
            self.unknown = true;
            return;
        };
        let off = seen.value.uncertainty();
        let (low, high) = (Reach { number, off: -off }, Reach { number, off });
        let (least, most) = self.possible.unwrap_or((low, high));
        if self.possible.is_none() || low.compare(least).is_lt() {
            self.at_least = Some(seen);
        }
        if self.possible.is_none() || high.compare(most).is_gt() {
            self.at_most = Some(seen);
        }
        self.possible = Some((least.least(low), most.most(high)));
        if self.window.must_meet(seen.b, end.0) {
            let (least, most) = self.certain.unwrap_or((high, low));
            self.certain = Some((least.least(high), most.most(low)));
            if let Some(means) = &mut self.means {
                let lasts = end.0.min(self.window.until.a).saturating_sub(seen.b.max(self.window.from.b));
                means.add((low.exact(), high.exact()), lasts.max(0));
            }
        }
    }

    /// What it came to when nothing comes any more; `None` if no number can lie in the window.
    pub fn finish(mut self) -> Option<Summary> {
        self.until((i64::MAX, i64::MAX));
        let (low, high) = self.possible?;
        let (low, high) = (low.exact(), high.exact());
        let at = (self.at_least?, self.at_most?);
        let (least, most) = match self.certain {
            Some((least, most)) => ((low, least.exact()), (most.exact(), high)),
            None => ((low, high), (low, high)),
        };
        let longest = match self.window.link {
            Some(length) => length,
            None => self.window.until.b.saturating_sub(self.window.from.a),
        };
        Some(Summary {
            least,
            most,
            mean: self.means.map(|means| means.finish((low, high), longest)),
            at,
            unknown: self.unknown,
        })
    }
}
