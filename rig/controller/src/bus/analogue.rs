//! A module of analogue inputs and outputs, as the bus sees it.

use super::BusModule;
use crate::analogue::AnalogueModule;
use crate::memory::Memory;
use profile::ChannelStatus;
use signal::{Address, Image, Time};

impl BusModule for AnalogueModule {
    #[inline]
    fn read(&mut self, now: Time, inputs: &mut Image) {
        self.read(now, inputs);
    }

    #[inline]
    fn write(&mut self, now: Time, outputs: &Image, memory: &Memory) {
        self.write(now, outputs, memory);
    }

    fn clear(&mut self, now: Time) {
        self.clear(now);
    }

    fn supply(&mut self, now: Time, on: bool) {
        self.supply(now, on);
    }

    fn internal_status(&mut self, now: Time, channel: usize) -> Option<ChannelStatus> {
        self.internal_status(now, channel)
    }

    fn status_bytes(&self) -> &[Address] {
        self.status_bytes()
    }
}
