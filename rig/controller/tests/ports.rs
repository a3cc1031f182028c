//! Endpoints at ports: instants, processor time, memory, power.

use crate::support::*;
use scanrig_controller::*;
use signal::{Area, Cause, SerialMessage, Span, Time, Value, When};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

/// What was reported to the endpoint of the controller.
type Heard = Arc<Mutex<Vec<(Time, PortLife)>>>;

/// Answers requests of a line: `R first count` with words, `W first value` with `w`, `B first` with a bit of %Q. Every
/// `period` it sends a frame of its own, if there is one.
#[derive(Debug)]
struct Reader {
    cost: Span,
    requests: VecDeque<[u8; 5]>,
    heard: Heard,
    period: Option<Span>,
    due: Time,
    /// Answers to each request.
    answers: usize,
}

impl Reader {
    fn new(cost: Span) -> Reader {
        let requests = VecDeque::with_capacity(8);
        Reader { cost, requests, heard: Heard::default(), period: None, due: Time::MAX, answers: 1 }
    }
}

impl Endpoint for Reader {
    fn enter(&mut self, now: Time, life: PortLife, _: &mut PortOutbox) {
        self.heard.lock().unwrap().push((now, life));
        self.requests.clear();
        self.due = match (life, self.period) {
            (PortLife::State(State::Running), Some(period)) => now + period,
            _ => Time::MAX,
        };
    }

    fn receive(&mut self, _: Time, event: &PortEvent, _: &mut PortOutbox) {
        if let PortEvent::Serial(message) = event
            && message.is_sound()
            && let Ok(request) = message.data().try_into()
        {
            self.requests.push_back(request);
        }
    }

    fn next(&self) -> Time {
        self.due
    }

    fn fire(&mut self, now: Time, outbox: &mut PortOutbox) {
        let frame = signal::CanFrame::classic(0x701, false, &[5]).unwrap();
        let _ = outbox.push(now, PortMessage::Can(frame));
        self.due = self.period.map_or(Time::MAX, |period| self.due + period);
    }

    fn work(&self) -> Option<Span> {
        (!self.requests.is_empty()).then_some(self.cost)
    }

    fn step(&mut self, now: Time, registers: &mut dyn RegisterAccess, outbox: &mut PortOutbox) {
        let Some([kind, a, b, c, d]) = self.requests.pop_front() else { return };
        let (first, value) = (u16::from_be_bytes([a, b]), u16::from_be_bytes([c, d]));
        let mut words = [0; 4];
        let bytes = match kind {
            b'R' => match registers.read_registers(first, &mut words[..usize::from(value)]) {
                Ok(()) => words[..usize::from(value)].iter().flat_map(|word| word.to_be_bytes()).collect(),
                Err(_) => vec![0xFF],
            },
            b'W' => vec![if registers.write_registers(first, &[value]).is_ok() { b'w' } else { 0xFF }],
            _ => {
                let written = registers.write_bits(Area::Output, u32::from(first), &[value != 0]);
                vec![if written.is_ok() { b'b' } else { 0xFF }]
            }
        };
        for _ in 0..self.answers {
            let _ = outbox.push(now, PortMessage::serial(&bytes).unwrap());
        }
    }
}

/// A controller with an endpoint at SL1, and what that one heard.
fn with(config: Config, app: Script, reader: Reader) -> (Rig, Heard) {
    let heard = reader.heard.clone();
    let mut rig = Rig::off(config, app);
    assert!(rig.plc.attach_endpoint(0, Box::new(reader)));
    rig.plc.commission(b"app", State::Running).unwrap();
    rig.power_on();
    rig.after(BOOT);
    rig.settle();
    assert_eq!(rig.plc.state(), State::Running);
    (rig, heard)
}

/// A MAST of 20 ms that takes 10 ms of them, and counts in %MW5.
fn half_load() -> Script {
    Script::new(vec![vec![(5_000_000, Act::Nop), (5_000_000, Act::Store(at("%MW5"), 77))]])
}

fn request(kind: u8, first: u16, value: u16) -> PortEvent {
    let ([a, b], [c, d]) = (first.to_be_bytes(), value.to_be_bytes());
    let at = When::exactly(Time::ZERO);
    PortEvent::Serial(SerialMessage::of(at, at, &[kind, a, b, c, d]))
}

impl Rig {
    fn receive(&mut self, port: usize, event: &PortEvent) {
        self.plc.receive(self.now, port, event, &mut self.fx);
        self.seen.append(&mut self.fx.list);
    }

    /// When each message of a port was announced.
    fn outputs(&self, port: usize) -> Vec<Time> {
        let of = |effect: &Effect| match effect {
            Effect::PortOutput { at, port: of } if *of == port => Some(*at),
            _ => None,
        };
        self.seen.iter().filter_map(of).collect()
    }
}

fn bytes(message: Option<PortMessage>) -> Vec<u8> {
    match message {
        Some(PortMessage::Serial(bytes)) => bytes.data().to_vec(),
        other => panic!("{other:?}"),
    }
}

/// MAST is at rest from 10 ms to 20 ms of its cycle; what does not fit waits for the next rest (ethernet:NET-08).
#[test]
fn a_request_takes_processor_time_that_no_task_wants() {
    for (at, cost, answered) in [(12, 3, 15), (15, 5, 20), (15, 8, 33), (2, 4, 14), (15, 16, 51)] {
        let (mut rig, _) = with(config(), half_load(), Reader::new(ms(cost)));
        rig.to(run_at(ms(at)));
        rig.receive(0, &request(b'R', 5, 2));
        rig.to(run_at(ms(70)));
        assert_eq!(rig.outputs(0), [run_at(ms(answered))], "{at} ms, {cost} ms");
        assert_eq!(bytes(rig.plc.take_output(0)), [0, 77, 0, 0]);
        assert_eq!(rig.plc.take_output(0), None);
    }
}

#[test]
fn how_time_is_cut_does_not_show() {
    let seen = |slices: &[i64]| {
        let mut reader = Reader::new(us(3_333));
        reader.period = Some(us(7_001));
        let (mut rig, heard) = with(config(), half_load(), reader);
        rig.plc.watch(Probe::Address(at("%MW9")));
        rig.slices = slices.to_vec();
        for n in 0..6 {
            rig.to(run_at(us(9_700 * (n + 1))));
            rig.receive(0, &request(b'W', 9, n as u16 + 1));
            rig.receive(0, &request(b'R', 5, 1));
        }
        rig.to(run_at(ms(150)));
        let heard = heard.lock().unwrap().clone();
        (rig.seen, heard, rig.plc.port_status(0))
    };
    let whole = seen(&[]);
    assert_eq!(whole.2.unwrap().steps, 12);
    for slices in [&[1_000_003][..], &[777, 40_000, 1_300_001], &[3_333_000]] {
        assert_eq!(seen(slices), whole, "{slices:?}");
    }
}

/// As any write from outside: observed, with its cause, and closed where registers are (controller:MEM-07).
#[test]
fn writes_are_observed_with_their_cause() {
    let (mut rig, _) = with(config(), half_load(), Reader::new(us(100)));
    let word = rig.plc.watch(Probe::Address(at("%MW9")));
    let bit = rig.plc.watch(Probe::Address(at("%QX1.0")));
    rig.to(run_at(ms(12)));
    rig.receive(0, &request(b'W', 9, 4_711));
    rig.receive(0, &request(b'B', 8, 1));
    rig.receive(0, &request(b'W', 60_000, 1));
    rig.to(run_at(ms(13)));
    let written = |us_later, probe, value| Effect::Changed {
        at: run_at(ms(12) + us(us_later)),
        probe,
        value,
        cause: Cause::Port(0),
    };
    assert!(rig.seen.contains(&written(100, word, Value::Word(4_711))), "{:?}", rig.seen);
    assert!(rig.seen.contains(&written(200, bit, Value::Bool(true))), "{:?}", rig.seen);
    let answers: Vec<_> = (0..3).map(|_| bytes(rig.plc.take_output(0))).collect();
    assert_eq!(answers, [vec![b'w'], vec![b'b'], vec![0xFF]]);
}

/// serial-can:SER-17: in STOPPED the whole processor is idle.
#[test]
fn communication_goes_on_in_stopped() {
    let (mut rig, heard) = with(config(), half_load(), Reader::new(ms(8)));
    rig.command(Command::Stop).unwrap();
    rig.to(run_at(ms(40)));
    assert_eq!(heard.lock().unwrap().last().map(|(_, life)| *life), Some(PortLife::State(State::Stopped)));
    rig.receive(0, &request(b'R', 5, 1));
    // Real lines have it run ahead for that.
    assert!(rig.plc.is_computing());
    rig.to(run_at(ms(60)));
    assert!(!rig.plc.is_computing());
    assert_eq!(rig.outputs(0), [run_at(ms(48))]);
}

/// controller:CMD-03: the endpoint learns of a command that it gave itself, and goes on answering.
#[test]
fn a_step_may_command_the_controller() {
    let mut config = config();
    config.relocation.write = vec!["PLC_W.q_wPLCControl".into(), "PLC_W.q_uiOpenPLCControl".into()];
    let (mut rig, heard) = with(config, half_load(), Reader::new(us(100)));
    rig.to(run_at(ms(12)));
    for (register, value) in [(62_200, 1), (62_201, 6_699)] {
        rig.receive(0, &request(b'W', register, value));
    }
    rig.receive(0, &request(b'R', 5, 1));
    rig.to(run_at(ms(13)));
    assert_eq!(rig.plc.state(), State::Stopped);
    let stopped = (run_at(ms(12) + us(200)), PortLife::State(State::Stopped));
    assert_eq!(heard.lock().unwrap().last(), Some(&stopped));
}

/// What came before is gone; what comes meanwhile reaches nobody; afterwards it begins from the start.
#[test]
fn power_ends_what_is_under_way() {
    let (mut rig, heard) = with(config(), half_load(), Reader::new(ms(9)));
    rig.to(run_at(ms(11)));
    rig.receive(0, &request(b'R', 5, 1));
    rig.power_off();
    rig.to(run_at(ms(16)));
    assert_eq!(rig.plc.state(), State::Off);
    let silent = Effect::PortSilent { at: run_at(ms(15)), port: 0 };
    assert!(rig.seen.contains(&silent), "{:?}", rig.seen);
    rig.receive(0, &request(b'R', 5, 1));
    rig.to(run_at(ms(100)));
    assert_eq!(rig.outputs(0), []);
    let PortStatus { received, discarded, steps, .. } = rig.plc.port_status(0).unwrap();
    assert_eq!((received, discarded, steps), (1, 1, 0));
    rig.power_on();
    rig.after(BOOT + ms(11));
    let lives: Vec<_> = heard.lock().unwrap().iter().map(|(_, life)| *life).collect();
    let boot = [PortLife::State(State::Booting), PortLife::Restarted, PortLife::State(State::Running)];
    assert_eq!(lives, [&boot[..], &[PortLife::State(State::Off)], &boot].concat());
    rig.receive(0, &request(b'R', 5, 1));
    rig.after(ms(30));
    assert_eq!(rig.outputs(0).len(), 1);
}

#[test]
fn a_full_outbox_is_reported() {
    let mut reader = Reader::new(us(10));
    reader.answers = OUTBOX_MESSAGES + 2;
    let (mut rig, _) = with(config(), half_load(), reader);
    rig.to(run_at(ms(12)));
    rig.receive(0, &request(b'R', 5, 1));
    rig.to(run_at(ms(13)));
    assert_eq!(rig.outputs(0).len(), OUTBOX_MESSAGES);
    assert_eq!(rig.plc.port_status(0).unwrap().dropped, 2);
    assert!(rig.log().contains(&LogEntry::OutboxFull { port: "SL1", dropped: 2 }), "{:?}", rig.log());
}

#[test]
fn ports_take_their_steps_in_turn() {
    let mut rig = Rig::off(config(), half_load());
    assert!(
        rig.plc.attach_endpoint(0, Box::new(Reader::new(ms(1))))
            && rig.plc.attach_endpoint(1, Box::new(Reader::new(ms(1))))
    );
    assert!(!rig.plc.attach_endpoint(9, Box::new(Reader::new(ms(1)))), "there is no such port");
    rig.plc.commission(b"app", State::Running).unwrap();
    rig.power_on();
    rig.after(BOOT);
    rig.settle();
    assert!(!rig.plc.attach_endpoint(0, Box::new(Reader::new(ms(1)))), "it has power");
    rig.to(run_at(ms(12)));
    for _ in 0..2 {
        rig.receive(0, &request(b'R', 5, 1));
    }
    rig.receive(1, &request(b'R', 5, 1));
    rig.to(run_at(ms(18)));
    assert_eq!(
        (rig.outputs(0), rig.outputs(1)),
        (vec![run_at(ms(13)), run_at(ms(15))], vec![run_at(ms(14))])
    );
}

/// What an endpoint does in a step.
type Step = Box<dyn FnMut(&mut dyn RegisterAccess) + Send>;

/// Does this in a step of 100 us for each message.
struct Doing {
    waiting: usize,
    step: Step,
}

impl std::fmt::Debug for Doing {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Doing").finish_non_exhaustive()
    }
}

impl Endpoint for Doing {
    fn enter(&mut self, _: Time, _: PortLife, _: &mut PortOutbox) {}

    fn receive(&mut self, _: Time, _: &PortEvent, _: &mut PortOutbox) {
        self.waiting += 1;
    }

    fn next(&self) -> Time {
        Time::MAX
    }

    fn fire(&mut self, _: Time, _: &mut PortOutbox) {}

    fn work(&self) -> Option<Span> {
        (self.waiting > 0).then_some(us(100))
    }

    fn step(&mut self, _: Time, registers: &mut dyn RegisterAccess, _: &mut PortOutbox) {
        self.waiting -= 1;
        (self.step)(registers);
    }
}

/// Has a controller's endpoint at SL2 do this in RUNNING, while MAST is at rest.
fn doing(step: impl FnMut(&mut dyn RegisterAccess) + Send + 'static) -> Rig {
    let mut rig = Rig::off(config(), half_load());
    assert!(rig.plc.attach_endpoint(1, Box::new(Doing { waiting: 0, step: Box::new(step) })));
    rig.plc.commission(b"app", State::Running).unwrap();
    rig.power_on();
    rig.after(BOOT);
    rig.settle();
    rig.to(run_at(ms(12)));
    rig
}

#[test]
fn bits_are_those_of_their_area_up_to_its_end() {
    let done = Arc::new(Mutex::new(0));
    let count = done.clone();
    let mut rig = doing(move |registers| {
        assert_eq!(registers.state(), State::Running);
        registers.write_bits(Area::Memory, 159, &[true, false, true]).unwrap();
        let mut bits = [false; 5];
        registers.read_bits(Area::Memory, 158, &mut bits).unwrap();
        assert_eq!(bits, [false, true, false, true, false]);
        assert_eq!(registers.write_bits(Area::Input, 0, &[true]), Err(RegisterError::IllegalAddress));
        let end = profile::Profile::M241_2019.address_limits().bits(Area::Memory);
        assert_eq!(
            registers.write_bits(Area::Memory, end - 1, &[true; 2]),
            Err(RegisterError::IllegalAddress)
        );
        let beyond = registers.read_bits(Area::Memory, end - 1, &mut [false; 2]);
        assert_eq!(beyond, Err(RegisterError::IllegalAddress));
        registers.read_bits(Area::Memory, end - 1, &mut bits[..1]).unwrap();
        assert!(!bits[0], "all or none");
        *count.lock().unwrap() += 1;
    });
    rig.receive(1, &request(b'x', 0, 0));
    rig.to(run_at(ms(13)));
    assert_eq!(*done.lock().unwrap(), 1);
    assert_eq!((rig.memory("%MX19.7"), rig.memory("%MX20.1"), rig.memory("%IX0.0")), (1, 1, 0));
}

/// As any write from outside: in STOPPED, where no cycle ends, a save begins with the write and not with the next refresh of
/// inputs and outputs, for which the supply does not last (controller:REM-02).
#[test]
fn what_is_written_in_stopped_is_kept_over_a_power_cut() {
    let mut rig = doing(|registers| registers.write_registers(9, &[4_711]).unwrap());
    rig.command(Command::Stop).unwrap();
    rig.to(run_at(ms(40)));
    assert_eq!(rig.plc.state(), State::Stopped);
    rig.receive(1, &request(b'x', 0, 0));
    rig.after(ms(1));
    rig.power_off();
    rig.after(ms(100));
    rig.power_on();
    rig.after(BOOT + ms(10));
    assert_eq!(rig.memory("%MW9"), 4_711);
}

/// Whoever reads the trace sees which port wrote, register by register and bit by bit.
#[test]
fn the_second_port_writes_in_its_own_name() {
    let mut rig = doing(|registers| {
        registers.write_bits(Area::Output, 0, &[true]).unwrap();
        registers.write_bits(Area::Memory, 0, &[true]).unwrap();
        registers.write_registers(9, &[1]).unwrap();
    });
    let bit = rig.plc.watch(Probe::Address(at("%MX0.0")));
    let word = rig.plc.watch(Probe::Address(at("%MW9")));
    rig.receive(1, &request(b'x', 0, 0));
    rig.to(run_at(ms(13)));
    rig.to(run_at(ms(31)));
    let (terminal, value) = (Terminal::output(0), Value::Bool(true));
    let (at, cause) = (run_at(ms(30) + us(2)), Cause::Port(1));
    let driven = Effect::Terminal { at, terminal, value, cause, early: Span::ZERO };
    assert!(rig.seen.contains(&driven), "{:?}", rig.seen);
    for (probe, value) in [(bit, Value::Bool(true)), (word, Value::Word(1))] {
        let written = Effect::Changed { at: run_at(us(12_100)), probe, value, cause: Cause::Port(1) };
        assert!(rig.seen.contains(&written), "{:?}", rig.seen);
    }
}

#[test]
fn a_controller_says_what_it_is() {
    let said = Arc::new(Mutex::new(None));
    let into = said.clone();
    let mut rig = doing(move |registers| *into.lock().unwrap() = Some(registers.identification()));
    rig.receive(1, &request(b'x', 0, 0));
    rig.to(run_at(ms(13)));
    let reference = config().reference;
    let expected = Identification {
        vendor: profile::VENDOR_NAME,
        vendor_id: profile::VENDOR_ID,
        reference: reference.name,
        product_id: reference.product_id(),
        firmware: profile::FIRMWARE_VERSION,
        serial_number: profile::SERIAL_NUMBER,
    };
    assert_eq!(said.lock().unwrap().take(), Some(expected));
}

/// Sends when the controller enters a state: its name at once, 5 ms later and 10 s later. Every 10 ms it wants to be called.
#[derive(Debug, Default)]
struct Announcer {
    due: Time,
    seen: Arc<Mutex<Seen>>,
}

#[derive(Debug, Default)]
struct Seen {
    /// Messages that waited when it was to enter a state.
    waited: Vec<usize>,
    /// When it was called.
    fired: Vec<Time>,
}

impl Endpoint for Announcer {
    fn enter(&mut self, now: Time, life: PortLife, outbox: &mut PortOutbox) {
        let PortLife::State(state) = life else { return };
        self.seen.lock().unwrap().waited.push(outbox.len());
        for wait in [0, 5, 10_000] {
            outbox.push(now + ms(wait), PortMessage::serial(state.name().as_bytes()).unwrap()).unwrap();
        }
    }

    fn receive(&mut self, _: Time, _: &PortEvent, _: &mut PortOutbox) {}

    fn next(&self) -> Time {
        self.due
    }

    fn fire(&mut self, now: Time, _: &mut PortOutbox) {
        self.seen.lock().unwrap().fired.push(now);
        self.due = now + ms(10);
    }

    fn work(&self) -> Option<Span> {
        None
    }

    fn step(&mut self, _: Time, _: &mut dyn RegisterAccess, _: &mut PortOutbox) {}
}

/// What waited is gone before the endpoint learns that there is no power, what it sends then goes nowhere, and its time does
/// not come until there is power again.
#[test]
fn without_power_an_endpoint_rests() {
    let announcer = Announcer::default();
    let seen = announcer.seen.clone();
    let mut rig = Rig::off(config(), half_load());
    assert!(rig.plc.attach_endpoint(0, Box::new(announcer)));
    rig.plc.commission(b"app", State::Running).unwrap();
    rig.power_on();
    rig.after(BOOT + ms(12));
    rig.power_off();
    rig.after(ms(100));
    rig.power_on();
    let (begun, again) = (run_at(Span::ZERO), rig.now + BOOT);
    rig.after(BOOT + ms(12));
    assert_eq!(rig.outputs(0), [begun, begun + ms(5), again, again + ms(5)]);
    // What was announced before the cut and not taken is gone, too.
    assert_eq!([0; 2].map(|_| bytes(rig.plc.take_output(0))), [b"RUNNING"; 2]);
    assert_eq!(rig.plc.take_output(0), None);
    let seen = seen.lock().unwrap();
    assert_eq!(seen.waited, [0; 5], "BOOTING, RUNNING, OFF, BOOTING, RUNNING");
    assert_eq!(seen.fired, [begun, begun + ms(10), again, again + ms(10)]);
}

/// controller:TR-02: INVALID_OS has no memory to show.
#[test]
fn without_firmware_memory_does_not_answer() {
    let done = Arc::new(Mutex::new(0));
    let count = done.clone();
    let mut rig = Rig::off(config(), half_load());
    let step: Step = Box::new(move |registers| {
        let none = Err(RegisterError::NoAnswer);
        assert_eq!(registers.read_registers(5, &mut [0]), none);
        assert_eq!(registers.write_registers(5, &[0]), none);
        assert_eq!(registers.read_bits(Area::Output, 0, &mut [false]), none);
        assert_eq!(registers.write_bits(Area::Output, 0, &[true]), none);
        *count.lock().unwrap() += 1;
    });
    assert!(rig.plc.attach_endpoint(0, Box::new(Doing { waiting: 0, step })));
    rig.plc.damage_firmware();
    rig.power_on();
    rig.after(BOOT + ms(1));
    assert_eq!(rig.plc.state(), State::InvalidOs);
    rig.receive(0, &request(b'x', 0, 0));
    rig.after(ms(1));
    assert_eq!(*done.lock().unwrap(), 1);
}
