//! What the indicators show (controller:STATE-01, io:LED-01).

use super::Controller;
use crate::led::{Led, LedInputs, LedPattern};
use crate::probe::Probe;
use crate::rtc::Battery;
use signal::Time;

impl Controller {
    fn led_inputs(&self) -> LedInputs {
        LedInputs {
            profile: self.config.profile,
            state: self.state,
            supplied: self.power.hold_up.is_none(),
            boot_step: self.power.boot_step(),
            system_error: self.power.system_error,
            application_differs: self.application_differs(),
            external_error: self.external_error(),
            tm4_error: self.external.tm4() || self.modules.tm4_error(),
            battery: match self.system.battery_led_inhibited {
                true => Battery::Good,
                false => self.system.rtc.battery(),
            },
        }
    }

    /// What an indicator shows.
    pub(super) fn pattern(&self, led: Led) -> LedPattern {
        self.leds.pattern(led, &self.led_inputs())
    }

    /// Whether an indicator is lit.
    pub(super) fn is_lit(&self, led: Led) -> bool {
        self.leds.is_lit(self.pattern(led), self.scheduler.now())
    }

    /// When an observed indicator is lit or goes dark next.
    pub(super) fn next_observed_flash(&self, now: Time) -> Time {
        let next = |probe: &Probe| match probe {
            Probe::LedLit(led) => self.leds.next_flash(self.pattern(*led), now),
            _ => Time::MAX,
        };
        self.probes.iter().map(next).min().unwrap_or(Time::MAX)
    }
}
