//! Converters of industrial I/O through the kernel.

mod plan;

use devices::{ADC, Adc, Lab, PATIENCE, wait_for};
use document::SourceFile;
use drivers::adc::{self, AdcPace, AdcReading, AdcSpec, AdcsSpec, InRange, SampleSpec};
use drivers::{
    Board, BoardContext, BoardEvent, BoardFile, BoardKind, ChannelId, LossReason, Refusal, Terminals,
};
use host::{HostInstant, Realtime};
use rustix::event::{PollFd, PollFlags, poll};
use signal::{Span, Time};
use std::fs;
use std::time::{Duration, Instant};

/// A step of the converter.
const STEP: f64 = 20.48 / 65_536.0;

/// Samples that are asked for, those that come by a timer of the rig's own, and by a trigger of the machine.
const ASKED: &str = "";
const TIMER: &str = ", buffered = true, buffer = 64";
const TRIGGER: &str = ", trigger = \"rig-trigger\", buffer = 64";

/// A board file of the lab's converter, with a period that an emulated machine keeps as a rule; channels are lines of
/// TOML.
fn text(keys: &str, channels: &str) -> String {
    format!(
        "format = 1\n[board]\nkind = \"real\"\nreconnect = true\nunresponsive-after = \"200 ms\"\n[converters]\n\
         adc = {{ kind = \"iio\", name = \"{ADC}\", period = \"20 ms\"{keys} }}\n[channels]\n{channels}"
    )
}

fn read(text: &str) -> BoardFile {
    let none = |_: &drivers::Subject| Ok(Terminals::default());
    drivers::read(&SourceFile::new("bench.toml", text), &none).unwrap_or_else(|found| panic!("{found:#?}"))
}

/// The converter with these inputs.
fn spec(keys: &str, inputs: &[u16]) -> (AdcSpec, Vec<SampleSpec>) {
    let channel = |input| format!("v{input} = {{ kind = \"analog\", unit = \"V\", input = {input} }}\n");
    let file = read(&text(keys, &inputs.iter().map(channel).collect::<String>()));
    let BoardKind::Real(spec) = file.kind else { panic!("a real board") };
    let adcs = spec.of::<AdcsSpec>().unwrap();
    (adcs.converters[0].clone(), adcs.samples.clone())
}

fn opened(keys: &str, inputs: &[u16]) -> Box<dyn adc::Adc> {
    let (converter, samples) = spec(keys, inputs);
    adc::open(&converter, &samples).unwrap()
}

fn refused(keys: &str, inputs: &[u16]) -> Refusal {
    let (converter, samples) = spec(keys, inputs);
    adc::open(&converter, &samples).unwrap_err()
}

/// What comes of the converter until there are so many readings.
fn readings(converter: &mut dyn adc::Adc, least: usize) -> Vec<AdcReading> {
    let mut out = Vec::new();
    let due = Instant::now() + PATIENCE;
    while out.len() < least {
        assert!(Instant::now() < due, "only {} readings came", out.len());
        if let AdcPace::Ready(fd, _) = converter.pace() {
            let tick = rustix::event::Timespec { tv_sec: 0, tv_nsec: 100_000_000 };
            let _ = poll(&mut [PollFd::from_borrowed_fd(fd, PollFlags::IN)], Some(&tick));
        }
        converter.read(&mut out).unwrap();
    }
    out
}

fn near(value: f64, volts: f64) -> bool {
    (value - volts).abs() <= STEP
}

/// Whether the kernel samples into the buffer now.
fn running() -> bool {
    fs::read_to_string("/sys/bus/iio/devices/iio:device0/buffer/enable").unwrap().trim() == "1"
}

fn timers() -> Vec<String> {
    let entries = fs::read_dir("/sys/kernel/config/iio/triggers/hrtimer").unwrap().flatten();
    let mut names: Vec<String> =
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn single_reads_are_volts_between_two_instants() {
    let (_lab, adc) = (Lab::enter(), Adc::enter());
    let mut converter = opened(ASKED, &[2, 0]);
    assert_eq!(converter.device(), "iio:device0 (rig-adc)");
    assert!(matches!(converter.pace(), AdcPace::Asked(period) if period == Span::from_millis(20)));
    for (volts, range) in
        [(2.5, InRange::Yes), (-10.0, InRange::Yes), (10.3, InRange::Above), (-10.3, InRange::Below)]
    {
        adc.set(2, volts);
        adc.set(0, -volts / 2.0);
        let begin = HostInstant::now();
        let reported = readings(&mut *converter, 2);
        let end = HostInstant::now();
        assert_eq!(reported.iter().map(|one| one.input).collect::<Vec<_>>(), [0, 1]);
        assert_eq!(reported[0].range, range, "{volts} V");
        assert!(range != InRange::Yes || near(reported[0].value, volts), "{volts} V: {reported:?}");
        assert!(near(reported[1].value, -volts / 2.0), "{volts} V: {reported:?}");
        let mut last = begin;
        for stamp in reported.iter().flat_map(|one| [one.before, one.after]).chain([end]) {
            assert!(last <= stamp, "{reported:?}");
            last = stamp;
        }
    }
    adc.fails();
    assert_eq!(converter.read(&mut Vec::new()).unwrap_err().raw_os_error(), Some(5));
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_timer_of_the_rigs_own_samples_with_instants_and_goes_with_it() {
    let (_lab, adc) = (Lab::enter(), Adc::enter());
    let before = timers();
    let mut converter = opened(TIMER, &[3, 1]);
    assert!(running());
    assert_eq!(timers().len(), before.len() + 1);
    adc.set(3, -5.0);
    readings(&mut *converter, 6);
    let earliest = HostInstant::now();
    adc.set(1, 4.0);
    adc.set(3, 5.0);
    let latest = HostInstant::now();
    let mut reported = Vec::new();
    while reported.iter().filter(|one: &&AdcReading| one.before > latest).count() < 6 {
        reported.extend(readings(&mut *converter, 1));
    }
    for one in &reported {
        let (old, new) = if one.input == 0 { (-5.0, 5.0) } else { (0.0, 4.0) };
        // Of a sample that lies within the change, nobody knows.
        assert!(one.after >= earliest || near(one.value, old), "{one:?} before {earliest:?}");
        assert!(one.before <= latest || near(one.value, new), "{one:?} after {latest:?}");
        assert!(one.before <= one.after && one.after <= HostInstant::now());
    }
    let stamps: Vec<HostInstant> =
        reported.iter().filter(|one| one.input == 1).map(|one| one.before).collect();
    assert!(stamps.windows(2).all(|two| two[0] < two[1]), "{stamps:?}");
    drop(converter);
    assert!(!running());
    assert_eq!(timers(), before);
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_trigger_that_is_there_gives_the_pace_and_stays() {
    let (_lab, _adc) = (Lab::enter(), Adc::enter());
    let mut converter = opened(TRIGGER, &[0]);
    readings(&mut *converter, 3);
    let trigger = "/sys/bus/iio/devices/trigger0";
    assert_eq!(fs::read_to_string(format!("{trigger}/name")).unwrap(), "rig-trigger\n");
    let frequency = fs::read_to_string(format!("{trigger}/sampling_frequency")).unwrap();
    assert_eq!(frequency.trim().parse::<f64>(), Ok(50.0));
    drop(converter);
    assert!(!running() && timers().contains(&"rig-trigger".to_owned()));
    let current = fs::read_to_string("/sys/bus/iio/devices/iio:device0/trigger/current_trigger").unwrap();
    assert_eq!(current.trim(), "");
    let typo = refused(", trigger = \"rig-triger\"", &[0]);
    assert_eq!((typo.code, typo.help.as_str()), ("B0134", "did you mean \"rig-trigger\"?"));
    assert!(typo.place.is_some());
}

/// A trigger that fires when somebody writes to its file, until this is dropped.
struct Fired;

impl Fired {
    const NAME: &str = "sysfstrig7";

    fn add() -> Fired {
        fs::write("/sys/bus/iio/devices/iio_sysfs_trigger/add_trigger", "7").unwrap();
        Fired
    }

    /// Its folder.
    fn folder(&self) -> std::path::PathBuf {
        let entries = fs::read_dir("/sys/bus/iio/devices").unwrap().flatten().map(|entry| entry.path());
        let named = |folder: &std::path::PathBuf| {
            fs::read_to_string(folder.join("name")).is_ok_and(|name| name.trim() == Fired::NAME)
        };
        entries.into_iter().find(named).expect("the trigger that was added")
    }
}

impl Drop for Fired {
    fn drop(&mut self) {
        let _ = fs::write("/sys/bus/iio/devices/iio_sysfs_trigger/remove_trigger", "7");
    }
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_trigger_that_a_program_fires_gives_a_sample_each_time() {
    let (_lab, adc) = (Lab::enter(), Adc::enter());
    let trigger = Fired::add();
    let now = trigger.folder().join("trigger_now");
    let mut converter = opened(&format!(", trigger = \"{}\", buffer = 64", Fired::NAME), &[2]);
    let mut last = HostInstant::BOOT;
    for step in 0..4 {
        let volts = f64::from(step);
        adc.set(2, volts);
        let fired = HostInstant::now();
        fs::write(&now, "1").unwrap();
        let reported = readings(&mut *converter, 1);
        let end = HostInstant::now();
        let [one] = &reported[..] else { panic!("one trigger, one sample: {reported:?}") };
        assert!(near(one.value, volts), "{volts} V: {reported:?}");
        assert!(
            fired <= one.before && one.before <= one.after && one.after <= end,
            "{fired:?} {reported:?} {end:?}"
        );
        assert!(last < one.before, "{last:?} {reported:?}");
        last = one.before;
    }
    drop(converter);
    assert!(!running() && now.exists(), "whoever fires it keeps it");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_device_has_one_user_at_a_time_and_only_its_own_inputs() {
    let (_lab, _adc) = (Lab::enter(), Adc::enter());
    for first in [ASKED, TIMER] {
        let held = opened(first, &[0]);
        for second in [ASKED, TIMER] {
            assert_eq!(refused(second, &[0]).code, "B0133");
        }
        drop(held);
    }
    let strange = refused(ASKED, &[4]);
    assert_eq!(strange.code, "B0132");
    assert_eq!(strange.help, "its inputs are voltage0, voltage1, voltage2, voltage3");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn scans_that_a_hanging_driver_or_a_full_buffer_swallowed_are_counted() {
    let (_lab, adc) = (Lab::enter(), Adc::enter());
    let mut converter = opened(TIMER, &[0, 1]);
    readings(&mut *converter, 4);
    converter.begin().unwrap();
    let lost = converter.lost();
    adc.stall(Duration::from_millis(300), 1);
    wait_for("a sample hangs", PATIENCE, || adc.inside() == 1);
    wait_for("it comes back", PATIENCE, || adc.inside() == 0);
    let mut misses = |what: &str, least: u64, lost: u64| {
        wait_for(what, PATIENCE, || {
            converter.read(&mut Vec::new()).unwrap();
            converter.lost() - lost >= least
        });
        converter.lost()
    };
    // 300 ms are 15 periods; one or two of them are those of the samples around.
    let lost = misses("the gap is seen", 10, lost);
    // More scans than the kernel keeps: those that found no room are gone.
    let full = || fs::read_to_string("/run/lab/iio/samples").unwrap().trim().parse::<u32>().unwrap();
    let begin = full();
    wait_for("the buffer runs over", PATIENCE, || full() >= begin + 100);
    misses("the overflow is seen", 10, lost);
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_device_that_is_taken_away_says_so_and_can_be_had_again() {
    let (_lab, adc) = (Lab::enter(), Adc::enter());
    for keys in [ASKED, TIMER] {
        let mut converter = opened(keys, &[0]);
        readings(&mut *converter, 1);
        adc.unbind();
        wait_for("the device is gone", PATIENCE, || {
            converter.read(&mut Vec::new()).is_err_and(|error| error.raw_os_error() == Some(19))
        });
        assert_eq!(refused(keys, &[0]).code, "B0130");
        adc.bind();
        drop(converter);
        adc.set(0, 1.0);
        let mut again = opened(keys, &[0]);
        let reported = readings(&mut *again, 2);
        assert!(near(reported[1].value, 1.0), "{reported:?}");
    }
    assert!(!timers().iter().any(|name| name.starts_with("rig-iio")));
}

/// A board at work, and what it reported.
struct Bench {
    board: Box<dyn Board>,
    at: BoardContext,
    events: Vec<BoardEvent>,
}

impl Bench {
    fn start(keys: &str, channels: &str) -> Bench {
        let at = BoardContext::new(Realtime::with_priority(80));
        let mut board = drivers::open(&read(&text(keys, channels)), &at).unwrap().expect("a real board");
        at.time.restart();
        board.start(Time::ZERO).unwrap();
        Bench { board, at, events: Vec::new() }
    }

    fn until(&mut self, what: &str, holds: impl Fn(&BoardEvent) -> bool) -> BoardEvent {
        let due = Instant::now() + PATIENCE;
        let mut seen = 0;
        loop {
            self.board.poll(self.at.time.now(), &mut self.events).unwrap();
            if let Some(event) = self.events[seen..].iter().find(|event| holds(event)) {
                return *event;
            }
            seen = self.events.len();
            assert!(Instant::now() < due, "never: {what}; {:?} {:?}", self.board.health(), self.events);
            let next = self.at.time.now() + Span::from_millis(20);
            let next = self.board.next_event().map_or(next, |at| at.min(next));
            self.at.bell.wait_until(self.at.time.stamp(next));
        }
    }
}

fn shows(event: &BoardEvent, channel: u16, near: f64, within: f64) -> bool {
    matches!(*event, BoardEvent::Changed { channel: ChannelId(of), value, .. }
        if of == channel && value.as_real().is_some_and(|shown| (shown - near).abs() <= within))
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_board_reports_quantities_between_the_instants_of_their_samples() {
    let (_lab, adc) = (Lab::enter(), Adc::enter());
    // 0 to 10 V are 0 to 16 bar.
    let channels = "pressure = { kind = \"analog\", unit = \"bar\", input = 1, deadband = \"0.1 bar\", \
                    scale = { from = [\"0 V\", \"10 V\"], to = [\"0 bar\", \"16 bar\"] } }\n\
                    level = { kind = \"analog\", unit = \"mV\", input = \"voltage3\" }\n";
    for keys in [ASKED, TIMER, TRIGGER] {
        adc.set(1, 5.0);
        adc.set(3, -0.5);
        let mut bench = Bench::start(keys, channels);
        bench.until("the pressure at the start", |event| shows(event, 0, 8.0, 0.01));
        bench.until("the level at the start", |event| shows(event, 1, -500.0, 0.5));
        let earliest = bench.at.time.now();
        adc.set(1, 7.5);
        let latest = bench.at.time.now();
        let event = bench.until("the new pressure", |event| shows(event, 0, 12.0, 0.01));
        let BoardEvent::Changed { at, .. } = event else { unreachable!() };
        assert!(at.earliest <= latest && at.latest >= earliest, "{keys}: {at:?}, {earliest} to {latest}");
        // Half of the deadband is nothing.
        adc.set(1, 7.53);
        adc.set(3, 0.25);
        bench.until("the new level", |event| shows(event, 1, 250.0, 0.5));
        let reported = bench
            .events
            .iter()
            .filter(|event| event.channel() == ChannelId(0) && shows(event, 0, 12.05, 0.01));
        assert_eq!(reported.count(), 0, "{keys}: {:?}", bench.events);
        assert_eq!(bench.board.health().lost, 0);
        bench.board.safe(bench.at.time.now()).unwrap();
    }
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_board_loses_a_converter_that_hangs_or_goes_and_takes_it_back() {
    let (_lab, adc) = (Lab::enter(), Adc::enter());
    let channels = "level = { kind = \"analog\", unit = \"V\", input = 0 }\n";
    for keys in [ASKED, TIMER] {
        adc.set(0, 1.0);
        let mut bench = Bench::start(keys, channels);
        bench.until("the level at the start", |event| shows(event, 0, 1.0, 0.001));
        for (reason, begin) in [(LossReason::Unresponsive, 0), (LossReason::Gone, 1)] {
            bench.events.clear();
            match begin {
                0 => adc.stall(Duration::from_millis(1_000), 1),
                _ => adc.unbind(),
            }
            bench.until(
                "it is lost",
                |event| matches!(event, BoardEvent::Lost { reason: reported, .. } if *reported == reason),
            );
            assert_eq!(bench.board.health().lost, 1, "{keys}");
            if reason == LossReason::Gone {
                adc.bind();
            }
            // A device that was taken away begins at 0 V.
            adc.set(0, 1.0);
            bench.until("it is back", |event| matches!(event, BoardEvent::Returned { .. }));
            bench.until("it measures again", |event| shows(event, 0, 1.0, 0.001));
            assert_eq!(bench.board.health().lost, 0, "{keys}");
        }
    }
}
