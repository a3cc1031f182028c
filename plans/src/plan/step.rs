//! The steps of one case.

use std::borrow::Cow;
use std::collections::BTreeMap;

use document::{Data, Diagnostic, Entry, Fields, Findings, Node};
use signal::Span;

use super::envelope::{self, Form};
use super::keys::STEP_KEYS;
use super::read::Document;
use super::scope::Scope;
use super::times::Written;
use super::variants::Variant;
use super::{Await, Step, StepTime};
use crate::codes;
use crate::expect::Names;
use crate::lang::{Anchor, Base, Literal, is_id};
use crate::steps::{self, Stimulus};

const STEP: Form =
    Form { what: "step", list: "steps", own: STEP_KEYS, code: codes::STEP_VERB, alone: Some("when") };

/// The steps as anchors know them, before they are read.
pub(super) fn step_names(here: &[(usize, Cow<'_, Node>)]) -> BTreeMap<String, Option<u64>> {
    let mut names = BTreeMap::new();
    for (_, node) in here {
        let Some(table) = node.as_table() else { continue };
        let Some(id) = table.get("id").and_then(Node::as_text) else { continue };
        let count =
            table.get("train").and_then(Node::as_table).map(|train| train.get("count").map(|n| &n.data));
        let pulses = count.map(|count| match count {
            Some(Data::Integer(count)) => u64::try_from(*count).unwrap_or(0),
            // A wrong count is reported when the step is read; any pulse may stand in an anchor until then.
            _ => u64::MAX,
        });
        names.insert(id.to_owned(), pulses);
    }
    names
}

/// Reads the steps of one case.
pub(super) struct StepReader<'a> {
    pub(super) document: &'a Document,
    pub(super) variant: &'a Variant<'a>,
    pub(super) number: u64,
    pub(super) scope: &'a Scope<'a>,
}

impl StepReader<'_> {
    /// The steps in order, each with its time as written. Wrong ones are left out after they were reported.
    pub(super) fn read<'n>(
        &self,
        here: &'n [(usize, Cow<'_, Node>)],
        out: &mut Findings,
    ) -> (Vec<Step>, Vec<Written<'n>>) {
        let (mut steps, mut written) = (Vec::with_capacity(here.len()), Vec::with_capacity(here.len()));
        let verbs: Vec<&'static str> = steps::VERBS.iter().map(|verb| verb.name).collect();
        let mut ids: BTreeMap<&str, &Node> = BTreeMap::new();
        let mut previous: Option<&str> = None;
        for (at, node) in here {
            let id =
                node.as_table().and_then(|table| table.get("id")).and_then(|id| Some((id.as_text()?, id)));
            if let Some((text, place)) = id
                && let Some(first) = ids.insert(text, place)
            {
                report_twice(text, place, first, out);
            }
            if let Some((step, time)) = self.step(*at, node, &verbs, previous, out) {
                steps.push(step);
                written.push(time);
            }
            previous = id.map(|(text, _)| text).or(previous);
        }
        (steps, written)
    }

    fn step<'n>(
        &self,
        at: usize,
        node: &'n Node,
        verbs: &[&'static str],
        previous: Option<&str>,
        out: &mut Findings,
    ) -> Option<(Step, Written<'n>)> {
        let (entry, own) = envelope::verb(node, &STEP, verbs, out)?;
        let fields = Fields::check(&own, node.span.clone(), "step", STEP_KEYS, out);
        let (stimulus, verb) = match entry {
            Some(entry) => (self.stimulus(entry, out), entry.key.as_str()),
            None => (Some(Stimulus::Mark), "mark"),
        };
        let id = self.id(&fields, out);
        let phase = self.phase(at, &fields, out);
        let time = self.time(node, &fields, previous, out);
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
        let (when, anchor, place) = time?;
        let line = self.document.line(node.span.start);
        let written = Written { anchor, node: place, phase: phase? };
        Some((Step { id, when, stimulus, refused, span: node.span.clone(), line }, written))
    }

    fn stimulus(&self, entry: &Entry, out: &mut Findings) -> Option<Stimulus> {
        let verb = steps::VERBS.iter().find(|verb| verb.name == entry.key)?;
        let right = document::check_value(&entry.node, verb.name, &verb.value, out);
        if right { (verb.read)(&entry.node, self.scope, out) } else { None }
    }

    fn id(&self, fields: &Fields<'_>, out: &mut Findings) -> Option<String> {
        let node = fields.get("id")?;
        let text = node.as_text()?;
        if matches!(text, "start" | "end") || !is_id(text) {
            let help = "letters, digits, `_`, and `-` before a letter; not `start` or `end`";
            out.bad(codes::STEP_ID, node, format!("`{text}` cannot be the id of a step"), help);
            return None;
        }
        Some(text.to_owned())
    }

    /// What the phase of this case adds to the step's time, in nanoseconds.
    fn phase(&self, at: usize, fields: &Fields<'_>, out: &mut Findings) -> Option<i64> {
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
        let nanos = match self.variant.phases.iter().find(|(step, ..)| *step == at) {
            Some((_, position, count)) => over * i128::from(*position) / i128::from(*count),
            None if phase.has("positions") => return None,
            None => {
                let purpose = format!("{}:{}", self.number, fields.text("id").unwrap_or_default());
                (i128::from(draw(self.document.seed, &purpose)) * over) >> 64
            }
        };
        i64::try_from(nanos).ok()
    }

    /// The time of a step, its anchor and the value that says it.
    fn time<'n>(
        &self,
        node: &'n Node,
        fields: &Fields<'_>,
        previous: Option<&str>,
        out: &mut Findings,
    ) -> Option<(StepTime, Anchor, &'n Node)> {
        // The same values as in `fields`, but of the node, which lives longer.
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
                let (time, anchor) = self.awaited(&when, place, previous, out)?;
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

    fn awaited(
        &self,
        when: &Fields<'_>,
        place: &Node,
        previous: Option<&str>,
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
                "rises" => Await::Rises,
                "falls" => Await::Falls,
                _ => Await::Changes,
            }),
            key => Literal::read(value, out).map(|literal| match key {
                "becomes" => Await::Becomes(literal),
                "above" => Await::Above(literal),
                _ => Await::Below(literal),
            }),
        };
        let from = match (when.get("from"), previous) {
            (Some(node), _) => self.scope.anchor(node, out)?,
            (None, Some(previous)) => Anchor { base: Base::Step(previous.to_owned()), offset: Span::ZERO },
            (None, None) => Anchor::START,
        };
        let time = StepTime::When {
            signal: signal?,
            awaits: awaits?,
            from: from.clone(),
            within: when.duration("within")?,
        };
        Some((time, from))
    }
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
