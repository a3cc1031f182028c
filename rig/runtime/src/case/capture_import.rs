//! A trace of a case out of what another instrument recorded, so that the same judge judges it.
//!
//! The case is laid out on its bench as for a run, which says what its signals are. The channels of the capture become
//! its signals. Its steps come when they are due, counted from the start that the user names, and where a step waits
//! for something, when the capture has it. Where it may have come or not, its mark is not known
//! (`docs/decisions/0068-steps-that-may-have-come.md`). After the end of the capture nothing is known.

use crate::case::look_up;
use crate::prepare::PreparedCase;
use crate::schedule::case_ending::CaseEnding;
use crate::schedule::{Act, Due, EndReason, PlannedStep, Schedule, Timing};
use crate::suite::case_files::CaseFiles;
use crate::suite::describe;
use crate::suite::instrument_file::InstrumentFile;
use capture::{Capture, CapturedChange, CapturedChannel, ChannelType, Knowledge, LevelRule, ReadingError};
use document::Diagnostic;
use plans::Case;
use plans::judge::{INSTANTS_COVERAGE_NOTE, coverage_note};
use plans::lang::{Anchor, AnchorBase};
use plans::plan::StepRepeat;
use plans::steps::CasePart;
use signal::{
    Cause, ClockDomain, Coverage, Event, Policy, Sampling, SignalId, SignalInfo, SignalRecording, Span, Time,
    Trace, TraceError, Value, ValueKind, When,
};

/// The note that names the instrument file by which a capture was read.
pub(crate) const INSTRUMENT_NOTE: &str = "instrument";
/// The note that has its text.
pub(crate) const INSTRUMENT_TEXT_NOTE: &str = "instrument-text";

/// The signals and steps of a case, as a run would have them.
#[derive(Debug)]
pub struct CaseLayout {
    prepared: PreparedCase,
}

/// Lays out a case.
///
/// # Errors
/// What a run would find in the user's files.
pub fn lay_out(case: &Case, files: &CaseFiles) -> Result<CaseLayout, Vec<Diagnostic>> {
    Ok(CaseLayout { prepared: look_up::lay_out(case, files)? })
}

impl CaseLayout {
    /// The signals, the marks of the steps among them.
    pub fn signals(&self) -> &[SignalInfo] {
        self.prepared.trace.signals()
    }

    /// How long after `start` a step is due, where that is known before the case.
    pub fn due(&self, step: &str) -> Option<Span> {
        match &self.prepared.steps.iter().find(|known| known.id == step)?.timing {
            Timing::At(Anchor { base: AnchorBase::Start, offset }) => Some(*offset),
            _ => None,
        }
    }

    /// Whether the case has this step.
    pub fn has_step(&self, step: &str) -> bool {
        self.prepared.steps.iter().any(|known| known.id == step)
    }
}

/// A channel of the capture that is a signal of the case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelMapping {
    /// Place of the channel.
    pub channel: usize,
    /// Place of the signal.
    pub signal: usize,
    /// Above this the signal is TRUE; `None` once [`find_levels`] has gone through the capture.
    pub threshold: Option<f64>,
    /// Distance of the thresholds of TRUE and FALSE around it.
    pub hysteresis: f64,
    /// How far the readings may be off.
    pub error: ReadingError,
    /// What that covers.
    pub coverage: Coverage,
}

impl ChannelMapping {
    /// A channel whose values are those of the signal.
    pub fn new(channel: usize, signal: usize) -> ChannelMapping {
        ChannelMapping {
            channel,
            signal,
            threshold: None,
            hysteresis: 0.0,
            error: ReadingError::default(),
            coverage: Coverage::Limits,
        }
    }

    /// The same as an instrument file describes it, whose threshold is that of a signal that has none yet.
    #[must_use]
    pub fn described(mut self, info: &SignalInfo, instrument: &InstrumentFile, name: &str) -> ChannelMapping {
        if let Some(channel) = instrument.channel(name) {
            if info.kind == ValueKind::Bool {
                // A threshold of the command line stands for both of the file's.
                if self.threshold.is_none() {
                    (self.threshold, self.hysteresis) = (channel.threshold, channel.hysteresis);
                }
            }
            self.error = channel.error;
            self.coverage = channel.coverage;
        }
        self
    }
}

/// Gives every mapping with a threshold a channel of levels of its own.
pub fn find_levels(capture: &mut Capture, wires: &mut [ChannelMapping]) {
    let rule = |wire: &ChannelMapping| {
        let threshold = wire.threshold?;
        let mut error = wire.error;
        // Within the deadband of a recording the value moved without a word.
        if let Some(SignalRecording { policy: Policy::Deadband(band), .. }) =
            capture.channels[wire.channel].recording
        {
            error.plus = (error.plus + band).next_up();
        }
        Some((wire.channel, LevelRule { threshold, hysteresis: wire.hysteresis, error }))
    };
    let rules: Vec<(usize, LevelRule)> = wires.iter().filter_map(rule).collect();
    let levels = capture.add_levels(&rules);
    for (wire, level) in wires.iter_mut().filter(|wire| wire.threshold.is_some()).zip(levels) {
        (wire.channel, wire.threshold) = (level, None);
    }
}

/// Why a channel cannot be a signal: what is wrong, and what to do.
pub fn misfit(
    channel: &CapturedChannel,
    info: &SignalInfo,
    threshold: Option<f64>,
) -> Option<(String, String)> {
    let (name, signal) = (&channel.name, &info.name);
    let shape = match channel.shape {
        ChannelType::Bit => "bits",
        ChannelType::Whole => "whole numbers",
        ChannelType::Real => "real numbers",
    };
    let numbers = channel.shape != ChannelType::Bit;
    match (info.kind, threshold) {
        (ValueKind::Bool, None) if numbers => Some((
            format!("`{signal}` is TRUE or FALSE, and `{name}` has {shape}"),
            format!("say above which value it is TRUE: --map \"{name}={signal}@2.5\""),
        )),
        (ValueKind::Bool, _) => None,
        (_, Some(_)) => Some((
            format!("`{signal}` is a number and has no threshold"),
            format!("write --map \"{name}={signal}\""),
        )),
        (ValueKind::Real, None) if !channel.unit.is_empty() && channel.unit != info.unit => Some((
            format!("`{name}` is in {}, and `{signal}` in {}", channel.unit, or_none(&info.unit)),
            format!("write the column in {}", or_none(&info.unit)),
        )),
        (ValueKind::Real, None) => None,
        (ValueKind::Int | ValueKind::Word | ValueKind::State | ValueKind::Mark, None)
            if channel.shape == ChannelType::Real =>
        {
            Some((
                format!("`{signal}` has whole numbers, and `{name}` has {shape}"),
                String::from("map a channel of whole numbers"),
            ))
        }
        _ => None,
    }
}

fn or_none(unit: &str) -> &str {
    if unit.is_empty() { "no unit" } else { unit }
}

/// Where the instants of the plan lie in the capture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Instants {
    /// The start of the case.
    pub start: When,
    /// Steps that did not come when the plan has them, but here.
    pub steps: Vec<(String, When)>,
}

/// A value of the capture as the signal has it.
fn fit(value: Value, kind: ValueKind, error: &ReadingError) -> Value {
    if matches!(value, Value::HighZ | Value::Unknown) {
        return value;
    }
    match kind {
        ValueKind::Bool => value.as_bool().map_or(Value::Unknown, Value::Bool),
        ValueKind::Real => {
            value.as_real().map_or(Value::Unknown, |number| read(number, value.uncertainty(), error))
        }
        ValueKind::Word => value.as_int().map_or(Value::Unknown, |n| Value::Word(n as u64)),
        // The low 64 bits: two's complement, as dumps have them.
        ValueKind::Int | ValueKind::State | ValueKind::Mark => {
            value.as_int().map_or(Value::Unknown, |n| Value::Int(n as i64))
        }
    }
}

/// A reading with how far the truth may lie from it, by what is stated of its instrument and by what it carries itself.
fn read(number: f64, own: f64, error: &ReadingError) -> Value {
    let off = match own {
        0.0 => error.of(number),
        own => error.of(number) + own,
    };
    match Value::measured(number, off) {
        // More than can be kept: the truth may be anything.
        Value::Real(_) if off > 0.0 => Value::Unknown,
        value => value,
    }
}

/// Makes the trace. Without `instants` the capture itself has the marks of the steps, as a dump of the rig's own has.
///
/// # Errors
/// The trace cannot hold it.
pub fn trace(
    layout: CaseLayout,
    case: &Case,
    files: &CaseFiles,
    capture: &Capture,
    wires: &[ChannelMapping],
    instants: Option<&Instants>,
    instrument: Option<&InstrumentFile>,
) -> Result<Trace, TraceError> {
    let PreparedCase { trace: model, mut steps, .. } = layout.prepared;
    let mut trace = Trace::new();
    for (place, info) in model.signals().iter().enumerate() {
        let wired = wires.iter().find(|wire| wire.signal == place);
        trace.define(match wired.and_then(|wire| capture.channels.get(wire.channel)) {
            Some(channel) => seen_by(info.clone(), channel, capture.knowledge),
            None => info.clone(),
        })?;
    }
    annotate(&mut trace, case, files, capture);
    if let Some(instrument) = instrument {
        annotate_instrument(&mut trace, wires, instrument);
    }
    let count = trace.signals().len();
    let mut widths = vec![0; steps.len()];
    let mut ends = case.ends.clone();
    if let Some(instants) = instants {
        lay_steps(&mut steps, &mut widths, &mut ends, case, instants);
    }
    let width_of = |change: &CapturedChange| width(change.at);
    let mut replay = Replay {
        changes: &capture.changes,
        next: 0,
        widest: capture.changes.iter().map(width_of).max().unwrap_or(0),
        wires,
        waits: vec![None; steps.len()],
        before: vec![None; count],
        start_mark: trace.find("step:start"),
        main_mark: trace.find("step:main"),
        end_mark: trace.find("step:end"),
        schedule: Schedule::new(steps, ends),
        trace,
        width: instants.map_or(0, |instants| width(instants.start)),
        widths,
        emitted: Vec::new(),
    };
    replay.run(capture.span[0], capture.end, instants.map(|instants| instants.start))?;
    CaseEnding { early: replay.schedule.early_end(), ..CaseEnding::default() }.write_to(&mut replay.trace);
    Ok(replay.trace)
}

/// Lays steps where the user says that they are, and with them what counts from them: other steps, and the end of the case.
fn lay_steps(
    steps: &mut [PlannedStep],
    widths: &mut [i64],
    ends: &mut Anchor,
    case: &Case,
    instants: &Instants,
) {
    let laid: Vec<Option<When>> = steps
        .iter()
        .map(|step| instants.steps.iter().find(|(id, _)| *id == step.id).map(|(_, at)| *at))
        .collect();
    let planned: Vec<Option<Anchor>> = steps
        .iter()
        .map(|step| match &step.timing {
            Timing::At(anchor) => Some(anchor.clone()),
            Timing::When { .. } => None,
        })
        .collect();
    let since_start = |at: When| at.latest - instants.start.latest;
    // The laid step that something counts from, through others.
    let root = |mut from: Option<usize>| loop {
        let step = from?;
        match laid[step] {
            Some(at) => return Some((step, at)),
            None => from = case.steps.get(step)?.counts_from,
        }
    };
    let moved = |anchor: &mut Anchor, from: Option<usize>| -> Option<When> {
        let (step, at) = root(from)?;
        let before = planned[step].as_ref().filter(|before| before.base == anchor.base)?;
        *anchor =
            Anchor { base: AnchorBase::Start, offset: since_start(at) + (anchor.offset - before.offset) };
        Some(at)
    };
    for (place, step) in steps.iter_mut().enumerate() {
        let Some(written) = case.steps.get(place) else { break };
        if let (Some(StepRepeat::Every { until: Some(until), .. }), Some(from)) =
            (&mut step.repeat, written.until_from)
        {
            moved(until, Some(from));
        }
        if let Some(at) = laid[place] {
            step.timing = Timing::At(Anchor { base: AnchorBase::Start, offset: since_start(at) });
            widths[place] = width(at);
            continue;
        }
        let (Timing::At(anchor) | Timing::When { from: anchor, .. }) = &mut step.timing;
        if let Some(at) = moved(anchor, written.counts_from) {
            widths[place] = width(at);
        }
    }
    moved(ends, case.ends_from);
}

/// What the trace knows of a signal that this instrument saw.
fn seen_by(info: SignalInfo, channel: &CapturedChannel, knowledge: Knowledge) -> SignalInfo {
    let (sampling, shortest) = match knowledge {
        Knowledge::Own => {
            return match channel.recording {
                Some(recording) => recording.applied_to(info),
                None => info,
            };
        }
        Knowledge::Edges(resolution) => (Sampling::Edges { resolution }, Span::ZERO),
        Knowledge::Sampled(period) => (Sampling::Sampled { period }, period),
    };
    SignalInfo {
        sampling,
        shortest_pulse: shortest,
        clock: ClockDomain::Device,
        policy: Policy::Changes,
        ..info
    }
}

/// Notes for judging, those of a file of the rig's own first, but for what names the case here.
fn annotate(trace: &mut Trace, case: &Case, files: &CaseFiles, capture: &Capture) {
    const HERE: [&str; 6] = ["clock", "plan", "plan-case", "profile", "reference", "seed"];
    describe::annotate_files(trace, case, files, "capture");
    for (key, value) in &capture.notes {
        if !HERE.contains(&key.as_str()) && !key.starts_with("given:") {
            trace.set_note(key, value.clone());
        }
    }
}

/// Whether a change may be what the step waits for. Where nothing is known anything may come.
fn may_meet(schedule: &Schedule, step: usize, before: Option<Value>, value: Value) -> bool {
    let Timing::When { event, .. } = schedule.steps()[step].timing else { return false };
    !is_known(Some(value)) || event.met(before, value)
}

fn is_known(value: Option<Value>) -> bool {
    value.is_some_and(|value| value != Value::Unknown)
}

/// Notes of the instrument: its file whole, so that the trace can be judged again without it, and what of it is no bound.
fn annotate_instrument(trace: &mut Trace, wires: &[ChannelMapping], instrument: &InstrumentFile) {
    trace.set_note(INSTRUMENT_NOTE, instrument.name.clone());
    trace.set_note(INSTRUMENT_TEXT_NOTE, instrument.text.clone());
    let mut instants = vec![instrument.coverage];
    let of = |wire: &ChannelMapping| {
        let info = trace.signals().get(wire.signal)?;
        Some((info.name.clone(), info.kind == ValueKind::Bool, wire.coverage))
    };
    let stated: Vec<_> =
        wires.iter().filter_map(of).filter(|(.., coverage)| *coverage != Coverage::Limits).collect();
    for (name, is_line, coverage) in stated {
        trace.set_note(&coverage_note(&name), coverage.to_string());
        // A step may wait for the line, and the start may be an edge of it.
        if is_line {
            instants.push(coverage);
        }
    }
    trace.set_note(INSTANTS_COVERAGE_NOTE, Coverage::together(instants));
}

fn width(at: When) -> i64 {
    (at.latest - at.earliest).as_nanos()
}

/// The case once more, with the capture in place of the controller.
struct Replay<'a> {
    /// All changes of the capture, and the first that is still to come.
    changes: &'a [CapturedChange],
    next: usize,
    /// The widest interval of a change, nanoseconds.
    widest: i64,
    wires: &'a [ChannelMapping],
    /// How each step waits, once it does.
    waits: Vec<Option<StepWait>>,
    /// What each signal was before its last change.
    before: Vec<Option<Value>>,
    schedule: Schedule,
    trace: Trace,
    start_mark: Option<SignalId>,
    main_mark: Option<SignalId>,
    end_mark: Option<SignalId>,
    /// How well the instants are known that steps depend on: the widest so far, as nanoseconds.
    width: i64,
    /// The same of each step that the user says an instant of, else 0.
    widths: Vec<i64>,
    /// What a generator would have written, which somebody else did.
    emitted: Vec<(drivers::ChannelId, Value)>,
}

/// How a step waits for what it comes with.
#[derive(Clone, Copy, Debug)]
struct StepWait {
    /// When it began to, at the latest.
    since: Time,
    /// How much earlier that may have been, nanoseconds.
    width: i64,
    /// For how long it waits.
    within: Span,
}

impl StepWait {
    /// Whether something in this interval came after the wait began, and in time, wherever both lie.
    fn holds(&self, at: When) -> bool {
        at.earliest >= self.since
            && at.latest <= self.since.saturating_add(self.within - Span::from_nanos(self.width))
    }
}

impl Replay<'_> {
    /// `first` is the first instant of the capture, `captured` its end.
    fn run(&mut self, first: Time, captured: When, start: Option<When>) -> Result<(), TraceError> {
        let mut waiting = start;
        while let Some(change) = self.changes.get(self.next) {
            // What a channel is at the first instant it was before, too: that is no edge of a case that starts there.
            let initial = change.at.latest <= first;
            let due = |start: &When| {
                start.latest < change.at.latest.saturating_add(Span::from_nanos(i64::from(!initial)))
            };
            if let Some(start) = waiting.filter(due) {
                self.start(start)?;
                waiting = None;
            }
            self.settle(change.at.latest, true)?;
            if self.schedule.end().is_some_and(|end| end < change.at.latest) {
                break;
            }
            self.next += 1;
            for wire in self.wires.iter().filter(|wire| wire.channel == change.channel as usize) {
                self.change(wire, change.at, change.value)?;
            }
        }
        let Some(all) = start else { return Ok(()) };
        if waiting.is_some() {
            self.start(all)?;
        }
        let last = captured.latest;
        self.settle(last, false)?;
        let end = self.schedule.end().unwrap_or(last);
        if end > last {
            self.lose_all(captured)?;
            self.settle(end, false)?;
        }
        for step in 0..self.schedule.steps().len() {
            if self.schedule.is_waiting(step) && self.may_come_by(step, end) {
                self.leave_open(step, end)?;
            }
        }
        self.mark(self.end_mark, end)?;
        self.changes_about(end)?;
        // The capture may end before the case.
        if end > captured.earliest && end <= last { self.lose_all(captured) } else { Ok(()) }
    }

    /// From here on no signal is known.
    fn lose_all(&mut self, at: When) -> Result<(), TraceError> {
        for wire in self.wires {
            self.put(SignalId(wire.signal as u32), at, Value::Unknown)?;
        }
        Ok(())
    }

    /// Changes that come after the end of the case at the latest, and may have come before it: they stand after it.
    fn changes_about(&mut self, end: Time) -> Result<(), TraceError> {
        for change in &self.changes[self.next..] {
            if change.at.latest.as_nanos().saturating_sub(self.widest) > end.as_nanos() {
                break;
            }
            for wire in self.wires.iter().filter(|wire| wire.channel == change.channel as usize) {
                if change.at.earliest < end {
                    self.take(wire, change.at, change.value)?;
                }
            }
        }
        Ok(())
    }

    fn start(&mut self, at: When) -> Result<(), TraceError> {
        self.mark(self.start_mark, at.latest)?;
        self.schedule.start(at.latest);
        self.settle(at.latest, true)
    }

    fn change(&mut self, wire: &ChannelMapping, at: When, value: Value) -> Result<(), TraceError> {
        let signal = SignalId(wire.signal as u32);
        let before = self.trace.last(signal).map(|event| event.value);
        let Some(value) = self.take(wire, at, value)? else { return Ok(()) };
        self.before[wire.signal] = before;
        if self.schedule.awaits(signal) {
            for step in self.left_open_by(signal, at, before, value) {
                self.leave_open(step, at.latest)?;
            }
            self.width = self.width.max(width(at));
            self.schedule.changed(signal, before, value, at.latest);
            self.settle(at.latest, true)?;
        }
        Ok(())
    }

    /// The steps that may have come with this change, or not: it may lie outside of their wait, or what the signal was, or is,
    /// is not known.
    fn left_open_by(&self, signal: SignalId, at: When, before: Option<Value>, value: Value) -> Vec<usize> {
        let open = |step: &usize| {
            self.schedule.is_awaiting(*step, signal)
                && may_meet(&self.schedule, *step, before, value)
                && !(is_known(before)
                    && is_known(Some(value))
                    && self.waits[*step].is_some_and(|wait| wait.holds(at)))
        };
        (0..self.schedule.steps().len()).filter(open).collect()
    }

    /// Whether a step that did not come with what the capture has up to its limit, or up to the end of the case, may have come
    /// by it all the same: the signal is not known, or a change that comes later in the capture may have happened before.
    fn may_come_by(&self, step: usize, limit: Time) -> bool {
        // What comes at the very end comes after it.
        let last = |end: Time| end.saturating_add(Span::from_nanos(-1));
        let limit = self.schedule.end().map_or(limit, |end| last(end).min(limit));
        let Timing::When { signal, .. } = self.schedule.steps()[step].timing else { return false };
        let mut before = self.trace.last(signal).map(|event| event.value);
        if !is_known(before) {
            return true;
        }
        let Some(info) = self.trace.signals().get(signal.0 as usize) else { return false };
        for change in &self.changes[self.next..] {
            // Changes stand in the order of their latest instants.
            if change.at.latest.as_nanos().saturating_sub(self.widest) > limit.as_nanos() {
                return false;
            }
            let own = |wire: &&ChannelMapping| {
                wire.signal == signal.0 as usize && wire.channel == change.channel as usize
            };
            let Some(wire) = self.wires.iter().find(own) else { continue };
            let value = fit(change.value, info.kind, &wire.error);
            if change.at.earliest <= limit && may_meet(&self.schedule, step, before, value) {
                return true;
            }
            before = Some(value);
        }
        false
    }

    /// Whether what the step waits for from now on may come unseen, or has come already: its signal is not known, or its last
    /// change may lie after the wait began.
    fn may_have_come(&self, step: usize, wait: StepWait) -> bool {
        let Timing::When { signal, .. } = self.schedule.steps()[step].timing else { return false };
        let Some(last) = self.trace.last(signal).filter(|last| is_known(Some(last.value))) else {
            return true;
        };
        last.at.latest > wait.since.saturating_add(Span::from_nanos(-wait.width))
            && may_meet(&self.schedule, step, self.before[signal.0 as usize], last.value)
    }

    /// Nobody knows whether this step came, and with it those that come only after it.
    fn leave_open(&mut self, step: usize, at: Time) -> Result<(), TraceError> {
        self.schedule.miss(step, at);
        // What stands after the end of the case is not judged.
        let at = self.schedule.end().map_or(at, |end| end.min(at));
        for open in self.schedule.with_those_after(step) {
            if self.schedule.begun(open).is_none() {
                self.put(self.schedule.steps()[open].mark, When::exactly(at), Value::Unknown)?;
            }
        }
        Ok(())
    }

    /// The value as the signal has it, if it is another.
    fn take(&mut self, wire: &ChannelMapping, at: When, value: Value) -> Result<Option<Value>, TraceError> {
        let Some(info) = self.trace.signals().get(wire.signal) else { return Ok(None) };
        let value = fit(value, info.kind, &wire.error);
        Ok(self.put(SignalId(wire.signal as u32), at, value)?.then_some(value))
    }

    fn put(&mut self, signal: SignalId, at: When, value: Value) -> Result<bool, TraceError> {
        // A capture is kept whole, and the rig's own file has what the policy kept.
        Ok(self.trace.push_kept(Event { signal, at, value, cause: Cause::Unknown })?.is_some())
    }

    /// The mark of something that happened by `at`, and as much earlier as the instants are known.
    fn mark(&mut self, mark: Option<SignalId>, at: Time) -> Result<(), TraceError> {
        let Some(mark) = mark else { return Ok(()) };
        let times = match self.trace.last(mark) {
            Some(Event { value: Value::Int(times), .. }) => times + 1,
            _ => 1,
        };
        let at = When::within(at.saturating_add(Span::from_nanos(-self.width)), at);
        self.put(mark, at, Value::Int(times)).map(|_| ())
    }

    /// The steps that are due. Where `more` changes may come at this very instant, a wait whose limit it is goes on.
    fn settle(&mut self, until: Time, more: bool) -> Result<(), TraceError> {
        let mut waits = Vec::new();
        while let Some((at, step, due)) = self.schedule.take(until) {
            match due {
                Due::Arm => {
                    self.schedule.arm(step, at);
                    if let Timing::When { within, .. } = self.schedule.steps()[step].timing {
                        let wait = StepWait { since: at, width: self.width, within };
                        self.waits[step] = Some(wait);
                        if self.may_have_come(step, wait) {
                            self.leave_open(step, at)?;
                        }
                    }
                }
                Due::Begin if !self.schedule.begins(step, at) => {}
                Due::Begin => {
                    self.width = self.width.max(self.widths[step]);
                    self.mark(Some(self.schedule.steps()[step].mark), at)?;
                    // What a channel is driven to is not known; no instant depends on it.
                    self.schedule.begin(step, at, &[]);
                }
                Due::Emit(n) => {
                    self.schedule.emitted(step, n, None, &mut self.emitted);
                    self.emitted.clear();
                }
                Due::Done if !self.schedule.is_done(step) => {}
                Due::Done => {
                    self.mark(Some(self.schedule.steps()[step].done), at)?;
                    self.schedule.finish(step, at);
                }
                Due::Missed if more && at == until => waits.push((at, step)),
                Due::Missed => {
                    let missed = self.schedule.miss(step, at);
                    if missed && self.may_come_by(step, at) {
                        self.leave_open(step, at)?;
                    } else if missed && self.schedule.steps()[step].phase == CasePart::Setup {
                        self.schedule.end_early(EndReason::Missed(step), at);
                    }
                }
                Due::Stop => self.schedule.stop(step, at),
                Due::Main => {
                    self.mark(self.main_mark, at)?;
                    self.schedule.begin_main(at);
                }
                // What the rig would do, somebody else did; a train that it would stop ends there.
                Due::Act(act) => {
                    let taken = match self.schedule.steps()[step].acts.get(act as usize) {
                        Some((_, Act::Drive(channel, _) | Act::Restore(channel))) => Some(*channel),
                        _ => None,
                    };
                    if let Some(channel) = taken {
                        self.schedule.take_over(channel, None);
                    }
                }
            }
        }
        for (at, step) in waits {
            self.schedule.wait_on(at, step);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
