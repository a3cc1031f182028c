//! Each request and its answer.

use control::ForcedPoint;
use scanrig_services::control::{OnDisconnect, RigOrder};
use serde_json::{Value as Json, json};
use signal::Value;

use crate::bench::{Bench, signals, wait_for};
use crate::fake::Fake;

#[test]
fn what_is_written_is_read_and_answers_come_in_order() {
    let bench = Bench::new();
    let mut client = bench.client();
    assert_eq!(client.ok(json!({"do": "write", "name": "m3", "value": 7})), json!({}));
    assert_eq!(client.ok(json!({"do": "read", "names": ["m3", "m4"]})), json!({"values": [7, 0]}));
    assert_eq!(client.refused(json!({"do": "read", "names": ["m3", "q"]})), "R0600 there is no q");
    assert_eq!(client.refused(json!({"do": "write", "name": "m3", "value": null})), "R0600 nothing to write");
    assert_eq!(client.ok(json!({"do": "plans", "path": "p"})), json!({"plans": ["p"]}));
    // Many at once: each write is seen by the read after it.
    let mut lines = String::new();
    for value in 0..200 {
        lines += &format!("{}\n", json!({"id": 2 * value, "do": "write", "name": "m5", "value": value}));
        lines += &format!("{}\n", json!({"id": 2 * value + 1, "do": "read", "names": ["m5"]}));
    }
    client.send(lines.as_bytes());
    for value in 0..200 {
        assert_eq!(client.line(), json!({"id": 2 * value, "ok": {}}));
        assert_eq!(client.line(), json!({"id": 2 * value + 1, "ok": {"values": [value]}}));
    }
}

#[test]
fn a_greeting_says_who_is_there_and_another_protocol_is_refused() {
    let bench = Bench::new();
    let mut first = bench.client();
    assert_eq!(first.ok(json!({"do": "hello", "protocol": 1, "name": "rig\ndash"}))["client"], 1);
    bench.logged("client 1 (rig\u{fffd}dash, user ");
    let mut second = bench.client();
    let said = second.refused(json!({"do": "hello", "protocol": 2, "name": "new"}));
    assert_eq!(said, "R0624 the client speaks version 2 of the protocol, the rig 1");
    assert_eq!(second.line(), Json::Null);
    assert_eq!(first.ok(json!({"do": "describe"}))["on_disconnect"], "keep");
    wait_for(|| first.ok(json!({"do": "status"}))["clients"] == 1, "the second to be gone");
}

#[test]
fn signals_are_reported_from_the_answer_on() {
    let bench = Bench::new();
    bench.rig.change(2, Value::Int(9));
    let mut client = bench.client();
    let begun = client.ok(signals(&["m2", "m1", "m2"], 5, true));
    let named: Vec<Json> =
        begun["signals"].as_array().expect("signals").iter().map(|one| one["name"].clone()).collect();
    assert_eq!((&begun["subscription"], named), (&json!(1), vec![json!("m2"), json!("m1"), json!("m2")]));
    assert_eq!(begun["values"], json!([[1, 0, 0, 0], [2, 0, 0, 9]]));
    for value in 1..=3 {
        bench.rig.change(1, Value::Int(value));
    }
    let mut changes = Vec::new();
    while changes.len() < 3 {
        let event = client.event_of("signals");
        assert_eq!((&event["subscription"], &event["missed"]), (&json!(1), &json!(0)));
        changes.extend(event["changes"].as_array().expect("changes").clone());
    }
    assert_eq!(changes, [json!([1, 0, 0, 1]), json!([1, 0, 0, 2]), json!([1, 0, 0, 3])]);
    client.ok(json!({"do": "unsubscribe", "subscription": 1}));
    assert!(bench.rig.state().watched.is_empty());
    assert_eq!(
        client.refused(json!({"do": "unsubscribe", "subscription": 1})),
        "R0627 this connection has no subscription 1"
    );
}

#[test]
fn a_subscription_that_cannot_be_leaves_nothing_watched() {
    let bench = Bench::new();
    let mut client = bench.client();
    assert_eq!(client.refused(signals(&["m1", "m999"], 5, true)), "R0600 that is one too many");
    assert_eq!(client.refused(signals(&["m1", "nothing"], 5, true)), "R0600 there is no nothing");
    assert!(bench.rig.state().watched.is_empty());
    client.ok(signals(&["m1", "m2"], 5, true));
    let mut other = bench.client();
    other.ok(signals(&["m2"], 5, false));
    drop(client);
    wait_for(|| bench.rig.state().watched.len() == 1, "the first client's watches to end");
    assert_eq!(bench.rig.state().watched[&2], 1);
}

#[test]
fn the_status_is_reported_when_it_changes() {
    let bench = Bench::new();
    let mut client = bench.client();
    client.ok(json!({"do": "subscribe", "topic": {"of": "status", "every_ms": 5}}));
    assert_eq!(client.event_of("status")["status"]["state"], "");
    client.ok(json!({"do": "command", "action": "run"}));
    wait_for(|| client.event_of("status")["status"]["state"] == "run", "the new state");
}

#[test]
fn what_is_forced_has_its_name_and_ends_as_the_client_says() {
    for (policy, left, state) in
        [(OnDisconnect::Keep, 1, ""), (OnDisconnect::Release, 0, ""), (OnDisconnect::Stop, 0, "stop")]
    {
        let bench = Bench::of(Fake::default(), |settings| settings.on_disconnect = policy);
        let mut watcher = bench.client();
        let mut client = bench.client();
        client.ok(json!({"do": "hello", "protocol": 1, "name": "hand"}));
        client.ok(json!({"do": "force", "name": "m1", "value": true}));
        assert_eq!(
            client.refused(json!({"do": "force", "name": "m2", "value": null})),
            "R0600 nothing to force"
        );
        let forced = |status: Json| -> Vec<ForcedPoint> {
            serde_json::from_value(status["forced"].clone()).expect("what is forced")
        };
        let now = forced(watcher.ok(json!({"do": "status"})));
        assert_eq!((now.len(), &*now[0].address, now[0].by.as_deref()), (1, "m1", Some("hand")));
        drop(client);
        bench.logged("is gone");
        wait_for(|| bench.rig.state().forced.len() == left, "the policy");
        wait_for(|| bench.rig.state().state == state, "the state");
        let now = forced(watcher.ok(json!({"do": "status"})));
        assert!(now.iter().all(|one| one.by.is_none()));
    }
}

#[test]
fn a_terminal_and_its_address_are_one_thing() {
    let bench = Bench::of(Fake::default(), |settings| settings.on_disconnect = OnDisconnect::Release);
    let (mut one, mut other) = (bench.client(), bench.client());
    let by =
        |client: &mut crate::bench::Client| client.ok(json!({"do": "status"}))["forced"][0]["by"].clone();
    one.ok(json!({"do": "force", "name": "t5", "value": true}));
    assert_eq!(by(&mut one), "client 1");
    // What another client forces again is no longer the first one's.
    other.ok(json!({"do": "force", "name": "m5", "value": false}));
    assert_eq!(by(&mut one), "client 2");
    drop(one);
    wait_for(|| other.ok(json!({"do": "status"}))["clients"] == 1, "the first to be gone");
    assert_eq!(by(&mut other), "client 2");
    other.ok(json!({"do": "release", "name": "t5"}));
    assert!(bench.rig.state().forced.is_empty());
}

#[test]
fn who_says_goodbye_says_what_becomes_of_its_forces() {
    for (forces, left) in [("keep", 1), ("release", 0)] {
        let bench = Bench::of(Fake::default(), |settings| settings.on_disconnect = OnDisconnect::Stop);
        let mut client = bench.client();
        client.ok(json!({"do": "force", "name": "m1", "value": true}));
        client.ok(json!({"do": "leave", "forces": forces}));
        assert_eq!(client.line(), Json::Null);
        bench.is_empty();
        assert_eq!(bench.rig.state().forced.len(), left);
        assert!(!bench.rig.state().done.contains(&RigOrder::Command(control::ControllerAction::Stop)));
    }
}

#[test]
fn a_lock_freezes_and_outlasts_the_rig() {
    let state = tempfile::tempdir().expect("a folder");
    let settings = |all: &mut scanrig_services::control::SocketSettings| {
        all.on_disconnect = OnDisconnect::Release;
        all.state = Some(state.path().into());
    };
    let mut bench = Bench::of(Fake::default(), settings);
    let mut client = bench.client();
    client.ok(json!({"do": "force", "name": "m1", "value": true}));
    client.ok(json!({"do": "lock", "note": "handed over"}));
    let frozen = [
        json!({"do": "write", "name": "m3", "value": 7}),
        json!({"do": "force", "name": "m3", "value": 7}),
        json!({"do": "release", "name": "m1"}),
        json!({"do": "release-all"}),
        json!({"do": "command", "action": "stop"}),
        json!({"do": "plan", "name": "a"}),
        json!({"do": "lock"}),
        json!({"do": "leave", "forces": "release"}),
    ];
    for request in frozen {
        assert_eq!(client.refused(request), "R0628 the rig was locked by client 1: handed over");
    }
    client.ok(json!({"do": "abort"}));
    drop(client);
    bench.logged("which stay: the rig is locked");
    assert_eq!(bench.rig.state().forced.len(), 1);
    drop(bench.serving.take());
    bench.start(settings);
    let mut client = bench.client();
    assert_eq!(client.ok(json!({"do": "status"}))["locked"]["note"], "handed over");
    client.ok(json!({"do": "unlock"}));
    client.ok(json!({"do": "release", "name": "m1"}));
    assert_eq!(client.ok(json!({"do": "status"}))["locked"], Json::Null);
}

#[test]
fn whoever_leads_time_is_sent_everything_before_the_answer() {
    let course = || {
        let bench = Bench::of(Fake::led(), |_| {});
        let mut client = bench.client();
        client.ok(signals(&["m0"], 10, true));
        client.ok(signals(&["m0"], 20, false));
        client.ok(json!({"do": "subscribe", "topic": {"of": "status", "every_ms": 10}}));
        for at in [35, 70] {
            assert_eq!(client.ok(json!({"do": "advance", "by": 35_000_000})), json!({"at": at * 1_000_000}));
        }
        client.events
    };
    let events = course();
    let reported = |subscription: u64| -> Vec<(i64, usize)> {
        let of = events
            .iter()
            .filter(|event| event["subscription"] == subscription && event["event"] == "signals");
        let changes = of.map(|event| event["changes"].as_array().expect("changes").clone());
        changes.map(|all| (all[all.len() - 1][3].as_i64().expect("a number"), all.len())).collect()
    };
    assert_eq!(reported(1).iter().map(|(_, count)| count).sum::<usize>(), 70);
    assert_eq!(reported(1), [(9, 9), (19, 10), (29, 10), (35, 6), (44, 9), (54, 10), (64, 10), (70, 6)]);
    assert_eq!(reported(2), [(19, 1), (35, 1), (54, 1), (70, 1)]);
    // The same each time, byte for byte.
    assert_eq!(course(), events);
}

#[test]
fn whoever_leads_time_misses_nothing_however_much_it_is() {
    let bench = Bench::of(Fake::led(), |settings| settings.limits.changes = 100);
    let mut client = bench.client();
    client.ok(signals(&["m0"], 3_600_000, true));
    client.ok(json!({"do": "advance", "by": 20_000_000_000_i64}));
    let mut last = 0;
    for event in &client.events {
        assert_eq!(event["missed"], 0);
        for change in event["changes"].as_array().expect("changes") {
            last += 1;
            assert_eq!(change[3], last);
        }
    }
    assert_eq!(last, 20_000);
}

#[test]
fn whoever_leads_time_and_does_not_read_is_cut_off() {
    let bench = Bench::of(Fake::led(), |settings| {
        settings.limits.patience = std::time::Duration::from_millis(300);
    });
    let mut client = bench.client();
    client.ok(signals(&["m0"], 5, true));
    client.send(b"{\"id\": 9, \"do\": \"advance\", \"by\": 20000000000}\n");
    bench.logged("does not read what it is sent");
    bench.is_empty();
}
