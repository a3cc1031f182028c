//! An endpoint of the controller at a serial line of this machine, on the host's clock. The line is a pseudo-terminal: bytes
//! and a far end that can go away, but no bits.

use super::{Bench, Reported, SL1, Seen, World};
use crate::texts::Texts;
use controller::State;
use drivers::{BoardContext, LossReason};
use host::Realtime;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use scanrig_runtime::executor::ExecutorReport;
use scanrig_runtime::executor::clock::HostClock;
use scanrig_runtime::executor::rig_fault::RigFault;
use signal::Span;
use std::fs::File;
use std::io::{Read, Write};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// How long the partner waits for anything.
const PATIENCE: Duration = Duration::from_secs(30);

/// What the partner writes into %MW9 has the plan act on the controller.
const STOP: u8 = 1;
const RUN: u8 = 2;
const CUT: u8 = 3;
const END: u8 = 4;

const STEPS: &str = r#"
{ id = "stop", when = { signal = "word", becomes = 1, within = "100 s" }, command = "stop" },
{ id = "run", when = { signal = "word", becomes = 2, within = "100 s" }, command = "run" },
{ id = "cut", when = { signal = "word", becomes = 3, within = "100 s" }, mark = {} },
{ id = "off", at = "cut + 200 ms", power-cut = { duration = "300 ms" } },
{ id = "last", when = { signal = "word", becomes = 4, from = "start", within = "100 s" }, mark = {} },
"#;

/// The partner at the far end of the line.
struct Partner {
    far: File,
    /// The near end, to see what nobody took yet.
    near: File,
    reported: Seen,
}

impl Partner {
    fn reported(&self) -> Reported {
        *self.reported.lock().unwrap()
    }

    fn until(&self, what: &str, holds: impl Fn(Reported) -> bool) {
        let due = Instant::now() + PATIENCE;
        while !holds(self.reported()) {
            assert!(Instant::now() < due, "{what}: {:?}", self.reported());
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    fn says(&mut self, bytes: &[u8]) {
        self.far.write_all(bytes).unwrap();
    }

    /// The rig took all that was said.
    fn is_heard(&self) {
        let due = Instant::now() + PATIENCE;
        while rustix::io::ioctl_fionread(&self.near).unwrap() > 0 {
            assert!(Instant::now() < due, "nobody takes it");
            std::thread::yield_now();
        }
    }

    /// What comes next, byte for byte.
    fn hears(&mut self, expected: &[u8]) {
        let mut heard = Vec::new();
        while heard.len() < expected.len() {
            let wait = Timespec { tv_sec: PATIENCE.as_secs() as i64, tv_nsec: 0 };
            let ready = poll(&mut [PollFd::new(&self.far, PollFlags::IN)], Some(&wait)).unwrap();
            assert!(ready > 0, "{heard:02X?} came of {expected:02X?}");
            let mut room = [0; 64];
            let count = self.far.read(&mut room).unwrap();
            heard.extend_from_slice(&room[..count]);
        }
        assert_eq!(heard, expected);
    }

    fn asks(&mut self, request: &[u8], answer: &[u8]) {
        self.says(request);
        self.hears(answer);
    }

    /// Writes %MW9.
    fn orders(&mut self, value: u8) {
        self.asks(&[9, 0, 0, value], &[0]);
    }

    /// Has the case end, which answers no more. The line stays until it has.
    fn ends(mut self) -> Option<Partner> {
        self.says(&[9, 0, 0, END]);
        Some(self)
    }
}

/// Runs a case at a line with this message gap while the partner does its part, which hands back its end of the line unless
/// it goes away.
fn with_partner(
    gap: &str,
    part: impl FnOnce(Partner) -> Option<Partner> + Send,
) -> (ExecutorReport, Reported) {
    let far = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
    grantpt(&far).unwrap();
    unlockpt(&far).unwrap();
    let path = ptsname(&far, Vec::new()).unwrap().into_string().unwrap();
    let board = format!(
        "format = 1\n[board]\nkind = \"real\"\nunresponsive-after = \"20 s\"\n[buses]\n\
         line = {{ kind = \"serial\", path = \"{path}\", exclusive = false, message-gap = \"{gap}\" }}\n\
         [ports]\nSL1 = \"line\"\n"
    );
    let plan = format!(
        "format = 1\ntitle = \"Requests\"\nprogram = \"program.st\"\nboard = \"board.toml\"\n\
         signals = {{ word = \"%MW9\" }}\nends = \"last\"\ntimeout = \"120 s\"\n\
         steps = [{STEPS}]\nexpect = [{{ state = {{ is = \"RUNNING\", when = \"start\" }} }}]\n"
    );
    let files = [("plan.toml", &*plan), ("program.st", super::PROGRAM), ("board.toml", &*board)];
    let texts = Texts(&files);
    let (loaded, jobs) = texts.load(1);
    let case = loaded.plan.case(jobs[0].case).unwrap();
    let file = loaded.files(&case, &jobs[0]).unwrap().board;
    let context = BoardContext::new(Realtime::default());
    let board = drivers::open(&file, &context).unwrap_or_else(|found| panic!("{found:#?}")).unwrap();
    let (model, mut parts) = texts.parts(1);
    parts.board = board;
    // How punctual this machine is, is not the subject.
    parts.late = Span::from_secs(100);
    let world = Arc::new(Mutex::new(World::default()));
    let mut bench = Bench { model, parts, world, reported: Seen::default() }.attach(SL1, None);
    let reported = bench.reported.clone();
    let partner = Partner { far: File::from(far), near: File::open(path).unwrap(), reported };
    let ran = std::thread::scope(|scope| {
        let part = scope.spawn(|| {
            partner.until("RUNNING", |reported| reported.state == Some(State::Running));
            part(partner)
        });
        let ran = bench.parts.run(&mut HostClock::of(&context), &mut bench.model);
        let parted = part.join();
        assert!(parted.is_ok(), "the partner gave up; the case ended at {} with {:?}", ran.end, ran.fault);
        ran
    });
    (ran, bench.reported())
}

/// In RUNNING, in STOPPED, and again after a power cut that comes while a request waits for the processor.
#[test]
fn a_partner_is_answered_in_every_state_and_after_a_power_cut() {
    let (ran, reported) = with_partner("20 ms", |mut partner| {
        partner.asks(&[5, 2], &[0x12, 0x34, 0, 0]);
        partner.orders(STOP);
        partner.until("STOPPED", |reported| reported.state == Some(State::Stopped));
        partner.asks(&[5, 1], &[0x12, 0x34]);
        partner.orders(RUN);
        partner.until("RUNNING", |reported| reported.state == Some(State::Running));
        partner.orders(CUT);
        // It waits for the processor when the supply goes, unless this machine stands still for longer than that.
        partner.says(&super::ENDLESS);
        partner.until("another start", |reported| {
            reported.starts == 2 && reported.state == Some(State::Running)
        });
        // Nothing of what was under way comes before it.
        partner.asks(&[5, 1], &[0x12, 0x34]);
        partner.ends()
    });
    assert_eq!(ran.fault, None);
    assert_eq!((reported.damaged, reported.not_sent), (0, 0));
}

/// The second piece is said when the first one was taken, and the line was not silent for the message gap between them.
#[test]
fn a_request_in_two_pieces_is_one_request() {
    let (ran, reported) = with_partner("1 s", |mut partner| {
        partner.says(&[5]);
        partner.is_heard();
        partner.says(&[2]);
        partner.hears(&[0x12, 0x34, 0, 0]);
        partner.ends()
    });
    assert_eq!((ran.fault, reported.requests), (None, 2));
}

#[test]
fn a_far_end_that_is_gone_is_a_fault_of_the_rig() {
    let (ran, _) = with_partner("20 ms", |mut partner| {
        partner.asks(&[5, 1], &[0x12, 0x34]);
        None
    });
    let gone = |fault: &RigFault| matches!(fault, RigFault::BusLost { bus, reason: LossReason::Gone, .. } if bus == "line");
    assert!(ran.fault.as_ref().is_some_and(gone), "{:?}", ran.fault);
}
