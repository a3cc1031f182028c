//! Board files: the good one reads, each broken one is refused with the code and the place that its first line
//! expects, and no text panics.

use std::path::{Path, PathBuf};

use crate::common::*;
use crate::plant_programs::PlayedPrograms;
use document::{SourceFile, line_col};
use proptest::prelude::*;
use scanrig_drivers::circuit::{Bounce, Pull, Spacing};
use scanrig_drivers::file::KEYS;
use scanrig_drivers::{
    Bite, Board, BoardFile, BusId, CODES, ControlSettings, Disturbance, GuardSettings, OnDisconnect, Subject,
    SubjectPort, SubjectPortKind, Terminals, UnknownSubject, WatchdogSettings, build, read,
    read_with_programs,
};
use signal::{Address, Area, Span, Value};

fn terminals(subject: &Subject) -> Result<Terminals, UnknownSubject> {
    let known = ["m241-2014", "m241-2019", "m251-2024"].map(String::from).to_vec();
    if !known.contains(&subject.profile) {
        return Err(UnknownSubject::Profile { known });
    }
    let known = ["TM241CEC24T", "TM241CEC24R", "TM241CE40T"].map(String::from).to_vec();
    if subject.reference.as_ref().is_some_and(|reference| !known.contains(reference)) {
        return Err(UnknownSubject::Reference { known });
    }
    let inputs = (0..14).map(|bit| Address::bit(Area::Input, bit)).collect();
    let mut outputs: Vec<Address> = (0..10).map(|bit| Address::bit(Area::Output, bit)).collect();
    outputs.extend(Address::parse("%QW4"));
    let port = |name: &str, node: &str, kind| SubjectPort { names: [name.into(), node.into()], kind };
    let ports = vec![
        port("SL1", "Serial_Line_1", SubjectPortKind::Serial { rs232: true }),
        port("SL2", "Serial_Line_2", SubjectPortKind::Serial { rs232: false }),
        port("CAN_1", "CAN_1", SubjectPortKind::Can),
        port("Ethernet_1", "Ethernet_1", SubjectPortKind::Other("an Ethernet network".into())),
    ];
    let modules = ["TM3DI16", "TM3DQ16T"].map(String::from).to_vec();
    Ok(Terminals { inputs, outputs, ports, modules })
}

/// As [`terminals`] but with levels alone, as the controllers have them.
fn levels(subject: &Subject) -> Result<Terminals, UnknownSubject> {
    let mut terminals = terminals(subject)?;
    terminals.outputs.truncate(10);
    Ok(terminals)
}

fn here() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests")
}

fn good_text() -> String {
    std::fs::read_to_string(here().join("bench.toml")).unwrap()
}

fn good() -> BoardFile {
    read(&SourceFile::new("bench.toml", good_text()), &levels).unwrap_or_else(|found| panic!("{found:#?}"))
}

#[test]
fn the_bench_reads() {
    let file = good();
    assert_eq!(file.subject, Subject::default());
    let channel = |address: &str| {
        let id = file.channel_of(Address::parse(address).unwrap()).unwrap();
        &file.circuit.channels[usize::from(id.0)]
    };
    assert_eq!(channel("%IX0.0").name, "I0");
    assert_eq!(channel("%IX0.3").name, "I4");
    assert_eq!(channel("%IX0.1").name, "door");
    assert_eq!(channel("%IX1.5").name, "I13");
    assert_eq!(channel("%QX1.1").name, "Q9");
    assert_eq!((channel("%IX0.2").pull, channel("%IX0.1").pull), (Pull::Up, Pull::Up));
    // A channel of an output is high impedance while nobody drives it, unless its pull is written.
    assert_eq!((channel("%QX0.2").name.as_str(), channel("%QX0.2").pull), ("lamp", Pull::None));
    let wire = file.circuit.wires[0];
    assert_eq!((wire.from, wire.to), (file.find("Q0").unwrap(), file.find("I3").unwrap()));
    assert_eq!((wire.delay, wire.invert), (Span::from_millis(1), true));
    let bounce = Bounce { edges: 4, over: Span::from_millis(3), spacing: Spacing::Random };
    assert_eq!(wire.bounce, Some(bounce));
    assert_eq!(file.circuit.wires[1].from, file.find("lamp").unwrap());
    let plant = |place: usize| format!("{:?}", file.circuit.plants[place]);
    assert!(plant(0).contains("target: Levels { low: 20.0, high: 120.5 }, initial: 25.0"), "{}", plant(0));
    assert!(plant(0).contains("off_below: 55.0"));
    assert!(plant(1).contains("target: Linear { offset: 1.0, gain: 2.5 }, initial: 1.0"), "{}", plant(1));
    let expected = Disturbance {
        late_ppm: 250_000,
        late_by: Span::from_millis(1),
        drop_ppm: 1,
        ..Disturbance::default()
    };
    assert_eq!(file.disturbance, Some(expected));
    let mut board = build(&file, 7).unwrap();
    board.start(at(0)).unwrap();
    let events = poll(&mut board, 0);
    assert_eq!(events.len(), board.channels().len());
    assert_eq!(changes(&events, file.find("set").unwrap().0), [(0, Value::Real(0.0))]);
}

#[test]
fn a_delay_of_on_or_off_stands_for_its_own_direction() {
    let delays = |keys: &str| {
        let text = format!("format = 1\n[channels]\n[[wires]]\nfrom = \"Q0\"\nto = \"I0\"\n{keys}\n");
        let file = read(&SourceFile::new("b.toml", text), &levels).unwrap();
        let wire = file.circuit.wires[0];
        (wire.delay.as_nanos() / 1_000_000, wire.off_delay.map(|delay| delay.as_nanos() / 1_000_000))
    };
    assert_eq!(delays("delay = \"3 ms\""), (3, None));
    assert_eq!(delays("delay = \"3 ms\"\non-delay = \"5 ms\""), (5, Some(3)));
    assert_eq!(delays("delay = \"3 ms\"\noff-delay = \"5 ms\""), (3, Some(5)));
    assert_eq!(delays("off-delay = \"5 ms\""), (0, Some(5)));
    assert_eq!(delays("on-delay = \"5 ms\"\noff-delay = \"1 ms\""), (5, Some(1)));
}

#[test]
fn numbers_are_converted_to_the_unit_of_their_channel() {
    let plant = |unit: &str, numbers: &str| {
        let text = format!(
            "format = 1\n[channels]\nu = {{ kind = \"analog\", unit = \"{unit}\" }}\n[[plants]]\nkind = \"lag\"\n\
             name = \"p\"\ninput = \"Q0\"\noutput = \"u\"\ntau = \"1 s\"\nsample = \"1 ms\"\n{numbers}\n"
        );
        let file = read(&SourceFile::new("b.toml", text), &levels).map_err(|found| found[0].code)?;
        let lag = format!("{:?}", file.circuit.plants[0]);
        let number = |key: &str| -> f64 {
            let text = lag.split_once(&format!("{key}: ")).unwrap().1;
            text[..text.find([',', ' ', '}']).unwrap()].parse().unwrap()
        };
        Ok((number("low"), number("high"), number("initial")))
    };
    let of_volts = plant("V", "low = \"500 mV\"\nhigh = \"1_000_000 µV\"\ninitial = \"-0.001 kV\"");
    assert_eq!(of_volts, Ok((0.5, 1.0, -1.0)));
    assert_eq!(plant("°C", "low = \"20 degC\"\nhigh = \"+80.5 °C\""), Ok((20.0, 80.5, 20.0)));
    assert_eq!(plant("l/min", "low = \"2 l/min\"\nhigh = 1e1"), Ok((2.0, 10.0, 2.0)));
    assert_eq!(plant("uA", "low = \"4 μA\"\nhigh = \"0.02 mA\""), Ok((4.0, 20.0, 4.0)));
    assert_eq!(plant("l/min", "low = \"2 l/h\"\nhigh = 3"), Err("B0503"));
    assert_eq!(plant("V", "low = \"500 mA\"\nhigh = 3"), Err("B0503"));
    assert_eq!(plant("", "low = \"1 V\"\nhigh = 3"), Err("B0503"));
}

#[test]
fn modules_that_are_fitted() {
    let fitted = |text: &str| {
        let file = read(&SourceFile::new("b.toml", format!("format = 1\n{text}\n")), &levels);
        file.map(|file| file.fitted).map_err(|found| found[0].code)
    };
    let both = ["TM3DI16", "TM3DQ16T"].map(String::from).to_vec();
    assert_eq!(fitted(""), Ok(None));
    assert_eq!(fitted("modules = []"), Ok(Some(Vec::new())));
    assert_eq!(fitted("modules = [\"tm3di16\", { type = \"TM3DQ16T\" }]"), Ok(Some(both.clone())));
    assert_eq!(fitted("[[modules]]\ntype = \"TM3DI16\"\n[[modules]]\ntype = \"TM3DQ16T\""), Ok(Some(both)));
    assert_eq!(fitted("modules = [\"TM3DI17\"]"), Err("B0314"));
    assert_eq!(fitted(&format!("modules = [{}]", "\"TM3DI16\",".repeat(33))), Err("B0314"));
    assert_eq!(fitted("modules = [\"TM3DI16\"]\n[subject]\nkind = \"external\""), Err("B0314"));
}

#[test]
fn the_smallest_file_is_the_default_board() {
    let file = read(&SourceFile::new("b.toml", "format = 1\n"), &levels).unwrap();
    let Terminals { inputs, outputs, .. } = levels(&Subject::default()).unwrap();
    let default = BoardFile::default_for(&inputs, &outputs);
    assert_eq!((&file.circuit.channels, &file.bind), (&default.circuit.channels, &default.bind));
    assert!(file.circuit.wires.is_empty() && file.circuit.plants.is_empty());
    assert_eq!(file.circuit.channels.len(), 24);
}

/// What the first lines of a file expect, as `B0102 3:7`.
fn expected(text: &str) -> Vec<String> {
    text.lines().map_while(|line| line.strip_prefix("# expect ")).map(str::to_owned).collect()
}

/// A real board with these channels.
fn channels(text: &str, subject: &str) -> BoardFile {
    let text = format!(
        "format = 1\n[board]\nkind = \"real\"\n{subject}\n[channels]\n{text}\n[chips]\nmain = {{ label = \"chip\" }}\n\
         [generators]\ng = {{ kind = \"spi\", path = \"/dev/spidev0.0\" }}\n"
    );
    read(&SourceFile::new("b.toml", text), &terminals).unwrap_or_else(|found| panic!("{found:#?}"))
}

#[test]
fn one_duration_of_an_input_delay_is_the_greatest() {
    for (written, least, most) in [
        ("18 us", 0, 18),
        ("2 us .. 18 us", 2, 18),
        (".. 18 us", 0, 18),
        ("18 us .. 18 us", 18, 18),
        ("5 us ± 1 us", 4, 6),
        // A tolerance does not reach below 0.
        ("5 us ± 8 us", 0, 13),
    ] {
        let file =
            channels(&format!("I0 = {{ kind = \"digital\", line = 1, input-delay = \"{written}\" }}"), "");
        let us = Span::from_micros;
        assert_eq!(file.delays[0].before, (us(least), us(most)), "{written}");
    }
}

#[test]
fn an_output_of_a_generator_has_the_delay_of_an_output() {
    let text = "I0 = { kind = \"digital\", generator = \"g\", output-delay = \"5 us\" }";
    let file = channels(text, "[subject]\nkind = \"external\"");
    let zero = Span::ZERO;
    assert_eq!((file.delays[0].before, file.delays[0].after), ((zero, zero), Span::from_micros(5)));
}

#[test]
fn a_clock_that_is_right_needs_no_unit() {
    for written in ["0", "0.0", "\"0\"", "\"0 ppm\""] {
        let text = format!("format = 1\n[board]\nkind = \"simulated\"\nclock-error = {written}\n");
        let file =
            read(&SourceFile::new("b.toml", text), &terminals).unwrap_or_else(|found| panic!("{found:#?}"));
        assert!(file.clock.error.is_none(), "{written}");
    }
}

#[test]
fn broken_files_are_refused_where_they_are_broken() {
    let mut paths: Vec<PathBuf> =
        std::fs::read_dir(here().join("broken")).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let mut seen = Vec::new();
    let mut wrong = String::new();
    for path in &paths {
        let text = std::fs::read_to_string(path).unwrap();
        let file = SourceFile::new("b.toml", text.clone());
        let found = read_with_programs(&file, &terminals, &PlayedPrograms).err().unwrap_or_default();
        let mut places = Vec::new();
        for one in &found {
            let (line, column) = line_col(&text, one.labels.first().map_or(0, |label| label.span.start));
            places.push(format!("{} {line}:{column}", one.code));
            seen.push(one.code);
            assert!(!one.message.ends_with('.'), "{}: {}", path.display(), one.message);
        }
        if places != expected(&text) {
            wrong += &format!("{}: {places:?}\n{found:#?}\n", path.file_name().unwrap().to_string_lossy());
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
    // Sizes have no file of their own, what a machine lacks shows only when the board is opened, and what does not suit a module
    // only with a plan.
    let serial = |code: &str| ("B0144"..="B0149").contains(&code);
    let can = |code: &str| ("B0154"..="B0159").contains(&code);
    let converter = |code: &str| code == "B0125" || ("B0127"..="B0137").contains(&code);
    let counter = |code: &str| ("B0208"..="B0214").contains(&code);
    let generator = |code: &str| code.starts_with("B023");
    let converter = |code: &str| converter(code) || counter(code) || generator(code);
    let machine = |code: &str| code.starts_with("B017") || serial(code) || can(code) || converter(code);
    let elsewhere = |code: &str| ["B0003", "B0204", "B0312"].contains(&code) || machine(code);
    for (code, title) in CODES.iter().filter(|(code, _)| !elsewhere(code)) {
        assert!(seen.contains(code), "no broken file shows {code}: {title}");
    }
}

/// The help of what is wrong with one bus on a board of this kind.
fn help_of_bus(board: &str, bus: &str) -> String {
    let text = format!("format = 1\nboard = {{ kind = \"{board}\" }}\n[buses]\nline = {{ {bus} }}\n");
    let found = read(&SourceFile::new("b.toml", text), &terminals).unwrap_err();
    assert_eq!(found.len(), 1, "{found:?}");
    found[0].help.clone()
}

#[test]
fn a_key_of_another_bus_is_answered_by_what_this_one_has() {
    for (board, bus, help) in [
        ("simulated", "kind = \"can\", baud = 9600", "write `bitrate`"),
        ("simulated", "kind = \"serial\", bitrate = 9600", "write `baud`"),
        ("simulated", "kind = \"can\", message-gap = \"1 ms\"", "only a serial line"),
        ("simulated", "kind = \"can\", delay = \"1 ms\"", "only a serial line"),
        ("simulated", "kind = \"can\", sample-point = 0.8", "only a bus of a real board"),
        ("simulated", "kind = \"serial\", path = \"/dev/ttyS0\"", "no device"),
        (
            "real",
            "kind = \"serial\", path = \"/dev/ttyS0\", joins = \"other\"",
            "only a bus of a simulated board",
        ),
        (
            "real",
            "kind = \"can\", interface = \"can0\", bitrate = 500_000, delay = \"1 s\"",
            "only a bus of a simulated",
        ),
        ("real", "kind = \"serial\", path = \"/dev/ttyS0\", accept = [\"701\"]", "only a CAN bus"),
    ] {
        let found = help_of_bus(board, bus);
        assert!(found.contains(help), "{bus}: {found}");
    }
}

/// On real and on simulated boards, and for a real controller too; a bus has the number of its place.
#[test]
fn ports_are_bound_to_buses() {
    let can = "[buses]\nfirst = { kind = \"can\" }\nsecond = { kind = \"can\", joins = \"first\" }\n[ports]\ncan_1 = \"second\"\n";
    for subject in ["", "[subject]\nkind = \"external\"\n"] {
        let text = format!("format = 1\n{subject}{can}");
        let file =
            read(&SourceFile::new("board.toml", text), &levels).unwrap_or_else(|found| panic!("{found:#?}"));
        let bound: Vec<_> = file.ports.iter().map(|port| (port.port.as_str(), port.bus)).collect();
        assert_eq!(bound, [("CAN_1", BusId(1))]);
    }
    // What a real serial port is on the wire, its adapter says.
    let text = "format = 1\n[board]\nkind = \"real\"\n[buses]\nline = { kind = \"serial\", path = \"/dev/ttyS0\" }\n[ports]\nSL2 = \"line\"\n";
    let file =
        read(&SourceFile::new("board.toml", text), &levels).unwrap_or_else(|found| panic!("{found:#?}"));
    assert_eq!(file.ports[0].bus, BusId(0));
}

#[test]
fn the_guard_is_read() {
    let text = "format = 1\n[guard]\nlimit = \"50 ms\"\nwatchdog = \"/dev/watchdog1\"\nbite = \"rig-lost\"\n";
    let file = read(&SourceFile::new("b.toml", text), &terminals).unwrap();
    let place = text.find("\"/dev").map_or(0..0, |at| at..at + "\"/dev/watchdog1\"".len());
    let watchdog = WatchdogSettings {
        path: "/dev/watchdog1".into(),
        after: Span::from_secs(10),
        bite: Bite::RigLost,
        place,
    };
    assert_eq!(
        file.guard,
        GuardSettings { limit: Span::from_millis(50), watchdog: Some(watchdog), ..GuardSettings::default() }
    );
    assert_eq!(good().guard, GuardSettings::default());
}

#[test]
fn the_control_socket_is_read() {
    let text = "format = 1\n[control]\nsocket = \"/run/rig.sock\"\ngroup = \"scanrig\"\non-disconnect = \"stop\"\n\
                clients = 4096\n";
    let file = read(&SourceFile::new("b.toml", text), &levels).unwrap_or_else(|found| panic!("{found:#?}"));
    let told = ControlSettings {
        socket: Some("/run/rig.sock".into()),
        group: Some("scanrig".into()),
        group_at: text.find("\"scanrig\"").map_or(0..0, |at| at..at + 9),
        on_disconnect: OnDisconnect::Stop,
        clients: Some(4_096),
    };
    assert_eq!(file.control, told);
    assert_eq!(good().control, ControlSettings::default());
}

#[test]
fn the_register_is_in_order_and_the_keys_are_told() {
    assert!(CODES.windows(2).all(|pair| pair[0].0 < pair[1].0));
    assert!(KEYS.iter().all(|key| !key.doc.is_empty()));
}

#[test]
fn too_many_parts_are_refused() {
    let mut text = String::from("format = 1\n[channels]\n");
    for n in 0..5_000 {
        text += &format!("c{n} = {{ kind = \"digital\" }}\n");
    }
    let found = read(&SourceFile::new("b.toml", text), &terminals).unwrap_err();
    assert_eq!(found[0].code, "B0204");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    /// A file with a line or a part replaced either reads, and then its board can be built and started, or is
    /// refused with codes of the register.
    #[test]
    fn mutated_files_do_not_panic(
        at in 0usize..2_000,
        length in 0usize..40,
        by in prop_oneof![
            "\\PC{0,12}",
            "[-0-9.\"%IQX ]{0,8}",
            Just("\"0 ns\"".to_owned()),
            Just("1e999".to_owned()),
            Just("99999999999999999999".to_owned()),
        ],
    ) {
        let mut text = good_text();
        let mut start = at % text.len();
        while !text.is_char_boundary(start) {
            start -= 1;
        }
        let mut end = (start + length).min(text.len());
        while !text.is_char_boundary(end) {
            end += 1;
        }
        text.replace_range(start..end, &by);
        match read(&SourceFile::new("b.toml", text), &levels) {
            Ok(file) => {
                let mut board = build(&file, 1).unwrap();
                prop_assert_eq!(board.start(at_zero()), Ok(()));
            }
            Err(found) => {
                prop_assert!(!found.is_empty());
                for one in found {
                    prop_assert!(CODES.iter().any(|(code, _)| *code == one.code), "{}", one.code);
                }
            }
        }
    }

    #[test]
    fn no_text_panics(text in "\\PC{0,200}") {
        let _ = read(&SourceFile::new("b.toml", text), &levels);
    }
}

fn at_zero() -> signal::Time {
    at(0)
}

#[test]
fn a_real_controller_turns_the_directions_round() {
    let text = |kind: &str| {
        format!(
            "format = 1\nboard = {{ kind = \"simulated\" }}\n[subject]\nkind = \"{kind}\"\npower = \"supply\"\n\
             alarm = \"Q3\"\n[channels]\nsupply = {{ kind = \"digital\" }}\nspare = {{ kind = \"digital\" }}\n"
        )
    };
    for (kind, external) in [("external", true), ("model", false)] {
        let file = read(&SourceFile::new("board.toml", text(kind)), &levels).unwrap();
        assert_eq!(file.subject.is_external(), external);
        let driven = |name: &str| file.is_driven(file.find(name).unwrap());
        assert_eq!(driven("I0"), Some(external));
        assert_eq!(driven("Q0"), Some(!external));
        assert_eq!(driven("supply"), Some(external));
        assert_eq!(driven("spare"), None);
        assert_eq!((file.lines.power, file.lines.alarm), (file.find("supply"), file.find("Q3")));
    }
}

#[test]
fn what_values_cover_is_a_bound_unless_the_file_or_the_noise_says_otherwise() {
    let text = "format = 1\n[board]\nkind = \"real\"\n[converters]\n\
                one = { kind = \"spi\", path = \"/dev/spidev0.0\", part = \"mcp3208\", reference = \"3.3 V\" }\n\
                many = { kind = \"spi\", path = \"/dev/spidev0.1\", part = \"mcp3208\", reference = \"3.3 V\", oversample = 16 }\n\
                [channels]\n\
                a = { kind = \"analog\", unit = \"V\", converter = \"one\", input = 0, accuracy = { plus = \"10 mV\" } }\n\
                b = { kind = \"analog\", unit = \"V\", converter = \"one\", input = 1, accuracy = { plus = \"10 mV\", coverage = \"k = 2\" } }\n\
                c = { kind = \"analog\", unit = \"V\", converter = \"many\", input = 0 }\n\
                d = { kind = \"analog\", unit = \"V\", converter = \"many\", input = 1, accuracy = { of-value = \"1 %\", coverage = \"k = 2\" } }\n";
    let file = read(&SourceFile::new("b.toml", text), &levels).unwrap_or_else(|found| panic!("{found:#?}"));
    let stated: Vec<(String, String)> = file
        .coverages()
        .into_iter()
        .map(|(channel, words)| (file.circuit.channels[usize::from(channel.0)].name.clone(), words))
        .collect();
    let known = [("b", "k = 2"), ("c", "95 %"), ("d", "95 %, k = 2")];
    assert_eq!(stated, known.map(|(channel, words)| (channel.to_owned(), words.to_owned())));
    assert!(good().coverages().is_empty());
}
