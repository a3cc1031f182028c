//! What was measured of this machine and is kept.

use super::check::DoctorCheck;
use drivers::file::{BoardFile, BoardKind};
use drivers::gpio::GpioSpec;
use host::HostMachine;
use runtime::instrument::figures::{self, CountingLimit};
use signal::Span;

const GROUP: &str = "figures";

/// The figures that are kept of this machine; of another one nothing is known here.
pub fn checks(machine: &HostMachine) -> Vec<DoctorCheck> {
    if machine.is_here() { vec![latency(machine)] } else { Vec::new() }
}

/// How fast a board counts, as it was measured last, beside what its file promises. `None` for a board without GPIO
/// lines.
pub fn counts(file: &BoardFile) -> Option<DoctorCheck> {
    const NAME: &str = "counting";
    let BoardKind::Real(spec) = &file.kind else { return None };
    let lines = &spec.of::<GpioSpec>()?.lines;
    let promised = lines.iter().filter_map(|line| Some((line, line.counts_hz?)));
    let promised = promised.max_by_key(|(_, hz)| *hz);
    if lines.is_empty() {
        return None;
    }
    let fix = format!("rig bench counts {}", file.name);
    let open = |found: String| Some(DoctorCheck::open(GROUP, NAME, found).fix(fix.clone()));
    let Some(folder) = figures::folder() else { return open(String::from("nothing can be kept")) };
    let kept = match figures::kept(&folder, figures::COUNTS, &figures::devices(file)) {
        Ok(Some(kept)) => kept,
        Ok(None) => return open(String::from("not measured")),
        Err(error) => return open(format!("the figures cannot be read: {error}")),
    };
    if let Some((name, then, now)) = kept.differences(&HostMachine::here().identity()).first() {
        return open(format!("measured when the {name} was `{then}`; now it is `{now}`"));
    }
    let Some(came) = CountingLimit::of(&kept) else {
        return open(String::from("the figures that were kept are empty"));
    };
    let found = format!("{}, made up to {} Hz, on {}", came.counted(), came.made_hz, kept.measured);
    Some(match promised {
        Some((line, hz)) if hz > came.counted_hz => {
            let name = file.circuit.channels.get(usize::from(line.channel.0));
            let name = name.map_or("", |channel| channel.name.as_str());
            let check = DoctorCheck::poor(
                GROUP,
                NAME,
                format!("{found}; the board file promises {hz} Hz of `{name}`"),
            );
            check.means("counts of faster pulses may be wrong without notice").fix(fix)
        }
        _ => DoctorCheck::good(GROUP, NAME, found),
    })
}

fn latency(machine: &HostMachine) -> DoctorCheck {
    const NAME: &str = "wake-up latency";
    const FIX: &str = "rig bench latency --count 100000";
    let open = |found: String| DoctorCheck::open(GROUP, NAME, found).fix(FIX);
    let Some(folder) = figures::folder() else {
        return open(String::from("nothing can be kept: neither XDG_STATE_HOME nor HOME names a folder"));
    };
    let kept = match figures::kept(&folder, "latency", "") {
        Ok(Some(kept)) => kept,
        Ok(None) => return open(String::from("not measured")),
        Err(error) => return open(format!("the figures cannot be read: {error}")),
    };
    if let Some((name, then, now)) = kept.differences(&machine.identity()).first() {
        return open(format!("measured when the {name} was `{then}`; now it is `{now}`"));
    }
    let span = |nanos: u64| Span::from_nanos(i64::try_from(nanos).unwrap_or(i64::MAX));
    let how: Vec<String> = kept.settings.iter().map(|(name, text)| format!("{name} {text}")).collect();
    match kept.figures.first() {
        Some(late) => DoctorCheck::good(
            GROUP,
            NAME,
            format!(
                "p99 {}, worst of {} {} ({}), on {}",
                span(late.p99_ns),
                late.count,
                span(late.max_ns),
                how.join(", "),
                kept.measured
            ),
        ),
        None => open(String::from("the figures that were kept are empty")),
    }
}
