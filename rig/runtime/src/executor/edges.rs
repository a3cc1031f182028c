//! Pulses on real lines: every edge that a step or the subject makes reaches the board by itself, what the rig is late
//! with keeps apart, and a step is done when its last edge was seen.

use super::Executor;
use crate::executor::rig_fault::RigFault;
use crate::generator::StimulusGenerator;
use crate::subject::SubjectExt;
use drivers::ChannelId;
use signal::{Span, Time, Value};

/// The edges that steps asked for and nobody has seen yet.
#[derive(Debug, Default)]
pub(super) struct PendingEdges {
    /// How many of each channel.
    asked: Vec<u32>,
    /// Whether one of its edges was seen since it had none to come.
    followed: Vec<bool>,
    /// Whether changes of each were lost.
    missed: Vec<bool>,
    /// Steps that are done but for their last edges, and until when these are waited for.
    ending: Vec<(usize, Time)>,
    /// How late the pulses of a step ended at worst.
    late: Span,
    /// The end of the case has come, and waits for edges that were to come before it.
    put_off: bool,
}

impl PendingEdges {
    /// For so many channels and steps.
    pub(super) fn new(channels: usize, steps: usize) -> PendingEdges {
        PendingEdges {
            asked: vec![0; channels],
            followed: vec![false; channels],
            missed: vec![false; channels],
            ending: Vec::with_capacity(steps),
            late: Span::ZERO,
            put_off: false,
        }
    }

    /// Until when the next step waits.
    #[inline]
    pub(super) fn next(&self) -> Option<Time> {
        self.ending.iter().map(|(_, until)| *until).min()
    }

    /// A change of a channel was seen.
    #[inline]
    pub(super) fn seen(&mut self, channel: ChannelId) {
        let place = usize::from(channel.0);
        if let Some(asked) = self.asked.get_mut(place).filter(|asked| **asked > 0) {
            *asked -= 1;
            self.followed[place] = true;
        }
    }

    fn ask(&mut self, channel: ChannelId) {
        let place = usize::from(channel.0);
        self.followed[place] &= self.asked[place] > 0;
        self.asked[place] += 1;
    }

    /// Whether an edge of the channel is still to come.
    fn awaits(&self, channel: ChannelId) -> bool {
        self.asked.get(usize::from(channel.0)).is_some_and(|asked| *asked > 0)
    }

    /// Nothing of it is waited for any more. Whether it had followed before.
    fn forget(&mut self, channel: ChannelId) -> bool {
        let place = usize::from(channel.0);
        let awaited = std::mem::take(&mut self.asked[place]) > 0;
        std::mem::take(&mut self.followed[place]) && awaited
    }
}

impl Executor<'_> {
    /// An edge of a step's generator comes later than the rig may be: what counts on its instant is not what was
    /// planned.
    pub(super) fn note_late_edge(&mut self, step: usize) {
        let of_edges = |generator: &StimulusGenerator| generator.is_of_edges();
        let generator = self.parts.schedule.steps()[step].generator.as_ref();
        let Some(at) = self.parts.schedule.planned(step).filter(|_| generator.is_some_and(of_edges)) else {
            return;
        };
        let late = self.actual - at;
        if late > self.limits.late {
            self.report.fault.get_or_insert(RigFault::Late { at, late, limit: self.limits.late });
        }
    }

    /// These writes of a generator are about to be made: the edges among them are to be seen.
    pub(super) fn expect_edges(&mut self) {
        if !self.pacing.has_wires() {
            return;
        }
        for (channel, value) in &self.buffers.writes {
            let place = usize::from(channel.0);
            let sensed = self.parts.board.channels().get(place).is_some_and(|channel| channel.senses);
            if sensed && matches!(value, Value::Bool(_)) && self.driven.values.get(place) != Some(value) {
                self.awaited.edges.ask(*channel);
            }
        }
    }

    /// Whether the end of a step waits for edges that it asked for.
    pub(super) fn awaits_edges(&mut self, step: usize) -> bool {
        if !self.pacing.has_wires() || self.report.fault.is_some() {
            return false;
        }
        let planned = &self.parts.schedule.steps()[step];
        let Some(generator) = &planned.generator else { return false };
        if let Some(begun) = self.parts.schedule.begun(step).filter(|_| planned.repeat.is_none()) {
            // What follows from late pulses has as much time as it was to have.
            self.awaited.edges.late =
                self.awaited.edges.late.max(self.now - begun.saturating_add(planned.lasts));
        }
        if !generator.channels().any(|channel| self.awaited.edges.awaits(channel)) {
            return false;
        }
        let until = self.actual.saturating_add(self.limits.late);
        self.awaited.edges.ending.push((step, until));
        true
    }

    /// The end of the case; not before pulses that the rig is late with have come that were to come before it.
    pub(super) fn end(&self) -> Time {
        match self.parts.schedule.end() {
            Some(end) if self.awaited.edges.put_off && self.is_behind(end) => Time::MAX,
            Some(end) => end.saturating_add(self.awaited.edges.late),
            None => Time::MAX,
        }
    }

    /// Whether the case, whose end has come, goes on for what the rig is late with.
    pub(super) fn puts_off_end(&mut self) -> bool {
        let early = self.over || self.parts.schedule.ended().is_some() || self.report.fault.is_some();
        self.awaited.edges.put_off =
            !early && self.parts.schedule.end().is_some_and(|end| self.is_behind(end));
        self.awaited.edges.put_off
    }

    fn is_behind(&self, end: Time) -> bool {
        self.holds_end()
            || self.pacing.has_wires()
                && (!self.awaited.edges.ending.is_empty() || self.parts.schedule.is_behind(end))
    }

    /// Ends the steps whose last edges were seen, or are not waited for any longer.
    pub(super) fn end_pulses(&mut self) {
        for place in (0..self.awaited.edges.ending.len()).rev() {
            let (step, until) = self.awaited.edges.ending[place];
            let Some(generator) = &self.parts.schedule.steps()[step].generator else { continue };
            let awaited = generator.channels().any(|channel| self.awaited.edges.awaits(channel));
            let over = self.actual >= until || self.report.fault.is_some();
            if awaited && !over {
                continue;
            }
            let mut late = false;
            for channel in generator.channels() {
                late |= self.awaited.edges.forget(channel);
            }
            // A line that never followed is cut, or held: what that means is for the claims to say.
            if late && self.report.fault.is_none() {
                let limit = self.limits.late;
                self.report.fault =
                    Some(RigFault::Late { at: until.saturating_add(-limit), late: limit, limit });
            }
            self.awaited.edges.ending.remove(place);
            self.parts.schedule.done_at(step, self.now);
        }
    }

    /// Changes of a line were lost. The model's counters that look at it are off by up to so many, and say so
    /// (io:STD-HSC-16); who plays a controller goes on with them.
    pub(super) fn report_missed_edges(&mut self, at: Time, channel: ChannelId, count: u32) {
        let fault = RigFault::Dropped { at, channel, count };
        let place = usize::from(channel.0);
        if !std::mem::replace(&mut self.awaited.edges.missed[place], true) {
            self.notice(at, fault.show(self.parts.board.channels()).to_string());
        }
        self.report.fault.get_or_insert(fault);
        for index in 0..self.parts.wiring.inputs[place].len() {
            let terminal = self.parts.wiring.inputs[place][index].terminal;
            if let Some(input) = terminal.embedded_input() {
                self.parts.subject.report_missed_edges(self.now, input, count);
            }
        }
    }

    /// The subject turns an output that it has turned already since the board was commanded: both are edges.
    pub(super) fn keep_edge(&mut self, channel: ChannelId, value: Value) -> Result<(), RigFault> {
        let turns = |(known, before): &(ChannelId, Value)| *known == channel && *before != value;
        if !self.pacing.has_wires() || !self.buffers.writes.iter().any(turns) {
            return Ok(());
        }
        let at = self.board_time();
        self.expect_writes();
        let written = self.parts.board.write(at, &self.buffers.writes);
        self.buffers.writes.clear();
        written.map_err(|error| RigFault::Board { at, error })
    }
}
