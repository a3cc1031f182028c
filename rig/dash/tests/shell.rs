//! Header, tabs, dialogs, leaving, and the connection.

use crate::bench::{Bench, LOOK, PLAIN, SMALL, views};
use crate::sample;
use control::{Action, Ask, Event, Fault, Forces, Locked, Trouble, Value, WireValue};
use ratatui::crossterm::event::KeyCode;
use scanrig_dash::{Heard, Shell, Want};

fn bench() -> Bench {
    Bench::new(sample::rig(), SMALL, LOOK)
}

#[test]
fn what_moves_outputs_is_asked_before() {
    let mut bench = bench();
    bench.press(":").key(KeyCode::Down).key(KeyCode::Enter);
    assert!(bench.asked.is_empty());
    bench.press("n");
    assert!(bench.asked.is_empty());
    bench.press(":").key(KeyCode::Down).key(KeyCode::Enter).press("x").press("y");
    assert_eq!(bench.asked, [Ask::Command { action: Action::Stop }]);
    assert!(bench.screen().contains("Stop: done"));
}

#[test]
fn the_mouse_gives_commands_too() {
    let mut bench = bench();
    bench.press(":").click("Reset cold").click("yes");
    assert_eq!(bench.asked, [Ask::Command { action: Action::ResetCold }]);
}

#[test]
fn leaving_asks_what_becomes_of_forces() {
    for (keys, forces) in [("qk", Forces::Keep), ("qr", Forces::Release)] {
        let mut bench = bench();
        bench.press(keys);
        assert_eq!((bench.asked, bench.wants), (vec![Ask::Leave { forces }], vec![Want::End]));
    }
    let mut bench = bench();
    bench.press("qs");
    assert!(bench.asked.is_empty() && bench.wants.is_empty());
    bench.rig.status.forced.clear();
    bench.tell_status();
    bench.press("q");
    assert_eq!((bench.asked, bench.wants), (vec![Ask::Leave { forces: Forces::Keep }], vec![Want::End]));
}

#[test]
fn one_who_may_not_release_does_not_leave_unasked() {
    let mut bench = bench();
    let message = "the rig is locked".to_owned();
    bench.rig.fault = Some(Fault { code: "R0625".to_owned(), message, help: "unlock it".to_owned() });
    bench.press("qr");
    assert!(bench.wants.is_empty());
    assert!(bench.screen().contains("!! R0625 the rig is locked: unlock it"));
}

#[test]
fn a_rig_of_its_own_ends_only_when_that_is_said() {
    let shell = Shell::new(views(), LOOK, true);
    let mut bench = Bench::with(shell, sample::rig(), SMALL);
    bench.control('c');
    assert!(bench.wants.is_empty());
    assert!(bench.screen().contains("Leave and end the rig"));
    bench.press("l");
    assert_eq!(bench.wants, [Want::End]);
}

#[test]
fn what_cannot_be_trusted_and_what_is_forced_stands_out_without_colours() {
    let mut bench = Bench::new(sample::rig(), SMALL, PLAIN);
    for text in ["!! Do not trust figures: the device `adc` is lost", "FORCED 2: %QX0.1=TRUE  %IX0.3=FALSE"] {
        assert!(bench.stands_out(text), "{text}:\n{}", bench.screen());
    }
    bench.rig.status.troubles = vec![Trouble { kind: "overrun".to_owned(), text: "2 overruns".to_owned() }];
    bench.rig.status.forced.clear();
    bench.rig.status.locked = Some(Locked { by: "anna".to_owned(), note: "accepted".to_owned() });
    bench.tell_status();
    assert!(bench.stands_out("2 overruns") && bench.stands_out("Locked by anna: accepted"));
    assert!(!bench.screen().contains("FORCED"));
    // On every view, and on a window that is too small for one.
    bench.press("2");
    assert!(bench.stands_out("2 overruns"));
    let mut bench = Bench::new(sample::rig(), (60, 10), PLAIN);
    let screen = bench.screen();
    assert!(screen.contains("80 x 24 is needed") && screen.contains("FORCED 2"), "{screen}");
}

#[test]
fn indicators_flash_with_the_times_of_the_rig() {
    let mut bench = bench();
    for (at, lit) in [(9_520, false), (10_000, true), (10_499, true), (10_500, false)] {
        bench.rig.status.at = at * 1_000_000;
        bench.tell_status();
        assert_eq!(bench.screen().contains("I/O ●"), lit, "{at} ms");
    }
    // What passed since the status came counts.
    bench.shell.pass(500_000_000);
    assert!(bench.screen().contains("I/O ●"));
}

#[test]
fn a_lost_connection_is_shown_and_taken_up_again() {
    let mut bench = bench();
    bench.shell.hear(Heard::Lost("the rig ended; trying again".to_owned()));
    assert!(bench.stands_out("!! No connection: the rig ended; trying again"));
    bench.press(":").key(KeyCode::Enter).press("y");
    assert!(bench.asked.is_empty(), "nothing is sent later that was wanted now");
    bench.subscriptions.clear();
    bench.others.clear();
    bench.connect();
    assert!(!bench.screen().contains("No connection"));
    assert_eq!(bench.others.values().filter(|topic| matches!(topic, control::Topic::Log)).count(), 1);
    // Leaving without a connection needs no answer.
    bench.shell.hear(Heard::Lost("gone".to_owned()));
    bench.press("q");
    assert_eq!(bench.wants, [Want::End]);
}

#[test]
fn the_lock_says_why() {
    let mut bench = bench();
    bench.press(":").key(KeyCode::End).key(KeyCode::Enter).enter("accepted by Anna");
    assert_eq!(bench.asked, [Ask::Lock { note: "accepted by Anna".to_owned() }]);
}

#[test]
fn the_log_stays_where_somebody_reads() {
    let mut bench = bench();
    bench.click("Log");
    let log = |at: i64| Event::Log { subscription: 0, at: at * 1_000_000, text: format!("line {at}") };
    (0..100).for_each(|at| bench.tell(log(at)));
    assert!(bench.screen().contains("line 99"));
    bench.key(KeyCode::PageUp);
    let before = bench.screen();
    bench.tell(log(100));
    let after = bench.screen();
    let shown = |screen: &str| screen.lines().find(|line| line.contains("line ")).unwrap().to_owned();
    assert_eq!(shown(&before), shown(&after));
    assert!(after.contains("more below") && !after.contains("line 100"));
    bench.key(KeyCode::End);
    assert!(bench.screen().contains("line 100"));
    bench.press("/").enter("line 42");
    let screen = bench.screen();
    assert!(screen.contains("1 of 104 lines") && screen.contains("line 42"), "{screen}");
}

#[test]
fn only_what_is_shown_is_subscribed_to() {
    let mut bench = bench();
    let asked = |bench: &Bench| {
        bench.subscriptions.values().any(|(names, _)| names.iter().any(|n| n == "HSC0.value"))
    };
    assert!(!asked(&bench));
    bench.click("Expert");
    assert!(asked(&bench) && bench.screen().contains("14820"), "{}", bench.screen());
    bench.change("HSC0.value", 9_600_000_000, WireValue(Value::Int(14_821)));
    assert!(bench.screen().contains("14821"));
    bench.click("Tasks");
    assert!(!asked(&bench));
}

#[test]
fn what_the_rig_says_cannot_command_the_terminal() {
    let mut bench = bench();
    let text = "a\x1b[2Jb\x07c\nd\u{9b}1m".to_owned();
    bench.tell(Event::Log { subscription: 0, at: 0, text });
    bench.rig.status.state = "\x1b]0;title\x07".to_owned();
    bench.tell_status();
    bench.click("Log");
    assert!(!bench.screen().chars().any(|character| character.is_control() && character != '\n'));
}
