//! What is seen goes into the trace, and from the trace to the judge.

use plans::judge::CaseJudge;
use signal::{Cause, Event, SignalId, Span, Time, Trace, TraceError, Value, When};

/// The trace of a case as it grows, with the judge that follows it.
#[derive(Debug)]
pub struct Recorder {
    trace: Trace,
    judge: CaseJudge,
    /// How late the rig was at worst so far.
    late: Span,
    /// The widest interval of a mark so far.
    widest_mark: Span,
    fault: Option<TraceError>,
}

impl Recorder {
    /// Records into `trace`, whose signals are all defined.
    pub fn new(trace: Trace, judge: CaseJudge) -> Recorder {
        Recorder { trace, judge, late: Span::ZERO, widest_mark: Span::ZERO, fault: None }
    }

    /// The rig was this late.
    pub fn note_late(&mut self, late: Span) {
        self.late = self.late.max(late);
    }

    /// The worst lateness so far.
    pub fn late(&self) -> Span {
        self.late
    }

    /// Records a change; TRUE when the trace kept it.
    #[inline]
    pub fn record(&mut self, signal: SignalId, at: When, value: Value, cause: Cause) -> bool {
        match self.keep(Event { signal, at, value, cause }) {
            Ok(kept) => kept,
            Err(fault) => {
                self.fault.get_or_insert(fault);
                false
            }
        }
    }

    #[inline]
    fn keep(&mut self, event: Event) -> Result<bool, TraceError> {
        while let Some(settled) = self.trace.settle(event.at.earliest)? {
            self.judge.feed(&settled);
        }
        let kept = self.trace.push(event)?;
        if let Some(kept) = &kept {
            self.judge.feed(kept);
        }
        Ok(kept.is_some())
    }

    /// Records a happening: its value counts how often it happened.
    pub fn mark(&mut self, signal: SignalId, at: When) {
        let times = match self.trace.last(signal) {
            Some(Event { value: Value::Int(times), .. }) => times + 1,
            _ => 1,
        };
        self.widest_mark = self.widest_mark.max(at.latest - at.earliest);
        self.record(signal, at, Value::Int(times), Cause::Unknown);
    }

    /// How late the rig may have been at worst with what a mark stands for.
    pub fn widest_mark(&self) -> Span {
        self.widest_mark
    }

    /// The trace.
    pub fn trace(&self) -> &Trace {
        &self.trace
    }

    /// Whether some claim is lost already, in a case that has come to `now`.
    pub fn failed_early(&mut self, now: Time) -> bool {
        self.judge.reach(now);
        self.judge.failed_early()
    }

    /// Why the trace could not be written, if so.
    pub fn take_fault(&mut self) -> Option<TraceError> {
        self.fault.take()
    }

    /// Trace and judge for the verdicts.
    pub fn into_parts(self) -> (Trace, CaseJudge) {
        (self.trace, self.judge)
    }
}
