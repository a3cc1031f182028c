//! What makes the outputs safe when the rig cannot any more: the guard, and the watchdog that backs it.

use super::check::DoctorCheck;
use super::devices::{grant, version};
use drivers::file::GuardSettings;
use guard::{Guard, GuardError, MissingPrivileges};
use host::HostMachine;

const GROUP: &str = "safety";

/// The first kernel that lets one process watch and end another without mistaking it for a third.
const PIDFD: (u32, u32) = (5, 3);

/// The guard and the watchdog.
pub fn checks(machine: &HostMachine) -> Vec<DoctorCheck> {
    vec![guard(machine), watchdog(machine)]
}

fn guard(machine: &HostMachine) -> DoctorCheck {
    const NAME: &str = "guard";
    match version(machine) {
        None => DoctorCheck::open(GROUP, NAME, "the kernel does not say which version it has"),
        Some(version) if version < PIDFD => DoctorCheck::bad(GROUP, NAME, "not with this kernel")
            .means("the guard cannot end a rig that hangs; a kernel from 5.3 lets it"),
        // The one that knows best is a guard itself: it holds nothing and ends at once.
        Some(_) if machine.is_here() => match tried() {
            Ok(lacks) => DoctorCheck::good(GROUP, NAME, lacks),
            Err(error) => DoctorCheck::bad(GROUP, NAME, error.to_string())
                .means(
                    "nobody would make the outputs safe when the rig ends badly: real lines are not opened",
                )
                .then(error.help()),
        },
        Some(_) => DoctorCheck::good(GROUP, NAME, "possible"),
    }
}

/// Starts a guard and ends it: what it would have to do without, which other entries here fix.
fn tried() -> Result<String, GuardError> {
    let guard = Guard::spawn(&GuardSettings::default())?;
    let MissingPrivileges { priority, memory, sparing } = guard.lacks();
    guard.close()?;
    let lacks = [(priority, "priority"), (memory, "locked memory"), (sparing, "being spared")];
    let lacks: Vec<&str> = lacks.into_iter().filter(|(lacks, _)| *lacks).map(|(_, what)| what).collect();
    Ok(if lacks.is_empty() {
        String::from("it starts, with all that it asks for")
    } else {
        format!("it starts, without {}", lacks.join(", "))
    })
}

fn watchdog(machine: &HostMachine) -> DoctorCheck {
    const NAME: &str = "watchdog";
    const NODE: &str = "/dev/watchdog";
    const ABOUT: &str = "/sys/class/watchdog/watchdog0";
    let about = |name: &str| machine.read(&format!("{ABOUT}/{name}"));
    if !machine.has(NODE) {
        let check = DoctorCheck::poor(GROUP, NAME, "none")
            .means("if rig and guard both end, nobody makes the outputs safe");
        let release = machine.release().unwrap_or_default();
        return if machine.has(&format!("/lib/modules/{release}/kernel")) {
            check
                .fix("sudo modprobe softdog && echo softdog | sudo tee /etc/modules-load.d/rig-watchdog.conf")
        } else {
            check
        };
    }
    let name = about("identity").unwrap_or_else(|| String::from("one without a name"));
    if about("state").as_deref() == Some("active") {
        return DoctorCheck::poor(GROUP, NAME, format!("{name}, which another program feeds"))
            .means("it bites when that program ends, and not when the rig does")
            .fix(
                "printf '[Manager]\\nRuntimeWatchdogSec=0\\n' | \
                 sudo install -D -m 644 /dev/stdin /etc/systemd/system.conf.d/zz-rig.conf && \
                 sudo systemctl daemon-reexec",
            );
    }
    if !machine.may_use(NODE) {
        let (fix, then) = grant(machine, NODE, "watchdog", "watchdog");
        return DoctorCheck::poor(GROUP, NAME, format!("{name}; {NODE} is not to be used"))
            .means("if rig and guard both end, nobody makes the outputs safe")
            .fix(fix)
            .then(then);
    }
    match about("timeout").filter(|seconds| seconds != "0") {
        Some(seconds) => DoctorCheck::good(GROUP, NAME, format!("{name}, {seconds} s")),
        None => DoctorCheck::good(GROUP, NAME, name),
    }
}
