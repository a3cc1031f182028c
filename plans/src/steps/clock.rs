//! `battery` and `set-clock`: the real-time clock of the controller.

use document::{Data, Findings, KeyType, Node};
use signal::calendar::seconds_of;

use super::{DisturbanceKind, StepNames, StepVerb, Stimulus};
use crate::codes;

pub(super) const BATTERY: StepVerb = StepVerb {
    name: "battery",
    doc: "Gives the battery of the real-time clock a charge in per cent: 0 where it is empty or taken out.",
    value: KeyType::Integer(0, 100),
    needs: &["faults"],
    read: |node, _, _| {
        let Data::Integer(charge) = node.data else { return None };
        let charge = u8::try_from(charge).ok()?;
        Some(Stimulus::Disturb { what: DisturbanceKind::Battery(charge), on: true, lasts: None })
    },
};

pub(super) const SET_CLOCK: StepVerb = StepVerb {
    name: "set-clock",
    doc: "Sets the real-time clock, as the tool does.",
    value: KeyType::Text,
    needs: &["commands"],
    read: read_set_clock,
};

fn read_set_clock(node: &Node, _: &dyn StepNames, out: &mut Findings) -> Option<Stimulus> {
    let text = node.as_text()?.replacen(' ', "T", 1);
    let seconds = seconds_of(&text).or_else(|| seconds_of(&format!("{text}Z")));
    // The clock counts from 1970 on.
    let Some(seconds) = seconds.filter(|seconds| *seconds >= 0) else {
        let message = format!("`{text}` is no date and time from 1970 on");
        out.bad(
            codes::STIMULUS,
            node,
            message,
            "write it as in \"2026-11-28T14:00:00Z\"; without the Z it is what the clock is to show",
        );
        return None;
    };
    Some(Stimulus::SetClock { seconds })
}
