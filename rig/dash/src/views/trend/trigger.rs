//! The trigger: what the trend waits for, and the part of time that it then shows.

use super::store::{TrendPoint, TrendStore};
use control::Value;

/// What it waits for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TriggerEdge {
    /// FALSE becomes TRUE; a number comes above the level.
    #[default]
    Rise,
    /// TRUE becomes FALSE; a number comes below the level.
    Fall,
    /// Any change.
    Change,
}

/// What it does after a trigger.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TriggerMode {
    /// There is no trigger: the newest is shown.
    #[default]
    Off,
    /// The newest is shown while no trigger comes.
    Auto,
    /// The last trigger is shown until another comes.
    Normal,
    /// One trigger, and no other.
    Single,
}

impl TriggerEdge {
    /// All.
    pub const ALL: [TriggerEdge; 3] = [TriggerEdge::Rise, TriggerEdge::Fall, TriggerEdge::Change];

    /// In words.
    pub fn label(self) -> &'static str {
        match self {
            TriggerEdge::Rise => "rises",
            TriggerEdge::Fall => "falls",
            TriggerEdge::Change => "changes",
        }
    }
}

impl TriggerMode {
    /// All.
    pub const ALL: [TriggerMode; 4] =
        [TriggerMode::Off, TriggerMode::Auto, TriggerMode::Normal, TriggerMode::Single];

    /// In words.
    pub fn label(self) -> &'static str {
        match self {
            TriggerMode::Off => "off",
            TriggerMode::Auto => "auto",
            TriggerMode::Normal => "normal",
            TriggerMode::Single => "single",
        }
    }
}

/// The trigger.
#[derive(Clone, Debug, PartialEq)]
pub struct TrendTrigger {
    /// What it does.
    pub mode: TriggerMode,
    /// The signal.
    pub signal: String,
    /// What it waits for.
    pub edge: TriggerEdge,
    /// The level of numbers.
    pub level: f64,
    /// How much of the window lies before the trigger, per cent.
    pub before: u8,
    /// It looks at changes after this instant only.
    armed: i64,
    /// A trigger whose time after it is not over yet.
    fired: Option<i64>,
    /// The last trigger whose window is whole.
    whole: Option<i64>,
}

impl Default for TrendTrigger {
    fn default() -> TrendTrigger {
        TrendTrigger {
            mode: TriggerMode::Off,
            signal: String::new(),
            edge: TriggerEdge::Rise,
            level: 0.5,
            before: 50,
            armed: i64::MAX,
            fired: None,
            whole: None,
        }
    }
}

/// How it stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TriggerState {
    /// There is none.
    Off,
    /// It waits.
    Armed,
    /// It came; what follows it is still to come.
    Fired,
    /// It came, its window is whole, and no other is waited for.
    Done,
}

impl TrendTrigger {
    /// Begins to wait, now.
    pub fn arm(&mut self, now: i64) {
        self.armed = if self.mode == TriggerMode::Off { i64::MAX } else { now };
        self.fired = None;
        self.whole = None;
    }

    /// How it stands.
    pub fn state(&self) -> TriggerState {
        match (self.mode, self.fired, self.whole) {
            (TriggerMode::Off, ..) => TriggerState::Off,
            (TriggerMode::Single, _, Some(_)) => TriggerState::Done,
            (_, Some(_), _) => TriggerState::Fired,
            _ => TriggerState::Armed,
        }
    }

    /// Whether a change is what it waits for.
    fn fits(&self, before: Value, after: Value) -> bool {
        match self.edge {
            // What it is when it is first seen is no change.
            TriggerEdge::Change => before != Value::Unknown && before != after,
            TriggerEdge::Rise => self.above(before) == Some(false) && self.above(after) == Some(true),
            TriggerEdge::Fall => self.above(before) == Some(true) && self.above(after) == Some(false),
        }
    }

    fn above(&self, value: Value) -> Option<bool> {
        match value {
            Value::Bool(on) => Some(on),
            other => other.as_real().map(|number| number >= self.level),
        }
    }

    /// Looks at a change before it goes into the store.
    pub fn observe(&mut self, name: &str, before: Value, point: &TrendPoint) {
        let waits = self.state() == TriggerState::Armed && name == self.signal && point.at > self.armed;
        if waits && self.fits(before, point.value) {
            self.fired = Some(point.at);
        }
    }

    /// Time passed; the window is `base` long.
    pub fn advance_to(&mut self, now: i64, base: i64) {
        let Some(at) = self.fired else { return };
        let end = at.saturating_add(self.after(base));
        if now >= end {
            self.whole = self.fired.take();
            // The next one is waited for after the window that is shown.
            self.armed = if self.mode == TriggerMode::Single { i64::MAX } else { end };
        }
    }

    fn after(&self, base: i64) -> i64 {
        base - base / 100 * i64::from(self.before)
    }

    /// The end of the window that is to be shown, if a trigger says so, and the trigger in it.
    pub fn window(&self, now: i64, base: i64) -> Option<(i64, i64)> {
        let at = match (self.fired, self.whole) {
            // One that has just come is drawn into as time goes on.
            (Some(at), _) => at,
            (None, Some(at)) => {
                let stale = at.saturating_add(self.after(base)).saturating_add(base.max(WAIT)) < now;
                if self.mode == TriggerMode::Auto && stale {
                    return None;
                }
                at
            }
            (None, None) => return None,
        };
        (self.mode != TriggerMode::Off).then(|| (at.saturating_add(self.after(base)), at))
    }
}

/// How long at least a trigger is shown where the newest follows it, nanoseconds.
const WAIT: i64 = 500_000_000;

impl TrendTrigger {
    /// The first instant that it may yet need of the store.
    pub fn keeps(&self, store: &TrendStore, base: i64) -> Option<i64> {
        let at = self.fired.or(self.whole.filter(|_| self.mode == TriggerMode::Single))?;
        Some(at.saturating_sub(base / 100 * i64::from(self.before)).max(store.begin()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn armed(mode: TriggerMode, edge: TriggerEdge) -> TrendTrigger {
        let mut trigger =
            TrendTrigger { mode, edge, signal: "a".to_owned(), before: 20, ..TrendTrigger::default() };
        trigger.arm(0);
        trigger
    }

    fn look(trigger: &mut TrendTrigger, at: i64, before: Value, value: Value) {
        trigger.observe("a", before, &TrendPoint { earliest: at, at, value });
    }

    #[test]
    fn each_condition_fires_on_what_it_says_and_on_nothing_else() {
        let (low, high) = (Value::Real(0.1), Value::Real(0.9));
        for (on, before, after, fires) in [
            (TriggerEdge::Rise, low, high, true),
            (TriggerEdge::Rise, high, low, false),
            (TriggerEdge::Rise, Value::Unknown, high, false),
            (TriggerEdge::Rise, Value::Bool(false), Value::Bool(true), true),
            (TriggerEdge::Rise, high, Value::Real(2.0), false),
            (TriggerEdge::Fall, high, low, true),
            (TriggerEdge::Fall, Value::Bool(true), Value::HighZ, false),
            (TriggerEdge::Change, high, Value::Real(2.0), true),
            (TriggerEdge::Change, Value::Unknown, high, false),
        ] {
            let mut trigger = armed(TriggerMode::Normal, on);
            look(&mut trigger, 5, before, after);
            assert_eq!(trigger.state() == TriggerState::Fired, fires, "{on:?} {before:?} {after:?}");
        }
    }

    #[test]
    fn single_takes_one_and_normal_the_next_behind_its_window() {
        for (mode, second) in [(TriggerMode::Single, 10), (TriggerMode::Normal, 100)] {
            let mut trigger = armed(mode, TriggerEdge::Rise);
            let edge =
                |trigger: &mut TrendTrigger, at| look(trigger, at, Value::Bool(false), Value::Bool(true));
            edge(&mut trigger, 10);
            trigger.advance_to(89, 100);
            assert_eq!((trigger.state(), trigger.window(89, 100)), (TriggerState::Fired, Some((90, 10))));
            trigger.advance_to(90, 100);
            edge(&mut trigger, 90);
            edge(&mut trigger, 100);
            assert_eq!(trigger.window(200, 100).map(|(_, at)| at), Some(second), "{mode:?}");
        }
    }

    #[test]
    fn auto_shows_the_newest_when_no_trigger_comes() {
        let base = 1_000_000_000;
        let mut trigger = armed(TriggerMode::Auto, TriggerEdge::Change);
        assert_eq!(trigger.window(5, base), None);
        look(&mut trigger, 10, Value::Int(1), Value::Int(2));
        trigger.advance_to(base, base);
        assert!(trigger.window(base + 10, base).is_some());
        assert_eq!(trigger.window(3 * base, base), None);
        trigger.mode = TriggerMode::Normal;
        assert!(trigger.window(3 * base, base).is_some());
    }
}
