//! Whether interfaces are as the board file says.

use devices::Lab;

use super::bench::{Bench, fresh, run};

fn refused(bus: &str) -> (String, String, String) {
    let found = Bench::open("", &format!("bus = {{ kind = \"can\", {bus} }}")).err().expect("a refusal");
    let [one] = &found[..] else { panic!("{found:#?}") };
    (one.code.to_owned(), one.message.clone(), one.help.clone())
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_bit_rate_that_differs_is_said_with_the_line_that_mends_it() {
    let _lab = Lab::enter();
    fresh("restart-ms 0");
    let wanted = "interface = \"rcan0\", bitrate = 250_000, restart = \"100 ms\"";
    let (code, message, help) = refused(wanted);
    assert_eq!(code, "B0156");
    assert!(message.contains("500000 bit/s, not 250000 bit/s"), "{message}");
    let line = help.trim_start_matches("run `").trim_end_matches('`');
    run(line);
    let fixed = Bench::open("", &format!("bus = {{ kind = \"can\", {wanted} }}"));
    assert!(fixed.is_ok(), "{line}: {:#?}", fixed.err());
    fresh("restart-ms 0");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn an_interface_that_is_missing_down_or_no_can_is_distinguished() {
    let _lab = Lab::enter();
    let (code, _, help) = refused("interface = \"can9\", bitrate = 500_000");
    assert_eq!(code, "B0154");
    assert!(help.contains("can"), "{help}");
    assert_eq!(refused("interface = \"lo\", bitrate = 500_000").0, "B0154");
    fresh("restart-ms 0");
    run("ip link set rcan0 down");
    let (code, _, help) = refused("interface = \"rcan0\", bitrate = 500_000");
    assert_eq!((code.as_str(), help.as_str()), ("B0155", "run `ip link set rcan0 up`"));
    fresh("restart-ms 0");
    let (code, message, _) = refused("interface = \"can0\", bitrate = 500_000, data-bitrate = 2_000_000");
    assert!(code == "B0156" && message.contains("CAN FD is off"), "{code} {message}");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_virtual_bus_agrees_with_any_bit_rate() {
    let _lab = Lab::enter();
    let buses = "bus = { kind = \"can\", interface = \"vcan0\", bitrate = 1, data-bitrate = 8_000_000 }";
    let mut bench = Bench::of(buses);
    let frame = signal::CanFrame::classic(1, false, &[7]).unwrap();
    bench.send(super::bench::NEAR, &frame);
    bench.until("the own frame", |bench| {
        bench.frames(super::bench::NEAR).iter().any(|(_, got, own)| *got == frame && *own)
    });
}
