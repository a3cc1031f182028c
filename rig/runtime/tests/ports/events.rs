//! What a bus reports, as the endpoint at its port gets it: intervals, errors, order, and too much of it.

use super::{BOUND, Bench, CAN_1, ENDS, LINE, SL1, ms, start};
use controller::{Endpoint, PortEvent, PortLife, PortOutbox, RegisterAccess};
use drivers::{BusError, BusEvent, BusId, BusState, LossReason};
use scanrig_runtime::executor::rig_fault::RigFault;
use signal::{CanFrame, SerialMessage, Span, Time, When};
use std::sync::{Arc, Mutex};

const CAN: BusId = BusId(3);

type Heard = Arc<Mutex<Vec<(Time, PortEvent)>>>;

/// Notes what comes.
#[derive(Debug)]
struct Listener(Heard);

impl Endpoint for Listener {
    fn enter(&mut self, _: Time, _: PortLife, _: &mut PortOutbox) {}

    fn receive(&mut self, now: Time, event: &PortEvent, _: &mut PortOutbox) {
        self.0.lock().unwrap().push((now, *event));
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

/// A case whose board reports this, each at its instant, with a listener at this port.
fn reporting(port: usize, reports: impl IntoIterator<Item = (Time, BusEvent)>) -> (Bench, Heard) {
    let heard = Heard::default();
    let mut bench = Bench::new("", BOUND, ENDS);
    assert!(bench.model.attach_endpoint(port, Box::new(Listener(heard.clone()))));
    bench.world.lock().unwrap().reports.extend(reports);
    (bench, heard)
}

fn within(at: Time, micros: i64) -> When {
    When::within(at, at + Span::from_micros(micros))
}

/// As of a real line, where nothing is known to the nanosecond: the interval is the endpoint's, and it gets the event when all
/// of it is over.
#[test]
fn instants_are_handed_on_with_their_intervals() {
    let at = start() + ms(50);
    let mut message = SerialMessage::of(within(at, 40), within(at + ms(1), 70), b"12");
    message.errors.parity = 1;
    let frame = CanFrame::classic(0x181, false, &[1]).unwrap();
    let (first, last) = (within(at + ms(5), 40), within(at + ms(6), 90));
    let sent = SerialMessage::of(first, last, b"3");
    let reports = [
        (at, BusEvent::SerialMessage { bus: LINE, message, own: false }),
        (at + ms(5), BusEvent::SerialMessage { bus: LINE, message: sent, own: true }),
    ];
    let (mut bench, heard) = reporting(SL1, reports);
    assert_eq!(bench.run().fault, None);
    let got =
        [(message.last.latest, PortEvent::Serial(message)), (last.latest, PortEvent::Sent { at: last })];
    assert_eq!(*heard.lock().unwrap(), got);

    let when = within(at, 30);
    let of = |own| BusEvent::CanFrame { bus: CAN, at: when, frame, own };
    let (mut bench, heard) = reporting(CAN_1, [(at, of(false)), (at, of(true))]);
    assert_eq!(bench.run().fault, None);
    let events = [PortEvent::Can { at: when, frame }, PortEvent::Sent { at: when }];
    assert_eq!(*heard.lock().unwrap(), events.map(|event| (when.latest, event)));
}

#[test]
fn what_happens_to_a_bus_is_known_at_its_port() {
    let at = start() + ms(50);
    let (bus, reason) = (CAN, LossReason::Injected);
    let events = [
        (
            BusEvent::State { bus, at, state: BusState::ErrorPassive },
            PortEvent::State(BusState::ErrorPassive),
        ),
        (BusEvent::Error { bus, at, error: BusError::SendTimeout }, PortEvent::Error(BusError::SendTimeout)),
        (BusEvent::Lost { bus, at, reason }, PortEvent::Lost),
        (BusEvent::Returned { bus, at }, PortEvent::Returned),
        (BusEvent::Dropped { bus, at, count: 3 }, PortEvent::Missed(3)),
    ];
    let (mut bench, heard) = reporting(CAN_1, events.map(|(event, _)| (at, event)));
    let fault = bench.run().fault;
    assert!(matches!(fault, Some(RigFault::BusDropped { count: 3, .. })), "{fault:?}");
    assert_eq!(*heard.lock().unwrap(), events.map(|(_, event)| (at, event)));
}

/// Another bus may report something earlier later.
#[test]
fn events_come_in_the_order_of_their_instants() {
    let at = start() + ms(50);
    let frame = |id| CanFrame::classic(id, false, &[]).unwrap();
    let of = |id, millis| {
        let when = When::exactly(at + ms(millis));
        BusEvent::CanFrame { bus: CAN, at: when, frame: frame(id), own: false }
    };
    let reports = [(at, of(3, 9)), (at + ms(1), of(1, 2)), (at + ms(3), of(2, 9))];
    let (mut bench, heard) = reporting(CAN_1, reports);
    assert_eq!(bench.run().fault, None);
    let ids = |(now, event): &(Time, PortEvent)| match event {
        PortEvent::Can { frame: got, .. } => (*now - at, [1, 2, 3].into_iter().find(|id| *got == frame(*id))),
        other => panic!("{other:?}"),
    };
    let got: Vec<_> = heard.lock().unwrap().iter().map(ids).collect();
    assert_eq!(got, [(ms(2), Some(1)), (ms(9), Some(3)), (ms(9), Some(2))]);
}

/// More than the queue between bus and port holds is a fault of the case, not a silence.
#[test]
fn too_many_events_at_once_are_a_fault() {
    let at = start() + ms(50);
    let frame = CanFrame::classic(1, false, &[]).unwrap();
    let event = BusEvent::CanFrame { bus: CAN, at: When::exactly(at), frame, own: false };
    let (mut bench, heard) = reporting(CAN_1, vec![(at, event); 1_025]);
    let fault = bench.run().fault;
    assert!(matches!(&fault, Some(RigFault::BusDropped { bus, count: 1, .. }) if bus == "can"), "{fault:?}");
    assert_eq!(heard.lock().unwrap().len(), 1_024);
}
