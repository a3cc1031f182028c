//! The indicators of the controller: what each of them shows, and when it is lit (controller:STATE-01, io:LED-01).

use crate::rtc::Battery;
use crate::state::State;
use profile::Profile;
use signal::{Span, Time};

/// An indicator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Led {
    /// PWR, green: the supply.
    Pwr,
    /// RUN, green: the application.
    Run,
    /// ERR, red: errors of the controller.
    Err,
    /// I/O, red: errors detected outside of the controller.
    Io,
    /// TM4, red: errors of the TM4 bus.
    Tm4,
    /// BAT, red: the battery of the clock.
    Bat,
}

impl Led {
    /// Every indicator.
    pub const ALL: [Led; 6] = [Led::Pwr, Led::Run, Led::Err, Led::Io, Led::Tm4, Led::Bat];

    /// The name in a plan, as in `LED.RUN`.
    pub const fn name(self) -> &'static str {
        match self {
            Led::Pwr => "PWR",
            Led::Run => "RUN",
            Led::Err => "ERR",
            Led::Io => "IO",
            Led::Tm4 => "TM4",
            Led::Bat => "BAT",
        }
    }

    /// The indicator of this name, in any case of letters.
    pub fn find(name: &str) -> Option<Led> {
        Led::ALL.into_iter().find(|led| led.name().eq_ignore_ascii_case(name))
    }
}

/// What an indicator shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum LedPattern {
    /// Dark.
    Off = 0,
    /// Lit.
    On = 1,
    /// 50 ms lit, 50 ms dark (rig definition: the documents draw the times, in pictures that are lost).
    FastFlash = 2,
    /// 200 ms lit, 200 ms dark (rig definition).
    RegularFlash = 3,
    /// 200 ms lit, 1 s dark (rig definition).
    SingleFlash = 4,
}

impl LedPattern {
    /// Every pattern.
    pub const ALL: [LedPattern; 5] = [
        LedPattern::Off,
        LedPattern::On,
        LedPattern::FastFlash,
        LedPattern::RegularFlash,
        LedPattern::SingleFlash,
    ];

    /// The number in a trace.
    pub const fn number(self) -> i64 {
        self as i64
    }

    /// The name in plans and reports.
    pub const fn name(self) -> &'static str {
        match self {
            LedPattern::Off => "off",
            LedPattern::On => "on",
            LedPattern::FastFlash => "fast-flash",
            LedPattern::RegularFlash => "regular-flash",
            LedPattern::SingleFlash => "single-flash",
        }
    }

    /// Time lit and time dark of a flash.
    pub const fn times(self) -> Option<(Span, Span)> {
        match self {
            LedPattern::Off | LedPattern::On => None,
            LedPattern::FastFlash => Some((Span::from_millis(50), Span::from_millis(50))),
            LedPattern::RegularFlash => Some((Span::from_millis(200), Span::from_millis(200))),
            LedPattern::SingleFlash => Some((Span::from_millis(200), Span::from_secs(1))),
        }
    }

    /// Whether the indicator is lit `since` the beginning of the common phase, and how long it stays so
    /// ([`Span::MAX`] for ever).
    fn lit(self, since: Span) -> (bool, Span) {
        let Some((lit, dark)) = self.times() else { return (self == LedPattern::On, Span::MAX) };
        let (lit, dark) = (lit.as_nanos(), dark.as_nanos());
        let at = since.as_nanos().rem_euclid(lit + dark);
        (at < lit, Span::from_nanos(if at < lit { lit - at } else { lit + dark - at }))
    }
}

/// What the indicators depend on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LedInputs {
    pub profile: Profile,
    pub state: State,
    /// The supply is there.
    pub supplied: bool,
    /// Step of BOOTING, 0...2; the last one also while its end is being worked on.
    pub boot_step: usize,
    /// The boot was provoked by a system error.
    pub system_error: bool,
    /// The boot application is not the one in memory (controller:STATE-15).
    pub application_differs: bool,
    /// An error outside of the controller.
    pub external_error: bool,
    /// An error of the TM4 bus.
    pub tm4_error: bool,
    /// The battery, where its indicator shows it.
    pub battery: Battery,
}

/// The common phase of all flashes and what of it is observed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leds {
    /// Every flash begins lit here: the last power-on.
    origin: Time,
    /// The controller shows itself to somebody who looks for it (controller:LED-03).
    identify: bool,
    /// When an observed indicator is lit or goes dark next.
    next: Time,
    /// When anything was reported last.
    reported: Time,
}

impl Default for Leds {
    fn default() -> Self {
        Leds { origin: Time::ZERO, identify: false, next: Time::MAX, reported: Time::ZERO }
    }
}

impl Leds {
    /// Every flash begins at `now`.
    pub(crate) fn power_on(&mut self, now: Time) {
        self.origin = now;
    }

    /// Since when flashes flash.
    pub(crate) const fn origin(&self) -> Time {
        self.origin
    }

    /// Every indicator flashes, or no longer does.
    pub(crate) fn identify(&mut self, on: bool) {
        self.identify = on;
    }

    /// Values are reported at `at`.
    pub(crate) fn report(&mut self, at: Time) {
        self.reported = at;
    }

    /// When an observed indicator is lit or goes dark next.
    #[inline]
    pub(crate) const fn next(&self) -> Time {
        self.next
    }

    /// Sets when an observed indicator is lit or goes dark next.
    pub(crate) fn set_next(&mut self, next: Time) {
        self.next = next;
    }

    /// What an indicator shows.
    pub(crate) fn pattern(&self, led: Led, inputs: &LedInputs) -> LedPattern {
        if inputs.state == State::Off {
            LedPattern::Off
        } else if self.identify {
            LedPattern::RegularFlash
        } else {
            match led {
                Led::Pwr => on(inputs.supplied),
                Led::Run => inputs.run(),
                Led::Err => inputs.err(),
                Led::Io => on(inputs.io()),
                Led::Tm4 => on(inputs.state.status().is_some() && inputs.tm4_error),
                // That a low charge flashes in this rhythm is a rig definition.
                Led::Bat => match inputs.battery {
                    Battery::Good => LedPattern::Off,
                    Battery::Low => LedPattern::RegularFlash,
                    Battery::Empty => LedPattern::On,
                },
            }
        }
    }

    /// Whether a pattern is lit at `now`.
    pub(crate) fn is_lit(&self, pattern: LedPattern, now: Time) -> bool {
        pattern.lit(self.reported.max(now) - self.origin).0
    }

    /// When a pattern is lit or goes dark next.
    pub(crate) fn next_flash(&self, pattern: LedPattern, now: Time) -> Time {
        match pattern.lit(now - self.origin).1 {
            Span::MAX => Time::MAX,
            left => now.saturating_add(left),
        }
    }
}

impl LedInputs {
    const fn run(&self) -> LedPattern {
        match self.state {
            State::Booting => on(matches!(self.profile, Profile::M241_2014) && self.boot_step == 0),
            State::Running => LedPattern::On,
            State::Breakpoint => LedPattern::SingleFlash,
            State::Stopped | State::Halt => LedPattern::RegularFlash,
            State::Off | State::InvalidOs | State::Empty => LedPattern::Off,
        }
    }

    const fn err(&self) -> LedPattern {
        match self.state {
            State::Off => LedPattern::Off,
            State::Booting => on(self.boot_step > 0),
            State::InvalidOs => LedPattern::RegularFlash,
            State::Empty if self.system_error => LedPattern::FastFlash,
            State::Empty => LedPattern::SingleFlash,
            State::Halt => LedPattern::On,
            _ if self.application_differs => LedPattern::SingleFlash,
            State::Running | State::Breakpoint | State::Stopped => LedPattern::Off,
        }
    }

    const fn io(&self) -> bool {
        match self.state {
            State::Off | State::InvalidOs | State::Empty => false,
            State::Booting => match self.boot_step {
                0 => !matches!(self.profile, Profile::M241_2014),
                step => step == 1,
            },
            State::Running | State::Breakpoint | State::Stopped | State::Halt => self.external_error,
        }
    }
}

const fn on(lit: bool) -> LedPattern {
    if lit { LedPattern::On } else { LedPattern::Off }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flashes_begin_lit_and_come_again() {
        let ms = Span::from_millis;
        let single = LedPattern::SingleFlash;
        assert_eq!(single.lit(ms(0)), (true, ms(200)));
        assert_eq!(single.lit(ms(199)), (true, ms(1)));
        assert_eq!(single.lit(ms(200)), (false, ms(1_000)));
        assert_eq!(single.lit(ms(1_200)), (true, ms(200)));
        assert_eq!(LedPattern::FastFlash.lit(ms(149)), (true, ms(1)));
        assert_eq!(LedPattern::On.lit(ms(149)), (true, Span::MAX));
        assert!(LedPattern::ALL.iter().enumerate().all(|(n, pattern)| pattern.number() == n as i64));
    }
}
