//! What the parts measure.

use super::bench::{Bench, PATIENT, file, volts};
use devices::{ADS8688, MAX1111, MCP3008, SpiAdc, bind_spi};
use signal::Value;

fn part(adc: SpiAdc, name: &str, more: &str) -> String {
    format!("path = \"{}\", part = \"{name}\", period = \"5 ms\"{more}", adc.path().display())
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn an_mcp3008_measures_eight_inputs_and_says_when() {
    bind_spi();
    let adc = MCP3008.reset();
    (0..8).for_each(|input| adc.volts(input, 0.1 + 0.4 * f64::from(input)));
    let of = part(adc, "mcp3008", ", reference = \"3.3 V\"");
    let mut bench = Bench::started(&file(PATIENT, &of, &volts(0..8)));
    let step = 3.3 / 1024.0;
    for input in 0..8u8 {
        bench.shows(&format!("a{input}"), 0.1 + 0.4 * f64::from(input), step);
    }
    let before = bench.at.time.now();
    adc.volts(3, 2.9);
    let after = bench.at.time.now();
    bench.shows("a3", 2.9, step);
    let (at, _) = *bench.changes("a3").last().unwrap();
    assert!(at.earliest <= after && before <= at.latest, "{before} .. {after} is not within {at:?}");
    adc.volts(0, 4.0);
    bench.until("the end of the range", |bench| bench.last("a0") == Some(Value::Unknown));
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn pairs_are_measured_against_each_other() {
    bind_spi();
    let adc = MCP3008.reset();
    adc.volts(0, 2.5);
    adc.volts(1, 1.0);
    let of = part(adc, "mcp3008", ", reference = \"3.3 V\"");
    let channels = "up = { kind = \"analog\", unit = \"V\", input = \"0-1\" }\n\
                    down = { kind = \"analog\", unit = \"V\", input = \"1-0\" }";
    let mut bench = Bench::started(&file(PATIENT, &of, channels));
    bench.shows("up", 1.5, 3.3 / 1024.0);
    assert_eq!(bench.last("down"), Some(Value::Unknown), "it is below what the pair can show");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn inputs_of_an_ads8688_have_ranges_of_their_own_in_both_sequences() {
    bind_spi();
    let adc = ADS8688.reset();
    for (input, at) in [(0, -9.5), (2, 4.0), (5, 9.9), (7, -2.4)] {
        adc.volts(input, at);
    }
    let channels = "deep = { kind = \"analog\", unit = \"V\", input = 0 }\n\
                    wide = { kind = \"analog\", unit = \"V\", input = 5, range = \"0 V .. 10.24 V\" }\n\
                    half = { kind = \"analog\", unit = \"mV\", input = 2, range = \"0 V .. 5.12 V\" }\n\
                    fine = { kind = \"analog\", unit = \"V\", input = 7, range = \"-2.56 V .. 2.56 V\" }";
    for sequence in ["auto", "manual"] {
        let of = part(adc, "ads8688", &format!(", speed = \"10 MHz\", sequence = \"{sequence}\""));
        let mut bench = Bench::started(&file(PATIENT, &of, channels));
        bench.shows("deep", -9.5, 20.48 / 65_536.0);
        bench.shows("wide", 9.9, 10.24 / 65_536.0);
        bench.shows("half", 4_000.0, 5_120.0 / 65_536.0);
        bench.shows("fine", -2.4, 5.12 / 65_536.0);
        adc.volts(7, -2.7);
        bench.until("the end of the range", |bench| bench.last("fine") == Some(Value::Unknown));
        adc.volts(7, -2.4);
        bench.shows("fine", -2.4, 5.12 / 65_536.0);
    }
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_max1111_measures_from_zero_and_around_it() {
    bind_spi();
    let adc = MAX1111.reset();
    adc.volts(1, 1.5);
    adc.volts(2, 0.3);
    adc.volts(3, 0.8);
    let channels = "one = { kind = \"analog\", unit = \"V\", input = 1 }\n\
                    pair = { kind = \"analog\", unit = \"V\", input = \"2-3\", range = \"-1.024 V .. 1.024 V\" }";
    let mut bench = Bench::started(&file(PATIENT, &part(adc, "max1111", ""), channels));
    bench.shows("one", 1.5, 2.048 / 256.0);
    bench.shows("pair", -0.5, 2.048 / 256.0);
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_current_loop_shows_bar_and_its_open_wire_nothing() {
    bind_spi();
    let adc = ADS8688.reset();
    adc.volts(4, 3.0);
    let channels = "p = { kind = \"analog\", unit = \"bar\", input = 4, range = \"0 V .. 5.12 V\", \
                    scale = { shunt = \"250 Ohm\", from = [\"4 mA\", \"20 mA\"], to = [\"0 bar\", \"16 bar\"] }, \
                    open-below = \"3.6 mA\", short-above = \"20.3 mA\", \
                    calibration = { points = [[0, 0], [8, 8.5], [16, 16]], date = \"2026-01-31\" } }";
    let mut bench = Bench::started(&file(PATIENT, &part(adc, "ads8688", ""), channels));
    bench.shows("p", 8.5, 0.01);
    for (volts, shown) in [(0.85, None), (1.0, Some(0.0)), (5.08, None), (5.0, Some(16.0))] {
        adc.volts(4, volts);
        match shown {
            Some(bar) => bench.shows("p", bar, 0.01),
            None => {
                bench.until("a wire that is open or shorted", |bench| bench.last("p") == Some(Value::Unknown))
            }
        }
    }
}
