//! Square waves of a PWM chip: what is at its pins.

use super::bench::{Bench, PATIENT, file, open, square};
use devices::PwmChip;
use drivers::{BoardExt, LossReason};
use signal::{Span, Value};
use std::fs;

const CHIP: &str = "kind = \"pwm\", path = \"/sys/class/pwm/pwmchip0\"";
const MS: u64 = 1_000_000;

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_wave_is_put_out_changed_and_ended_as_asked() {
    let chip = PwmChip::enter();
    let channels = "Q0 = { kind = \"digital\", generator = \"it\", output = 2 }\n\
                    Q1 = { kind = \"digital\", generator = \"it\", output = 0, safe = true }";
    let mut bench = Bench::started(&file(PATIENT, &format!("{CHIP}, clock = \"100 MHz\""), channels));
    let (fan, other) = (chip.pin(2), chip.pin(0));
    assert!(fan.enabled && fan.duty == 0 && !fan.inversed, "{fan:?}");
    assert!(other.enabled && other.duty == 0 && other.inversed, "it rests high: {other:?}");
    let channel = &bench.board.channels()[0];
    assert!(channel.drives && !channel.senses && channel.emits.unwrap().endless);
    assert_eq!(channel.emits.unwrap().resolution, Span::from_nanos(10));
    bench.emit("Q0", &square(5_000_004, 2_000_006));
    bench.until("the wave", |_| chip.pin(2).duty == 2 * MS + 10);
    let fan = chip.pin(2);
    assert_eq!((fan.period, fan.enabled), (5 * MS, true));
    assert!(chip.pin(2).changes - fan.changes == 0 && bench.changes("Q0").is_empty(), "nobody reports it");
    bench.until("periods", |_| chip.pin(2).pulses > fan.pulses);
    // To another period, to a constant level, to a wave again, to rest: never more steps than it takes.
    let mut changed = chip.pin(2).changes;
    for (period, high, steps) in [(5 * MS, 4 * MS, 1), (MS, MS / 2, 2), (20 * MS, 19 * MS, 2)] {
        bench.emit("Q0", &square(period as i64, high as i64));
        bench.until("the next wave", |_| (chip.pin(2).period, chip.pin(2).duty) == (period, high));
        assert_eq!(chip.pin(2).changes, changed + steps);
        changed += steps;
    }
    bench.write("Q0", true);
    bench.until("all the time", |_| chip.pin(2).duty == 20 * MS);
    bench.write("Q0", false);
    bench.until("never", |_| chip.pin(2).duty == 0);
    // What rests high is active while it is low.
    bench.emit("Q1", &square(2 * MS as i64, 500_000));
    bench.until("the other wave", |_| chip.pin(0).duty == 1_500_000);
    bench.emit("Q0", &square(MS as i64, 1_000));
    bench.until("the wave", |_| chip.pin(2).duty == 1_000);
    let now = bench.at.time.now();
    bench.board.safe(now).unwrap();
    assert_eq!((chip.pin(0).duty, chip.pin(2).duty), (0, 0), "safe waits until it is so");
    assert!(bench.board.emit(now, bench.id("Q0"), &square(MS as i64, 1_000)).is_err());
    assert!(bench.board.write(now, &[(bench.id("Q0"), Value::Bool(true))]).is_err());
    bench.start();
    bench.emit("Q0", &square(MS as i64, 1_000));
    bench.until("the wave", |_| chip.pin(2).duty == 1_000);
    drop(bench);
    let (fan, other) = (chip.pin(2), chip.pin(0));
    assert!(!fan.enabled && fan.duty == 0 && !chip.is_held(2), "{fan:?}");
    assert!(
        other.enabled && other.duty == 0 && other.inversed && !chip.is_held(0),
        "it stays high: {other:?}"
    );
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_chip_that_fails_or_goes_away_is_reported_and_goes_on_where_it_was() {
    let chip = PwmChip::enter();
    let channels = "Q0 = { kind = \"digital\", generator = \"it\", output = 1 }";
    let board = "unresponsive-after = \"400 ms\"\nreconnect = true";
    let mut bench = Bench::started(&file(board, CHIP, channels));
    chip.fault(1, "io-error");
    bench.emit("Q0", &square(3 * MS as i64, MS as i64));
    bench.until("the failure", |bench| bench.board.health().failed_calls > 0);
    bench.until("what is missed", |bench| bench.board.health().dropped == 1);
    assert_eq!(chip.pin(1).duty, 0);
    chip.fault(1, "none");
    bench.emit("Q0", &square(3 * MS as i64, MS as i64));
    bench.until("the wave", |_| chip.pin(1).duty == MS);
    chip.unbind();
    bench.until("the loss", |bench| bench.fate("Q0") == [Some(LossReason::Gone)]);
    chip.bind();
    bench.until("the return", |bench| bench.fate("Q0").last() == Some(&None));
    bench.until("the wave again", |_| chip.pin(1).enabled && chip.pin(1).duty == MS);
    // A wave that cannot be ended makes a start and a safe state fail.
    chip.fault(1, "io-error");
    let now = bench.at.time.now();
    assert!(bench.board.safe(now).is_err());
    chip.fault(1, "none");
    bench.start();
    assert_eq!(chip.pin(1).duty, 0);
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn an_output_that_cannot_be_had_says_why() {
    let chip = PwmChip::enter();
    let channels =
        |output: u8| format!("Q0 = {{ kind = \"digital\", generator = \"it\", output = {output} }}");
    let refusal = |of: &str, output: u8| open(&file(PATIENT, of, &channels(output))).unwrap_err().remove(0);
    assert_eq!(refusal("kind = \"pwm\", name = \"pwmchip7\"", 0).code, "B0230");
    assert_eq!(refusal(CHIP, 4).code, "B0223");
    let by_label = "kind = \"pwm\", label = \"rig-pwm\"";
    let bench = Bench::started(&file(PATIENT, by_label, &channels(3)));
    assert_eq!(refusal(CHIP, 3).code, "B0232", "another rig has it");
    drop(bench);
    // Somebody else's wave is left alone, one at rest is taken over and given back.
    let own = |file: &str, text: &str| fs::write(format!("/sys/class/pwm/pwmchip0/{file}"), text).unwrap();
    own("export", "3");
    for (file, text) in [("period", "1000000"), ("duty_cycle", "500000"), ("enable", "1")] {
        own(&format!("pwm3/{file}"), text);
    }
    let held = refusal(CHIP, 3);
    assert!(held.code == "B0232" && chip.pin(3).duty == 500_000, "{held:?}");
    own("pwm3/duty_cycle", "0");
    drop(Bench::started(&file(PATIENT, CHIP, &channels(3))));
    assert!(!chip.is_held(3) && !chip.pin(3).enabled);
}
