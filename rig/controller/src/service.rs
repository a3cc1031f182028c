//! What a program asks of the controller.

use crate::{Controller, Service, State, VariableReset};
use signal::{Span, Time};

/// What came before RUNNING is entered next (controller:TASK-53).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Start {
    /// Nothing but a stop.
    #[default]
    Again,
    /// A reset warm, or a boot with a valid context.
    Warm,
    /// A reset cold, a download, or a boot without a valid context.
    Cold,
    /// RUNNING was entered behind this: MAST has not begun its first cycle.
    Entered(Behind),
    /// MAST is in its first cycle.
    First(Behind),
}

/// What came before the first cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Behind {
    Stop,
    Warm,
    Cold,
}

impl Start {
    /// A reset comes before the next start.
    pub(crate) fn behind(reset: VariableReset) -> Start {
        if reset == VariableReset::WARM { Start::Warm } else { Start::Cold }
    }
}

impl Controller {
    /// RUNNING is entered.
    pub(crate) fn begin_first_cycle(&mut self) {
        self.start = Start::Entered(match self.start {
            Start::Warm | Start::Entered(Behind::Warm) => Behind::Warm,
            Start::Cold | Start::Entered(Behind::Cold) => Behind::Cold,
            _ => Behind::Stop,
        });
    }

    /// A cycle of the task at this place begins.
    #[inline]
    pub(crate) fn start_first_cycle(&mut self, place: usize) {
        if let Start::Entered(behind) = self.start
            && place == self.mast
        {
            self.start = Start::First(behind);
        }
    }

    /// A cycle of the task at this place ended.
    #[inline]
    pub(crate) fn end_first_cycle(&mut self, place: usize) {
        if matches!(self.start, Start::First(_)) && place == self.mast {
            self.start = Start::Again;
        }
    }

    /// RUNNING is left, or a state like it.
    pub(crate) fn left(&mut self, from: State, now: Time) {
        if from == State::Booting && self.state.status().is_some() {
            self.system.clocks.begin(now);
        }
        // A breakpoint is a stop too, and what comes behind it is none again (controller:SYS-02).
        if from == State::Running || self.state == State::Off {
            if from == State::Running {
                self.system.dates.stop = self.system.rtc.date(now);
            }
            self.system.dates.save(&mut *self.store);
        }
    }

    /// Answers the task of this rank at once.
    pub(crate) fn serve(&mut self, rank: usize, service: Service, argument: i64) {
        let (now, place) = (self.cpu.at, self.tasks[rank].place);
        let start = self.start;
        let first =
            |behind: &[Behind]| i64::from(matches!(start, Start::First(this) if behind.contains(&this)));
        let answer = match service {
            Service::WaitSleep => {
                self.sleep(rank, now.saturating_add(Span::from_millis(argument)));
                0
            }
            Service::GetTaskCycle => self.interval(place).map_or(0, |interval| interval.as_nanos() / 1_000),
            Service::SetTaskCycle => i64::from(!self.set_interval(place, Span::from_micros(argument))),
            // The flags hold whatever task asks.
            Service::FirstMastCycle => first(&[Behind::Stop, Behind::Warm, Behind::Cold]),
            Service::FirstMastColdCycle => first(&[Behind::Cold]),
            Service::FirstMastWarmCycle => first(&[Behind::Warm]),
            Service::HasForcedIo => i64::from(self.forced_inputs.mask | self.forced_outputs.mask != 0),
            Service::GetRtc => self.system.rtc.seconds(now),
            Service::SetRtcDrift => self.system.rtc.set_drift(argument, self.config.profile, now),
            Service::InhibitBatteryLed => {
                self.battery_led_inhibited = argument != 0;
                0
            }
        };
        if let Some(application) = &mut self.application {
            application.answer(place, answer);
        }
    }
}
