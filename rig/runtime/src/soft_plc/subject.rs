//! The model with the lines that it has beside its terminals.

use super::SoftPlcEvent;
use crate::subject::capability::Capability;
use crate::subject::hook::HookError;
use crate::subject::{
    Disturbances, ExpertFunctionAccess, FileAccess, Observation, PortAccess, Startup, Subject, SubjectExt,
};
use controller::{
    Command, CommandError, Effect, Effects, FrontPanel, JitterCounts, LogEntry, PortEvent, PortMessage,
    Probe, ProbeId, State, TaskFigures, Terminal, WriteError,
};
use drivers::SubjectLines;
use profile::IoChannel;
use signal::{Address, Cause, Span, Time, Value, When};
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::SyncSender;

/// The longest that a boot takes, in modelled time.
const LONGEST_BOOT: Span = Span::from_secs(60);
/// Where its lines stand, after its terminals.
#[derive(Clone, Copy, Debug)]
pub(super) struct SoftPlcTerminals {
    pub inputs: usize,
    pub outputs: usize,
}

impl SoftPlcTerminals {
    pub const fn power(self) -> usize {
        self.inputs
    }

    pub const fn run_stop(self) -> usize {
        self.inputs + 1
    }

    pub const fn alarm(self) -> usize {
        self.outputs
    }
}

/// The model with the lines that it has beside its terminals.
pub(super) struct SoftPlc {
    model: Box<dyn Subject>,
    lines: SubjectLines,
    places: SoftPlcTerminals,
    /// The state that it is to come into first.
    initial: Option<State>,
    /// It gets its supply as soon as its time begins: it has no line for it, or the line was on before.
    power_pending: bool,
    begun: bool,
    /// Its next boot takes no time.
    pub quick: bool,
    /// What came of a boot before its time began.
    booted: Vec<Effect>,
    /// By how much its own time is ahead, after a boot that took none.
    ahead: Span,
    supply: bool,
    alarm: bool,
    events: SyncSender<SoftPlcEvent>,
}

impl std::fmt::Debug for SoftPlc {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SoftPlc").field("lines", &self.lines).finish_non_exhaustive()
    }
}

impl SoftPlc {
    pub fn new(
        model: Box<dyn Subject>,
        lines: SubjectLines,
        places: SoftPlcTerminals,
        initial: State,
        events: SyncSender<SoftPlcEvent>,
    ) -> SoftPlc {
        let (initial, power_pending) = (Some(initial), lines.power.is_none());
        SoftPlc {
            model,
            lines,
            places,
            initial,
            power_pending,
            begun: false,
            quick: false,
            booted: Vec::new(),
            ahead: Span::ZERO,
            supply: false,
            alarm: false,
            events,
        }
    }

    fn report(&self, event: SoftPlcEvent) {
        // Whoever watches may be slow, or gone.
        let _ = self.events.try_send(event);
    }

    fn switch(&mut self, now: Time, on: bool, effects: &mut Effects) {
        if self.supply != on {
            self.supply = on;
            let before = effects.list.len();
            self.model.power(self.own(now), on, effects);
            if std::mem::take(&mut self.quick) {
                self.boot(now, before, effects);
            }
            self.follow(now, before, effects);
        }
    }

    /// An instant in the model's own time.
    fn own(&self, at: Time) -> Time {
        at.saturating_add(self.ahead)
    }

    /// Lets the model boot at once: its time runs ahead by what that takes.
    fn boot(&mut self, now: Time, before: usize, effects: &mut Effects) {
        let limit = now.saturating_add(LONGEST_BOOT);
        while self.model.state() == State::Booting {
            let Some(next) = self.model.next_timer().filter(|next| *next <= limit) else { break };
            self.model.run(next, effects);
            self.model.fire(next, effects);
            self.ahead = self.ahead.max(next - now);
        }
        // All of it happens now.
        for effect in effects.list.iter_mut().skip(before) {
            *instant(effect) = self.own(now);
        }
    }

    /// Reports what the effects after the first `before` say, and lets the alarm line follow.
    fn follow(&mut self, now: Time, before: usize, effects: &mut Effects) {
        let mut place = before;
        while let Some(effect) = effects.list.get_mut(place) {
            place += 1;
            let at = instant(effect);
            *at = at.saturating_add(-self.ahead);
            let effect = *effect;
            match effect {
                Effect::State { at, state } => {
                    self.report(SoftPlcEvent::State(at, state));
                    let alarm = state == State::Running;
                    if self.alarm != alarm {
                        self.alarm = alarm;
                        let (terminal, value) = (Terminal::output(self.places.alarm()), Value::Bool(alarm));
                        let (at, cause) = (self.own(at), Cause::Controller);
                        effects.list.push(Effect::Terminal { at, terminal, value, cause, early: Span::ZERO });
                    }
                    self.settle(now.max(at), state, effects);
                }
                // Changes of the state are reported already.
                Effect::Log { entry: LogEntry::State { .. }, .. } => {}
                Effect::Log { at, entry } => self
                    .report(SoftPlcEvent::Log(at, crate::subject::log::show(&entry, self.model.catalogue()))),
                _ => {}
            }
        }
    }

    /// Where its first boot ends in another state than the case begins in, it is commanded there.
    fn settle(&mut self, now: Time, state: State, effects: &mut Effects) {
        if !matches!(state, State::Stopped | State::Running | State::Empty) {
            return;
        }
        let command = match self.initial.take() {
            Some(State::Running) if state == State::Stopped => Command::Run,
            Some(State::Stopped) if state == State::Running => Command::Stop,
            _ => return,
        };
        if let Err(refusal) = self.model.command(self.own(now), &command, effects) {
            self.report(SoftPlcEvent::Log(now, refusal.to_string()));
        }
    }
}

/// The instant of an effect.
fn instant(effect: &mut Effect) -> &mut Time {
    match effect {
        Effect::Terminal { at, .. }
        | Effect::Unsettled { at, .. }
        | Effect::Wave { at, .. }
        | Effect::PeriodRestarted { at, .. }
        | Effect::PortOutput { at, .. }
        | Effect::PortSilent { at, .. }
        | Effect::State { at, .. }
        | Effect::Changed { at, .. }
        | Effect::Log { at, .. } => at,
    }
}

impl Subject for SoftPlc {
    fn inner(&self) -> Option<&dyn Subject> {
        Some(&*self.model)
    }

    fn inner_mut(&mut self) -> Option<&mut dyn Subject> {
        Some(&mut *self.model)
    }

    fn capabilities(&self) -> &'static [Capability] {
        self.model.capabilities()
    }

    fn is_model(&self) -> bool {
        true
    }

    fn state(&self) -> State {
        // Whatever comes of its supply comes when its time has begun.
        if self.begun { self.model.state() } else { State::Off }
    }

    fn power(&mut self, now: Time, on: bool, effects: &mut Effects) {
        self.switch(now, on, effects);
    }

    fn run(&mut self, limit: Time, effects: &mut Effects) -> Time {
        let before = effects.list.len();
        let reached = self.model.run(self.own(limit), effects).saturating_add(-self.ahead);
        self.follow(reached, before, effects);
        reached
    }

    fn is_computing(&self) -> bool {
        self.model.is_computing()
    }

    fn next_timer(&self) -> Option<Time> {
        if self.power_pending {
            return Some(Time::ZERO);
        }
        Some(self.model.next_timer()?.saturating_add(-self.ahead))
    }

    fn fire(&mut self, now: Time, effects: &mut Effects) {
        if std::mem::take(&mut self.power_pending) {
            self.switch(now, true, effects);
            return;
        }
        let before = effects.list.len();
        self.model.fire(self.own(now), effects);
        self.follow(now, before, effects);
    }

    fn terminal(&self, address: Address) -> Option<Terminal> {
        self.model.terminal(address)
    }

    fn set_input(&mut self, now: Time, at: When, terminal: Terminal, value: Value, effects: &mut Effects) {
        let high = value.as_bool().unwrap_or(false);
        let before = effects.list.len();
        if terminal == Terminal::input(self.places.power()) {
            match self.begun {
                true => self.switch(now, high, effects),
                false => self.power_pending = high,
            }
        } else if terminal == Terminal::input(self.places.run_stop()) {
            let moved = self.model.command(self.own(now), &Command::Switch(high), effects);
            if let Err(refusal) = moved {
                self.report(SoftPlcEvent::Log(now, refusal.to_string()));
            }
            self.follow(now, before, effects);
        } else {
            self.model.set_input(self.own(now), at, terminal, value, effects);
        }
    }

    fn output(&self, terminal: Terminal) -> Value {
        match terminal == Terminal::output(self.places.alarm()) {
            true => Value::Bool(self.alarm),
            false => self.model.output(terminal),
        }
    }

    fn command(&mut self, now: Time, command: &Command, effects: &mut Effects) -> Result<(), CommandError> {
        let before = effects.list.len();
        let obeyed = self.model.command(self.own(now), command, effects);
        self.follow(now, before, effects);
        obeyed
    }

    fn notice(&mut self, at: Time, text: &str) {
        self.report(SoftPlcEvent::Log(at, text.to_owned()));
    }

    fn startup(&mut self) -> Option<&mut dyn Startup> {
        Some(self)
    }

    // Instants that are given and taken are not those of the model.

    fn observation(&self) -> Option<&dyn Observation> {
        Some(self)
    }

    fn observation_mut(&mut self) -> Option<&mut dyn Observation> {
        Some(self)
    }

    fn expert_functions(&mut self) -> Option<&mut dyn ExpertFunctionAccess> {
        Some(self)
    }

    fn ports(&mut self) -> Option<&mut dyn PortAccess> {
        Some(self)
    }

    // These are for the steps of a plan, and it has none.

    fn files(&mut self) -> Option<&mut dyn FileAccess> {
        None
    }

    fn disturbances(&mut self) -> Option<&mut dyn Disturbances> {
        None
    }
}

impl Startup for SoftPlc {
    fn load(&mut self, _interrupt: &AtomicBool) -> Result<(), HookError> {
        // Its program is loaded now where it can be: that takes the host's time, and none of its own.
        if self.quick && std::mem::take(&mut self.power_pending) {
            self.quick = false;
            self.supply = true;
            let mut effects = Effects::new();
            self.model.power(Time::ZERO, true, &mut effects);
            self.boot(Time::ZERO, 0, &mut effects);
            self.booted = effects.list;
        }
        self.report(SoftPlcEvent::Ready);
        Ok(())
    }

    fn loaded(&mut self, now: Time, effects: &mut Effects) {
        if self.booted.is_empty() {
            return;
        }
        // Its time goes on where the boot ended.
        self.ahead = self.ahead + -(now - Time::ZERO);
        let before = effects.list.len();
        effects.list.append(&mut self.booted);
        for effect in effects.list.iter_mut().skip(before) {
            *instant(effect) = self.own(now);
        }
        self.follow(now, before, effects);
    }

    fn unload(&mut self, _interrupt: &AtomicBool) -> Result<(), HookError> {
        Ok(())
    }

    fn limit(&self) -> Span {
        LONGEST_BOOT
    }

    fn begin(&mut self) -> Option<(Time, Value)> {
        self.begun = true;
        None
    }

    fn state_probe(&self) -> Option<ProbeId> {
        None
    }
}

impl Observation for SoftPlc {
    fn watch(&mut self, probe: Probe) -> ProbeId {
        self.model.watch(probe)
    }

    fn reserve(&mut self, watches: usize) {
        self.model.reserve(watches);
    }

    fn unwatch(&mut self, probe: ProbeId) {
        self.model.unwatch(probe);
    }

    fn read(&self, probe: &Probe) -> Value {
        match *probe {
            Probe::Terminal(terminal) => self.output(terminal),
            ref probe => self.model.read(probe),
        }
    }

    fn write(
        &mut self,
        now: Time,
        probe: &Probe,
        value: Value,
        cause: Cause,
        effects: &mut Effects,
    ) -> Result<(), WriteError> {
        let before = effects.list.len();
        let written = self.model.write(self.own(now), probe, value, cause, effects);
        self.follow(now, before, effects);
        written
    }

    fn front(&self) -> Option<FrontPanel> {
        let front = self.model.front()?;
        Some(FrontPanel { since: front.since.saturating_add(-self.ahead), ..front })
    }

    fn task_status(&self, task: usize) -> Option<(TaskFigures, JitterCounts)> {
        self.model.task_status(task)
    }
}

impl PortAccess for SoftPlc {
    fn receive(&mut self, now: Time, port: usize, event: &PortEvent, effects: &mut Effects) {
        let (before, own, event) = (effects.list.len(), self.own(now), event.shifted(self.ahead));
        if let Some(ports) = self.model.ports() {
            ports.receive(own, port, &event, effects);
        }
        self.follow(now, before, effects);
    }

    fn take_output(&mut self, port: usize) -> Option<PortMessage> {
        self.model.ports()?.take_output(port)
    }
}

impl ExpertFunctionAccess for SoftPlc {
    fn offload_pulses(&mut self, outputs: &[IoChannel]) {
        self.model.offload_pulses(outputs);
    }

    fn report_missed_edges(&mut self, now: Time, input: usize, edges: u32) {
        if input != self.places.power() && input != self.places.run_stop() {
            self.model.report_missed_edges(self.own(now), input, edges);
        }
    }

    fn count(&mut self, now: Time, input: usize, steps: i64) {
        let now = self.own(now);
        self.model.count(now, input, steps);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::application::store::MemoryStore;
    use crate::subject::model::ModelledController;
    use controller::{Config, Endpoint, PortLife, PortOutbox, RegisterAccess};
    use signal::SerialMessage;
    use std::sync::{Arc, Mutex};

    type Heard = Arc<Mutex<Vec<(Time, PortEvent)>>>;

    /// Notes what comes, and answers it 1 ms after its end.
    #[derive(Debug)]
    struct Answering(Heard);

    impl Endpoint for Answering {
        fn enter(&mut self, _: Time, _: PortLife, _: &mut PortOutbox) {}

        fn receive(&mut self, now: Time, event: &PortEvent, outbox: &mut PortOutbox) {
            self.0.lock().unwrap().push((now, *event));
            if let PortEvent::Serial(message) = event {
                let at = message.last.latest + Span::from_millis(1);
                outbox.push(at, PortMessage::serial(b"answer").unwrap()).unwrap();
            }
        }

        fn next(&self) -> Time {
            Time::MAX
        }

        fn fire(&mut self, _: Time, _: &mut PortOutbox) {}

        fn work(&self) -> Option<Span> {
            None
        }

        fn step(&mut self, _: Time, _: &mut dyn RegisterAccess, _: &mut PortOutbox) {}
    }

    /// The controller's own time is ahead of its lines by the boot that took none; an endpoint lives in it.
    #[test]
    fn a_port_is_in_the_time_of_its_lines() {
        let heard = Heard::default();
        let config = Config::new(profile::Profile::M241_2019);
        let mut model =
            ModelledController::new(config, None, Box::new(MemoryStore::default()), None).unwrap();
        assert!(model.attach_endpoint(0, Box::new(Answering(heard.clone()))));
        let (report, _reports) = std::sync::mpsc::sync_channel(16);
        let places = SoftPlcTerminals { inputs: 14, outputs: 10 };
        let mut plc = SoftPlc::new(Box::new(model), SubjectLines::default(), places, State::Empty, report);
        plc.quick = true;
        let mut effects = Effects::new();
        plc.switch(Time::ZERO, true, &mut effects);
        assert!(plc.ahead > Span::ZERO);
        effects.list.clear();

        let last = Time::ZERO + Span::from_millis(5);
        let now = last + Span::from_micros(10);
        plc.run(now, &mut effects);
        let message = SerialMessage::of(When::exactly(Time::ZERO), When::within(last, now), b"x");
        plc.receive(now, 0, &PortEvent::Serial(message), &mut effects);
        let event = PortEvent::Serial(message).shifted(plc.ahead);
        assert_eq!(*heard.lock().unwrap(), [(plc.own(now), event)]);
        let due = now + Span::from_millis(1);
        while plc.next_timer().is_some_and(|next| next <= due) {
            let next = plc.next_timer().unwrap();
            plc.run(next, &mut effects);
            plc.fire(next, &mut effects);
        }
        let output = |effect: &&Effect| matches!(effect, Effect::PortOutput { .. });
        let sent: Vec<_> = effects.list.iter().filter(output).collect();
        assert_eq!(sent, [&Effect::PortOutput { at: due, port: 0 }]);
        assert!(plc.take_output(0).is_some());
    }
}
