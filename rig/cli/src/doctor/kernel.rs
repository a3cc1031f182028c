//! The kernel: how punctual it can be at all, and its clocks.

use super::check::DoctorCheck;
use host::{HostMachine, Preemption};
use signal::Span;

const GROUP: &str = "kernel";

/// Everything about the kernel.
pub fn checks(machine: &HostMachine) -> Vec<DoctorCheck> {
    vec![kind(machine), resolution(machine), source(machine), throttling(machine), beneath(machine)]
}

/// A word of `/etc/os-release`.
fn distribution(machine: &HostMachine, key: &str) -> String {
    let text = machine.read("/etc/os-release").unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix('='));
    line.unwrap_or_default().trim_matches('"').to_owned()
}

fn kind(machine: &HostMachine) -> DoctorCheck {
    let Some(release) = machine.release() else {
        return DoctorCheck::open(GROUP, "kind", "the kernel does not say what it is");
    };
    let version = machine.read("/proc/sys/kernel/version").unwrap_or_default();
    let word = match machine.preemption() {
        Preemption::Realtime => return DoctorCheck::good(GROUP, "kind", format!("PREEMPT_RT, {release}")),
        Preemption::Xenomai => return DoctorCheck::good(GROUP, "kind", format!("Xenomai, {release}")),
        Preemption::Preemptible if version.contains("PREEMPT_DYNAMIC") => "PREEMPT_DYNAMIC",
        Preemption::Preemptible => "PREEMPT",
        Preemption::Ordinary => "not preemptible",
    };
    let check = DoctorCheck::poor(GROUP, "kind", format!("{word}, {release}"))
        .means("the kernel's own work can hold up a scan for milliseconds");
    let like = format!("{} {}", distribution(machine, "ID"), distribution(machine, "ID_LIKE"));
    let debian = match machine.architecture().as_str() {
        "x86_64" => Some("linux-image-rt-amd64"),
        "aarch64" => Some("linux-image-rt-arm64"),
        "armv7l" => Some("linux-image-rt-armmp"),
        _ => None,
    };
    // Kernels of Raspberry Pi OS name the board, whatever the distribution calls itself.
    let fixable = if release.contains("-rpi-") && machine.architecture() == "aarch64" {
        check.fix(
            "sudo apt install linux-image-rpi-v8-rt && echo kernel=kernel8_rt.img | \
             sudo tee -a /boot/firmware/config.txt",
        )
    } else if like.contains("ubuntu") {
        check.fix("sudo pro attach && sudo pro enable realtime-kernel")
    } else if let (true, Some(package)) = (like.contains("debian"), debian) {
        check.fix(format!("sudo apt install {package}"))
    } else {
        return check;
    };
    fixable.then("restart the machine")
}

fn resolution(machine: &HostMachine) -> DoctorCheck {
    const NAME: &str = "timer resolution";
    let active = match machine.read("/proc/timer_list") {
        Some(text) => text.lines().find_map(|line| {
            let (name, value) = line.split_once(':')?;
            (name.trim_start_matches([' ', '.']).trim() == "hres_active").then(|| value.trim() == "1")
        }),
        None => None,
    };
    let step = if machine.is_here() { Some(host::resolution()) } else { None };
    match (active, step.map(Span::as_nanos)) {
        (Some(true), _) | (None, Some(0..=1_000)) => DoctorCheck::good(GROUP, NAME, "1 ns"),
        (Some(false), _) | (None, Some(_)) => {
            let check = DoctorCheck::bad(GROUP, NAME, "a tick of the kernel")
                .means("no wait ends between two ticks of the kernel, which are milliseconds apart");
            boot_parameter(machine, check, "highres=on", "")
        }
        (None, None) => DoctorCheck::open(GROUP, NAME, "the kernel does not say"),
    }
}

fn source(machine: &HostMachine) -> DoctorCheck {
    const NAME: &str = "clock source";
    match machine.clocksource() {
        None => DoctorCheck::open(GROUP, NAME, "the kernel does not say"),
        Some(source)
            if ["hpet", "acpi_pm", "pit", "jiffies", "refined-jiffies"].contains(&source.as_str()) =>
        {
            let check =
                DoctorCheck::poor(GROUP, NAME, source).means("reading the clock takes a microsecond or more");
            // Where the kernel gave up the processor's counter, only the start of the kernel can bring it back.
            match machine.architecture().as_str() {
                "x86_64" => boot_parameter(machine, check, "tsc=reliable", ""),
                _ => check,
            }
        }
        Some(source) => DoctorCheck::good(GROUP, NAME, source),
    }
}

fn throttling(machine: &HostMachine) -> DoctorCheck {
    const NAME: &str = "throttling";
    let number = |name: &str| machine.read(&format!("/proc/sys/kernel/{name}"))?.parse::<i64>().ok();
    match (number("sched_rt_runtime_us"), number("sched_rt_period_us")) {
        (Some(share), Some(period)) if share >= 0 && share < period => {
            let (share, period) = (share / 1_000, period / 1_000);
            DoctorCheck::poor(
                GROUP,
                NAME,
                format!("real-time threads may run {share} ms of every {period} ms"),
            )
            .means("a program that uses up its share is held up for the rest of it")
            .fix(
                "echo kernel.sched_rt_runtime_us=-1 | sudo tee /etc/sysctl.d/90-rig.conf && \
                     sudo sysctl -p /etc/sysctl.d/90-rig.conf",
            )
        }
        (Some(_), Some(_)) => {
            DoctorCheck::good(GROUP, NAME, "none: real-time threads may run as long as they want")
        }
        _ => DoctorCheck::open(GROUP, NAME, "the kernel does not say"),
    }
}

/// Whether another system runs beneath this one.
fn beneath(machine: &HostMachine) -> DoctorCheck {
    const NAME: &str = "hypervisor";
    let text = machine.read("/proc/cpuinfo");
    let flagged = text.as_ref().is_some_and(|text| {
        text.lines()
            .any(|line| line.starts_with("flags") && line.split_whitespace().any(|flag| flag == "hypervisor"))
    });
    match text {
        None => DoctorCheck::open(GROUP, NAME, "the kernel does not say"),
        Some(_) if flagged => DoctorCheck::poor(GROUP, NAME, "this is a virtual machine")
            .means("the machine beneath can stop this one at any time: its figures hold for no other moment"),
        Some(_) => DoctorCheck::good(GROUP, NAME, "none that shows itself"),
    }
}

/// How to add a parameter to what the kernel is started with: a line to type, where the boot loader is known.
pub fn boot_parameter(
    machine: &HostMachine,
    check: DoctorCheck,
    parameter: &str,
    further: &str,
) -> DoctorCheck {
    let pi = ["/boot/firmware/cmdline.txt", "/boot/cmdline.txt"].into_iter().find(|file| machine.has(file));
    let line = match pi {
        Some(file) => Some(format!("sudo sed -i '1s/$/ {parameter}/' {file}")),
        None => machine.has("/etc/default/grub").then(|| {
            format!(
                "sudo sed -i 's/^GRUB_CMDLINE_LINUX=\"/&{parameter} /' /etc/default/grub && sudo update-grub"
            )
        }),
    };
    match line {
        Some(line) => check.fix(line).then(format!("restart the machine{further}")),
        None => check.then(format!(
            "let your boot loader give `{parameter}` to the kernel, and restart the machine{further}"
        )),
    }
}
