//! The rig's own value change dumps, judged again: what a trace knows, its dump has to know.

use super::*;
use signal::SignalRecording;

/// The trace that is read from the dump of a trace.
fn dumped(trace: &Trace, bench: &Bench) -> Trace {
    let mut dump = Vec::new();
    reports::vcd::write_trace(trace, "0", &mut dump).unwrap();
    let dump = capture::read(capture::CaptureFormat::Vcd, &dump, None).unwrap();
    let loaded = suite::load_plan(bench, "plan.toml", None, &[], 1, &mut Vec::new()).unwrap();
    let (job, case) = (loaded.jobs(0, 1, 1).remove(0), loaded.plan.case(0).unwrap());
    let files = loaded.files(&case, &job).unwrap();
    from_dump(lay_out(&case, &files).unwrap(), &case, &files, &dump)
}

/// How a signal may have been recorded.
fn recordings() -> impl Strategy<Value = SignalRecording> {
    let span = || (0..3_000i64).prop_map(Span::from_nanos);
    let clock =
        prop_oneof![Just(ClockDomain::Virtual), Just(ClockDomain::Monotonic), Just(ClockDomain::Device)];
    let sampling = prop_oneof![
        span().prop_map(|resolution| Sampling::Edges { resolution }),
        span().prop_map(|period| Sampling::Sampled { period }),
    ];
    let policy = prop_oneof![
        Just(Policy::Changes),
        (1..100u32).prop_map(|tenths| Policy::Deadband(f64::from(tenths) / 10.0)),
        (1..2_000i64).prop_map(|ns| Policy::AtMostEvery(Span::from_nanos(ns))),
    ];
    (clock, sampling, span(), policy).prop_map(|(clock, sampling, shortest_pulse, policy)| SignalRecording {
        clock,
        sampling,
        shortest_pulse,
        policy,
    })
}

/// Instants of a change: from when, for how long, in nanoseconds; and a choice of its value.
type Drawn = (usize, i64, i64, u8, f64);

fn value(kind: ValueKind, choice: u8, number: f64) -> Value {
    match (kind, choice) {
        (_, 0) => Value::Unknown,
        (ValueKind::Bool, 1) => Value::HighZ,
        (ValueKind::Bool, choice) => Value::Bool(choice % 2 == 0),
        (ValueKind::Real, 1) => Value::Real(f64::INFINITY),
        (ValueKind::Real, 2) => Value::measured(number, number.abs() / 7.0),
        (ValueKind::Real, _) => Value::Real(number),
        _ => Value::Int(number as i64),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    /// Signals recorded in every way, changes out of order, before 0, unknown, measured, of every kind of signal: the dump has
    /// each of them, within an interval that holds the one of the trace, and every note.
    #[test]
    fn a_dump_knows_what_its_trace_knows(
        how in proptest::collection::vec(recordings(), 16),
        drawn in proptest::collection::vec((0..16usize, -5_000..50_000i64, 0..2_000i64, 0..6u8, -1e6..1e6f64), 0..60),
        words in proptest::collection::vec(("[a-zä:$\\\\ ]{1,12}", "[ -~äß\n\t]{0,20}"), 0..4),
    ) {
        let bench = Bench(format!("{HEAD}expect = [{{ edges = {{ signal = \"lamp\", rising = 1 }} }}]\n"));
        let loaded = suite::load_plan(&bench, "plan.toml", None, &[], 1, &mut Vec::new()).unwrap();
        let (job, case) = (loaded.jobs(0, 1, 1).remove(0), loaded.plan.case(0).unwrap());
        let files = loaded.files(&case, &job).unwrap();
        let layout = lay_out(&case, &files).unwrap();
        let mut trace = Trace::new();
        for (info, how) in layout.signals().iter().zip(how.iter().cycle()) {
            trace.define(how.applied_to(info.clone())).unwrap();
        }
        for (key, text) in &words {
            // Not one of those by which a plan is judged.
            trace.set_note(&format!("x{key}"), text.clone());
        }
        let count = trace.signals().len();
        for (place, from, width, choice, number) in drawn as Vec<Drawn> {
            let signal = SignalId((place % count) as u32);
            let kind = trace.signals()[place % count].kind;
            let at = When::within(Time::from_nanos(from), Time::from_nanos(from + width));
            trace.push(Event { signal, at, value: value(kind, choice, number), cause: Cause::Board }).unwrap();
        }
        let again = dumped(&trace, &bench);
        prop_assert_eq!(again.signals(), trace.signals());
        for (key, text) in trace.notes() {
            prop_assert_eq!(again.note(key), Some(text), "{}", key);
        }
        let of = |trace: &Trace, signal: usize| -> Vec<Event> {
            let mut events: Vec<Event> = trace.events().map(Result::unwrap).collect();
            events.retain(|event| event.signal.0 as usize == signal);
            events.sort_by_key(|event| event.at.latest);
            // In the order of time a signal may seem to be twice what it was.
            events.dedup_by_key(|event| event.value);
            events
        };
        // Instants count from the earliest of all.
        let origin = trace.events().map(|event| event.unwrap().at.earliest).min().unwrap_or_default().min(Time::ZERO);
        let moved = again.events().map(|event| event.unwrap().at.earliest).min().is_none_or(|at| at >= origin);
        prop_assert!(moved);
        for signal in 0..count {
            let (before, after) = (of(&trace, signal), of(&again, signal));
            let values = |events: &[Event]| events.iter().map(|event| event.value).collect::<Vec<_>>();
            prop_assert_eq!(values(&before), values(&after));
            for (known, read) in before.iter().zip(&after) {
                prop_assert!(read.at.earliest <= known.at.earliest && known.at.latest == read.at.latest, "{:?} {:?}", known, read);
            }
        }
    }
}

/// The verdicts of both, which have to be the same claim by claim.
fn same(plan: &str, capture: Capture) -> Vec<Verdict> {
    let (record, again) = judge_plan(plan, capture, "", true);
    let again = again.unwrap();
    assert_eq!(again.claims, record.claims);
    assert_eq!(again.measurements, record.measurements);
    assert_eq!(again.verdict, record.verdict);
    record.claims.iter().map(|claim| claim.verdict).collect()
}

#[test]
fn a_dump_keeps_that_a_channel_was_only_sampled() {
    let claims = "ends = \"start + 18 s\"\nexpect = [\n\
                  { stays = { signal = \"lamp\", is = false, from = \"press\", until = \"press + 9 s\" } },\n\
                  { edges = { signal = \"lamp\", rising = 1, from = \"press\" } },\n]\n";
    let plan = format!("{HEAD}{claims}");
    let seen = |knowledge| Capture { knowledge, ..lamp_after(10 * S) };
    let sampled = same(&plan, seen(Knowledge::Sampled(Span::from_secs(1))));
    assert_eq!(sampled, [Verdict::Inconclusive; 2]);
    assert_eq!(same(&plan, seen(Knowledge::Edges(Span::ZERO))), [Verdict::Pass; 2]);
}

#[test]
fn a_dump_keeps_that_a_step_may_have_come() {
    let steps = "steps = [\n  { id = \"press\", at = \"start + 1 s\", set = { signal = \"button\", value = true } },\n\
                 { id = \"lit\", when = { signal = \"lamp\", edge = \"rises\", from = \"press\", within = \"500 ms\" } },\n\
                 { id = \"next\", at = \"lit + 1 s\", set = { signal = \"button\", value = false } },\n]\n\
                 ends = \"start + 5 s\"\nexpect = [{ happens = { step = \"lit\" } }]\n";
    let head = HEAD.split("steps =").next().unwrap();
    let plan = format!("{head}{steps}");
    let with_lamp = |from: i64, until: i64| {
        let mut seen = lamp_after(S);
        let at = When::within(Time::from_nanos(S + from * MS), Time::from_nanos(S + until * MS));
        seen.changes.retain(|change| change.channel != 1 || change.at == exactly(0));
        seen.changes.push(CapturedChange { channel: 1, at, value: Value::Bool(true) });
        seen
    };
    assert_eq!(same(&plan, with_lamp(400, 401)).into_iter().max(), Some(Verdict::Pass));
    assert_eq!(same(&plan, with_lamp(499, 501)).into_iter().max(), Some(Verdict::Inconclusive));
    assert_eq!(same(&plan, with_lamp(501, 502)).into_iter().max(), Some(Verdict::Fail));
}

#[test]
fn a_dump_keeps_what_came_before_the_trigger() {
    let claims = "ends = \"press + 2 s\"\nexpect = [\n\
                  { rises = { signal = \"lamp\", from = \"press\", within = \"400 ms .. 600 ms\" } },\n\
                  { edges = { signal = \"lamp\", rising = 1, from = \"press\" } },\n]\n";
    let mut seen = lamp_after(500 * MS);
    let earlier = |at: Time| at.saturating_add(Span::from_secs(-10));
    for change in &mut seen.changes {
        change.at = When::within(earlier(change.at.earliest), earlier(change.at.latest));
    }
    seen.span = seen.span.map(earlier);
    assert_eq!(same(&format!("{HEAD}{claims}"), seen), [Verdict::Pass; 2]);
}

#[test]
fn a_dump_that_is_cut_off_is_none() {
    let mut trace = Trace::new();
    let a = trace.define(SignalInfo::exact("a", ValueKind::Bool)).unwrap();
    let at = When::within(Time::ZERO, Time::from_nanos(5));
    trace.push(Event { signal: a, at, value: Value::Bool(true), cause: Cause::Unknown }).unwrap();
    let mut dump = Vec::new();
    reports::vcd::write_trace(&trace, "0", &mut dump).unwrap();
    let read = |text: &str| capture::read(capture::CaptureFormat::Vcd, text.as_bytes(), None);
    let text = String::from_utf8(dump).unwrap();
    assert_eq!(read(&text).unwrap().changes.len(), 1);
    let cut = &text[..text.rfind("$comment").unwrap()];
    assert!(read(cut).unwrap_err().to_string().contains("cut off"));
    let strange = text.replace("edges 0 ns", "edges");
    assert!(read(&strange).unwrap_err().to_string().contains("recorded"));
}
