//! From the last snapshot to a status, with what the scan need not know: how the machine under the rig fares.

use super::describe::DeviceTable;
use crate::scan_port::{BusCounts, LineCounts, Snapshot, counts};
use control::{
    BusInfo, BusStatus, Description, DeviceStatus, ForcedPoint, LedStatus as Lit, ModuleInfo, PointStatus,
    RigStatus, Status, StatusWarning, TaskStatus, WireValue,
};
use controller::{ForcedChannels, FrontPanel, JitterCounts, Led, LedPattern, TaskFigures};
use drivers::BusState;
use host::HostMachine;
use signal::{Address, Area, Size, Span, Time, Value};
use std::time::{Duration, Instant};

/// From one look at the machine to the next.
const LOOK: Duration = Duration::from_secs(2);

/// Nanoseconds of load that are one per mille of a second.
const PER_MILLE: i64 = 1_000_000;

/// What a status is made of.
#[derive(Debug)]
pub struct StatusSource {
    snapshot: Box<Snapshot>,
    devices: DeviceTable,
    /// The channel behind each point.
    channels: Vec<Option<usize>>,
    /// Since when each indicator shows what it shows, and what.
    leds: [(LedPattern, Time); Led::ALL.len()],
    /// Lines are real ones: how punctual the rig is matters.
    real: bool,
    /// Its threads have real-time priority.
    realtime: bool,
    throttle: Throttle,
}

impl StatusSource {
    /// Of a board with these devices.
    pub fn new(
        snapshot: Snapshot,
        devices: DeviceTable,
        channels: Vec<Option<usize>>,
        real: bool,
        realtime: bool,
    ) -> StatusSource {
        StatusSource {
            snapshot: Box::new(snapshot),
            devices,
            channels,
            leds: [(LedPattern::Off, Time::ZERO); Led::ALL.len()],
            real,
            realtime,
            throttle: Throttle::new(HostMachine::here()),
        }
    }

    /// Takes a newer snapshot in place of the one before, which goes back.
    pub fn take(&mut self, snapshot: Box<Snapshot>) -> Option<Box<Snapshot>> {
        if let Some(FrontPanel { leds, since, .. }) = &snapshot.front {
            for (known, pattern) in self.leds.iter_mut().zip(leds) {
                let at = if pattern.times().is_some() { *since } else { snapshot.at };
                if known.0 != *pattern {
                    *known = (*pattern, at);
                }
            }
        }
        Some(std::mem::replace(&mut self.snapshot, snapshot))
    }

    /// Looks at the machine, now and then.
    pub fn look_at_host(&mut self) {
        if self.real {
            self.throttle.look();
        }
    }

    /// How the rig is.
    pub fn status(&self, description: &Description) -> Status {
        let now = &*self.snapshot;
        let load = now.tasks.iter().map(|(figures, _)| figures.load.as_nanos()).sum::<i64>() / PER_MILLE;
        let line = |channel: &Option<usize>| channel.and_then(|channel| now.lines.get(channel));
        Status {
            at: now.at.as_nanos(),
            state: now.state.name().into(),
            leds: self.leds(),
            switch: now.front.is_some_and(|front| front.switch),
            power: now.front.is_some_and(|front| front.supply),
            tasks: now.tasks.iter().map(|(figures, jitter)| task(figures, jitter)).collect(),
            load: u32::try_from(load).unwrap_or(0),
            forced: now.front.map_or_else(Vec::new, |front| forced(&front)),
            points: self
                .channels
                .iter()
                .map(|channel| line(channel).map_or_else(Default::default, point))
                .collect(),
            devices: self.devices(),
            buses: now.buses.iter().zip(&description.buses).map(|(counts, info)| bus(counts, info)).collect(),
            modules: now.front.map_or_else(Vec::new, |front| {
                let state = |module: &ModuleInfo| front.modules.get(usize::from(module.index));
                let named = |module| state(module).map_or("", |state| state.name()).to_owned();
                description.modules.iter().map(named).collect()
            }),
            rig: RigStatus {
                late_max: now.late.as_nanos(),
                late_outputs: now.late_outputs.as_nanos(),
                late_counts: counts(&now.wakes),
                overruns: now.overruns,
                dropped: now.health.dropped,
                untold: now.untold,
                realtime: self.realtime,
                latched_safe: now.health.latched_safe,
            },
            troubles: self.troubles(description),
            ..Status::default()
        }
    }

    fn leds(&self) -> Vec<Lit> {
        let led = |(led, (pattern, since)): (Led, (LedPattern, Time))| Lit {
            name: led.name().into(),
            pattern: pattern.name().into(),
            times: pattern.times().map(|(lit, dark)| (lit.as_nanos(), dark.as_nanos())),
            since: since.as_nanos(),
        };
        Led::ALL.into_iter().zip(self.leds).map(led).collect()
    }

    /// Why a device does not work: one of its channels or buses is lost.
    fn devices(&self) -> Vec<DeviceStatus> {
        let of = |place: usize| {
            let behind =
                |devices: &[Option<usize>], at: usize| devices.get(at).copied().flatten() == Some(place);
            let mut lines = self.snapshot.lines.iter().enumerate();
            let line =
                lines.find_map(|(at, line)| line.lost.filter(|_| behind(&self.devices.of_channels, at)));
            let mut buses = self.snapshot.buses.iter().enumerate();
            let bus = || buses.find_map(|(at, bus)| bus.lost.filter(|_| behind(&self.devices.of_buses, at)));
            let lost = line.or_else(bus);
            DeviceStatus {
                sound: lost.is_none(),
                why: lost.map_or_else(String::new, |reason| reason.to_string()),
            }
        };
        (0..self.devices.list.len()).map(of).collect()
    }

    fn troubles(&self, description: &Description) -> Vec<StatusWarning> {
        let now = &*self.snapshot;
        let mut found = Vec::new();
        let mut add = |kind: &str, text: String| found.push(StatusWarning { kind: kind.into(), text });
        if self.real && !self.realtime {
            let text = "the rig runs without real-time priority: any program can hold it up";
            add("no-realtime", text.into());
        }
        if let Some(text) = self.throttle.found.as_ref().filter(|_| self.real) {
            add("throttled", text.clone());
        }
        let missed = now.health.dropped + now.buses.iter().map(|bus| bus.dropped).sum::<u64>();
        if missed > 0 {
            add("dropped", format!("{missed} events of the board were missed"));
        }
        if self.real && now.overruns > 0 {
            let late = Span::from_nanos(now.late.as_nanos());
            add("overrun", format!("the rig was late {} times, by {late} at worst", now.overruns));
        }
        for (device, info) in self.devices().iter().zip(&description.devices) {
            if !device.sound {
                add("lost", format!("{} {}", info.name, device.why));
            }
        }
        if now.untold > 0 {
            add("untold", format!("{} changes came faster than they could be reported", now.untold));
        }
        found
    }
}

fn task(figures: &TaskFigures, jitter: &JitterCounts) -> TaskStatus {
    TaskStatus {
        cycles: figures.cycles,
        last: figures.last.as_nanos(),
        min: figures.min.as_nanos(),
        mean: figures.mean().as_nanos(),
        max: figures.max.as_nanos(),
        jitter: figures.jitter.as_nanos(),
        jitter_min: figures.min_jitter.as_nanos(),
        jitter_max: figures.max_jitter.as_nanos(),
        jitter_counts: counts(jitter),
        load: u32::try_from(figures.load.as_nanos() / PER_MILLE).unwrap_or(0),
        overruns: figures.overruns,
        lost: figures.lost,
        watchdogs: figures.exceptions,
    }
}

fn forced(front: &FrontPanel) -> Vec<ForcedPoint> {
    let of = |area: Area, channels: ForcedChannels| {
        channels.iter().map(move |(channel, on)| ForcedPoint {
            address: Address::bit(area, channel as u32).to_string(),
            value: WireValue(Value::Bool(on)),
            by: None,
        })
    };
    let of_modules = front.forced_places.iter().map(|(address, value)| ForcedPoint {
        address: address.to_string(),
        value: WireValue(match address.size() {
            Size::Bit => Value::Bool(value != 0),
            _ => Value::Word(value),
        }),
        by: None,
    });
    let embedded = of(Area::Input, front.forced_inputs).chain(of(Area::Output, front.forced_outputs));
    embedded.chain(of_modules).collect()
}

fn point(line: &LineCounts) -> PointStatus {
    PointStatus { rising: line.rising, falling: line.falling, lost: line.lost.is_some() }
}

fn bus(traffic: &BusCounts, info: &BusInfo) -> BusStatus {
    let state = match (traffic.lost, traffic.state) {
        (Some(_), _) => "lost",
        // The other states are those of a CAN controller.
        (None, _) if info.kind == "serial" => "open",
        (None, BusState::ErrorActive) => "error-active",
        (None, BusState::ErrorWarning) => "error-warning",
        (None, BusState::ErrorPassive) => "error-passive",
        (None, BusState::BusOff) => "bus-off",
        (None, BusState::Stopped) => "stopped",
    };
    BusStatus {
        state: state.into(),
        received: traffic.received,
        sent: traffic.sent,
        errors: traffic.errors,
        dropped: traffic.dropped,
    }
}

/// Whether the machine makes its processors slower than they can be.
#[derive(Debug)]
struct Throttle {
    machine: HostMachine,
    looked: Option<Instant>,
    /// How often they had been throttled when the rig began.
    before: Option<u64>,
    found: Option<String>,
}

impl Throttle {
    fn new(machine: HostMachine) -> Throttle {
        Throttle { machine, looked: None, before: None, found: None }
    }

    fn look(&mut self) {
        if self.looked.is_some_and(|looked| looked.elapsed() < LOOK) {
            return;
        }
        self.looked = Some(Instant::now());
        self.found = self.count().or_else(|| self.limit()).or_else(|| self.firmware());
    }

    /// Times that a processor was throttled because it was hot, since the rig began.
    fn count(&mut self) -> Option<String> {
        let folders = self.machine.list("/sys/devices/system/cpu", "cpu");
        let count = |folder: &String| {
            let path = format!("/sys/devices/system/cpu/{folder}/thermal_throttle/core_throttle_count");
            self.machine.read(&path)?.trim().parse::<u64>().ok()
        };
        let all = folders.iter().filter_map(count).sum::<u64>();
        let times = all.saturating_sub(*self.before.get_or_insert(all));
        (times > 0).then(|| format!("the processors were throttled {times} times: they are too hot"))
    }

    /// A processor that may not run as fast as it could.
    fn limit(&self) -> Option<String> {
        let folders = self.machine.list("/sys/devices/system/cpu/cpufreq", "policy");
        folders.iter().find_map(|folder| {
            let figure = |name: &str| {
                let path = format!("/sys/devices/system/cpu/cpufreq/{folder}/{name}");
                self.machine.read(&path)?.trim().parse::<u64>().ok()
            };
            let (may, can) = (figure("scaling_max_freq")?, figure("cpuinfo_max_freq")?);
            (may < can).then(|| format!("the processors may run at {may} kHz only, not at {can} kHz"))
        })
    }

    /// What the firmware of a Raspberry Pi says: bit 0 too little voltage, 1 and 2 slowed down, 3 warm.
    fn firmware(&self) -> Option<String> {
        let text = self.machine.read("/sys/devices/platform/soc/soc:firmware/get_throttled")?;
        let bits = u32::from_str_radix(text.trim().trim_start_matches("0x"), 16).ok()?;
        match bits & 0xF {
            0 => None,
            bits if bits & 1 != 0 => Some("the supply of the board is too weak: it is slowed down".into()),
            _ => Some("the board is too hot: it is slowed down".into()),
        }
    }
}
