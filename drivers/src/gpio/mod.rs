//! GPIO lines of the kernel's character devices: what there is, and (through either of the kernel's two interfaces)
//! claims on lines whose edges the kernel stamps.

mod board;
mod chip;
mod device;
mod driver;
mod edges;
mod error;
mod find;
mod info;
mod inputs;
mod lines;
mod make;
mod pace;
mod port;
mod reconnect;
mod spec;
mod track;
mod v1;
mod v2;

pub use board::GpioBoard;
pub use error::{GpioCall, GpioError};
pub use find::{FoundChip, devices, find, uses};
pub use info::{Backend, Bias, ChipInfo, Direction, Drive, LineInfo, list, look};
pub use make::Served;
pub use port::{Claim, Edge, GpioPort, LineLevels, Wanted};
pub use spec::{ChipSpec, FindChip, FindLine, GpioSpec, LineSpec, MAX_CONSUMER, MAX_LINES, NamedLine};

use crate::channel_table::ChannelTable;
use crate::{Channel, FaultSet, TimestampSource};
use signal::{Span, Value};

/// Describes the channels that have lines, before anything is known of their chips.
pub(crate) fn describe(table: &ChannelTable, spec: &GpioSpec, channels: &mut [Channel]) {
    for line in &spec.lines {
        let at = usize::from(line.channel.0);
        let (Some(channel), Some(known)) = (channels.get_mut(at), table.channels.get(at)) else {
            continue;
        };
        let debounce = Span::from_micros(i64::from(line.debounce_us));
        let sensed = line.direction == Direction::Input || line.readback.is_some();
        *channel = Channel {
            name: known.name.clone(),
            kind: known.kind.clone(),
            drives: known.drives,
            senses: known.senses,
            timestamp: TimestampSource::Kernel,
            resolution: Span::ZERO,
            // What a debounced line keeps is long enough to be seen. Of others nobody knows: a pulse may be over
            // before the kernel looks.
            shortest_pulse: if sensed && debounce > Span::ZERO { debounce } else { Span::MAX },
            deadband: 0.0,
            max_pulse_hz: line.pulses_hz,
            emits: None,
            counts_hz: line.counts_hz,
            faults: FaultSet::NONE,
            safe: if line.direction == Direction::Output { Value::Bool(line.safe) } else { Value::HighZ },
        };
    }
}
