//! The simulated board: settles its lines at every instant at which something changes.

use signal::{CanFrame, Random, SerialOutput, SerialSettings, Span, Time, Value, When};

use super::buses::SimulatedBuses;
use super::checks;
use super::dirty::DirtyLines;
use super::line::{Line, MAX_FAULTS};
use super::links::{Links, PlantAt, PlantEnd};
use super::tally::Tallies;
use super::timetable::Timetable;
use super::wire::Wire;
use crate::board::{self, Board, BoardError, FaultInjection, PlantParameters};
use crate::bus::{Bus, BusEvent, BusId};
use crate::channel::{Channel, ChannelId, Fault};
use crate::circuit::{Circuit, CircuitError, CircuitFault, PlantFault, PlantInput, PlantSpec, fit};
use crate::course::Course;
use crate::event::{BoardEvent, Health, LossReason, Origin};

/// The first lane of the seed that a plant draws from.
const PLANT_LANES: u64 = 1 << 32;

/// The most changes of one call, the most unreported events, and the most changes on their way through delays.
pub const MAX_PENDING: u32 = 1 << 20;

/// A board of modelled lines in virtual time: exact, without a shortest pulse but for the nanosecond, the same
/// from run to run for the same seed and calls, however the time between two calls is cut.
///
/// All that changes at one instant changes together, then the wires without delay carry it on, each line
/// changing at most once: there are no glitches but those that somebody asked for.
#[derive(Debug)]
pub struct SimulatedBoard {
    channels: Vec<Channel>,
    lines: Vec<Line>,
    /// Whether the line's device is reported as lost, by line.
    lost: Vec<bool>,
    /// Whether the line's value is to be reported even if it is the same, by line.
    announce: Vec<bool>,
    wires: Vec<Wire>,
    plants: Vec<PlantAt>,
    tallies: Tallies,
    links: Vec<Links>,
    /// Lines to look at, lowest rank first.
    dirty: DirtyLines,
    reports: Vec<BoardEvent>,
    /// When lines, wires and plants next do something: first the lines, then the wires, then the plants.
    timetable: Timetable,
    now: Time,
    started: bool,
    health: Health,
    seed: u64,
    buses: SimulatedBuses,
    /// The first plant that came to its end, and whether that was reported.
    plant_fault: Option<PlantFault>,
    is_fault_reported: bool,
}

impl SimulatedBoard {
    /// Builds the board of a circuit; `seed` is where its bounces draw from.
    ///
    /// # Errors
    /// The first of [`Circuit::check`].
    pub fn new(circuit: &Circuit, seed: u64) -> Result<Self, CircuitError> {
        if let Some(error) = circuit.check().first() {
            return Err(*error);
        }
        let loops = |part| CircuitError { part, fault: CircuitFault::Loop };
        let ranks = circuit.order().map_err(loops)?;
        let mut board = SimulatedBoard {
            channels: circuit.channels.iter().map(checks::channel).collect(),
            lines: circuit
                .channels
                .iter()
                .map(|c| Line::new(c.kind == crate::ChannelKind::Digital, c.pull))
                .collect(),
            lost: vec![false; circuit.channels.len()],
            announce: vec![false; circuit.channels.len()],
            wires: Vec::new(),
            plants: Vec::new(),
            tallies: Tallies::new(&circuit.tallies),
            links: circuit.channels.iter().map(|_| Links::default()).collect(),
            dirty: DirtyLines::new(&ranks),
            reports: Vec::new(),
            timetable: Timetable::new(circuit.channels.len() + circuit.wires.len() + circuit.plants.len()),
            now: Time::MIN,
            started: false,
            health: Health::default(),
            seed,
            buses: SimulatedBuses::new(&circuit.buses),
            plant_fault: None,
            is_fault_reported: false,
        };
        for spec in &circuit.wires {
            board.add_wire(Wire::new(*spec, seed, board.wires.len() as u64));
        }
        for spec in &circuit.plants {
            board.add_plant(spec.as_ref());
        }
        board.find_rings();
        for (place, tally) in circuit.tallies.iter().enumerate() {
            board.links[usize::from(tally.channel.0)].tally = Some(place);
            for signal in tally.signals() {
                board.links[usize::from(signal.0)].tallies_out.push(tally.channel);
            }
        }
        Ok(board)
    }

    fn add_wire(&mut self, wire: Wire) {
        let place = self.wires.len();
        self.links[usize::from(wire.spec.from.0)].wires_out.push(place);
        self.links[usize::from(wire.spec.to.0)].wires_in.push(place);
        self.wires.push(wire);
    }

    fn add_plant(&mut self, spec: &dyn PlantSpec) {
        let place = self.plants.len();
        for (port, input) in spec.inputs().iter().enumerate() {
            let end = PlantEnd { plant: place, port, takes_courses: true };
            self.links[usize::from(input.channel.0)].plants_out.push(end);
        }
        let outputs: Vec<ChannelId> = spec.outputs().iter().map(|port| port.channel).collect();
        for (port, output) in outputs.iter().enumerate() {
            self.links[usize::from(output.0)].plants_in.push((place, port));
        }
        let driving = vec![Value::HighZ; outputs.len()];
        // Wires draw from the lanes before these.
        let random = Random::lane(self.seed, PLANT_LANES + place as u64);
        let name = spec.name().to_owned();
        self.plants.push(PlantAt { name, plant: spec.build(random), outputs, driving });
    }

    /// Finds out which plants take how their lines go on: those from which no way over lines leads back to the plant that
    /// drives the line. A digital line closes no ring: it changes at instants, and its plant goes on from there.
    fn find_rings(&mut self) {
        let after = |plant: usize| {
            let is_digital =
                |line: &&ChannelId| self.channels[usize::from(line.0)].kind == crate::ChannelKind::Digital;
            let lines = self.plants[plant].outputs.iter().filter(move |line| !is_digital(line));
            lines.flat_map(|line| self.links[usize::from(line.0)].plants_out.iter().map(|end| end.plant))
        };
        let mut rings = Vec::new();
        for (line, links) in self.links.iter().enumerate() {
            for (place, end) in links.plants_out.iter().enumerate() {
                let (mut seen, mut waiting) = (vec![false; self.plants.len()], vec![end.plant]);
                while let Some(plant) = waiting.pop() {
                    if !std::mem::replace(&mut seen[plant], true) {
                        waiting.extend(after(plant));
                    }
                }
                if links.plants_in.iter().any(|(plant, _)| seen[*plant]) {
                    rings.push((line, place));
                }
            }
        }
        for (line, place) in rings {
            self.links[line].plants_out[place].takes_courses = false;
        }
    }

    /// How a line goes on, where one plant drives it and nothing else has a say.
    #[inline]
    fn course(&self, place: usize) -> Option<&Course> {
        let (links, line) = (&self.links[place], &self.lines[place]);
        if links.plants_out.is_empty() {
            return None;
        }
        let [(plant, port)] = links.plants_in[..] else { return None };
        let alone = links.wires_in.is_empty() && line.driven == Value::HighZ && !line.has_faults();
        if alone { self.plants[plant].plant.course(port) } else { None }
    }

    /// How a line goes on, where its plants do not have that yet; a course with an infinite number is none.
    #[inline]
    fn new_course(&self, place: usize) -> Option<Option<Course>> {
        let (course, known) = (self.course(place), &self.links[place].course);
        // Most often it is the known one, and a course is large: it is compared where it stands.
        if course == known.as_ref() {
            return None;
        }
        let course = course.copied().filter(Course::is_finite);
        (course != *known).then_some(course)
    }

    /// What a device on the line reads now: as the last poll at the time of the last call would have reported.
    pub fn value(&self, channel: ChannelId) -> Option<Value> {
        let place = usize::from(channel.0);
        let line = self.lines.get(place)?;
        Some(if self.lost[place] { Value::Unknown } else { line.seen })
    }

    fn place(&self, channel: ChannelId) -> Result<usize, BoardError> {
        let place = usize::from(channel.0);
        if place < self.lines.len() { Ok(place) } else { Err(BoardError::NoChannel(channel)) }
    }

    fn mark(&mut self, place: usize, origin: Origin) {
        self.lines[place].origin = origin;
        self.dirty.insert(place);
    }

    /// Takes note of when a line does something by itself.
    fn note_line(&mut self, place: usize) {
        let line = &self.lines[place];
        self.timetable.set(place, line.next(), line.waiting());
    }

    /// The same of a wire.
    fn note_wire(&mut self, wire: usize) {
        let at = &self.wires[wire];
        self.timetable.set(self.lines.len() + wire, at.next(), at.waiting());
    }

    /// The same of a plant.
    fn note_plant(&mut self, plant: usize) {
        let at = &self.plants[plant].plant;
        self.timetable.set(self.lines.len() + self.wires.len() + plant, at.next_event(), at.waiting());
    }

    /// The outcome of a line's drivers.
    fn resolve(&self, place: usize) -> (Value, bool) {
        let (links, driven) = (&self.links[place], self.lines[place].driven);
        // What most lines have: one source at most.
        match (&links.wires_in[..], &links.plants_in[..]) {
            ([], []) => return (driven, false),
            ([wire], []) if driven == Value::HighZ => return (self.wires[*wire].out, false),
            ([], [(plant, port)]) if driven == Value::HighZ => {
                return (self.plants[*plant].driving[*port], false);
            }
            _ => {}
        }
        let wires = links.wires_in.iter().map(|&wire| self.wires[wire].out);
        let plants = links.plants_in.iter().map(|&(plant, port)| self.plants[plant].driving[port]);
        self.lines[place].resolve(wires.chain(plants))
    }

    /// Carries the marked changes through all that has no delay.
    fn settle(&mut self, now: Time) {
        while let Some(place) = self.dirty.pop() {
            if let Some(tally) = self.links[place].tally {
                self.tallies.look(tally, &mut self.lines);
            }
            let (raw, contended) = self.resolve(place);
            let line = &mut self.lines[place];
            self.health.contentions += u64::from(contended && !line.contended);
            line.contended = contended;
            let changed = if line.is_plain() {
                line.follow(raw)
            } else {
                let changed = line.update(now, raw);
                self.note_line(place);
                changed
            };
            let course = self.new_course(place);
            if changed || course.is_some() {
                if let Some(course) = course {
                    self.links[place].course = course;
                }
                self.carry(now, place);
            }
            self.report(now, place);
        }
    }

    /// Hands the new level of a line on to its wires and plants.
    fn carry(&mut self, now: Time, place: usize) {
        let level = self.lines[place].level;
        for link in 0..self.links[place].wires_out.len() {
            let wire = self.links[place].wires_out[link];
            if self.wires[wire].feed(now, level) {
                self.mark(usize::from(self.wires[wire].spec.to.0), Origin::Wire);
            }
            self.note_wire(wire);
        }
        for link in 0..self.links[place].plants_out.len() {
            let PlantEnd { plant, port, takes_courses } = self.links[place].plants_out[link];
            let course = self.links[place].course.filter(|_| takes_courses);
            self.plants[plant].plant.input(now, port, &PlantInput { value: level, course });
            self.note_plant(plant);
            self.drive_from(plant);
        }
        for link in 0..self.links[place].tallies_out.len() {
            let count = self.links[place].tallies_out[link];
            self.mark(usize::from(count.0), Origin::Outside);
        }
    }

    fn report(&mut self, now: Time, place: usize) {
        let line = &mut self.lines[place];
        let seen = line.sense();
        let changed = seen != line.seen;
        line.seen = seen;
        if self.lost[place] || !self.channels[place].senses {
            return;
        }
        if std::mem::replace(&mut self.announce[place], false) || changed {
            let channel = ChannelId(place as u16);
            let origin = line.origin;
            self.reports.push(BoardEvent::Changed { channel, at: When::exactly(now), value: seen, origin });
        }
    }

    /// Reports a device that went or came back.
    fn notice_loss(&mut self, now: Time, place: usize) {
        let lost = self.lines[place].is_lost();
        if lost == self.lost[place] {
            return;
        }
        self.lost[place] = lost;
        let channel = ChannelId(place as u16);
        if lost {
            self.health.lost_on_purpose += 1;
            self.reports.push(BoardEvent::Lost { channel, at: now, reason: LossReason::Injected });
        } else {
            self.health.lost_on_purpose -= 1;
            self.reports.push(BoardEvent::Returned { channel, at: now });
            self.announce[place] = self.channels[place].senses;
            // What was written meanwhile reaches the line now.
            self.lines[place].driven = self.lines[place].wanted;
        }
    }

    /// Lets all happen that is due at `now`.
    fn step(&mut self, now: Time) {
        let (lines, wires) = (self.lines.len(), self.wires.len());
        let mut part = 0;
        while let Some(due) = self.timetable.due_from(part, now) {
            part = due + 1;
            if due < lines {
                if self.lines[due].pass(now) {
                    let origin = self.lines[due].origin;
                    self.notice_loss(now, due);
                    self.mark(due, origin);
                }
                self.note_line(due);
            } else if due < lines + wires {
                let wire = due - lines;
                if self.wires[wire].arrive(now) {
                    self.mark(usize::from(self.wires[wire].spec.to.0), Origin::Wire);
                }
                self.note_wire(wire);
            } else {
                let plant = due - lines - wires;
                self.plants[plant].plant.advance(now);
                self.notice_fault(now, plant);
                self.note_plant(plant);
                self.drive_from(plant);
            }
        }
        self.settle(now);
    }

    /// Keeps why a plant came to its end, if it did.
    fn notice_fault(&mut self, now: Time, plant: usize) {
        let PlantAt { name, plant, .. } = &self.plants[plant];
        if let (Some(why), None) = (plant.fault(), &self.plant_fault) {
            self.plant_fault = Some(PlantFault { plant: name.clone(), at: now, why: why.to_owned() });
        }
    }

    /// Reports a plant that came to its end, once.
    fn check_plants(&mut self) -> Result<(), BoardError> {
        match &self.plant_fault {
            Some(fault) if !std::mem::replace(&mut self.is_fault_reported, true) => {
                Err(BoardError::PlantFailed(fault.at))
            }
            _ => Ok(()),
        }
    }

    /// Takes a plant's outputs over to its lines, and how they go on.
    fn drive_from(&mut self, plant: usize) {
        for port in 0..self.plants[plant].outputs.len() {
            let at = &mut self.plants[plant];
            let value = match at.plant.outputs().get(port).copied().unwrap_or(Value::HighZ) {
                // What no number can hold leaves the line as it is.
                Value::Real(number) if !number.is_finite() => at.driving[port],
                value => value,
            };
            let line = usize::from(at.outputs[port].0);
            let moved = std::mem::replace(&mut at.driving[port], value) != value;
            if moved {
                self.mark(line, Origin::Plant);
            } else if self.new_course(line).is_some() {
                self.mark(line, self.lines[line].origin);
            }
        }
    }

    /// Whether no more is on its way than there may be.
    fn check_pending(&mut self) -> Result<(), BoardError> {
        let most = MAX_PENDING as usize;
        if self.timetable.waiting() > most || self.reports.len() > most { self.storm() } else { Ok(()) }
    }

    fn storm(&mut self) -> Result<(), BoardError> {
        self.health.failed_calls += 1;
        Err(BoardError::Storm { at: self.now, limit: MAX_PENDING })
    }

    /// Lets all happen that is due before `until`, and what is due at it where `inclusive`.
    fn advance(&mut self, until: Time, inclusive: bool) -> Result<(), BoardError> {
        if !self.started {
            return Err(BoardError::NotStarted);
        }
        if until < self.now {
            return Err(BoardError::Backwards { now: until, last: self.now });
        }
        let mut steps = 0;
        self.check_pending()?;
        while self.timetable.first() < until
            || (inclusive && self.timetable.first() == until && until < Time::MAX)
        {
            self.now = self.now.max(self.timetable.first());
            self.step(self.now);
            self.check_plants()?;
            self.check_pending()?;
            steps += 1;
            if steps > MAX_PENDING {
                return self.storm();
            }
        }
        self.now = until;
        Ok(())
    }

    /// Settles what was marked at `now` by a call.
    fn finish(&mut self, now: Time) -> Result<(), BoardError> {
        self.settle(now);
        self.check_pending()
    }

    /// Lets wires and lines stand where the safe values bring them, as if they had stood there always; what never
    /// comes to rest is left to its delays.
    fn settle_at_start(&mut self, now: Time) {
        let order: Vec<usize> = self.dirty.order().iter().map(|place| usize::from(*place)).collect();
        for plant in &mut self.plants {
            plant.plant.start(now);
            plant.driving.copy_from_slice(plant.plant.outputs());
        }
        for _ in 0..=self.wires.len() {
            let mut moved = false;
            for &place in &order {
                let (raw, contended) = self.resolve(place);
                self.lines[place].contended = contended;
                self.lines[place].settle(raw);
                for link in 0..self.links[place].wires_out.len() {
                    let wire = &mut self.wires[self.links[place].wires_out[link]];
                    moved |= wire.out != wire.carry(raw);
                    // A delayed wire follows after the round, so that a ring through it can be seen.
                    if wire.spec.may_be_immediate() {
                        wire.settle(raw);
                    }
                }
            }
            if !moved {
                break;
            }
            for wire in self.wires.iter_mut().filter(|wire| !wire.spec.may_be_immediate()) {
                wire.settle(self.lines[usize::from(wire.spec.from.0)].level);
            }
        }
        self.tallies.start(&mut self.lines);
        self.health.contentions = self.lines.iter().map(|line| u64::from(line.contended)).sum();
        for place in order {
            self.announce[place] = self.channels[place].senses;
            if let Some(course) = self.new_course(place) {
                self.links[place].course = course;
            }
            self.carry(now, place);
            self.mark(place, Origin::Write);
        }
    }
}

impl Board for SimulatedBoard {
    fn inner(&self) -> Option<&dyn Board> {
        None
    }

    fn inner_mut(&mut self) -> Option<&mut dyn Board> {
        None
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn start(&mut self, now: Time) -> Result<(), BoardError> {
        self.started = true;
        self.now = now;
        self.health = Health::default();
        self.plant_fault = None;
        self.is_fault_reported = false;
        self.reports.clear();
        self.dirty.clear();
        self.lost.fill(false);
        self.buses.start();
        for (line, channel) in self.lines.iter_mut().zip(&self.channels) {
            line.reset(channel.safe);
        }
        self.wires.iter_mut().for_each(|wire| wire.reset(self.seed));
        self.settle_at_start(now);
        (0..self.lines.len()).for_each(|place| self.note_line(place));
        (0..self.wires.len()).for_each(|wire| self.note_wire(wire));
        (0..self.plants.len()).for_each(|plant| self.note_plant(plant));
        self.finish(now)
    }

    fn write(&mut self, now: Time, writes: &[(ChannelId, Value)]) -> Result<(), BoardError> {
        if self.health.latched_safe {
            return Err(BoardError::Latched);
        }
        for (channel, value) in writes {
            let place = self.place(*channel)?;
            if !self.channels[place].drives {
                return Err(BoardError::NotDriven(*channel));
            }
            if fit(&self.channels[place].kind, *value).is_none() {
                return Err(BoardError::BadValue(*channel));
            }
        }
        self.advance(now, false)?;
        for (channel, value) in writes {
            let place = usize::from(channel.0);
            let value = fit(&self.channels[place].kind, *value).unwrap_or(Value::HighZ);
            self.lines[place].wanted = value;
            if !self.lost[place] && self.lines[place].driven != value {
                self.lines[place].driven = value;
                self.mark(place, Origin::Write);
            }
        }
        self.finish(now)
    }

    fn poll(&mut self, now: Time, out: &mut Vec<BoardEvent>) -> Result<(), BoardError> {
        let outcome = self.advance(now, true);
        out.append(&mut self.reports);
        outcome
    }

    fn next_event(&self) -> Option<Time> {
        let waiting = self.reports.first().map(BoardEvent::latest);
        let next = Some(self.timetable.first()).filter(|next| self.started && *next < Time::MAX);
        waiting.into_iter().chain(next).chain(self.buses.next_event()).min()
    }

    fn safe(&mut self, now: Time) -> Result<(), BoardError> {
        self.health.latched_safe = true;
        self.buses.safe(now.max(self.now));
        if !self.started {
            return Ok(());
        }
        let now = now.max(self.now);
        // Lines are made safe even where the circuit storms.
        let outcome = self.advance(now, false);
        let now = self.now;
        for place in 0..self.lines.len() {
            // What is counted is driven by nobody.
            if self.links[place].tally.is_some() {
                continue;
            }
            let safe = self.channels[place].safe;
            self.lines[place].wanted = safe;
            if !self.lost[place] && self.lines[place].driven != safe {
                self.lines[place].driven = safe;
                self.mark(place, Origin::Write);
            }
        }
        self.finish(now).and(outcome)
    }

    fn health(&self) -> Health {
        self.health
    }

    fn plant_parameters(&mut self) -> Option<&mut dyn PlantParameters> {
        Some(self)
    }

    fn plant_fault(&self) -> Option<&PlantFault> {
        self.plant_fault.as_ref()
    }

    fn faults(&self) -> Option<&dyn FaultInjection> {
        Some(self)
    }

    fn faults_mut(&mut self) -> Option<&mut dyn FaultInjection> {
        Some(self)
    }

    fn buses(&self) -> Option<&dyn board::Buses> {
        Some(self)
    }

    fn buses_mut(&mut self) -> Option<&mut dyn board::Buses> {
        Some(self)
    }
}

impl PlantParameters for SimulatedBoard {
    fn set_parameter(
        &mut self,
        now: Time,
        plant: usize,
        parameter: usize,
        value: f64,
    ) -> Result<(), BoardError> {
        if self.health.latched_safe {
            return Err(BoardError::Latched);
        }
        if plant >= self.plants.len() {
            return Err(BoardError::NoPlant(plant));
        }
        self.advance(now, false)?;
        self.plants[plant].plant.set(now, parameter, value);
        self.note_plant(plant);
        self.drive_from(plant);
        self.finish(now)
    }
}

impl FaultInjection for SimulatedBoard {
    fn inject(&mut self, now: Time, fault: Fault) -> Result<(), BoardError> {
        let place = self.place(fault.channel)?;
        let (fault, until) = checks::fault(&self.channels[place], now, fault)?;
        self.advance(now, false)?;
        if !self.lines[place].inject(fault, until) {
            return Err(BoardError::TooManyFaults { channel: fault.channel, limit: MAX_FAULTS });
        }
        self.note_line(place);
        self.notice_loss(now, place);
        self.mark(place, Origin::Fault);
        self.finish(now)
    }

    fn clear_faults(&mut self, now: Time, channel: ChannelId) -> Result<(), BoardError> {
        let place = self.place(channel)?;
        self.advance(now, false)?;
        if self.lines[place].has_faults() {
            self.lines[place].clear();
            self.note_line(place);
            self.notice_loss(now, place);
            self.mark(place, Origin::Fault);
        }
        self.finish(now)
    }

    fn fault_switching_time(&self, _channel: ChannelId) -> Span {
        Span::ZERO
    }

    fn fault_settled_at(&self, _channel: ChannelId) -> Option<When> {
        None
    }
}

impl board::Buses for SimulatedBoard {
    fn bus_list(&self) -> &[Bus] {
        self.buses.list()
    }

    fn send(&mut self, now: Time, bus: BusId, frame: &CanFrame) -> Result<(), BoardError> {
        if !self.started {
            return Err(BoardError::NotStarted);
        }
        self.buses.send(now, bus, frame)
    }

    fn send_serial(&mut self, now: Time, bus: BusId, output: &SerialOutput) -> Result<(), BoardError> {
        if !self.started {
            return Err(BoardError::NotStarted);
        }
        self.buses.send_serial(now, bus, output)
    }

    fn configure(
        &mut self,
        now: Time,
        bus: BusId,
        settings: &SerialSettings,
        message_gap: Span,
    ) -> Result<(), BoardError> {
        if !self.started {
            return Err(BoardError::NotStarted);
        }
        self.buses.configure(now, bus, settings, message_gap)
    }

    fn break_off(&mut self, now: Time, bus: BusId) -> Result<(), BoardError> {
        if !self.started {
            return Err(BoardError::NotStarted);
        }
        self.buses.break_off(now, bus)
    }

    fn poll_buses(&mut self, now: Time, out: &mut Vec<BusEvent>) -> Result<(), BoardError> {
        if !self.started {
            return Err(BoardError::NotStarted);
        }
        self.buses.poll(now, out);
        Ok(())
    }

    fn bus_device(&self, _bus: BusId) -> Option<&str> {
        None
    }
}
