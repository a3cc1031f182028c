//! Once it has run for a while, a board of serial lines allocates nothing, on no thread.

use std::fs::File;
use std::io::{Read, Write};

use host::Realtime;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use scanrig_drivers::{Board, BoardContext, BoardExt, BusEvent, BusId, Terminals, open, read};
use signal::{SerialOutput, Span, Time};

pub fn messages_allocate_nothing() {
    let far = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
    grantpt(&far).unwrap();
    unlockpt(&far).unwrap();
    let path = ptsname(&far, Vec::new()).unwrap().into_string().unwrap();
    let mut far = File::from(far);
    let text = format!(
        "format = 1\n[board]\nkind = \"real\"\nunresponsive-after = \"20 s\"\n[buses]\n\
         line = {{ kind = \"serial\", path = \"{path}\", baud = 115200 }}\n"
    );
    let file = read(&document::SourceFile::new("board.toml", text), &|_| Ok(Terminals::default())).unwrap();
    let at = BoardContext::new(Realtime::default());
    let mut board = open(&file, &at).unwrap().unwrap();
    at.time.restart();
    board.start(Time::ZERO).unwrap();
    // Order and answer; the answer is longer than a message, and comes in two parts.
    let (output, answer) = (SerialOutput::plain(&[0x5A; 40]), [0xA5; 300]);
    let mut events = Vec::with_capacity(64);
    let (mut before, mut ordered) = (0, [0; 40]);
    for turn in 0..300 {
        if turn == 100 {
            before = counting::of_all_threads();
        }
        board.send_serial(at.time.now(), BusId(0), &output).unwrap();
        far.read_exact(&mut ordered).unwrap();
        far.write_all(&answer).unwrap();
        let due = at.time.now() + Span::from_secs(20);
        let mut whole = false;
        while !whole {
            assert!(at.time.now() < due, "turn {turn}: {:?}", board.health());
            events.clear();
            board.poll_buses(at.time.now(), &mut events).unwrap();
            whole = events.iter().any(
                |event| matches!(event, BusEvent::SerialMessage { message, own: false, .. } if message.ends),
            );
            if !whole {
                at.bell.wait_until(at.time.stamp(at.time.now() + Span::from_millis(5)));
            }
        }
    }
    assert_eq!(counting::of_all_threads() - before, 0, "allocations in 200 orders and their answers");
}
