//! A long commissioning in stepped time: clients come and go, force, trend, run plans, forget to read, break off. The rig stays as large
//! as it was, and serves everybody.

use crate::project_folder::TestProject;
use crate::stepped_rig::SteppedRig;
use control::{
    Advanced, ControlClient, ControllerAction, Done, Forces, PlanEvent, RequestOperation, SignalValues,
    Status, Subscribed, SubscriptionEvent, Topic, WireValue,
};
use signal::Value;
use std::io::Write;
use std::os::unix::net::UnixStream;
use std::time::{Duration, Instant};

const BOARD: &str = "format = 1
[board]
kind = \"simulated\"
[channels]
pressure = { kind = \"analog\", unit = \"bar\" }
[[plants]]
kind = \"lag\"
name = \"tank\"
input = \"Q1\"
output = \"pressure\"
low = 0
high = \"6 bar\"
tau = \"1 s\"
sample = \"10 ms\"
";

const PROGRAM: &str = "PROGRAM MAIN
VAR
    button AT %IX0.0 : BOOL;
    lamp AT %QX0.0 : BOOL;
    valve AT %QX0.1 : BOOL;
    count : DINT;
    preset : DINT;
END_VAR
count := count + 1;
lamp := button;
valve := (count / 50) MOD 2 = 0;
END_PROGRAM
";

const PATIENCE: Duration = Duration::from_secs(60);

/// A second of the rig's time.
const SECOND: i64 = 1_000_000_000;

/// Rounds of a second each until the rig has everything that it keeps: its log is full, for one.
const WARM: u32 = 120;
/// Rounds in all: ten minutes.
const ROUNDS: u32 = 600;

/// What the rig may grow by in 8 minutes: an allocator keeps pages at its own will, half a MiB within an hour. A leak of a
/// few bytes for each change that is sent meanwhile would be seen.
const SLACK: u64 = 1024 * 1024;

/// What the kernel says of the rig's process.
#[derive(Clone, Copy, Debug)]
struct ProcessUsage {
    bytes: u64,
    files: usize,
    threads: usize,
}

fn size(stepped: &SteppedRig) -> ProcessUsage {
    let process = format!("/proc/{}", stepped.process());
    let status = std::fs::read_to_string(format!("{process}/status")).unwrap();
    let line = status.lines().find(|line| line.starts_with("VmRSS:")).unwrap();
    let kib: u64 = line.split_whitespace().nth(1).unwrap().parse().unwrap();
    let count = |folder: &str| std::fs::read_dir(format!("{process}/{folder}")).unwrap().count();
    ProcessUsage { bytes: kib * 1024, files: count("fd"), threads: count("task") }
}

fn connect(stepped: &SteppedRig, name: &str) -> ControlClient {
    ControlClient::connect(&stepped.socket(), name).unwrap()
}

fn signals(names: &[&str], all: bool) -> RequestOperation {
    let names = names.iter().map(|name| (*name).to_owned()).collect();
    RequestOperation::Subscribe { topic: Topic::Signals { names, every_ms: 20, all } }
}

/// Somebody who looks at a trend for a second, and sees all of it.
fn trend(stepped: &SteppedRig) {
    let mut client = connect(stepped, "trend");
    client.ask::<Subscribed>(signals(&["MAIN.count", "pressure", "Q0", "Q1", "%IX0.0"], true)).unwrap();
    client.ask::<Advanced>(RequestOperation::Advance { by: SECOND }).unwrap();
    let mut seen = 0;
    while let Some(event) = client.next(Duration::ZERO).unwrap() {
        if let SubscriptionEvent::Signals { changes, missed, .. } = event {
            assert_eq!(missed, 0);
            seen += changes.len();
        }
    }
    assert!(seen >= 100, "{seen} changes");
}

/// Somebody who asks for everything and reads nothing.
fn deaf(stepped: &SteppedRig) -> UnixStream {
    let mut stream = UnixStream::connect(stepped.socket()).unwrap();
    let topic = r#"{"of":"signals","names":["MAIN.count","pressure"],"every_ms":5,"all":true}"#;
    for (id, topic) in (1..).zip([topic, r#"{"of":"status","every_ms":5}"#, r#"{"of":"log"}"#]) {
        writeln!(stream, "{{\"id\":{id},\"do\":\"subscribe\",\"topic\":{topic}}}").unwrap();
    }
    stream
}

/// Somebody who runs a plan, and waits until the program runs again.
fn plan(stepped: &SteppedRig) {
    let mut client = connect(stepped, "plan");
    client.ask::<Subscribed>(RequestOperation::Subscribe { topic: Topic::Plan }).unwrap();
    client.ask::<Done>(RequestOperation::Plan { name: "lamp".to_owned() }).unwrap();
    let began = Instant::now();
    let verdict = loop {
        assert!(began.elapsed() < PATIENCE, "the plan does not end");
        if let Some(SubscriptionEvent::Plan { event: PlanEvent::Over { verdict, .. }, .. }) =
            client.next(PATIENCE).unwrap()
        {
            break verdict;
        }
    };
    assert_eq!(verdict, "pass");
    stepped.expect(0, &["await", "state=RUNNING", "--advance", "60s"]);
}

/// A round: what several people do in a second.
fn round(stepped: &SteppedRig, leader: &mut ControlClient, deaf_ones: &mut Vec<UnixStream>, round: u32) {
    let name = "%IX0.0".to_owned();
    let on = WireValue(Value::Bool(round.is_multiple_of(2)));
    if round.is_multiple_of(60) {
        // The program restarts after it.
        plan(stepped);
    }
    leader
        .ask::<Done>(RequestOperation::Write {
            name: "MAIN.preset".to_owned(),
            value: WireValue(Value::Int(round.into())),
        })
        .unwrap();
    if round.is_multiple_of(3) {
        // One who forces and goes, one who forces and is lost, one who takes it back.
        let mut hand = connect(stepped, "hand");
        hand.ask::<Done>(RequestOperation::Force { name: name.clone(), value: on }).unwrap();
        match round % 9 {
            0 => drop(hand.ask::<Done>(RequestOperation::Leave { forces: Forces::Keep }).unwrap()),
            3 => drop(hand),
            _ => drop(hand.ask::<Done>(RequestOperation::Leave { forces: Forces::Release }).unwrap()),
        }
    }
    if round.is_multiple_of(10) {
        leader.ask::<Done>(RequestOperation::ReleaseAll).unwrap();
        deaf_ones.push(deaf(stepped));
        if deaf_ones.len() > 3 {
            deaf_ones.remove(0);
        }
    }
    if round.is_multiple_of(5) {
        trend(stepped);
    } else {
        leader.ask::<Advanced>(RequestOperation::Advance { by: SECOND }).unwrap();
    }
    if round.is_multiple_of(50) {
        leader.ask::<Done>(RequestOperation::Command { action: ControllerAction::Stop }).unwrap();
        leader.ask::<Advanced>(RequestOperation::Advance { by: SECOND / 10 }).unwrap();
        assert_eq!(leader.ask::<Status>(RequestOperation::Status).unwrap().state, "STOPPED");
        leader.ask::<Done>(RequestOperation::Command { action: ControllerAction::Run }).unwrap();
        leader.ask::<Advanced>(RequestOperation::Advance { by: SECOND / 10 }).unwrap();
    }
    let read: SignalValues =
        leader.ask(RequestOperation::Read { names: vec!["MAIN.preset".to_owned()] }).unwrap();
    assert_eq!(read.values, [WireValue(Value::Int(round.into()))]);
    let mut reported = 0;
    while let Some(event) = leader.next(Duration::ZERO).unwrap() {
        reported += u32::from(matches!(event, SubscriptionEvent::Status { .. }));
    }
    assert!(reported > 0, "round {round} reported nothing of the status");
}

#[test]
#[ignore = "takes minutes: tests/run all"]
fn ten_minutes_of_commissioning_leave_the_rig_as_large_as_it_was() {
    let bench = TestProject::new();
    bench.write("soak.toml", BOARD);
    bench.write("soak.st", PROGRAM);
    let stepped = SteppedRig::start(&bench, "soak.toml", "soak.st");
    stepped.expect(0, &["await", "state=RUNNING", "--advance", "60s"]);
    let mut leader = connect(&stepped, "leader");
    leader.ask::<Subscribed>(RequestOperation::Subscribe { topic: Topic::Status { every_ms: 100 } }).unwrap();
    let mut deaf_ones = Vec::new();
    (1..=WARM).for_each(|place| round(&stepped, &mut leader, &mut deaf_ones, place));
    let warm = size(&stepped);
    (WARM + 1..=ROUNDS).for_each(|place| round(&stepped, &mut leader, &mut deaf_ones, place));
    let end = size(&stepped);
    assert!(end.bytes <= warm.bytes + SLACK, "{warm:?} became {end:?}");
    assert_eq!((end.files, end.threads), (warm.files, warm.threads));
    let status: Status = leader.ask(RequestOperation::Status).unwrap();
    assert_eq!((&*status.state, status.rig.untold), ("RUNNING", 0));
}
