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
    rig.to(run_at(ms(60)));
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
    assert_eq!(rig.plc.port_status(0).map(|status| (status.received, status.discarded)), Some((1, 1)));
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
