//! The table of expansion modules.

use crate::sample;
use crate::setup::{DashboardSetup, LOOK, SMALL};
use control::ModuleInfo;

#[test]
fn modules_stand_above_the_buses_with_their_states() {
    let mut rig = sample::rig();
    rig.status.modules = vec!["TM3_OK".to_owned(), "TM3_MISSING_OPT_MOD".to_owned()];
    let mut described = sample::description();
    described.modules = vec![
        ModuleInfo { index: 0, reference: "TM3DI16".to_owned(), optional: false },
        ModuleInfo { index: 7, reference: "TM3DQ16T".to_owned(), optional: true },
    ];
    rig.description = described;
    let mut setup = DashboardSetup::new(rig, SMALL, LOOK);
    setup.press("5");
    let screen = setup.screen();
    let rows: Vec<Vec<&str>> = screen.lines().map(|line| line.split_whitespace().collect()).collect();
    assert!(rows.contains(&vec!["TM3DI16", "0", "TM3_OK"]), "{screen}");
    assert!(rows.contains(&vec!["TM3DQ16T", "7", "optional", "TM3_MISSING_OPT_MOD"]), "{screen}");
    assert!(screen.contains("Received"), "the buses follow:\n{screen}");
}
