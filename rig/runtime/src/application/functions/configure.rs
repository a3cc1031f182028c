//! Expert functions of a plan's settings as the controller takes them, and what it refuses of them.

use super::axis;
use crate::codes;
use controller::Config;
use document::Diagnostic;
use expert::{
    CaptureInput, ChannelRole, CounterConfig, CounterFault, CounterKind, CounterMode, CounterRole,
    ExpertConfig, ExpertError, ExpertFault, FunctionConfig, FunctionKind, LimitsMode, PeriodMeasurement,
    PhaseMode, Reflex, SyncInput, Threshold, ThresholdEvent, WaveConfig, WaveRole,
};
use plans::plan::{FunctionSettings, FunctionType, PlanSettings};
use profile::EventEdges;
use signal::Span;

/// The unit of a period meter where the plan says none.
const RESOLUTION: Span = Span::from_micros(1);

/// The functions of the settings, in their order.
///
/// # Errors
/// A finding for each function that lacks a key.
pub fn configure(settings: &PlanSettings, plan: &str) -> Result<ExpertConfig, Vec<Diagnostic>> {
    let (mut functions, mut found) = (Vec::new(), Vec::new());
    for said in &settings.expert {
        match kind(said) {
            Ok(kind) => functions.push(FunctionConfig { name: said.name.clone(), kind }),
            Err(key) => {
                let message = format!("`{}` lacks `{key}`", said.name);
                let lacking = Diagnostic::error(codes::FUNCTION_PARAMETER_MISSING, message).at(
                    plan,
                    said.span.clone(),
                    "",
                );
                found.push(lacking.help(format!("add `{key}`: a function of this kind and mode needs it")));
            }
        }
    }
    if found.is_empty() { Ok(ExpertConfig { functions }) } else { Err(found) }
}

/// What the controller refuses of its functions, each at the key that it is about.
///
/// # Errors
/// The findings.
pub fn check(config: &Config, settings: &PlanSettings, plan: &str) -> Result<(), Vec<Diagnostic>> {
    let errors = config.check_expert();
    let found: Vec<Diagnostic> = errors
        .iter()
        .filter_map(|error| Some(refusal(error, settings.expert.get(error.function)?, plan)))
        .collect();
    if found.is_empty() { Ok(()) } else { Err(found) }
}

/// What is worth knowing of them: bounce times that let too few pulses pass (io:STD-IN-05).
pub fn warnings(config: &Config, settings: &PlanSettings, plan: &str) -> Vec<Diagnostic> {
    let found = config.expert.warnings(&config.input_conditions());
    let show = |warning: &expert::ExpertWarning| {
        let said = settings.expert.get(warning.function)?;
        let message = format!("`{}`: {warning}", said.name);
        let found = Diagnostic::warning(codes::BOUNCE_TIME_TOO_LONG, message).at(
            plan,
            said.place(key_of(warning.role)),
            "",
        );
        Some(found.help("shorten the `bounce` of the input in `settings.inputs`, or expect less"))
    };
    found.iter().filter_map(show).collect()
}

/// A function, or the key that it lacks.
fn kind(said: &FunctionSettings) -> Result<FunctionKind, &'static str> {
    let a = said.terminal("a").ok_or("a")?;
    Ok(match said.kind {
        FunctionType::Pwm => FunctionKind::Pwm(wave(said, a)),
        FunctionType::FreqGen => FunctionKind::Generator(wave(said, a)),
        FunctionType::Pto => FunctionKind::Axis(axis::axis(said, a)?),
        _ => FunctionKind::Counter(counter(said, a)?),
    })
}

fn wave(said: &FunctionSettings, output: u8) -> WaveConfig {
    WaveConfig {
        output,
        enable: said.terminal("enable"),
        sync: said.terminal("sync"),
        sync_edges: edges(said, "sync-edges"),
    }
}

fn counter(said: &FunctionSettings, a: u8) -> Result<CounterConfig, &'static str> {
    let kind = match said.kind {
        FunctionType::Simple => CounterKind::Simple,
        FunctionType::MainDual => {
            CounterKind::Dual { b: said.terminal("b").ok_or("b")?, phases: phases(said) }
        }
        _ => CounterKind::Single,
    };
    let capture = |input: &str, its_edges: &str| {
        said.terminal(input).map(|input| CaptureInput { input, edges: edges(said, its_edges) })
    };
    let sync = said.terminal("sync").map(|input| SyncInput {
        input,
        edges: edges(said, "sync-edges"),
        while_enable: said.flag("sync-while-enable"),
    });
    Ok(CounterConfig {
        expected: said.number("expected").and_then(|hertz| u32::try_from(hertz).ok()),
        enable: said.terminal("enable"),
        sync,
        captures: [capture("capture", "capture-edges"), capture("capture1", "capture1-edges")],
        thresholds: thresholds(said),
        reflex: [reflex(said, "reflex0", "reflex0-zones"), reflex(said, "reflex1", "reflex1-zones")],
        ..CounterConfig::new(kind, a, mode(said)?)
    })
}

fn phases(said: &FunctionSettings) -> PhaseMode {
    match said.word("inputs") {
        Some("pulse-direction") => PhaseMode::PulseDirection,
        Some("quadrature-x1") => PhaseMode::X1,
        Some("quadrature-x2") => PhaseMode::X2,
        Some("quadrature-x4") => PhaseMode::X4,
        Some("reverse-x1") => PhaseMode::ReverseX1,
        Some("reverse-x2") => PhaseMode::ReverseX2,
        Some("reverse-x4") => PhaseMode::ReverseX4,
        _ => PhaseMode::UpDown,
    }
}

/// What a counter or meter does, or the key that it lacks.
fn mode(said: &FunctionSettings) -> Result<CounterMode, &'static str> {
    let number = |key: &'static str| said.number(key).and_then(|it| i32::try_from(it).ok()).ok_or(key);
    let window = || said.time("window").ok_or("window");
    match said.kind {
        FunctionType::FrequencyMeter => return Ok(CounterMode::Frequency { window: window()? }),
        FunctionType::PeriodMeter => {
            let measures = match said.word("measures") {
                Some("pulse-width") => PeriodMeasurement::PulseWidth,
                _ => PeriodMeasurement::Period,
            };
            let resolution = said.time("resolution").unwrap_or(RESOLUTION);
            let timeout = said.time("timeout").unwrap_or(Span::ZERO);
            return Ok(CounterMode::Period { measures, resolution, timeout });
        }
        _ => {}
    }
    Ok(match said.word("mode").ok_or("mode")? {
        "one-shot" => CounterMode::OneShot { preset: number("preset")? },
        "modulo-loop" => CounterMode::ModuloLoop { modulo: number("modulo")? },
        "event-counting" => CounterMode::EventCounting { window: window()? },
        _ => CounterMode::FreeLarge {
            preset: number("preset").unwrap_or(0),
            limits: if said.word("limits") == Some("rollover") {
                LimitsMode::Rollover
            } else {
                LimitsMode::Lock
            },
        },
    })
}

fn edges(said: &FunctionSettings, key: &str) -> EventEdges {
    match said.word(key) {
        Some("falling") => EventEdges::Falling,
        Some("both") => EventEdges::Both,
        _ => EventEdges::Rising,
    }
}

fn thresholds(said: &FunctionSettings) -> Vec<Threshold> {
    let events = said.words("threshold-events").iter().map(String::as_str).chain(std::iter::repeat("none"));
    let values = said.numbers("thresholds").iter();
    values
        .zip(events)
        .map(|(value, event)| Threshold {
            // Its type has limits that are those of a DINT.
            value: i32::try_from(*value).unwrap_or(i32::MAX),
            event: match event {
                "upwards" => ThresholdEvent::Upwards,
                "downwards" => ThresholdEvent::Downwards,
                "both" => ThresholdEvent::Both,
                "below" => ThresholdEvent::Below,
                "above" => ThresholdEvent::Above,
                "between" => ThresholdEvent::Between,
                _ => ThresholdEvent::None,
            },
        })
        .collect()
}

fn reflex(said: &FunctionSettings, output: &str, zones: &str) -> Reflex {
    let zones = said.numbers(zones).iter().fold(0, |mask, zone| mask | 1 << zone.clamp(&0, &4));
    Reflex { output: said.terminal(output), zones }
}

/// The key that says which input or output has a role.
pub(super) const fn key_of(role: ChannelRole) -> &'static str {
    match role {
        ChannelRole::Counter(CounterRole::A) | ChannelRole::Wave(WaveRole::A) => "a",
        ChannelRole::Axis(role) => axis::key_of(role),
        ChannelRole::Counter(CounterRole::B) => "b",
        ChannelRole::Counter(CounterRole::Enable) | ChannelRole::Wave(WaveRole::Enable) => "enable",
        ChannelRole::Counter(CounterRole::Sync) | ChannelRole::Wave(WaveRole::Sync) => "sync",
        ChannelRole::Counter(CounterRole::Capture(0)) => "capture",
        ChannelRole::Counter(CounterRole::Capture(_)) => "capture1",
        ChannelRole::Counter(CounterRole::Reflex(0)) => "reflex0",
        ChannelRole::Counter(CounterRole::Reflex(_)) => "reflex1",
    }
}

/// The key that a fault of a counter is about.
const fn key_of_fault(fault: CounterFault) -> &'static str {
    match fault {
        CounterFault::Mode => "mode",
        CounterFault::Preset(_) => "preset",
        CounterFault::Modulo(_) => "modulo",
        CounterFault::Window(_) => "window",
        CounterFault::Resolution(_) => "resolution",
        CounterFault::Timeout(_) => "timeout",
        CounterFault::Input(role) => key_of(ChannelRole::Counter(role)),
        CounterFault::SyncWithoutEnable => "sync-while-enable",
        CounterFault::Thresholds
        | CounterFault::TooManyThresholds(_)
        | CounterFault::ThresholdOrder(_)
        | CounterFault::ThresholdRange(_)
        | CounterFault::NoNextThreshold(_) => "thresholds",
        CounterFault::ReflexWithoutThreshold(0) => "reflex0",
        CounterFault::ReflexWithoutThreshold(_) => "reflex1",
        CounterFault::ReflexZone(0) => "reflex0-zones",
        CounterFault::ReflexZone(_) => "reflex1-zones",
    }
}

/// A refusal of the controller at the key that it is about, with what fixes it.
fn refusal(error: &ExpertError, said: &FunctionSettings, plan: &str) -> Diagnostic {
    let (code, help) = match error.fault {
        ExpertFault::Counter(_) | ExpertFault::Axis(_) => {
            (codes::FUNCTION_PARAMETER_INVALID, "take a value that the message allows, or leave the key out")
        }
        ExpertFault::Name | ExpertFault::SameName(_) => (codes::FUNCTION_NOT_AVAILABLE, "take another name"),
        ExpertFault::NoEmbedded
        | ExpertFault::Shared { .. }
        | ExpertFault::Axes { .. }
        | ExpertFault::Inputs { .. } => {
            (codes::FUNCTION_NOT_AVAILABLE, "remove functions or inputs, or take another reference")
        }
        _ => (codes::FUNCTION_TERMINAL_INVALID, "take another input or output, or free this one"),
    };
    let at = match (error.role, error.fault) {
        (Some(role), _) => said.place(key_of(role)),
        (None, ExpertFault::Counter(fault)) => said.place(key_of_fault(fault)),
        (None, ExpertFault::Axis(fault)) => said.place(&axis::key_of_parameter(fault)),
        (None, ExpertFault::Name | ExpertFault::SameName(_)) => said.name_span.clone(),
        (None, _) => said.span.clone(),
    };
    Diagnostic::error(code, format!("`{}`: {error}", said.name)).at(plan, at, "").help(help)
}
