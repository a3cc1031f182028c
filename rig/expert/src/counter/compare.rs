//! Thresholds, zones and reflexes (io:STD-HSC-11, io:STD-HSC-12).

use super::config::{CounterConfig, ThresholdEvent};

/// The most thresholds of a counter (VH-HSC-20).
pub(super) const MOST: usize = 4;

/// Compares a value with thresholds. The value's zone is the number of thresholds that it has reached; all else follows
/// from the zone, so that a value that stays in its zone costs one look.
#[derive(Clone, Debug)]
pub(super) struct Comparator {
    values: [i32; MOST],
    count: u8,
    /// Thresholds by what raises their events, bit n for threshold n.
    upwards: u8,
    downwards: u8,
    below: u8,
    above: u8,
    between: u8,
    /// Zones in which a reflex is on.
    reflexes: [u8; 2],
    on: bool,
    suspended: bool,
    /// None before the first comparison.
    zone: Option<u8>,
    /// While the value is in here, its zone stays.
    from: i64,
    to: i64,
}

impl Comparator {
    pub fn new(config: &CounterConfig) -> Comparator {
        let raised_by = |wanted: &[ThresholdEvent]| {
            (0..).zip(&config.thresholds).fold(0, |mask, (n, threshold)| {
                mask | u8::from(wanted.contains(&threshold.event)).checked_shl(n).unwrap_or(0)
            })
        };
        let mut values = [0; MOST];
        for (place, threshold) in values.iter_mut().zip(&config.thresholds) {
            *place = threshold.value;
        }
        let mut compare = Comparator {
            values,
            count: config.thresholds.len().min(MOST) as u8,
            upwards: raised_by(&[ThresholdEvent::Upwards, ThresholdEvent::Both]),
            downwards: raised_by(&[ThresholdEvent::Downwards, ThresholdEvent::Both]),
            below: raised_by(&[ThresholdEvent::Below]),
            above: raised_by(&[ThresholdEvent::Above]),
            between: raised_by(&[ThresholdEvent::Between]),
            reflexes: [config.reflex[0].zones, config.reflex[1].zones],
            on: false,
            suspended: false,
            zone: None,
            from: i64::MIN,
            to: i64::MAX,
        };
        compare.bound();
        compare
    }

    /// The thresholds that there are.
    pub fn thresholds(&self) -> &[i32] {
        &self.values[..usize::from(self.count)]
    }

    /// Whether the value is still in its zone, or nobody compares.
    #[inline]
    pub const fn stays(&self, value: i64) -> bool {
        self.from <= value && value < self.to
    }

    /// Where a value that goes from here to there next comes into another zone; there where it stays in its own.
    pub fn next_border(&self, value: i64, to: i64) -> i64 {
        match to > value {
            true if self.to > value => to.min(self.to),
            false if self.from <= value => to.max(self.from.saturating_sub(1)),
            _ => to,
        }
    }

    /// The value moved to this. Returns the thresholds whose events that raises.
    #[cold]
    pub fn moved(&mut self, value: i64) -> u8 {
        let Some(before) = self.zone else { return self.update_zone(value) };
        let after = self.zone_of(value);
        let raised = self.update_zone(value);
        let (reached_before, reached) = (below(before), below(after));
        raised | (reached & !reached_before & self.upwards) | (reached_before & !reached & self.downwards)
    }

    /// Comparison is switched on and off, and suspended. Returns the thresholds whose events that raises: nothing is
    /// crossed where the value does not move.
    pub fn switch(&mut self, on: bool, suspended: bool, value: i64) -> u8 {
        let on = on && self.count > 0;
        if (on, suspended) == (self.on, self.suspended) {
            return 0;
        }
        (self.on, self.suspended) = (on, suspended);
        if !on {
            self.zone = None;
        }
        self.update_zone(value)
    }

    /// The thresholds become others. Returns the thresholds whose events that raises.
    pub fn change(&mut self, values: [i32; MOST], value: i64) -> u8 {
        self.values = values;
        self.update_zone(value)
    }

    /// Works out the zone again. Returns the thresholds whose position events begin.
    fn update_zone(&mut self, value: i64) -> u8 {
        let mut raised = 0;
        if self.on && !self.suspended {
            let after = self.zone_of(value);
            raised = self.positions(after) & !self.zone.map_or(0, |before| self.positions(before));
            self.zone = Some(after);
        }
        self.bound();
        raised
    }

    fn zone_of(&self, value: i64) -> u8 {
        self.thresholds().iter().take_while(|threshold| i64::from(**threshold) <= value).count() as u8
    }

    /// The thresholds whose position events a zone means.
    const fn positions(&self, zone: u8) -> u8 {
        let reached = below(zone);
        (!reached & self.below) | (reached & self.above) | (reached & !(reached >> 1) & self.between)
    }

    fn bound(&mut self) {
        let zone = self.zone.filter(|_| self.on && !self.suspended).map(usize::from);
        let at = |place: Option<usize>| place.and_then(|place| self.thresholds().get(place)).copied();
        let (from, to) = (at(zone.and_then(|zone| zone.checked_sub(1))), at(zone));
        (self.from, self.to) = (from.map_or(i64::MIN, i64::from), to.map_or(i64::MAX, i64::from));
    }

    /// The thresholds that are reached, bit n for threshold n.
    pub const fn reached(&self) -> u8 {
        match self.zone {
            Some(zone) => below(zone),
            None => 0,
        }
    }

    /// Whether a reflex is on.
    pub fn reflex(&self, n: usize) -> bool {
        self.zone.is_some_and(|zone| self.reflexes[n] >> zone & 1 == 1)
    }

    pub const fn is_suspended(&self) -> bool {
        self.suspended
    }
}

/// The thresholds below a zone.
const fn below(zone: u8) -> u8 {
    (1 << zone) - 1
}
