//! How the bus is used.

use super::bench::{Bench, PATIENT, file, volts};
use devices::{ADS8688, MCP3008, PATIENCE, bind_spi, wait_for};
use rustix::process::{Pid, Signal, kill_process};
use std::process::{Command, Stdio};

/// The calls of this process on the bus as `strace` reports them, while it is looked on for a while.
fn calls(bench: &mut Bench, frames: impl Fn() -> u64) -> Vec<String> {
    let shown = "/tmp/adc.strace";
    let _ = std::fs::remove_file(shown);
    let me = std::process::id().to_string();
    let mut strace = Command::new("strace")
        .args(["-f", "-qq", "-e", "trace=ioctl", "-o", shown, "-p", &me])
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let lines = || std::fs::read_to_string(shown).unwrap_or_default();
    wait_for("strace sees calls", PATIENCE, || lines().lines().count() >= 2);
    let first = frames();
    bench.until("some sweeps", |_| frames() > first + 200);
    kill_process(Pid::from_child(&strace), Signal::INT).unwrap();
    strace.wait().unwrap();
    let all = lines();
    all.lines().filter(|line| line.contains("0x6b") || line.contains("SPI_IOC")).map(str::to_owned).collect()
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_sweep_of_eight_inputs_is_one_call() {
    bind_spi();
    let adc = MCP3008.reset();
    let of = "path = \"/dev/spidev0.0\", part = \"mcp3008\", reference = \"3.3 V\", period = \"20 ms\"";
    let mut bench = Bench::started(&file(PATIENT, of, &volts(0..8)));
    let seen = calls(&mut bench, || adc.frames());
    assert!(seen.len() >= 20, "{seen:#?}");
    for call in &seen {
        // The bytes of eight frames.
        assert!(call.ends_with(" = 24") || call.contains("resumed") || call.contains("unfinished"), "{call}");
    }
    // And no others: what is counted at the part from one rest to the next is eight times the calls.
    let rest = |bench: &mut Bench| {
        bench.board.safe(bench.at.time.now()).unwrap();
        wait_for("it rests", PATIENCE, || {
            let before = adc.frames();
            std::thread::sleep(std::time::Duration::from_millis(60));
            adc.frames() == before
        });
    };
    rest(&mut bench);
    let first = adc.frames();
    bench.start();
    bench.until("more sweeps", |_| adc.frames() > first + 80);
    rest(&mut bench);
    assert_eq!((adc.frames() - first) % 8, 0, "whole sweeps");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn many_sweeps_make_one_reading_whatever_the_driver_takes_at_once() {
    bind_spi();
    let adc = ADS8688.reset();
    (0..8).for_each(|input| adc.volts(input, 1.0 + f64::from(input)));
    // 100 sweeps of ten frames: far more than one call takes.
    let of = "path = \"/dev/spidev0.1\", part = \"ads8688\", speed = \"10 MHz\", oversample = 100, period = \"2 s\"";
    let mut bench = Bench::started(&file(PATIENT, of, &volts(0..8)));
    for input in 0..8u8 {
        bench.shows(&format!("a{input}"), 1.0 + f64::from(input), 20.48 / 65_536.0);
    }
    bench.board.safe(bench.at.time.now()).unwrap();
    let before = adc.frames();
    bench.start();
    bench.board.safe(bench.at.time.now()).unwrap();
    let made = adc.frames() - before;
    assert!(made >= 1_000 && made.is_multiple_of(1_000), "{made} frames");
}
