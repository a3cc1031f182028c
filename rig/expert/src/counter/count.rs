//! What levels do to a counter.

use super::decode::ILLEGAL;
use super::meter::{Meter, MeterReading};
use super::{Controls, Counter, CounterMode, LimitsMode, diag, role};
use crate::{ExpertEffect, ExpertEffects};
use signal::Time;

impl Counter {
    /// Levels of these roles changed at `at`.
    #[inline]
    pub(super) fn take_levels(&mut self, at: Time, changed: u8, fx: &mut ExpertEffects) {
        if changed & role::ENABLE != 0 {
            self.refresh_enable(at);
        }
        if changed & (role::A | role::B) != 0 && self.enabled && self.active {
            self.take_phases(at, changed, fx);
        }
        if changed & !(role::A | role::B | role::ENABLE) != 0 && self.operating {
            self.take_captures(changed);
            self.take_sync(at, changed, fx);
        }
    }

    /// Phases changed while it counts.
    #[inline]
    fn take_phases(&mut self, at: Time, changed: u8, fx: &mut ExpertEffects) {
        let rises = changed & self.levels;
        for (phase, role) in [role::A, role::B].into_iter().enumerate() {
            if rises & role != 0 && self.paces[phase].is_excess(at) {
                self.add_uncertainty(at, self.weight, fx);
            }
        }
        self.since_b = if changed & role::B == 0 { self.since_b + u64::from(rises & role::A) } else { 0 };
        let (before, after) = ((self.levels ^ changed) & 3, self.levels & 3);
        let counts = self.table[usize::from(before << 2 | after)];
        if counts == ILLEGAL {
            self.diag |= diag::PHASES;
        } else if matches!(self.meter, Meter::None) {
            if counts != 0 {
                self.count(at, i64::from(counts), fx);
            }
        } else {
            let measurement = self.meter.edge(at, rises & role::A != 0);
            self.measured(at, measurement, fx);
        }
    }

    /// The value counts one up or down (io: section 17.3).
    #[inline]
    fn count(&mut self, at: Time, counts: i64, fx: &mut ExpertEffects) {
        if self.params.is_changed() {
            self.take_params(at, fx);
        }
        match self.params.mode() {
            CounterMode::OneShot { .. } => self.set(at, self.value - 1, fx),
            CounterMode::ModuloLoop { modulo } => {
                let (value, last) = (self.value + counts, i64::from(modulo) - 1);
                let crossed = !(0..=last).contains(&value);
                self.modulo_flag |= crossed;
                self.set(
                    at,
                    if !crossed {
                        value
                    } else if counts > 0 {
                        0
                    } else {
                        last
                    },
                    fx,
                );
            }
            CounterMode::FreeLarge { limits, .. } => {
                let value = self.value + counts;
                match (i32::try_from(value), limits) {
                    (Ok(_), _) => self.set(at, value, fx),
                    (Err(_), LimitsMode::Rollover) => {
                        self.modulo_flag = true;
                        self.set(at, i64::from(if counts > 0 { i32::MIN } else { i32::MAX }), fx);
                    }
                    (Err(_), LimitsMode::Lock) => {
                        (self.active, self.valid) = (false, false);
                        self.diag |= if counts > 0 { diag::OVERFLOW } else { diag::UNDERFLOW };
                    }
                }
            }
            CounterMode::EventCounting { .. }
            | CounterMode::Frequency { .. }
            | CounterMode::Period { .. } => {}
        }
        if self.value == 0 && matches!(self.params.mode(), CounterMode::OneShot { .. }) {
            self.active = false;
            fx.push(at, ExpertEffect::Stop { counter: self.number });
        }
    }

    /// The value becomes this, and whatever compares it follows.
    #[inline]
    pub(super) fn set(&mut self, at: Time, value: i64, fx: &mut ExpertEffects) {
        self.value = value;
        if !self.compare.stays(value) {
            let raised = self.compare.moved(value);
            self.raise(at, raised, fx);
            self.refresh_outputs(at, fx);
        }
    }

    /// Changed parameters count from here on (io:STD-HSC-14).
    #[cold]
    pub(super) fn take_params(&mut self, at: Time, fx: &mut ExpertEffects) {
        self.params.take();
        let raised = self.compare.change(self.params.thresholds(), self.value);
        self.raise(at, raised, fx);
        self.refresh_outputs(at, fx);
    }

    /// A meter completed a measurement.
    pub(super) fn measured(&mut self, at: Time, measurement: Option<MeterReading>, fx: &mut ExpertEffects) {
        let Some(MeterReading { value, valid }) = measurement else { return };
        if self.params.is_changed() {
            self.take_params(at, fx);
        }
        self.valid = valid;
        self.set(at, value, fx);
    }

    /// The enable condition may have changed (io:STD-HSC-04).
    pub(super) fn refresh_enable(&mut self, at: Time) {
        let by_input = self.controls.has(Controls::BY_EN) && self.levels & role::ENABLE != 0;
        let enabled = self.operating && (self.controls.has(Controls::ENABLE) || by_input);
        if enabled != self.enabled {
            self.enabled = enabled;
            if enabled {
                self.meter.begin(at);
            } else {
                self.meter.stop();
            }
        }
    }

    /// io:STD-HSC-13: a second capture before the first is acknowledged is not stored (io:STD-HSC-06).
    fn take_captures(&mut self, changed: u8) {
        if !self.controls.has(Controls::BY_CAP) {
            return;
        }
        for n in 0..self.captures.len() {
            let role = role::CAPTURE[n];
            let stores =
                |edges: profile::EventEdges| changed & role != 0 && edges.includes(self.levels & role != 0);
            if self.captures[n].is_some_and(|it| stores(it.edges)) && !self.captured[n].1 {
                self.captured[n] = (self.value, true);
            }
        }
    }

    /// The preset condition of input SYNC (io:STD-HSC-05).
    fn take_sync(&mut self, at: Time, changed: u8, fx: &mut ExpertEffects) {
        let Some(sync) = self.sync else { return };
        let high = |role: u8| self.levels & role != 0;
        if changed & role::SYNC != 0
            && self.controls.has(Controls::BY_SYNC)
            && sync.edges.includes(high(role::SYNC))
            && sync.while_enable.is_none_or(|level| level == high(role::ENABLE))
        {
            self.preset(at, fx);
        }
    }

    /// A preset, whether it is enabled or not (io:STD-HSC-05). Meters have none.
    pub fn preset(&mut self, at: Time, fx: &mut ExpertEffects) {
        if self.params.is_changed() {
            self.take_params(at, fx);
        }
        let value = match self.params.mode() {
            CounterMode::OneShot { preset } | CounterMode::FreeLarge { preset, .. } => i64::from(preset),
            CounterMode::ModuloLoop { .. } => 0,
            CounterMode::EventCounting { .. } => {
                // What was counted before this instant is lost, and the value stays (VH-HSC-13).
                self.preset_flag = true;
                if self.enabled {
                    self.meter.begin(at);
                    self.next = self.meter.next();
                }
                return;
            }
            CounterMode::Frequency { .. } | CounterMode::Period { .. } => return,
        };
        self.preset_flag = true;
        (self.active, self.valid, self.diag) = (true, true, 0);
        self.set(at, value, fx);
    }

    /// The value may be off by so many counts more.
    #[cold]
    pub(super) fn add_uncertainty(&mut self, at: Time, counts: u64, fx: &mut ExpertEffects) {
        self.excess = self.excess.saturating_add(counts);
        if !self.overdriven {
            self.overdriven = true;
            fx.push(at, ExpertEffect::Overdriven { function: self.place });
        }
    }
}
