//! The client against a rig that says what a script says.

use control::client::{answer, running};
use control::{
    ClientError, ControlClient, Done, Greeting, PROTOCOL, Plans, Reply, RequestOperation, ServerMessage,
    Status, SubscriptionEvent, Topic,
};
use scanrig_control as control;
use std::io::{BufRead, BufReader, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::PathBuf;
use std::thread::JoinHandle;
use std::time::Duration;

const SOON: Duration = Duration::from_millis(30);
const PATIENCE: Duration = Duration::from_secs(30);

/// A rig at a socket: what it does with its only client runs in a thread.
struct Fake {
    folder: tempfile::TempDir,
    runs: JoinHandle<()>,
}

impl Fake {
    fn with(first: &'static str, script: impl FnOnce(BufReader<UnixStream>) + Send + 'static) -> Fake {
        let folder = tempfile::tempdir().unwrap();
        let listener = UnixListener::bind(folder.path().join("fake.sock")).unwrap();
        let runs = std::thread::spawn(move || {
            let mut stream = listener.accept().unwrap().0;
            stream.write_all(first.as_bytes()).unwrap();
            script(BufReader::new(stream));
        });
        Fake { folder, runs }
    }

    /// One that greets well and takes the client's hello.
    fn polite(script: impl FnOnce(BufReader<UnixStream>) + Send + 'static) -> Fake {
        Fake::with(GREETING, move |mut lines| {
            assert_eq!(line(&mut lines), r#"{"id":1,"do":"hello","protocol":1,"name":"test"}"#);
            say(&mut lines, r#"{"id":1,"ok":{}}"#);
            script(lines);
        })
    }

    fn socket(&self) -> PathBuf {
        self.folder.path().join("fake.sock")
    }

    fn client(&self) -> Result<ControlClient, ClientError> {
        ControlClient::connect(&self.socket(), "test")
    }

    fn end(self) {
        self.runs.join().unwrap();
    }
}

const GREETING: &str = "{\"rig\":\"scanrig\",\"protocol\":1,\"version\":\"0\",\"board\":\"b.toml\",\
                        \"reference\":\"TM241CEC24T\",\"client\":3,\"younger\":true}\n";

fn line(lines: &mut BufReader<UnixStream>) -> String {
    let mut line = String::new();
    lines.read_line(&mut line).unwrap();
    line.trim_end().to_owned()
}

fn say(lines: &mut BufReader<UnixStream>, text: &str) {
    lines.get_mut().write_all(format!("{text}\n").as_bytes()).unwrap();
}

fn log(text: &str) -> SubscriptionEvent {
    SubscriptionEvent::Log { subscription: 1, at: 5, text: text.to_owned() }
}

#[test]
fn events_beside_an_answer_are_kept_in_their_order() {
    let fake = Fake::polite(|mut lines| {
        assert_eq!(line(&mut lines), r#"{"id":2,"do":"subscribe","topic":{"of":"log"}}"#);
        say(&mut lines, r#"{"event":"log","subscription":1,"at":5,"text":"one"}"#);
        say(&mut lines, r#"{"event":"dream","subscription":1,"of":"a younger rig"}"#);
        say(&mut lines, r#"{"id":2,"ok":{"subscription":1,"younger":[]}}"#);
        say(&mut lines, r#"{"event":"log","subscription":1,"at":5,"text":"two"}"#);
        assert_eq!(line(&mut lines), "");
    });
    let mut client = fake.client().unwrap();
    assert_eq!(client.greeting().client, 3);
    let got = client.ask::<control::Subscribed>(RequestOperation::Subscribe { topic: Topic::Log }).unwrap();
    assert_eq!(got.subscription, 1);
    assert_eq!(client.next(PATIENCE), Ok(Some(log("one"))));
    assert_eq!(client.next(PATIENCE), Ok(Some(log("two"))));
    assert_eq!(client.next(SOON), Ok(None));
    drop(client);
    fake.end();
}

#[test]
fn a_rig_that_sends_events_without_an_answer_is_waited_for_no_longer_than_any_other() {
    for event in [
        r#"{"event":"log","subscription":1,"at":5,"text":"one"}"#,
        r#"{"event":"dream"}"#,
        r#"{"id":9,"ok":{}}"#,
    ] {
        let fake = Fake::polite(move |mut lines| {
            assert_eq!(line(&mut lines), r#"{"id":2,"do":"abort"}"#);
            // Until the client has gone.
            while lines.get_mut().write_all(format!("{event}\n").as_bytes()).is_ok() {}
        });
        let mut client = fake.client().unwrap();
        let silent = client.ask_within::<Done>(RequestOperation::Abort, SOON).unwrap_err();
        assert_eq!(silent.fault().code, "R0647", "{event}");
        drop(client);
        fake.end();
    }
}

#[test]
fn a_line_in_pieces_is_waited_for_no_longer_than_any_other() {
    let fake = Fake::polite(|mut lines| {
        assert_eq!(line(&mut lines), r#"{"id":2,"do":"abort"}"#);
        while lines.get_mut().write_all(b"x").is_ok() {}
    });
    let mut client = fake.client().unwrap();
    let silent = client.ask_within::<Done>(RequestOperation::Abort, SOON).unwrap_err();
    assert_eq!(silent.fault().code, "R0647");
    drop(client);
    fake.end();
}

#[test]
fn a_rig_that_takes_no_connection_does_not_keep_its_client_waiting() {
    let folder = tempfile::tempdir().unwrap();
    let socket = folder.path().join("stopped.sock");
    let _listener = UnixListener::bind(&socket).unwrap();
    let mut waiting = Vec::new();
    // As a rig that stands still: whoever comes waits for a place.
    while let control::Connection::Open(stream) = control::connect(&socket, Duration::ZERO).unwrap() {
        waiting.push(stream);
    }
    let silent = ControlClient::meet(&socket, SOON).unwrap_err();
    assert_eq!(silent.fault().code, "R0647");
}

#[test]
fn an_answer_that_comes_too_late_is_not_taken_for_the_next() {
    let fake = Fake::polite(|mut lines| {
        assert_eq!(line(&mut lines), r#"{"id":2,"do":"abort"}"#);
        assert_eq!(line(&mut lines), r#"{"id":3,"do":"plans","path":null}"#);
        say(&mut lines, r#"{"id":2,"ok":{}}"#);
        say(&mut lines, r#"{"id":3,"ok":{"plans":["a"]}}"#);
    });
    let mut client = fake.client().unwrap();
    let silent = client.ask_within::<Done>(RequestOperation::Abort, SOON).unwrap_err();
    assert_eq!(silent.fault().code, "R0647");
    let plans: Plans = client.ask(RequestOperation::Plans { path: None }).unwrap();
    assert_eq!(plans.plans, ["a"]);
    fake.end();
}

#[test]
fn a_refusal_keeps_its_code() {
    let fake = Fake::polite(|mut lines| {
        line(&mut lines);
        say(&mut lines, r#"{"id":2,"error":{"code":"R0601","message":"no"}}"#);
        line(&mut lines);
        say(&mut lines, r#"{"id":3,"ok":{"at":"noon"}}"#);
    });
    let mut client = fake.client().unwrap();
    let refused = client.ask::<Status>(RequestOperation::Status).unwrap_err();
    assert_eq!((&*refused.fault().code, &*refused.fault().message), ("R0601", "no"));
    let garbled = client.ask::<Status>(RequestOperation::Status).unwrap_err();
    assert_eq!(garbled.fault().code, "R0648");
    fake.end();
}

#[test]
fn a_rig_that_is_gone_ends_every_wait() {
    let fake = Fake::polite(|mut lines| {
        say(&mut lines, r#"{"event":"gone","why":"the rig stops"}"#);
    });
    let mut client = fake.client().unwrap();
    assert_eq!(client.next(PATIENCE), Err(ClientError::Ended("the rig stops".to_owned())));
    fake.end();

    let fake = Fake::polite(|mut lines| lines.get_mut().write_all(b"{\"event\":\"log\",\"subscr").unwrap());
    let mut client = fake.client().unwrap();
    assert_eq!(client.next(PATIENCE).unwrap_err().fault().code, "R0645");
    fake.end();

    let fake = Fake::polite(|mut lines| assert_eq!(line(&mut lines), ""));
    let (sender, mut receiver) = fake.client().unwrap().split();
    let listens = std::thread::spawn(move || receiver.next(None));
    sender.close();
    assert_eq!(listens.join().unwrap().unwrap_err().fault().code, "R0645");
    fake.end();
}

#[test]
fn who_is_no_rig_of_this_protocol_is_distinguished_from_one() {
    for (first, code) in [
        ("SSH-2.0-OpenSSH\n", "R0643"),
        ("{}\n", "R0643"),
        (
            "{\"rig\":\"other\",\"protocol\":1,\"version\":\"\",\"board\":\"\",\"reference\":\"\",\"client\":1}\n",
            "R0643",
        ),
        (
            "{\"rig\":\"scanrig\",\"protocol\":2,\"version\":\"\",\"board\":\"\",\"reference\":\"\",\"client\":1}\n",
            "R0644",
        ),
        ("{\"id\":null,\"error\":{\"code\":\"R0630\",\"message\":\"full\",\"help\":\"\"}}\n", "R0630"),
        ("", "R0645"),
    ] {
        let fake = Fake::with(first, |_| {});
        assert_eq!(fake.client().unwrap_err().fault().code, code, "{first}");
        fake.end();
    }
    let nowhere = ControlClient::connect(&PathBuf::from("/nowhere/at/all.sock"), "test").unwrap_err();
    assert_eq!(nowhere.fault().code, "R0642");
}

#[test]
fn lines_arrive_whole_however_they_are_cut() {
    let fake = Fake::polite(|mut lines| {
        for place in 0..200 {
            let text = format!(
                "{{\"event\":\"log\",\"subscription\":1,\"at\":{place},\"text\":\"{}\"}}\n",
                "x".repeat(place * 37)
            );
            for piece in text.as_bytes().chunks(1 + place * 61) {
                lines.get_mut().write_all(piece).unwrap();
            }
        }
    });
    let mut client = fake.client().unwrap();
    for place in 0..200_usize {
        let Some(SubscriptionEvent::Log { at, text, .. }) = client.next(PATIENCE).unwrap() else {
            panic!("no line {place}")
        };
        assert_eq!((at, text.len()), (i64::try_from(place).unwrap(), place * 37));
    }
    fake.end();
}

#[test]
fn a_message_is_recognised_by_what_it_has() {
    let read = |text: &str| ServerMessage::read(text.as_bytes());
    assert!(matches!(read(r#"{"ok":{},"id":4}"#), Ok(Some(ServerMessage::Reply(Reply { id: Some(4), .. })))));
    assert!(matches!(
        read(r#"{"subscription":2,"lines":3,"event":"missed"}"#),
        Ok(Some(ServerMessage::Event(SubscriptionEvent::Missed { lines: 3, .. })))
    ));
    assert!(matches!(read(r#"{"event":"later","x":1}"#), Ok(None)));
    assert!(read(r#"{"event":"missed","subscription":2}"#).is_err());
    assert!(read("[]").is_err() && read("").is_err() && read("{\"event\":7}").is_err());
    let all = [
        SubscriptionEvent::Signals { subscription: 1, changes: vec![], missed: 0 },
        SubscriptionEvent::Status { subscription: 1, status: Box::default() },
        log("x"),
        SubscriptionEvent::Missed { subscription: 1, lines: 1 },
        SubscriptionEvent::Gone { why: String::new() },
    ];
    for event in all {
        let text = serde_json::to_string(&event).unwrap();
        assert_eq!(read(&text).unwrap(), Some(ServerMessage::Event(event)), "{text}");
    }
}

#[test]
fn answers_are_taken_from_replies_of_any_reader() {
    let reply = Reply { id: Some(1), ok: Some(serde_json::json!({"plans": []})), error: None };
    assert_eq!(answer::<Plans>(reply).unwrap().plans.len(), 0);
    // What runs on this machine is no matter of a test; that nothing hangs is.
    let _ = running();
    let greeting: Greeting = serde_json::from_str(GREETING).unwrap();
    assert_eq!(greeting.protocol, PROTOCOL);
}
