//! What the kernel reports about the machine in its files, and what distinguishes one machine from another.

use std::fs;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};

/// Parameters of the kernel's command line that change how punctual threads are. The rest, such as the disk that it
/// boots from, is nobody's business.
const TIMING_PARAMETERS: &[&str] = &[
    "clocksource",
    "cpufreq.default_governor",
    "cpuidle.off",
    "idle",
    "intel_idle.max_cstate",
    "irqaffinity",
    "isolcpus",
    "mitigations",
    "nohz",
    "nohz_full",
    "nosmt",
    "preempt",
    "processor.max_cstate",
    "rcu_nocbs",
    "skew_tick",
    "threadirqs",
    "tsc",
];

/// How far the kernel's own work can hold up a thread of real-time priority.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preemption {
    /// PREEMPT_RT: nearly everything can be interrupted.
    Realtime,
    /// A second kernel beside Linux.
    Xenomai,
    /// The kernel can be interrupted outside its locks.
    Preemptible,
    /// It cannot, or does not say.
    Ordinary,
}

/// The files of `/proc`, `/sys`, `/dev` and `/etc`, below a root that is not `/` in tests alone.
#[derive(Clone, Debug)]
pub struct HostMachine {
    root: PathBuf,
}

impl HostMachine {
    /// This machine.
    pub fn here() -> HostMachine {
        HostMachine::below(Path::new("/"))
    }

    /// The machine whose files stand below a folder.
    pub fn below(root: &Path) -> HostMachine {
        HostMachine { root: root.to_owned() }
    }

    /// Whether it is this machine, which can be tried and not only read about.
    pub fn is_here(&self) -> bool {
        self.root == Path::new("/")
    }

    fn path(&self, path: &str) -> PathBuf {
        self.root.join(path.trim_start_matches('/'))
    }

    /// The text of a file without the white space around it; nothing where it is empty, missing or not to be read.
    pub fn read(&self, path: &str) -> Option<String> {
        let bytes = fs::read(self.path(path)).ok()?;
        Some(String::from_utf8_lossy(&bytes).trim().to_owned()).filter(|text| !text.is_empty())
    }

    /// Names in a folder that begin with `prefix`, as people count: `gpiochip2` before `gpiochip10`.
    pub fn list(&self, folder: &str, prefix: &str) -> Vec<String> {
        let Ok(entries) = fs::read_dir(self.path(folder)) else { return Vec::new() };
        let mut names: Vec<String> = entries
            .flatten()
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .filter(|name| name.starts_with(prefix))
            .collect();
        names.sort_by(|a, b| counted(a).cmp(&counted(b)));
        names
    }

    /// Whether there is such a file.
    pub fn has(&self, path: &str) -> bool {
        self.path(path).exists()
    }

    /// Where a symbolic link leads, as it is written.
    pub fn link(&self, path: &str) -> Option<String> {
        Some(fs::read_link(self.path(path)).ok()?.to_string_lossy().into_owned())
    }

    /// Whether this process may read and write a file. Of another machine the mode of the file decides, and whom
    /// `/proc/self/status` names.
    pub fn may_use(&self, path: &str) -> bool {
        use rustix::fs::{Access, access};
        if self.is_here() {
            return access(self.path(path), Access::READ_OK | Access::WRITE_OK).is_ok();
        }
        let Some((mode, owner, group)) = self.mode(path) else { return false };
        let ids = |name: &str| -> Vec<u32> {
            let field = self.status(name).unwrap_or_default();
            field.split_whitespace().filter_map(|word| word.parse().ok()).collect()
        };
        let user = ids("Uid").get(1).copied();
        let groups = [ids("Gid").get(1).copied().into_iter().collect(), ids("Groups")].concat();
        if user == Some(0) {
            return true;
        }
        let shift = match () {
            () if user == Some(owner) => 6,
            () if groups.contains(&group) => 3,
            () => 0,
        };
        mode >> shift & 6 == 6
    }

    /// Mode, owner and group of a file.
    pub fn mode(&self, path: &str) -> Option<(u32, u32, u32)> {
        let about = fs::metadata(self.path(path)).ok()?;
        Some((about.permissions().mode() & 0o777, about.uid(), about.gid()))
    }

    /// A field of `/proc/self/status`.
    pub fn status(&self, field: &str) -> Option<String> {
        let text = self.read("/proc/self/status")?;
        text.lines().find_map(|line| Some(line.strip_prefix(field)?.strip_prefix(':')?.trim().to_owned()))
    }

    /// The release of the kernel, as in `6.12.25+rpt-rpi-v8-rt`.
    pub fn release(&self) -> Option<String> {
        self.read("/proc/sys/kernel/osrelease")
    }

    /// Name, release, version and architecture of the kernel.
    pub fn kernel(&self) -> String {
        let part = |name: &str| self.read(&format!("/proc/sys/kernel/{name}")).unwrap_or_default();
        let words = [part("ostype"), part("osrelease"), part("version"), self.architecture()];
        words.join(" ").trim().to_owned()
    }

    /// The kernel's word for the architecture, as in `aarch64`.
    pub fn architecture(&self) -> String {
        self.read("/proc/sys/kernel/arch").unwrap_or_else(|| std::env::consts::ARCH.to_owned())
    }

    /// Which kind of kernel it is, as far as it tells.
    pub fn preemption(&self) -> Preemption {
        let says = |path: &str, word: &str| self.read(path).is_some_and(|text| text.contains(word));
        if says("/sys/kernel/realtime", "1") || says("/proc/sys/kernel/version", "PREEMPT_RT") {
            Preemption::Realtime
        } else if self.has("/proc/xenomai") {
            Preemption::Xenomai
        } else if says("/proc/sys/kernel/version", "PREEMPT") {
            Preemption::Preemptible
        } else {
            Preemption::Ordinary
        }
    }

    /// The processor's name, or the board's where the processor has none.
    pub fn processor(&self) -> Option<String> {
        let text = self.read("/proc/cpuinfo").unwrap_or_default();
        let named = text.lines().find(|line| line.starts_with("model name") || line.starts_with("Model"));
        match named.and_then(|line| line.split_once(':')) {
            Some((_, name)) => Some(name.trim().to_owned()),
            None => Some(self.read("/proc/device-tree/model")?.trim_end_matches('\0').to_owned()),
        }
    }

    /// How the frequency of the processors is chosen: that of each where they differ.
    pub fn governors(&self) -> Vec<String> {
        let mut governors: Vec<String> = self
            .list("/sys/devices/system/cpu", "cpu")
            .iter()
            .filter_map(|cpu| self.read(&format!("/sys/devices/system/cpu/{cpu}/cpufreq/scaling_governor")))
            .collect();
        governors.sort();
        governors.dedup();
        governors
    }

    /// The source of the kernel's clock.
    pub fn clocksource(&self) -> Option<String> {
        self.read("/sys/devices/system/clocksource/clocksource0/current_clocksource")
    }

    /// Parameters of the kernel's command line that figures of time depend on, in their order.
    pub fn parameters(&self) -> Vec<String> {
        let line = self.read("/proc/cmdline").unwrap_or_default();
        let timing = |word: &&str| TIMING_PARAMETERS.contains(&word.split('=').next().unwrap_or_default());
        line.split_whitespace().filter(timing).map(str::to_owned).collect()
    }

    /// What the figures of this machine depend on, name and text: another machine, or the same one set up in another
    /// way, differs in one of them.
    pub fn identity(&self) -> Vec<(String, String)> {
        let online = self.read("/sys/devices/system/cpu/online");
        let named = |name: &str, text: Option<String>| (name.to_owned(), text.unwrap_or_default());
        vec![
            named("kernel", Some(self.kernel())),
            named("processor", self.processor()),
            named("processors", online),
            named("parameters", Some(self.parameters().join(" "))),
            named("governor", Some(self.governors().join(" "))),
            named("clock source", self.clocksource()),
            named("isolated processors", self.read("/sys/devices/system/cpu/isolated")),
            named("real-time share", self.read("/proc/sys/kernel/sched_rt_runtime_us")),
            named("host", self.read("/proc/sys/kernel/hostname")),
        ]
    }
}

/// A name as its word and the number after it.
fn counted(name: &str) -> (&str, u64) {
    let word = name.trim_end_matches(|c: char| c.is_ascii_digit());
    (word, name[word.len()..].parse().unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_in_the_order_of_their_numbers() {
        let mut names = vec!["gpiochip10", "gpiochip2", "gpiochip0", "gpio"];
        names.sort_by_key(|name| counted(name));
        assert_eq!(names, ["gpio", "gpiochip0", "gpiochip2", "gpiochip10"]);
    }

    #[test]
    fn a_machine_that_tells_nothing_has_an_identity_without_facts() {
        let nowhere = HostMachine::below(Path::new("/nonexistent"));
        assert_eq!(nowhere.preemption(), Preemption::Ordinary);
        assert!(nowhere.list("/dev", "gpiochip").is_empty() && !nowhere.may_use("/dev/gpiochip0"));
        assert!(nowhere.identity().iter().all(|(name, text)| name == "kernel" || text.is_empty()));
    }

    #[test]
    fn this_machine_says_which_kernel_it_runs() {
        let here = HostMachine::here();
        assert!(here.is_here() && here.kernel().starts_with("Linux "), "{}", here.kernel());
        assert_eq!(here.identity(), here.identity());
    }
}
