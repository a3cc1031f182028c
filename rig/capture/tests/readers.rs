//! Captures of real instruments are read as they are, broken ones are refused with their place, and nothing panics.

use proptest::prelude::*;
use scanrig_capture::{Capture, CaptureError, CaptureFormat, CapturePlace, ChannelType, Knowledge, read};
use signal::{Span, Time, Value, When};

const LAMP: &[u8] = include_bytes!("files/lamp.sr");
const DEMO: &[u8] = include_bytes!("files/demo.sr");
const SIGROK_VCD: &[u8] = include_bytes!("files/sigrok.vcd");
const SIGROK_CSV: &[u8] = include_bytes!("files/sigrok.csv");
const RIG_VCD: &[u8] = include_bytes!("files/rig.vcd");
const EDGES: &[u8] = include_bytes!("files/edges.csv");
const SCOPE: &[u8] = include_bytes!("files/scope.csv");

fn within(earliest: i64, latest: i64) -> When {
    When::within(Time::from_nanos(earliest), Time::from_nanos(latest))
}

/// The changes of a channel.
fn changes(capture: &Capture, name: &str) -> Vec<(When, Value)> {
    let channel = capture.channels.iter().position(|channel| channel.name == name).unwrap() as u32;
    capture.changes.iter().filter(|change| change.channel == channel).map(|c| (c.at, c.value)).collect()
}

fn refused(format: CaptureFormat, text: &str) -> CaptureError {
    read(format, text.as_bytes(), None).expect_err(text)
}

#[test]
fn formats_are_recognised_by_their_beginning() {
    assert_eq!(CaptureFormat::of(LAMP, "x.bin"), Some(CaptureFormat::Sigrok));
    assert_eq!(CaptureFormat::of(b"\n $date", "x"), Some(CaptureFormat::Vcd));
    assert_eq!(
        (CaptureFormat::of(b"time", "a.CSV"), CaptureFormat::of(b"time", "a.txt")),
        (Some(CaptureFormat::Csv), None)
    );
}

#[test]
fn a_session_of_sigrok() {
    let capture = read(CaptureFormat::Sigrok, LAMP, None).unwrap();
    assert_eq!(capture.knowledge, Knowledge::Sampled(Span::from_micros(100)));
    assert_eq!(capture.span, [Time::ZERO, Time::from_nanos(3_600_000_000)]);
    let on = Value::Bool(true);
    assert_eq!(
        changes(&capture, "0"),
        [(within(0, 0), Value::Bool(false)), (within(2_499_900_000, 2_500_000_000), on)]
    );
    assert_eq!(changes(&capture, "1")[1], (within(3_020_000_000, 3_020_100_000), on));
    // The user knows the rate better.
    let slower = read(CaptureFormat::Sigrok, LAMP, Some(Span::from_millis(1))).unwrap();
    assert_eq!(changes(&slower, "0")[1].0, within(24_999_000_000, 25_000_000_000));
}

#[test]
fn a_session_with_an_analog_channel() {
    let capture = read(CaptureFormat::Sigrok, DEMO, None).unwrap();
    let shapes: Vec<_> =
        capture.channels.iter().map(|channel| (channel.name.as_str(), channel.shape)).collect();
    assert_eq!(shapes, [("D0", ChannelType::Bit), ("A0", ChannelType::Real)]);
    assert!(
        changes(&capture, "A0").iter().all(|(_, value)| matches!(value, Value::Real(v) if v.abs() < 20.0))
    );
    assert!(capture.changes.is_sorted_by_key(|change| change.at.latest));
}

#[test]
fn dumps_of_sigrok_are_sampled_and_those_of_the_rig_exact() {
    let session = read(CaptureFormat::Sigrok, LAMP, None).unwrap();
    let dump = read(CaptureFormat::Vcd, SIGROK_VCD, None).unwrap();
    assert_eq!((&dump.changes, dump.knowledge), (&session.changes, session.knowledge));
    let own = read(CaptureFormat::Vcd, RIG_VCD, None).unwrap();
    assert_eq!(own.knowledge, Knowledge::Own);
    assert_eq!(
        changes(&own, "lamp").last(),
        Some(&(within(3_020_035_000, 3_020_035_000), Value::Bool(true)))
    );
    assert!(own.notes.contains(&("plan-case".into(), "lamp".into())), "{:?}", own.notes);
}

#[test]
fn every_kind_of_a_dump() {
    let text = "$timescale 10 ns $end $scope module a $end $var wire 1 ! a $end $var wire 8 # n $end \
                $var real 64 % r $end $var wire 1 ! b $end $upscope $end $enddefinitions $end \
                #0 0! b0 # r1.5 % #5 1! b101 # #7 x! bx1 # r-2 % #8 z! b0 #";
    let capture = read(CaptureFormat::Vcd, text.as_bytes(), None).unwrap();
    assert_eq!(capture.knowledge, Knowledge::Edges(Span::from_nanos(10)));
    let values = |name| changes(&capture, name).into_iter().map(|(_, value)| value).collect::<Vec<_>>();
    assert_eq!(values("a"), [Value::Bool(false), Value::Bool(true), Value::Unknown, Value::HighZ]);
    assert_eq!(values("b"), values("a"));
    assert_eq!(values("n"), [Value::Word(0), Value::Word(5), Value::Unknown, Value::Word(0)]);
    assert_eq!(values("r"), [Value::Real(1.5), Value::Real(-2.0)]);
    // One tool rounds, another cuts off.
    assert_eq!(changes(&capture, "a")[1].0, within(40, 60));
}

#[test]
fn a_dump_of_the_rig_says_how_wide_its_changes_are() {
    let text = "$version rig 0.1.0 $end $timescale 1 ns $end $var wire 1 ! a $end $var wire 1 # b $end \
                $enddefinitions $end #0 0! 0# #50 1! 1# $comment widest a 20 ns $end $comment widest b ? $end";
    let capture = read(CaptureFormat::Vcd, text.as_bytes(), None).unwrap();
    assert_eq!(changes(&capture, "a")[1].0, within(30, 50));
    assert_eq!(changes(&capture, "b")[1].0, within(0, 50));
}

#[test]
fn a_table_of_sigrok_takes_its_names_from_the_comment() {
    let capture = read(CaptureFormat::Csv, SIGROK_CSV, None).unwrap();
    let names: Vec<&str> = capture.channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(names, ["D0", "D1", "D2"]);
    assert_eq!(capture.knowledge, Knowledge::Sampled(Span::from_micros(1)));
    assert!(
        capture
            .changes
            .iter()
            .skip(3)
            .all(|change| (change.at.latest - change.at.earliest) == Span::from_micros(1))
    );
}

#[test]
fn between_rows_anything_may_be() {
    let capture = read(CaptureFormat::Csv, EDGES, None).unwrap();
    assert_eq!(changes(&capture, "lamp")[1], (within(1_000_000_000, 1_520_035_000), Value::Bool(true)));
    assert_eq!(capture.knowledge, Knowledge::Sampled(Span::from_millis(1_500)));
    let reported = read(CaptureFormat::Csv, EDGES, Some(Span::from_micros(2))).unwrap();
    assert_eq!(changes(&reported, "lamp")[1].0, within(1_520_033_000, 1_520_035_000));
}

#[test]
fn a_table_of_volts_with_decimal_commas() {
    let capture = read(CaptureFormat::Csv, SCOPE, None).unwrap();
    let lamp = capture.channels.iter().find(|channel| channel.name == "Lampe").unwrap();
    assert_eq!((lamp.unit.as_str(), lamp.shape), ("V", ChannelType::Real));
    assert_eq!(changes(&capture, "Lampe")[1], (within(1_520_000_000, 1_525_000_000), Value::Real(23.7)));
}

#[test]
fn numbers_of_64_bits_without_a_sign_keep_their_digits() {
    let text = "time [s],n\n0,1\n1,18446744073709551615\n2,9007199254740993\n";
    let capture = read(CaptureFormat::Csv, text.as_bytes(), None).unwrap();
    assert_eq!(capture.channels[0].shape, ChannelType::Whole);
    let values: Vec<Value> = changes(&capture, "n").into_iter().map(|(_, value)| value).collect();
    assert_eq!(values, [Value::Int(1), Value::Word(u64::MAX), Value::Int(9_007_199_254_740_993)]);
}

#[test]
fn two_rows_of_one_instant_say_that_instants_are_rounded() {
    let rows = |second: &str| format!("time [ms],a,b\n0,0,0\n1.250,1,0\n{second},1,1\n2.5,0,1\n");
    let at = |second: &str, channel: &str, place: usize| {
        let capture = read(CaptureFormat::Csv, rows(second).as_bytes(), Some(Span::from_nanos(1))).unwrap();
        changes(&capture, channel)[place].0
    };
    assert_eq!(at("1.260", "a", 1), within(1_249_999, 1_250_000));
    assert_eq!(at("1.250", "a", 1), within(1_248_999, 1_251_000));
    assert_eq!(at("1.250", "b", 1), within(1_248_999, 1_251_000));
    assert_eq!(at("1.250", "a", 2), within(2_498_999, 2_501_000));
    // What a channel is at the first instant is no change.
    assert_eq!(at("1.250", "a", 0), within(0, 0));
}

#[test]
fn what_is_wrong_is_said_with_its_line() {
    for (text, line, words) in [
        ("time,a\n0,1", 1, "names no unit"),
        ("time [s]\n0", 1, "one column only"),
        ("t (ms),a\n0,1\n1,maybe", 3, "`maybe` is no value"),
        ("t (ms),a\n0,1\n# c\nsoon,1", 4, "`soon` is no time"),
        ("t (ms),a\n5,1\n4,0", 3, "runs backwards"),
        ("t (ms),a\n5,1,0", 2, "more than the 2 columns"),
        ("t_ns,a\n1e40,1", 2, "is no time"),
    ] {
        let error = refused(CaptureFormat::Csv, text);
        assert_eq!(error.place, CapturePlace::Line(line), "{text}");
        assert!(error.what.contains(words) && !error.fix.is_empty(), "{error}");
    }
    let declared = "$timescale 1 us $end\n$var wire 1 ! a $end\n$enddefinitions $end\n";
    for (text, line, words) in [
        (format!("{declared}#5 1!\n#4 0!"), 5, "backwards"),
        (format!("{declared}#5\n1?"), 5, "declared nowhere"),
        (format!("{declared}#5\nhello"), 5, "no value change dump"),
        (format!("{declared}#18446744073709551615 1!"), 4, "292 years"),
        ("$timescale 0 us $end".into(), 1, "timescale of 0"),
    ] {
        let error = refused(CaptureFormat::Vcd, &text);
        assert_eq!(error.place, CapturePlace::Line(line), "{text} {error}");
        assert!(error.what.contains(words), "{error}");
    }
    assert_eq!(refused(CaptureFormat::Csv, "").place, CapturePlace::Whole);
    assert!(refused(CaptureFormat::Vcd, "$date today $end").what.contains("header does not end"));
    assert!(refused(CaptureFormat::Sigrok, "PK\u{3}\u{4}").what.contains("no whole archive"));
}

#[test]
fn a_damaged_session_is_refused() {
    for length in (0..LAMP.len()).step_by(7) {
        assert!(read(CaptureFormat::Sigrok, &LAMP[..length], None).is_err(), "{length}");
    }
    // A byte of the samples: the checksum shows it.
    let data = LAMP.windows(9).position(|bytes| bytes == b"logic-1-1").unwrap() + 12;
    let mut broken = LAMP.to_vec();
    broken[data] ^= 1;
    let error = read(CaptureFormat::Sigrok, &broken, None).unwrap_err();
    assert_eq!(
        (error.place, error.what.as_str()),
        (CapturePlace::Entry("logic-1-1".into()), "it is damaged")
    );
}

#[test]
fn a_file_that_claims_to_be_huge_takes_no_memory() {
    let at = LAMP.windows(4).rposition(|bytes| bytes == b"PK\x01\x02").unwrap();
    let mut huge = LAMP.to_vec();
    huge[at + 24..at + 28].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(read(CaptureFormat::Sigrok, &huge, None).unwrap_err().what.contains("more than"));
    let mut deep = String::from("$timescale 1 ns $end");
    (0..100_000).for_each(|_| deep.push_str(" $scope module a $end"));
    assert!(refused(CaptureFormat::Vcd, &deep).what.contains("header"));
}

proptest! {
    #[test]
    fn no_mutation_panics(file in 0usize..7, place in 0.0f64..1.0, byte: u8, cut in 0.0f64..1.0) {
        let (format, bytes) = [
            (CaptureFormat::Sigrok, LAMP), (CaptureFormat::Sigrok, DEMO), (CaptureFormat::Vcd, SIGROK_VCD), (CaptureFormat::Csv, SIGROK_CSV),
            (CaptureFormat::Vcd, RIG_VCD), (CaptureFormat::Csv, EDGES), (CaptureFormat::Csv, SCOPE),
        ][file];
        let mut bytes = bytes.to_vec();
        let at = (place * bytes.len() as f64) as usize;
        bytes[at] = byte;
        let _ = read(format, &bytes, None);
        bytes.truncate((cut * bytes.len() as f64) as usize);
        let _ = read(format, &bytes, Some(Span::from_nanos(1)));
    }
}

#[test]
fn a_dump_of_the_rig_has_how_well_its_numbers_are_known() {
    let of = |uncertainty: &str| {
        let text = format!(
            "$version rig 0.1.0 $end\n$comment uncertainty u_uncertainty u $end\n$timescale 1 ns $end\n$scope module rig $end\n\
             $var real 64 ! u $end\n$var real 64 # v $end\n$var real 64 \" u_uncertainty $end\n$upscope $end\n\
             $enddefinitions $end\n#5\nr{uncertainty} \"\nr3.5 !\nr1 #\n#9\nr4 !\n#12\nr0 \"\nr4 !\n"
        );
        read(CaptureFormat::Vcd, text.as_bytes(), None).unwrap()
    };
    let capture = of("0.25");
    let names: Vec<_> = capture.channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(names, ["u", "v"]);
    let values = |capture: &Capture, name: &str| -> Vec<Value> {
        changes(capture, name).into_iter().map(|(_, value)| value).collect()
    };
    let measured = |value| Value::measured(value, 0.25);
    assert_eq!(values(&capture, "u"), [measured(3.5), measured(4.0), Value::Real(4.0)]);
    assert_eq!(values(&capture, "v"), [Value::Real(1.0)]);
    // What cannot be read as an uncertainty leaves the truth open.
    for wrong in ["-1", "nan", "inf", "1e300"] {
        assert_eq!(values(&of(wrong), "u"), [Value::Unknown, Value::Real(4.0)], "{wrong}");
    }
}
