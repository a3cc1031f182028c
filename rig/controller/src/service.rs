//! What a program asks of the controller.

use crate::{Controller, State, SystemCall, VariableReset};
use signal::{Span, Time};

/// What came before RUNNING is entered next (controller:TASK-53).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum FirstCycle {
    /// Nothing but a stop.
    #[default]
    Again,
    /// A reset warm, or a boot with a valid context.
    Warm,
    /// A reset cold, a download, or a boot without a valid context.
    Cold,
    /// RUNNING was entered after this: MAST has not begun its first cycle.
    Entered(StartKind),
    /// MAST is in its first cycle.
    First(StartKind),
}

/// What came before the first cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StartKind {
    Stop,
    Warm,
    Cold,
}

impl FirstCycle {
    /// A reset comes before the next start.
    pub(crate) fn behind(reset: VariableReset) -> FirstCycle {
        if reset == VariableReset::WARM { FirstCycle::Warm } else { FirstCycle::Cold }
    }
}

impl Controller {
    /// RUNNING is entered.
    pub(crate) fn begin_first_cycle(&mut self) {
        self.start = FirstCycle::Entered(match self.start {
            FirstCycle::Warm | FirstCycle::Entered(StartKind::Warm) => StartKind::Warm,
            FirstCycle::Cold | FirstCycle::Entered(StartKind::Cold) => StartKind::Cold,
            _ => StartKind::Stop,
        });
    }

    /// A cycle of the task at this place begins.
    #[inline]
    pub(crate) fn start_first_cycle(&mut self, place: usize) {
        if let FirstCycle::Entered(behind) = self.start
            && place == self.mast
        {
            self.start = FirstCycle::First(behind);
        }
    }

    /// A cycle of the task at this place ended.
    #[inline]
    pub(crate) fn end_first_cycle(&mut self, place: usize) {
        if matches!(self.start, FirstCycle::First(_)) && place == self.mast {
            self.start = FirstCycle::Again;
        }
    }

    /// RUNNING is left, or a state like it.
    pub(crate) fn left(&mut self, from: State, now: Time) {
        if from == State::Booting && self.state.status().is_some() {
            self.system.clocks.begin(now);
        }
        // A breakpoint is a stop too, and what comes after it is none again (controller:SYS-02).
        if from == State::Running || self.state == State::Off {
            if from == State::Running {
                self.system.dates.stop = self.system.rtc.date(now);
            }
            self.system.dates.save(&mut *self.store);
        }
    }

    /// Answers the task of this rank at once.
    pub(crate) fn answer_call(&mut self, rank: usize, call: SystemCall, argument: i64) {
        let (now, place) = (self.cpu.at, self.tasks[rank].place);
        let start = self.start;
        let first = |behind: &[StartKind]| {
            i64::from(matches!(start, FirstCycle::First(this) if behind.contains(&this)))
        };
        let answer = match call {
            SystemCall::WaitSleep => {
                self.sleep(rank, now.saturating_add(Span::from_millis(argument)));
                0
            }
            SystemCall::GetTaskCycle => {
                self.interval(place).map_or(0, |interval| interval.as_nanos() / 1_000)
            }
            SystemCall::SetTaskCycle => i64::from(!self.set_interval(place, Span::from_micros(argument))),
            // The flags hold whatever task asks.
            SystemCall::FirstMastCycle => first(&[StartKind::Stop, StartKind::Warm, StartKind::Cold]),
            SystemCall::FirstMastColdCycle => first(&[StartKind::Cold]),
            SystemCall::FirstMastWarmCycle => first(&[StartKind::Warm]),
            SystemCall::HasForcedIo => i64::from(self.forced_inputs.mask | self.forced_outputs.mask != 0),
            SystemCall::GetRtc => self.system.rtc.seconds(now),
            SystemCall::SetRtcDrift => self.system.rtc.set_drift(argument, self.config.profile, now),
            SystemCall::InhibitBatteryLed => {
                self.battery_led_inhibited = argument != 0;
                0
            }
        };
        if let Some(application) = &mut self.application {
            application.answer(place, answer);
        }
    }
}
