//! What counters a machine has, and which of them a board file means. Nothing is opened to find out.

use std::path::{Path, PathBuf};

use document::suggest;

use super::spec::{CounterSpec, FindCount, FindCounter};
use crate::codes;
use crate::inventory::{line, names};
use crate::refusal::Refusal;

/// Where the kernel lists its counters.
const DEVICES: &str = "sys/bus/counter/devices";

/// A device of the counter subsystem.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CounterDevice {
    /// Its folder below `/sys/bus/counter/devices`.
    pub folder: PathBuf,
    /// Its name in the kernel, as in `counter0`: it can be another after the next start of the machine.
    pub number: String,
    /// What its driver calls it, as in `ti-eqep`; may be empty.
    pub name: String,
    /// Its node, as in `/dev/counter0`, where it has one.
    pub node: Option<PathBuf>,
    /// Its counts, by number.
    pub counts: Vec<HardwareCount>,
}

/// A count of a device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HardwareCount {
    /// Its number.
    pub number: u8,
    /// What its driver calls it; may be empty.
    pub name: String,
    /// Its folder.
    pub folder: PathBuf,
    /// What it counts, as the kernel writes it.
    pub function: String,
    /// What it could count.
    pub functions: Vec<String>,
}

/// The counters of a machine whose `/dev` and `/sys` lie under `root`, as people count.
pub fn list(root: &Path) -> Vec<CounterDevice> {
    let folder = root.join(DEVICES);
    let mut numbers: Vec<String> =
        names(&folder).into_iter().filter(|name| name.starts_with("counter")).collect();
    numbers.sort_by_key(|name| (name.len(), name.clone()));
    numbers.into_iter().map(|number| device(root, number)).collect()
}

fn device(root: &Path, number: String) -> CounterDevice {
    let folder = root.join(DEVICES).join(&number);
    let node = Some(root.join("dev").join(&number)).filter(|node| node.exists());
    let mut counts: Vec<HardwareCount> =
        names(&folder).iter().filter_map(|name| count(&folder, name.strip_prefix("count")?)).collect();
    counts.sort_by_key(|count| count.number);
    CounterDevice { name: line(&folder.join("name")), folder, number, node, counts }
}

fn count(device: &Path, number: &str) -> Option<HardwareCount> {
    let (folder, number) = (device.join(format!("count{number}")), number.parse().ok()?);
    let functions = std::fs::read_to_string(folder.join("function_available")).unwrap_or_default();
    Some(HardwareCount {
        number,
        name: line(&folder.join("name")),
        function: line(&folder.join("function")),
        functions: functions.lines().map(|name| name.trim().to_owned()).collect(),
        folder,
    })
}

/// The device that a board file means.
///
/// # Errors
/// There is none, or several answer to this.
pub fn find(root: &Path, find: &FindCounter) -> Result<CounterDevice, Refusal> {
    let machine = list(root);
    let (what, matches): (String, Vec<&CounterDevice>) = match find {
        FindCounter::Name(name) => {
            (format!("the name \"{name}\""), machine.iter().filter(|device| device.name == *name).collect())
        }
        FindCounter::Path(path) => (
            format!("the path \"{}\"", path.display()),
            machine.iter().filter(|device| is_at(root, device, path)).collect(),
        ),
    };
    match matches[..] {
        [one] => Ok(one.clone()),
        [] => Err(missing(find, &what, &machine)),
        _ => {
            let numbers: Vec<&str> = matches.iter().map(|device| device.number.as_str()).collect();
            let message =
                format!("{} counters of the machine have {what}: {}", numbers.len(), numbers.join(", "));
            let help = "say which by `path`: what `readlink -f` says of its place below \
                        /sys/bus/counter/devices stays the same";
            Err(Refusal::new(codes::COUNTERS_ALIKE, message, help))
        }
    }
}

/// Whether a path is a device's node, a link to it, its place in `/sys`, or that of its parent.
fn is_at(root: &Path, device: &CounterDevice, path: &Path) -> bool {
    let Ok(meant) = root.join(path.strip_prefix("/").unwrap_or(path)).canonicalize() else { return false };
    let place = device.folder.canonicalize().ok();
    let parent = place.as_deref().and_then(Path::parent).map(PathBuf::from);
    let node = device.node.as_deref().and_then(|node| node.canonicalize().ok());
    [place, parent, node].into_iter().flatten().any(|own| own == meant)
}

fn missing(find: &FindCounter, what: &str, machine: &[CounterDevice]) -> Refusal {
    let known: Vec<&str> = match find {
        FindCounter::Name(_) => machine.iter().map(|device| device.name.as_str()).collect(),
        FindCounter::Path(_) => machine.iter().map(|device| device.number.as_str()).collect(),
    };
    let known: Vec<&str> = known.into_iter().filter(|name| !name.is_empty()).collect();
    let meant = match find {
        FindCounter::Name(name) => suggest(name, known.iter().copied()),
        FindCounter::Path(_) => None,
    };
    let help = match (meant, known.is_empty()) {
        (Some(meant), _) => format!("did you mean \"{meant}\"?"),
        (None, true) => {
            "the machine has none at all: is its driver loaded, and the device in the device tree?".to_owned()
        }
        (None, false) => format!("the machine has {}", known.join(", ")),
    };
    Refusal::new(codes::COUNTER_MISSING, format!("no counter has {what}"), help)
}

/// The device and the count that a board file means, which the device can set up as the file says.
///
/// # Errors
/// As [`find`]; the device has no such count, or the count no such function.
pub fn look(root: &Path, spec: &CounterSpec) -> Result<(CounterDevice, HardwareCount), Refusal> {
    let device = find(root, &spec.find)?;
    let is_meant = |count: &&HardwareCount| match &spec.count {
        FindCount::Number(number) => count.number == *number,
        FindCount::Name(name) => count.name == *name,
    };
    let Some(count) = device.counts.iter().find(is_meant).cloned() else {
        let what = match &spec.count {
            FindCount::Number(number) => format!("count {number}"),
            FindCount::Name(name) => format!("count `{name}`"),
        };
        let known = |count: &HardwareCount| match count.name.as_str() {
            "" => count.number.to_string(),
            name => format!("{} (\"{name}\")", count.number),
        };
        let known: Vec<String> = device.counts.iter().map(known).collect();
        let help = format!("its counts are {}", known.join(", "));
        return Err(Refusal::new(codes::COUNT_MISSING, format!("{} has no {what}", named(&device)), help));
    };
    if let Some(function) = spec.function
        && !count.functions.iter().any(|known| known == function.kernel())
    {
        let message = format!("{} does not count by \"{}\"", named(&device), function.name());
        let known: Vec<&str> = crate::counting::CountFunction::ALL
            .iter()
            .filter(|(.., kernel)| count.functions.iter().any(|known| known == kernel))
            .map(|(_, name, _)| *name)
            .collect();
        let help = format!("its functions are {}", known.join(", "));
        return Err(Refusal::new(codes::COUNTER_SETTING, message, help));
    }
    Ok((device, count))
}

/// A device as messages name it.
pub fn named(device: &CounterDevice) -> String {
    let number = match &device.node {
        Some(_) => format!("/dev/{}", device.number),
        None => device.number.clone(),
    };
    if device.name.is_empty() { number } else { format!("{number} ({})", device.name) }
}
