//! From what a board file says to a device and its inputs.

use std::path::{Path, PathBuf};

use document::suggest;

use super::info::{IioDevice, IioInput, list};
use super::spec::{FindDevice, IioSpec};
use crate::adc::{FindInput, SampleSpec};
use crate::codes;
use crate::refusal::Refusal;

/// The device that a board file means, on the machine whose `/dev` and `/sys` lie under `root`. Nothing is opened.
///
/// # Errors
/// There is none, or several answer to this.
pub fn find(root: &Path, spec: &IioSpec) -> Result<IioDevice, Refusal> {
    let machine = list(root);
    let (what, matches): (String, Vec<&IioDevice>) = match &spec.find {
        FindDevice::Name(name) => {
            (format!("the name \"{name}\""), machine.iter().filter(|device| device.name == *name).collect())
        }
        FindDevice::Label(label) => (
            format!("the label \"{label}\""),
            machine.iter().filter(|device| device.label == *label).collect(),
        ),
        FindDevice::Path(path) => (
            format!("the path \"{}\"", path.display()),
            machine.iter().filter(|device| is_at(root, device, path)).collect(),
        ),
    };
    match matches[..] {
        [one] => Ok(one.clone()),
        [] => Err(missing(&spec.find, &what, &machine)),
        _ => {
            let numbers: Vec<&str> = matches.iter().map(|device| device.number.as_str()).collect();
            let message =
                format!("{} devices of the machine have {what}: {}", numbers.len(), numbers.join(", "));
            let help = "say which by `label`, or by `path`: what `readlink -f` says of its place below \
                        /sys/bus/iio/devices stays the same";
            Err(Refusal::new(codes::IIO_ALIKE, message, help))
        }
    }
}

/// Whether a path is a device's node, a link to it, its place in `/sys`, or that of its parent.
fn is_at(root: &Path, device: &IioDevice, path: &Path) -> bool {
    let below = |path: &Path| root.join(path.strip_prefix("/").unwrap_or(path));
    let Ok(meant) = below(path).canonicalize() else { return false };
    let place = device.folder.canonicalize().ok();
    let parent = place.as_deref().and_then(Path::parent).map(PathBuf::from);
    let node = device.node.as_deref().and_then(|node| node.canonicalize().ok());
    [place, parent, node].into_iter().flatten().any(|own| own == meant)
}

fn missing(find: &FindDevice, what: &str, machine: &[IioDevice]) -> Refusal {
    let (wanted, known): (&str, Vec<&str>) = match find {
        FindDevice::Name(name) => (name, machine.iter().map(|device| device.name.as_str()).collect()),
        FindDevice::Label(label) => (label, machine.iter().map(|device| device.label.as_str()).collect()),
        FindDevice::Path(_) => ("", machine.iter().map(|device| device.number.as_str()).collect()),
    };
    let known: Vec<&str> = known.into_iter().filter(|name| !name.is_empty()).collect();
    let help = match (suggest(wanted, known.iter().copied()), known.is_empty()) {
        (Some(meant), _) => format!("did you mean \"{meant}\"?"),
        (None, true) => {
            "the machine has none with that at all: is its driver loaded, and the device in the device \
                         tree?"
                .to_owned()
        }
        (None, false) => format!("the machine has {}", known.join(", ")),
    };
    Refusal::new(codes::IIO_MISSING, format!("no industrial I/O device has {what}"), help)
}

/// The inputs behind channels, by their places in [`IioDevice::inputs`].
///
/// # Errors
/// All that the device does not have.
pub fn inputs(device: &IioDevice, samples: &[SampleSpec]) -> Result<Vec<usize>, Vec<Refusal>> {
    let mut refused = Vec::new();
    let mut found = Vec::new();
    for sample in samples {
        match input(device, &sample.input) {
            Some(at) => found.push(at),
            None => refused.push(no_input(device, sample)),
        }
    }
    if refused.is_empty() { Ok(found) } else { Err(refused) }
}

/// The input of this number or name.
fn input(device: &IioDevice, find: &FindInput) -> Option<usize> {
    let only = |is: &dyn Fn(&IioInput) -> bool| {
        let mut all = device.inputs.iter().enumerate().filter(|(_, input)| is(input));
        let first = all.next()?.0;
        all.next().is_none().then_some(first)
    };
    match find {
        FindInput::Number(number) => {
            let voltage = format!("voltage{number}");
            let numbered = |input: &IioInput| {
                let digits = input.name.trim_start_matches(|c: char| c.is_ascii_alphabetic());
                digits.parse() == Ok(*number)
            };
            only(&|input| input.name == voltage).or_else(|| only(&numbered))
        }
        FindInput::Name(name) => {
            only(&|input| input.name == *name).or_else(|| only(&|input| input.label == *name))
        }
    }
}

fn no_input(device: &IioDevice, sample: &SampleSpec) -> Refusal {
    let names: Vec<&str> = device.inputs.iter().map(|input| input.name.as_str()).collect();
    let (what, meant) = match &sample.input {
        FindInput::Number(number) => (format!("input {number}"), None),
        FindInput::Name(name) => (format!("input `{name}`"), suggest(name, names.iter().copied())),
    };
    let help = match meant {
        Some(meant) => format!("did you mean \"{meant}\"?"),
        None => format!("its inputs are {}", names.join(", ")),
    };
    let message = format!("{} has no {what}", named(device));
    Refusal::new(codes::IIO_INPUT, message, help).at(sample.place.clone())
}

/// A device, as messages name it.
pub fn named(device: &IioDevice) -> String {
    let called = if device.label.is_empty() { &device.name } else { &device.label };
    if called.is_empty() { device.number.clone() } else { format!("{} ({called})", device.number) }
}

#[cfg(test)]
mod tests {
    use super::super::made_up::Machine;
    use super::*;

    fn machine(name: &str) -> Machine {
        let machine = Machine::new(name);
        for (number, chip) in [(0, "ads8688"), (1, "ads8688"), (2, "mcp3422")] {
            let folder = machine.device(number, chip);
            machine.file(&format!("dev/iio:device{number}"), "");
            machine.file(&format!("{folder}/label"), &format!("rack-{number}"));
            for input in ["voltage0", "voltage1", "voltage0-voltage1", "temp2"] {
                machine.file(&format!("{folder}/in_{input}_raw"), "0");
            }
            machine.file(&format!("{folder}/in_voltage1_label"), "tank");
        }
        machine
    }

    fn by(find: FindDevice) -> IioSpec {
        IioSpec { find, buffered: None }
    }

    #[test]
    fn devices_are_found_by_name_label_and_path() {
        let machine = machine("find");
        let number = |spec| find(machine.root(), &by(spec)).map(|device| device.number);
        assert_eq!(number(FindDevice::Name("mcp3422".into())).unwrap(), "iio:device2");
        assert_eq!(number(FindDevice::Label("rack-1".into())).unwrap(), "iio:device1");
        assert_eq!(number(FindDevice::Path("/dev/iio:device0".into())).unwrap(), "iio:device0");
        assert_eq!(
            number(FindDevice::Path("/sys/bus/iio/devices/iio:device1".into())).unwrap(),
            "iio:device1"
        );
        let alike = number(FindDevice::Name("ads8688".into())).unwrap_err();
        assert_eq!(alike.code, codes::IIO_ALIKE);
        assert!(alike.message.ends_with("iio:device0, iio:device1"), "{}", alike.message);
        let typo = number(FindDevice::Name("mcp3421".into())).unwrap_err();
        assert_eq!((typo.code, typo.help.as_str()), (codes::IIO_MISSING, "did you mean \"mcp3422\"?"));
        assert_eq!(number(FindDevice::Path("/dev/iio:device7".into())).unwrap_err().code, codes::IIO_MISSING);
    }

    #[test]
    fn inputs_are_found_by_number_name_and_label() {
        let machine = machine("find-inputs");
        let device = find(machine.root(), &by(FindDevice::Label("rack-0".into()))).unwrap();
        let of = |find| input(&device, &find).map(|at| device.inputs[at].name.as_str());
        assert_eq!(of(FindInput::Number(1)), Some("voltage1"));
        assert_eq!(of(FindInput::Number(2)), Some("temp2"));
        assert_eq!(of(FindInput::Name("voltage0-voltage1".into())), Some("voltage0-voltage1"));
        assert_eq!(of(FindInput::Name("tank".into())), Some("voltage1"));
        assert_eq!(of(FindInput::Number(3)), None);
    }
}
