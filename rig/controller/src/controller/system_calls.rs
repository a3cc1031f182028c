//! What a program asks of the controller.

use super::Controller;
use crate::probes::class;
use crate::{Effects, SystemCall};
use signal::{Cause, Span};

impl Controller {
    /// Answers the task of this rank at once.
    pub(super) fn answer_call(&mut self, rank: usize, call: SystemCall, argument: i64, fx: &mut Effects) {
        let (now, place) = (self.scheduler.now(), self.scheduler.place(rank));
        let answer = match call {
            SystemCall::WaitSleep => {
                self.scheduler.sleep(rank, now.saturating_add(Span::from_millis(argument)));
                0
            }
            SystemCall::GetTaskCycle => {
                self.interval(place).map_or(0, |interval| interval.as_nanos() / 1_000)
            }
            SystemCall::SetTaskCycle => i64::from(!self.set_interval(place, Span::from_micros(argument))),
            // The flags hold whatever task asks.
            SystemCall::FirstMastCycle | SystemCall::FirstMastColdCycle | SystemCall::FirstMastWarmCycle => {
                self.system.first_cycle.flag(call)
            }
            SystemCall::HasForcedIo => i64::from(self.has_forced()),
            SystemCall::ModuleInternalStatus => self.modules.bus.internal_status(now, argument),
            SystemCall::GetRtc => self.system.rtc.seconds(now),
            SystemCall::SetRtcDrift => self.system.rtc.set_drift(argument, self.config.profile, now),
            SystemCall::InhibitBatteryLed => {
                let before = std::mem::replace(&mut self.system.battery_led_inhibited, argument != 0);
                if before != self.system.battery_led_inhibited {
                    self.observe(class::STATE, now, Cause::Controller, fx);
                }
                0
            }
            SystemCall::ModuleBusStatus => i64::from(self.modules.bus.exchange_code(argument).code()),
            SystemCall::ModuleFirmware => i64::from(self.modules.bus.firmware(argument)),
        };
        if let Some(application) = &mut self.application {
            application.answer(place, answer);
        }
    }
}
