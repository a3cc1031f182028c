//! What the system variables show, as far as it is nowhere else.

use crate::clocks::Clocks;
use crate::first_cycle::FirstCycle;
use crate::last_state::Dates;
use crate::rtc::Rtc;
use crate::system_words::{SystemLinks, SystemWords};
use profile::{ApplicationError, BootProjectStatus, StopCause};

/// What the system variables show, as far as it is nowhere else.
#[derive(Clone, Debug)]
pub(crate) struct System {
    pub boot_project: BootProjectStatus,
    pub stop_cause: StopCause,
    pub error: ApplicationError,
    /// When RUNNING was left last, and when the controller went off last (controller:RB-06).
    pub dates: Dates,
    pub rtc: Rtc,
    /// The indicator of the battery stays dark (controller:LED-05).
    pub battery_led_inhibited: bool,
    pub clocks: Clocks,
    /// Events that configured inputs raised; counts round (plcsystem:PLCR-11).
    pub events: u16,
    /// The words of the structures that are written.
    pub words: SystemWords,
    /// What came before the first cycle of MAST (controller:TASK-53).
    pub first_cycle: FirstCycle,
    /// The system variables that the application has, too.
    pub links: SystemLinks,
}

impl System {
    /// What they show at first; the clock is fast by so many seconds a week, or slow below 0.
    pub(crate) fn new(clock_drift: i64) -> System {
        System {
            boot_project: BootProjectStatus::None,
            stop_cause: StopCause::Unknown,
            error: ApplicationError::None,
            dates: Dates::default(),
            rtc: Rtc::new(clock_drift),
            battery_led_inhibited: false,
            clocks: Clocks::default(),
            events: 0,
            words: SystemWords::default(),
            first_cycle: FirstCycle::default(),
            links: SystemLinks::default(),
        }
    }
}
