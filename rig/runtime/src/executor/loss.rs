//! Devices that go away while a case runs, and those that come back.

use super::{Executor, LOG_LINES};
use crate::executor::rig_fault::RigFault;
use crate::schedule::EndReason;
use drivers::{BoardError, BoardExt, BusId, BusState, ChannelId, LossReason, OnLoss};
use signal::Time;

impl Executor<'_> {
    /// The device behind a channel is lost. A device of many channels reports it for each; the first says it all.
    pub(super) fn channel_lost(&mut self, at: Time, channel: ChannelId, reason: LossReason) {
        let device = self.parts.board.device(channel).unwrap_or_default().to_owned();
        self.device_lost(at, RigFault::Lost { at, channel, device, reason });
    }

    /// The device of a bus is lost.
    pub(super) fn bus_lost(&mut self, at: Time, bus: BusId, reason: LossReason) {
        let device = self.parts.board.bus_device(bus).unwrap_or_default().to_owned();
        self.device_lost(at, RigFault::BusLost { at, bus: self.bus_name(bus), device, reason });
    }

    /// The controller of a bus takes no part in it any more: what passes there is not seen, what is sent does not come.
    pub(super) fn bus_off(&mut self, at: Time, bus: BusId) {
        let device = self.parts.board.bus_device(bus).unwrap_or_default().to_owned();
        self.device_lost(at, RigFault::BusOff { at, bus: self.bus_name(bus), device });
    }

    fn device_lost(&mut self, at: Time, fault: RigFault) {
        if let RigFault::Lost { device, .. }
        | RigFault::BusLost { device, .. }
        | RigFault::BusOff { device, .. } = &fault
            && self.is_first_report(at, device.clone())
        {
            self.notice(at, fault.show(self.parts.board.channels()).to_string());
        }
        self.report.fault.get_or_insert(fault);
        if self.limits.on_loss == OnLoss::End {
            self.parts.schedule.end_early(EndReason::Lost, self.now);
        }
    }

    /// The device behind a channel is back. Its values come next.
    pub(super) fn channel_returned(&mut self, at: Time, channel: ChannelId) {
        let device = self.parts.board.device(channel).unwrap_or_default().to_owned();
        if self.is_first_report(at, device.clone()) {
            let name = &self.parts.board.channels()[usize::from(channel.0)].name;
            self.notice(at, format!("channel {name} is back at {at}: its device {device} answers"));
        }
    }

    /// The device of a bus is back.
    pub(super) fn bus_returned(&mut self, at: Time, bus: BusId) {
        if let Some(known) = self.devices.nodes.get_mut(usize::from(bus.0)) {
            *known = BusState::ErrorActive;
        }
        let device = self.parts.board.bus_device(bus).unwrap_or_default().to_owned();
        if self.is_first_report(at, device.clone()) {
            let name = self.bus_name(bus);
            self.notice(at, format!("bus {name} is back at {at}: its device {device} answers"));
        }
    }

    /// A controller takes part in its bus in another way.
    pub(super) fn bus_state_changed(&mut self, at: Time, bus: BusId, state: BusState) {
        let Some(known) = self.devices.nodes.get_mut(usize::from(bus.0)) else { return };
        let before = std::mem::replace(known, state);
        let how = match (before, state) {
            (before, state) if before == state => return,
            (_, BusState::BusOff) => return self.bus_off(at, bus),
            (BusState::BusOff, _) => "takes part again",
            (_, BusState::ErrorPassive) => "is error-passive: nobody acknowledges, or the bus is disturbed",
            (BusState::ErrorPassive, _) => "is no longer error-passive",
            _ => return,
        };
        let (name, device) = (self.bus_name(bus), self.parts.board.bus_device(bus).unwrap_or_default());
        let text = match before {
            BusState::BusOff => format!("bus {name} is back at {at}: its controller {device} {how}"),
            _ => format!("bus {name} at {at}: its controller {device} {how}"),
        };
        self.notice(at, text);
    }

    /// What the plan wanted to be sent did not come to its bus.
    pub(super) fn not_on_bus(&mut self, at: Time, bus: BusId) {
        let device = self.parts.board.bus_device(bus).unwrap_or_default().to_owned();
        let state = self.devices.nodes.get(usize::from(bus.0)).copied().unwrap_or(BusState::ErrorActive);
        let kind = self.parts.board.bus_list()[usize::from(bus.0)].kind;
        let fault = RigFault::NotOnBus { at, bus: self.bus_name(bus), kind, device, state };
        self.notice(at, fault.show(self.parts.board.channels()).to_string());
        self.report.fault.get_or_insert(fault);
    }

    /// What whoever watches has to know of the devices, and whoever reads the record later.
    pub(super) fn notice(&mut self, at: Time, text: String) {
        self.parts.subject.notice(at, &text);
        if let Some(live) = &mut self.live {
            live.log(at, &text);
        }
        if self.pacing.has_wires() && self.report.log.len() < LOG_LINES {
            self.report.log.push((at, text));
        }
    }

    /// Whether this is the first of its channels that reports a device at this instant.
    fn is_first_report(&mut self, at: Time, device: String) -> bool {
        let reported = Some((at, device));
        std::mem::replace(&mut self.devices.noticed, reported.clone()) != reported
    }

    /// Why the board did not start.
    pub(super) fn not_started(&self, error: BoardError) -> RigFault {
        let reconnect = self.limits.reconnect;
        match error {
            BoardError::Lost { channel, reason, since } => {
                let known = self.parts.board.channels().get(usize::from(channel.0));
                let what = known.map_or_else(String::new, |known| format!("channel {}", known.name));
                let device = self.parts.board.device(channel).unwrap_or_default().to_owned();
                RigFault::StillLost { what, device, reason, since, reconnect }
            }
            BoardError::BusLost { bus, reason, since } => {
                let device = self.parts.board.bus_device(bus).unwrap_or_default().to_owned();
                let what = format!("bus {}", self.bus_name(bus));
                RigFault::StillLost { what, device, reason, since, reconnect }
            }
            error => RigFault::Board { at: Time::ZERO, error },
        }
    }

    fn bus_name(&self, bus: BusId) -> String {
        let known = self.parts.board.bus_list().get(usize::from(bus.0));
        known.map_or_else(|| bus.0.to_string(), |known| known.name.clone())
    }
}
