//! The loop by which the rig checks itself before a run.

use document::{Fields, Findings, Node};

use super::bench::Bench;
use super::{BoardKind, codes};
use crate::gpio::GpioSpec;
use crate::{ChannelId, LoopbackPair};

/// What the key `check` of a real board says.
pub(super) fn looped(board: &Fields, bench: &Bench, out: &mut Findings) -> Option<LoopbackPair> {
    let fields = board.inner("check")?;
    let (from, to) = (fields.get("out")?, fields.get("in")?);
    let found = LoopbackPair { out: bench.channel(from, out)?, input: bench.channel(to, out)? };
    let channels = &bench.file.circuit.channels;
    let mut suits = |node: &Node, yes: bool, message: String, help: &str| {
        if !yes {
            out.bad(codes::CHECK, node, message, help);
        }
        yes
    };
    let (driven, sensed) = (&channels[usize::from(found.out.0)], &channels[usize::from(found.input.0)]);
    // An output shows the world outside only where another line reads it back.
    let reads_back = |channel: ChannelId| match &bench.file.kind {
        BoardKind::Real(spec) => spec.of::<GpioSpec>().is_some_and(|gpio| {
            gpio.lines.iter().any(|line| line.channel == channel && line.readback.is_some())
        }),
        BoardKind::Simulated => false,
    };
    let comes_back =
        if found.out == found.input { reads_back(found.out) } else { sensed.senses && !sensed.drives };
    let sound = suits(
        from,
        driven.drives,
        format!("`{}` is an input, and the loop begins at an output", driven.name),
        "write `drives = true` to it, or name another channel",
    ) && suits(
        to,
        comes_back,
        format!("`{}` is no input, and the loop ends at one", sensed.name),
        "name an input, or the output itself where it has a `readback`",
    ) && suits(
        from,
        bench.file.bind.iter().all(|binding| binding.channel != found.out),
        format!("`{}` is bound to a terminal of the controller", driven.name),
        "take a line that nothing depends on: the rig drives it before each run",
    ) && suits(
        from,
        !bench.relays.contains(&found.out),
        format!("`{}` is a fault relay", driven.name),
        "take a line that nothing depends on: the rig drives it before each run",
    );
    sound.then_some(found)
}
