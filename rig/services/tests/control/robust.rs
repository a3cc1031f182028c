//! What clients do wrong, and what must not come of it.

use std::io::Write;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use control::{FrameSeen, LONGEST_LINE, PlanEvent};
use scanrig_services::control::ClientLimits;
use serde_json::{Value as Json, json};
use signal::Value;

use crate::bench::{Bench, Client, PATIENCE, signals, wait_for};
use crate::fake::Fake;

#[test]
fn lines_that_are_no_requests_are_answered_and_the_connection_goes_on() {
    let bench = Bench::new();
    let mut client = bench.client();
    client.send(b"{\"id\": 1, \"do\"\n\n  \r\n\xff\xfe\n[1]\n");
    let mut long = vec![b'x'; 4 * LONGEST_LINE];
    long.push(b'\n');
    client.send(&long);
    let codes: Vec<Json> = (0..6).map(|_| client.line()["error"]["code"].clone()).collect();
    assert_eq!(codes, ["R0621", "R0621", "R0621", "R0621", "R0622", "R0620"]);
    assert_eq!(client.ok(json!({"do": "read", "names": ["m1"]})), json!({"values": [0]}));
}

#[test]
fn who_asks_for_too_much_is_refused() {
    let bench = Bench::of(Fake::default(), |settings| {
        settings.limits = ClientLimits { clients: 2, subscriptions: 2, names: 3, ..ClientLimits::default() };
    });
    let mut client = bench.client();
    let said = client.refused(json!({"do": "read", "names": ["m1", "m2", "m3", "m4"]}));
    assert_eq!(said, "R0626 4 names are more than the 3 that a client may have");
    client.ok(signals(&["m1", "m2"], 5, true));
    let said = client.refused(signals(&["m3", "m4"], 5, true));
    assert_eq!(said, "R0626 4 names are more than the 3 that a client may have");
    client.ok(json!({"do": "subscribe", "topic": {"of": "log"}}));
    let said = client.refused(json!({"do": "subscribe", "topic": {"of": "log"}}));
    assert_eq!(said, "R0626 a client has at most 2 subscriptions");
    let _second = bench.client();
    let mut third = Client::connect(&bench.socket);
    let said = third.line();
    assert_eq!((&said["id"], &said["error"]["code"]), (&Json::Null, &json!("R0625")));
    assert_eq!(third.line(), Json::Null);
}

#[test]
fn a_thousand_clients_are_served() {
    const CLIENTS: usize = 1_000;
    let bench = Bench::of(Fake::default(), |settings| settings.limits.clients = CLIENTS + 1);
    let mut first = bench.client();
    let mut clients: Vec<Client> = (0..CLIENTS).map(|_| bench.client()).collect();
    let ask = signals(&["m1"], 5, true).to_string();
    for client in &mut clients {
        client.send(ask.replacen('{', "{\"id\": 1, ", 1).as_bytes());
        client.send(b"\n");
    }
    for client in &mut clients {
        assert_eq!(client.line()["ok"]["subscription"], 1);
    }
    assert_eq!(first.ok(json!({"do": "status"}))["clients"], 1 + CLIENTS);
    bench.rig.change(1, Value::Int(5));
    for client in &mut clients {
        assert_eq!(client.event()["changes"], json!([[1, 0, 0, 5]]));
    }
    drop(clients);
    wait_for(|| first.ok(json!({"do": "status"}))["clients"] == 1, "a thousand to be gone");
    assert!(bench.rig.state().watched.is_empty());
}

#[test]
fn who_does_not_read_is_sent_less_and_who_leaves_answers_unread_is_cut_off() {
    let patience = Duration::from_millis(300);
    let bench = Bench::of(Fake::default(), |settings| {
        settings.limits = ClientLimits { patience, changes: 100, ..ClientLimits::default() };
    });
    let mut reader = bench.client();
    let mut sleeper = bench.client();
    sleeper.ok(signals(&["m1"], 5, true));
    sleeper.ok(json!({"do": "subscribe", "topic": {"of": "frames"}}));
    let mut greedy = bench.client();
    greedy.stream.set_nonblocking(true).expect("a socket");
    let ask = "{\"id\": 1, \"do\": \"describe\"}\n".repeat(1_000);
    let (mut sent, mut frames, mut last) = (0, 0, 0);
    let began = Instant::now();
    let cut = |bench: &Bench| bench.log.lock().expect("lines").iter().any(|line| line.contains("is cut off"));
    while !cut(&bench) {
        assert!(began.elapsed() < PATIENCE, "the greedy client is still served");
        // The greedy one asks as long as anything fits.
        let rest = &ask.as_bytes()[sent % ask.len()..];
        sent += greedy.stream.write(rest).unwrap_or(0);
        for _ in 0..50 {
            last += 1;
            bench.rig.change(1, Value::Int(last));
            bench.rig.frame(frame(frames));
            frames += 1;
        }
        reader.ok(json!({"do": "read", "names": ["m1"]}));
    }
    // Far more than its queue and the kernel's hold, so that something was left out.
    while frames < 20_000 {
        last += 1;
        bench.rig.change(1, Value::Int(last));
        bench.rig.frame(frame(frames));
        frames += 1;
        if frames % 500 == 0 {
            reader.ok(json!({"do": "status"}));
        }
    }
    // The sleeper wakes: what it missed is counted, and it ends with the last value.
    let (mut seen, mut missed, mut reported, mut left_out, mut value) = (0, 0, 0, 0, 0);
    while value != last || reported + left_out < frames {
        let event = sleeper.event();
        match event["event"].as_str() {
            Some("signals") => {
                let changes = event["changes"].as_array().expect("changes");
                seen += changes.len() as u64;
                missed += event["missed"].as_u64().expect("a count");
                value = changes[changes.len() - 1][3].as_i64().expect("a value");
            }
            Some("frame") => reported += 1,
            Some("missed") => left_out += event["lines"].as_u64().expect("a count"),
            _ => panic!("{event}"),
        }
    }
    assert!(missed > 0 && left_out > 0, "{missed} {left_out}");
    assert_eq!((seen + missed, reported + left_out), (last as u64, frames));
}

fn frame(number: u64) -> FrameSeen {
    let data = format!("{number:016X}");
    FrameSeen { bus: "can".into(), at: 0, sent: false, id: "18F".into(), flags: Vec::new(), data }
}

#[test]
fn floods_of_requests_do_not_keep_others_waiting() {
    const FLOODS: usize = 8;
    let bench = Bench::new();
    let (over, answered) = (AtomicBool::new(false), AtomicU64::new(0));
    std::thread::scope(|scope| {
        for _ in 0..FLOODS {
            scope.spawn(|| {
                let mut client = bench.client();
                let burst = "{\"id\": 7, \"do\": \"write\", \"name\": \"m7\", \"value\": 1}\n".repeat(500);
                while !over.load(Ordering::Relaxed) {
                    client.send(burst.as_bytes());
                    for _ in 0..500 {
                        assert_eq!(client.line(), json!({"id": 7, "ok": {}}));
                        answered.fetch_add(1, Ordering::Relaxed);
                    }
                }
            });
        }
        wait_for(|| answered.load(Ordering::Relaxed) > 0, "the flood");
        let mut client = bench.client();
        let mut most = 0;
        for value in 0..20 {
            let before = answered.load(Ordering::Relaxed);
            client.ok(json!({"do": "write", "name": "m1", "value": value}));
            most = most.max(answered.load(Ordering::Relaxed) - before);
        }
        over.store(true, Ordering::Relaxed);
        // Everyone has one turn after the other: its request does not stand after thousands. The rest of the bound is
        // for threads that wait for a processor.
        assert!(most < 500 * FLOODS as u64, "{most} other requests came first");
    });
}

#[test]
fn what_was_asked_is_answered_behind_the_end_of_the_input() {
    let bench = Bench::new();
    let mut client = bench.client();
    client.send(b"{\"id\": 1, \"do\": \"write\", \"name\": \"m1\", \"value\": 3}\n{\"id\": 2, \"do\": \"read\", \"names\": [\"m1\"]}");
    client.says_nothing_more();
    assert_eq!(client.line(), json!({"id": 1, "ok": {}}));
    assert_eq!(client.line(), json!({"id": 2, "ok": {"values": [3]}}));
    assert_eq!(client.line(), Json::Null);
}

#[test]
fn at_the_end_everyone_is_informed_and_every_request_is_answered() {
    let mut bench = Bench::new();
    let mut idle = bench.client();
    let mut waits = bench.client();
    bench.rig.state().hangs = true;
    waits.send(b"{\"id\": 5, \"do\": \"write\", \"name\": \"m1\", \"value\": 3}\n");
    wait_for(|| !bench.rig.state().orders.is_empty(), "the order");
    bench.serving.take().expect("it serves").end("it was stopped");
    assert_eq!(idle.line(), json!({"event": "gone", "why": "it was stopped"}));
    assert_eq!(idle.line(), Json::Null);
    let reply = waits.line();
    assert_eq!((&reply["id"], &reply["error"]["code"]), (&json!(5), &json!("R0633")));
    assert_eq!(waits.line()["event"], "gone");
    assert!(!bench.socket.exists());
}

#[test]
fn who_comes_later_hears_what_was_reported_before() {
    let bench = Bench::new();
    bench.rig.log("the first line");
    let case = PlanEvent::Case { name: "a".into(), place: (1, 1), steps: Vec::new(), claims: Vec::new() };
    bench.rig.plan(case.clone());
    let mut client = bench.client();
    let lines = || json!({"do": "subscribe", "topic": {"of": "log"}});
    let mut begun = Json::Null;
    wait_for(
        || {
            begun = client.ok(lines());
            client.ok(json!({"do": "unsubscribe", "subscription": begun["subscription"]}));
            begun["log"].as_array().is_some_and(|log| log.iter().any(|line| line["text"] == "the first line"))
        },
        "the line",
    );
    client.ok(lines());
    let plan = client.ok(json!({"do": "subscribe", "topic": {"of": "plan"}}));
    assert_eq!(plan["plan"], json!([case]));
    bench.rig.log("another line");
    bench.rig.plan(PlanEvent::Step { step: 0, at: 5, done: true });
    wait_for(|| client.event_of("log")["text"] == "another line", "the line");
    assert_eq!(client.event_of("plan")["told"], json!({"plan": "step", "step": 0, "at": 5, "done": true}));
    assert_eq!(client.refused(json!({"do": "plan", "name": "unknown"})), "R0600 there is no such plan");
}
