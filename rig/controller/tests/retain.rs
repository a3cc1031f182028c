//! Remanent variables under power cuts (controller:REM-02, controller:REM-07).

use crate::support::*;
use scanrig_controller::*;
use signal::{Span, Time};

/// Each cycle: n := n + 1, then m := n, both RETAIN; plain counts beside them; %MW3 follows.
fn script() -> Script {
    let mut script = Script::new(vec![vec![
        (100_000, Act::Add(0, 1)),
        (100_000, Act::Move(0, 1)),
        (100_000, Act::Add(2, 1)),
        (100_000, Act::Store(at("%MW3"), 33)),
    ]]);
    script.variables = vec![(0, Keep::Retain), (0, Keep::Retain), (0, Keep::Plain)];
    script
}

/// Cuts the supply so that the power is gone at `gone`, and comes back; how many cycles the context holds.
fn cut(gone: Time) -> i64 {
    let mut rig = Rig::running(config(), script());
    rig.to(gone - ms(4));
    rig.power_off();
    rig.to(gone);
    let before = rig.variable(0);
    rig.after(ms(500));
    rig.power_on();
    rig.after(ms(1_499));
    assert_eq!(rig.plc.state(), State::Booting);
    rig.after(us(1_050));
    assert_eq!(rig.plc.state(), State::Running, "cut at {gone}");
    let (n, m, plain) = (rig.variable(0), rig.variable(1), rig.variable(2));
    assert_eq!(n, m, "a mixture of two contexts at {gone}");
    assert!((before - n).abs() <= 1, "{n} is not near {before} at {gone}");
    assert_eq!((plain, rig.memory("%MW3")), (0, 33));
    n
}

#[test]
fn a_cut_anywhere_in_a_cycle_keeps_a_whole_context() {
    for step in 0..=540 {
        cut(run_at(ms(100) + us(37) * step));
    }
}

/// A cycle ends 0.4 ms after its start; its save takes 1 ms. Byte by byte of the image.
#[test]
fn a_cut_anywhere_in_a_save_keeps_the_context_before() {
    let start = run_at(us(100_400));
    for nanos in (0..1_000_000).step_by(487) {
        let held = cut(start + Span::from_nanos(nanos));
        assert_eq!(held, 5, "cut {nanos} ns into the save");
    }
    assert_eq!(cut(start + us(1_000)), 6, "the whole image was written");
    assert_eq!(cut(start + us(1_001)), 6);
}

/// The images alternate, and damage to the newer one brings back the older.
#[test]
fn the_other_image_stands_in() {
    let mut rig = Rig::running(config(), script());
    rig.after(ms(50));
    rig.power_off();
    rig.after(ms(10));
    let images = RETAIN_FILES.map(|name| rig.files.read(name).unwrap());
    let newer = usize::from(images[1][8] > images[0][8]);
    assert_ne!(images[0][8], images[1][8]);
    for place in [0, 8, 30, 2_010, images[newer].len() - 1] {
        let mut damaged = images[newer].clone();
        damaged[place] ^= 1;
        rig.files.write(RETAIN_FILES[newer], &damaged);
        rig.files.write(RETAIN_FILES[1 - newer], &images[1 - newer]);
        rig.power_on();
        rig.after(ms(1_500));
        rig.settle();
        assert_eq!((rig.variable(0), rig.variable(1)), (2, 2), "byte {place}");
        rig.power_off();
        rig.after(ms(10));
        rig.files.write(STATE_FILE, b"");
    }
}

/// A context is taken only while no cycle is half done.
#[test]
fn a_faster_task_never_saves_a_half_cycle() {
    for gone in (0..60).map(|step| run_at(ms(100) + us(333) * step)) {
        let mut config = config();
        config.tasks.push(task("FAST", 0, ms(1)));
        let mut script = script();
        script.tasks[0] = vec![(3_000_000, Act::Add(0, 1)), (3_000_000, Act::Move(0, 1))];
        script.tasks.push(vec![(10_000, Act::Add(2, 1))]);
        let mut rig = Rig::running(config, script);
        rig.to(gone - ms(4));
        rig.power_off();
        rig.after(ms(10));
        rig.power_on();
        rig.after(ms(1_501));
        assert_eq!(rig.variable(0), rig.variable(1), "cut at {gone}");
    }
}
