//! A rig with something of everything.

use crate::setup::ScriptedRig;
use control::*;

const MS: i64 = 1_000_000;
const SECOND: i64 = 1_000 * MS;

fn point(name: &str, address: Option<&str>, variable: Option<&str>, kind: SignalKind) -> PointInfo {
    let direction = match address {
        Some(address) if address.starts_with("%I") => PointDirection::Input,
        Some(_) => PointDirection::Output,
        None => PointDirection::Loose,
    };
    let unit = if kind == SignalKind::Bool { "" } else { "V" };
    PointInfo {
        name: name.to_owned(),
        address: address.map(str::to_owned),
        variable: variable.map(str::to_owned),
        direction,
        kind,
        channel: Some(ChannelInfo {
            name: format!("line-{}", name.to_lowercase()),
            unit: unit.to_owned(),
            device: Some(usize::from(kind != SignalKind::Bool)),
            drives: direction != PointDirection::Output,
        }),
        image: address.map(str::to_owned),
        forcible: address.is_some() && kind == SignalKind::Bool,
        writable: false,
        scale: (kind == SignalKind::Real).then(|| WordScale {
            words: [0.0, 10_000.0],
            values: [0.0, 10.0],
            unit: "V".to_owned(),
        }),
    }
}

fn signal(number: u32, name: &str, kind: SignalKind, unit: &str) -> Signal {
    let labels = if kind == SignalKind::State {
        vec![(0, "EMPTY".to_owned()), (1, "STOPPED".to_owned()), (2, "RUNNING".to_owned())]
    } else {
        Vec::new()
    };
    let writable = kind != SignalKind::State;
    Signal { number, name: name.to_owned(), kind, unit: unit.to_owned(), labels, writable }
}

fn led(name: &str, pattern: &str, times: Option<(i64, i64)>) -> LedStatus {
    LedStatus { name: name.to_owned(), pattern: pattern.to_owned(), times, since: 0 }
}

fn task(interval: i64, priority: u8, name: &str) -> TaskInfo {
    TaskInfo {
        name: name.to_owned(),
        kind: "cyclic".to_owned(),
        interval,
        priority,
        watchdog: Some(10 * interval),
        programs: vec![format!("{name}_prg")],
    }
}

fn points() -> Vec<PointInfo> {
    let mut points = Vec::new();
    for n in 0..14 {
        let variable = ["start", "stop", "part", "gate"].get(n).copied();
        let address = format!("%IX{}.{}", n / 8, n % 8);
        points.push(point(&format!("I{n}"), Some(&address), variable, SignalKind::Bool));
    }
    for n in 0..10 {
        let variable = ["motor", "lamp"].get(n).copied();
        let address = format!("%QX{}.{}", n / 8, n % 8);
        points.push(point(&format!("Q{n}"), Some(&address), variable, SignalKind::Bool));
    }
    points.push(point("AI0", Some("%IW10"), Some("level"), SignalKind::Real));
    points.push(point("spare", None, None, SignalKind::Bool));
    points
}

/// What it is.
pub fn description() -> Description {
    Description {
        board: "boards/conveyor.toml".to_owned(),
        reference: "TM241CEC24T".to_owned(),
        profile: "m241-2024".to_owned(),
        program: vec!["conveyor.st".to_owned()],
        clock: TimeSource::Real,
        subject: SubjectKind::Model,
        points: points(),
        signals: vec![
            signal(100, "state", SignalKind::State, ""),
            signal(101, "main.count", SignalKind::Int, ""),
            signal(102, "main.speed", SignalKind::Real, "m/s"),
            signal(103, "HSC0.value", SignalKind::Int, ""),
        ],
        tasks: vec![task(10 * MS, 1, "mast"), task(50 * MS, 15, "slow")],
        functions: vec![FunctionInfo {
            name: "HSC0".to_owned(),
            kind: "HSC main, dual phase x4".to_owned(),
            signals: vec!["HSC0.value".to_owned()],
            terminals: vec!["I0".to_owned(), "I1".to_owned()],
        }],
        buses: vec![
            BusInfo {
                name: "can0".to_owned(),
                kind: "can".to_owned(),
                settings: "500 kbit/s".to_owned(),
                ..BusInfo::default()
            },
            BusInfo {
                name: "line".to_owned(),
                kind: "serial".to_owned(),
                settings: "19200 8E1".to_owned(),
                ..BusInfo::default()
            },
        ],
        modules: Vec::new(),
        devices: vec![
            DeviceInfo {
                name: "lines".to_owned(),
                kind: "gpio".to_owned(),
                path: "/dev/gpiochip0".to_owned(),
            },
            DeviceInfo { name: "adc".to_owned(), kind: "spi".to_owned(), path: "/dev/spidev0.0".to_owned() },
        ],
        on_disconnect: "keep".to_owned(),
        load_limit: 850,
    }
}

/// How it is.
pub fn status() -> Status {
    let counts = vec![(10_000, 12), (20_000, 840), (50_000, 96), (100_000, 4), (i64::MAX, 0)];
    let mast = TaskStatus {
        cycles: 952,
        last: 1_220_000,
        min: 1_180_000,
        mean: 1_214_000,
        max: 1_530_000,
        jitter: 15_000,
        jitter_min: 4_000,
        jitter_max: 81_000,
        jitter_counts: counts.clone(),
        load: 122,
        ..TaskStatus::default()
    };
    let slow = TaskStatus { cycles: 190, last: 9 * MS, overruns: 2, load: 180, ..mast.clone() };
    let on = |on| WireValue(Value::Bool(on));
    let forced = |address: &str, value| ForcedPoint {
        address: address.to_owned(),
        value,
        by: Some("rig dash".to_owned()),
    };
    let mut points = vec![PointStatus::default(); points().len()];
    points[2] = PointStatus { rising: 37, falling: 36, lost: false };
    points[14] = PointStatus { rising: 5, falling: 4, lost: false };
    points[24].lost = true;
    Status {
        at: 9_520 * MS,
        state: "RUNNING".to_owned(),
        leds: vec![
            led("PWR", "on", None),
            led("RUN", "on", None),
            led("ERR", "off", None),
            led("I/O", "regular-flash", Some((SECOND / 2, SECOND / 2))),
            led("CAN R", "on", None),
            led("CAN E", "off", None),
        ],
        switch: true,
        power: true,
        tasks: vec![mast, slow],
        load: 302,
        forced: vec![forced("%QX0.1", on(true)), forced("%IX0.3", on(false))],
        points,
        devices: vec![
            DeviceStatus { sound: true, why: String::new() },
            DeviceStatus { sound: false, why: "gives no sign of life for 200 ms".to_owned() },
        ],
        buses: vec![
            BusStatus { state: "error-active".to_owned(), received: 1_204, sent: 87, errors: 1, dropped: 0 },
            BusStatus { state: "open".to_owned(), received: 512, sent: 64, errors: 0, dropped: 0 },
        ],
        modules: Vec::new(),
        rig: RigStatus { late_max: 81_000, late_counts: counts, realtime: true, ..RigStatus::default() },
        troubles: vec![StatusWarning {
            kind: "lost".to_owned(),
            text: "the device `adc` is lost: it gives no sign of life for 200 ms".to_owned(),
        }],
        locked: None,
        plan: None,
        clients: 2,
    }
}

/// The whole rig.
pub fn rig() -> ScriptedRig {
    let description = description();
    let mut rig = ScriptedRig { status: status(), ..ScriptedRig::default() };
    for (place, point) in description.points.iter().enumerate() {
        let on = WireValue(Value::Bool(matches!(place, 0 | 2 | 14 | 15)));
        let (image, line) = match point.kind {
            SignalKind::Bool => (on, on),
            _ => (WireValue(Value::Int(16_384)), WireValue(Value::Measured(5.0, 0.01))),
        };
        if let Some(name) = &point.image {
            rig.signals.insert(name.clone(), (SECOND, image));
        }
        if let Some(channel) = &point.channel {
            rig.signals.insert(channel.name.clone(), (SECOND, line));
        }
    }
    for (signal, value) in
        description.signals.iter().zip([Value::Int(2), Value::Int(37), Value::Real(0.25), Value::Int(14_820)])
    {
        rig.signals.insert(signal.name.clone(), (SECOND, WireValue(value)));
    }
    rig.log = [(0, "ready"), (1_200, "RUNNING"), (9_400, "the device `adc` is lost")]
        .map(|(at, text)| RigLogLine { at: at * MS, text: text.to_owned() })
        .to_vec();
    rig.plans = vec!["lamp".to_owned(), "conveyor/start".to_owned(), "conveyor/stop".to_owned()];
    rig.description = description;
    rig
}
