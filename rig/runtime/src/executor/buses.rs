//! What the executor sees on the board's buses.

use super::Executor;
use crate::executor::rig_fault::RigFault;
use drivers::{BoardExt, BusError, BusEvent, BusId, LossReason};
use signal::{CanFrame, Cause, Time, When};

impl Executor<'_> {
    /// What the buses reported up to now.
    pub(super) fn poll_buses(&mut self, now: Time) -> Result<(), RigFault> {
        if self.parts.board.bus_list().is_empty() {
            return Ok(());
        }
        let mut events = std::mem::take(&mut self.buffers.polled_buses);
        events.clear();
        let polled = self.parts.board.poll_buses(now, &mut events);
        for event in &events {
            self.report_bus(event);
            self.see_bus(event);
            self.hear_at_port(event);
        }
        self.buffers.polled_buses = events;
        polled.map_err(|error| RigFault::Board { at: now, error })
    }

    fn see_bus(&mut self, event: &BusEvent) {
        match *event {
            BusEvent::Lost { at, reason, .. } if reason != LossReason::Injected => {
                self.bus_lost(at, event.bus(), reason);
            }
            // A modelled controller that goes off its bus was commanded to, by a plan.
            BusEvent::State { at, bus, state } if self.pacing.has_wires() => {
                self.bus_state_changed(at, bus, state)
            }
            BusEvent::Error { at, bus, error: BusError::SendTimeout } if self.pacing.has_wires() => {
                self.not_on_bus(at, bus)
            }
            BusEvent::Returned { at, bus } => self.bus_returned(at, bus),
            BusEvent::Dropped { at, bus, count } => {
                let known = &self.parts.board.bus_list()[usize::from(bus.0)];
                let (bus, kind) = (known.name.clone(), known.kind);
                self.report.fault.get_or_insert(RigFault::BusDropped { at, bus, kind, count });
            }
            BusEvent::CanFrame { bus, at, frame, own } => self.see_frame(bus, at, &frame, own),
            _ => {}
        }
    }

    /// A frame was on a bus: the signals that stand for it learn of it.
    fn see_frame(&mut self, bus: BusId, at: When, frame: &CanFrame, own: bool) {
        let at = match !self.pacing.has_wires() && !self.parts.clock.is_exact() {
            true => When::within(at.earliest, at.latest.max(self.actual)),
            false => at,
        };
        self.report.frames.hear(at.latest, bus, frame);
        let place = usize::from(bus.0);
        for index in 0..self.parts.wiring.buses.get(place).map_or(0, Vec::len) {
            let watch = &mut self.parts.wiring.buses[place][index];
            if let Some(value) = watch.see(frame, own) {
                let signal = watch.signal;
                self.record(signal, at, value, Cause::Board);
            }
        }
    }

    /// The counts of frames before the first one.
    pub(super) fn show_counts(&mut self) {
        for place in 0..self.parts.wiring.buses.len() {
            for index in 0..self.parts.wiring.buses[place].len() {
                let watch = &self.parts.wiring.buses[place][index];
                if let Some(value) = watch.initial() {
                    let signal = watch.signal;
                    self.parts.recorder.record(signal, When::exactly(Time::ZERO), value, Cause::Board);
                }
            }
        }
    }

    /// A step puts a frame on a bus.
    pub(super) fn send(&mut self, step: usize, bus: BusId, frame: &CanFrame) -> Result<(), RigFault> {
        let sent = self.parts.board.send(self.board_time(), bus, frame);
        if let Err(error) = sent {
            let step = self.parts.schedule.steps()[step].id.clone();
            let bus = self
                .parts
                .board
                .bus_list()
                .get(usize::from(bus.0))
                .map_or(String::new(), |bus| bus.name.clone());
            self.report.fault.get_or_insert(RigFault::NotSent { at: self.now, step, bus, error });
        }
        self.poll()
    }
}
