//! Interfaces that the rig sets up, and starts again.

use devices::Lab;
use drivers::can::{Link, Modes, ask};
use drivers::{BusEvent, BusState, LossReason};
use rustix::thread::{CapabilitySet, capabilities, set_capabilities};
use signal::{CanFrame, Span, Time};

use super::bench::{Bench, FAR, NEAR, TROUBLED, Trouble, fresh, run};

fn frame(id: u32) -> CanFrame {
    CanFrame::classic(id, false, &[0x55; 8]).unwrap()
}

/// An interface but for what changes with the traffic.
fn settings(name: &str) -> Link {
    Link { errors: None, running: false, state: None, ..ask(name).unwrap() }
}

/// The refusal of a board with this bus.
fn refused(bus: &str) -> (String, String, String) {
    let found = Bench::open("", &format!("bus = {{ kind = \"can\", {bus} }}")).err().expect("a refusal");
    let [one] = &found[..] else { panic!("{found:#?}") };
    (one.code.to_owned(), one.message.clone(), one.help.clone())
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_controller_is_started_again_by_the_rig_where_the_kernel_leaves_it() {
    let _lab = Lab::enter();
    fresh("restart-ms 0");
    let mut bench = Bench::of(&TROUBLED.replace(" }", ", restart = \"300 ms\" }"));
    let state = |bench: &Bench, wanted: BusState| -> Option<Time> {
        bench.events.iter().find_map(|event| match *event {
            BusEvent::State { bus, at, state } if bus == NEAR && state == wanted => Some(at),
            _ => None,
        })
    };
    let _off = Trouble::on("rcan0", "event", "bus-off");
    bench.until("bus-off", |bench| state(bench, BusState::BusOff).is_some());
    bench.send(NEAR, &frame(1));
    bench.until("the frame after the restart", |bench| bench.frames(FAR).len() == 1);
    let off = state(&bench, BusState::BusOff).unwrap();
    let on = state(&bench, BusState::ErrorActive).expect("it is told");
    assert!(on - off >= Span::from_millis(300), "{off} {on}");
    assert_eq!(ask("rcan0").unwrap().restart_ms, 0);
    // Each time again, and where a run begins so.
    let _off = Trouble::on("rcan0", "event", "bus-off");
    bench.start();
    bench.send(NEAR, &frame(2));
    bench.until("the second restart", |bench| bench.frames(FAR).iter().any(|(_, got, _)| got.id == 2));
    assert_eq!(bench.board.health().failed_calls, 0);
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn interfaces_are_set_up_and_put_back_as_they_were() {
    let _lab = Lab::enter();
    fresh("bitrate 125000 sample-point 0.8 restart-ms 50 listen-only on");
    run("ip link set rcan1 down");
    let before = [settings("rcan0"), settings("rcan1")];
    let buses = TROUBLED.replace(
        " }",
        ", data-bitrate = 2_000_000, sample-point = 0.75, restart = \"100 ms\", configure = true }",
    );
    let mut bench = Bench::of(&buses);
    for name in ["rcan0", "rcan1"] {
        let link = ask(name).unwrap();
        let bits = link.bits.unwrap();
        assert_eq!((link.up, bits.bitrate, bits.sample_point, link.restart_ms), (true, 500_000, 750, 100));
        assert!(link.modes.has(Modes::FD) && !link.modes.has(Modes::LISTEN_ONLY), "{link:?}");
        assert_eq!(link.data_bits.unwrap().bitrate, 2_000_000);
    }
    bench.send(NEAR, &frame(1));
    bench.until("a frame", |bench| bench.frames(FAR).len() == 1);
    let lost = |event: &BusEvent| matches!(event, BusEvent::Lost { .. } | BusEvent::Returned { .. });
    assert!(!bench.events.iter().any(lost), "what the rig did itself is no loss: {:?}", bench.events);
    drop(bench);
    assert_eq!([settings("rcan0"), settings("rcan1")], before);
    fresh("restart-ms 0");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn what_a_controller_cannot_do_is_refused_and_undone() {
    let _lab = Lab::enter();
    fresh("restart-ms 0");
    let before = settings("rcan0");
    let (code, message, _) = refused("interface = \"rcan0\", bitrate = 3, configure = true");
    assert!(code == "B0159" && message.starts_with("rcan0 cannot be set up"), "{code} {message}");
    assert_eq!(settings("rcan0"), before);
    // can0 is a controller of classic CAN.
    let before = settings("can0");
    let bus = "interface = \"can0\", bitrate = 500_000, data-bitrate = 2_000_000, configure = true";
    let (code, message, _) = refused(bus);
    assert!(code == "B0159" && message.contains("not supported"), "{code} {message}");
    assert_eq!(settings("can0"), before);
    // One that is set up already is put back where another cannot be.
    let both = format!(
        "{}\nlast = {{ kind = \"can\", {bus} }}",
        TROUBLED.replace("500_000 }", "250_000, configure = true }")
    );
    let before = settings("rcan0");
    assert!(Bench::open("", &both).is_err());
    assert_eq!(settings("rcan0"), before);
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_rig_without_the_privilege_says_what_it_would_need_it_for() {
    let _lab = Lab::enter();
    fresh("restart-ms 0");
    let mut sets = capabilities(None).unwrap();
    sets.effective.remove(CapabilitySet::NET_ADMIN);
    sets.permitted.remove(CapabilitySet::NET_ADMIN);
    set_capabilities(None, sets).unwrap();
    let (code, message, help) = refused("interface = \"rcan0\", bitrate = 250_000, configure = true");
    assert_eq!((code.as_str(), message.as_str()), ("B0158", "the rig is to set up rcan0, and may not"));
    let line = "ip link set rcan0 down && ip link set rcan0 type can bitrate 250000 && ip link set rcan0 up";
    assert!(help.contains("cap_net_admin") && help.contains(line), "{help}");
    let (code, message, help) = refused("interface = \"rcan0\", bitrate = 500_000, restart = \"100 ms\"");
    assert!(code == "B0158" && message.contains("start rcan0 again"), "{code} {message}");
    assert!(help.contains("restart-ms 100"), "{help}");
    // Where nothing is to be done no privilege is missing.
    let ready = Bench::open(
        "",
        "bus = { kind = \"can\", interface = \"rcan0\", bitrate = 500_000, configure = true }",
    );
    assert!(ready.is_ok(), "{:#?}", ready.err());
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_new_interface_is_set_up_again_and_one_that_somebody_takes_down_is_left() {
    let _lab = Lab::enter();
    run("ip link del vcan9 2>/dev/null; ip link add dev vcan9 type vcan");
    let bus = "near = { kind = \"can\", interface = \"vcan9\", bitrate = 500_000, configure = true }";
    let mut bench = Bench::with("unresponsive-after = \"5 s\"\nreconnect = true", bus);
    bench.send(NEAR, &frame(1));
    bench.until("a frame", |bench| bench.frames(NEAR).len() == 1);
    let count = |bench: &Bench, lost: bool| {
        let suits = |event: &&BusEvent| match event {
            BusEvent::Lost { reason: LossReason::Gone, .. } => lost,
            BusEvent::Returned { .. } => !lost,
            _ => false,
        };
        bench.events.iter().filter(suits).count()
    };
    // As an adapter that is plugged out and in again.
    run("ip link del vcan9; ip link add dev vcan9 type vcan");
    bench.until("the return", |bench| count(bench, false) == 1);
    assert!(ask("vcan9").unwrap().up);
    run("ip link set vcan9 down");
    bench.until("the second loss", |bench| count(bench, true) == 2);
    assert!(!ask("vcan9").unwrap().up && count(&bench, false) == 1);
    run("ip link set vcan9 up");
    bench.until("the second return", |bench| count(bench, false) == 2);
    drop(bench);
    assert!(!ask("vcan9").unwrap().up, "as it came");
    run("ip link del vcan9");
}
