//! What goes wrong around the controller, which does not change the state by itself (controller:TR-23), and in it.

use super::Controller;
use crate::module::TaskModule;
use crate::probes::class;
use crate::{Disturbance, Effects, State};
use profile::IoStatus;
use signal::{Cause, Time};

impl Controller {
    /// Something in the world around the controller or in it goes wrong at `now`, or is over. Outputs that the reference does
    /// not have and bits that are reserved have no effect.
    pub fn disturb(&mut self, now: Time, disturbance: Disturbance, fx: &mut Effects) {
        self.scheduler.idle_until(now);
        match disturbance {
            Disturbance::ShortCircuit { output, on } => self.io.short_circuit(output, on),
            Disturbance::OverTemperature { output, on } => self.io.over_temperature(output, on),
            Disturbance::IoSupply(on) => self.io.supply(on),
            Disturbance::ExternalError { bit, on } => self.external.set(bit, on),
            Disturbance::InternalError(error) => self.fail(now, error, fx),
            Disturbance::Module { index, fault } => self.modules.bus.fault(now, index, fault),
            Disturbance::BusSupply(on) => self.modules.bus.supply(now, on),
            Disturbance::BusLink(whole) => self.modules.bus.link(now, whole),
            Disturbance::Battery { charge } => self.system.rtc.set_charge(charge),
        }
        self.protect(now, fx);
        self.observe(class::STATE | class::TERMINAL, now, Cause::Board, fx);
    }

    /// Whether an error outside of the controller is detected (controller:STATE-01, io:OUT-11).
    pub(super) fn external_error(&self) -> bool {
        self.external.is_any()
            || self.io.has_fault()
            || !self.io.is_supplied()
            || self.modules.bus.status() != IoStatus::Ok
            || self.modules.tm4_error()
    }

    /// PLC_R.i_wLocalIOStatus of an M241 (io:OUT-12); none without embedded inputs and outputs.
    pub(super) fn local_io_status(&self) -> Option<IoStatus> {
        (self.config.reference.output_count() > 0).then(|| match self.state {
            // Nothing is configured without an application.
            State::Empty => IoStatus::NotInitialised,
            _ if self.modules.bus.is_in_error() => IoStatus::BusError,
            _ => self.io.status(),
        })
    }
}
