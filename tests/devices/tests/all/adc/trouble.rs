//! Converters that fail, hang, go away and come back, or cannot be had.

use super::bench::{Bench, PATIENT, file, open, volts};
use devices::{ADS8688, MCP3008, SpiAdc, bind_spi, unbind_spi};
use drivers::{Board, BoardError, LossReason};
use signal::{Time, Value};
use std::time::Duration;

const MCP: &str = "path = \"/dev/spidev0.0\", part = \"mcp3008\", reference = \"3.3 V\", period = \"5 ms\"";
const ADS: &str = "path = \"/dev/spidev0.1\", part = \"ads8688\", period = \"5 ms\"";
/// Long enough that an emulated machine is not taken for a device that hangs, short enough for a test.
const SOON: &str = "unresponsive-after = \"400 ms\"";

fn gone(bench: &Bench, names: [&str; 2]) -> bool {
    names.iter().all(|name| bench.fate(name).last() == Some(&Some(LossReason::Gone)))
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn wires_that_are_stuck_and_bits_that_slip_are_no_voltages() {
    bind_spi();
    let spoil = |adc: SpiAdc, of: &str, fault: &str| {
        adc.reset();
        adc.volts(0, 1.25);
        adc.volts(1, 2.5);
        let mut bench = Bench::started(&file(SOON, of, &volts(0..2)));
        adc.fault(fault);
        bench.until(fault, |bench| gone(bench, ["a0", "a1"]));
        assert!(bench.board.health().failed_calls > 0);
        for name in ["a0", "a1"] {
            assert_eq!(bench.changes(name).len(), 1, "nothing was made of it: {:?}", bench.changes(name));
        }
        adc.fault("none");
    };
    spoil(MCP3008, MCP, "stuck-high");
    spoil(MCP3008, MCP, "bit-slip");
    spoil(ADS8688, ADS, "stuck-high");
    spoil(ADS8688, ADS, "stuck-low");
    spoil(ADS8688, ADS, "bit-slip");
    spoil(MCP3008, MCP, "io-error");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_transfer_that_hangs_is_reported_and_survived() {
    bind_spi();
    let adc = MCP3008.reset();
    let mut bench = Bench::started(&file("unresponsive-after = \"300 ms\"", MCP, &volts(0..2)));
    adc.stall(Duration::from_millis(1_500), 1);
    bench.until("the loss", |bench| bench.fate("a0").contains(&Some(LossReason::Unresponsive)));
    assert_eq!(adc.inside(), 1, "the call hangs");
    adc.volts(0, 1.65);
    bench.until("the return", |bench| bench.fate("a0").last() == Some(&None));
    bench.shows("a0", 1.65, 0.004);
    adc.fault("none");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_bus_that_goes_away_is_taken_back_with_its_parts_set_up_again() {
    bind_spi();
    let adc = ADS8688.reset();
    adc.volts(0, 3.0);
    let channels = "a0 = { kind = \"analog\", unit = \"V\", input = 0, range = \"0 V .. 5.12 V\" }\n\
                    a1 = { kind = \"analog\", unit = \"V\", input = 1 }";
    let mut bench = Bench::started(&file("reconnect = true\nunresponsive-after = \"400 ms\"", ADS, channels));
    bench.shows("a0", 3.0, 0.001);
    unbind_spi();
    bench.until("the loss", |bench| gone(bench, ["a0", "a1"]));
    bind_spi();
    adc.volts(0, 4.0);
    bench.until("the return", |bench| bench.fate("a1").last() == Some(&None));
    // The part was as after power-on: without its range it would show something else.
    bench.shows("a0", 4.0, 0.001);
    bench.start();
    // On an emulated machine a reading may be late.
    let health = bench.board.health();
    assert_eq!((health.lost, health.failed_calls), (0, 0), "{health:?}");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_bus_that_goes_away_stays_lost_where_nobody_wants_it_back() {
    bind_spi();
    let adc = MCP3008.reset();
    let mut bench = Bench::started(&file(SOON, MCP, &volts(0..2)));
    unbind_spi();
    bench.until("the loss", |bench| gone(bench, ["a0", "a1"]));
    bind_spi();
    adc.volts(0, 1.0);
    bench.board.safe(bench.at.time.now()).unwrap();
    let error = bench.board.start(Time::ZERO).unwrap_err();
    assert!(matches!(error, BoardError::Lost { reason: LossReason::Gone, .. }), "{error:?}");
    // The next run finds it.
    drop(bench);
    let bench = Bench::started(&file(PATIENT, MCP, &volts(0..2)));
    let volts = bench.last("a0").and_then(Value::as_real);
    assert!(volts.is_some_and(|volts| (volts - 1.0).abs() < 0.004), "{volts:?}");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_converter_that_cannot_be_had_says_why() {
    bind_spi();
    let _ = (MCP3008.reset(), ADS8688.reset());
    let refusal = |of: &str| open(&file(PATIENT, of, &volts(0..2))).unwrap_err();
    let missing = refusal("path = \"/dev/spidev9.0\", part = \"max1111\"");
    assert_eq!(missing[0].code, "B0127", "{missing:?}");
    // A loop answers, but not as the part would.
    let other = refusal("path = \"/dev/spidev0.3\", part = \"ads8688\"");
    assert_eq!(other[0].code, "B0129", "{other:?}");
    assert!(other[0].message.contains("does not answer as ads8688"), "{}", other[0].message);
    let bench = Bench::started(&file(PATIENT, MCP, &volts(0..2)));
    let held = refusal(MCP);
    assert_eq!(held[0].code, "B0128", "{held:?}");
    drop(bench);
    assert!(open(&file(PATIENT, MCP, &volts(0..2))).is_ok(), "it is free again");
}
