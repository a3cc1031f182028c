//! What industrial I/O devices a machine has, and what they can measure. Nothing is opened to find out.

use std::path::{Path, PathBuf};

use super::element::Element;
use crate::adc::Resolution;
use crate::inventory::{line, names};

/// Where the kernel lists its devices and triggers.
pub(super) const DEVICES: &str = "sys/bus/iio/devices";

/// A device of the industrial I/O subsystem that measures something.
#[derive(Clone, Debug, PartialEq)]
pub struct IioDevice {
    /// Its folder below `/sys/bus/iio/devices`.
    pub folder: PathBuf,
    /// Its name in the kernel, as in `iio:device0`: it can be another after the next start of the machine.
    pub number: String,
    /// What its driver calls it, as in `ads8688`; may be empty.
    pub name: String,
    /// What the description of the board calls it; may be empty.
    pub label: String,
    /// Its node, as in `/dev/iio:device0`, where it has one.
    pub node: Option<PathBuf>,
    /// Its inputs, as people count.
    pub inputs: Vec<IioInput>,
    /// Samples can be taken into a buffer, with their instants.
    pub buffered: bool,
}

/// An input of a device.
#[derive(Clone, Debug, PartialEq)]
pub struct IioInput {
    /// Its name, as in `voltage0`, `voltage2-voltage3` or `temp`.
    pub name: String,
    /// What the description of the board calls it; may be empty.
    pub label: String,
    /// The unit of its readings, once they are scaled; empty where the kernel defines none.
    pub unit: &'static str,
    /// Its file.
    pub(super) file: PathBuf,
    /// The file shows what the driver made of a code, and not the code.
    made: bool,
    /// From what its file says to the unit.
    pub(super) scaling: Scaling,
    /// How it lies in the buffer, and where among the others, if it can be there.
    pub(super) element: Option<(Element, u32)>,
}

/// `(code + offset) * scale`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scaling {
    pub(super) offset: f64,
    pub(super) scale: f64,
}

impl IioInput {
    /// How finely it is measured. A driver that reports what it made of its codes does not report that.
    pub(super) fn resolution(&self) -> Resolution {
        if self.made {
            return Resolution::default();
        }
        let step = self.scaling.scale.abs();
        let range = self
            .element
            .map(|(element, _)| (element.highest() as f64 - element.lowest() as f64 + 1.0) * step);
        Resolution { step, range }
    }
}

impl Scaling {
    pub(super) fn value(self, code: i128) -> f64 {
        (code as f64 + self.offset) * self.scale
    }
}

/// What a kind of input measures: the unit, and how many of the kernel's units make one.
const QUANTITIES: &[(&str, &str, f64)] = &[
    ("accel", "m/s2", 1.0),
    ("altvoltage", "V", 1_000.0),
    ("angl", "rad", 1.0),
    ("anglvel", "rad/s", 1.0),
    ("capacitance", "nF", 1.0),
    ("concentration", "%", 1.0),
    ("current", "mA", 1.0),
    ("distance", "m", 1.0),
    ("energy", "J", 1.0),
    ("humidityrelative", "%", 1_000.0),
    ("illuminance", "lx", 1.0),
    ("ph", "", 1.0),
    ("positionrelative", "%", 1_000.0),
    ("power", "mW", 1.0),
    ("pressure", "kPa", 1.0),
    ("resistance", "Ohm", 1.0),
    ("temp", "degC", 1_000.0),
    ("voltage", "V", 1_000.0),
];

/// The unit of an input of this name: that of its kind.
pub fn unit_of(name: &str) -> &'static str {
    quantity(name).0
}

/// The unit of an input, and how many of the kernel's units make one.
fn quantity(name: &str) -> (&'static str, f64) {
    let kind = name.split(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or_default();
    let known = QUANTITIES.iter().find(|(known, ..)| *known == kind);
    known.map_or(("", 1.0), |(_, unit, parts)| (unit, *parts))
}

/// The devices of a machine whose `/dev` and `/sys` lie under `root`, as people count. Those without inputs, such as
/// converters in the other direction, are left out.
pub fn list(root: &Path) -> Vec<IioDevice> {
    let folder = root.join(DEVICES);
    let mut numbers: Vec<String> =
        names(&folder).into_iter().filter(|name| name.starts_with("iio:device")).collect();
    numbers.sort_by_key(|name| (name.len(), name.clone()));
    numbers.iter().map(|number| look(root, number)).filter(|device| !device.inputs.is_empty()).collect()
}

/// One device.
pub(super) fn look(root: &Path, number: &str) -> IioDevice {
    let folder = root.join(DEVICES).join(number);
    let node = root.join("dev").join(number);
    let inputs = inputs(&folder);
    let buffered = folder.join("buffer/enable").exists()
        && folder.join("scan_elements/in_timestamp_en").exists()
        && inputs.iter().any(|input| input.element.is_some());
    IioDevice {
        number: number.to_owned(),
        name: line(&folder.join("name")),
        label: line(&folder.join("label")),
        node: node.exists().then_some(node),
        inputs,
        buffered,
        folder,
    }
}

fn inputs(folder: &Path) -> Vec<IioInput> {
    let mut found: Vec<IioInput> = names(folder).iter().filter_map(|file| input(folder, file)).collect();
    // A driver may offer both what it measured and what it made of that: the first says more of it.
    found.sort_by_key(|input| (counted(&input.name), input.made));
    found.dedup_by(|other, kept| other.name == kept.name);
    found.sort_by_key(|input| input.element.map_or(u32::MAX, |(_, index)| index));
    found
}

/// An input by the file that shows its value.
fn input(folder: &Path, file: &str) -> Option<IioInput> {
    let body = file.strip_prefix("in_")?;
    let (name, raw) = match (body.strip_suffix("_raw"), body.strip_suffix("_input")) {
        (Some(name), _) => (name, true),
        (_, Some(name)) => (name, false),
        _ => return None,
    };
    let kind = name.split(|c: char| !c.is_ascii_alphabetic()).next()?;
    // Raw counts and time are no quantities.
    if ["count", "index", "timestamp", "steps", "activity"].contains(&kind) {
        return None;
    }
    let (unit, parts) = quantity(name);
    let number = |what: &str| {
        let files = shared(name).into_iter().map(|name| folder.join(format!("{name}_{what}")));
        files.map(|file| line(&file)).find_map(|text| text.parse::<f64>().ok().filter(|n| n.is_finite()))
    };
    let (offset, scale) =
        if raw { (number("offset").unwrap_or(0.0), number("scale").unwrap_or(1.0)) } else { (0.0, 1.0) };
    let scan = folder.join("scan_elements");
    let index = line(&scan.join(format!("in_{name}_index"))).parse().ok();
    let described = shared(name).into_iter().map(|name| line(&scan.join(format!("{name}_type"))));
    let element = described.filter(|text| !text.is_empty()).find_map(|text| Element::parse(&text));
    Some(IioInput {
        name: name.to_owned(),
        label: line(&folder.join(format!("in_{name}_label"))),
        unit,
        file: folder.join(file),
        made: !raw,
        scaling: Scaling { offset, scale: scale / parts },
        // What is in the buffer is never what a driver made of it.
        element: element.filter(|_| raw).zip(index),
    })
}

/// Where what belongs to an input may stand: with it, with all of its kind, with all of the direction, or of the
/// device.
fn shared(name: &str) -> Vec<String> {
    let letters: String = name.chars().filter(|c| !c.is_ascii_digit()).collect();
    let kind = letters.split('_').next().unwrap_or_default();
    vec![format!("in_{name}"), format!("in_{letters}"), format!("in_{kind}"), "in".to_owned()]
}

/// A key that sorts `voltage10` after `voltage9`.
fn counted(name: &str) -> (String, usize, String) {
    let letters = name.chars().take_while(char::is_ascii_alphabetic).collect();
    (letters, name.len(), name.to_owned())
}

#[cfg(test)]
mod tests {
    use super::super::made_up::Machine;
    use super::*;

    #[test]
    fn a_machine_without_the_subsystem_has_no_device() {
        assert_eq!(list(Machine::new("none").root()), []);
    }

    #[test]
    fn inputs_have_their_scales_units_and_places_in_the_buffer() {
        let machine = Machine::new("inputs");
        let folder = machine.device(0, "ads8688");
        for (file, text) in [
            ("in_voltage0_raw", "32768"),
            ("in_voltage10_raw", "0"),
            ("in_voltage2_raw", "0"),
            ("in_voltage2_scale", "0.5"),
            ("in_voltage_scale", "0.312500000"),
            ("in_voltage_offset", "-32768"),
            ("in_temp_input", "21500"),
            ("in_count0_raw", "3"),
            ("in_voltage0_label", "tank"),
            ("scan_elements/in_voltage0_type", "le:u16/16>>0"),
            ("scan_elements/in_voltage0_index", "0"),
            ("scan_elements/in_timestamp_en", "0"),
            ("buffer/enable", "0"),
        ] {
            machine.file(&format!("{folder}/{file}"), text);
        }
        let devices = list(machine.root());
        let [device] = &devices[..] else { panic!("{devices:?}") };
        assert_eq!((device.name.as_str(), device.number.as_str()), ("ads8688", "iio:device0"));
        assert!(device.buffered && device.node.is_none());
        let names: Vec<(&str, &str)> =
            device.inputs.iter().map(|input| (input.name.as_str(), input.unit)).collect();
        assert_eq!(names, [("voltage0", "V"), ("temp", "degC"), ("voltage2", "V"), ("voltage10", "V")]);
        let values: Vec<f64> =
            device.inputs.iter().map(|input| input.scaling.value(32_768 + 8_192)).collect();
        assert_eq!(values, [2.56, 40.96, 4.096, 2.56]);
        let finely: Vec<Resolution> = device.inputs.iter().map(IioInput::resolution).collect();
        let step = 0.000_312_5;
        assert_eq!(finely[0], Resolution { step, range: Some(65_536.0 * step) });
        assert_eq!(finely[1], Resolution::default(), "what its driver made of it");
        assert_eq!(finely[2], Resolution { step: 0.000_5, range: None });
        assert_eq!(device.inputs[0].label, "tank");
        assert!(device.inputs[0].element.is_some() && device.inputs[2].element.is_none());
    }

    #[test]
    fn what_belongs_to_an_input_is_looked_for_from_near_to_far() {
        assert_eq!(
            shared("voltage2-voltage3"),
            ["in_voltage2-voltage3", "in_voltage-voltage", "in_voltage-voltage", "in"]
        );
        assert_eq!(shared("accel_x"), ["in_accel_x", "in_accel_x", "in_accel", "in"]);
    }
}
