//! Where a run came from.

use host::{HostMachine, Preemption};
use record::{Provenance, RunClock};
use sha2::{Digest, Sha256};
use signal::calendar::rfc3339;
use std::io::Read;
use std::time::{SystemTime, UNIX_EPOCH};

/// The provenance of a run that begins now.
pub fn now(seed: u64, clock: RunClock) -> Provenance {
    let machine = HostMachine::here();
    let since = SystemTime::now().duration_since(UNIX_EPOCH).ok();
    Provenance {
        binary_sha256: binary_sha256().unwrap_or_default(),
        kernel: machine.kernel(),
        host_cpu: machine.processor(),
        profiles: Vec::new(),
        seed,
        clock,
        arguments: std::env::args().skip(1).collect(),
        started: since.map(|since| rfc3339(since.as_secs())),
        started_nanos: since.map_or(0, |since| since.subsec_nanos()),
        environment: environment(&machine),
    }
}

/// What else of the host the figures of a run depend on.
fn environment(machine: &HostMachine) -> Vec<(String, String)> {
    let named = |name: &str, text: Option<String>| {
        text.filter(|text| !text.is_empty()).map(|text| (name.to_owned(), text))
    };
    let cores = std::thread::available_parallelism().ok().map(|cores| cores.to_string());
    // Where the run happened, as the CI says it itself; GitLab and GitHub name themselves.
    let ci = ["GITLAB_CI", "GITHUB_ACTIONS", "JENKINS_URL", "CI"]
        .into_iter()
        .find(|name| std::env::var_os(name).is_some_and(|value| !value.is_empty()))
        .map(|name| match name {
            "GITLAB_CI" => String::from("GitLab"),
            "GITHUB_ACTIONS" => String::from("GitHub"),
            "JENKINS_URL" => String::from("Jenkins"),
            _ => String::from("yes"),
        });
    let all = [
        named("Real-time kernel", Some(real_time(machine).to_owned())),
        named("Cores", cores),
        named("Governor", Some(machine.governors().join(" "))),
        named("Clock source", machine.clocksource()),
        named("Isolated processors", machine.read("/sys/devices/system/cpu/isolated")),
        named("Real-time share", machine.read("/proc/sys/kernel/sched_rt_runtime_us")),
        named("Kernel parameters", Some(machine.parameters().join(" "))),
        named("CI", ci),
    ];
    all.into_iter().flatten().collect()
}

/// Which kind of kernel this is, as far as it reports.
fn real_time(machine: &HostMachine) -> &'static str {
    match machine.preemption() {
        Preemption::Realtime => "PREEMPT_RT",
        Preemption::Xenomai => "Xenomai",
        Preemption::Preemptible => "no: preemptible, without PREEMPT_RT",
        Preemption::Ordinary => "no",
    }
}

fn binary_sha256() -> Option<String> {
    let mut file = std::fs::File::open(std::env::current_exe().ok()?).ok()?;
    let mut hasher = Sha256::new();
    // Large pieces: over a network each read takes its time.
    let mut piece = vec![0; 1 << 20];
    loop {
        match file.read(&mut piece).ok()? {
            0 => break,
            count => hasher.update(&piece[..count]),
        }
    }
    Some(runtime::suite::describe::hex(&hasher.finalize()))
}
