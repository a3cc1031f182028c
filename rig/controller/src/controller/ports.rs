//! The ports at work: what comes to them and goes from them, and their steps in idle processor time.

use super::Controller;
use crate::endpoint::{Endpoint, PortEvent, PortMessage};
use crate::ports::PortStatus;
use crate::probes::class;
use crate::register_access::{Identification, RegisterAccess};
use crate::{Effect, Effects, LogEntry, RegisterError, State};
use profile::{FIRMWARE_VERSION, SERIAL_NUMBER, VENDOR_ID, VENDOR_NAME};
use signal::{Address, Area, Cause, Time};

impl Controller {
    /// Puts an endpoint at a port, by its number, in place of one that is there. FALSE, with nothing done, where the
    /// reference has no such port or the controller has power.
    pub fn attach_endpoint(&mut self, port: usize, endpoint: Box<dyn Endpoint>) -> bool {
        self.state == State::Off && self.ports.attach(port, endpoint)
    }

    /// What passed at a port.
    pub fn port_status(&self, port: usize) -> Option<PortStatus> {
        self.ports.status(port)
    }

    /// Something happened at a port, by `now`: [`Controller::run`] must have come there before. What reaches a port without
    /// an endpoint or a controller without power is discarded, and counted.
    pub fn receive(&mut self, now: Time, port: usize, event: &PortEvent, fx: &mut Effects) {
        self.scheduler.idle_until(now);
        self.ports.receive(now, port, event);
        self.send(now, fx);
    }

    /// The message of which [`Effect::PortOutput`] says that it is to be sent now.
    pub fn take_output(&mut self, port: usize) -> Option<PortMessage> {
        self.ports.take(port)
    }

    /// Tells the endpoints what happened to the controller, and lets those act that are due at `now`.
    pub(super) fn fire_ports(&mut self, now: Time, fx: &mut Effects) {
        if self.ports.next() > now {
            return;
        }
        if self.ports.notify(now) {
            for port in self.ports.attached() {
                fx.push(Effect::PortSilent { at: now, port });
            }
        }
        self.ports.fire(now);
        self.send(now, fx);
    }

    /// Announces what the ports send from now on, and reports what found no room.
    fn send(&mut self, now: Time, fx: &mut Effects) {
        while let Some(port) = self.ports.announce(now) {
            fx.push(Effect::PortOutput { at: now, port });
        }
        while let Some((port, dropped)) = self.ports.take_dropped() {
            let name = self.config.reference.ports.get(port).map_or("?", |port| port.name);
            self.log_entry(now, LogEntry::OutboxFull { port: name, dropped }, fx);
        }
    }

    /// Gives the step of a port the processor up to `end`, which no task wants until then, or to the end of the step.
    pub(super) fn run_ports(&mut self, end: Time, fx: &mut Effects) {
        let at = self.scheduler.now();
        let Some(left) = self.ports.left() else { return };
        if end - at < left {
            self.ports.pass(end - at);
            self.scheduler.skip_to(end);
            return;
        }
        let now = at.saturating_add(left);
        self.scheduler.skip_to(now);
        self.step_port(now, fx);
    }

    /// The step of a port takes effect.
    fn step_port(&mut self, now: Time, fx: &mut Effects) {
        let Some(port) = self.ports.stepping() else { return };
        let cause = Cause::Port(u8::try_from(port).unwrap_or(u8::MAX));
        // What it writes may command the controller, whose notes come into the place of the ports meanwhile.
        let mut ports = std::mem::take(&mut self.ports);
        ports.step(now, &mut PortRegisters { controller: self, now, cause, fx });
        ports.adopt(&std::mem::take(&mut self.ports));
        self.ports = ports;
        self.send(now, fx);
    }
}

/// The controller's memory during a step of a port.
struct PortRegisters<'a> {
    controller: &'a mut Controller,
    now: Time,
    cause: Cause,
    fx: &'a mut Effects,
}

impl PortRegisters<'_> {
    /// The addresses of bits; none where one is beyond the end of the area.
    fn bits(
        &self,
        area: Area,
        first: u32,
        count: usize,
    ) -> Result<impl Iterator<Item = Address> + use<>, RegisterError> {
        let end = u32::try_from(count).ok().and_then(|count| first.checked_add(count));
        let limit = self.controller.config.profile.address_limits().bits(area);
        let end = end.filter(|end| *end <= limit).ok_or(RegisterError::IllegalAddress)?;
        Ok((first..end).map(move |bit| Address::bit(area, bit)))
    }

    /// What follows a write, as after any from outside.
    fn written(&mut self) {
        self.controller.observe(class::MEMORY | class::VARIABLE, self.now, self.cause, self.fx);
        if self.controller.state == State::Stopped {
            self.controller.save_if_dirty(self.now);
        }
    }
}

impl RegisterAccess for PortRegisters<'_> {
    fn state(&self) -> State {
        self.controller.state
    }

    fn read_registers(&self, first: u16, out: &mut [u16]) -> Result<(), RegisterError> {
        self.controller.read_registers(first, out)
    }

    fn write_registers(&mut self, first: u16, values: &[u16]) -> Result<(), RegisterError> {
        self.controller.write_registers(self.now, first, values, self.cause, self.fx)?;
        self.written();
        Ok(())
    }

    fn read_bits(&self, area: Area, first: u32, out: &mut [bool]) -> Result<(), RegisterError> {
        if self.controller.state.status().is_none() {
            return Err(RegisterError::NoAnswer);
        }
        let places = self.bits(area, first, out.len())?;
        for (bit, at) in out.iter_mut().zip(places) {
            *bit = self.controller.memory.load(at) != 0;
        }
        Ok(())
    }

    fn write_bits(&mut self, area: Area, first: u32, values: &[bool]) -> Result<(), RegisterError> {
        if self.controller.state.status().is_none() {
            return Err(RegisterError::NoAnswer);
        }
        if area == Area::Input {
            return Err(RegisterError::IllegalAddress);
        }
        let places = self.bits(area, first, values.len())?;
        self.controller.memory.set_cause(self.cause);
        for (at, value) in places.zip(values) {
            self.controller.memory.store(at, u64::from(*value));
        }
        self.written();
        Ok(())
    }

    fn identification(&self) -> Identification {
        let reference = self.controller.config.reference;
        Identification {
            vendor: VENDOR_NAME,
            vendor_id: VENDOR_ID,
            reference: reference.name,
            product_id: reference.product_id(),
            firmware: FIRMWARE_VERSION,
            serial_number: SERIAL_NUMBER,
        }
    }
}
