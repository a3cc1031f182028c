//! Endpoints of the controller on buses of the board: from the partner at the far end through the port, the endpoint and the
//! memory back to the partner, in virtual time.

mod events;
mod real;
mod settings;

use crate::allocation::Noting;
use crate::texts::{Parted, Texts};
use controller::{Endpoint, PortEvent, PortLife, PortMessage, PortOutbox, RegisterAccess, State};
use drivers::{
    Board, BoardError, BoardEvent, BoardExt, Bus, BusEvent, BusId, Buses, Channel, ChannelId, Health,
};
use profile::RequestCosts;
use scanrig_runtime::executor::ExecutorReport;
use scanrig_runtime::executor::clock::VirtualClock;
use scanrig_runtime::executor::rig_fault::RigFault;
use scanrig_runtime::subject::model::ModelledController;
use signal::{CanFrame, SerialFlaw, SerialMessage, SerialOutput, SerialSettings, Span, Time, Value};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

const PROGRAM: &str = "PROGRAM MAIN
VAR
    n AT %MW5 : WORD;
    lamp AT %QX0.0 : BOOL;
END_VAR
n := 16#1234;
lamp := NOT lamp;
END_PROGRAM
";

/// SL1 and SL2 on one pair of wires with a partner and somebody who listens; CAN_1 with a partner.
const BOARD: &str = "format = 1
title = \"Lines and a bus of the controller\"
[board]
kind = \"simulated\"
[buses]
line = { kind = \"serial\", baud = 20_000, rs485 = {} }
partner = { kind = \"serial\", rs485 = {}, joins = \"line\" }
listener = { kind = \"serial\", rs485 = {}, joins = \"line\" }
can = { kind = \"can\" }
peer = { kind = \"can\", joins = \"can\" }
";

const LINE: BusId = BusId(0);
const PARTNER: BusId = BusId(1);
const LISTENER: BusId = BusId(2);
const PEER: BusId = BusId(4);

/// A request that takes more processor time than a case has.
const ENDLESS: [u8; 3] = [0; 3];

/// Answers `first count` with words, and `first value` of 4 bytes by writing. At a period it sends a frame.
#[derive(Debug)]
struct Reader {
    requests: VecDeque<SerialMessage>,
    period: Option<Span>,
    due: Time,
    seen: Seen,
}

/// What the endpoint received, as far as it is counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Reported {
    /// The state of the controller, and how often its communication started.
    state: Option<State>,
    starts: u32,
    requests: u32,
    damaged: u32,
    sent: u32,
    not_sent: u32,
    /// When the last message that it sent was over, and when it learned of it.
    free: Option<(Time, Time)>,
}

type Seen = Arc<Mutex<Reported>>;

impl Reader {
    fn boxed(period: Option<Span>, seen: &Seen) -> Box<dyn Endpoint> {
        let requests = VecDeque::with_capacity(4);
        Box::new(Reader { requests, period, due: Time::MAX, seen: seen.clone() })
    }
}

impl Endpoint for Reader {
    fn enter(&mut self, now: Time, life: PortLife, _: &mut PortOutbox) {
        self.requests.clear();
        let mut seen = self.seen.lock().unwrap();
        seen.starts += u32::from(life == PortLife::Restarted);
        if let PortLife::State(state) = life {
            seen.state = Some(state);
            let running = state == State::Running;
            self.due = self.period.filter(|_| running).map_or(Time::MAX, |period| now + period);
        }
    }

    fn receive(&mut self, now: Time, event: &PortEvent, _: &mut PortOutbox) {
        let mut seen = self.seen.lock().unwrap();
        match event {
            PortEvent::Serial(message) if message.is_sound() => {
                seen.requests += 1;
                self.requests.push_back(*message);
            }
            PortEvent::Serial(_) => seen.damaged += 1,
            PortEvent::Sent { at } => {
                seen.sent += 1;
                seen.free = Some((at.latest, now));
            }
            PortEvent::NotSent => seen.not_sent += 1,
            _ => {}
        }
    }

    fn next(&self) -> Time {
        self.due
    }

    fn fire(&mut self, now: Time, outbox: &mut PortOutbox) {
        let frame = CanFrame::classic(0x701, false, &[5]).unwrap();
        let _ = outbox.push(now, PortMessage::Can(frame));
        self.due = self.period.map_or(Time::MAX, |period| self.due + period);
    }

    fn work(&self) -> Option<Span> {
        let request = self.requests.front()?.data();
        if request == ENDLESS {
            return Some(Span::from_secs(3_600));
        }
        let words = request.get(1).copied().unwrap_or(0);
        Some(RequestCosts::RIG.of(u16::from(words)))
    }

    fn step(&mut self, now: Time, registers: &mut dyn RegisterAccess, outbox: &mut PortOutbox) {
        let Some(request) = self.requests.pop_front() else { return };
        let mut answer = [0; 256];
        let len = match *request.data() {
            [first, count] => {
                let mut words = [0; 120];
                let words = &mut words[..usize::from(count)];
                registers.read_registers(u16::from(first), words).unwrap();
                let bytes = words.iter().flat_map(|word| word.to_be_bytes());
                answer.iter_mut().zip(bytes).for_each(|(place, byte)| *place = byte);
                usize::from(count) * 2
            }
            [first, _, high, low] => {
                registers.write_registers(u16::from(first), &[u16::from_be_bytes([high, low])]).unwrap();
                1
            }
            _ => return,
        };
        let _ = outbox.push(now, PortMessage::serial(&answer[..len]).unwrap());
    }
}

/// What every end heard, and what the partner sends.
#[derive(Debug, Default)]
struct World {
    script: VecDeque<(Time, BusId, SerialOutput)>,
    /// What the board reports when besides what is on its lines.
    reports: VecDeque<(Time, BusEvent)>,
    heard: Vec<BusEvent>,
}

impl World {
    /// What an end received: message and when it was over.
    fn received(&self, at: BusId) -> Vec<SerialMessage> {
        let of = |event: &BusEvent| match *event {
            BusEvent::SerialMessage { bus, message, own: false } if bus == at => Some(message),
            _ => None,
        };
        self.heard.iter().filter_map(of).collect()
    }
}

/// A board with partners at its far ends.
#[derive(Debug)]
struct WithPartners {
    board: Box<dyn Board>,
    world: Arc<Mutex<World>>,
}

impl Board for WithPartners {
    fn inner(&self) -> Option<&dyn Board> {
        Some(&*self.board)
    }
    fn inner_mut(&mut self) -> Option<&mut dyn Board> {
        Some(&mut *self.board)
    }
    fn channels(&self) -> &[Channel] {
        self.board.channels()
    }
    fn start(&mut self, now: Time) -> Result<(), BoardError> {
        self.board.start(now)
    }
    fn write(&mut self, now: Time, writes: &[(ChannelId, Value)]) -> Result<(), BoardError> {
        self.board.write(now, writes)
    }
    fn poll(&mut self, now: Time, out: &mut Vec<BoardEvent>) -> Result<(), BoardError> {
        let mut world = self.world.lock().unwrap();
        while let Some((_, bus, output)) = world.script.front().filter(|(at, ..)| *at <= now) {
            self.board.send_serial(now, *bus, output)?;
            world.script.pop_front();
        }
        self.board.poll(now, out)
    }
    fn next_event(&self) -> Option<Time> {
        let world = self.world.lock().unwrap();
        let script = world.script.front().map(|(at, ..)| *at);
        let reports = world.reports.front().map(|(at, _)| *at);
        self.board.next_event().into_iter().chain(script).chain(reports).min()
    }
    fn safe(&mut self, now: Time) -> Result<(), BoardError> {
        self.board.safe(now)
    }
    fn health(&self) -> Health {
        self.board.health()
    }
    fn buses(&self) -> Option<&dyn Buses> {
        Some(self)
    }
    fn buses_mut(&mut self) -> Option<&mut dyn Buses> {
        Some(self)
    }
}

impl Buses for WithPartners {
    fn bus_list(&self) -> &[Bus] {
        self.board.bus_list()
    }
    fn bus_device(&self, bus: BusId) -> Option<&str> {
        self.board.bus_device(bus)
    }
    fn send(&mut self, now: Time, bus: BusId, frame: &CanFrame) -> Result<(), BoardError> {
        self.board.send(now, bus, frame)
    }
    fn send_serial(&mut self, now: Time, bus: BusId, output: &SerialOutput) -> Result<(), BoardError> {
        self.board.send_serial(now, bus, output)
    }
    fn configure(
        &mut self,
        now: Time,
        bus: BusId,
        settings: &SerialSettings,
        message_gap: Span,
    ) -> Result<(), BoardError> {
        self.board.configure(now, bus, settings, message_gap)
    }

    fn break_off(&mut self, now: Time, bus: BusId) -> Result<(), BoardError> {
        self.board.break_off(now, bus)
    }
    fn poll_buses(&mut self, now: Time, out: &mut Vec<BusEvent>) -> Result<(), BoardError> {
        let first = out.len();
        self.board.poll_buses(now, out)?;
        let mut world = self.world.lock().unwrap();
        while let Some((_, event)) = world.reports.front().copied().filter(|(at, _)| *at <= now) {
            world.reports.pop_front();
            out.push(event);
        }
        // What it heard is looked into; in a test of allocations nobody does.
        if world.heard.capacity() > world.heard.len() + out.len() {
            world.heard.extend_from_slice(&out[first..]);
        }
        Ok(())
    }
}

/// A case on this board, with what is on its lines and what its endpoints received.
struct Bench {
    model: ModelledController,
    parts: Parted,
    world: Arc<Mutex<World>>,
    reported: Seen,
}

impl Bench {
    /// A case with these steps and bound ports.
    fn new(steps: &str, ports: &str, ends: &str) -> Bench {
        let plan = format!(
            "format = 1\ntitle = \"Requests\"\nprogram = \"program.st\"\nboard = \"board.toml\"
signals = {{ word = \"%MW9\", lamp = \"%QX0.0\" }}\nends = \"{ends}\"\nsteps = [{steps}]
expect = [{{ state = {{ stays = \"RUNNING\", from = \"start\", until = \"end\" }} }}]\n"
        );
        let board = format!("{BOARD}[ports]\n{ports}\n");
        let texts = [("plan.toml", plan.as_str()), ("program.st", PROGRAM), ("board.toml", board.as_str())];
        let world = Arc::new(Mutex::new(World { heard: Vec::with_capacity(1_000), ..World::default() }));
        let with = |board| -> Box<dyn Board> { Box::new(WithPartners { board, world: world.clone() }) };
        let (model, parts) =
            Texts(&texts).parts_on(1, |_| {}, with).unwrap_or_else(|found| panic!("{found:#?}"));
        Bench { model, parts, world, reported: Seen::default() }
    }

    fn attach(mut self, port: usize, period: Option<Span>) -> Bench {
        assert!(self.model.attach_endpoint(port, Reader::boxed(period, &self.reported)));
        self
    }

    /// The partner sends this at an instant.
    fn says(self, at: Time, output: SerialOutput) -> Bench {
        self.world.lock().unwrap().script.push_back((at, PARTNER, output));
        self
    }

    fn run(&mut self) -> ExecutorReport {
        self.parts.run(&mut VirtualClock::default(), &mut self.model)
    }

    fn received(&self, at: BusId) -> Vec<SerialMessage> {
        self.world.lock().unwrap().received(at)
    }

    fn reported(&self) -> Reported {
        *self.reported.lock().unwrap()
    }
}

const BOUND: &str = "SL1 = \"line\"\nCAN_1 = \"can\"";
const ENDS: &str = "start + 300 ms";
const SL1: usize = 0;
const CAN_1: usize = 2;

/// When RUNNING begins: MAST at once and every 20 ms, for some microseconds.
fn start() -> Time {
    Bench::new("", BOUND, ENDS).run().start.unwrap()
}

fn ms(n: i64) -> Span {
    Span::from_millis(n)
}

/// Bits of 50 us, so that every instant is a whole nanosecond.
const SETTINGS: SerialSettings =
    SerialSettings { baud: 20_000, data_bits: 8, parity: signal::Parity::Even, stop_bits: 1 };

fn characters(n: u64) -> Span {
    SETTINGS.lasts(n)
}

/// From the end of a message to its being over, as Modbus has it.
fn gap() -> Span {
    SETTINGS.frame_gap()
}

/// The request is over a gap after its last character; then the words cost what the profile says; the answer begins at once.
#[test]
fn an_answer_comes_after_gap_and_processor_time_to_the_nanosecond() {
    let asked = start() + ms(105);
    let mut bench = Bench::new("", BOUND, ENDS).attach(SL1, None).says(asked, SerialOutput::plain(&[5, 2]));
    let ran = bench.run();
    assert_eq!(ran.fault, None);
    let answers = bench.received(PARTNER);
    assert_eq!(answers.len(), 1);
    assert_eq!(answers[0].first.earliest, asked + characters(2) + gap() + RequestCosts::RIG.of(2));
    assert_eq!(answers[0].data(), [0x12, 0x34, 0, 0]);
    assert!(answers[0].is_sound());
    let Reported { sent, free: Some((free, learned)), damaged, .. } = bench.reported() else { panic!() };
    assert_eq!((sent, damaged, learned), (1, 0, free), "it learns that its line is free as it is");
    assert_eq!(free - answers[0].first.earliest, characters(4));
}

/// A shorter answer has nothing of the longer one before it.
#[test]
fn each_request_has_its_own_answer() {
    let asked = start() + ms(105);
    let mut bench = Bench::new("", BOUND, ENDS)
        .attach(SL1, None)
        .says(asked, SerialOutput::plain(&[5, 2]))
        .says(asked + ms(50), SerialOutput::plain(&[5, 1]));
    assert_eq!(bench.run().fault, None);
    let answers: Vec<_> = bench.received(PARTNER).iter().map(|answer| answer.data().to_vec()).collect();
    assert_eq!(answers, [vec![0x12, 0x34, 0, 0], vec![0x12, 0x34]]);
}

/// Twice and with any slices, the trace and what is on the lines are the same.
#[test]
fn how_time_is_cut_does_not_show() {
    let begun = start();
    let run = |slice: Span| {
        let mut bench = Bench::new("", BOUND, ENDS).attach(SL1, None).attach(CAN_1, Some(ms(7)));
        for n in 0..20 {
            let at = begun + ms(10) + Span::from_micros(13_331 * n);
            let output = if n % 2 == 0 { vec![5, 60] } else { vec![9, 0, 1, n as u8] };
            bench = bench.says(at, SerialOutput::plain(&output));
        }
        bench.parts.slice = slice;
        assert_eq!(bench.run().fault, None);
        let heard = std::mem::take(&mut bench.world.lock().unwrap().heard);
        (bench.parts.recorder.trace().digest(), heard, bench.reported())
    };
    let whole = run(Span::MAX);
    assert!(whole.2.sent > 40, "{:?}", whole.2);
    for slice in [Span::MAX, Span::from_micros(333), Span::from_nanos(77_777)] {
        assert!(run(slice) == whole, "{slice}");
    }
}

/// What a client writes is in the trace with its port as writer.
#[test]
fn a_write_is_recorded_with_its_port() {
    let asked = start() + ms(105);
    let request = SerialOutput::plain(&[9, 0, 0x47, 0x11]);
    let mut bench = Bench::new("", BOUND, ENDS).attach(SL1, None).says(asked, request);
    assert_eq!(bench.run().fault, None);
    let trace = bench.parts.recorder.trace();
    let word = trace.signals().iter().position(|signal| signal.name == "word").unwrap() as u32;
    let of_word = trace.events().map(|event| event.unwrap()).filter(|event| event.signal.0 == word);
    let last = of_word.last().unwrap();
    assert_eq!((last.value, last.cause), (Value::Word(0x4711), signal::Cause::Port(SL1 as u8)));
}

#[test]
fn a_damaged_request_gets_no_answer() {
    let flaw = Some((1, SerialFlaw::Parity));
    let request = SerialOutput::Characters { data: vec![5, 2], gap: Span::ZERO, flaw };
    let mut bench = Bench::new("", BOUND, ENDS).attach(SL1, None).says(start() + ms(105), request);
    assert_eq!(bench.run().fault, None);
    assert_eq!((bench.reported().damaged, bench.received(PARTNER).len()), (1, 0));
}

/// The partner speaks again while the controller answers: the listener hears what nobody said.
#[test]
fn a_collision_damages_what_is_on_the_line() {
    let asked = start() + ms(105);
    let begins = asked + characters(2) + gap() + RequestCosts::RIG.of(40);
    let mut bench = Bench::new("", BOUND, ENDS)
        .attach(SL1, None)
        .says(asked, SerialOutput::plain(&[5, 40]))
        .says(begins + characters(3) + Span::from_micros(100), SerialOutput::plain(&[0; 8]));
    assert_eq!(bench.run().fault, None);
    let heard = bench.received(LISTENER);
    assert_eq!(heard[0].data(), [5, 40]);
    assert!(heard[1].errors.any() || heard[1].data()[..2] != [0x12, 0x34] || heard[1].data().len() != 80);
    assert_eq!(bench.reported().sent, 1);
}

/// The supply goes while the answer is on the line: it ends 4 ms later, the hold-up time, in the middle of it, and comes not
/// again.
#[test]
fn an_answer_breaks_off_with_the_supply() {
    let begun = start();
    let asked = begun + ms(105);
    let steps = "{ id = \"off\", at = \"start + 115 ms\", power = \"off\" }";
    let mut bench =
        Bench::new(steps, BOUND, ENDS).attach(SL1, None).says(asked, SerialOutput::plain(&[5, 60]));
    assert_eq!(bench.run().fault, None);
    let answer = bench.received(PARTNER)[0];
    let off = begun + ms(119);
    assert!(answer.data().len() > 10 && answer.data().len() < 30, "{answer:?}");
    // A character that broke off is completed by the line at rest.
    assert!(answer.last.latest <= off + characters(1), "{} {off}", answer.last.latest);
    assert_eq!(bench.reported().sent, 0);
}

#[test]
fn frames_of_an_endpoint_are_on_the_bus_of_its_port() {
    let mut bench = Bench::new("", BOUND, ENDS).attach(CAN_1, Some(ms(50)));
    let ran = bench.run();
    assert_eq!(ran.fault, None);
    assert!(ran.log.iter().all(|(_, line)| !line.contains("CAN_1")), "{:?}", ran.log);
    let heard = &bench.world.lock().unwrap().heard;
    let at_peer =
        heard.iter().filter(|event| matches!(event, BusEvent::CanFrame { bus: PEER, own: false, .. }));
    assert!((5..=6).contains(&at_peer.count()));
}

#[test]
fn an_unbound_port_discards_and_the_log_says_so_once() {
    let mut bench = Bench::new("", "SL1 = \"line\"", ENDS).attach(CAN_1, Some(ms(50)));
    let ran = bench.run();
    assert_eq!(ran.fault, None);
    let lines: Vec<_> = ran.log.iter().filter(|(_, line)| line.contains("CAN_1")).collect();
    let [(at, line)] = lines[..] else { panic!("{:?}", ran.log) };
    assert_eq!(*at, ran.start.unwrap() + ms(50));
    assert!(line.contains("binds no bus") && line.contains("discarded"), "{line}");
    // An endpoint that waits for the end of what it sends does not wait for ever.
    let reported = bench.reported();
    assert!(reported.not_sent >= 5 && reported.sent == 0, "{reported:?}");
}

/// A frame does not fit on a serial line.
#[test]
fn what_the_bus_refuses_is_a_fault_of_the_case() {
    let mut bench = Bench::new("", BOUND, ENDS).attach(SL1, Some(ms(50)));
    let fault = bench.run().fault;
    let expected = |fault: &RigFault| matches!(fault, RigFault::PortNotSent { bus, error: BoardError::BadFrame(LINE), .. } if bus == "line");
    assert!(fault.as_ref().is_some_and(expected), "{fault:?}");
    assert!(bench.reported().not_sent >= 5);
}

/// The loop allocates as little with requests in it as without.
#[test]
fn a_request_allocates_nothing() {
    let begun = start();
    let mut bench = Bench::new("", BOUND, "start + 230 s").attach(SL1, None).attach(CAN_1, Some(ms(5)));
    for n in 0..2_000 {
        bench = bench.says(begun + ms(100 * (n + 1)), SerialOutput::plain(&[5, 60]));
    }
    bench.world.lock().unwrap().heard = Vec::new();
    let at = |seconds| Time::ZERO + Span::from_secs(seconds);
    let mut clock = Noting { now: Time::ZERO, at: [at(40), at(100), at(160)], allocations: [None; 3] };
    let ran = bench.parts.run(&mut clock, &mut bench.model);
    assert_eq!(ran.fault, None);
    let [first, second, third] = clock.allocations.map(Option::unwrap);
    let (short, long) = (second - first, third - second);
    // Segments of the trace, as without endpoints; a request has none.
    assert!(short < 100 && long < 100, "{short} {long}");
}
