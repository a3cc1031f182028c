//! Parameters that a program may change (io:STD-HSC-14).

use super::Counter;
use super::compare::MOST;
use super::config::{CounterConfig, CounterMode};

/// A parameter by its number in EXPERTSetParam and EXPERTGetParam.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CounterParam {
    /// 0: the value that a preset loads.
    Preset,
    /// 1: the modulo.
    Modulo,
    /// 2...5: a threshold.
    Threshold(usize),
}

/// Why a parameter stays as it was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ParamFault {
    /// The counter has no such parameter.
    Unknown,
    /// The parameter cannot have this value, or not beside the others.
    Value,
}

/// What a program set, and what is in force.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CounterParams {
    in_force: Values,
    set: Values,
    /// Something that was set is not in force yet.
    changed: bool,
    /// Thresholds that there are.
    count: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Values {
    mode: CounterMode,
    thresholds: [i32; MOST],
}

impl CounterParam {
    /// The parameter of a number.
    pub fn of(number: i64) -> Option<CounterParam> {
        match number {
            0 => Some(CounterParam::Preset),
            1 => Some(CounterParam::Modulo),
            2..=5 => Some(CounterParam::Threshold((number - 2) as usize)),
            _ => None,
        }
    }
}

impl CounterParams {
    pub fn new(config: &CounterConfig) -> CounterParams {
        let mut thresholds = [0; MOST];
        for (place, threshold) in thresholds.iter_mut().zip(&config.thresholds) {
            *place = threshold.value;
        }
        let values = Values { mode: config.mode, thresholds };
        CounterParams {
            in_force: values,
            set: values,
            changed: false,
            count: config.thresholds.len().min(MOST),
        }
    }

    /// The mode with the parameters that are in force.
    #[inline]
    pub const fn mode(&self) -> CounterMode {
        self.in_force.mode
    }

    /// The thresholds that are in force; as many of them mean something as were configured.
    pub const fn thresholds(&self) -> [i32; MOST] {
        self.in_force.thresholds
    }

    /// Whether something that was set is not in force yet.
    #[inline]
    pub const fn is_changed(&self) -> bool {
        self.changed
    }

    /// What was set is in force.
    pub fn take(&mut self) {
        (self.in_force, self.changed) = (self.set, false);
    }
}

impl Values {
    /// Whether they go together: thresholds strictly increasing, within the range (io:STD-HSC-11).
    fn is_possible(&self, count: usize) -> bool {
        let (least, most) = self.mode.range();
        let sound = match self.mode {
            CounterMode::OneShot { preset } => preset >= 1,
            CounterMode::ModuloLoop { modulo } => modulo >= 2,
            _ => true,
        };
        let thresholds = &self.thresholds[..count];
        sound
            && thresholds.iter().all(|threshold| (least..=most).contains(threshold))
            && thresholds.is_sorted_by(|a, b| a < b)
    }
}

impl Counter {
    /// Sets a parameter: it counts from the next count or preset on.
    pub fn set_param(&mut self, param: CounterParam, value: i32) -> Result<(), ParamFault> {
        let count = self.params.count;
        let mut values = self.params.set;
        match (param, &mut values.mode) {
            (
                CounterParam::Preset,
                CounterMode::OneShot { preset } | CounterMode::FreeLarge { preset, .. },
            ) => {
                *preset = value;
            }
            (CounterParam::Modulo, CounterMode::ModuloLoop { modulo }) => *modulo = value,
            (CounterParam::Threshold(n), _) if n < count => values.thresholds[n] = value,
            _ => return Err(ParamFault::Unknown),
        }
        if !values.is_possible(count) {
            return Err(ParamFault::Value);
        }
        (self.params.set, self.params.changed) = (values, true);
        Ok(())
    }

    /// A parameter as it was set last.
    pub fn param(&self, param: CounterParam) -> Option<i32> {
        let values = &self.params.set;
        match (param, values.mode) {
            (
                CounterParam::Preset,
                CounterMode::OneShot { preset } | CounterMode::FreeLarge { preset, .. },
            ) => Some(preset),
            (CounterParam::Modulo, CounterMode::ModuloLoop { modulo }) => Some(modulo),
            (CounterParam::Threshold(n), _) if n < self.params.count => Some(values.thresholds[n]),
            _ => None,
        }
    }
}
