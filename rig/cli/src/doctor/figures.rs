//! What was measured of this machine and is kept.

use super::check::Check;
use host::Machine;
use runtime::figures;
use signal::Span;

/// The figures that are kept of this machine; of another one nothing is known here.
pub fn checks(machine: &Machine) -> Vec<Check> {
    if machine.is_here() { vec![latency(machine)] } else { Vec::new() }
}

fn latency(machine: &Machine) -> Check {
    const GROUP: &str = "figures";
    const NAME: &str = "wake-up latency";
    const MEND: &str = "rig bench latency --count 100000";
    let open = |found: String| Check::open(GROUP, NAME, found).mend(MEND);
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
        Some(late) => Check::good(
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
