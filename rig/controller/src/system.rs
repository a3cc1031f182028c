//! What the system variables show, as far as it is nowhere else.

use crate::clocks::Clocks;
use crate::first_cycle::FirstCycle;
use crate::last_state::Dates;
use crate::rtc::Rtc;
use crate::system_variable::SystemVariable;
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
    /// PLC_W.q_wPLCControl and PLC_W.q_uiOpenPLCControl.
    pub control: u16,
    pub open: u16,
    /// TM3_BUS_W.q_wIOBusErrPassiv and TM3_BUS_W.q_wIOBusRestart.
    pub bus_control: (u16, u16),
    /// What came before the first cycle of MAST (controller:TASK-53).
    pub first_cycle: FirstCycle,
    /// The system variables that the application has too, by their numbers in it.
    links: Vec<(SystemVariable, u32)>,
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
            control: 0,
            open: 0,
            bus_control: (0, 0),
            first_cycle: FirstCycle::default(),
            links: Vec::new(),
        }
    }

    /// The application mentions these system variables, by their numbers in it.
    pub(crate) fn set_links(&mut self, links: impl Iterator<Item = (SystemVariable, u32)>) {
        self.links.clear();
        self.links.extend(links);
    }

    /// The system variables that the application mentions, with their numbers in it.
    pub(crate) fn links(&self) -> &[(SystemVariable, u32)] {
        &self.links
    }

    /// The number of a system variable in the application, where that mentions it.
    pub(crate) fn link(&self, variable: SystemVariable) -> Option<u32> {
        self.links.iter().find(|(known, _)| *known == variable).map(|(_, number)| *number)
    }
}
