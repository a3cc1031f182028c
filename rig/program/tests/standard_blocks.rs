//! Every standard block called from Structured Text in every way, against models of their own: IEC 61131-3, 6.6.3.5
//! (bodies of the bistables, edges and counters, diagrams of the timers), with the pins and types of the controllers'
//! library Standard (controller:LIB-01).

use crate::support::{Rig, codes};
use proptest::prelude::*;
use scanrig_program::{Retention, STANDARD};
use signal::{Span, Time, Value};
use std::fmt::Write;

/// What a block does: inputs and outputs in the order of the pins, numbers as the host sees them.
struct Model {
    name: String,
    inputs: Vec<(&'static str, &'static str)>,
    outputs: Vec<(&'static str, &'static str)>,
    unit: i128,
    limits: (i128, i128),
    // State.
    last: [bool; 2],
    start: Option<i128>,
    done: bool,
    q: bool,
    cv: i128,
    et: i128,
}

impl Model {
    fn step(&mut self, now: i128, i: &[i128]) -> Vec<i128> {
        let on = |nth: usize| i[nth] != 0;
        let name = self.name.clone();
        let kind = name.split('_').next().unwrap().trim_start_matches('L');
        match kind {
            _ if self.name == "R_TRIG" => {
                let q = on(0) && !self.last[0];
                self.last[0] = on(0);
                vec![q.into()]
            }
            // Q is FALSE in a first call with FALSE (IEC 61131-8).
            _ if self.name == "F_TRIG" => {
                let q = !on(0) && self.last[0];
                self.last[0] = on(0);
                vec![q.into()]
            }
            "SR" => {
                self.q = on(0) || !on(1) && self.q;
                vec![self.q.into()]
            }
            "RS" => {
                self.q = !on(1) && (on(0) || self.q);
                vec![self.q.into()]
            }
            "TON" | "TOF" | "TP" => self.timer(kind, now, on(0), i[1]),
            "CTU" | "CTD" => {
                let edge = on(0) && !self.last[0];
                self.last[0] = on(0);
                if on(1) {
                    self.cv = if kind == "CTU" { 0 } else { i[2] };
                } else if edge {
                    let next = self.cv + if kind == "CTU" { 1 } else { -1 };
                    self.cv = next.clamp(self.limits.0, self.limits.1);
                }
                let q = if kind == "CTU" { self.cv >= i[2] } else { self.cv <= 0 };
                vec![q.into(), self.cv]
            }
            "CTUD" => {
                let edges = [on(0) && !self.last[0], on(1) && !self.last[1]];
                self.last = [on(0), on(1)];
                if on(2) {
                    self.cv = 0;
                } else if on(3) {
                    self.cv = i[4];
                } else if edges[0] != edges[1] {
                    let next = self.cv + if edges[0] { 1 } else { -1 };
                    self.cv = next.clamp(self.limits.0, self.limits.1);
                }
                vec![(self.cv >= i[4]).into(), (self.cv <= 0).into(), self.cv]
            }
            "RTC" => {
                if on(0) && !self.last[0] {
                    self.start = Some(now);
                    self.cv = i[1];
                }
                self.last[0] = on(0);
                let second = 1_000_000_000;
                let passed = self.start.map_or(0, |start| (now - start) / second * second);
                vec![on(0).into(), if on(0) { self.cv + passed } else { 0 }]
            }
            other => panic!("no model of {other}"),
        }
    }

    /// Elapsed time counts whole units from the call that started it.
    fn timer(&mut self, kind: &str, now: i128, on: bool, preset: i128) -> Vec<i128> {
        let reset = match kind {
            "TON" => !on,
            "TOF" => on,
            _ => !on && self.done,
        };
        if reset {
            (self.start, self.done, self.et) = (None, false, 0);
        } else if self.start.is_none() && (kind != "TOF" || self.q) && (kind != "TP" || on) {
            self.start = Some(now);
        }
        if let Some(start) = self.start.filter(|_| !self.done) {
            let elapsed = (now - start) / self.unit * self.unit;
            self.et = elapsed.min(preset);
            self.done = elapsed >= preset;
        }
        self.q = match kind {
            "TON" => self.done,
            "TOF" => on || self.start.is_some() && !self.done,
            _ => self.start.is_some() && !self.done,
        };
        // A pulse that ends while IN is FALSE is over at once.
        if kind == "TP" && self.done && !on {
            (self.start, self.done, self.et) = (None, false, 0);
        }
        vec![self.q.into(), self.et]
    }
}

fn models() -> Vec<Model> {
    let mut all = Vec::new();
    let mut add = |name: String, inputs, outputs, unit, limits| {
        let (last, start, done, q, cv, et) = ([false; 2], None, false, false, 0, 0);
        all.push(Model { name, inputs, outputs, unit, limits, last, start, done, q, cv, et });
    };
    add("R_TRIG".into(), vec![("CLK", "BOOL")], vec![("Q", "BOOL")], 1, (0, 0));
    add("F_TRIG".into(), vec![("CLK", "BOOL")], vec![("Q", "BOOL")], 1, (0, 0));
    add("SR".into(), vec![("SET1", "BOOL"), ("RESET", "BOOL")], vec![("Q1", "BOOL")], 1, (0, 0));
    add("RS".into(), vec![("SET", "BOOL"), ("RESET1", "BOOL")], vec![("Q1", "BOOL")], 1, (0, 0));
    add("RTC".into(), vec![("IN", "BOOL"), ("PDT", "DT")], vec![("Q", "BOOL"), ("CDT", "DT")], 1, (0, 0));
    for kind in ["TON", "TOF", "TP"] {
        for (name, ty, unit) in [
            (kind.to_string(), "TIME", 1_000_000),
            (format!("{kind}_TIME"), "TIME", 1_000_000),
            (format!("L{kind}"), "LTIME", 1),
            (format!("{kind}_LTIME"), "LTIME", 1),
        ] {
            add(name, vec![("IN", "BOOL"), ("PT", ty)], vec![("Q", "BOOL"), ("ET", ty)], unit, (0, 0));
        }
    }
    for (ending, ty, low, high) in [
        ("", "WORD", 0, 0xFFFF),
        ("_INT", "INT", -0x8000, 0x7FFF),
        ("_DINT", "DINT", -0x8000_0000, 0x7FFF_FFFF),
        ("_UDINT", "UDINT", 0, 0xFFFF_FFFF),
        ("_LINT", "LINT", i64::MIN.into(), i64::MAX.into()),
        ("_ULINT", "ULINT", 0, u64::MAX.into()),
    ] {
        // The controllers' names of the pins, and the standard's for the typed ones.
        let (reset, load) = if ending.is_empty() { ("RESET", "LOAD") } else { ("R", "LD") };
        let outputs = vec![("Q", "BOOL"), ("CV", ty)];
        let limits = (low, high);
        add(
            format!("CTU{ending}"),
            vec![("CU", "BOOL"), (reset, "BOOL"), ("PV", ty)],
            outputs.clone(),
            1,
            limits,
        );
        add(format!("CTD{ending}"), vec![("CD", "BOOL"), (load, "BOOL"), ("PV", ty)], outputs, 1, limits);
        let inputs = vec![("CU", "BOOL"), ("CD", "BOOL"), (reset, "BOOL"), (load, "BOOL"), ("PV", ty)];
        add(format!("CTUD{ending}"), inputs, vec![("QU", "BOOL"), ("QD", "BOOL"), ("CV", ty)], 1, limits);
    }
    all
}

/// Instances that are called in different ways, by their paths.
const WAYS: [&str; 7] = ["named", "placed", "told", "set", "list[1]", "inside.block", "kept"];

fn text(model: &Model) -> String {
    let name = &model.name;
    let mut text = String::from("FUNCTION_BLOCK wrap\nVAR_INPUT ");
    for (pin, ty) in &model.inputs {
        write!(text, "{pin} : {ty}; ").unwrap();
    }
    let joined = |form: &dyn Fn(&str) -> String| {
        model.inputs.iter().map(|(pin, _)| form(pin)).collect::<Vec<_>>().join(", ")
    };
    let named = joined(&|pin| format!("{pin} := {pin}"));
    let host = joined(&|pin| format!("{pin} := x_{pin}"));
    let placed = joined(&|pin| format!("x_{pin}"));
    write!(
        text,
        "END_VAR VAR block : {name}; END_VAR block({named}); END_FUNCTION_BLOCK\nPROGRAM MAIN\nVAR "
    )
    .unwrap();
    for (pin, ty) in &model.inputs {
        write!(text, "x_{pin} : {ty}; ").unwrap();
    }
    for (pin, ty) in &model.outputs {
        write!(text, "o_{pin} : {ty}; ").unwrap();
    }
    writeln!(
        text,
        "named, placed, told, set : {name}; list : ARRAY[0..2] OF {name}; inside : wrap; i : INT := 1; END_VAR
         VAR RETAIN kept : {name}; END_VAR
         named({host}); placed({placed}); list[i]({host}); inside({host}); kept({host});"
    )
    .unwrap();
    let outputs: Vec<String> = model.outputs.iter().map(|(pin, _)| format!("{pin} => o_{pin}")).collect();
    writeln!(text, "told({host}, {});", outputs.join(", ")).unwrap();
    for (pin, _) in &model.inputs {
        writeln!(text, "set.{pin} := x_{pin};").unwrap();
    }
    text + "set();\nEND_PROGRAM\n"
}

/// Nanoseconds passed, and what becomes of each input.
type Turn = (i64, u8);

fn run(mut model: Model, preset: i128, turns: &[Turn]) {
    let mut rig = Rig::new(&text(&model));
    for (pin, ty) in &model.inputs {
        if *ty != "BOOL" {
            let value = Value::Int(preset as i64);
            rig.write(&format!("x_{pin}"), value);
        }
    }
    for (nth, (passed, bits)) in turns.iter().enumerate() {
        rig.now += Span::from_nanos(*passed);
        let mut inputs = Vec::new();
        for (place, (pin, ty)) in model.inputs.iter().enumerate() {
            if *ty == "BOOL" {
                let on = bits >> place & 1 == 1;
                rig.write(&format!("x_{pin}"), Value::Bool(on));
                inputs.push(i128::from(on));
            } else {
                inputs.push(preset);
            }
        }
        rig.cycle();
        let now = i128::from((rig.now - Time::ZERO).as_nanos());
        let expected = model.step(now, &inputs);
        for ((pin, _), expected) in model.outputs.iter().zip(expected) {
            for way in WAYS {
                assert_eq!(
                    rig.int(&format!("{way}.{pin}")),
                    expected,
                    "{} {way}.{pin} turn {nth} {turns:?}",
                    model.name
                );
            }
            assert_eq!(rig.int(&format!("o_{pin}")), expected, "{}", model.name);
        }
        assert_eq!(rig.int(&format!("list[0].{}", model.inputs[0].0)), 0);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(6) })]

    #[test]
    fn blocks_agree_with_their_models(
        turns in prop::collection::vec((0i64..12_000_000, any::<u8>()), 40),
        // Inputs change only now and then.
        calm in any::<bool>(),
        preset in prop::sample::select(vec![0i128, 1, 3, 20]),
    ) {
        let mut bits = 0;
        let turns: Vec<Turn> = turns
            .into_iter()
            .map(|(passed, random)| {
                bits = if calm && random & 0xE0 != 0 { bits } else { random };
                // Resets and loads are rare.
                (passed, if calm { bits & 0b0_0011 | bits & random >> 3 & 0b1_1100 } else { bits })
            })
            .collect();
        for model in models() {
            // Of times, in nanoseconds: whole units; of dates, whole seconds.
            let unit = match model.name.as_str() {
                name if name.contains("CT") => 1,
                "RTC" => 1_000_000_000,
                _ => 1_000_000,
            };
            run(model, preset * unit, &turns);
        }
    }
}

#[test]
fn there_is_a_model_of_every_block() {
    let known: Vec<String> = models().into_iter().map(|model| model.name).collect();
    for native in STANDARD {
        assert!(known.iter().any(|name| name == native.name), "{}", native.name);
    }
    assert_eq!(known.len(), STANDARD.len());
}

#[test]
fn counters_stop_at_the_limits_of_their_type() {
    // IEC 61131-3, table 45: CV counts while it is below PVmax and above PVmin.
    for (ty, low, high) in
        [("", 0, 0xFFFF_i64), ("_INT", -0x8000, 0x7FFF), ("_DINT", i32::MIN.into(), i32::MAX.into())]
    {
        let mut rig = Rig::new(&format!(
            "PROGRAM MAIN VAR up : CTU{ty}; down : CTD{ty}; both : CTUD{ty}; x : BOOL; END_VAR
             up(CU := x, PV := 5); down(CD := x, PV := 5); both(CU := x, PV := 5); x := NOT x; END_PROGRAM"
        ));
        rig.write("up.CV", Value::Int(high - 1));
        rig.write("both.CV", Value::Int(high - 1));
        rig.write("down.CV", Value::Int(low + 1));
        for _ in 0..8 {
            rig.cycle();
        }
        assert_eq!(
            (rig.int("up.CV"), rig.int("down.CV"), rig.int("both.CV")),
            (high.into(), low.into(), high.into()),
            "{ty}"
        );
        assert!(rig.on("up.Q") && rig.on("down.Q") && rig.on("both.QU") && !rig.on("both.QD"));
    }
}

#[test]
fn retained_instances_go_on_after_a_restart() {
    // controller:REM-02
    let mut rig = Rig::new(
        "PROGRAM MAIN VAR lost : CTU; x : BOOL; END_VAR VAR RETAIN kept : CTU; t : TON; END_VAR
         x := NOT x; lost(CU := x, PV := 3); kept(CU := x, PV := 3); t(IN := TRUE, PT := T#50ms); END_PROGRAM",
    );
    for _ in 0..3 {
        rig.cycle();
    }
    assert_eq!((rig.int("lost.CV"), rig.int("kept.CV")), (2, 2));
    assert_eq!(rig.machine.program().find("kept.CV").unwrap().retention, Retention::Retain);
    rig.machine.reset(true, true);
    assert_eq!((rig.int("lost.CV"), rig.int("kept.CV"), rig.int("kept.PV")), (0, 2, 3));
    rig.now += Span::from_millis(50);
    rig.cycle();
    // The edge was seen before; the timer ran on.
    assert_eq!((rig.int("lost.CV"), rig.int("kept.CV")), (1, 2));
    assert!(rig.on("t.Q"));
    rig.machine.reset(false, false);
    assert_eq!((rig.int("kept.CV"), rig.int("t.ET")), (0, 0));
}

#[test]
fn other_names_of_pins_and_wrong_ones() {
    let with = |declarations: &str, call: &str| {
        codes(&format!("PROGRAM MAIN VAR {declarations} b : BOOL; n : INT; END_VAR {call} END_PROGRAM"))
    };
    for (ty, call) in [
        ("CTU", "x(CU := b, R := b, PV := 3);"),
        ("CTU_INT", "x(CU := b, RESET := b, PV := 3);"),
        ("CTD", "x(CD := b, LD := b, PV := 3);"),
        ("SR", "x(S1 := b, R := b, Q1 => b);"),
        ("RS", "x(S := b, R1 := b);"),
        ("TON", "x();"),
        ("TON", "x(PT := T#1s, IN := b);"),
        ("TON", "x(b);"),
        ("TON", "x(IN := b, Q => , ET => );"),
        ("TON", "x(IN := b, NOT Q => b);"),
        ("CTU_DINT", "x(CU := b, PV := n);"),
    ] {
        assert_eq!(with(&format!("x : {ty};"), call), Vec::<&str>::new(), "{ty} {call}");
    }
    for (call, code) in [
        ("x(IN := 5);", "S0302"),
        ("x(PT := 5);", "S0302"),
        ("x(LIMIT := b);", "S0406"),
        ("x(START := 5);", "S0406"),
        ("x(IN := b, IN := b);", "S0407"),
        ("x(b, T#1s, T#2s);", "S0407"),
        ("x.Q := TRUE;", "S0401"),
        ("n := x.START;", "S0301"),
        ("b := x;", "S0307"),
        ("x := x;", "S0307"),
    ] {
        assert_eq!(with("x : TON;", call), [code], "{call}");
    }
    // A BOOL takes the numbers 0 and 1.
    assert_eq!(with("x : TON;", "x(IN := 1);"), Vec::<&str>::new());
}
