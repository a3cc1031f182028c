//! Counts that hardware made of the pulses.

use super::{Counter, CounterMode, LimitsMode, diag, role};
use crate::{ExpertEffect, ExpertEffects};
use profile::ChannelSet;
use signal::Time;

impl Counter {
    /// Hardware counts its pulses at one of these inputs: the levels of its phases mean nothing then.
    pub fn counted(&mut self, inputs: ChannelSet) {
        let place = self.roles.iter().position(|roles| roles & role::A != 0);
        let input = place.filter(|place| inputs.contains(*place));
        if let Some(input) = input {
            self.fed = Some(input as u8);
            self.roles.iter_mut().for_each(|roles| *roles &= !(role::A | role::B));
        }
    }

    /// The hardware at input `input` counted so many steps by `at`, below 0 backwards.
    ///
    /// The value goes all the way: what it passes is compared as pulse by pulse, at one instant. What it would pass for a
    /// third time round a modulo is left out, as nothing new comes of it.
    pub fn take_steps(&mut self, at: Time, input: u8, steps: i64, fx: &mut ExpertEffects) {
        if self.fed != Some(input) || steps == 0 || !self.enabled || !self.active {
            return;
        }
        if self.params.is_changed() {
            self.take_params(at, fx);
        }
        match self.params.mode() {
            CounterMode::OneShot { .. } => {
                // It counts pulses down, whichever way they go.
                let pulses = i64::try_from(steps.unsigned_abs()).unwrap_or(i64::MAX);
                self.move_value(at, (self.value - pulses.min(self.value)).max(0), fx);
                if self.value == 0 {
                    self.active = false;
                    fx.push(at, ExpertEffect::Stop { counter: self.number });
                }
            }
            CounterMode::ModuloLoop { modulo } => self.count_modulo(at, i64::from(modulo), steps, fx),
            CounterMode::FreeLarge { limits, .. } => self.count_free(at, limits, steps, fx),
            CounterMode::EventCounting { .. }
            | CounterMode::Frequency { .. }
            | CounterMode::Period { .. } => {}
        }
    }

    /// Round from 0 to the modulo less 1.
    fn count_modulo(&mut self, at: Time, modulo: i64, steps: i64, fx: &mut ExpertEffects) {
        let last = modulo - 1;
        let whole = steps / modulo;
        let mut left = steps - whole * modulo + whole.signum() * modulo;
        while left != 0 {
            let room = if left > 0 { last - self.value } else { -self.value };
            if left.abs() <= room.abs() {
                return self.move_value(at, self.value + left, fx);
            }
            self.move_value(at, self.value + room, fx);
            self.modulo_flag = true;
            self.set(at, if left > 0 { 0 } else { last }, fx);
            left -= room + left.signum();
        }
    }

    /// Through all values of a DINT.
    fn count_free(&mut self, at: Time, limits: LimitsMode, steps: i64, fx: &mut ExpertEffects) {
        let (low, high) = (i64::from(i32::MIN), i64::from(i32::MAX));
        let mut value = self.value.saturating_add(steps);
        if limits == LimitsMode::Lock {
            self.move_value(at, value.clamp(low, high), fx);
            if !(low..=high).contains(&value) {
                (self.active, self.valid) = (false, false);
                self.diag |= if steps > 0 { diag::OVERFLOW } else { diag::UNDERFLOW };
            }
            return;
        }
        while !(low..=high).contains(&value) {
            self.modulo_flag = true;
            let (end, other) = if value > high { (high, low) } else { (low, high) };
            self.move_value(at, end, fx);
            self.set(at, other, fx);
            value = (value - low).rem_euclid(high - low + 1) + low;
        }
        self.move_value(at, value, fx);
    }

    /// The value goes to another, through every zone on its way.
    fn move_value(&mut self, at: Time, to: i64, fx: &mut ExpertEffects) {
        while self.value != to {
            let next = self.compare.next_border(self.value, to);
            self.set(at, next, fx);
        }
    }
}
