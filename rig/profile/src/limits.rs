//! Limits of the configuration and the values that a parameter may take.

use crate::{Family, Profile, Reference};
use signal::Span;
use std::fmt;
use std::ops::RangeInclusive;

/// Words of %MW that the application can address: %MW0...%MW59999 (controller:MEM-06, controller:ADDR-02).
pub const MEMORY_WORDS: u32 = 60_000;

/// Words of %MW that are remanent without a declaration: %MW0...%MW999 (controller:REM-03).
pub const REMANENT_WORDS: u32 = 1_000;

/// Room for retain and persistent variables in bytes (controller:MEM-08).
pub const REMANENT_BYTES: usize = 64 * 1024;

/// Memory for the application's variables in bytes (controller:HW-01, controller:MEM-06).
pub const APPLICATION_BYTES: u32 = 8 << 20;

/// Bits of the input image and of the output image (io:ADR-06).
pub const IMAGE_BITS: u32 = 4_096;

/// Priorities of tasks, 0 the highest (controller:PRIO-01).
pub const PRIORITIES: RangeInclusive<u8> = 0..=31;

/// Priorities of controller tasks; the others are background tasks (controller:PRIO-03).
pub const FOREGROUND_PRIORITIES: RangeInclusive<u8> = 0..=24;

/// Priority of MAST where the configuration gives none (controller:TASK-50).
pub const DEFAULT_PRIORITY: u8 = 15;

/// How many tasks an application may have (controller:TASK-01).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TaskLimits {
    /// Tasks in all.
    pub total: usize,
    /// Cyclic tasks without a freewheeling task.
    pub cyclic: usize,
    /// Cyclic tasks beside a freewheeling one.
    pub cyclic_beside_freewheeling: usize,
    /// Freewheeling tasks.
    pub freewheeling: usize,
    /// Event tasks.
    pub event: usize,
    /// External event tasks.
    pub external_event: usize,
}

impl TaskLimits {
    pub(crate) fn of(profile: Profile, reference: &Reference) -> TaskLimits {
        let (total, cyclic, beside) = if profile == Profile::M241_2014 { (20, 4, 3) } else { (19, 5, 5) };
        let external_event = match (reference.family, reference.has_can()) {
            (Family::M241, _) => 8,
            (Family::M251, true) => 1,
            (Family::M251, false) => 0,
        };
        TaskLimits {
            total,
            cyclic,
            cyclic_beside_freewheeling: beside,
            freewheeling: 1,
            event: 8,
            external_event,
        }
    }
}

/// The integrating filter of a digital input (io: section 3, io:STD-IN-01).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum InputFilter {
    /// No filter behind the input's own delay.
    None,
    /// 1 ms.
    Ms1,
    /// 4 ms, the default.
    #[default]
    Ms4,
    /// 12 ms.
    Ms12,
}

impl InputFilter {
    /// Every value, shortest first.
    pub const ALL: [InputFilter; 4] =
        [InputFilter::None, InputFilter::Ms1, InputFilter::Ms4, InputFilter::Ms12];

    /// Time of the integrator; 0 for none.
    pub const fn span(self) -> Span {
        match self {
            InputFilter::None => Span::ZERO,
            InputFilter::Ms1 => Span::from_millis(1),
            InputFilter::Ms4 => Span::from_millis(4),
            InputFilter::Ms12 => Span::from_millis(12),
        }
    }

    /// The value of this time: 0, 1, 4 or 12 ms exactly.
    pub fn from_span(span: Span) -> Option<InputFilter> {
        InputFilter::ALL.into_iter().find(|filter| filter.span() == span)
    }
}

impl fmt::Display for InputFilter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            InputFilter::None => f.write_str("none"),
            other => write!(f, "{}", other.span()),
        }
    }
}

/// The anti-bounce filter of an input with Latch or Event (io: section 3, io:STD-IN-03): its time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct BounceFilter(Span);

impl BounceFilter {
    /// Every value, shortest first.
    pub const ALL: [BounceFilter; 10] = [
        BounceFilter(Span::from_micros(0)),
        BounceFilter(Span::from_micros(1)),
        BounceFilter(Span::from_micros(2)),
        BounceFilter(Span::from_micros(5)),
        BounceFilter(Span::from_micros(10)),
        BounceFilter(Span::from_micros(50)),
        BounceFilter(Span::from_micros(100)),
        BounceFilter(Span::from_micros(500)),
        BounceFilter(Span::from_millis(1)),
        BounceFilter(Span::from_millis(5)),
    ];

    /// The bounce time.
    pub const fn span(self) -> Span {
        self.0
    }

    /// The value of exactly this time.
    pub fn from_span(span: Span) -> Option<BounceFilter> {
        BounceFilter::ALL.into_iter().find(|bounce| bounce.0 == span)
    }
}

impl Default for BounceFilter {
    /// 0.002 ms.
    fn default() -> Self {
        BounceFilter(Span::from_micros(2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // controller:TASK-01
    #[test]
    fn task_limits() {
        let limits = |profile: Profile, name: &str| profile.task_limits(Reference::find(name).unwrap());
        let old = limits(Profile::M241_2014, "TM241CEC24T");
        assert_eq!(
            (old.total, old.cyclic, old.cyclic_beside_freewheeling, old.external_event),
            (20, 4, 3, 8)
        );
        let new = limits(Profile::M241_2019, "TM241CEC24T");
        assert_eq!(
            (new.total, new.cyclic, new.cyclic_beside_freewheeling, new.external_event),
            (19, 5, 5, 8)
        );
        assert_eq!(limits(Profile::M251_2024, "TM251MESC").external_event, 1);
        assert_eq!(limits(Profile::M251_2024, "TM251MESE").external_event, 0);
    }

    #[test]
    fn only_documented_times_are_values() {
        assert!(BounceFilter::ALL.contains(&BounceFilter::default()));
        assert_eq!(BounceFilter::from_span(Span::from_micros(3)), None);
        assert_eq!(InputFilter::from_span(Span::from_millis(4)), Some(InputFilter::default()));
        assert_eq!(InputFilter::from_span(Span::from_millis(2)), None);
    }
}
