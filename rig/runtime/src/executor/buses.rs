//! What the executor sees on the board's buses.

use super::Executor;
use crate::trouble::Trouble;
use drivers::{BusEvent, LossReason};
use signal::Time;

impl Executor<'_> {
    /// What the buses told up to now.
    pub(super) fn poll_buses(&mut self, now: Time) -> Result<(), Trouble> {
        if self.board.buses().is_empty() {
            return Ok(());
        }
        let mut events = std::mem::take(&mut self.polled_buses);
        events.clear();
        let polled = self.board.poll_buses(now, &mut events);
        for event in &events {
            self.see_bus(event);
        }
        self.polled_buses = events;
        polled.map_err(|error| Trouble::Board { at: now, error })
    }

    fn see_bus(&mut self, event: &BusEvent) {
        let name = || self.board.buses()[usize::from(event.bus().0)].name.clone();
        match *event {
            BusEvent::Lost { at, reason, .. } if reason != LossReason::Injected => {
                let bus = name();
                self.ran.trouble.get_or_insert(Trouble::BusLost { at, bus, reason });
            }
            BusEvent::Dropped { at, count, .. } => {
                let bus = name();
                self.ran.trouble.get_or_insert(Trouble::FramesDropped { at, bus, count });
            }
            _ => {}
        }
    }
}
