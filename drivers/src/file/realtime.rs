//! The table `realtime` of a board file.

use document::{Data, Fields, Findings};
use host::Processors;
use signal::Span;

use super::codes;
use crate::RealtimeSettings;

/// The least and the most that the application can be let ahead of the clock.
const HORIZON: [Span; 2] = [Span::from_micros(10), Span::from_millis(10)];

/// What the table says.
pub(super) fn realtime(fields: &Fields, out: &mut Findings) -> RealtimeSettings {
    let mut settings = RealtimeSettings::default();
    match fields.integer("priority") {
        Some(0) => settings.priority = None,
        Some(1) => {
            let help = "write 0 for none, or 2 to 97: devices run one below it";
            refuse(fields, "priority", "no priority below 1 is left for devices", help, out);
        }
        Some(priority) => settings.priority = u8::try_from(priority).ok(),
        None => {}
    }
    let numbers = fields.each("cpus").iter().filter_map(|node| match node.data {
        Data::Integer(number) => u16::try_from(number).ok(),
        _ => None,
    });
    settings.processors = Processors::new(numbers);
    if let Some(horizon) = fields.duration("horizon") {
        settings.horizon = horizon;
        if !(HORIZON[0]..=HORIZON[1]).contains(&horizon) {
            let help = format!("write {} to {}", HORIZON[0], HORIZON[1]);
            refuse(fields, "horizon", "the horizon is out of range", &help, out);
        }
    }
    settings.late = fields.duration("late");
    if settings.late == Some(Span::ZERO) {
        refuse(fields, "late", "no host is never late", "write how late the rig may be, as in \"1 ms\"", out);
    }
    settings
}

fn refuse(fields: &Fields, key: &str, message: &str, help: &str, out: &mut Findings) {
    if let Some(node) = fields.get(key) {
        out.bad(codes::REALTIME, node, message, help);
    }
}
