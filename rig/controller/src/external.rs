//! What goes wrong around the controller: external errors (controller:ERR-01), faults at the outputs, the supply of
//! inputs and outputs. None of it changes the state by itself (controller:TR-23).

use crate::watch::class;
use crate::{Controller, Effects, State};
use profile::{IoStatus, Profile};
use signal::{Cause, Time};

/// Something that goes wrong in the world around the controller, or is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Disturbance {
    /// A short circuit at an output; it takes a current while the output is on.
    ShortCircuit {
        /// The output: n for Qn.
        output: usize,
        /// TRUE when it begins, FALSE when it is over.
        on: bool,
    },
    /// An output is too hot.
    OverTemperature {
        /// The output: n for Qn.
        output: usize,
        /// TRUE when it begins, FALSE when it is over.
        on: bool,
    },
    /// The supply of inputs and outputs is there, or not.
    IoSupply(bool),
    /// A part outside of the controller is in error: its bit of PLC_R.i_lwSystemFault_1 (controller:SYS-04).
    ExternalError {
        /// The bit.
        bit: u8,
        /// TRUE when it begins, FALSE when it is over.
        on: bool,
    },
}

/// The bits of PLC_R.i_lwSystemFault_1 that stand for something: TM3 (0 and 1), Ethernet IF1 and IF2, CAN 1, TM4, SD
/// card, firewall, DHCP server, OPC UA server. The others are reserved (controller:SYS-04; bit 0 is too, but the
/// text of the expansion bus uses it).
pub const FAULT_BITS: &[u8] = &[0, 1, 2, 3, 6, 9, 10, 11, 12, 13];

const TM4_BIT: u8 = 9;

/// The errors of parts outside of the controller.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ExternalErrors {
    /// A 1 for every part in error.
    faults: u64,
}

impl ExternalErrors {
    fn set(&mut self, bit: u8, on: bool) {
        if FAULT_BITS.contains(&bit) {
            self.faults = if on { self.faults | 1 << bit } else { self.faults & !(1 << bit) };
        }
    }

    /// PLC_R.i_lwSystemFault_1: a 0 for every part in error.
    pub(crate) const fn word(self) -> u64 {
        !self.faults
    }

    /// Whether the TM4 bus is in error.
    pub(crate) const fn tm4(self) -> bool {
        self.faults >> TM4_BIT & 1 == 1
    }
}

impl Controller {
    /// Something in the world around the controller goes wrong at `now`, or is over. Outputs that the reference does
    /// not have and bits that are reserved have no effect.
    pub fn disturb(&mut self, now: Time, disturbance: Disturbance, fx: &mut Effects) {
        self.idle_until(now);
        match disturbance {
            Disturbance::ShortCircuit { output, on } => self.protection.short_circuit(output, on),
            Disturbance::OverTemperature { output, on } => self.protection.over_temperature(output, on),
            Disturbance::IoSupply(on) => self.protection.supply(on),
            Disturbance::ExternalError { bit, on } => self.external.set(bit, on),
        }
        self.protect(now, fx);
        self.observe(class::STATE | class::TERMINAL, now, Cause::Board, fx);
    }

    /// Whether an error outside of the controller is detected (controller:STATE-01, io:OUT-11).
    pub(crate) fn external_error(&self) -> bool {
        self.external.faults != 0 || self.protection.reported() || !self.protection.supplied()
    }

    /// PLC_R.i_wLocalIOStatus of an M241 (io:OUT-12); none without embedded inputs and outputs.
    pub(crate) fn local_io_status(&self) -> Option<IoStatus> {
        (self.config.reference.output_count() > 0).then(|| match self.state {
            // Nothing is configured without an application.
            State::Empty => IoStatus::NotInitialised,
            _ if !self.protection.supplied() => IoStatus::PowerSupply,
            _ if self.protection.reported() => IoStatus::ShortCircuit,
            _ => IoStatus::Ok,
        })
    }
}

/// Driving the outputs, past protection and alarm.
impl Controller {
    /// Commands the drivers of `which` outputs at `now`: bit n for Qn, and the rearming command among the bits behind
    /// them.
    #[inline]
    pub(crate) fn drive(&mut self, now: Time, image: u32, which: u32, fx: &mut Effects) {
        let which = which & !self.functions.outputs();
        let bits = self.with_alarm(image);
        let all = self.outputs.commanded() & !which | bits & which;
        let quiet = self.protection.is_quiet();
        if which & self.rearming_bit == 0 {
            self.protection.update_without_write(now, all);
        } else {
            self.protection.update(now, all, image & self.rearming_bit != 0);
        }
        if quiet && self.protection.is_quiet() {
            self.outputs.drive(now, bits, which, &self.memory);
        } else {
            // A stage that protection switches off with this write must not come on with it.
            self.cut_outputs(now);
            self.outputs.drive(now, self.with_alarm(image), which, &self.memory);
            self.drive_alarm(now);
            self.observe(class::STATE | class::TERMINAL, now, Cause::Controller, fx);
        }
    }

    /// Protection looks at the outputs as they are commanded. Under hardware initialization values nothing is driven.
    pub(crate) fn protect(&mut self, now: Time, fx: &mut Effects) {
        if !self.outputs.initialized() {
            self.protection.update_without_write(now, self.outputs.commanded());
        }
        self.cut_outputs(now);
        self.drive_alarm(now);
        self.observe(class::STATE | class::TERMINAL, now, Cause::Controller, fx);
    }

    /// Stages that protection switches off, or that have no supply.
    fn cut_outputs(&mut self, now: Time) {
        let off = self.protection.off();
        self.outputs.cut(now, off | self.unsupplied());
        self.functions.protect(now, off);
    }

    /// Hardware initialization values (controller:OUT-02).
    pub(crate) fn initialize_outputs(&mut self, now: Time) {
        self.protection.reset();
        self.outputs.initialize(now);
    }

    /// Outputs that are without supply: all or none.
    fn unsupplied(&self) -> u32 {
        if self.protection.supplied() { 0 } else { self.outputs.mask() }
    }

    /// What the alarm output shows (controller:RS-08, io:OUT-03).
    fn alarm(&self) -> bool {
        let fault = self.config.profile != Profile::M241_2014 && self.protection.reported();
        self.state == State::Running && !fault
    }

    /// The alarm output is no longer the program's; only forcing goes before it (controller:FRC-02).
    #[inline]
    fn with_alarm(&self, bits: u32) -> u32 {
        match self.config.alarm_output {
            Some(output) if self.acting_outputs().mask >> output & 1 == 0 => {
                bits & !(1 << output) | u32::from(self.alarm()) << output
            }
            _ => bits,
        }
    }

    fn alarm_bit(&self) -> u32 {
        self.config.alarm_output.map_or(0, |output| 1 << output)
    }

    /// The alarm output follows the state at once, also where no outputs are updated (controller:STOP-02).
    pub(crate) fn drive_alarm(&mut self, now: Time) {
        if !self.outputs.initialized() && self.config.alarm_output.is_some() {
            let bits = self.with_alarm(self.outputs.commanded());
            self.outputs.drive(now, bits, self.alarm_bit(), &self.memory);
        }
    }
}
