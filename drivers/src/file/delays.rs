//! Delays between a terminal and the line of the machine: an optocoupler in front of an input, a stage behind an output.

use document::{Fields, Findings, Node};
use signal::Span;

use super::bench::Bench;
use super::codes;
use super::devices::{channels, generators};
use crate::ChannelId;

/// The keys of a channel that say so.
pub(super) const KEYS: &[&str] = &["input-delay", "output-delay"];

/// The longest that is a delay and no process.
const LONGEST: Span = Span::from_secs(10);

/// How far what happens at the terminal of a channel lies from what its line shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChannelDelay {
    /// The channel.
    pub channel: ChannelId,
    /// How much earlier than its line shows it a change happened: at least, at most. Both 0 for an output.
    pub before: (Span, Span),
    /// How much later than its line was driven a change happens at most; 0 for an input.
    pub after: Span,
}

/// The delays of a real board whose devices were read. What is wrong with them is reported.
pub(super) fn read(fields: &Fields, bench: &Bench, out: &mut Findings) -> Vec<ChannelDelay> {
    let mut delays = Vec::new();
    for (entry, fields) in channels(fields) {
        let Some(channel) = bench.file.find(&entry.key) else { continue };
        let spec = &bench.file.circuit.channels[usize::from(channel.0)];
        // What a generator puts out the rig reports, and nobody reads.
        let is_generated = generators::is_generated(&fields);
        let is_read = !is_generated && spec.senses && (!spec.drives || fields.has("readback"));
        let strange = if is_read { "output-delay" } else { "input-delay" };
        if let Some(entry) = fields.entry(strange) {
            let (what, help) = match is_read {
                true => (
                    "an input, or a line that is read back,",
                    "write `input-delay`: its level is what was read",
                ),
                false if is_generated => {
                    ("an output of a generator", "write `output-delay`: its level is what was driven")
                }
                false => {
                    ("an output that nobody reads back", "write `output-delay`: its level is what was driven")
                }
            };
            out.error(codes::DELAY, entry.key_span.clone(), format!("{what} has no `{strange}`"), help);
        }
        let before = fields.get("input-delay").filter(|_| is_read).and_then(|node| range(node, out));
        let after = fields.get("output-delay").filter(|_| !is_read).map(|node| {
            let after = fields.duration("output-delay").unwrap_or_default();
            too_long(node, after, out);
            after
        });
        if before.is_some() || after.is_some() {
            let (before, after) = (before.unwrap_or_default(), after.unwrap_or_default());
            delays.push(ChannelDelay { channel, before, after });
        }
    }
    delays
}

/// The least and the greatest delay. One duration is the greatest, as that of an output is: nothing is known of the least.
fn range(node: &Node, out: &mut Findings) -> Option<(Span, Span)> {
    let read = node.as_text().and_then(|text| match Span::parse(text) {
        Ok(most) => (!most.is_negative()).then_some((Span::ZERO, most)),
        Err(_) => Span::parse_range(text).ok(),
    });
    let Some((least, most)) = read else {
        let help =
            "write the greatest delay, or the least, at least 0, and the greatest, as in \"2 us .. 18 us\"";
        out.bad(codes::DELAY, node, "this is no delay", help);
        return None;
    };
    (!too_long(node, most, out)).then_some((least, most))
}

fn too_long(node: &Node, delay: Span, out: &mut Findings) -> bool {
    if delay > LONGEST {
        let help = format!("write at most {LONGEST}, with both ends of a range");
        out.bad(codes::DELAY, node, "no input or output takes as long", help);
    }
    delay > LONGEST
}
