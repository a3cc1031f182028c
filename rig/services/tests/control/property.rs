//! Whatever bytes come, in whatever pieces: each request is answered once, in order, and nothing grows.

use control::LONGEST_LINE;
use proptest::prelude::*;
use scanrig_services::control::{ClientId, Hub, Peer, SocketSettings};
use serde_json::{Value as Json, json};
use signal::{Span, Time, Value};

use crate::fake::{Fake, SIGNALS};

fn hub(rig: &Fake) -> Hub {
    Hub::new(Box::new(rig.clone()), SocketSettings::of("unused".into()), Box::new(|_| {}))
}

/// A client that reads everything.
struct Reader {
    hub: Hub,
    id: ClientId,
    now: Time,
    read: Vec<u8>,
}

impl Reader {
    fn new() -> Reader {
        let mut hub = hub(&Fake::default());
        let id = hub.connect(Peer::default(), Time::ZERO).expect("room");
        let mut reader = Reader { hub, id, now: Time::ZERO, read: Vec::new() };
        reader.turn();
        reader.read.clear();
        reader
    }

    fn turn(&mut self) {
        self.now += Span::from_millis(1);
        while self.hub.work(self.id, self.now) {}
        self.hub.turn(self.now);
        let output = self.hub.output(self.id).to_vec();
        self.hub.sent(self.id, output.len(), self.now);
        self.read.extend(output);
    }

    /// As the shell does: bytes are handed over when they are wanted.
    fn put(&mut self, bytes: &[u8]) {
        self.settle();
        self.hub.receive(self.id, bytes);
    }

    fn settle(&mut self) {
        for _ in 0..10_000 {
            if self.hub.wants_input(self.id) || self.hub.is_done(self.id) {
                return;
            }
            self.turn();
        }
        panic!("the client is never asked for more");
    }

    fn end(mut self) -> Vec<Json> {
        self.settle();
        self.hub.input_is_over(self.id);
        self.settle();
        assert!(self.hub.is_done(self.id));
        self.hub.disconnect(self.id, self.now);
        let text = String::from_utf8(self.read).expect("text");
        text.lines().map(|line| serde_json::from_str(line).unwrap_or_else(|_| panic!("{line}"))).collect()
    }
}

/// Something like a line: requests, halves of them, and anything.
fn line() -> impl Strategy<Value = Vec<u8>> {
    let request = prop_oneof![
        Just(json!({"do": "status"})),
        Just(json!({"do": "read", "names": ["m1", "m2"]})),
        Just(json!({"do": "write", "name": "m1", "value": 1.5})),
        Just(json!({"do": "force", "name": "m1", "value": null})),
        Just(json!({"do": "subscribe", "topic": {"of": "signals", "names": ["m1"]}})),
        Just(json!({"do": "subscribe", "topic": {"of": "log"}})),
        Just(json!({"do": "unsubscribe", "subscription": 1})),
        Just(json!({"do": "lock", "note": "n"})),
        Just(json!({"do": "unlock"})),
        Just(json!({"do": "nothing"})),
    ];
    prop_oneof![
        4 => (request, any::<u64>()).prop_map(|(mut request, id)| {
            request["id"] = id.into();
            request.to_string().into_bytes()
        }),
        2 => prop::collection::vec(any::<u8>(), 0..40),
        1 => (LONGEST_LINE - 2..LONGEST_LINE + 2).prop_map(|length| vec![b'9'; length]),
        1 => "[ \t\r]{0,4}".prop_map(String::into_bytes),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_line_is_answered_once_and_in_order(
        lines in prop::collection::vec(line(), 0..20),
        piece in 1usize..3_000,
    ) {
        let bytes = lines.join(&b'\n');
        let mut reader = Reader::new();
        for part in bytes.chunks(piece) {
            reader.put(part);
        }
        let lines = reader.end();
        let answers = lines.iter().filter(|line| line.get("event").is_none());
        let answered: Vec<Option<u64>> = answers.map(|line| line["id"].as_u64()).collect();
        let mut asked: Vec<&[u8]> = bytes.split(|byte| *byte == b'\n').collect();
        // Nothing after the end of the last line is no line.
        asked.pop_if(|line| line.is_empty());
        let asked: Vec<Option<u64>> = asked.into_iter().map(|line| {
            let value: Json = serde_json::from_slice(line).ok()?;
            value.get("id")?.as_u64()
        }).collect();
        prop_assert_eq!(answered, asked);
    }
}

#[test]
fn what_waits_for_a_client_that_never_reads_is_bounded() {
    let rig = Fake::default();
    let mut hub = hub(&rig);
    let id = hub.connect(Peer::default(), Time::ZERO).expect("room");
    let names: Vec<String> = (0..SIGNALS - 1).map(|number| format!("m{number}")).collect();
    let mut now = Time::ZERO;
    let mut turn = |hub: &mut Hub| {
        // A minute in steps: the subscriptions are due often, and nothing that waits is an answer.
        now += Span::from_millis(20);
        hub.work(id, now);
        hub.turn(now);
    };
    for topic in [
        json!({"of": "signals", "names": names, "every_ms": 5, "all": true}),
        json!({"of": "signals", "names": ["m1"], "every_ms": 5}),
        json!({"of": "status", "every_ms": 5}),
        json!({"of": "frames"}),
        json!({"of": "log"}),
        json!({"of": "plan"}),
    ] {
        hub.receive(id, format!("{}\n", json!({"id": 1, "do": "subscribe", "topic": topic})).as_bytes());
        while !hub.wants_input(id) {
            turn(&mut hub);
            let length = hub.output(id).len();
            hub.sent(id, length, Time::ZERO);
        }
    }
    let mut most = 0;
    for round in 0..3_000 {
        for signal in 0..10 {
            rig.change(signal, Value::Int(round));
        }
        rig.log("a line of the log that is as long as such lines are");
        rig.plan(control::PlanEvent::Step { step: 1, at: round, done: false });
        turn(&mut hub);
        assert!(!hub.is_done(id), "only answers have to be read");
        most = most.max(hub.output(id).len());
    }
    let limits = SocketSettings::of("unused".into()).limits;
    // Plans may fill eight queues; a message more goes over each.
    assert!(most > limits.queue && most < 9 * limits.queue, "{most}");
}
