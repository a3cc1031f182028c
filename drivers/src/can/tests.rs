//! The thread of a bus and its board on a port that does what a test says.

use std::collections::VecDeque;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::sync::{Arc, Condvar, Mutex};
use std::time::{Duration, Instant};

use host::{Bell, Errno, Realtime, ReceivedDatagram, TimeBase};
use rustix::event::{EventfdFlags, eventfd};
use signal::{CanFrame, Span};

use super::adapter::{Adapter, Change};
use super::node::Node;
use super::port::CanPort;
use super::shared::{REPORTS, ThreadConfig};
use super::spec::CanBusSpec;
use super::wire::{FD, encode};
use crate::{BoardError, BusError, BusEvent, BusId, BusState, LossReason};

/// How long a condition is waited for.
const PATIENCE: Duration = Duration::from_secs(20);

/// What a port does, and what was done to it.
#[derive(Debug, Default)]
struct Script {
    /// Datagrams to be received.
    arrive: VecDeque<(Vec<u8>, ReceivedDatagram)>,
    /// Answers to calls that send; OK where there is none.
    answers: VecDeque<Errno>,
    /// Calls that send hang.
    hang: bool,
    sent: Vec<Vec<u8>>,
}

#[derive(Debug)]
struct Scripted {
    script: Arc<(Mutex<Script>, Condvar)>,
    source: OwnedFd,
}

impl CanPort for Scripted {
    fn receive(&mut self, into: &mut [u8; FD]) -> Result<ReceivedDatagram, Errno> {
        let (bytes, received) = self.script.0.lock().unwrap().arrive.pop_front().ok_or(Errno::AGAIN)?;
        into[..bytes.len()].copy_from_slice(&bytes);
        Ok(ReceivedDatagram { len: bytes.len(), ..received })
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), Errno> {
        let mut script = self.script.0.lock().unwrap();
        while script.hang {
            script = self.script.1.wait(script).unwrap();
        }
        if let Some(error) = script.answers.pop_front() {
            return Err(error);
        }
        script.sent.push(bytes.to_vec());
        Ok(())
    }

    fn source(&self) -> BorrowedFd<'_> {
        self.source.as_fd()
    }
}

/// An interface that stays.
#[derive(Debug)]
struct Fixed;

impl Adapter for Fixed {
    fn open(&mut self) -> std::io::Result<(Box<dyn CanPort>, BusState)> {
        Err(Errno::NODEV.into())
    }

    fn state(&mut self) -> Option<BusState> {
        Some(BusState::ErrorPassive)
    }

    fn change(&mut self) -> Change {
        Change::None
    }

    fn source(&self) -> Option<BorrowedFd<'_>> {
        None
    }

    fn restarts_after(&self) -> Option<Span> {
        None
    }

    fn restart(&mut self) -> std::io::Result<()> {
        Ok(())
    }

    fn put_back(&mut self) {}
}

struct Bench {
    node: Node,
    time: TimeBase,
    script: Arc<(Mutex<Script>, Condvar)>,
    events: Vec<BusEvent>,
}

const BUS: BusId = BusId(0);

impl Bench {
    fn new(unresponsive_after: Span) -> Bench {
        let script = Arc::new((Mutex::default(), Condvar::new()));
        let source = eventfd(0, EventfdFlags::CLOEXEC).unwrap();
        let port = Box::new(Scripted { script: script.clone(), source });
        let limit = unresponsive_after;
        let config = ThreadConfig {
            resolution: Span::ZERO,
            limit,
            patience: limit,
            reconnect: false,
            realtime: Realtime::default(),
        };
        let spec = CanBusSpec {
            bus: BUS,
            name: "bus".into(),
            place: 0..0,
            interface_place: 0..0,
            interface: "can0".into(),
            bitrate: 500_000,
            sample_point: None,
            data_bitrate: None,
            data_sample_point: None,
            accept: Vec::new(),
            restart: None,
            listen_only: false,
            configure: false,
        };
        let mut bench = Bench {
            node: Node::start(spec, Box::new(Fixed), port, &Arc::new(Bell::new()), config).unwrap(),
            time: TimeBase::start(),
            script,
            events: Vec::new(),
        };
        bench.start();
        bench
    }

    fn start(&mut self) {
        let start = self.node.ask_start();
        let due = host::HostInstant::now() + Span::from_nanos(PATIENCE.as_nanos() as i64);
        assert!(self.node.await_start(start, due), "it never starts");
        self.events.clear();
    }

    fn change(&self, how: impl FnOnce(&mut Script)) {
        how(&mut self.script.0.lock().unwrap());
        self.script.1.notify_all();
    }

    fn arrives(&self, bytes: &[u8], received: ReceivedDatagram) {
        self.change(|script| script.arrive.push_back((bytes.to_vec(), received)));
        self.node.shared.ask();
    }

    fn send(&mut self, id: u32) -> Result<(), BoardError> {
        self.node.send(host::HostInstant::now(), &frame(id))
    }

    fn until(&mut self, what: &str, holds: impl Fn(&Bench) -> bool) {
        let due = Instant::now() + PATIENCE;
        loop {
            let now = self.time.now();
            self.node.poll(&self.time, now, &mut self.events);
            if holds(self) {
                return;
            }
            assert!(Instant::now() < due, "never: {what}; {:?}", self.events);
            std::thread::yield_now();
        }
    }

    fn reported(&self, suits: impl Fn(&BusEvent) -> bool) -> bool {
        self.events.iter().any(suits)
    }
}

fn frame(id: u32) -> CanFrame {
    CanFrame::classic(id, false, &[]).unwrap()
}

fn bytes(id: u32) -> Vec<u8> {
    let (bytes, len) = encode(&frame(id)).unwrap();
    bytes[..len].to_vec()
}

#[test]
fn frames_that_the_kernel_has_no_room_for_are_offered_again_in_their_order() {
    let mut bench = Bench::new(Span::from_secs(60));
    bench.change(|script| script.answers = [Errno::NOBUFS, Errno::AGAIN, Errno::NOBUFS].into());
    for id in 1..=3 {
        bench.send(id).unwrap();
    }
    bench.until("three frames", |bench| bench.script.0.lock().unwrap().sent.len() == 3);
    assert_eq!(bench.script.0.lock().unwrap().sent, [bytes(1), bytes(2), bytes(3)]);
    assert_eq!(bench.node.failed(), 0);
}

#[test]
fn a_call_that_hangs_makes_the_bus_silent_until_it_ends() {
    let mut bench = Bench::new(Span::from_millis(50));
    bench.change(|script| script.hang = true);
    let asked = bench.time.now();
    bench.send(1).unwrap();
    let silent = |event: &BusEvent| matches!(event, BusEvent::Lost { reason: LossReason::Unresponsive, .. });
    bench.until("silence", |bench| bench.reported(silent));
    let reported = bench.events.iter().find(|event| silent(event)).unwrap().latest();
    // The call counts from the turn of the device that it is part of, which may have begun a moment before.
    assert!(reported >= asked + Span::from_millis(40), "asked at {asked}, reported at {reported}");
    assert!(!bench.reported(|event| matches!(event, BusEvent::Returned { .. })));
    bench.change(|script| script.hang = false);
    bench.until("the return", |bench| bench.reported(|event| matches!(event, BusEvent::Returned { .. })));
    assert_eq!(bench.script.0.lock().unwrap().sent, [bytes(1)]);
}

#[test]
fn the_board_fills_its_queue_while_a_call_hangs_and_waits_for_nothing() {
    let mut bench = Bench::new(Span::from_secs(60));
    bench.change(|script| script.hang = true);
    let mut taken = 0;
    let refused = loop {
        match bench.send(taken % 0x700) {
            Ok(()) => taken += 1,
            Err(error) => break error,
        }
        assert!(taken < 100_000, "the queue has no end");
    };
    assert_eq!(refused, BoardError::BusFull(BUS));
    bench.change(|script| script.hang = false);
    bench.until("all of them", |bench| bench.script.0.lock().unwrap().sent.len() == taken as usize);
}

#[test]
fn frames_that_were_lost_on_their_way_are_counted() {
    let mut bench = Bench::new(Span::from_secs(60));
    bench.arrives(&bytes(1), ReceivedDatagram { dropped: 0, ..ReceivedDatagram::default() });
    bench.arrives(&bytes(2), ReceivedDatagram { dropped: 5, ..ReceivedDatagram::default() });
    // Nothing that a kernel writes.
    bench.arrives(&[0; 7], ReceivedDatagram { dropped: 5, ..ReceivedDatagram::default() });
    let frames = |bench: &Bench| {
        bench.events.iter().filter(|event| matches!(event, BusEvent::CanFrame { .. })).count()
    };
    bench.until("both frames and the loss", |bench| frames(bench) == 2 && bench.node.dropped == 6);
    assert!(bench.reported(|event| matches!(event, BusEvent::Dropped { count: 5, .. })));
}

/// On several processors the kernel hands over what their interrupts bring in any order.
#[test]
fn frames_come_in_the_order_of_their_stamps() {
    let mut bench = Bench::new(Span::from_secs(60));
    bench.change(|script| {
        for (id, wall) in [(1, 1_000_000), (3, 3_000_000), (2, 2_000_000), (4, 4_000_000)] {
            script
                .arrive
                .push_back((bytes(id), ReceivedDatagram { wall: Some(wall), ..ReceivedDatagram::default() }));
        }
    });
    bench.node.shared.ask();
    let ids = |bench: &Bench| -> Vec<u32> {
        let id = |event: &BusEvent| match event {
            BusEvent::CanFrame { frame, .. } => Some(frame.id),
            _ => None,
        };
        bench.events.iter().filter_map(id).collect()
    };
    bench.until("all of them", |bench| ids(bench).len() == 4);
    assert_eq!(ids(&bench), [1, 2, 3, 4]);
}

#[test]
fn a_run_begins_whatever_was_left_unread_before() {
    let mut bench = Bench::new(Span::from_secs(60));
    bench.change(|script| {
        script.arrive.extend((0..20_000).map(|id| (bytes(id % 0x700), ReceivedDatagram::default())));
    });
    bench.node.shared.ask();
    let due = Instant::now() + PATIENCE;
    while bench.node.reports.slots() < REPORTS {
        assert!(Instant::now() < due, "the queue is never full");
        std::thread::yield_now();
    }
    bench.start();
    bench.change(|script| script.arrive.clear());
    bench.arrives(&bytes(0x7FF), ReceivedDatagram { own: true, ..ReceivedDatagram::default() });
    bench.until("the frame of the run", |bench| {
        bench.reported(
            |event| matches!(event, BusEvent::CanFrame { frame, own: true, .. } if frame.id == 0x7FF),
        )
    });
    // How the controller took part is reported first.
    let first = bench.events.first();
    assert!(matches!(first, Some(BusEvent::State { state: BusState::ErrorPassive, .. })), "{first:?}");
}

#[test]
fn a_frame_that_waits_for_the_bus_for_too_long_is_told_once() {
    let mut bench = Bench::new(Span::from_millis(100));
    bench.send(1).unwrap();
    let late = |event: &BusEvent| matches!(event, BusEvent::Error { error: BusError::SendTimeout, .. });
    bench.until("the error", |bench| bench.reported(late));
    bench.arrives(&bytes(1), ReceivedDatagram { own: true, ..ReceivedDatagram::default() });
    bench.until("the own frame", |bench| {
        bench.reported(|event| matches!(event, BusEvent::CanFrame { own: true, .. }))
    });
    assert_eq!(bench.events.iter().filter(|event| late(event)).count(), 1);
}

#[test]
fn a_run_is_told_of_frames_of_the_one_before_that_still_wait_for_the_bus() {
    let mut bench = Bench::new(Span::from_millis(100));
    bench.send(1).unwrap();
    bench.until("the frame", |bench| bench.script.0.lock().unwrap().sent.len() == 1);
    bench.start();
    assert!(bench.node.is_behind());
    // Nothing is sent in this run, which could not tell the frame from its own.
    let late = |event: &BusEvent| matches!(event, BusEvent::Error { error: BusError::SendTimeout, .. });
    bench.until("the error", |bench| bench.reported(late));
    bench.arrives(&bytes(1), ReceivedDatagram { own: true, ..ReceivedDatagram::default() });
    bench.until("the frame on the bus", |bench| {
        bench.reported(|event| matches!(event, BusEvent::CanFrame { own: true, .. }))
    });
    bench.start();
    assert!(!bench.node.is_behind());
}
