//! The socket's file.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::os::unix::net::UnixListener;
use std::time::{Duration, Instant};

use control::{Connection, connect};
use rustix::fs::{FlockOperation, flock};
use scanrig_services::control::{SocketSettings, serve};
use serde_json::json;

use crate::bench::{Bench, Client};
use crate::fake::Fake;

/// The code of what is refused.
fn refused(settings: SocketSettings) -> String {
    serve(Fake::default(), settings, |_| {}).expect_err("a refusal").code
}

#[test]
fn the_owner_and_the_group_may_connect_and_nothing_is_left() {
    let mut bench = Bench::new();
    let mode = fs::metadata(&bench.socket).expect("the socket").permissions().mode();
    assert_eq!(mode & 0o777, 0o660);
    let others = || fs::read_dir(bench.folder.path()).expect("the folder").count();
    assert_eq!(others(), 1);
    drop(bench.serving.take());
    assert_eq!(others(), 0);
}

#[test]
fn a_dead_rigs_socket_is_taken_over_and_a_live_one_is_not() {
    let bench = Bench::new();
    assert_eq!(refused(SocketSettings::of(bench.socket.clone())), "R0630");
    bench.client();
    // What a killed rig leaves: a socket that nobody listens at.
    let dead = bench.folder.path().join("dead.sock");
    drop(UnixListener::bind(&dead).expect("a socket"));
    let serving = serve(Fake::default(), SocketSettings::of(dead.clone()), |_| {}).expect("a socket");
    let mut client = Client::connect(serving.path());
    assert_eq!(client.line()["client"], 1);
    // Somebody removed the file, and another rig serves its name now: that one's file stays.
    fs::remove_file(&dead).expect("the file");
    let other = serve(Fake::default(), SocketSettings::of(dead.clone()), |_| {}).expect("a socket");
    drop(serving);
    let mut client = Client::connect(other.path());
    client.line();
    assert_eq!(client.ok(json!({"do": "read", "names": ["m1"]})), json!({"values": [0]}));
}

#[test]
fn what_cannot_be_a_socket_is_refused_and_stays() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("notes");
    fs::write(&file, "mine").expect("a file");
    assert_eq!(refused(SocketSettings::of(file.clone())), "R0631");
    assert_eq!(fs::read(&file).expect("the file"), b"mine");
    assert_eq!(refused(SocketSettings::of(file.join("rig.sock"))), "R0631");
    assert_eq!(refused(SocketSettings::of(folder.path().join("x".repeat(100)))), "R0631");
    let group = Some("no-such-group-of-anybody".into());
    let settings = SocketSettings { group, ..SocketSettings::of(folder.path().join("rig.sock")) };
    assert_eq!(refused(settings), "R0632");
    // A folder that is not there yet is made.
    let deep = folder.path().join("a/b/rig.sock");
    drop(serve(Fake::default(), SocketSettings::of(deep.clone()), |_| {}).expect("a socket"));
    assert!(deep.parent().is_some_and(std::path::Path::is_dir) && !deep.exists());
}

/// How long a rig may wait for another program at its start and its end.
const BOUND: Duration = Duration::from_secs(20);

#[test]
fn a_rig_whose_backlog_is_full_has_its_socket_and_is_not_waited_for() {
    let folder = tempfile::tempdir().expect("a folder");
    let socket = folder.path().join("stopped.sock");
    let _listener = UnixListener::bind(&socket).expect("a socket");
    let mut waiting = Vec::new();
    while let Connection::Open(stream) = connect(&socket, Duration::ZERO).expect("somebody listens") {
        waiting.push(stream);
    }
    assert_eq!(refused(SocketSettings::of(socket)), "R0630");
}

#[test]
fn who_holds_the_lock_on_the_folder_holds_up_neither_the_start_nor_the_end() {
    let mut bench = Bench::new();
    let folder = fs::File::open(bench.folder.path()).expect("the folder");
    flock(&folder, FlockOperation::LockExclusive).expect("the lock");
    let began = Instant::now();
    assert_eq!(refused(SocketSettings::of(bench.folder.path().join("other.sock"))), "R0631");
    let mut client = bench.client();
    drop(bench.serving.take());
    assert_eq!(client.line()["event"], "gone");
    assert!(began.elapsed() < BOUND, "{:?}", began.elapsed());
    // What it could not remove is taken over.
    drop(folder);
    bench.start(|_| {});
    bench.client();
}
