//! A rig made by hand: a lamp and a level, two tasks, a counter and a pulse generator, two buses, a plan that runs.

use crate::model::RigModel;
use crate::recording::{RecordedChange, RecordedSignal, TrendRecording};
use control::{
    BusInfo, BusStatus, ChannelInfo, Description, FrameSeen, FunctionInfo, Measured, PlanEvent, PlanStatus,
    PointDirection, PointInfo, RigStatus, Signal, SignalKind, Status, TaskInfo, TaskStatus, Value, WireValue,
};

const MS: i64 = 1_000_000;

fn texts(pairs: &[(&str, &str)]) -> Vec<(String, String)> {
    pairs.iter().map(|(a, b)| ((*a).to_owned(), (*b).to_owned())).collect()
}

pub fn model() -> RigModel {
    let mut model =
        RigModel { description: description(), status: status(), now: 10_000 * MS, ..RigModel::default() };
    let values = [
        ("HSC0.CurrentValue", Value::Int(-123_456)),
        ("HSC0.Run", Value::Bool(true)),
        ("HSC0.Frequency", Value::Measured(49_998.25, 12.5)),
        ("HSC0.State", Value::Int(2)),
        ("PTO0.Position", Value::Int(80_000)),
        ("PTO0.Velocity", Value::Real(12_500.0)),
    ];
    model.values = values.into_iter().map(|(name, value)| (name.to_owned(), (0, WireValue(value)))).collect();
    model.frames = frames().into();
    model.plan = plan();
    let plans = ["library/outputs/retriggered", "library/watchdog/overrun", "lamp/blinks", "lamp/holds"];
    model.plans = Some(plans.map(str::to_owned).to_vec());
    model
}

fn description() -> Description {
    let signal = |name: &str, kind, unit: &str, labels: &[(i64, &str)]| Signal {
        number: 0,
        name: name.to_owned(),
        kind,
        unit: unit.to_owned(),
        labels: labels.iter().map(|(n, label)| (*n, (*label).to_owned())).collect(),
        writable: false,
    };
    let task = |name: &str, kind: &str, interval, priority, watchdog, programs: &[&str]| TaskInfo {
        name: name.to_owned(),
        kind: kind.to_owned(),
        interval,
        priority,
        watchdog,
        programs: programs.iter().map(|name| (*name).to_owned()).collect(),
    };
    let point =
        |name: &str, address: &str, variable: Option<&str>, direction, channel: Option<&str>| PointInfo {
            name: name.to_owned(),
            address: Some(address.to_owned()),
            variable: variable.map(str::to_owned),
            direction,
            kind: SignalKind::Bool,
            channel: channel.map(|name| ChannelInfo {
                name: name.to_owned(),
                unit: String::new(),
                device: None,
                drives: false,
            }),
            image: Some(address.to_owned()),
            forcible: true,
            writable: false,
            scale: None,
        };
    let bus = |name: &str, kind: &str, settings: &str| BusInfo {
        name: name.to_owned(),
        kind: kind.to_owned(),
        settings: settings.to_owned(),
        ..BusInfo::default()
    };
    let function = |name: &str, kind: &str, facts: &[&str], terminals: &[&str]| FunctionInfo {
        name: name.to_owned(),
        kind: kind.to_owned(),
        signals: facts.iter().map(|fact| format!("{name}.{fact}")).collect(),
        terminals: terminals.iter().map(|name| (*name).to_owned()).collect(),
    };
    Description {
        board: "boards/bench.toml".to_owned(),
        reference: "TM241CEC24T".to_owned(),
        points: vec![
            point("I1", "%IX0.1", Some("start"), PointDirection::Input, Some("button")),
            point("Q4", "%QX0.4", Some("lamp"), PointDirection::Output, None),
        ],
        signals: vec![
            signal("lamp", SignalKind::Bool, "", &[]),
            signal("level", SignalKind::Real, "mm", &[]),
            signal("state", SignalKind::State, "", &[(0, "IDLE"), (1, "FILLING"), (2, "FULL")]),
            signal("HSC0.State", SignalKind::State, "", &[(1, "STOPPED"), (2, "COUNTING")]),
            signal("HSC0.Frequency", SignalKind::Real, "Hz", &[]),
        ],
        tasks: vec![
            task("MAST", "cyclic", 20 * MS, 15, Some(100 * MS), &["Main", "Alarms"]),
            task("FAST", "cyclic", 2 * MS, 1, Some(5 * MS), &["Edges"]),
            task("Free", "freewheeling", 0, 31, None, &["Report"]),
        ],
        functions: vec![
            function(
                "HSC0",
                "HSC main, dual phase x4",
                &["CurrentValue", "Run", "Frequency", "State", "Modulo"],
                &["I0", "I1"],
            ),
            function("PTO0", "PTO", &["Position", "Velocity", "Busy"], &["Q0", "Q1"]),
        ],
        buses: vec![bus("drive", "can", "500 kbit/s"), bus("scale", "serial", "19200 8E1")],
        load_limit: 850,
        ..Description::default()
    }
}

fn status() -> Status {
    let borders = [10_000, 20_000, 50_000, 100_000, 200_000, 500_000, MS, i64::MAX];
    let counts = |counts: [u64; 8]| borders.into_iter().zip(counts).collect();
    Status {
        at: 10_000 * MS,
        state: "RUNNING".to_owned(),
        load: 423,
        tasks: vec![
            TaskStatus {
                cycles: 500,
                last: 5_120_000,
                min: 4_980_000,
                mean: 5_100_345,
                max: 7_250_000,
                jitter: 12_000,
                jitter_min: 0,
                jitter_max: 180_000,
                jitter_counts: counts([312, 120, 40, 20, 8, 0, 0, 0]),
                load: 255,
                ..TaskStatus::default()
            },
            TaskStatus {
                cycles: 5_000,
                last: 310_000,
                min: 300_000,
                mean: 335_000,
                max: 4_600_000,
                jitter_max: 90_000,
                jitter_counts: counts([4_800, 150, 40, 10, 0, 0, 0, 0]),
                load: 168,
                overruns: 2,
                lost: 1,
                ..TaskStatus::default()
            },
            TaskStatus::default(),
        ],
        buses: vec![
            BusStatus {
                state: "error-active".to_owned(),
                received: 12_345,
                sent: 678,
                errors: 0,
                dropped: 0,
            },
            BusStatus { state: "open".to_owned(), received: 88, sent: 0, errors: 3, dropped: 0 },
        ],
        rig: RigStatus {
            late_counts: counts([0, 9_000, 700, 30, 4, 0, 0, 1]),
            realtime: true,
            ..RigStatus::default()
        },
        plan: Some(PlanStatus { name: "lamp".to_owned(), case: "lamp/holds".to_owned(), place: (2, 4) }),
        ..Status::default()
    }
}

fn frames() -> Vec<FrameSeen> {
    let frame = |bus: &str, at: i64, sent, id: &str, flags: &[&str], data: &str| FrameSeen {
        bus: bus.to_owned(),
        at: at * MS,
        sent,
        id: id.to_owned(),
        flags: flags.iter().map(|flag| (*flag).to_owned()).collect(),
        data: data.to_owned(),
    };
    let mut frames = Vec::new();
    for n in 0..4 {
        frames.push(frame("drive", 9_000 + n * 200, false, "18F", &[], &format!("0{n}FF00A5")));
        frames.push(frame("drive", 9_010 + n * 200, true, "18FF50E5", &[], "0011223344556677"));
    }
    frames.push(frame("scale", 9_900, false, "", &[], "2B30312E352067"));
    frames.push(frame("scale", 9_910, false, "", &["parity"], "0D0A"));
    frames.push(frame("drive", 9_920, false, "7E8", &["fd", "brs"], "48656C6C6F"));
    frames.push(frame("drive", 9_930, false, "7DF", &["remote"], ""));
    frames
}

fn plan() -> Vec<PlanEvent> {
    let measured = |name: &str, value, low, high, unit: &str, verdict: &str| Measured {
        name: name.to_owned(),
        value,
        low,
        high,
        unit: unit.to_owned(),
        verdict: verdict.to_owned(),
    };
    let word = str::to_owned;
    vec![
        PlanEvent::Case {
            name: word("lamp/blinks"),
            place: (1, 4),
            steps: texts(&[("press", "set start to TRUE at 1 s"), ("let-go", "set start to FALSE at 2 s")]),
            claims: texts(&[("on", "lamp rises within 500 ms .. 550 ms from press"), ("off", "lamp falls")]),
        },
        PlanEvent::Step { step: 0, at: 1_000 * MS, done: true },
        PlanEvent::Step { step: 1, at: 2_000 * MS, done: true },
        PlanEvent::Verdict {
            name: word("lamp/blinks"),
            verdict: word("fail"),
            reason: word("`on` does not hold"),
            claims: vec![
                (word("on"), word("fail"), word("it rose 562.1 ms after press")),
                (word("off"), word("pass"), String::new()),
            ],
            measured: vec![
                measured("delay", Some((562.1, 562.3)), Some(500.0), Some(550.0), "ms", "fail"),
                measured("period", Some((1_000.0, 1_000.0)), Some(990.0), Some(1_010.0), "ms", "pass"),
                measured("current", None, None, Some(0.5), "A", "inconclusive"),
            ],
        },
        PlanEvent::Case {
            name: word("lamp/holds"),
            place: (2, 4),
            steps: texts(&[("press", "set start to TRUE at 1 s"), ("wait", "wait 60 s"), ("end", "ends")]),
            claims: texts(&[("holds", "lamp stays TRUE")]),
        },
        PlanEvent::Step { step: 0, at: 1_000 * MS, done: true },
        PlanEvent::Step { step: 1, at: 1_000 * MS, done: false },
    ]
}

/// Ten seconds of the signals.
pub fn changes() -> Vec<(&'static str, i64, WireValue)> {
    let mut changes: Vec<(&str, i64, Value)> = Vec::new();
    for n in 0..10 {
        changes.push(("lamp", 200 + n * 1_000, Value::Bool(true)));
        changes.push(("lamp", 700 + n * 1_000, Value::Bool(n == 6)));
    }
    for n in 0..200 {
        // A saw that falls faster than it rises.
        let (rest, turn) = (n % 50, n / 50);
        let level = if rest < 40 { rest as f64 / 8.0 } else { (50 - rest) as f64 / 2.0 };
        changes.push(("level", 10 + n * 50, Value::Real(level + turn as f64 / 10.0)));
    }
    for (at, state) in [(100, 0), (2_500, 1), (6_000, 2), (6_100, 1), (9_000, 0)] {
        changes.push(("state", at, Value::Int(state)));
    }
    changes.push(("%IX0.1", 3_000, Value::Bool(false)));
    changes.push(("%IX0.1", 5_000, Value::HighZ));
    changes.push(("%IX0.1", 7_000, Value::Bool(true)));
    changes.sort_by_key(|(_, at, _)| *at);
    changes.into_iter().map(|(name, at, value)| (name, at * MS, WireValue(value))).collect()
}

/// A recording of another day.
pub fn recording() -> TrendRecording {
    let track = |name: &str, unit: &str, kind| RecordedSignal {
        name: name.to_owned(),
        unit: unit.to_owned(),
        kind,
        labels: Vec::new(),
    };
    let samples = (0..100).map(|n| RecordedChange {
        track: usize::from(n % 2 == 1),
        when: (n * MS, n * MS),
        value: WireValue(if n % 2 == 1 { Value::Bool(n % 4 == 1) } else { Value::Int(n * n) }),
    });
    TrendRecording {
        tracks: vec![track("speed", "1/min", SignalKind::Int), track("pump", "", SignalKind::Bool)],
        samples: samples.collect(),
        span: (0, 100 * MS),
    }
}
