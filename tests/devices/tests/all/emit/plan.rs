//! Plans over generators of the kernel: trains and waves of steps, and square waves of the model.

use super::stream::runs;
use crate::rig::{Rig, guards};
use devices::{Lab, PwmChip, Sink};

const BOARD: &str = r#"format = 1
title = "A stream of bits, and outputs of a PWM chip"
[board]
kind = "real"
unresponsive-after = "30 s"
[generators]
bits = { kind = "spi", path = "/dev/spidev0.4", clock = "1 MHz" }
chip = { kind = "pwm", path = "/sys/class/pwm/pwmchip0", clock = "100 MHz" }
[channels]
stream = { kind = "digital", generator = "bits" }
fan = { kind = "digital", generator = "chip", output = 1 }
Q0 = { kind = "digital", generator = "chip", output = 2 }
[guard]
limit = "10 s"
[realtime]
late = "10 s"
"#;

/// A PWM that becomes faster after half a second, and constant after a whole one.
const PROGRAM: &str = "\
PROGRAM MAIN
VAR
    wave : PWM_M241;
    first, second : TON;
    f : UDINT := 10_000;
    d : UDINT := 25;
END_VAR
first(IN := TRUE, PT := T#500ms);
second(IN := TRUE, PT := T#1s);
IF first.Q THEN f := 20_000; END_IF;
IF second.Q THEN d := 100; END_IF;
wave(PWM_REF_IN := PWM0, Enable := TRUE, Frequency := f, Duty := d);
END_PROGRAM
";

/// 500 pulses at 100 kHz, 100 of 1 us, a millisecond of a table, and a wave of a second beside them.
const STEPS: &str = r#"format = 1
title = "Pulses that nobody writes edge by edge"
program-text = "PROGRAM MAIN END_PROGRAM"
signals = { stream = "stream", fan = "fan" }
steps = [
  { id = "wave", at = "start + 100 ms", square = { signal = "fan", frequency = "1 kHz", duty = "25 %", duration = "1 s" } },
  { id = "train", at = "start + 200 ms", train = { signal = "stream", frequency = "100 kHz", count = 500 } },
  { id = "short", at = "start + 1 s", train = { signal = "stream", frequency = "10 kHz", count = 100, duty = "1 %" } },
  { id = "rows", at = "start + 1500 ms", sequence = { file = "rows.csv" } },
]
ends = "rows + 300 ms"
expect = [
  { edges = { signal = "stream", rising = 602, falling = 602, from = "start", until = "end" } },
  { stays = { signal = "stream", is = false, from = "train.pulse[500] + 200 ms", until = "short.pulse[1] - 200 ms" } },
  { stays = { signal = "stream", is = false, from = "short.done + 200 ms", until = "rows - 100 ms" } },
]
"#;

const ROWS: &str = "time [us],stream\n0,0\n10,1\n40,0\n60,1\n61,0\n1000,0\n";

const MODEL: &str = r#"format = 1
title = "The model's PWM behind a chip of the kernel"
program = "main.st"
signals = { duty = "PWM0.duty", f = "PWM0.frequency" }
settings = { expert = { PWM0 = { kind = "pwm", a = "%QX0.0" } } }
steps = [{ id = "stop", at = "start + 2 s", command = "stop" }]
ends = "stop + 300 ms"
expect = [
  { becomes = { signal = "f", is = 20_000, from = "start", within = "2200 ms" } },
  { becomes = { signal = "duty", is = 1000, from = "start", within = "2200 ms" } },
]
"#;

fn start(name: &str, plan: &str, words: &[&str]) -> Rig {
    let files = [("board.toml", BOARD), ("plan.toml", plan), ("main.st", PROGRAM), ("rows.csv", ROWS)];
    Rig::start(name, &files.map(|(name, text)| (name, text.to_owned())), words)
}

const TEST: [&str; 6] = ["test", "--board", "board.toml", "--report", "report", "plan.toml"];

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn steps_on_generators_are_handed_over_whole_and_judged_by_what_was_sent() {
    let (_lab, sink, chip) = (Lab::enter(), Sink::enter(), PwmChip::enter());
    let mut rig = start("emitted", STEPS, &TEST);
    rig.until("the wave", || {
        let pin = chip.pin(1);
        pin.enabled && (pin.period, pin.duty) == (1_000_000, 250_000)
    });
    rig.until("the end of the wave", || chip.pin(1).duty == 0);
    assert_eq!(rig.exit_code(), Some(0), "{}", rig.said());
    assert!(!chip.is_held(1) && !chip.pin(1).enabled);
    // What was sent at rest when it was opened, to try the clock and the size, and then a transfer for each step.
    let bytes = sink.bytes();
    let mut sent = sink.transfers();
    sent.retain(|one| bytes[one.at..one.at + one.bytes].iter().any(|byte| *byte != 0));
    assert_eq!(sent.len(), 3, "{sent:?}");
    let of = |place: usize| runs(&bytes[sent[place].at..sent[place].at + sent[place].bytes]);
    let train = of(0);
    assert_eq!(train.len(), 1_001);
    assert!(train[1..1_000].iter().all(|run| *run == 5), "{train:?}");
    let short = of(1);
    assert!(short.len() == 201 && short[1..200].chunks(2).all(|two| two[0] == 1), "{short:?}");
    assert!(short[2..200].iter().step_by(2).all(|low| *low == 99), "{short:?}");
    assert_eq!(of(2)[..4], [8 + 10, 30, 20, 1]);
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn the_models_pwm_is_made_by_a_chip() {
    let (_lab, chip) = (Lab::enter(), PwmChip::enter());
    let mut rig = start("model", MODEL, &TEST);
    let shape = |chip: &PwmChip| (chip.pin(2).period, chip.pin(2).duty);
    for (period, duty) in [(1_000_000, 250_000), (500_000, 125_000), (500_000, 500_000), (500_000, 0)] {
        rig.until("the next shape", || shape(&chip) == (period, duty));
    }
    assert_eq!(rig.exit_code(), Some(0), "{}", rig.said());
    // The guard looks at the outputs once more before they are given back: else it stays for them.
    assert_eq!(guards(), 0, "{}", rig.said());
    assert!(!chip.is_held(2) && !chip.pin(2).enabled);
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn what_a_generator_cannot_is_refused_and_nothing_moves() {
    let (_lab, sink, chip) = (Lab::enter(), Sink::enter(), PwmChip::enter());
    let before = chip.pin(1).changes;
    let counted = STEPS.replace("duration = \"1 s\"", "count = 1_000");
    let mut rig = start("refused", &counted, &TEST);
    assert_eq!(rig.exit_code(), Some(2), "{}", rig.said());
    assert!(rig.said().contains("R0305") && rig.said().contains("leave out `count`"), "{}", rig.said());
    assert!(sink.bytes().iter().all(|byte| *byte == 0), "nothing but the rest");
    assert!(chip.pin(1).duty == 0 && chip.pin(1).changes <= before + 2, "{:?}", chip.pin(1));
}
