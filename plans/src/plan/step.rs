//! The steps of one case.

use std::collections::BTreeMap;

use document::{Data, Diagnostic, Entry, Fields, Findings, Node, Table};
use signal::Span;

use super::envelope::{self, STEP};
use super::expand::PlacedEntry;
use super::groups::RESERVED;
use super::keys::{MOST_TIMES, STEP_KEYS};
use super::names::{CaseNames, StepName};
use super::read::PlanDocument;
use super::times::WrittenTime;
use super::variants::Variant;
use super::{PlanStep, StepRepeat, StepTime};
use crate::codes;
use crate::lang::PlanNames;
use crate::lang::{Anchor, AnchorBase, Literal, is_id};
use crate::steps::{self, CasePart, StepCondition, StepNames, Stimulus};

/// Most times that a step comes that waits each time, where the plan does not say.
const USUAL_TIMES: u64 = 1_000;

/// The steps as anchors know them, before they are read.
pub(super) fn step_names(here: &[PlacedEntry<'_>]) -> BTreeMap<String, StepName> {
    let mut names = BTreeMap::new();
    for placed in here {
        let (Some(table), Some(id)) = (placed.node.as_table(), placed.id()) else { continue };
        let inner = |key: &str| table.get(key).and_then(Node::as_table);
        // A wrong number is reported when the step is read; any may stand in an instant until then.
        let number = |table: &Table, key: &str| {
            table.get(key).map(|node| match &node.data {
                Data::Integer(number) => u64::try_from(*number).unwrap_or(0),
                _ => u64::MAX,
            })
        };
        let pulses = inner("train").map(|train| number(train, "count").unwrap_or(u64::MAX));
        let every = inner("every").map(|every| number(every, "times").unwrap_or(u64::MAX));
        let each = inner("when").filter(|when| when.get("each").is_some());
        let each = each.map(|when| number(when, "times").unwrap_or(USUAL_TIMES));
        let times = if placed.turn.is_some() { None } else { every.or(each) };
        names.insert(id, StepName { pulses, times });
    }
    names
}

/// Reads the steps of one case.
pub(super) struct StepReader<'a> {
    pub(super) document: &'a PlanDocument,
    pub(super) variant: &'a Variant<'a>,
    pub(super) number: u64,
    pub(super) seed: u64,
    pub(super) scope: &'a CaseNames<'a>,
}

impl StepReader<'_> {
    /// The steps in order, each with its time as written. Wrong ones are left out after they were reported.
    pub(super) fn read<'n>(
        &self,
        here: &'n [PlacedEntry<'_>],
        out: &mut Findings,
    ) -> (Vec<PlanStep>, Vec<WrittenTime<'n>>) {
        let (mut steps, mut written) = (Vec::with_capacity(here.len()), Vec::with_capacity(here.len()));
        let verbs: Vec<&'static str> = steps::VERBS.iter().map(|verb| verb.name).collect();
        let mut ids: BTreeMap<String, &Node> = BTreeMap::new();
        // The step before, in the same list.
        let mut before: BTreeMap<(&str, CasePart), String> = BTreeMap::new();
        for placed in here {
            self.scope.enter(&placed.call, out);
            let id = placed.id();
            let place = placed.node.as_table().and_then(|table| table.get("id"));
            if let (Some(id), Some(place)) = (&id, place)
                && let Some(first) = ids.insert(id.clone(), place)
            {
                report_twice(id, place, first, out);
            }
            let list = (placed.call.path.as_str(), placed.part);
            if let Some((step, time)) = self.step(placed, &verbs, before.get(&list), out) {
                steps.push(step);
                written.push(time);
            }
            if let Some(id) = id {
                before.insert(list, id);
            }
        }
        (steps, written)
    }

    fn step<'n>(
        &self,
        placed: &'n PlacedEntry<'_>,
        verbs: &[&'static str],
        previous: Option<&String>,
        out: &mut Findings,
    ) -> Option<(PlanStep, WrittenTime<'n>)> {
        let node: &Node = &placed.node;
        let (entry, own) = envelope::verb(node, &STEP, verbs, out)?;
        let fields = Fields::check(&own, node.span.clone(), "step", STEP_KEYS, out);
        let (stimulus, verb) = match entry {
            Some(entry) => (self.stimulus(entry, out), entry.key.as_str()),
            None => (Some(Stimulus::Mark), "mark"),
        };
        let id = self.id(&fields, placed, out);
        let phase = self.phase(placed, &fields, out);
        let time = match id.as_deref().and_then(|local| placed.instant(local)) {
            Some(instant) => Some((StepTime::At(instant.clone()), instant, node)),
            None => self.time(placed, &fields, previous, out),
        };
        let refused = fields.boolean("refused").unwrap_or(false);
        let (stimulus, id) = (stimulus?, id?);
        if refused && !stimulus.can_be_refused() {
            let place = fields.entry("refused").map_or(node.span.clone(), |entry| entry.key_span.clone());
            let message = format!("`{verb}` cannot be refused");
            out.error(
                codes::STIMULUS,
                place,
                message,
                "only commands, downloads, forcing, `file` and `write` can",
            );
            return None;
        }
        let repeat = self.repeat(node, &fields, &stimulus, out);
        let (when, anchor, place) = time?;
        let line = self.document.line(node.span.start);
        let until = repeat_node(node);
        let written = WrittenTime { anchor, node: place, until, phase: phase? };
        let id = placed.id().unwrap_or(id);
        let repeat = if placed.turn.is_some() { None } else { repeat? };
        let (span, part, parent) = (node.span.clone(), placed.part, placed.parent);
        let (counts_from, until_from) = (None, None);
        let step = PlanStep {
            id,
            part,
            when,
            counts_from,
            repeat,
            until_from,
            parent,
            stimulus,
            refused,
            span,
            line,
        };
        Some((step, written))
    }

    /// How the step comes more than once: `None` after it reported what is wrong, `Some(None)` for once.
    fn repeat(
        &self,
        node: &Node,
        fields: &Fields<'_>,
        stimulus: &Stimulus,
        out: &mut Findings,
    ) -> Option<Option<StepRepeat>> {
        let fault = |node: &Node, message: &str, help: &str, out: &mut Findings| {
            out.bad(codes::REPEAT, node, message, help);
            None
        };
        let runs = matches!(stimulus, Stimulus::Run { .. });
        let each = fields.inner("when").and_then(|when| Some((when, when.boolean("each")?)));
        let times = |fields: &Fields<'_>| fields.integer("times").and_then(|n| u64::try_from(n).ok());
        let Some(every) = fields.inner("every") else {
            let when = fields.inner("when").and_then(|when| when.get("times"));
            return match (fields.has("every"), each, when) {
                (true, ..) => None,
                (_, Some((_, true)), _) if runs || matches!(stimulus, Stimulus::Ask(_)) => {
                    let help = "give `each` to a step that does one thing, or run the group `every` so often";
                    fault(node, "a step with this verb cannot come each time", help, out)
                }
                (_, Some((when, true)), _) => {
                    Some(Some(StepRepeat::Each { times: times(&when).unwrap_or(USUAL_TIMES) }))
                }
                (_, _, Some(times)) => {
                    fault(times, "`times` counts for `each` alone", "add each = true", out)
                }
                _ => Some(None),
            };
        };
        let place = node.as_table()?.get("every")?;
        let period = every.duration("period")?;
        if fields.has("when") {
            let help = "write `each = true` into `when`, or let the step come `at` an instant";
            return fault(place, "a step that waits does not come `every` so often", help, out);
        }
        if matches!(stimulus, Stimulus::Ask(_)) {
            return fault(place, "a question is asked once", "ask again with a step of its own", out);
        }
        if period == Span::ZERO {
            return fault(place, "the period is 0", "as in period = \"100 ms\"", out);
        }
        if stimulus.duration() > period {
            let message = format!("it lasts {}, longer than its period of {period}", stimulus.duration());
            return fault(place, &message, "a step is done before it comes again: lengthen the period", out);
        }
        match (times(&every), every.get("until")) {
            (Some(times), None) => Some(Some(StepRepeat::Every { period, times, until: None })),
            (None, Some(_)) if runs => fault(
                place,
                "how often a group is run has to be known",
                "give `times` in place of `until`",
                out,
            ),
            (None, Some(until)) => {
                let until = Some(self.scope.anchor(until, out)?);
                Some(Some(StepRepeat::Every { period, times: MOST_TIMES.unsigned_abs(), until }))
            }
            _ => {
                let help = "as in every = { period = \"100 ms\", times = 10 } or until = \"stop\"";
                fault(place, "`every` has either `times` or `until`", help, out)
            }
        }
    }

    fn stimulus(&self, entry: &Entry, out: &mut Findings) -> Option<Stimulus> {
        let verb = steps::VERBS.iter().find(|verb| verb.name == entry.key)?;
        let right = document::check_value(&entry.node, verb.name, &verb.value, out);
        if right { (verb.read)(&entry.node, self.scope, out) } else { None }
    }

    /// The id as the step says it.
    fn id(&self, fields: &Fields<'_>, placed: &PlacedEntry<'_>, out: &mut Findings) -> Option<String> {
        let node = fields.get("id")?;
        let text = node.as_text()?;
        let inner = !placed.call.path.is_empty();
        if matches!(text, "start" | "main" | "end" | "teardown")
            || inner && RESERVED.contains(&text)
            || !is_id(text)
        {
            let mut help =
                "letters, digits, `_`, and `-` before a letter; not `start`, `main`, `end` or `teardown`";
            if inner {
                help = "not `begin`, `done` or `pulse` in a group, nor `start`, `main`, `end` or `teardown`";
            }
            out.bad(codes::STEP_ID, node, format!("`{text}` cannot be the id of a step"), help);
            return None;
        }
        Some(text.to_owned())
    }

    /// What the phase of this case adds to the step's time, in nanoseconds.
    fn phase(&self, placed: &PlacedEntry<'_>, fields: &Fields<'_>, out: &mut Findings) -> Option<i64> {
        let Some(phase) = fields.inner("phase") else { return (!fields.has("phase")).then_some(0) };
        if fields.has("when") {
            let place = fields.entry("phase")?.key_span.clone();
            let message = "a step that waits has no phase";
            out.error(
                codes::STEP_TIME,
                place,
                message,
                "remove `phase`, or let the step come `at` an instant",
            );
            return None;
        }
        let over = i128::from(phase.duration("over")?.as_nanos());
        let nanos = match self.variant.phases.iter().find(|(step, ..)| Some(*step) == placed.listed) {
            Some((_, position, count)) => over * i128::from(*position) / i128::from(*count),
            None if phase.has("positions") => return placed.turn.map(|_| 0),
            None => {
                let purpose = format!("{}:{}", self.number, placed.id().unwrap_or_default());
                (i128::from(draw(self.seed, &purpose)) * over) >> 64
            }
        };
        i64::try_from(nanos).ok()
    }

    /// The time of a step, its anchor and the value that says it.
    fn time<'n>(
        &self,
        placed: &'n PlacedEntry<'_>,
        fields: &Fields<'_>,
        previous: Option<&String>,
        out: &mut Findings,
    ) -> Option<(StepTime, Anchor, &'n Node)> {
        // The same values as in `fields`, but of the node, which lives longer.
        let node: &Node = &placed.node;
        let table = node.as_table()?;
        match (fields.has("at"), fields.has("when")) {
            (true, false) => {
                fields.get("at")?;
                let place = table.get("at")?;
                let anchor = self.scope.anchor(place, out)?;
                Some((StepTime::At(anchor.clone()), anchor, place))
            }
            (false, true) => {
                let when = fields.inner("when")?;
                let place = table.get("when")?;
                let (time, anchor) = self.awaited(&when, place, placed, previous, out)?;
                Some((time, anchor, place))
            }
            (both, _) => {
                let message =
                    if both { "the step has two times, `at` and `when`" } else { "the step has no time" };
                let help =
                    "write at = \"start + 1 s\", or when = { signal = ..., becomes = ..., within = ... }";
                out.error(codes::STEP_TIME, node.span.clone(), message, help);
                None
            }
        }
    }

    /// Where waiting begins in a list that has no step before.
    fn first(&self, placed: &PlacedEntry<'_>) -> Anchor {
        let at = |base| Anchor { base, offset: Span::ZERO };
        match (placed.call.path.as_str(), placed.part) {
            ("", CasePart::Main) if self.scope.parts.contains(&CasePart::Setup) => at(AnchorBase::Main),
            ("", CasePart::Teardown) => at(AnchorBase::Teardown),
            ("", _) => Anchor::START,
            (path, _) => at(AnchorBase::Step(path.to_owned())),
        }
    }

    fn awaited(
        &self,
        when: &Fields<'_>,
        place: &Node,
        placed: &PlacedEntry<'_>,
        previous: Option<&String>,
        out: &mut Findings,
    ) -> Option<(StepTime, Anchor)> {
        let signal = self.scope.whole_signal(when.get("signal")?, out);
        let given: Vec<&str> =
            ["becomes", "edge", "above", "below"].into_iter().filter(|key| when.has(key)).collect();
        let [key] = given.as_slice() else {
            let message = "the step waits for none of, or several of, `becomes`, `edge`, `above` and `below`";
            out.bad(codes::STEP_TIME, place, message, "write exactly one of them");
            return None;
        };
        let value = when.get(key)?;
        let awaits = match *key {
            "edge" => Some(match value.as_text()? {
                "rises" => StepCondition::Rises,
                "falls" => StepCondition::Falls,
                _ => StepCondition::Changes,
            }),
            key => Literal::read(value, out).map(|literal| match key {
                "becomes" => StepCondition::Becomes(literal),
                "above" => StepCondition::Above(literal),
                _ => StepCondition::Below(literal),
            }),
        };
        let from = match (when.get("from"), previous) {
            (Some(node), _) => self.scope.anchor(node, out)?,
            (None, Some(previous)) => Anchor { base: AnchorBase::Step(previous.clone()), offset: Span::ZERO },
            (None, None) => self.first(placed),
        };
        let time = StepTime::When {
            signal: signal?,
            awaits: awaits?,
            from: from.clone(),
            written: from.clone(),
            within: when.duration("within")?,
        };
        Some((time, from))
    }
}

/// The `until` of a step's `every`.
fn repeat_node(node: &Node) -> Option<&Node> {
    node.as_table()?.get("every")?.as_table()?.get("until")
}

fn report_twice(id: &str, place: &Node, first: &Node, out: &mut Findings) {
    let found = Diagnostic::error(codes::STEP_ID, format!("two steps have the id `{id}`"))
        .at(out.file().to_owned(), place.span.clone(), "the second")
        .at(out.file().to_owned(), first.span.clone(), "the first")
        .help("give it another id; one id in several rows needs a `rows` in each of its steps");
    out.push(found);
}

/// 64 bits of chance for one purpose: SplitMix64 of the seed and the purpose, fixed for ever.
fn draw(seed: u64, purpose: &str) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325u64;
    for byte in purpose.bytes() {
        hash = (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    }
    let mut z = (seed ^ hash).wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
