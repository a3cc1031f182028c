//! Captures judged with what their instrument may be off: cases computed by hand, and random errors within what is stated,
//! against the judgement of what truly was.

use super::*;
use crate::case::rejudge::judge_gathered;
use crate::suite::instrument_file;
use crate::suite::{self, FileSource};
use capture::{CapturedChange, TimebaseErrors};
use document::SourceFile;
use proptest::prelude::*;
use record::{CaseRecord, Verdict};

mod dumps;

const PROGRAM: &str = "PROGRAM MAIN VAR button AT %IX0.0 : BOOL; lamp AT %QX0.4 : BOOL; END_VAR lamp := button; \
                       END_PROGRAM";
const BOARD: &str =
    "format = 1\n[board]\nkind = \"simulated\"\n[channels]\nu = { kind = \"analog\", unit = \"V\" }\n";
const HEAD: &str = r#"format = 1
program = "lamp.st"
board = "board.toml"
signals = { button = "%IX0.0", lamp = "%QX0.4", u = { channel = "u" } }
steps = [{ id = "press", at = "start + 1 s", set = { signal = "button", value = true } }]
"#;

struct Bench(String);

impl FileSource for Bench {
    fn read(&self, path: &str) -> Result<String, String> {
        match path {
            "plan.toml" => Ok(self.0.clone()),
            "lamp.st" => Ok(PROGRAM.to_owned()),
            "board.toml" => Ok(BOARD.to_owned()),
            _ => Err("there is no such file".to_owned()),
        }
    }
}

/// Button and lamp as levels, `u` in volts.
fn capture(changes: Vec<(u32, When, Value)>, last: i64) -> Capture {
    let channel = |name: &str, shape, unit: &str| CapturedChannel {
        name: name.to_owned(),
        shares_name: false,
        unit: unit.to_owned(),
        shape,
        recording: None,
    };
    let mut changes: Vec<CapturedChange> =
        changes.into_iter().map(|(channel, at, value)| CapturedChange { channel, at, value }).collect();
    changes.sort_by_key(|change| change.at.latest);
    Capture {
        channels: vec![
            channel("B", ChannelType::Bit, ""),
            channel("L", ChannelType::Bit, ""),
            channel("U", ChannelType::Real, "V"),
        ],
        changes,
        knowledge: Knowledge::Edges(Span::ZERO),
        span: [Time::ZERO, Time::from_nanos(last)],
        end: When::exactly(Time::from_nanos(last)),
        notes: Vec::new(),
    }
}

/// Judges a capture whose button is pressed by the step `press`.
fn judge(claims: &str, capture: Capture, instrument: &str) -> CaseRecord {
    judge_twice(claims, capture, instrument, false).0
}

/// The same, and judges again the value change dump that the rig writes of it.
fn judge_twice(
    claims: &str,
    capture: Capture,
    instrument: &str,
    dumped: bool,
) -> (CaseRecord, Option<CaseRecord>) {
    judge_plan(&format!("{HEAD}{claims}"), capture, instrument, dumped)
}

/// The same of a whole plan.
fn judge_plan(
    plan: &str,
    mut capture: Capture,
    instrument: &str,
    dumped: bool,
) -> (CaseRecord, Option<CaseRecord>) {
    let bench = Bench(plan.to_owned());
    let loaded = suite::load_plan(&bench, "plan.toml", None, &[], 1, &mut Vec::new())
        .unwrap_or_else(|found| panic!("{found:#?}"));
    let job = loaded.jobs(0, 1, 1).into_iter().next().unwrap();
    let case = loaded.plan.case(0).unwrap();
    let files = loaded.files(&case, &job).unwrap();
    let layout = lay_out(&case, &files).unwrap();
    let file = SourceFile::new("scope.toml", format!("format = 1\n{instrument}"));
    let instrument = instrument_file::read(&file).unwrap_or_else(|found| panic!("{found:#?}"));
    let wire = |(channel, signal): (usize, &str)| {
        let place = layout.signals().iter().position(|info| info.name == signal).unwrap();
        let name = &capture.channels[channel].name;
        ChannelMapping::new(channel, place).described(&layout.signals()[place], &instrument, name)
    };
    let mut wires: Vec<ChannelMapping> =
        [(0, "button"), (1, "lamp"), (2, "u")].into_iter().map(wire).collect();
    find_levels(&mut capture, &mut wires);
    capture.correct(&instrument.errors());
    let pressed = |change: &&CapturedChange| {
        change.channel as usize == wires[0].channel && change.value == Value::Bool(true)
    };
    let press = capture.changes.iter().find(pressed).unwrap().at;
    capture.widen_by_rate(press, instrument.timebase.rate);
    let before = |at: Time| at.saturating_add(Span::from_secs(-1));
    let start = When::within(before(press.earliest), before(press.latest));
    let instants = Instants { start, steps: vec![("press".to_owned(), press)] };
    let trace = trace(layout, &case, &files, &capture, &wires, Some(&instants), Some(&instrument)).unwrap();
    let judged = |trace: &Trace| {
        judge_gathered(loaded.plan.text(), trace).unwrap_or_else(|found| panic!("{found:#?}"))
    };
    let record = judged(&trace);
    if !dumped {
        return (record, None);
    }
    let mut dump = Vec::new();
    reports::vcd::write_trace(&trace, "0", &mut dump).unwrap();
    let dump = capture::read(capture::CaptureFormat::Vcd, &dump, None).unwrap();
    assert_eq!(dump.knowledge, Knowledge::Own);
    let again = from_dump(lay_out(&case, &files).unwrap(), &case, &files, &dump);
    (record, Some(judged(&again)))
}

/// The trace of a dump of the rig's own.
fn from_dump(layout: CaseLayout, case: &Case, files: &CaseFiles, dump: &Capture) -> Trace {
    let spelled = reports::vcd::names(layout.signals());
    let place = |channel: &CapturedChannel| spelled.iter().position(|name| *name == channel.name);
    let wires: Vec<ChannelMapping> = (dump.channels.iter().enumerate())
        .map(|(channel, of)| ChannelMapping::new(channel, place(of).unwrap()))
        .collect();
    super::trace(layout, case, files, dump, &wires, None, None).unwrap()
}

const MS: i64 = 1_000_000;
const S: i64 = 1_000 * MS;

fn exactly(at: i64) -> When {
    When::exactly(Time::from_nanos(at))
}

/// The button at 1 s, and the lamp so much later.
fn lamp_after(delay: i64) -> Capture {
    let changes = vec![
        (0, exactly(0), Value::Bool(false)),
        (1, exactly(0), Value::Bool(false)),
        (2, exactly(0), Value::Real(10.0)),
        (0, exactly(S), Value::Bool(true)),
        (1, exactly(S + delay), Value::Bool(true)),
    ];
    capture(changes, 20 * S)
}

/// A plan with a limit for the time from the button to the lamp.
fn delay_within(max: &str) -> String {
    format!(
        "ends = \"start + 13 s\"\nmeasure = [{{ name = \"delay\", from = \"press\", to = {{ signal = \"lamp\", edge = \
         \"rises\" }}, max = \"{max}\" }}]\n"
    )
}

fn delay(record: &CaseRecord) -> (Verdict, [f64; 2], &str) {
    let taken = &record.measurements[0];
    (taken.verdict, taken.value.unwrap(), &taken.coverage)
}

#[test]
fn a_rate_error_counts_by_the_time_since_the_reference() {
    // 100 ppm of 10 s: 1 000 100.01 ns, rounded up.
    let known = [10e9 - 1_000_101.0, 10e9 + 1_000_101.0];
    let of = |max: &str| judge(&delay_within(max), lamp_after(10 * S), "[timebase]\nerror = \"100 ppm\"");
    assert_eq!(delay(&of("10.001000101 s")), (Verdict::Pass, known, "limits"));
    assert_eq!(delay(&of("10.001000100 s")), (Verdict::Inconclusive, known, "limits"));
    assert_eq!(delay(&of("9.998999898 s")), (Verdict::Fail, known, "limits"));
    assert_eq!(
        delay(&judge(&delay_within("10 s"), lamp_after(10 * S), "")),
        (Verdict::Pass, [10e9; 2], "limits")
    );
}

#[test]
fn each_error_of_an_instant_widens_a_time_by_what_it_is() {
    for (instrument, low, high, coverage) in [
        // Each of both instants by one step, either way.
        ("[timebase]\nresolution = \"10 ns\"", -20, 20, "limits"),
        // Two channels are at most so far apart.
        ("[timebase]\nskew = \"4 ns\"\ncoverage = \"k = 2\"", -4, 4, "k = 2"),
        ("[timebase]\noffset = \"-3 us\"\noffset-error = \"1 us\"", 0, 0, "limits"),
        ("[channels.L]\ndelay = \"50 ns\"\ndelay-error = \"3 ns\"", -53, -47, "limits"),
        ("[channels.B]\ndelay = \"50 ns\"", 50, 50, "limits"),
    ] {
        let record = judge(&delay_within("1 s"), lamp_after(500 * MS), instrument);
        let own = 500 * MS;
        let known = [(own + low) as f64, (own + high) as f64];
        assert_eq!(delay(&record), (Verdict::Pass, known, coverage), "{instrument}");
        assert_eq!(record.instrument.unwrap().file, "scope.toml");
    }
}

#[test]
fn a_reading_is_known_to_within_its_accuracy() {
    let plan = |max: &str| {
        format!("measure = [{{ name = \"u\", value-of = \"u\", when = \"press\", max = \"{max}\" }}]\n")
    };
    // 1.5 % of 10 V and 50 mV: 0.2 V, and at most 3 % more for how it is kept.
    let instrument = "[channels.U]\nunit = \"V\"\naccuracy = { of-value = \"1.5 %\", plus = \"50 mV\", coverage = \"95 %\" }";
    for (max, verdict) in
        [("10.207 V", Verdict::Pass), ("10.19 V", Verdict::Inconclusive), ("9.79 V", Verdict::Fail)]
    {
        let record = judge(&plan(max), lamp_after(MS), instrument);
        let (found, [low, high], coverage) = delay(&record);
        assert_eq!((found, coverage), (verdict, "95 %"), "{max}");
        assert!((9.793..=9.8).contains(&low) && (10.2..=10.207).contains(&high), "{low} {high}");
    }
}

#[test]
fn a_dump_keeps_how_well_a_reading_is_known() {
    let instrument = "[channels.U]\nunit = \"V\"\naccuracy = { of-value = \"1.5 %\", plus = \"50 mV\", coverage = \"95 %\" }";
    for (max, verdict) in
        [("10.207 V", Verdict::Pass), ("10.19 V", Verdict::Inconclusive), ("9.79 V", Verdict::Fail)]
    {
        let claims = format!(
            "measure = [{{ name = \"u\", value-of = \"u\", when = \"press\", max = \"{max}\" }}]\n\
             expect = [{{ stays = {{ signal = \"u\", max = \"{max}\" }} }}]\n"
        );
        let (record, again) = judge_twice(&claims, lamp_after(MS), instrument, true);
        let again = again.unwrap();
        assert_eq!((record.verdict, again.verdict), (verdict, verdict), "{max}");
        assert_eq!((&again.claims, &again.measurements), (&record.claims, &record.measurements), "{max}");
    }
}

#[test]
fn a_voltage_is_a_level_by_its_hysteresis() {
    // The lamp is `u` here: above 13 V it is TRUE. 12.9 V may be 13.1 V.
    let mut seen = lamp_after(MS);
    seen.channels.swap(1, 2);
    for change in &mut seen.changes {
        change.channel = [0, 2, 1][change.channel as usize];
    }
    seen.changes.retain(|change| change.channel != 1);
    for (ms, volts) in [(0, 0.0), (1_499, 12.0), (1_500, 12.9), (1_510, 14.0)] {
        let at = When::within(Time::from_nanos((ms - 1).max(0) * MS), Time::from_nanos(ms * MS));
        seen.changes.push(CapturedChange { channel: 1, at, value: Value::Real(volts) });
    }
    seen.changes.sort_by_key(|change| change.at.latest);
    seen.channels[1].name = "V".to_owned();
    let of = |error: &str| {
        let file = format!("[channels.V]\nunit = \"V\"\nthreshold = \"12 V\"\nhysteresis = \"2 V\"\n{error}");
        let record = judge(&delay_within("1 s"), seen.clone(), &file);
        let (verdict, value, coverage) = delay(&record);
        (verdict, value.map(|end| (end / MS as f64).round() as i64), coverage.to_owned())
    };
    assert_eq!(of(""), (Verdict::Pass, [509, 510], "limits".into()));
    let error = "accuracy = { plus = \"200 mV\", coverage = \"99 %\" }";
    assert_eq!(of(error), (Verdict::Pass, [499, 510], "99 %".into()));
}

#[test]
fn a_change_that_may_have_come_before_the_end_counts() {
    let claim = "ends = \"press + 1 s\"\nexpect = [{ stays = { signal = \"lamp\", is = false, from = \"press\", until = \"end\" } }]\n";
    let of = |lamp: When| {
        let mut seen = lamp_after(0);
        seen.changes.retain(|change| change.channel != 1 || change.at == exactly(0));
        seen.changes.push(CapturedChange { channel: 1, at: lamp, value: Value::Bool(true) });
        judge(claim, seen, "").verdict
    };
    let end = 2 * S;
    let within = |from, until| When::within(Time::from_nanos(end + from), Time::from_nanos(end + until));
    assert_eq!(of(within(-2 * MS, -MS)), Verdict::Fail);
    assert_eq!(of(within(-MS, MS)), Verdict::Inconclusive);
    assert_eq!(of(within(MS, 2 * MS)), Verdict::Pass);
}

/// What truly happened: instants of the lamp in microseconds after the button, and of `u`, each with its value.
#[derive(Clone, Debug)]
struct Truth {
    lamp: Vec<i64>,
    u: Vec<(i64, f64)>,
}

fn truths() -> impl Strategy<Value = Truth> {
    let times = |most| proptest::collection::btree_set(1..1_000_000i64, 1..most);
    (times(12), times(6), proptest::collection::vec(-10.0..10.0f64, 6)).prop_map(|(lamp, u, values)| Truth {
        lamp: lamp.into_iter().collect(),
        u: u.into_iter().zip(values).collect(),
    })
}

/// How an instrument is off: its stated bounds, and where within them.
#[derive(Clone, Debug)]
struct Off {
    rate_ppm: u32,
    offset: i64,
    resolution: i64,
    skew: i64,
    delay_error: i64,
    of_value_permille: u32,
    plus_mv: u32,
    /// Parts of what is stated, from -1 to 1: the rate, the channels, the delay, and each reading.
    parts: Vec<f64>,
}

fn offs() -> impl Strategy<Value = Off> {
    (
        (0..2_000u32, -MS..MS, 1..200_000i64, 0..50_000i64, 0..50_000i64, 0..50u32, 0..500u32),
        proptest::collection::vec(-1.0..=1.0f64, 24),
    )
        .prop_map(
            |((rate_ppm, offset, resolution, skew, delay_error, of_value_permille, plus_mv), parts)| Off {
                rate_ppm,
                offset,
                resolution,
                skew,
                delay_error,
                of_value_permille,
                plus_mv,
                parts,
            },
        )
}

impl Off {
    fn file(&self) -> String {
        format!(
            "[timebase]\nerror = \"{} ppm\"\noffset = \"{} ns\"\nresolution = \"{} ns\"\nskew = \"{} ns\"\n[channels.L]\n\
             delay = \"2 us\"\ndelay-error = \"{} ns\"\n[channels.U]\nunit = \"V\"\naccuracy = {{ of-value = \"{}\", plus = \"{} mV\" }}\n",
            self.rate_ppm,
            self.offset,
            self.resolution,
            self.skew,
            self.delay_error,
            format_args!("{}.{} %", self.of_value_permille / 10, self.of_value_permille % 10),
            self.plus_mv,
        )
    }

    /// The stamp that a channel gives a true time, in nanoseconds.
    fn stamp(&self, channel: usize, time: i64) -> i64 {
        let rate = f64::from(self.rate_ppm) * 1e-6 * self.parts[0];
        let own = self.parts[1 + channel] * self.skew as f64 / 2.0;
        let delay = if channel == 1 { 2_000.0 + self.parts[4] * self.delay_error as f64 } else { 0.0 };
        let shown = time as f64 * (1.0 + rate) + own + delay + self.offset as f64 + 3e9;
        (shown as i64).div_euclid(self.resolution) * self.resolution
    }

    /// A reading from which the truth is as far as is stated at most.
    fn reading(&self, place: usize, truth: f64) -> f64 {
        let (part, plus) = (f64::from(self.of_value_permille) / 1_000.0, f64::from(self.plus_mv) / 1_000.0);
        let read = truth + self.parts[5 + place] * (part * truth.abs() + plus);
        if (truth - read).abs() <= part * read.abs() + plus { read } else { truth }
    }
}

const CLAIMS: &str = r#"ends = "press + 1 s"
expect = [
  { name = "first", rises = { signal = "lamp", from = "press", within = "20 ms .. 150 ms" } },
  { name = "off", stays = { signal = "lamp", is = false, from = "press", until = "press + 50 ms" } },
  { name = "count", edges = { signal = "lamp", rising = 3, from = "press", until = "press + 700 ms" } },
  { name = "pulses", pulse = { signal = "lamp", width = "1 ms .. 400 ms", from = "press", until = "press + 900 ms" } },
  { name = "value", value = { of = "u", min = "0 V", max = "8 V", when = "press + 500 ms" } },
  { name = "never", never = { signal = "u", min = "9 V", from = "press", until = "press + 900 ms" } },
]
measure = [
  { name = "delay", from = "press", to = { signal = "lamp", edge = "rises" }, max = "100 ms" },
  { name = "frequency", frequency-of = "lamp", from = "press", until = "press + 900 ms", max = "5 Hz" },
  { name = "duty", duty-of = "lamp", from = "press", until = "press + 900 ms", max = "50 %" },
  { name = "shortest", width-of = "lamp", take = "min", from = "press", until = "press + 900 ms", min = "30 ms" },
  { name = "period", period-of = "lamp", take = "max", from = "press", until = "press + 900 ms", max = "300 ms" },
  { name = "least", value-of = "u", take = "min", from = "press", until = "press + 900 ms", min = "-5 V" },
  { name = "span", value-of = "u", take = "span", from = "press", until = "press + 900 ms", max = "10 V" },
  { name = "mean", value-of = "u", take = "mean", from = "press", until = "press + 900 ms", max = "1 V" },
  { name = "rms", value-of = "u", take = "rms", from = "press", until = "press + 900 ms", max = "4 V" },
  { name = "end", value-of = "u", when = "press + 700 ms", max = "2 V" },
]
"#;

/// The capture of what happened, by the stamps and readings of an instrument; without one by the truth.
fn seen(truth: &Truth, off: Option<&Off>) -> Capture {
    let stamp = |channel: usize, time: i64| match off {
        Some(off) => off.stamp(channel, time),
        None => time + 3 * S,
    };
    let read = |place: usize, value: f64| off.map_or(value, |off| off.reading(place, value));
    let mut changes = vec![
        (0, exactly(stamp(0, -2 * S)), Value::Bool(false)),
        (1, exactly(stamp(1, -2 * S)), Value::Bool(false)),
        (2, exactly(stamp(2, -2 * S)), Value::Real(read(10, 1.0))),
        (0, exactly(stamp(0, 0)), Value::Bool(true)),
    ];
    for (place, time) in truth.lamp.iter().enumerate() {
        changes.push((1, exactly(stamp(1, time * 1_000)), Value::Bool(place % 2 == 0)));
    }
    for (place, (time, value)) in truth.u.iter().enumerate() {
        changes.push((2, exactly(stamp(2, time * 1_000)), Value::Real(read(place, *value))));
    }
    capture(changes, stamp(0, 5 * S))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    /// Whatever the instrument was off within what it states: what is judged with its file holds of what truly was.
    #[test]
    fn no_error_within_the_stated_ones_contradicts_a_verdict(truth in truths(), off in offs()) {
        let (exact, judged) = (judge(CLAIMS, seen(&truth, None), ""), judge(CLAIMS, seen(&truth, Some(&off)), &off.file()));
        prop_assert_eq!(exact.claims.len(), judged.claims.len());
        let fits = |known: Verdict, found: Verdict| match found {
            Verdict::Pass | Verdict::Fail => known == found || known == Verdict::Inconclusive,
            _ => true,
        };
        for (known, found) in exact.claims.iter().zip(&judged.claims) {
            prop_assert!(fits(known.verdict, found.verdict), "{known:?}\n{found:?}\n{}", off.file());
        }
        for (known, found) in exact.measurements.iter().zip(&judged.measurements) {
            prop_assert!(fits(known.verdict, found.verdict), "{known:?}\n{found:?}\n{}", off.file());
            if let (Some([low, high]), Some([least, most])) = (known.value, found.value) {
                // What floats round is no error of the instrument.
                let by = 1e-9 * low.abs().max(high.abs()).max(1.0);
                let whole = found.verdict == Verdict::Inconclusive && !found.reason.contains("uncertainty");
                prop_assert!(whole || least - by <= low && high <= most + by, "{known:?}\n{found:?}\n{}", off.file());
            }
        }
    }
}

#[test]
fn an_instant_that_is_named_by_a_time_is_off_by_the_offset_alone() {
    let timebase = TimebaseErrors { offset_error: Span::from_nanos(5), ..TimebaseErrors::default() };
    assert_eq!(timebase.named(Time::ZERO), When::within(Time::from_nanos(-5), Time::from_nanos(5)));
}
