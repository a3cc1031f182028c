//! Devices of each kind, lost one after the other under one run.

use super::world::{Loss, World, board};
use super::{RUN, TEST, files};
use crate::rig::{Rig, guards};
use devices::{Lab, MAIN};

/// A case for each loss, and one that nothing happens to.
fn plan() -> String {
    let rows = Loss::ALL.iter().map(|loss| format!("{loss:?} = {{ lasts = \"300 s\" }}\n"));
    format!(
        r#"format = 1
title = "The lamp is on"
program = "main.st"
signals = {{ lamp = "%QX0.0" }}
ends = "start + $lasts"
expect = [{{ stays = {{ signal = "lamp", is = true, from = "start + 300 ms", until = "start + 600 ms" }} }}]
[rows]
{}sound = {{ lasts = "1 s" }}
"#,
        rows.collect::<String>()
    )
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_device_of_any_kind_that_is_lost_ends_its_case_and_is_there_for_the_next() {
    let lab = Lab::enter();
    let mut world = World::enter(&lab);
    let mut rig = Rig::start("every", &files(board("reconnect = true"), plan()), &TEST);
    for loss in Loss::ALL {
        rig.until(&format!("both lamps are on: {loss:?}"), || MAIN.line(8).value() && world.far_is_on());
        world.lose(loss);
        rig.until(&format!("the lamp is off: {loss:?}"), || !MAIN.line(8).value());
        // Whatever is still there is safe, not only what is beside the device that is lost.
        rig.until(&format!("the other lamp is off: {loss:?}"), || loss == Loss::Chip || !world.far_is_on());
        world.restore(loss);
    }
    assert_eq!(rig.exit_code(), Some(4), "{}", rig.said());
    assert!(!MAIN.line(8).value() && !world.far_is_on() && guards() == 0, "{}", rig.said());
    let found = rig.cases();
    assert_eq!(found.len(), Loss::ALL.len() + 1, "{}", rig.said());
    let (said, junit) = (rig.said(), rig.file("report/junit.xml"));
    for (loss, [verdict, reason, ended]) in Loss::ALL.iter().zip(&found) {
        assert_eq!([verdict.as_str(), ended.as_str()], ["error", "a device was lost"], "{loss:?}: {reason}");
        let [whom, how] = loss.words();
        assert!(
            reason.starts_with(&format!("{whom} was lost at ")) && reason.contains(how),
            "{loss:?}: {reason}"
        );
        assert!(said.contains(reason) && junit.contains(reason), "{loss:?}: {reason}\n{said}");
    }
    // On a machine that stands still now and then it need not be sure of it.
    let last = &found[Loss::ALL.len()];
    assert!(["pass", "inconclusive"].contains(&last[0].as_str()), "{last:?}");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_controller_that_is_kept_running_goes_on_without_any_device_and_has_it_again() {
    let lab = Lab::enter();
    let mut world = World::enter(&lab);
    let rest = "reconnect = true\non-loss = \"go-on\"";
    let mut rig = Rig::start("goes-on", &files(board(rest), plan()), &[&RUN[..], &["--booted"]].concat());
    let mut reported = 0;
    for loss in Loss::ALL {
        rig.until(&format!("both lamps are on: {loss:?}"), || MAIN.line(8).value() && world.far_is_on());
        world.lose(loss);
        let [whom, how] = loss.words();
        let lost = |line: &str| line.contains(&format!("{whom} was lost at ")) && line.contains(how);
        rig.until(&format!("it says so: {loss:?}"), || rig.said()[reported..].lines().any(lost));
        world.restore(loss);
        let back = format!("{whom} is back at ");
        rig.until(&format!("it says that it is back: {loss:?}"), || rig.said()[reported..].contains(&back));
        reported = rig.said().len();
        assert!(MAIN.line(8).value(), "{loss:?}: the other output went on: {}", rig.said());
    }
    rig.signal(rustix::process::Signal::INT);
    assert_eq!(rig.exit_code(), Some(4), "{}", rig.said());
    assert!(!MAIN.line(8).value() && !world.far_is_on() && guards() == 0, "{}", rig.said());
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_controller_that_is_kept_running_ends_with_the_loss_where_the_board_file_says_no_more() {
    let lab = Lab::enter();
    for loss in [Loss::IioHangs, Loss::Removed, Loss::Serial] {
        let mut world = World::enter(&lab);
        let mut rig = Rig::start("ends", &files(board(""), plan()), &[&RUN[..], &["--booted"]].concat());
        rig.until(&format!("both lamps are on: {loss:?}"), || MAIN.line(8).value() && world.far_is_on());
        world.lose(loss);
        assert_eq!(rig.exit_code(), Some(4), "{loss:?}: {}", rig.said());
        assert!(!MAIN.line(8).value() && !world.far_is_on() && guards() == 0, "{loss:?}: {}", rig.said());
        let [whom, how] = loss.words();
        let words = [&format!("{whom} was lost at "), how, "outputs safe"];
        assert!(words.iter().all(|words| rig.said().contains(words)), "{loss:?}: {}", rig.said());
        world.restore(loss);
    }
}
