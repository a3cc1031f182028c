//! The channels of a module in words.

use profile::{AnalogueChannels, ModuleType};

/// What channels a module has: `16 digital inputs, 8 relay outputs`. Empty where it has none, or where no document says it.
pub fn channels(module: &ModuleType) -> String {
    let mut words = Vec::new();
    if let Some(inputs) = &module.digital_inputs {
        words.push(counted(inputs.count, "digital input"));
    }
    if let Some(outputs) = &module.digital_outputs {
        let kind = outputs.kind.map_or("digital", |kind| kind.name());
        words.push(counted(outputs.count, &format!("{kind} output")));
    }
    let analogue = |channels: &AnalogueChannels, what: &str| {
        let bits = channels.bits.map_or_else(String::new, |bits| format!(" of {bits} bit"));
        counted(channels.count, what) + &bits
    };
    words.extend(module.analogue_inputs.as_ref().map(|channels| analogue(channels, "analogue input")));
    words.extend(module.analogue_outputs.as_ref().map(|channels| analogue(channels, "analogue output")));
    words.join(", ")
}

/// `1 analogue output`, `2 analogue outputs`.
fn counted(count: u32, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}
