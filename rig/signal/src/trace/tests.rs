//! The trace against naive oracles: a plain list of events.

use std::io::{self, Read, Seek, SeekFrom, Write};
use std::sync::{Arc, Mutex};

use proptest::prelude::*;

use super::*;
use crate::{Cause, ClockDomain, Sampling, SignalGap, Span, Time, Value};

const SIGNALS: u32 = 4;

/// A store that the test can look into, spoil and let fail.
#[derive(Clone, Default)]
struct Store {
    bytes: Arc<Mutex<io::Cursor<Vec<u8>>>>,
    room: Option<usize>,
}

impl Read for Store {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        self.bytes.lock().unwrap().read(into)
    }
}

impl Write for Store {
    fn write(&mut self, from: &[u8]) -> io::Result<usize> {
        let mut bytes = self.bytes.lock().unwrap();
        if self.room.is_some_and(|room| bytes.position() as usize + from.len() > room) {
            return Err(io::ErrorKind::StorageFull.into());
        }
        bytes.write(from)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Store {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.bytes.lock().unwrap().seek(to)
    }
}

/// Every bit of an event: `Value`'s own equality takes `Int(1)` and `Word(1)` for equal.
fn bits(event: &Event) -> (u32, Time, Time, u64, u64, Cause) {
    let (kind, number) = match event.value {
        Value::Bool(b) => (0, u64::from(b)),
        Value::Int(n) => (1, n as u64),
        Value::Word(n) => (2, n),
        Value::Real(r) => (3, r.to_bits()),
        Value::HighZ => (4, 0),
        Value::Unknown => (5, 0),
        Value::Measured(r, by) => (6 + (u64::from(by.to_bits()) << 3), r.to_bits()),
    };
    (event.signal.0, event.at.earliest, event.at.latest, kind, number, event.cause)
}

fn all_bits(events: &[Event]) -> Vec<(u32, Time, Time, u64, u64, Cause)> {
    events.iter().map(bits).collect()
}

fn any_value() -> impl Strategy<Value = Value> {
    prop_oneof![
        4 => any::<bool>().prop_map(Value::Bool),
        2 => (-300i64..300).prop_map(Value::Int),
        1 => any::<i64>().prop_map(Value::Int),
        2 => any::<u64>().prop_map(Value::Word),
        2 => any::<u64>().prop_map(|n| Value::Real(f64::from_bits(n))),
        1 => (any::<u64>(), 1u32..0x7F80_0000)
            .prop_map(|(n, by)| Value::Measured(f64::from_bits(n), f32::from_bits(by))),
        1 => Just(Value::HighZ),
        1 => Just(Value::Unknown),
    ]
}

fn any_cause() -> impl Strategy<Value = Cause> {
    prop_oneof![
        Just(Cause::Unknown),
        Just(Cause::Controller),
        Just(Cause::Board),
        any::<u16>().prop_map(Cause::Step),
        any::<u8>().prop_map(Cause::Port),
        proptest::sample::select(SignalGap::ALL.to_vec()).prop_map(Cause::Gap),
        (any::<u8>(), any::<u16>(), any::<u32>()).prop_map(|(task, file, line)| Cause::Program {
            task,
            file,
            line
        }),
    ]
}

/// Events whose times mostly run forwards, as steps that `times` adds up.
fn any_events(max: usize) -> impl Strategy<Value = Vec<Event>> {
    let step = prop_oneof![
        8 => -20i64..100,
        2 => 0i64..50_000_000,
        1 => any::<i64>(),
    ];
    let width = prop_oneof![4 => Just(0i64), 2 => 0i64..40, 1 => any::<i64>()];
    let event = (0..SIGNALS, step, width, any_value(), any_cause());
    proptest::collection::vec(event, 0..max).prop_map(|list| {
        let mut now = 0i64;
        list.into_iter()
            .map(|(signal, step, width, value, cause)| {
                now = now.wrapping_add(step);
                let other = now.saturating_add(width);
                let at = When::within(Time::from_nanos(now), Time::from_nanos(other));
                Event { signal: SignalId(signal), at, value, cause }
            })
            .collect()
    })
}

/// Events of a short stretch of time that overlap and come out of order.
fn crowded_events(max: usize) -> impl Strategy<Value = Vec<Event>> {
    let event = (0..SIGNALS, -6i64..7, 0i64..6, any_value(), any_cause());
    proptest::collection::vec(event, 0..max).prop_map(|list| {
        list.into_iter()
            .enumerate()
            .map(|(place, (signal, jitter, width, value, cause))| {
                let earliest = place as i64 + jitter;
                let at = When::within(Time::from_nanos(earliest), Time::from_nanos(earliest + width));
                Event { signal: SignalId(signal), at, value, cause }
            })
            .collect()
    })
}

fn with_signals(mut trace: Trace) -> Trace {
    for n in 0..SIGNALS {
        let kind = if n == 0 { ValueKind::Mark } else { ValueKind::Int };
        trace.define(SignalInfo::exact(format!("s{n}"), kind)).unwrap();
    }
    trace
}

fn plain() -> Trace {
    with_signals(Trace::new())
}

/// What a trace keeps of `events`: for all but the first signal changes only, and of unknown values the reasons.
fn kept(events: &[Event]) -> Vec<Event> {
    let mut last: [Option<Event>; SIGNALS as usize] = [None; SIGNALS as usize];
    let mut kept = Vec::new();
    for event in events {
        let place = &mut last[event.signal.0 as usize];
        let reason = event.value == Value::Unknown && matches!(event.cause, Cause::Gap(_));
        let same = |last: Event| last.value == event.value && !(reason && last.cause != event.cause);
        if event.signal.0 == 0 || !place.is_some_and(same) {
            *place = Some(*event);
            kept.push(*event);
        }
    }
    kept
}

fn read(trace: &Trace) -> Vec<Event> {
    trace.events().collect::<Result<_, _>>().unwrap()
}

proptest! {
    #[test]
    fn what_is_pushed_reads_back(
        events in any_events(300),
        segment in 1usize..400,
        bound in prop_oneof![Just(0usize), 0usize..5000, Just(usize::MAX)],
    ) {
        let expected = kept(&events);
        let mut simple = plain();
        let mut cut = with_signals(Trace::segmented(segment, bound, Some(Box::new(Store::default()))));
        let mut kept_count = 0;
        for event in &events {
            kept_count += u64::from(cut.push(*event).unwrap().is_some());
            simple.push(*event).unwrap();
        }
        prop_assert_eq!(kept_count, expected.len() as u64);
        prop_assert_eq!(cut.len(), expected.len() as u64);
        prop_assert_eq!(all_bits(&read(&cut)), all_bits(&expected));
        let mut folded = Vec::new();
        cut.events().for_each(|event| folded.push(event.unwrap()));
        prop_assert_eq!(all_bits(&folded), all_bits(&expected));
        prop_assert_eq!(cut.digest(), simple.digest());
        for signal in 0..SIGNALS {
            let last = expected.iter().rev().find(|event| event.signal.0 == signal);
            prop_assert_eq!(cut.last(SignalId(signal)).as_ref().map(bits), last.map(bits));
        }

        // Equal files, whichever way the trace was held, and the file gives the same trace.
        let (mut file, mut other) = (Vec::new(), Vec::new());
        cut.save(&mut file).unwrap();
        simple.save(&mut other).unwrap();
        prop_assert!(file == other);
        let loaded = Trace::load(&mut file.as_slice(), LoadLimits::default()).unwrap();
        prop_assert_eq!(all_bits(&read(&loaded)), all_bits(&expected));
        prop_assert_eq!(loaded.digest(), cut.digest());
        prop_assert_eq!(loaded.signals(), cut.signals());
    }

    #[test]
    fn a_cursor_follows_a_growing_trace(
        events in any_events(200),
        bursts in proptest::collection::vec(1usize..30, 1..20),
        segment in 1usize..300,
    ) {
        let mut trace = with_signals(Trace::segmented(segment, 0, Some(Box::new(Store::default()))));
        let mut cursor = Cursor::new();
        let mut seen = Vec::new();
        let (mut left, mut burst) = (events.as_slice(), bursts.iter().cycle());
        while !left.is_empty() {
            let (now, later) = left.split_at(left.len().min(*burst.next().unwrap()));
            for event in now {
                trace.push(*event).unwrap();
            }
            left = later;
            // Reading may stop in the middle, too.
            let some = *burst.next().unwrap();
            for event in trace.since(&mut cursor).take(some) {
                seen.push(event.unwrap());
            }
        }
        for event in trace.since(&mut cursor) {
            seen.push(event.unwrap());
        }
        prop_assert_eq!(all_bits(&seen), all_bits(&kept(&events)));
        prop_assert!(trace.since(&mut cursor).next().is_none());
    }

    #[test]
    fn a_window_equals_a_naive_filter(
        events in crowded_events(150),
        segment in 1usize..200,
        from in -10i64..160,
        length in -2i64..60,
        forgotten in 0u32..1 << SIGNALS,
    ) {
        let (from, to) = (Time::from_nanos(from), Time::from_nanos(from + length));
        let mut trace = with_signals(Trace::segmented(segment, 300, Some(Box::new(Store::default()))));
        for event in &events {
            trace.push(*event).unwrap();
        }
        let kept = kept(&events);
        let window = trace.between(from, to).unwrap();
        for signal in 0..SIGNALS {
            let before = kept.iter().rev().find(|e| e.signal.0 == signal && e.at.latest < from);
            prop_assert_eq!(window.before(SignalId(signal)).as_ref().map(bits), before.map(bits));
        }
        let inside: Vec<Event> =
            kept.into_iter().filter(|e| e.at.latest >= from && e.at.earliest <= to).collect();
        let window: Vec<Event> = window.collect::<Result<_, _>>().unwrap();
        prop_assert_eq!(all_bits(&window), all_bits(&inside));

        // Of forgotten signals nothing has to come, of the others everything.
        let wanted = |event: &Event| forgotten >> event.signal.0 & 1 == 0;
        let mut window = trace.between(from, to).unwrap();
        (0..SIGNALS).filter(|id| forgotten >> id & 1 == 1).for_each(|id| window.forget(SignalId(id)));
        let window: Vec<Event> = window.collect::<Result<_, _>>().unwrap();
        let of = |events: &[Event]| all_bits(&events.iter().copied().filter(wanted).collect::<Vec<_>>());
        prop_assert_eq!(of(&window), of(&inside));
    }

    #[test]
    fn damaged_files_are_refused(
        events in any_events(60),
        damage in proptest::collection::vec((any::<prop::sample::Index>(), 1u8..=255), 1..4),
    ) {
        let mut trace = plain();
        for event in &events {
            trace.push(*event).unwrap();
        }
        let mut file = Vec::new();
        trace.save(&mut file).unwrap();
        for (place, change) in &damage {
            let place = place.index(file.len());
            file[place] ^= change;
        }
        // Two changes may cancel out; else the damage is noticed.
        if let Ok(loaded) = Trace::load(&mut file.as_slice(), LoadLimits::default()) {
            prop_assert_eq!(loaded.digest(), trace.digest());
        }
        let cut = damage[0].0.index(file.len());
        prop_assert!(Trace::load(&mut &file[..cut], LoadLimits::default()).is_err());
    }

    /// Chunks with right checksums and arbitrary content reach every decoder.
    #[test]
    fn no_file_panics_or_takes_more_memory_than_allowed(
        chunks in proptest::collection::vec(
            (prop::sample::select(b"SSSNEEEZ?".to_vec()), proptest::collection::vec(any::<u8>(), 0..80)),
            0..20,
        ),
        define_first in any::<bool>(),
        bytes in 0u64..4096,
    ) {
        let mut file = Vec::new();
        plain().save(&mut file).unwrap();
        // Without the definitions, or with them, but without the end.
        file.truncate(if define_first { file.len() - 49 } else { 10 });
        for (tag, payload) in chunks {
            let mut hasher = crc32fast::Hasher::new();
            hasher.update(&[tag]);
            hasher.update(&payload);
            file.push(tag);
            file.extend_from_slice(&(payload.len() as u32).to_le_bytes());
            file.extend_from_slice(&hasher.finalize().to_le_bytes());
            file.extend_from_slice(&payload);
        }
        if let Ok(trace) = Trace::load(&mut file.as_slice(), LoadLimits { bytes }) {
            let allowed = 2 * bytes as usize + 2 * SEGMENT_BYTES;
            prop_assert!(trace.bytes_in_memory() <= allowed);
        }
    }

    #[test]
    fn no_bytes_panic(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        prop_assert!(Trace::load(&mut bytes.as_slice(), LoadLimits::default()).is_err());
        let _ = CodecState::restore(&bytes, 3);
        let _ = info::read_info(&bytes);
        let mut state = CodecState::default();
        let mut at = 0;
        while let Ok((_, length)) = state.decode(&bytes[at..], 3) {
            at += length;
        }
    }
}

fn change(signal: SignalId, at: i64, value: Value) -> Event {
    Event { signal, at: When::exactly(Time::from_nanos(at)), value, cause: Cause::Unknown }
}

#[test]
fn a_change_of_a_boolean_takes_six_bytes() {
    let mut trace = plain();
    for n in 0..10_000 {
        let cause = Cause::Program { task: 0, file: 0, line: 7 };
        trace.push(Event { cause, ..change(SignalId(2), n * 10_000_000, Value::Bool(n % 2 == 0)) }).unwrap();
    }
    let mut file = Vec::new();
    trace.save(&mut file).unwrap();
    assert!(file.len() < 60_400, "{}", file.len());
}

#[test]
fn memory_is_bounded_with_a_store() {
    let bound = 64 * 1024;
    let store = Store::default();
    let mut trace = with_signals(Trace::with_spill(bound, Box::new(store.clone())));
    for n in 0..300_000u64 {
        trace.push(change(SignalId(1), n as i64 * 1_000_000, Value::Word(n))).unwrap();
        assert!(trace.bytes_in_memory() <= bound + bound / 2);
    }
    assert!(store.bytes.lock().unwrap().get_ref().len() > 20 * bound);
    assert_eq!(trace.events().count(), 300_000);
}

#[test]
fn a_failed_store_ends_the_trace() {
    let store = Store { room: Some(1000), ..Store::default() };
    let mut trace = with_signals(Trace::segmented(200, 500, Some(Box::new(store))));
    let mut errors = 0;
    for n in 0..2000 {
        match trace.push(change(SignalId(1), n, Value::Int(n * 1000))) {
            Ok(_) => assert_eq!(errors, 0, "an event after a hole"),
            Err(error) => {
                let kind = io::ErrorKind::StorageFull;
                assert_eq!(error, TraceError::Io { transfer: TraceTransfer::Spill, kind });
                errors += 1;
            }
        }
    }
    assert!(errors > 0);
    assert!(trace.events().all(|event| event.is_ok()), "what was recorded stays readable");
}

#[test]
fn a_damaged_store_is_noticed() {
    let store = Store::default();
    let mut trace = with_signals(Trace::segmented(200, 0, Some(Box::new(store.clone()))));
    for n in 0..500 {
        trace.push(change(SignalId(1), n, Value::Int(n * 1000))).unwrap();
    }
    store.bytes.lock().unwrap().get_mut()[300] ^= 1;
    let results: Vec<_> = trace.events().collect();
    assert!(matches!(results.last(), Some(Err(TraceError::SpillDamaged { segment: 1 }))));
    // `last` reads from the inside.
    assert_eq!(trace.events().last(), results.last().copied());
    assert!(trace.save(&mut Vec::new()).is_err());
}

#[test]
fn a_value_that_is_unknown_for_another_reason_is_an_event() {
    let mut trace = Trace::new();
    let signal = trace.define(SignalInfo::exact("pressure", ValueKind::Real)).unwrap();
    let mut push =
        |at, value, cause| trace.push(Event { cause, ..change(signal, at, value) }).unwrap().is_some();
    assert!(push(0, Value::Unknown, Cause::Gap(SignalGap::OpenWire)));
    assert!(!push(1, Value::Unknown, Cause::Gap(SignalGap::OpenWire)));
    assert!(push(2, Value::Unknown, Cause::Gap(SignalGap::Above)));
    assert!(!push(3, Value::Unknown, Cause::Board), "less is said");
}

#[test]
fn policies_keep_what_they_say() {
    let mut trace = Trace::new();
    let mut signal = |name: &str, kind, policy| {
        trace.define(SignalInfo { policy, ..SignalInfo::exact(name, kind) }).unwrap()
    };
    let band = signal("band", ValueKind::Real, Policy::Deadband(0.5));
    let large = signal("large", ValueKind::Int, Policy::Deadband(1.5));
    let mark = signal("mark", ValueKind::Mark, Policy::AtMostEvery(Span::from_nanos(10)));
    let bool = signal("bool", ValueKind::Bool, Policy::Changes);
    let mut push = |signal, at, value| trace.push(change(signal, at, value)).unwrap().is_some();
    assert!(push(band, 0, Value::Real(1.0)));
    assert!(!push(band, 1, Value::Real(1.5)), "not more than the band");
    assert!(push(band, 2, Value::Real(1.6)), "measured from the last kept one");
    assert!(!push(band, 2, Value::measured(1.8, 0.25)), "0.2 and 0.25 are within the band");
    assert!(push(band, 2, Value::measured(1.8, 0.35)), "it may be farther off than the band says");
    assert!(push(band, 3, Value::Unknown));
    assert!(push(band, 4, Value::Real(1.6)));
    assert!(push(band, 5, Value::Real(f64::NAN)));
    assert!(!push(band, 6, Value::Real(f64::NAN)));
    assert!(push(large, 7, Value::Int(1 << 60)));
    assert!(!push(large, 8, Value::Int((1 << 60) + 1)));
    assert!(push(large, 9, Value::Int((1 << 60) + 2)), "two more, though both are one float");
    assert!(push(large, 10, Value::Int(i64::MIN)));
    assert!(push(mark, 19, Value::Int(1)) && push(mark, 19, Value::Int(1)));
    assert!(push(bool, 20, Value::Bool(false)), "the first value is no change, but the start of knowing it");
    assert!(!push(bool, 21, Value::Bool(false)));
    assert!(push(bool, 22, Value::Unknown));
    assert!(push(bool, 23, Value::Bool(false)));
    let other = SignalId(9);
    assert_eq!(trace.push(change(other, 0, Value::Int(1))), Err(TraceError::UnknownSignal(other)));
}

/// Records as a recorder does: what waits first, then the event.
fn record(trace: &mut Trace, event: Event) -> Vec<Event> {
    let mut kept = Vec::new();
    while let Some(settled) = trace.settle(event.at.earliest).unwrap() {
        kept.push(settled);
    }
    kept.extend(trace.push(event).unwrap());
    kept
}

#[test]
fn a_change_that_comes_too_soon_leaves_the_value_unknown_until_the_time_is_over() {
    let mut trace = Trace::new();
    let policy = Policy::AtMostEvery(Span::from_nanos(10));
    let slow = trace.define(SignalInfo { policy, ..SignalInfo::exact("slow", ValueKind::Int) }).unwrap();
    let clock = trace.define(SignalInfo::exact("clock", ValueKind::Int)).unwrap();
    let mut record = |event| record(&mut trace, event);
    let int = |at, value| change(slow, at, Value::Int(value));
    let unknown = |at| change(slow, at, Value::Unknown);
    assert_eq!(record(int(0, 1)), [int(0, 1)]);
    assert_eq!(record(int(4, 1)), [], "no change");
    assert_eq!(record(int(5, 2)), [unknown(5)]);
    assert_eq!(record(int(6, 3)), []);
    assert_eq!(record(int(7, 4)), []);
    // At the very end of the time it may change again: that value counts.
    let tick = |at, value| change(clock, at, Value::Int(value));
    assert_eq!(record(tick(10, 1)), [tick(10, 1)]);
    assert_eq!(record(tick(11, 2)), [int(10, 4), tick(11, 2)]);
    assert_eq!(record(int(20, 5)), [int(20, 5)], "the time is over");
    assert_eq!(record(int(22, 6)), [unknown(22)]);
    assert_eq!(record(int(30, 7)), [int(30, 7)], "a change at the end of the time is recorded itself");
    // Back to what it was: something happened all the same.
    assert_eq!(record(int(32, 8)), [unknown(32)]);
    assert_eq!(record(int(33, 7)), []);
    assert_eq!(record(tick(50, 3)), [int(40, 7), tick(50, 3)]);
    assert_eq!(record(tick(60, 4)), [tick(60, 4)], "nothing waits any more");
}

proptest! {
    /// At every instant the trace has what the signal is, or that it is not known, and never more than it may.
    #[test]
    fn a_limited_signal_is_never_recorded_as_what_it_is_not(
        steps in proptest::collection::vec((0u32..2, 0i64..8, -2i64..3), 1..60),
        every in 1i64..20,
    ) {
        let mut trace = Trace::new();
        let policy = Policy::AtMostEvery(Span::from_nanos(every));
        for name in ["a", "b"] {
            trace.define(SignalInfo { policy, ..SignalInfo::exact(name, ValueKind::Int) }).unwrap();
        }
        let mut now = 0;
        let mut changes = Vec::new();
        for (signal, step, value) in steps {
            now += step;
            changes.push(change(SignalId(signal), now, Value::Int(value)));
            record(&mut trace, changes[changes.len() - 1]);
        }
        while trace.settle(Time::from_nanos(now + every + 1)).unwrap().is_some() {}
        let recorded = read(&trace);
        prop_assert!(recorded.windows(2).all(|pair| pair[0].at.earliest <= pair[1].at.earliest));
        let at = |events: &[Event], signal, instant| {
            let found = events.iter().rfind(|e| e.signal == signal && e.at.latest.as_nanos() <= instant);
            found.map(|event| event.value)
        };
        for signal in [SignalId(0), SignalId(1)] {
            for instant in 0..=now + every {
                let (is, says) = (at(&changes, signal, instant), at(&recorded, signal, instant));
                prop_assert!(says == is || says == Some(Value::Unknown), "{is:?} {says:?} at {instant}");
            }
            prop_assert_eq!(at(&recorded, signal, now + every), at(&changes, signal, now));
            let values = recorded.iter().filter(|e| e.signal == signal && e.value != Value::Unknown);
            let times: Vec<i64> = values.map(|event| event.at.earliest.as_nanos()).collect();
            prop_assert!(times.windows(2).all(|pair| pair[1] - pair[0] >= every), "{times:?}");
        }
    }
}

#[test]
fn signals_have_one_name_each() {
    let mut trace = plain();
    assert_eq!(
        trace.define(SignalInfo::exact("s2", ValueKind::Bool)),
        Err(TraceError::DuplicateName(SignalId(2)))
    );
    assert_eq!(trace.find("s3"), Some(SignalId(3)));
    assert_eq!(trace.find("s9"), None);
}

#[test]
fn a_file_repeats_definitions_and_notes() {
    let mut trace = Trace::new();
    let info = SignalInfo {
        name: "tank.level".into(),
        kind: ValueKind::State,
        unit: "°C".into(),
        labels: vec![(-1, "below".into()), (i64::MAX, String::new())],
        clock: ClockDomain::Device,
        sampling: Sampling::Sampled { period: Span::from_millis(10) },
        shortest_pulse: Span::from_millis(20),
        policy: Policy::Deadband(0.25),
    };
    trace.define(info.clone()).unwrap();
    trace.set_note("plan", "a.toml".into());
    trace.set_note("case", "x".into());
    trace.set_note("plan", "watchdog/fallback.toml".into());
    let mut file = Vec::new();
    trace.save(&mut file).unwrap();
    let loaded = Trace::load(&mut file.as_slice(), LoadLimits::default()).unwrap();
    assert_eq!(loaded.signals(), [info]);
    assert_eq!(loaded.notes().collect::<Vec<_>>(), [("case", "x"), ("plan", "watchdog/fallback.toml")]);
    assert_eq!(loaded.note("case"), Some("x"));

    // Notes say where a trace comes from, not what happened.
    let digest = trace.digest();
    trace.set_note("seed", "7".into());
    assert_eq!(trace.digest(), digest);
    trace.define(SignalInfo::exact("more", ValueKind::Bool)).unwrap();
    assert_ne!(trace.digest(), digest);
}

#[test]
fn file_errors_say_what_and_where() {
    let mut trace = plain();
    trace.push(change(SignalId(1), 5, Value::Bool(true))).unwrap();
    let mut file = Vec::new();
    trace.save(&mut file).unwrap();
    let load = |bytes: &[u8]| Trace::load(&mut &*bytes, LoadLimits::default()).unwrap_err();
    assert_eq!(load(b"PNG"), TraceError::NotATrace);
    assert_eq!(load(&file[..file.len() - 1]), TraceError::Truncated { offset: file.len() as u64 - 1 });
    let mut newer = file.clone();
    newer[8] = 2;
    assert_eq!(load(&newer), TraceError::Version(2));
    let mut damaged = file.clone();
    damaged[20] ^= 1;
    assert_eq!(load(&damaged), TraceError::Checksum { offset: 10 });
    let tight = LoadLimits { bytes: 100 };
    assert_eq!(Trace::load(&mut file.as_slice(), tight).unwrap_err(), TraceError::TooLarge { limit: 100 });
}

#[test]
fn a_signal_can_be_defined_while_the_trace_is_read() {
    let mut trace = plain();
    let mut cursor = Cursor::new();
    trace.push(change(SignalId(1), 0, Value::Int(1))).unwrap();
    assert_eq!(trace.since(&mut cursor).count(), 1);
    let late = trace.define(SignalInfo::exact("late", ValueKind::Bool)).unwrap();
    trace.push(change(late, 1, Value::Bool(true))).unwrap();
    let events: Vec<_> = trace.since(&mut cursor).collect();
    assert_eq!(events, [Ok(change(late, 1, Value::Bool(true)))]);
}

#[test]
fn a_cursor_of_another_trace_is_no_panic() {
    let mut long = with_signals(Trace::segmented(50, usize::MAX, None));
    for n in 0..200 {
        long.push(change(SignalId(1), n, Value::Int(n * n))).unwrap();
    }
    let mut cursor = Cursor::new();
    assert_eq!(long.since(&mut cursor).count(), 200);
    assert!(plain().since(&mut cursor).any(|event| event == Err(TraceError::ForeignCursor)));
}
