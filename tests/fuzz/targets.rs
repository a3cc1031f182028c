//! What is fuzzed: each function takes any bytes and must neither panic nor hang nor take memory without bound.
//! `tests/end_to_end/corpus.rs` runs the committed corpora through the same functions with the stable compiler.

mod lines_of_clients;

use capture::{Capture, CaptureFormat, LevelRule};
use document::{Diagnostic, SourceFile, render};
use drivers::adc::iio::{Element, Sampled, Scans};
use drivers::adc::spi::{Chosen, FRAME, PARTS, SpiInput, Sweep};
use drivers::can::{Datagram, Filter, Reported};
use drivers::counter::{CounterReading, CounterSpec, FindCount, FindCounter, Follower};
use drivers::counting::CountFunction as Counting;
use drivers::serial::{Marks, MessageAssembler, MessageTiming, Received, Symbol};
use expert::{
    BLOCKS, BlockCall, BlockPins, CounterConfig, CounterKind, CounterMode, ExpertConfig, ExpertFunctions,
    ExpertOperation, FunctionConfig, FunctionKind, FunctionProbe, InputConditions, LimitsMode, LineEvents,
    PhaseMode, RECORD,
};
use host::{COUNTER_RECORD, CounterEvent, CounterEventKind, HostInstant};
use plans::frames::DataPattern;
use plans::frames::can::DbcDatabase;
use plans::lang::{Need, SignalAt};
use plans::{Anchor, Literal};
use profile::Profile;
use record::RunRecord;
use reports::text::Style;
use runtime::instrument::standalone::{self, StandaloneRun};
use runtime::suite::{self, FileSource, instrument_file};
use signal::{
    Address, Cause, Event, LoadLimits, Policy, Quantity, QuantityRange, SignalId, SignalInfo, Span, Time,
    Trace, Value, ValueKind, When,
};

/// Lines of clients, and what comes back.
pub fn control(data: &[u8]) {
    lines_of_clients::control(data);
}

const PROGRAM: &str = "PROGRAM MAIN VAR button AT %IX0.0 : BOOL; lamp AT %QX0.4 : BOOL; n : INT; d : TON; END_VAR \
                       d(IN := button, PT := T#500ms); lamp := d.Q; n := n + 1; END_PROGRAM";

/// The program of a plant.
const PLANT: &str = "PROGRAM PLANT VAR_INPUT on : BOOL; divisor : INT := 1; flow : LREAL; END_VAR \
                     VAR_OUTPUT n : DINT; level : REAL; done : BOOL; END_VAR VAR d : TON; END_VAR \
                     n := n + 100 / divisor; level := level + LREAL_TO_REAL(flow); d(IN := on, PT := T#1ms); done := d.Q; END_PROGRAM";

const BOARD: &str = "format = 1\n[board]\nkind = \"simulated\"\n";

const PLAN: &str = r#"format = 1
program = "lamp.st"
signals = { button = "%IX0.0", lamp = "%QX0.4" }
steps = [{ id = "press", at = "start + 1 s", set = { signal = "button", value = true } }]
expect = [
  { rises = { signal = "lamp", from = "press", within = "500 ms .. 550 ms" } },
  { stays = { signal = "lamp", is = false, from = "start", until = "press + 500 ms" } },
  { edges = { signal = "lamp", rising = 1, from = "press", until = "end" } },
  { state = { stays = "RUNNING", from = "start", until = "end" } },
]
measure = [{ name = "delay", from = "press", to = { signal = "lamp", edge = "rises" }, max = "1 s" }]
"#;

/// Cases of a plan that are looked at; a plan may have a hundred thousand.
const CASES: usize = 3;

/// One text under a name, and sound files under all others.
struct One<'a> {
    name: &'a str,
    text: &'a str,
}

impl FileSource for One<'_> {
    fn read(&self, path: &str) -> Result<String, String> {
        match path {
            path if path == self.name => Ok(self.text.to_owned()),
            "plant.st" => Ok(PLANT.to_owned()),
            path if path.ends_with(".st") => Ok(PROGRAM.to_owned()),
            path if path.ends_with(".toml") => Ok(BOARD.to_owned()),
            _ => Err("there is no such file".to_owned()),
        }
    }
}

/// Every finding has a code, and can be shown.
fn show(found: &[Diagnostic], sources: &[SourceFile]) {
    for one in found {
        assert!(one.code.len() == 5 && !one.message.is_empty(), "{one:?}");
    }
    let _ = render(found, sources, false);
}

/// A plan, with everything that `rig check` looks up.
pub fn plan(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    let files = One { name: "plan.toml", text: &text };
    let mut sources = Vec::new();
    match suite::load_plan(&files, "plan.toml", None, &[], 1, &mut sources) {
        Err(found) => {
            assert!(found.iter().any(Diagnostic::is_error));
            show(&found, &sources);
        }
        Ok(loaded) => {
            show(&loaded.plan.warnings, &sources);
            for job in loaded.jobs(0, 1, 1).into_iter().take(CASES) {
                let Some(case) = loaded.plan.case(job.case) else { continue };
                let checked =
                    loaded.files(&case, &job).and_then(|files| runtime::case::check_case(&case, &files));
                if let Err(found) = checked {
                    show(&found, &sources);
                }
            }
        }
    }
}

/// A board file, and the board that it describes.
pub fn board(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    let mut sources = Vec::new();
    match suite::load_board(&One { name: "board.toml", text: &text }, "board.toml", &mut sources) {
        Err(found) => {
            assert!(found.iter().any(Diagnostic::is_error));
            show(&found, &sources);
        }
        Ok((file, _)) => {
            let mut board = drivers::build(&file, 1).expect("a board file without findings can be built");
            // A board may make trouble by itself, which then is an error and no panic.
            let _ = board.start(Time::ZERO);
            let _ = board.poll(Time::ZERO, &mut Vec::new());
            let later = Time::from_nanos(10_000_000);
            let _ = board.poll(later, &mut Vec::new());
            let _ = board.safe(later);
        }
    }
}

/// An instrument file, and what it makes of the instants of a capture.
pub fn instrument(data: &[u8]) {
    let file = SourceFile::new("scope.toml", String::from_utf8_lossy(data));
    match instrument_file::read(&file) {
        Err(found) => {
            assert!(found.iter().any(Diagnostic::is_error));
            show(&found, &[file]);
        }
        Ok(read) => {
            let table = b"time [ms],a [V],b\n0,0,0\n1,20,0\n2,1.5,1\n3,-7,0\n";
            let mut capture = capture::read(CaptureFormat::Csv, table, None).expect("the table is sound");
            let at = |name: &str| capture.channels.iter().position(|channel| channel.name == name);
            let rules: Vec<(usize, LevelRule)> = read
                .channels
                .iter()
                .filter_map(|of| {
                    let rule =
                        LevelRule { threshold: of.threshold?, hysteresis: of.hysteresis, error: of.error };
                    Some((at(&of.name)?, rule))
                })
                .collect();
            capture.add_levels(&rules);
            capture.correct(&read.errors());
            let reference = read.timebase.named(Time::ZERO);
            capture.widen_by_rate(reference, read.timebase.rate);
            assert!(capture.changes.is_sorted_by_key(|change| change.at.latest));
            assert!(capture.changes.iter().all(|change| change.at.earliest <= change.at.latest));
            assert_eq!(read.record().file, "scope.toml");
        }
    }
}

/// Descriptions of the samples of a device, a line each, and after a byte 0 what came out of its buffer.
pub fn iio(data: &[u8]) {
    let text = data.iter().position(|byte| *byte == 0).unwrap_or(data.len());
    let (text, bytes) = data.split_at(text);
    let text = String::from_utf8_lossy(text);
    let mut elements: Vec<Element> = text.lines().take(64).filter_map(Element::parse).collect();
    let Some(stamp) = elements.pop() else { return };
    let input = |(at, element): (usize, &Element)| Sampled::new(at as u16, *element, -0.5, 0.25);
    let inputs = elements.iter().enumerate().map(input).collect();
    let mut scans = Scans::new(inputs, stamp, Span::from_micros(100), bytes.len() % 2 == 0);
    let mut readings = Vec::new();
    for (at, part) in bytes.chunks(scans.size() * 3 + 1).enumerate() {
        scans.take(part, HostInstant::from_nanos(at as i64), &mut readings);
    }
    assert!(readings.iter().all(|reading| reading.before <= reading.after && reading.value.is_finite()));
    assert!(readings.len() <= bytes.len() * elements.len());
}

/// A program, compiled and run for a millisecond.
pub fn program(data: &[u8]) {
    let sources = [SourceFile::new("a.st", String::from_utf8_lossy(data))];
    match runtime::application::compile(&sources, Profile::default()) {
        Err(found) => {
            assert!(found.iter().any(Diagnostic::is_error));
            show(&found, &sources);
        }
        Ok(program) => {
            show(&program.warnings, &sources);
            let program = std::sync::Arc::new(program);
            let tasks = standalone::tasks(&program, Span::from_micros(100));
            let Ok(mut alone) = StandaloneRun::new(program.clone(), tasks, Profile::default()) else {
                return;
            };
            let _ = alone.run(Span::from_millis(1));
            for root in program.roots().iter().take(100) {
                let _ = alone.show(&root.path).map(|shown| shown.to_string());
                let _ = alone.set(&root.path, "1");
            }
        }
    }
}

/// A trace: the bytes as a file, as a file whose checksums are corrected, and as the recipe of a trace.
pub fn trace(data: &[u8]) {
    let limits = LoadLimits { bytes: 16 << 20 };
    for bytes in [data, &with_right_checksums(data)] {
        if let Ok(trace) = Trace::load(&mut &bytes[..], limits) {
            whole(&trace);
        }
    }
    whole(&built(data));
}

/// A trace can be saved and comes back the same; it can be shown and judged.
fn whole(trace: &Trace) {
    let mut file = Vec::new();
    trace.save(&mut file).expect("memory takes everything");
    let again = Trace::load(&mut &file[..], LoadLimits::default()).expect("a saved trace loads");
    assert_eq!(again.digest(), trace.digest());
    let events: Vec<Event> = trace.events().map(|event| event.expect("memory reads")).collect();
    assert_eq!(events.len() as u64, trace.len());
    let _ = reports::vcd::write_trace(trace, "0.0.0", std::io::sink());
    if let Ok(record) = runtime::case::rejudge::judge(&SourceFile::new("plan.toml", PLAN), trace) {
        let _ = reports::text::details(&record, Style::default());
    }
}

/// The same file with right checksums, so that what stands after them is reached.
fn with_right_checksums(data: &[u8]) -> Vec<u8> {
    let mut file = data.to_vec();
    let mut at = 10;
    while let Some(head) = file.get(at..at + 9) {
        let length = u32::from_le_bytes([head[1], head[2], head[3], head[4]]) as usize;
        let Some(payload) = file.get(at + 9..).and_then(|rest| rest.get(..length)) else { break };
        let sum = crc32(&[&head[..1], payload].concat());
        file[at + 5..at + 9].copy_from_slice(&sum.to_le_bytes());
        at += 9 + length;
    }
    file
}

fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32, byte: &u8| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| (crc >> 1) ^ (0xEDB8_8320 & 0u32.wrapping_sub(crc & 1)))
    };
    !bytes.iter().fold(!0, step)
}

/// A trace with the signals of [`PLAN`], and events as the bytes say.
fn built(data: &[u8]) -> Trace {
    let mut trace = Trace::new();
    let signals = [
        ("state", ValueKind::State),
        ("button", ValueKind::Bool),
        ("lamp", ValueKind::Bool),
        ("step:start", ValueKind::Mark),
        ("step:end", ValueKind::Mark),
        ("step:press", ValueKind::Mark),
        ("step:press.done", ValueKind::Mark),
        ("temperature", ValueKind::Real),
        ("count", ValueKind::Int),
        ("bits", ValueKind::Word),
    ];
    for (place, (name, kind)) in signals.into_iter().enumerate() {
        let mut info = SignalInfo::exact(name, kind);
        info.policy = match data.get(place).map_or(0, |byte| byte % 8) {
            1 => Policy::AtMostEvery(Span::from_millis(1)),
            2 => Policy::Deadband(0.5),
            _ => Policy::Changes,
        };
        trace.define(info).expect("the names differ");
    }
    trace.set_note("plan", "plan.toml".to_owned());
    trace.set_note("plan-case", "plan".to_owned());
    let mut now = 0i64;
    for bytes in data.chunks_exact(5) {
        let place = usize::from(bytes[0]) % signals.len();
        let unit = [1, 1_000, 1_000_000, 500_000_000][usize::from(bytes[1] >> 6)];
        now = now.saturating_add(i64::from(bytes[1] & 63) * unit);
        let width = i64::from(bytes[2]) * [0, 1, 1_000_000, i64::MAX >> 9][usize::from(bytes[2] >> 6)];
        let at = When::within(Time::from_nanos(now), Time::from_nanos(now.saturating_add(width)));
        let number = i64::from(bytes[3] as i8);
        let value = match (bytes[4] % 16, signals[place].1) {
            (0, _) => Value::Unknown,
            (1, _) => Value::HighZ,
            (2, _) => Value::Real(f64::NAN),
            (3, _) => Value::Word(u64::MAX),
            (4, _) => Value::Int(i64::MIN),
            (_, ValueKind::Bool) => Value::Bool(number & 1 == 1),
            (_, ValueKind::Real) => Value::Real(number as f64 / 3.0),
            (_, ValueKind::Word) => Value::Word(number as u64),
            _ => Value::Int(number),
        };
        let cause = match bytes[4] >> 5 {
            0 => Cause::Board,
            1 => Cause::Step(u16::from(bytes[3])),
            2 => Cause::Program { task: bytes[3], file: u16::from(bytes[2]), line: u32::from(bytes[1]) },
            _ => Cause::Controller,
        };
        let _ = trace.push(Event { at, signal: SignalId(place as u32), value, cause });
    }
    trace
}

/// A capture of another instrument in each format, with and without a time between samples.
pub fn capture(data: &[u8]) {
    for format in [CaptureFormat::Vcd, CaptureFormat::Csv, CaptureFormat::Sigrok] {
        for period in [None, Some(Span::from_micros(1))] {
            match capture::read(format, data, period) {
                Err(error) => assert!(!error.what.is_empty(), "{error:?}"),
                Ok(read) => sound(&read),
            }
        }
    }
}

/// What a reader promises of a capture.
fn sound(read: &Capture) {
    assert!(read.changes.is_sorted_by_key(|change| change.at.latest));
    for change in &read.changes {
        assert!((change.channel as usize) < read.channels.len() && change.at.earliest <= change.at.latest);
    }
    let names: std::collections::BTreeSet<&str> =
        read.channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(names.len(), read.channels.len());
}

/// A record, with the reports that are made from it.
pub fn record(data: &[u8]) {
    let Ok(run) = RunRecord::from_json(&String::from_utf8_lossy(data)) else { return };
    let text = run.to_json();
    let again = RunRecord::from_json(&text).expect("a record that was read can be written and read");
    assert_eq!(again.to_json(), text);
    let _ = reports::text::render(&run, Style::default());
    let _ = reports::junit::render(&run, "out");
    let _ = reports::ctrf::render(&run);
    let _ = reports::markdown::render(&run);
    let _ = (reports::csv::measurements(&run), reports::csv::claims(&run));
    let _ = reports::html::render(&run);
}

/// A DBC file, and after a byte of 0 the data of frames that carry its values; the data of frames as plans write them.
pub fn frames(data: &[u8]) {
    let end = data.iter().position(|byte| *byte == 0).unwrap_or(data.len());
    let (text, bytes) = (String::from_utf8_lossy(&data[..end]), &data[(end + 1).min(data.len())..]);
    if let Ok(pattern) = DataPattern::parse(&text) {
        assert_eq!(DataPattern::parse(&pattern.to_string()).as_ref(), Ok(&pattern));
        if let Some(exact) = pattern.exact() {
            assert!(pattern.matches(&exact));
        }
    }
    let Ok(base) = DbcDatabase::parse(&text) else { return };
    for field in base.messages.values().flat_map(|message| &message.fields) {
        assert!(field.coding.bytes() <= plans::frames::MAX_DATA);
        let selected = field.selector.as_ref().is_none_or(|selector| selector.selects(bytes));
        if let (true, Value::Real(value)) = (selected, field.coding.value(bytes)) {
            assert!(value.is_finite());
            let _ = field.coding.code(value);
        }
    }
}

/// The small languages inside texts. What reads is written in one spelling, which reads as the same.
pub fn words(data: &[u8]) {
    let text = &*String::from_utf8_lossy(data);
    macro_rules! comes_again {
        ($($kind:ty),*) => {
            $(if let Ok(read) = <$kind>::parse(text) {
                let shown = read.to_string();
                assert_eq!(<$kind>::parse(&shown).as_ref(), Ok(&read), "{shown} of {text}");
            })*
        };
    }
    comes_again!(Address, Span, Quantity, Anchor, Need);
    let _ = QuantityRange::parse(text);
    let _ = Span::parse_range(text);
    let _ = Literal::parse(text);
    let _ = SignalAt::parse(text);
    for profile in Profile::ALL {
        assert_eq!(profile.name().parse::<Profile>().ok(), Some(profile));
    }
    let _ = text.parse::<Profile>();
}

/// Bytes off a serial line, in pieces of any size at any time: none is lost, moved or made of nothing. The first byte of
/// a piece says how long it is, how much later it comes and how late it is read.
pub fn serial(data: &[u8]) {
    let nanos = Span::from_nanos;
    let mut marks = Marks::default();
    let mut assembler =
        MessageAssembler::new(MessageTiming { gap: nanos(4), character: nanos(1), hold: nanos(2) });
    let (mut now, mut sent, mut got, mut left) = (HostInstant::BOOT, Vec::new(), Vec::new(), data);
    while let Some((head, rest)) = left.split_first() {
        let (piece, after) = rest.split_at(rest.len().min(usize::from(head & 15)));
        let empty = now + nanos(i64::from(head >> 6) * 4);
        now = empty + nanos(i64::from(head >> 4 & 3) * 3);
        let mut received = Received { symbols: Vec::new(), empty, read: now };
        piece.iter().for_each(|byte| marks.take(*byte, |symbol| received.symbols.push(symbol)));
        sent.extend(received.symbols.iter().filter_map(|symbol| match *symbol {
            Symbol::Byte(byte) | Symbol::Damaged(byte) => Some(byte),
            Symbol::Break => None,
        }));
        assembler.take(&received, |received| got.push(received.message));
        left = after;
    }
    got.extend(assembler.quiet(HostInstant::NEVER).map(|received| received.message));
    assert!(got.windows(2).all(|pair| pair[0].ends != pair[1].continues));
    assert!(got.iter().all(|message| !message.is_empty()));
    assert!(assembler.due().is_none());
    let back: Vec<u8> = got.iter().flat_map(|message| message.data().to_vec()).collect();
    assert_eq!(back, sent);
}

/// What a CAN socket and the kernel's news of interfaces may bring.
pub fn can(data: &[u8]) {
    for len in [data.len(), 16, 72] {
        let Some(bytes) = data.get(..len) else { continue };
        match drivers::can::decode(bytes) {
            Some(Datagram::Frame(frame)) => {
                if let Some((again, len)) = drivers::can::encode(&frame) {
                    assert_eq!(drivers::can::decode(&again[..len]), Some(Datagram::Frame(frame)));
                }
            }
            Some(Datagram::Report(classes, details)) => {
                let _ = Reported::read(classes, &details).errors().count();
            }
            None => {}
        }
    }
    assert!(drivers::can::read_news(data).len() <= data.len() / 16 + 1);
    let _ = Filter::parse(&String::from_utf8_lossy(data));
}

/// Answers of a converter on an SPI bus: whatever they are, a reading lies within the range of its input, and was taken
/// when the bus was asked. The first byte is the part, the second its inputs, a bit each.
pub fn spi(data: &[u8]) {
    let [part, inputs, answers @ ..] = data else { return };
    let part = PARTS[usize::from(*part) % PARTS.len()];
    let reference = part.reference().unwrap_or(3.3);
    let numbers = (0..part.inputs()).filter(|number| inputs >> number & 1 == 1);
    let chosen: Vec<Chosen> = numbers
        .map(|number| {
            let input = SpiInput::Single(number);
            let spans = part.spans(input, reference);
            Chosen { input, span: spans[usize::from(*inputs) % spans.len()] }
        })
        .collect();
    let mut sweep = Sweep::new(part, chosen.clone());
    let frames = sweep.frames().len();
    for (at, piece) in answers.chunks(FRAME).enumerate().filter(|_| frames > 0) {
        let mut answer = [0; FRAME];
        answer[..piece.len()].copy_from_slice(piece);
        let _ = sweep.take(
            at % frames,
            &answer,
            HostInstant::from_nanos(at as i64),
            HostInstant::from_nanos(at as i64 + 1),
        );
    }
    let mut readings = Vec::new();
    sweep.readings(&mut readings);
    assert!(readings.len() <= chosen.len());
    for reading in readings {
        let span = chosen[usize::from(reading.input)].span;
        assert!(span.low <= reading.value && reading.value < span.high, "{reading:?}");
        assert!(reading.before < reading.after, "{reading:?}");
        assert!(sweep.noise(usize::from(reading.input)).is_none_or(|noise| noise.deviation >= 0.0));
    }
}

/// What a counter says: the number in its file, and records of its events. The first byte says what of it is listened to, the
/// second what it counts; each event goes with a reading.
pub fn counter(data: &[u8]) {
    let _ = drivers::counter::shown(data);
    let [listens, counts, records @ ..] = data else { return };
    let listened = |(bit, kind): (usize, &CounterEventKind)| (listens >> bit & 1 == 1).then_some(*kind);
    let spec = CounterSpec {
        name: String::new(),
        place: 0..0,
        find: FindCounter::Name(String::new()),
        count: FindCount::Number(0),
        function: Some(Counting::ALL[usize::from(*counts) % Counting::ALL.len()].0),
        edge: None,
        ceiling: None,
        period: Span::from_millis(1),
        events: CounterEventKind::ALL.iter().enumerate().filter_map(listened).collect(),
        buffer: 16,
        counts_hz: Some(1_000_000),
    };
    let ceiling = if listens & 0x80 == 0 { u64::from(*counts) } else { u64::MAX };
    let mut follower = Follower::new(&spec, ceiling, Span::from_millis(100), Span::from_micros(50));
    let mut reported = 0;
    for record in records.as_chunks::<COUNTER_RECORD>().0 {
        let event = CounterEvent::read(record);
        let stamp =
            HostInstant::from_nanos(i64::from_ne_bytes(record.first_chunk().copied().unwrap_or_default()));
        let value = u64::from(record[8]);
        let reading = CounterReading { before: stamp - Span::from_nanos(100), after: stamp, value };
        follower.take(reading, event.as_slice(), &mut |step| {
            assert!(step.from <= step.to, "{step:?}");
            reported += 1;
        });
    }
    assert!(reported <= 2 * records.len() / COUNTER_RECORD + 1);
}

/// The pins of a block that is called once: its reference is 1, and all that enables and presets is on.
struct AllOn;

impl BlockPins for AllOn {
    fn get(&self, pin: usize) -> i64 {
        i64::from(pin < 9)
    }

    fn set(&mut self, _pin: usize, _value: i64) {}
}

/// Records of GPIO lines into a counter with two phases. The first byte says how the phases count, and whether there is a
/// filter.
pub fn lines(data: &[u8]) {
    let [how, records @ ..] = data else { return };
    let phases = [PhaseMode::UpDown, PhaseMode::PulseDirection, PhaseMode::X1, PhaseMode::ReverseX4]
        [usize::from(how % 4)];
    let mode = CounterMode::FreeLarge { preset: 7, limits: LimitsMode::Rollover };
    let config = CounterConfig::new(CounterKind::Dual { b: 1, phases }, 0, mode);
    let functions = vec![FunctionConfig { name: "HSC0".to_owned(), kind: FunctionKind::Counter(config) }];
    let own = Span::from_nanos(if how & 4 == 0 { 0 } else { 2_000 });
    let conditions = InputConditions { delay: own, bounce: own };
    let mut expert = ExpertFunctions::new(&ExpertConfig { functions }, &[conditions; 2]);
    expert.operate(Time::MIN, ExpertOperation::Running);
    let block = BLOCKS.iter().copied().flatten().find(|block| block.name == "HSCMain_M241").unwrap();
    (block.run)(&mut BlockCall { now: Time::MIN, pins: &mut AllOn, expert: &mut expert });
    let mut lines = LineEvents::new(&[(0, 0), (1, 1)], 0);
    let mut left = records;
    while left.len() >= RECORD {
        let taken = lines.read(left, &mut expert);
        assert!(taken > 0 && taken.is_multiple_of(RECORD));
        left = &left[taken..];
        let mut place = 0;
        while expert.take(place).is_some() {
            place += 1;
        }
    }
    let whole = records.len() / RECORD;
    assert!(lines.malformed() <= whole as u64);
    let counted = expert.read(0, FunctionProbe::Value).as_int().unwrap_or(i128::MAX) - 7;
    assert!(counted.unsigned_abs() <= whole as u128, "{counted}");
}
