//! The port itself: settings, bytes and their harm, silences, sending, breaks, counters, who holds it.

use std::fs::File;
use std::future::Future;
use std::process::{Command, Stdio};
use std::time::Duration;

use devices::{Lab, PATIENCE, SERIAL_A, SERIAL_B, Serial, wait_for};
use drivers::holders;
use drivers::serial::{
    MessageAssembler, MessageTiming, OpenError, PortSpec, Received, ReceivedMessage, SerialPort, Symbol,
};
use host::{HostInstant, Rs485};
use rustix::termios::{ControlModes, tcgetattr};
use signal::{Parity, SerialSettings, Span};

fn spec(port: Serial) -> PortSpec {
    PortSpec {
        path: port.path(),
        line: SerialSettings::default(),
        rs485: None,
        low_latency: None,
        exclusive: true,
    }
}

fn until() -> HostInstant {
    HostInstant::now() + Span::from_nanos(PATIENCE.as_nanos() as i64)
}

fn run<T>(test: impl Future<Output = T>) -> T {
    tokio::runtime::Builder::new_current_thread().enable_io().build().unwrap().block_on(test)
}

/// Receives so many symbols.
async fn symbols(port: &mut SerialPort, count: usize) -> Vec<Symbol> {
    let (mut all, mut received) = (Vec::new(), Received::with_room());
    while all.len() < count {
        assert!(port.receive(until(), &mut received).await.unwrap(), "no more came after {all:?}");
        all.extend_from_slice(&received.symbols);
    }
    all
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn every_byte_goes_over_the_line_as_it_is_at_any_speed() {
    let _lab = Lab::enter();
    run(async {
        for (baud, parity) in [(9_600, Parity::None), (19_200, Parity::Even), (12_345, Parity::Odd)] {
            let line = SerialSettings { baud, parity, ..SerialSettings::default() };
            let mut a = SerialPort::open(&PortSpec { line, ..spec(SERIAL_A) }).unwrap();
            let mut b = SerialPort::open(&PortSpec { line, ..spec(SERIAL_B) }).unwrap();
            let settings = tcgetattr(File::open(SERIAL_A.path()).unwrap()).unwrap();
            assert_eq!(settings.output_speed(), baud);
            let modes = settings.control_modes;
            assert_eq!(modes.contains(ControlModes::PARENB), parity != Parity::None);
            assert_eq!(modes.contains(ControlModes::PARODD), parity == Parity::Odd);
            let all: Vec<u8> = (0..=255).collect();
            let wanted: Vec<Symbol> = all.iter().copied().map(Symbol::Byte).collect();
            a.send(&all, until()).await.unwrap();
            assert_eq!(symbols(&mut b, all.len()).await, wanted);
            b.send(&all, until()).await.unwrap();
            assert_eq!(symbols(&mut a, all.len()).await, wanted);
        }
    });
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn the_kernel_drives_the_direction_of_a_transceiver_as_asked_or_it_is_refused() {
    let _lab = Lab::enter();
    run(async {
        let wanted = Rs485 {
            enabled: true,
            rts_on_send: true,
            rx_during_tx: true,
            delay_before: 2,
            delay_after: 1,
            ..Rs485::default()
        };
        let low = Rs485 { rts_on_send: false, rts_after_send: true, rx_during_tx: false, ..wanted };
        for wanted in [wanted, low, Rs485 { enabled: false, ..wanted }] {
            let mut a = SerialPort::open(&PortSpec { rs485: Some(wanted), ..spec(SERIAL_A) }).unwrap();
            let granted = host::rs485(&File::open(SERIAL_A.path()).unwrap()).unwrap();
            let off = Rs485::default();
            assert_eq!(granted, if wanted.enabled { wanted } else { off });
            // With delays around the direction bytes still come through, and the end of sending is seen.
            let mut b = SerialPort::open(&spec(SERIAL_B)).unwrap();
            let sending = a.send(b"request", until()).await.unwrap();
            let (earliest, latest) = a.drain(sending, until()).await.unwrap();
            assert!(sending.begun < earliest && earliest <= latest);
            assert_eq!(symbols(&mut b, 7).await, b"request".map(Symbol::Byte));
        }
        let far = Rs485 { delay_after: 250, ..wanted };
        let refused = SerialPort::open(&PortSpec { rs485: Some(far), ..spec(SERIAL_A) }).unwrap_err();
        let words = refused.to_string();
        assert!(words.contains("2 ms and 100 ms"), "{words}");
        SerialPort::open(&PortSpec { rs485: Some(Rs485::default()), ..spec(SERIAL_A) }).unwrap();
    });
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn low_latency_is_switched_on_and_off() {
    let _lab = Lab::enter();
    run(async {
        for wanted in [true, false] {
            let _port = SerialPort::open(&PortSpec { low_latency: Some(wanted), ..spec(SERIAL_A) }).unwrap();
            assert_eq!(host::low_latency(&File::open(SERIAL_A.path()).unwrap()).unwrap(), wanted);
        }
    });
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn breaks_and_damaged_bytes_are_distinguished_from_sound_ones_and_counted() {
    let _lab = Lab::enter();
    run(async {
        for parity in [Parity::None, Parity::Even] {
            let line = SerialSettings { parity, ..SerialSettings::default() };
            let mut a = SerialPort::open(&PortSpec { line, ..spec(SERIAL_A) }).unwrap();
            let before = a.counters().unwrap().unwrap();
            for harm in ["byte ff", "parity 41", "break", "frame ff", "byte 0"] {
                SERIAL_A.harm(harm);
            }
            let wanted = [
                Symbol::Byte(0xFF),
                Symbol::Damaged(0x41),
                Symbol::Break,
                Symbol::Damaged(0xFF),
                Symbol::Byte(0),
            ];
            assert_eq!(symbols(&mut a, wanted.len()).await, wanted);
            SERIAL_A.harm("overrun");
            let after = a.counters().unwrap().unwrap();
            let more = |one: fn(&host::LineCounters) -> u32| one(&after).wrapping_sub(one(&before));
            let counted = [
                more(|all| all.parity),
                more(|all| all.breaks),
                more(|all| all.frame),
                more(|all| all.overrun),
                more(|all| all.received),
            ];
            assert_eq!(counted, [1, 1, 1, 1, 2]);
        }
    });
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn silence_ends_messages_and_what_may_be_two_is_said_to_be() {
    let _lab = Lab::enter();
    run(async {
        let mut a = SerialPort::open(&spec(SERIAL_A)).unwrap();
        let mut b = SerialPort::open(&spec(SERIAL_B)).unwrap();
        let mut assembler = MessageAssembler::new(MessageTiming::modbus_rtu(a.line()));
        let mut room = Received::with_room();
        let requests: [&[u8]; 3] = [b"\x11\x03\x00\x6B\x00\x03\x76\x87", b"\xFF\xFF\x00", b"x"];
        for request in requests {
            b.send(request, until()).await.unwrap();
            assert_eq!(whole(&mut a, &mut assembler, &mut room, request.len()).await, request);
        }
        let nothing = |received: &ReceivedMessage| panic!("{received:?}");
        // The sender goes on before anybody has looked: nothing says that these were two.
        b.send(b"one", until()).await.unwrap();
        assert!(a.receive(until(), &mut room).await.unwrap());
        assembler.take(&room, nothing);
        let late = room.read + a.line().frame_gap() * 20;
        wait_for("time to pass", PATIENCE, || HostInstant::now() >= late);
        b.send(b"two", until()).await.unwrap();
        let port = File::open(SERIAL_A.path()).unwrap();
        wait_for("more to be there", PATIENCE, || rustix::io::ioctl_fionread(&port).unwrap() == 3);
        let mut got = room.symbols.len();
        while got < 6 {
            assert!(a.receive(until(), &mut room).await.unwrap());
            got += room.symbols.len();
            assembler.take(&room, nothing);
        }
        let message = assembler.quiet(HostInstant::NEVER).unwrap().message;
        assert_eq!((message.data(), message.doubtful), (&b"onetwo"[..], true));
        assert!(!a.messages(&mut assembler, HostInstant::now(), &mut room, nothing).await.unwrap());
    });
}

/// So many bytes. An emulated line may pause between them for longer than a real one does.
async fn whole(
    port: &mut SerialPort,
    assembler: &mut MessageAssembler,
    room: &mut Received,
    count: usize,
) -> Vec<u8> {
    let mut all = Vec::new();
    while all.len() < count {
        let each = |received: &ReceivedMessage| all.extend_from_slice(received.message.data());
        assert!(port.messages(assembler, until(), room, each).await.unwrap());
    }
    all
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn sending_ends_when_the_last_bit_has_left_or_when_it_is_given_up() {
    let _lab = Lab::enter();
    run(async {
        let mut a = SerialPort::open(&spec(SERIAL_A)).unwrap();
        SERIAL_A.stuck(true);
        let sending = a.send(b"never", until()).await.unwrap();
        let given_up = a.drain(sending, HostInstant::now() + Span::from_millis(30)).await.unwrap_err();
        assert_eq!(given_up.errno, host::Errno::TIMEDOUT);
        SERIAL_A.stuck(false);
        let (earliest, latest) = a.drain(sending, until()).await.unwrap();
        assert!(earliest >= sending.begun + a.line().lasts(5) && latest >= earliest);
        let begun = HostInstant::now();
        a.send_break(Span::from_millis(5), until()).await.unwrap();
        assert!(begun.elapsed() >= Span::from_millis(5));
    });
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_port_is_the_rigs_alone_and_its_holder_is_named() {
    let _lab = Lab::enter();
    run(async {
        let port = SERIAL_A.path();
        let device = std::fs::canonicalize(&port).unwrap();
        // Somebody reads from it, without any lock.
        let from = File::open(&port).unwrap();
        let mut reader = Command::new("sleep").arg("100").stdin(Stdio::from(from)).spawn().unwrap();
        wait_for("the reader to be there", PATIENCE, || {
            holders(&port).iter().any(|holder| holder.process == reader.id() && holder.name == "sleep")
        });
        let refused = SerialPort::open(&spec(SERIAL_A)).unwrap_err();
        assert_eq!(refused, OpenError::Busy(port.clone()));
        // Whoever shares has nothing against it.
        drop(SerialPort::open(&PortSpec { exclusive: false, ..spec(SERIAL_A) }).unwrap());
        reader.kill().unwrap();
        reader.wait().unwrap();
        // Two paths lead to one port.
        let _held = SerialPort::open(&spec(SERIAL_A)).unwrap();
        let other = SerialPort::open(&PortSpec { path: device.clone(), ..spec(SERIAL_A) }).unwrap_err();
        assert_eq!(other, OpenError::Busy(device));
        assert!(holders(&port).is_empty(), "this process does not count");
    });
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_port_whose_driver_goes_away_ends_every_wait() {
    let _lab = Lab::enter();
    run(async {
        let mut a = SerialPort::open(&spec(SERIAL_A)).unwrap();
        let unplugging = std::thread::spawn(|| {
            // While the other side waits.
            std::thread::sleep(Duration::from_millis(20));
            SERIAL_A.unplug()
        });
        let error = a.receive(until(), &mut Received::with_room()).await.unwrap_err();
        assert!(error.is_gone(), "{error}");
        let unplugged = unplugging.join().unwrap();
        assert!(a.send(b"x", until()).await.unwrap_err().is_gone());
        drop(a);
        // What is left of the port is no port.
        let left = SerialPort::open(&spec(SERIAL_A)).unwrap_err();
        assert!(left.is_gone(), "{left}");
        drop(unplugged);
        let mut a = SerialPort::open(&spec(SERIAL_A)).unwrap();
        let mut b = SerialPort::open(&spec(SERIAL_B)).unwrap();
        b.send(b"again", until()).await.unwrap();
        assert_eq!(symbols(&mut a, 5).await, b"again".map(Symbol::Byte));
    });
}
