//! Output terminals of a module: what the drivers command and when the edge comes out.

use crate::effect::Effect;
use crate::memory::Memory;
use crate::terminal::Terminal;
use profile::{ChannelSet, EmbeddedOutput, IoChannel, OutputKind};
use signal::{Cause, Level, Span, Time, Value};

/// What a terminal does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shown {
    /// It keeps a level.
    Level(Level),
    /// It pulses, and hardware makes the edges.
    Wave { period: Span, high: Span },
}

/// What a digital output is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct OutputStage {
    /// From a 1 in the driver to the edge at the terminal.
    pub(crate) on_delay: Span,
    /// From a 0 in the driver to the edge at the terminal.
    pub(crate) off_delay: Span,
    /// Both are maxima.
    pub(crate) at_most: bool,
    /// It drives nothing under hardware initialization values (controller:OUT-02); else it is at 0.
    pub(crate) floats: bool,
}

impl From<EmbeddedOutput> for OutputStage {
    fn from(output: EmbeddedOutput) -> OutputStage {
        let EmbeddedOutput { on_delay, off_delay, at_most, kind, .. } = output;
        OutputStage { on_delay, off_delay, at_most, floats: kind == OutputKind::Fast }
    }
}

/// One terminal. Its delays are inertial: a command that is taken back before its edge came out leaves none.
#[derive(Clone, Debug)]
struct OutputTerminal {
    on_delay: Span,
    off_delay: Span,
    /// The delays are maxima, and what a faster stage may have shown is reported.
    at_most: bool,
    shown: Shown,
    /// What is to come and when, while they differ.
    next: Shown,
    at: Time,
    /// When that was commanded.
    since: Time,
    cause: Cause,
    /// A command that was taken back, of which a faster stage may have shown a pulse.
    taken_back: Option<TakenBack>,
    /// The pulses that are commanded, where they are.
    wave: Shown,
}

/// When a command came that was taken back before its edge came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct TakenBack {
    /// The command, of several the first one.
    since: Time,
    /// The command that took it back, of several the last one.
    back: Time,
}

impl OutputTerminal {
    /// Something else is commanded at `now`, whatever was: an edge that has not come out may have come out of a faster
    /// stage.
    fn take_back(&mut self, now: Time) {
        if self.at_most && self.next != self.shown {
            let since = self.taken_back.map_or(self.since, |before| before.since);
            self.taken_back = Some(TakenBack { since, back: now });
        }
    }

    /// What a faster stage may have shown up to `at`, when it is `back` or shows another level.
    fn unsettled(&mut self, terminal: Terminal, at: Time, is_back: bool) -> Option<Effect> {
        let TakenBack { since, back } = self.taken_back.take()?;
        Some(Effect::Unsettled { at, terminal, left: at - since, back: is_back.then(|| at - back) })
    }
}

/// All digital outputs of a module.
#[derive(Clone, Debug)]
pub(crate) struct Outputs {
    /// The number of the module.
    module: usize,
    /// The bit of %Q of the first output.
    first_bit: usize,
    terminals: Vec<OutputTerminal>,
    /// Outputs that are not driven under hardware initialization values (controller:OUT-02).
    floating: ChannelSet,
    /// What the drivers are commanded: 1, and not driven at all.
    on: ChannelSet,
    undriven: ChannelSet,
    /// What of it pulses.
    pulsing: ChannelSet,
    /// Outputs whose stages are switched off whatever they are commanded, by protection or for want of a supply.
    cut: ChannelSet,
    /// Terminals with an edge to come, and the first of these edges.
    pending: ChannelSet,
    first: Time,
}

impl Outputs {
    /// Outputs in hardware initialization values, whose bits of %Q begin at `first_bit`. With `worst_case` they report by how much
    /// edges may have come earlier.
    pub(crate) fn new(
        module: usize,
        first_bit: usize,
        stages: impl Iterator<Item = OutputStage>,
        worst_case: bool,
    ) -> Outputs {
        let mut floating = ChannelSet::EMPTY;
        let terminals = stages
            .enumerate()
            .map(|(output, stage)| {
                floating.set(output, stage.floats);
                let shown = Shown::Level(if stage.floats { Level::HighZ } else { Level::Low });
                OutputTerminal {
                    on_delay: stage.on_delay,
                    off_delay: stage.off_delay,
                    at_most: worst_case && stage.at_most,
                    shown,
                    next: shown,
                    at: Time::MAX,
                    since: Time::MAX,
                    taken_back: None,
                    cause: Cause::Controller,
                    wave: shown,
                }
            })
            .collect();
        Outputs {
            module,
            first_bit,
            terminals,
            floating,
            on: ChannelSet::EMPTY,
            undriven: floating,
            pulsing: ChannelSet::EMPTY,
            cut: ChannelSet::EMPTY,
            pending: ChannelSet::EMPTY,
            first: Time::MAX,
        }
    }

    /// Edges take as long as those of such a stage from now on, those under way as long as before.
    pub(crate) fn set_delays(&mut self, stage: OutputStage) {
        for terminal in &mut self.terminals {
            (terminal.on_delay, terminal.off_delay) = (stage.on_delay, stage.off_delay);
        }
    }

    /// Every output.
    pub(crate) fn all(&self) -> ChannelSet {
        ChannelSet::first(self.terminals.len())
    }

    /// The level at a terminal; none beyond the reference's outputs, and while hardware makes its pulses.
    pub(crate) fn level(&self, output: usize) -> Option<Level> {
        match self.terminals.get(output)?.shown {
            Shown::Level(level) => Some(level),
            Shown::Wave { .. } => None,
        }
    }

    /// The outputs whose drivers are commanded to be on.
    #[inline]
    pub(crate) fn commanded(&self) -> ChannelSet {
        self.on
    }

    /// Whether the outputs are in hardware initialization values.
    pub(crate) fn initialized(&self) -> bool {
        !self.undriven.is_empty()
    }

    /// Commands these outputs at `now`, on those of `on`. The cause of an edge is the last writer of its %Q bit.
    #[inline]
    pub(crate) fn drive(&mut self, now: Time, on: ChannelSet, which: ChannelSet, memory: &Memory) {
        let first = self.first_bit;
        self.command_by(now, on, which, |output| memory.writer(first + output));
    }

    /// Commands these outputs at `now`, for an expert function: no bit of %Q has a part in it.
    #[inline]
    pub(crate) fn command(&mut self, now: Time, on: ChannelSet, which: ChannelSet) {
        self.command_by(now, on, which, |_| Cause::Controller);
    }

    /// Has an output pulse at `now`, for an expert function whose pulses hardware makes.
    pub(crate) fn pulse(&mut self, now: Time, output: usize, period: Span, high: Span) {
        let Some(terminal) = self.terminals.get_mut(output) else { return };
        terminal.wave = Shown::Wave { period, high };
        self.on.insert(output);
        self.undriven.remove(output);
        self.pulsing.insert(output);
        self.aim(now, ChannelSet::of(output), |_| Cause::Controller);
    }

    #[inline]
    fn command_by(&mut self, now: Time, on: ChannelSet, which: ChannelSet, cause: impl Fn(usize) -> Cause) {
        let changed = (on ^ self.on | self.undriven | self.pulsing) & self.all() & which;
        if !changed.is_empty() {
            self.on = self.on.updated(changed, on);
            self.undriven -= changed;
            self.pulsing -= changed;
            self.aim(now, changed, cause);
        }
    }

    /// Commands hardware initialization values at `now` (controller:OUT-02).
    pub(crate) fn initialize(&mut self, now: Time) {
        (self.on, self.undriven, self.pulsing) = (ChannelSet::EMPTY, self.floating, ChannelSet::EMPTY);
        self.aim(now, self.all(), |_| Cause::Controller);
    }

    /// Switches the stages of these outputs off at once, without delay, and lets the others follow their commands.
    pub(crate) fn cut(&mut self, now: Time, cut: ChannelSet) {
        let changed = cut ^ std::mem::replace(&mut self.cut, cut);
        if !changed.is_empty() {
            self.aim(now, changed & self.all(), |_| Cause::Controller);
        }
    }

    fn aim(&mut self, now: Time, which: ChannelSet, cause: impl Fn(usize) -> Cause) {
        for output in which {
            let cut = self.cut.contains(output);
            let terminal = &mut self.terminals[output];
            let shown = match cut || self.undriven.contains(output) {
                true if self.floating.contains(output) => Shown::Level(Level::HighZ),
                true => Shown::Level(Level::Low),
                false if self.pulsing.contains(output) => terminal.wave,
                false => Shown::Level(Level::from_bool(self.on.contains(output))),
            };
            let delay = match (cut, shown) {
                (true, _) => Span::ZERO,
                (false, Shown::Level(Level::High) | Shown::Wave { .. }) => terminal.on_delay,
                (false, _) => terminal.off_delay,
            };
            if shown != terminal.next {
                terminal.take_back(now);
            }
            if shown == terminal.shown {
                if terminal.taken_back.is_none() {
                    self.pending.remove(output);
                } else if shown != terminal.next || cut {
                    // What the stage may have shown is over when the edge back would be out.
                    terminal.at = now.saturating_add(delay);
                }
                terminal.next = shown;
            } else if shown != terminal.next || cut {
                // An edge that was on its way before protection hastened it may have come already.
                if shown != terminal.next {
                    terminal.since = now;
                }
                (terminal.next, terminal.at, terminal.cause) =
                    (shown, now.saturating_add(delay), cause(output));
                self.pending.insert(output);
            }
        }
        self.find_first();
    }

    fn terminal(&self, output: usize) -> Terminal {
        Terminal { module: self.module, channel: IoChannel::Output(output) }
    }

    fn find_first(&mut self) {
        self.first = Time::MAX;
        for output in self.pending {
            self.first = self.first.min(self.terminals[output].at);
        }
    }

    /// When the next edge comes out; [`Time::MAX`] for none.
    #[inline]
    pub(crate) fn next(&self) -> Time {
        self.first
    }

    /// Reports at `now`, after which nothing comes any more, what faster stages may have shown of the edges to come.
    pub(crate) fn report_unsettled(&mut self, now: Time, mut report: impl FnMut(Effect)) {
        for output in self.pending {
            let place = self.terminal(output);
            let terminal = &mut self.terminals[output];
            terminal.take_back(now);
            if let Some(unsettled) = terminal.unsettled(place, now, true) {
                report(unsettled);
            }
        }
    }

    /// The edges due at `now` come out.
    pub(crate) fn fire(&mut self, now: Time, mut report: impl FnMut(Effect)) {
        if self.first > now {
            return;
        }
        for output in self.pending {
            let place = self.terminal(output);
            let terminal = &mut self.terminals[output];
            if terminal.at <= now {
                let changed = std::mem::replace(&mut terminal.shown, terminal.next) != terminal.next;
                self.pending.remove(output);
                let (at, cause) = (terminal.at, terminal.cause);
                let unsettled = terminal.unsettled(place, at, !changed);
                // After a pulse that a faster stage may have shown, such a stage may have the new level since then.
                let is_known = unsettled.is_none();
                if let Some(unsettled) = unsettled {
                    report(unsettled);
                }
                if !changed {
                    continue;
                }
                report(match terminal.shown {
                    Shown::Level(level) => {
                        let early =
                            if terminal.at_most && is_known { at - terminal.since } else { Span::ZERO };
                        Effect::Terminal { at, terminal: place, value: Value::from(level), cause, early }
                    }
                    Shown::Wave { period, high } => Effect::Wave { at, output, period, high, cause },
                });
            }
        }
        self.find_first();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::Effects;
    use profile::{Profile, Reference};

    fn of(name: &str, worst_case: bool) -> Outputs {
        let stages = profile::outputs(Reference::find(name).unwrap()).map(OutputStage::from);
        Outputs::new(0, 0, stages, worst_case)
    }

    fn outputs(name: &str) -> Outputs {
        of(name, false)
    }

    fn worst_case(name: &str) -> Outputs {
        of(name, true)
    }

    fn us(n: i64) -> Time {
        Time::from_nanos(n * 1_000)
    }

    // io:STD-OUT-01
    #[test]
    fn delays_by_kind_and_direction() {
        let (mut out, mut fx, memory) =
            (outputs("TM241CEC24T"), Effects::new(), Memory::new(Profile::default()));
        out.drive(us(0), ChannelSet::from_iter([0, 4]), ChannelSet::ALL, &memory);
        assert_eq!(out.next(), us(2));
        out.fire(us(2), |effect| fx.push(effect));
        assert_eq!(
            (out.level(0), out.level(1), out.level(4)),
            (Some(Level::High), Some(Level::Low), Some(Level::Low))
        );
        assert_eq!(out.next(), us(34));
        out.fire(us(34), |effect| fx.push(effect));
        assert_eq!(out.level(4), Some(Level::High));
        out.drive(us(100), ChannelSet::EMPTY, ChannelSet::ALL, &memory);
        out.fire(us(102), |effect| fx.push(effect));
        assert_eq!(out.next(), us(350));
        let mut relay = outputs("TM241CEC24R");
        relay.drive(us(0), ChannelSet::of(4), ChannelSet::ALL, &memory);
        relay.fire(us(2), |effect| fx.push(effect));
        assert_eq!(relay.next(), us(10_000));
    }

    // controller:OUT-02
    #[test]
    fn hardware_initialization_values() {
        let (mut out, mut fx, memory) =
            (outputs("TM241CEC24T"), Effects::new(), Memory::new(Profile::default()));
        assert_eq!((out.level(3), out.level(4)), (Some(Level::HighZ), Some(Level::Low)));
        out.drive(us(0), ChannelSet::first(10), ChannelSet::ALL, &memory);
        out.fire(us(1_000), |effect| fx.push(effect));
        out.initialize(us(2_000));
        out.initialize(us(2_100));
        assert_eq!(out.next(), us(2_002), "the same command again starts no delay again");
        out.fire(us(2_250), |effect| fx.push(effect));
        assert_eq!(
            (out.level(3), out.level(4), out.next()),
            (Some(Level::HighZ), Some(Level::Low), Time::MAX)
        );
    }

    // io:OUT-06, io:OUT-09
    #[test]
    fn a_stage_that_is_cut_is_off_at_once() {
        let (mut out, mut fx, memory) =
            (outputs("TM241CEC24T"), Effects::new(), Memory::new(Profile::default()));
        out.drive(us(0), ChannelSet::from_iter([0, 4, 5]), ChannelSet::ALL, &memory);
        out.fire(us(34), |effect| fx.push(effect));
        out.drive(us(100), ChannelSet::from_iter([0, 5]), ChannelSet::ALL, &memory);
        out.cut(us(110), ChannelSet::first(8));
        assert_eq!(out.next(), us(110), "sooner than the off delay under way");
        out.fire(us(110), |effect| fx.push(effect));
        assert_eq!(
            [0, 1, 4, 5, 8].map(|n| out.level(n).unwrap()),
            [Level::HighZ, Level::HighZ, Level::Low, Level::Low, Level::Low]
        );
        out.drive(us(200), ChannelSet::from_iter([0, 4, 5]), ChannelSet::ALL, &memory);
        assert_eq!(out.next(), Time::MAX, "a command changes nothing");
        out.cut(us(300), ChannelSet::EMPTY);
        out.fire(us(302), |effect| fx.push(effect));
        out.fire(us(334), |effect| fx.push(effect));
        assert_eq!(
            [0, 1, 4, 5].map(|n| out.level(n).unwrap()),
            [Level::High, Level::Low, Level::High, Level::High]
        );
    }

    #[test]
    fn a_command_taken_back_in_time_leaves_no_edge() {
        let (mut out, mut fx, memory) =
            (outputs("TM241CEC24T"), Effects::new(), Memory::new(Profile::default()));
        out.drive(us(0), ChannelSet::EMPTY, ChannelSet::ALL, &memory);
        out.fire(us(2), |effect| fx.push(effect));
        fx.list.clear();
        out.drive(us(10), ChannelSet::of(4), ChannelSet::ALL, &memory);
        out.drive(us(40), ChannelSet::EMPTY, ChannelSet::ALL, &memory);
        assert_eq!(out.next(), Time::MAX);
        out.drive(us(50), ChannelSet::of(4), ChannelSet::ALL, &memory);
        assert_eq!(out.next(), us(84), "the delay starts again");
        assert!(fx.list.is_empty());
    }

    fn fired(out: &mut Outputs, at: i64) -> Vec<Effect> {
        let mut list = Vec::new();
        out.fire(us(at), |effect| list.push(effect));
        list
    }

    fn edge(output: usize, at: i64, level: Level, early: i64) -> Effect {
        let (terminal, value, cause) = (Terminal::output(output), Value::from(level), Cause::Unknown);
        Effect::Terminal { at: us(at), terminal, value, cause, early: Span::from_micros(early) }
    }

    fn unsettled(output: usize, at: i64, left: i64, back: i64) -> Effect {
        let (left, back) = (Span::from_micros(left), Some(Span::from_micros(back)));
        Effect::Unsettled { at: us(at), terminal: Terminal::output(output), left, back }
    }

    // io:STD-OUT-01
    #[test]
    fn an_edge_whose_delay_is_a_maximum_may_come_from_its_command_on() {
        let (mut out, memory) = (worst_case("TM241CEC24T"), Memory::new(Profile::default()));
        out.drive(us(0), ChannelSet::of(4), ChannelSet::of(4), &memory);
        assert_eq!(fired(&mut out, 34), [edge(4, 34, Level::High, 34)]);
        out.drive(us(100), ChannelSet::EMPTY, ChannelSet::of(4), &memory);
        assert_eq!(fired(&mut out, 350), [edge(4, 350, Level::Low, 250)]);
        let mut relay = worst_case("TM241CEC24R");
        relay.drive(us(0), ChannelSet::of(4), ChannelSet::of(4), &memory);
        assert_eq!(fired(&mut relay, 10_000), [edge(4, 10_000, Level::High, 0)], "an assumption is exact");
        let mut exact = outputs("TM241CEC24T");
        exact.drive(us(0), ChannelSet::of(4), ChannelSet::of(4), &memory);
        assert_eq!(fired(&mut exact, 34), [edge(4, 34, Level::High, 0)]);
    }

    // io:OUT-06
    #[test]
    fn protection_acts_at_once_in_the_worst_case_too() {
        let (mut out, memory) = (worst_case("TM241CEC24T"), Memory::new(Profile::default()));
        out.drive(us(0), ChannelSet::of(4), ChannelSet::of(4), &memory);
        fired(&mut out, 34);
        out.cut(us(100), ChannelSet::of(4));
        let Effect::Terminal { at, early, .. } = fired(&mut out, 100)[0] else { panic!("no edge") };
        assert_eq!((at, early), (us(100), Span::ZERO));
        out.cut(us(200), ChannelSet::EMPTY);
        out.cut(us(210), ChannelSet::of(4));
        assert_eq!(fired(&mut out, 210), [unsettled(4, 210, 10, 0)], "off again before it was on");
        assert_eq!(out.next(), Time::MAX);
    }

    #[test]
    fn a_command_taken_back_may_have_left_a_pulse() {
        let (mut out, memory) = (worst_case("TM241CEC24T"), Memory::new(Profile::default()));
        let set = |out: &mut Outputs, at: i64, on: bool| {
            let on = if on { ChannelSet::of(4) } else { ChannelSet::EMPTY };
            out.drive(us(at), on, ChannelSet::of(4), &memory);
        };
        set(&mut out, 0, true);
        set(&mut out, 10, false);
        assert_eq!(
            (out.next(), out.level(4)),
            (us(260), Some(Level::Low)),
            "over when it is off for certain"
        );
        assert_eq!(fired(&mut out, 260), [unsettled(4, 260, 260, 250)]);
        assert_eq!(out.next(), Time::MAX);
        // Taken back twice, then not any more: one stretch, and the edge after it.
        set(&mut out, 1_000, true);
        set(&mut out, 1_010, false);
        set(&mut out, 1_020, true);
        set(&mut out, 1_030, false);
        set(&mut out, 1_050, true);
        assert_eq!(fired(&mut out, 1_083), []);
        // A stage that is on at once and off late has been on all the while: nothing is known until it is on for certain.
        let (left, terminal) = (Span::from_micros(84), Terminal::output(4));
        let not_back = Effect::Unsettled { at: us(1_084), terminal, left, back: None };
        assert_eq!(fired(&mut out, 1_084), [not_back, edge(4, 1_084, Level::High, 0)]);
        // What is to come when the case ends may be there already.
        set(&mut out, 2_000, false);
        let mut list = Vec::new();
        out.report_unsettled(us(2_100), |effect| list.push(effect));
        assert_eq!(list, [unsettled(4, 2_100, 100, 0)]);
        assert_eq!(fired(&mut out, 2_250), [edge(4, 2_250, Level::Low, 250)]);
    }
}
