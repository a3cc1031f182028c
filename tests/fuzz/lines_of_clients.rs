//! Lines of clients of the control socket.

use control::{
    Description, Greeting, PROTOCOL, Request, RequestFault, Signal as Named, SignalKind, Status, TimeSource,
};
use services::control::{Answer, Hub, Peer, Rig, RigEvent, RigOrder, SocketSettings, Ticket, decode};
use signal::{Span, Time, Value, When};

/// A rig that has every signal, and does what it is asked.
#[derive(Default)]
struct Willing {
    answers: Vec<(Ticket, Answer)>,
    watched: std::collections::BTreeMap<u32, u32>,
}

impl Rig for Willing {
    fn greeting(&self) -> Greeting {
        let text = String::new;
        Greeting {
            rig: text(),
            protocol: PROTOCOL,
            version: text(),
            board: text(),
            reference: text(),
            client: 0,
        }
    }

    fn describe(&self) -> Description {
        Description { clock: TimeSource::Stepped, ..Description::default() }
    }

    fn status(&self) -> Status {
        Status::default()
    }

    fn find(&mut self, name: &str) -> Result<Named, RequestFault> {
        let number = name.len() as u32;
        let (name, unit) = (name.to_owned(), String::new());
        Ok(Named { number, name, kind: SignalKind::Int, unit, labels: Vec::new(), writable: true })
    }

    fn watch(&mut self, signal: u32) -> Result<(), RequestFault> {
        *self.watched.entry(signal).or_default() += 1;
        Ok(())
    }

    fn unwatch(&mut self, signal: u32) {
        let times = self.watched.get_mut(&signal).expect("only what is watched is left");
        *times = times.checked_sub(1).expect("only as often as it was watched");
    }

    fn last(&self, _: u32) -> Option<(When, Value)> {
        None
    }

    fn order(&mut self, ticket: Ticket, order: RigOrder) -> Result<(), RequestFault> {
        let answer = match order {
            RigOrder::Read(signal) => Answer::Value(Value::Int(signal.into())),
            _ => Answer::Done,
        };
        self.answers.push((ticket, answer));
        Ok(())
    }

    fn poll(&mut self, reported: &mut dyn FnMut(RigEvent)) {
        for (ticket, answer) in self.answers.drain(..) {
            reported(RigEvent::Answer(ticket, Ok(answer)));
        }
    }
}

/// Bytes of a client: each line is answered once, whatever it is, and what is read as a request is
/// written as one that reads the same.
pub fn control(data: &[u8]) {
    let mut lines: Vec<&[u8]> = data.split(|byte| *byte == b'\n').collect();
    // Nothing after the end of the last line is no line.
    lines.pop_if(|line| line.is_empty());
    for line in &lines {
        match decode(line) {
            Ok(request) => comes_again(&request),
            Err(refused) => assert!(refused.fault.code.len() == 5 && !refused.fault.message.is_empty()),
        }
    }
    let mut hub =
        Hub::new(Box::new(Willing::default()), SocketSettings::of("unused".into()), Box::new(|_| {}));
    let Ok(client) = hub.connect(Peer::default(), Time::ZERO) else { panic!("there is room") };
    let (mut now, mut reported) = (Time::ZERO, Vec::new());
    let mut settle = |hub: &mut Hub| {
        while !hub.wants_input(client) && !hub.is_done(client) {
            now += Span::from_millis(1);
            while hub.work(client, now) {}
            hub.turn(now);
            reported.extend_from_slice(hub.output(client));
            hub.sent(client, hub.output(client).len(), now);
        }
    };
    for piece in data.chunks(1_000) {
        settle(&mut hub);
        hub.receive(client, piece);
    }
    settle(&mut hub);
    hub.input_is_over(client);
    settle(&mut hub);
    hub.disconnect(client, Time::MAX);
    let mut answers = 0;
    let mut left = false;
    for line in String::from_utf8(reported).expect("text").lines() {
        let value: serde_json::Value = serde_json::from_str(line).expect("JSON");
        answers += usize::from(value.get("id").is_some());
        left |= value.get("error").is_some_and(|error| error["code"] == "R0624");
    }
    // Who takes its leave or speaks another protocol is not heard any more.
    let leaves = left || lines.iter().any(|line| line.windows(5).any(|word| word == b"leave"));
    assert!(answers == lines.len() || leaves && answers <= lines.len(), "{answers} of {}", lines.len());
}

fn comes_again(request: &Request) {
    let line = serde_json::to_string(request).expect("a line");
    let again = decode(line.as_bytes()).expect("what was read is written so that it reads");
    // What is not equal to itself is no number.
    let same = again == *request || line.contains("nan");
    assert!(same, "{line}");
}
