//! When the steps of a plan happened, read from the trace.
//!
//! A step's beginning is the first event of the mark `step:<id>`, its end that of `step:<id>.done` (where
//! nothing records an end, a step is done when it begins). Pulse `n` of a train is the `n`th rising edge of
//! the train's signal after its mark: as emitted, never as counted by the controller.

use std::collections::BTreeMap;

use signal::{Event, SignalInfo, Span, Value, When};

use super::edges::{CountedEdge, EdgeFinder};
use super::{TimedValue, UncertainInstant};
use crate::lang::{Anchor, AnchorBase};

/// A happening of the trace that instants of the plan depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Happening {
    at: When,
    place: u64,
}

/// The pulses of a train that the plan speaks of.
#[derive(Clone, Debug)]
struct TrainPulses {
    /// Place of the signal `step:<id>`, then that of the signal that the train is emitted on.
    mark: u32,
    line: u32,
    started: bool,
    counted: u64,
    finder: EdgeFinder,
    /// Number of the pulse and place of its base in `bases`, by number.
    wanted: Vec<(u64, usize)>,
}

/// The instants that a case's claims and measurements depend on.
#[derive(Clone, Debug)]
pub(crate) struct Anchors {
    bases: Vec<AnchorBase>,
    found: Vec<Option<Happening>>,
    /// By place of the signal: the base that its first event is.
    marks: BTreeMap<u32, Vec<usize>>,
    trains: Vec<TrainPulses>,
    /// By place of the signal: whether it matters here at all.
    relevant: Vec<bool>,
    /// The mark of the teardown's end, and when it was.
    closing: Option<u32>,
    closed: Option<Happening>,
}

impl Anchors {
    /// Prepares for these instants. `train` gives the signal that a step's train is emitted on.
    pub(crate) fn new<'a>(
        anchors: impl Iterator<Item = &'a Anchor>,
        train: impl Fn(&str) -> Option<String>,
        signals: &[SignalInfo],
    ) -> Anchors {
        let mut bases = vec![AnchorBase::Start, AnchorBase::Main, AnchorBase::End];
        bases.extend(anchors.map(|anchor| anchor.base.clone()));
        bases.sort();
        bases.dedup();
        let mut this = Anchors {
            found: vec![None; bases.len()],
            bases,
            marks: BTreeMap::new(),
            trains: Vec::new(),
            relevant: vec![false; signals.len()],
            closing: None,
            closed: None,
        };
        let find = |name: &str| signals.iter().position(|info| info.name == name).map(|at| at as u32);
        this.closing = find("step:teardown.done");
        if let Some(mark) = this.closing {
            this.relevant[mark as usize] = true;
        }
        for (at, base) in this.bases.clone().iter().enumerate() {
            let mark = match base {
                AnchorBase::Start => find("step:start"),
                // Without a setup the case begins with its steps.
                AnchorBase::Main => find("step:main").or_else(|| find("step:start")),
                AnchorBase::End => find("step:end"),
                AnchorBase::Teardown => find("step:teardown"),
                AnchorBase::Occurrence { step, .. } => find(&format!("step:{step}")),
                AnchorBase::Step(id) => find(&format!("step:{id}")),
                AnchorBase::StepDone(id) => {
                    find(&format!("step:{id}.done")).or_else(|| find(&format!("step:{id}")))
                }
                AnchorBase::Pulse { step, n } => {
                    let line = train(step).and_then(|signal| find(&signal));
                    if let (Some(mark), Some(line)) = (find(&format!("step:{step}")), line) {
                        this.pulse(mark, line, *n, at);
                    }
                    None
                }
            };
            if let Some(mark) = mark {
                this.marks.entry(mark).or_default().push(at);
                this.relevant[mark as usize] = true;
            }
        }
        this
    }

    fn pulse(&mut self, mark: u32, line: u32, n: u64, base: usize) {
        self.relevant[mark as usize] = true;
        self.relevant[line as usize] = true;
        match self.trains.iter_mut().find(|train| train.mark == mark) {
            Some(train) => train.wanted.push((n, base)),
            None => self.trains.push(TrainPulses {
                mark,
                line,
                started: false,
                counted: 0,
                finder: EdgeFinder::new(CountedEdge::Rises, 0.0),
                wanted: vec![(n, base)],
            }),
        }
    }

    /// The next event of the trace. `true` if an instant became known.
    #[inline]
    pub(crate) fn feed(&mut self, event: &Event, place: u64) -> bool {
        if !self.relevant.get(event.signal.0 as usize).copied().unwrap_or(false) {
            return false;
        }
        let mut news = false;
        let now = Happening { at: event.at, place };
        if self.closing == Some(event.signal.0) {
            self.closed.get_or_insert(now);
        }
        for base in self.marks.get(&event.signal.0).into_iter().flatten() {
            let meant = match &self.bases[*base] {
                // A mark counts how often it happened.
                AnchorBase::Occurrence { n, .. } => event.value.as_int() == Some(i128::from(*n)),
                _ => !matches!(event.value, Value::Unknown),
            };
            if self.found[*base].is_none() && meant {
                self.found[*base] = Some(now);
                news = true;
            }
        }
        for train in &mut self.trains {
            train.started |= train.mark == event.signal.0 && event.value != Value::Unknown;
            if train.line != event.signal.0 {
                continue;
            }
            let (a, b) = (event.at.earliest.as_nanos(), event.at.latest.as_nanos());
            let seen = TimedValue::of(event, a, b, place);
            if train.finder.see(&seen).is_some_and(|found| found.certain) && train.started {
                train.counted += 1;
                for (n, base) in &train.wanted {
                    if *n == train.counted && self.found[*base].is_none() {
                        self.found[*base] = Some(now);
                        news = true;
                    }
                }
            }
        }
        news
    }

    /// Sets the end of the case where the trace has no mark of it.
    pub(crate) fn end(&mut self, at: When, place: u64) {
        if let Some(base) = self.bases.iter().position(|base| *base == AnchorBase::End) {
            self.found[base].get_or_insert(Happening { at, place });
        }
    }

    /// Place in the trace of the case's end; after everything in a case without a teardown.
    pub(crate) fn end_place(&self) -> u64 {
        if self.closing.is_none() {
            return u64::MAX;
        }
        let end =
            self.bases.iter().position(|base| *base == AnchorBase::End).and_then(|base| self.found[base]);
        end.map_or(u64::MAX, |end| end.place)
    }

    /// When the teardown was over, if the case has one.
    pub(crate) fn closed(&self, offset: Span) -> Option<UncertainInstant> {
        let happening = self.closed?;
        // No base has this number: what is linked to the end of the case is not linked to this.
        Some(UncertainInstant::new(happening.at, happening.place, u32::MAX - 1, offset))
    }

    /// When an instant was, if it came.
    pub(crate) fn resolve(&self, anchor: &Anchor) -> Option<UncertainInstant> {
        let base = self.bases.iter().position(|base| *base == anchor.base)?;
        let happening = self.found[base]?;
        Some(UncertainInstant::new(happening.at, happening.place, base as u32, anchor.offset))
    }
}
