//! A rig whose time clients lead: exact, and the same each time.

use super::{BOARD, Bench, PLAN, with_rig, with_rig_of};
use control::{ControllerAction, SignalKind, WordScale};
use services::control::{Answer, Rig, RigEvent, RigOrder};
use signal::{Span, Value};

const MS: fn(i64) -> Span = Span::from_millis;

#[test]
fn time_passes_when_it_is_asked_for_and_what_it_brings_is_reported() {
    let lead = || {
        let mut all = Vec::new();
        with_rig(true, |bench: &mut Bench<'_>| {
            bench.advance(MS(1_000));
            let before = bench.rig.status();
            assert_eq!((before.at, before.state.as_str()), (1_000_000_000, "RUNNING"));
            let flash = bench.watch("MAIN.flash");
            bench.advance(MS(500));
            assert_eq!(bench.rig.status().at, 1_500_000_000);
            // Its value at first, then an edge in each 120 ms: the timer is asked every 20 ms.
            let changes = bench.changes(flash);
            assert!((4..=6).contains(&changes.len()), "{changes:?}");
            assert_eq!(changes[0].0, 1_000_000_000);
            assert!(changes.windows(2).all(|pair| pair[0].1 != pair[1].1), "{changes:?}");
            assert!(changes.last().unwrap().0 <= 1_500_000_000);
            bench.rig.unwatch(flash);
            bench.advance(MS(500));
            assert_eq!(bench.changes(flash), changes);
            all = changes;
        });
        all
    };
    assert_eq!(lead(), lead());
}

#[test]
fn forces_writes_and_commands_do_what_they_say() {
    with_rig(true, |bench| {
        bench.advance(MS(100));
        assert_eq!(bench.read("%QX0.0"), Value::Bool(false));
        bench.force("Q0", true).unwrap();
        let status = bench.rig.status();
        assert_eq!(status.forced.len(), 1);
        assert_eq!(status.forced[0].address, "%QX0.0");
        bench.advance(MS(100));
        assert_eq!(bench.read("signal"), Value::Bool(true));
        // An input is forced by its line's name as well.
        bench.force("start", true).unwrap();
        assert_eq!(bench.order(RigOrder::ReleaseAll), Ok(Answer::Done));
        assert!(bench.rig.status().forced.is_empty());
        bench.advance(MS(100));
        assert_eq!(bench.read("signal"), Value::Bool(false));
        // Somebody pushes the button.
        bench.write("start", Value::Bool(true)).unwrap();
        bench.advance(MS(100));
        assert_eq!(bench.read("signal"), Value::Bool(true));
        bench.write("MAIN.count", Value::Int(1_000)).unwrap();
        bench.write("main.level", Value::Int(2)).unwrap();
        assert_eq!(bench.read("MAIN.level"), Value::Real(2.0));
        bench.advance(MS(100));
        assert_eq!(bench.read("MAIN.count"), Value::Int(1_005));
        // What a TIME cannot hold is not cut to something else.
        bench.write("MAIN.tick.PT", Value::Int(250_000_000)).unwrap();
        assert_eq!(bench.read("MAIN.tick.PT"), Value::Int(250_000_000));
        for nanos in [-5_000_000, 4_294_967_296_000_000] {
            let fault = bench.write("MAIN.tick.PT", Value::Int(nanos)).unwrap_err();
            assert_eq!(fault.code, "R0603");
            assert!(fault.help.contains("a time from 0 s to 4294967.295 s"), "{}", fault.help);
        }
        assert_eq!(bench.order(RigOrder::Command(ControllerAction::Stop)), Ok(Answer::Done));
        bench.advance(MS(100));
        assert_eq!(bench.rig.status().state, "STOPPED");
        bench.order(RigOrder::Command(ControllerAction::PowerOff)).unwrap();
        bench.advance(MS(1_000));
        let off = bench.rig.status();
        assert_eq!((off.state.as_str(), off.power), ("OFF", false));
        let fault = bench.order(RigOrder::Command(ControllerAction::Run)).unwrap_err();
        assert_eq!(fault.code, "R0606");
        bench.order(RigOrder::Command(ControllerAction::PowerOn)).unwrap();
        bench.advance(Span::from_secs(60));
        assert!(bench.rig.status().power);
    });
}

#[test]
fn what_cannot_be_is_refused_with_a_code_and_a_mend() {
    with_rig(true, |bench| {
        bench.advance(MS(100));
        let fault = bench.rig.find("MAIN.cuont").unwrap_err();
        assert_eq!((fault.code.as_str(), fault.help.as_str()), ("R0601", "did you mean `MAIN.count`?"));
        assert_eq!(bench.rig.find("%MW99999999").unwrap_err().code, "R0601");
        assert_eq!(bench.rig.find("MAIN.list").unwrap_err().code, "R0601");
        let fault = bench.rig.find("M1.IW0").unwrap_err();
        assert!(fault.code == "R0601" && fault.help.contains("no module is configured"), "{}", fault.help);
        for (name, value, code) in [
            ("MAIN.count", Value::Int(100_000), "R0603"),
            ("MAIN.count", Value::Real(0.5), "R0603"),
            ("MAIN.tick.Q", Value::Int(2), "R0603"),
            ("MAIN.level", Value::Bool(true), "R0603"),
            ("MAIN.level", Value::Real(f64::NAN), "R0603"),
            ("%MW3", Value::Int(70_000), "R0603"),
            ("%MW3", Value::Int(-40_000), "R0603"),
            ("%MW3", Value::Bool(true), "R0603"),
            ("%MX8.0", Value::Int(2), "R0603"),
            ("PLC_R.i_wStatus", Value::Int(1), "R0602"),
            ("signal", Value::Bool(true), "R0602"),
            ("state", Value::Int(1), "R0602"),
        ] {
            assert_eq!(bench.write(name, value).unwrap_err().code, code, "{name}");
        }
        assert_eq!(bench.force("MAIN.count", true).unwrap_err().code, "R0605");
        // Bits have no sign: a word takes the numbers of an INT and those of a UINT.
        bench.write("%MW3", Value::Int(-2)).unwrap();
        assert_eq!(bench.read("%MW3"), Value::Int(65_534));
        // Elements of arrays are found though nobody lists them.
        bench.write("MAIN.list[2]", Value::Int(7)).unwrap();
        assert_eq!(bench.read("MAIN.list[2]"), Value::Int(7));
    });
}

#[test]
fn a_description_says_what_the_words_of_analogue_channels_stand_for() {
    let plan = format!(
        "{PLAN}[settings]
modules = [
    {{ type = \"TM3AI4\", inputs = [{{ mode = \"4..20 mA\", min = 0, max = 10000 }}] }},
    {{ type = \"TM3TI4\", inputs = [{{ mode = \"PT100\", scope = \"fahrenheit\" }}, \"thermocouple K\"] }},
    {{ type = \"TM3AQ2\", outputs = [{{ mode = \"-10..10 V\", min = -500, max = 500 }}] }},
]
"
    );
    with_rig_of(&plan, BOARD, true, |bench| {
        let points = bench.rig.describe().points;
        let scale = |name: &str| {
            let point = points.iter().find(|point| point.name == name);
            point.unwrap_or_else(|| panic!("no {name}")).scale.clone()
        };
        let of = |words, values, unit: &str| Some(WordScale { words, values, unit: unit.to_owned() });
        assert_eq!(scale("I0"), None);
        assert_eq!(scale("M1.IW0"), of([0.0, 10_000.0], [4.0, 20.0], "mA"));
        assert_eq!(scale("M2.IW0"), of([-3280.0, 15_620.0], [-328.0, 1_562.0], "degF"));
        assert_eq!(scale("M2.IW1"), of([-2_000.0, 13_000.0], [-200.0, 1_300.0], "degC"));
        assert_eq!(scale("M3.QW0"), of([-500.0, 500.0], [-10.0, 10.0], "V"));
        let current = scale("M1.IW0").unwrap();
        assert_eq!((current.value(2_500.0), current.share(2_500.0)), (8.0, 0.25));
    });
}

#[test]
fn a_description_has_what_is_on_the_front_and_inside() {
    with_rig(true, |bench| {
        let described = bench.rig.describe();
        let start = described.points.iter().find(|point| point.name == "I0").unwrap();
        assert_eq!(start.address.as_deref(), Some("%IX0.0"));
        assert_eq!(start.variable.as_deref(), Some("MAIN.button"));
        assert_eq!(start.channel.as_ref().unwrap().name, "start");
        let tasks: Vec<_> =
            described.tasks.iter().map(|task| (task.name.as_str(), task.programs.len())).collect();
        assert_eq!(tasks, [("MAST", 1)]);
        let signal = |name: &str| described.signals.iter().find(|signal| signal.name == name).unwrap();
        let count = signal("MAIN.count");
        assert_eq!((count.unit.as_str(), signal("MAIN.tick.PT").unit.as_str()), ("", "ns"));
        assert_eq!((count.kind, count.writable), (SignalKind::Int, true));
        // The values of a system variable have names where they have an enumeration.
        let state = signal("PLC_R.i_wStatus");
        assert_eq!((state.kind, &state.labels[2]), (SignalKind::Word, &(2, String::from("PLC_R_RUNNING"))));
        assert!(signal("PLC_R.i_wVendorID").labels.is_empty());
        assert!(signal("SERIAL_W[1].q_wResetCounter").writable && !signal("ETH_R.i_byIPAddress[3]").writable);
        bench.advance(MS(2_000));
        let status = bench.rig.status();
        assert_eq!(status.points.len(), described.points.len());
        let beacon = described.points.iter().position(|point| point.name == "Q1").unwrap();
        assert!(status.points[beacon].rising >= 7, "{:?}", status.points[beacon]);
        assert_eq!(status.tasks[0].jitter_counts.iter().map(|(_, n)| n).sum::<u64>(), status.tasks[0].cycles);
        assert!(status.troubles.is_empty(), "{:?}", status.troubles);
        let led = |name: &str| status.leds.iter().find(|led| led.name == name).unwrap().pattern.clone();
        assert_eq!((led("RUN"), led("ERR")), (String::from("on"), String::from("off")));
    });
}

#[test]
fn two_names_of_one_place_are_watched_apart() {
    with_rig(true, |bench| {
        bench.advance(MS(100));
        let (lamp, image) = (bench.watch("MAIN.lamp"), bench.watch("%QX0.0"));
        assert_ne!(lamp, image);
        bench.advance(MS(100));
        assert_eq!(bench.changes(lamp).len(), 1);
        assert_eq!(bench.changes(image).len(), 1);
        bench.rig.unwatch(image);
        bench.force("Q0", true).unwrap();
        bench.advance(MS(100));
        // The program writes it in each cycle, and the force after the cycle.
        assert!(bench.changes(lamp).len() > 1);
        assert_eq!(bench.changes(image).len(), 1);
        assert!(!bench.reported.iter().any(|reported| matches!(reported, RigEvent::Ended(_))));
    });
}
