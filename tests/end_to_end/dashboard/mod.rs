//! The dashboard before a rig whose time clients lead, over its socket: what it shows is the same with every run.
//!
//! `SCANRIG_BLESS=1 cargo test -p scanrig-cli --test end_to_end dashboard` writes the goldens anew.

mod floor;
mod stage;

use control::{Ask, PlanEvent, Value};
use floor::floor;
use ratatui::crossterm::event::KeyCode;
use stage::{MS, SMALL, Stage, scene};

fn force(stage: &mut Stage, name: &str, on: bool) {
    stage.ask(Ask::Force { name: name.into(), value: control::WireValue(Value::Bool(on)) });
}

#[test]
fn every_view_shows_a_rig_that_runs() {
    scene(|look| {
        let mut stage = Stage::conveyor(look);
        stage.advance(7_300 * MS);
        stage.golden("io");
        for (key, name) in [("3", "tasks"), ("4", "expert"), ("5", "buses"), ("6", "log"), ("7", "plan")] {
            stage.keys(key);
            if name == "plan" {
                // Of one file: the list of those that ship is another one with every plan that is added.
                stage.keys("olamp.toml\n");
            }
            if name == "log" {
                // The controller's own: whether it booted before or after a client came is between two processes.
                stage.keys("/boot\n");
            }
            stage.golden(name);
        }
    });
}

#[test]
fn inputs_and_outputs_are_found_and_forced() {
    scene(|look| {
        let mut stage = Stage::conveyor(look);
        stage.advance(2_000 * MS);
        stage.keys("v$");
        stage.advance(200 * MS);
        stage.golden("io-variables");
        stage.keys("v/Q6\nf");
        stage.golden("io-force");
        stage.key(KeyCode::Enter);
        force(&mut stage, "I3", false);
        stage.advance(200 * MS);
        stage.keys("/forced\n");
        stage.golden("io-filter");
        for key in "1234567".chars() {
            stage.key(KeyCode::Char(key));
            let screen = stage.screen(SMALL);
            assert!(screen.contains("FORCED 2: ") && screen.contains("%QX0.6="), "{screen}");
        }
    });
}

#[test]
fn dialogs() {
    scene(|look| {
        let mut stage = Stage::conveyor(look);
        stage.advance(1_000 * MS);
        force(&mut stage, "Q6", true);
        stage.ask(Ask::Lock { note: "accepted".into() });
        stage.advance(100 * MS);
        stage.keys("?");
        stage.golden("help");
        stage.keys("\x1b:");
        stage.golden("commands");
        stage.keys("|\n");
        stage.golden("sure");
        stage.keys("nq");
        stage.golden("leave");
    });
}

#[test]
fn tasks_with_something_to_do() {
    scene(|look| {
        let mut stage = floor(look);
        stage.keys("3");
        stage.advance(1_000 * MS);
        stage.golden("tasks-loaded");
        stage.keys("|h");
        stage.golden("tasks-rig");
    });
}

#[test]
fn frames_on_buses() {
    scene(|look| {
        let mut stage = floor(look);
        stage.keys("7oplans/frames.toml\n");
        stage.keys("5");
        stage.ask(Ask::Plan { name: "plans/frames".into() });
        stage.until(is_over);
        stage.advance(100 * MS);
        stage.golden("frames");
        stage.keys("ox");
        stage.golden("frames-each");
        stage.keys("o/18f\n");
        stage.golden("frames-filter");
        stage.keys("ddrive.dbc\n");
        stage.golden("frames-meaning");
    });
}

fn is_over(stage: &Stage) -> bool {
    let model = stage.shell.model();
    matches!(model.plan.last(), Some(PlanEvent::Over { .. })) && model.status.plan.is_none()
}

#[test]
fn a_plan_is_run_and_followed() {
    scene(|look| {
        let mut stage = floor(look);
        stage.keys("7oplans/lamp.toml\n");
        stage.golden("plan-list");
        stage.keys("\n");
        stage.golden("plan-sure");
        // Both cases, as a script would ask for them.
        stage.keys("n");
        stage.ask(Ask::Plan { name: "plans/lamp".into() });
        // In the second case, while its last step is still to come.
        stage.until(|stage| {
            let second = |event: &PlanEvent| matches!(event, PlanEvent::Case { place: (2, _), .. });
            let events = &stage.shell.model().plan;
            let begin = events.iter().position(second).unwrap_or(events.len());
            events[begin..].iter().any(|event| matches!(event, PlanEvent::Step { step: 0, done: true, .. }))
        });
        stage.golden("plan-running");
        stage.until(is_over);
        stage.advance(100 * MS);
        stage.golden("plan-over");
        stage.keys("^");
        stage.golden("plan-ended-case");
        // One alone, as the user chooses it.
        stage.keys("l\ny");
        stage.until(|stage| !is_over(stage));
        stage.until(is_over);
        assert!(stage.screen(SMALL).contains("case 1 of 1"), "{}", stage.screen(SMALL));
    });
}

#[test]
fn a_trend_of_a_rig_that_runs() {
    scene(|look| {
        let mut stage = Stage::conveyor(look);
        stage.keys("2");
        stage.golden("trend-empty");
        for name in ["temperature", "BELT.position", "pusher-out", "state"] {
            stage.choose(name);
        }
        stage.play(60, 200 * MS);
        stage.golden("trend");
        stage.keys("i");
        stage.golden("trend-picker");
        stage.keys("\x1ba<<<eb>>>ee");
        stage.golden("trend-cursors");
        stage.keys("|");
        stage.golden("trend-cursors-number");
    });
}

#[test]
fn a_trigger_shows_what_it_waited_for() {
    scene(|look| {
        let mut stage = Stage::conveyor(look);
        stage.keys("2");
        for name in ["pusher-out", "BELT.position"] {
            stage.choose(name);
        }
        stage.advance(1_000 * MS);
        // One rising edge of the pusher's contact, half of the window before it, and what it is behind it.
        stage.keys("++t>>>");
        stage.golden("trend-trigger-setting");
        stage.keys("\n");
        stage.advance(200 * MS);
        stage.golden("trend-trigger-armed");
        stage.play(60, 200 * MS);
        stage.golden("trend-trigger-done");
        stage.keys("aebe");
        stage.golden("trend-trigger-cursors");
        stage.keys("\x1bs\n");
        let saved = stage.shelf.saved("trend.vcd");
        assert_eq!(saved.tracks.len(), 2);
        let contact: Vec<bool> =
            saved.samples.iter().filter(|s| s.track == 0).filter_map(|s| s.value.0.as_bool()).collect();
        // Contacts bounce, and every edge of that is there.
        assert!(contact.len() > 8 && contact.windows(2).all(|two| two[0] != two[1]), "{contact:?}");
        stage.keys("otrend.vcd\n");
        stage.golden("trend-file");
    });
}
