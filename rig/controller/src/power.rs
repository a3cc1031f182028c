//! Supply, boot, and what a controller remembers of them while it is on.

use signal::Time;

/// Supply and boot.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Power {
    /// The supply is gone; the controller lives until then.
    pub hold_up: Option<Time>,
    /// Step of BOOTING and its end.
    pub stage: Option<(usize, Time)>,
    /// The boot was provoked by a system error.
    pub system_error: bool,
    /// HALT that only a power cycle ends (controller:WD-14).
    pub needs_power_cycle: bool,
    /// The boot was commanded by a script.
    pub script: bool,
    /// The firmware in non-volatile memory is valid.
    pub firmware: bool,
    /// When a power cycle is due (controller:RB-05).
    pub cycle_due: Option<Time>,
    /// The boot application is being saved until then.
    pub creating: Option<Time>,
    /// The Run/Stop switch is at Run.
    pub switch_at_run: bool,
    /// Next update of inputs and outputs in STOPPED and HALT.
    pub refresh: Option<Time>,
    /// A programming tool is connected (controller:FRC-01).
    pub tool_connected: bool,
}

impl Power {
    /// Without supply, the switch at Run.
    pub(crate) const fn new(tool_connected: bool) -> Power {
        Power {
            hold_up: None,
            stage: None,
            system_error: false,
            needs_power_cycle: false,
            script: false,
            firmware: true,
            cycle_due: None,
            creating: None,
            switch_at_run: true,
            refresh: None,
            tool_connected,
        }
    }

    /// When something here is due; [`Time::MAX`] for never.
    pub(crate) fn next(&self) -> Time {
        let or_never = |time: Option<Time>| time.unwrap_or(Time::MAX);
        let stage = or_never(self.stage.map(|(_, end)| end));
        let next = or_never(self.hold_up).min(or_never(self.refresh)).min(stage);
        next.min(or_never(self.cycle_due)).min(or_never(self.creating))
    }

    /// Step of BOOTING, 0...2; the last one also while its end is being worked on.
    pub(crate) fn boot_step(&self) -> usize {
        self.stage.map_or(2, |(step, _)| step)
    }
}
