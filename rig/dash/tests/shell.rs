//! Header, tabs, dialogs, leaving, and the connection.

use crate::sample;
use crate::setup::{DashboardSetup, LOOK, PLAIN, SMALL, views};
use control::{
    ControllerAction, Forces, Locked, RequestFault, RequestOperation, StatusWarning, SubscriptionEvent,
    Value, WireValue,
};
use ratatui::crossterm::event::KeyCode;
use scanrig_dash::{LoopCommand, RigMessage, Shell};

fn setup() -> DashboardSetup {
    DashboardSetup::new(sample::rig(), SMALL, LOOK)
}

#[test]
fn what_moves_outputs_is_asked_before() {
    let mut setup = setup();
    setup.press(":").key(KeyCode::Down).key(KeyCode::Enter);
    assert!(setup.asked.is_empty());
    setup.press("n");
    assert!(setup.asked.is_empty());
    setup.press(":").key(KeyCode::Down).key(KeyCode::Enter).press("x").press("y");
    assert_eq!(setup.asked, [RequestOperation::Command { action: ControllerAction::Stop }]);
    assert!(setup.screen().contains("Stop: done"));
}

#[test]
fn the_mouse_gives_commands_too() {
    let mut setup = setup();
    setup.press(":").click("Reset cold").click("yes");
    assert_eq!(setup.asked, [RequestOperation::Command { action: ControllerAction::ResetCold }]);
}

#[test]
fn leaving_asks_what_becomes_of_forces() {
    for (keys, forces) in [("qk", Forces::Keep), ("qr", Forces::Release)] {
        let mut setup = setup();
        setup.press(keys);
        assert_eq!(
            (setup.asked, setup.wants),
            (vec![RequestOperation::Leave { forces }], vec![LoopCommand::End])
        );
    }
    let mut setup = setup();
    setup.press("qs");
    assert!(setup.asked.is_empty() && setup.wants.is_empty());
    setup.rig.status.forced.clear();
    setup.report_status();
    setup.press("q");
    assert_eq!(
        (setup.asked, setup.wants),
        (vec![RequestOperation::Leave { forces: Forces::Keep }], vec![LoopCommand::End])
    );
}

#[test]
fn one_who_may_not_release_does_not_leave_unasked() {
    let mut setup = setup();
    let message = "the rig is locked".to_owned();
    setup.rig.fault = Some(RequestFault { code: "R0625".to_owned(), message, help: "unlock it".to_owned() });
    setup.press("qr");
    assert!(setup.wants.is_empty());
    assert!(setup.screen().contains("!! R0625 the rig is locked: unlock it"));
}

#[test]
fn a_rig_of_its_own_ends_only_when_that_is_said() {
    let shell = Shell::new(views(), LOOK, true);
    let mut setup = DashboardSetup::with(shell, sample::rig(), SMALL);
    setup.control('c');
    assert!(setup.wants.is_empty());
    assert!(setup.screen().contains("Leave and end the rig"));
    setup.press("l");
    assert_eq!(setup.wants, [LoopCommand::End]);
}

#[test]
fn what_cannot_be_trusted_and_what_is_forced_stands_out_without_colours() {
    let mut setup = DashboardSetup::new(sample::rig(), SMALL, PLAIN);
    for text in ["!! Do not trust figures: the device `adc` is lost", "FORCED 2: %QX0.1=TRUE  %IX0.3=FALSE"] {
        assert!(setup.stands_out(text), "{text}:\n{}", setup.screen());
    }
    setup.rig.status.troubles =
        vec![StatusWarning { kind: "overrun".to_owned(), text: "2 overruns".to_owned() }];
    setup.rig.status.forced.clear();
    setup.rig.status.locked = Some(Locked { by: "anna".to_owned(), note: "accepted".to_owned() });
    setup.report_status();
    assert!(setup.stands_out("2 overruns") && setup.stands_out("Locked by anna: accepted"));
    assert!(!setup.screen().contains("FORCED"));
    // On every view, and on a window that is too small for one.
    setup.press("2");
    assert!(setup.stands_out("2 overruns"));
    let mut setup = DashboardSetup::new(sample::rig(), (60, 10), PLAIN);
    let screen = setup.screen();
    assert!(screen.contains("80 x 24 is needed") && screen.contains("FORCED 2"), "{screen}");
}

#[test]
fn indicators_flash_with_the_times_of_the_rig() {
    let mut setup = setup();
    for (at, lit) in [(9_520, false), (10_000, true), (10_499, true), (10_500, false)] {
        setup.rig.status.at = at * 1_000_000;
        setup.report_status();
        assert_eq!(setup.screen().contains("I/O ●"), lit, "{at} ms");
    }
    // What passed since the status came counts.
    setup.shell.pass(500_000_000);
    assert!(setup.screen().contains("I/O ●"));
}

#[test]
fn a_lost_connection_is_shown_and_taken_up_again() {
    let mut setup = setup();
    setup.shell.receive(RigMessage::Disconnected("the rig ended; trying again".to_owned()));
    assert!(setup.stands_out("!! No connection: the rig ended; trying again"));
    setup.press(":").key(KeyCode::Enter).press("y");
    assert!(setup.asked.is_empty(), "nothing is sent later that was wanted now");
    setup.subscriptions.clear();
    setup.others.clear();
    setup.connect();
    assert!(!setup.screen().contains("No connection"));
    assert_eq!(setup.others.values().filter(|topic| matches!(topic, control::Topic::Log)).count(), 1);
    // Leaving without a connection needs no answer.
    setup.shell.receive(RigMessage::Disconnected("gone".to_owned()));
    setup.press("q");
    assert_eq!(setup.wants, [LoopCommand::End]);
}

#[test]
fn the_lock_says_why() {
    let mut setup = setup();
    setup.press(":").key(KeyCode::End).key(KeyCode::Enter).enter("accepted by Anna");
    assert_eq!(setup.asked, [RequestOperation::Lock { note: "accepted by Anna".to_owned() }]);
}

#[test]
fn the_log_stays_where_somebody_reads() {
    let mut setup = setup();
    setup.click("Log");
    let log =
        |at: i64| SubscriptionEvent::Log { subscription: 0, at: at * 1_000_000, text: format!("line {at}") };
    (0..100).for_each(|at| setup.report(log(at)));
    assert!(setup.screen().contains("line 99"));
    setup.key(KeyCode::PageUp);
    let before = setup.screen();
    setup.report(log(100));
    let after = setup.screen();
    let shown = |screen: &str| screen.lines().find(|line| line.contains("line ")).unwrap().to_owned();
    assert_eq!(shown(&before), shown(&after));
    assert!(after.contains("more below") && !after.contains("line 100"));
    setup.key(KeyCode::End);
    assert!(setup.screen().contains("line 100"));
    setup.press("/").enter("line 42");
    let screen = setup.screen();
    assert!(screen.contains("1 of 104 lines") && screen.contains("line 42"), "{screen}");
}

#[test]
fn only_what_is_shown_is_subscribed_to() {
    let mut setup = setup();
    let asked = |setup: &DashboardSetup| {
        setup.subscriptions.values().any(|(names, _)| names.iter().any(|n| n == "HSC0.value"))
    };
    assert!(!asked(&setup));
    setup.click("Expert");
    assert!(asked(&setup) && setup.screen().contains("14820"), "{}", setup.screen());
    setup.change("HSC0.value", 9_600_000_000, WireValue(Value::Int(14_821)));
    assert!(setup.screen().contains("14821"));
    setup.click("Tasks");
    assert!(!asked(&setup));
}

#[test]
fn what_the_rig_says_cannot_command_the_terminal() {
    let mut setup = setup();
    let text = "a\x1b[2Jb\x07c\nd\u{9b}1m".to_owned();
    setup.report(SubscriptionEvent::Log { subscription: 0, at: 0, text });
    setup.rig.status.state = "\x1b]0;title\x07".to_owned();
    setup.report_status();
    setup.click("Log");
    assert!(!setup.screen().chars().any(|character| character.is_control() && character != '\n'));
}
