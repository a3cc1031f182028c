//! The dashboard before a rig in stepped time, over its socket: what it shows is the same with every run.
//!
//! `SCANRIG_BLESS=1 cargo test -p scanrig-cli --test end_to_end dashboard` writes the goldens again.

mod floor;
mod setup;

use control::{PlanEvent, RequestOperation, Value};
use floor::floor;
use ratatui::crossterm::event::KeyCode;
use setup::{DashboardSetup, MS, SMALL, scene};

fn force(setup: &mut DashboardSetup, name: &str, on: bool) {
    setup.ask(RequestOperation::Force { name: name.into(), value: control::WireValue(Value::Bool(on)) });
}

#[test]
fn every_view_shows_a_rig_that_runs() {
    scene(|features| {
        let mut setup = DashboardSetup::conveyor(features);
        setup.advance(7_300 * MS);
        setup.golden("io");
        for (key, name) in [("3", "tasks"), ("4", "expert"), ("5", "buses"), ("6", "log"), ("7", "plan")] {
            setup.keys(key);
            if name == "plan" {
                // Of one file: the list of those that ship is another one with every plan that is added.
                setup.keys("olamp.toml\n");
            }
            if name == "log" {
                // The controller's own: whether it booted before or after a client came is between two processes.
                setup.keys("/boot\n");
            }
            setup.golden(name);
        }
    });
}

#[test]
fn inputs_and_outputs_are_found_and_forced() {
    scene(|features| {
        let mut setup = DashboardSetup::conveyor(features);
        setup.advance(2_000 * MS);
        setup.keys("v$");
        setup.advance(200 * MS);
        setup.golden("io-variables");
        setup.keys("v/Q6\nf");
        setup.golden("io-force");
        setup.key(KeyCode::Enter);
        force(&mut setup, "I3", false);
        setup.advance(200 * MS);
        setup.keys("/forced\n");
        setup.golden("io-filter");
        for key in "1234567".chars() {
            setup.key(KeyCode::Char(key));
            let screen = setup.screen(SMALL);
            assert!(screen.contains("FORCED 2: ") && screen.contains("%QX0.6="), "{screen}");
        }
    });
}

#[test]
fn dialogs() {
    scene(|features| {
        let mut setup = DashboardSetup::conveyor(features);
        setup.advance(1_000 * MS);
        force(&mut setup, "Q6", true);
        setup.ask(RequestOperation::Lock { note: "accepted".into() });
        setup.advance(100 * MS);
        setup.keys("?");
        setup.golden("help");
        setup.keys("\x1b:");
        setup.golden("commands");
        setup.keys("|\n");
        setup.golden("sure");
        setup.keys("nq");
        setup.golden("leave");
    });
}

#[test]
fn tasks_with_something_to_do() {
    scene(|features| {
        let mut setup = floor(features);
        setup.keys("3");
        setup.advance(1_000 * MS);
        setup.golden("tasks-loaded");
        setup.keys("|h");
        setup.golden("tasks-rig");
    });
}

#[test]
fn frames_on_buses() {
    scene(|features| {
        let mut setup = floor(features);
        setup.keys("7oplans/frames.toml\n");
        setup.keys("5");
        setup.ask(RequestOperation::Plan { name: "plans/frames".into() });
        setup.until(is_over);
        setup.advance(100 * MS);
        setup.golden("frames");
        setup.keys("ox");
        setup.golden("frames-each");
        setup.keys("o/18f\n");
        setup.golden("frames-filter");
        setup.keys("ddrive.dbc\n");
        setup.golden("frames-meaning");
    });
}

fn is_over(setup: &DashboardSetup) -> bool {
    let model = setup.shell.model();
    matches!(model.plan.last(), Some(PlanEvent::Over { .. })) && model.status.plan.is_none()
}

#[test]
fn a_plan_is_run_and_followed() {
    scene(|features| {
        let mut setup = floor(features);
        setup.keys("7oplans/lamp.toml\n");
        setup.golden("plan-list");
        setup.keys("\n");
        setup.golden("plan-sure");
        // Both cases, as a script would ask for them.
        setup.keys("n");
        setup.ask(RequestOperation::Plan { name: "plans/lamp".into() });
        // In the second case, while its last step is still to come.
        setup.until(|setup| {
            let second = |event: &PlanEvent| matches!(event, PlanEvent::Case { place: (2, _), .. });
            let events = &setup.shell.model().plan;
            let begin = events.iter().position(second).unwrap_or(events.len());
            events[begin..].iter().any(|event| matches!(event, PlanEvent::Step { step: 0, done: true, .. }))
        });
        setup.golden("plan-running");
        setup.until(is_over);
        setup.advance(100 * MS);
        setup.golden("plan-over");
        setup.keys("^");
        setup.golden("plan-ended-case");
        // One alone, as the user chooses it.
        setup.keys("l\ny");
        setup.until(|setup| !is_over(setup));
        setup.until(is_over);
        assert!(setup.screen(SMALL).contains("case 1 of 1"), "{}", setup.screen(SMALL));
    });
}

#[test]
fn a_trend_of_a_rig_that_runs() {
    scene(|features| {
        let mut setup = DashboardSetup::conveyor(features);
        setup.keys("2");
        setup.golden("trend-empty");
        for name in ["temperature", "BELT.position", "pusher-out", "state"] {
            setup.choose(name);
        }
        setup.play(60, 200 * MS);
        setup.golden("trend");
        setup.keys("i");
        setup.golden("trend-picker");
        setup.keys("\x1ba<<<eb>>>ee");
        setup.golden("trend-cursors");
        setup.keys("|");
        setup.golden("trend-cursors-number");
    });
}

#[test]
fn a_trigger_shows_what_it_waited_for() {
    scene(|features| {
        let mut setup = DashboardSetup::conveyor(features);
        setup.keys("2");
        for name in ["pusher-out", "BELT.position"] {
            setup.choose(name);
        }
        setup.advance(1_000 * MS);
        // One rising edge of the pusher's contact, half of the window before it, and what it is after it.
        setup.keys("++t>>>");
        setup.golden("trend-trigger-setting");
        setup.keys("\n");
        setup.advance(200 * MS);
        setup.golden("trend-trigger-armed");
        setup.play(60, 200 * MS);
        setup.golden("trend-trigger-done");
        setup.keys("aebe");
        setup.golden("trend-trigger-cursors");
        setup.keys("\x1bs\n");
        let saved = setup.files.saved("trend.vcd");
        assert_eq!(saved.tracks.len(), 2);
        let contact: Vec<bool> =
            saved.samples.iter().filter(|s| s.track == 0).filter_map(|s| s.value.0.as_bool()).collect();
        // Contacts bounce, and every edge of that is there.
        assert!(contact.len() > 8 && contact.windows(2).all(|two| two[0] != two[1]), "{contact:?}");
        setup.keys("otrend.vcd\n");
        setup.golden("trend-file");
    });
}
