//! Pulses as a stream of bits: what the sink was sent, and what the board reported.

use super::bench::{Bench, PATIENT, file, open, pulses};
use devices::{PATIENCE, Sink, bind_spi, unbind_spi, wait_for};
use drivers::{BoardExt, LossReason, TimestampSource};
use host::HostInstant;
use signal::{Span, Value};
use std::time::Duration;

/// The levels of the bits, in order.
fn bits(bytes: &[u8]) -> Vec<bool> {
    bytes.iter().flat_map(|byte| (0..8).map(move |place| byte << place & 0x80 != 0)).collect()
}

/// Lengths of the levels in bits, from the rest before the first edge to the one after the last.
pub fn runs(bytes: &[u8]) -> Vec<usize> {
    bits(bytes).chunk_by(|one, other| one == other).map(<[bool]>::len).collect()
}

fn of_sink(sink: &Sink, more: &str) -> String {
    format!("kind = \"spi\", path = \"{}\"{more}", sink.path().display())
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn every_bit_is_sent_in_one_transfer_and_every_edge_reported_within_it() {
    let sink = Sink::enter();
    let channels = "I0 = { kind = \"digital\", generator = \"it\" }";
    let mut bench = Bench::started(&file(PATIENT, &of_sink(&sink, ", clock = \"1 MHz\""), channels));
    let channel = bench.board.channels()[0].clone();
    let emits = channel.emits.unwrap();
    assert_eq!((emits.shortest, emits.endless), (Span::from_micros(1), false));
    assert_eq!((channel.timestamp, channel.drives, channel.senses), (TimestampSource::Device, false, true));
    // 100 kHz, 200 kHz at uneven duty, pulses of one bit a millisecond apart, and some that jitter.
    let even = |count: i64, period: i64, high: i64| {
        (0..count).flat_map(move |pulse| [pulse * period, pulse * period + high]).collect::<Vec<i64>>()
    };
    let mut at = 0;
    let jittered = (0..200_i64).flat_map(|pulse| {
        at += 7_300 + pulse * pulse % 900;
        [at, at + 3_000]
    });
    let trains = [
        even(1_000, 10_000, 5_000),
        even(1_000, 5_000, 2_000),
        even(20, 1_000_000, 1_000),
        jittered.collect(),
    ];
    for edges in trains {
        sink.forget();
        let reported = bench.changes("I0").len();
        let asked = bench.at.time.now();
        bench.emit("I0", &pulses(edges.iter().copied()));
        bench.until("all edges", |bench| bench.changes("I0").len() == reported + edges.len());
        let (bytes, sent) = (sink.bytes(), sink.transfers());
        assert_eq!(sent.len(), 1, "no gap is possible in one transfer: {sent:?}");
        assert_eq!((sent[0].hz, sent[0].mode, sent[0].bytes), (1_000_000, 0, bytes.len()));
        // A byte at rest goes before the first edge.
        let wanted: Vec<usize> = edges.iter().map(|at| 8 + ((at + 500) / 1_000) as usize).collect();
        let found: Vec<usize> = runs(&bytes)
            .iter()
            .scan(0, |at, run| {
                *at += run;
                Some(*at)
            })
            .take(edges.len())
            .collect();
        assert_eq!(found, wanted);
        assert!(!bits(&bytes).last().unwrap(), "it ends at rest");
        let at = |stamp| bench.at.time.at(HostInstant::from_nanos(stamp));
        let stamps = (at(sent[0].start), at(sent[0].end));
        for (place, ((at, value), bit)) in bench.changes("I0")[reported..].iter().zip(&wanted).enumerate() {
            assert_eq!(*value, Value::Bool(place % 2 == 0));
            let true_at = stamps.0 + Span::from_nanos(*bit as i64 * 1_000);
            assert!(asked <= at.earliest && at.earliest <= true_at && at.latest <= bench.at.time.now());
            // The sink sends at once and waits then: its call may end a little early.
            let late = stamps.1 - Span::from_nanos((sent[0].bytes * 8 - bit) as i64 * 1_000);
            assert!(at.latest >= late, "{at:?} {late}");
        }
    }
    assert!(bench.board.health().is_sound(), "{:?}", bench.board.health());
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn order_of_bits_mode_and_a_line_that_is_turned_over_are_as_the_file_has_them() {
    let sink = Sink::enter();
    let channels = "I0 = { kind = \"digital\", generator = \"it\", active-low = true, senses = false }";
    let more = ", clock = \"500 kHz\", mode = 3, lsb-first = true, buffer = 64";
    let mut bench = Bench::started(&file(PATIENT, &of_sink(&sink, more), channels));
    let opened = sink.transfers();
    assert_eq!(opened.last().unwrap().bytes, 64, "the whole buffer, at rest");
    assert!(sink.bytes().iter().all(|byte| *byte == 0xff), "rest is high");
    sink.forget();
    bench.emit("I0", &pulses([2_000, 8_000, 10_000, 12_000]));
    bench.until("the transfer", |_| sink.transfers().iter().any(|sent| sent.end > 0));
    assert_eq!((sink.transfers()[0].mode, sink.transfers()[0].hz), (3, 500_000));
    // The sink keeps bits in the order of the wire.
    assert_eq!(sink.bytes(), [0xff, !0b0111_0100]);
    assert_eq!(bench.changes("I0"), [], "nobody asked to be told");
    let beyond = pulses([0, (63 * 8) * 2_000]);
    let refused = bench.board.emit(bench.at.time.now(), bench.id("I0"), &beyond).unwrap_err();
    assert!(refused.to_string().contains("last at most 1.006 ms"), "{refused}");
    assert_eq!(bench.board.channels()[0].emits.unwrap().counted, Span::from_micros(1_006));
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_bus_that_fails_hangs_or_goes_away_is_reported_and_taken_back_at_rest() {
    let sink = Sink::enter();
    let channels = "I0 = { kind = \"digital\", generator = \"it\" }";
    let board = "unresponsive-after = \"400 ms\"\nreconnect = true";
    let mut bench = Bench::started(&file(board, &of_sink(&sink, ""), channels));
    let train = pulses([0, 5_000, 10_000, 15_000]);
    sink.part().fault("io-error");
    bench.emit("I0", &train);
    bench.until("the failure", |bench| bench.board.health().failed_calls > 0);
    bench.until("what is missed", |bench| bench.board.health().dropped == 4);
    sink.part().fault("none");
    sink.stall(Duration::from_millis(1_500), 1);
    bench.emit("I0", &train);
    bench.until("the silence", |bench| bench.fate("I0") == [Some(LossReason::Unresponsive)]);
    assert_eq!(sink.part().inside(), 1, "the call hangs");
    bench.until("the answer", |bench| bench.fate("I0").len() == 2);
    bench.until("the edges of the train", |bench| bench.changes("I0").len() >= 5);
    unbind_spi();
    bench.until("the loss", |bench| bench.fate("I0").last() == Some(&Some(LossReason::Gone)));
    bind_spi();
    bench.until("the return", |bench| bench.fate("I0").len() == 4);
    let reported = bench.changes("I0").len();
    bench.emit("I0", &train);
    bench.until("the edges of the train", |bench| bench.changes("I0").len() == reported + 4);
    let sent = sink.transfers();
    assert_eq!(sent.last().unwrap().bytes, 3, "the train was sent: {sent:?}");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_bus_that_cannot_be_had_says_why() {
    let sink = Sink::enter();
    let channels = "I0 = { kind = \"digital\", generator = \"it\" }";
    let refusal = |of: &str| open(&file(PATIENT, of, channels)).unwrap_err().remove(0);
    assert_eq!(refusal("kind = \"spi\", path = \"/dev/spidev9.0\"").code, "B0230");
    let long = refusal(&of_sink(&sink, ", buffer = 65536"));
    assert_eq!(long.code, "B0235");
    assert!(long.help.contains("spidev.bufsiz=65536"), "{long:?}");
    // The kernel takes any clock, and the controller another one.
    let fast = file(PATIENT, &of_sink(&sink, ", clock = \"4 GHz\""), channels);
    // A machine that is busy just now cannot tell.
    wait_for("the clock is refused", PATIENCE, || match open(&fast) {
        Ok(_) => false,
        Err(found) => found[0].code == "B0236" && found[0].message.contains("for bits that last 8.192 us"),
    });
    let bench = Bench::started(&file(PATIENT, &of_sink(&sink, ""), channels));
    let held = refusal(&of_sink(&sink, ""));
    assert_eq!(held.code, "B0232", "{held:?}");
    drop(bench);
    assert!(open(&file(PATIENT, &of_sink(&sink, ""), channels)).is_ok(), "it is free again");
}
