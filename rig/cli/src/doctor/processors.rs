//! The processors: their frequency, their sleep, and whether one is kept free.

use super::check::DoctorCheck;
use super::kernel::boot_parameter;
use host::HostMachine;

const GROUP: &str = "processors";

/// Where the kernel describes them.
const PROCESSORS: &str = "/sys/devices/system/cpu";

/// Everything about the processors.
pub fn checks(machine: &HostMachine) -> Vec<DoctorCheck> {
    vec![governor(machine), sleep(machine), isolated(machine)]
}

fn governor(machine: &HostMachine) -> DoctorCheck {
    const NAME: &str = "governor";
    let governors = machine.governors();
    match governors.as_slice() {
        [] if !machine.has(PROCESSORS) => DoctorCheck::open(GROUP, NAME, "the kernel does not say"),
        [] => DoctorCheck::good(GROUP, NAME, "none: the frequency does not change, or is not ours to choose"),
        [only] if only == "performance" => DoctorCheck::good(GROUP, NAME, "performance"),
        others => DoctorCheck::poor(GROUP, NAME, others.join(", "))
            .means("a processor that begins slowly makes the first scans after idle time late")
            .fix("echo performance | sudo tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor"),
    }
}

/// Deep sleep is kept off while the rig runs, where the kernel lets it ask for that.
fn sleep(machine: &HostMachine) -> DoctorCheck {
    const NAME: &str = "idle states";
    const REQUEST: &str = "/dev/cpu_dma_latency";
    let driver = machine.read("/sys/devices/system/cpu/cpuidle/current_driver");
    match driver {
        None if !machine.has(PROCESSORS) => DoctorCheck::open(GROUP, NAME, "the kernel does not say"),
        None => DoctorCheck::good(GROUP, NAME, "none"),
        Some(driver) if driver == "none" => DoctorCheck::good(GROUP, NAME, "none"),
        Some(driver) if machine.may_use(REQUEST) => DoctorCheck::good(
            GROUP,
            NAME,
            format!("{driver}; the rig keeps the processors awake while it runs"),
        ),
        Some(driver) => DoctorCheck::poor(GROUP, NAME, format!("{driver}; {REQUEST} is not to be written"))
            .means("a processor in deep sleep takes tens of microseconds or more to wake up")
            .fix(format!(
                "echo 'KERNEL==\"cpu_dma_latency\", MODE=\"0666\"' | sudo tee \
                 /etc/udev/rules.d/60-rig-latency.rules && sudo chmod 666 {REQUEST}"
            )),
    }
}

fn isolated(machine: &HostMachine) -> DoctorCheck {
    const NAME: &str = "isolation";
    let online = machine.read("/sys/devices/system/cpu/online");
    let last = online.as_deref().and_then(|text| text.rsplit([',', '-']).next()?.parse::<u32>().ok());
    match (machine.read("/sys/devices/system/cpu/isolated"), last) {
        (Some(isolated), _) => {
            DoctorCheck::good(GROUP, NAME, format!("processor {isolated} is kept free of others' work"))
        }
        (None, None) => DoctorCheck::open(GROUP, NAME, "the kernel does not say"),
        (None, Some(0)) => DoctorCheck::poor(GROUP, NAME, "there is one processor only")
            .means("the scan shares its processor with everything else"),
        (None, Some(last)) => {
            let check = DoctorCheck::poor(GROUP, NAME, "no processor is kept free of others' work")
                .means("interrupts and other programs run on the processor of the scan");
            let parameter = format!("isolcpus=managed_irq,domain,{last} nohz_full={last} rcu_nocbs={last}");
            let further = format!(", and write `cpus = [{last}]` below `[realtime]` in the board file");
            boot_parameter(machine, check, &parameter, &further)
        }
    }
}
