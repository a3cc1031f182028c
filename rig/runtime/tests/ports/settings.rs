//! Settings of a serial line by the endpoint at its port: what an application configures.

use super::{BOUND, Bench, ENDS, LINE, PARTNER, SETTINGS, SL1, ms, start};
use controller::{Endpoint, PortEvent, PortLife, PortMessage, PortOutbox, RegisterAccess};
use drivers::BoardError;
use scanrig_runtime::executor::rig_fault::RigFault;
use signal::{Parity, SerialOutput, SerialSettings, Span, Time};

/// When communication starts it says `1` as its line is, and `2` with other settings. What it hears it says again.
#[derive(Debug)]
struct Changing(SerialSettings);

impl Endpoint for Changing {
    fn enter(&mut self, now: Time, life: PortLife, outbox: &mut PortOutbox) {
        if life != PortLife::Restarted {
            return;
        }
        let (line, at) = (self.0, now + ms(10));
        outbox.push(now, PortMessage::serial(b"1").unwrap()).unwrap();
        outbox.push(at, PortMessage::Settings { line, message_gap: line.frame_gap() }).unwrap();
        outbox.push(at, PortMessage::serial(b"2").unwrap()).unwrap();
    }

    fn receive(&mut self, now: Time, event: &PortEvent, outbox: &mut PortOutbox) {
        assert_ne!(*event, PortEvent::NotSent);
        if let PortEvent::Serial(message) = event
            && message.is_sound()
        {
            outbox.push(now, PortMessage::serial(message.data()).unwrap()).unwrap();
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

fn with(settings: SerialSettings) -> Bench {
    let mut bench = Bench::new("", BOUND, ENDS);
    assert!(bench.model.attach_endpoint(SL1, Box::new(Changing(settings))));
    bench
}

/// The partner keeps the settings of the file: it hears `1`, and nothing sound from then on. What it says is not understood
/// either.
#[test]
fn ends_that_disagree_do_not_understand_each_other() {
    let other = SerialSettings { baud: 9_600, parity: Parity::Odd, ..SETTINGS };
    for (settings, understood) in [(SETTINGS, true), (other, false)] {
        let mut bench = with(settings).says(start() + ms(100), SerialOutput::plain(b"xyz"));
        assert_eq!(bench.run().fault, None);
        let sound: Vec<_> = bench.received(PARTNER).into_iter().filter(|got| got.is_sound()).collect();
        let said = |bytes: &[u8]| sound.iter().any(|got| got.data() == bytes);
        assert_eq!((said(b"1"), said(b"2"), said(b"xyz")), (true, understood, understood), "{settings}");
        let status = bench.model.controller().port_status(SL1).unwrap();
        assert_eq!(status.sent, 2 + u64::from(understood), "settings are no message");
    }
}

#[test]
fn settings_that_a_line_refuses_are_a_fault_of_the_case() {
    let fault = with(SerialSettings { data_bits: 9, ..SETTINGS }).run().fault;
    let refused = |fault: &RigFault| matches!(fault, RigFault::PortNotSent { bus, error: BoardError::BadSettings(LINE), .. } if bus == "line");
    assert!(fault.as_ref().is_some_and(refused), "{fault:?}");
}
