//! Triggers: what starts each scan of a device.

use std::fs;
use std::path::{Path, PathBuf};

use document::suggest;
use signal::Span;

use super::files::{read, write};
use super::info::{DEVICES, IioDevice};
use crate::codes;
use crate::inventory::{line, names};
use crate::refusal::Refusal;

/// Where timers are made.
const TIMERS: &str = "sys/kernel/config/iio/triggers/hrtimer";

/// The kernel takes frequencies in thousandths of a Hz.
const THOUSANDTHS: i64 = 1_000;

/// How far the kernel's frequency may be from what was asked for, in parts of it.
const TOLERANCE: f64 = 0.01;

/// A trigger of the machine. One that the rig made goes when this is dropped.
#[derive(Debug)]
pub(super) struct Trigger {
    pub(super) name: String,
    folder: PathBuf,
    own: Option<PathBuf>,
}

impl Trigger {
    /// The trigger of this name.
    pub(super) fn named(root: &Path, name: &str) -> Result<Trigger, Refusal> {
        let all = triggers(root);
        match all.iter().find(|(_, known)| known == name) {
            Some((folder, name)) => Ok(Trigger { name: name.clone(), folder: folder.clone(), own: None }),
            None => {
                let known: Vec<&str> = all.iter().map(|(_, name)| name.as_str()).collect();
                let help = match (suggest(name, known.iter().copied()), known.is_empty()) {
                    (Some(meant), _) => format!("did you mean \"{meant}\"?"),
                    (None, true) => {
                        "leave `trigger` out and write `buffered = true`: the rig makes a timer of its own"
                            .to_owned()
                    }
                    (None, false) => format!("the machine has {}", known.join(", ")),
                };
                Err(Refusal::new(codes::IIO_TRIGGER, format!("the machine has no trigger `{name}`"), help))
            }
        }
    }

    /// A timer of the rig's own for a device.
    pub(super) fn timer(root: &Path, device: &IioDevice) -> Result<Trigger, Refusal> {
        let name = format!("rig-{}", device.number);
        let timers = root.join(TIMERS);
        if !timers.is_dir() {
            let message = "this kernel makes no timers for industrial I/O";
            let help = format!(
                "load them: `sudo modprobe iio-trig-hrtimer`, with configfs mounted; or name a trigger that is there: {}",
                triggers(root).into_iter().map(|(_, name)| name).collect::<Vec<_>>().join(", ")
            );
            return Err(Refusal::new(codes::IIO_TRIGGER, message, help));
        }
        let own = timers.join(&name);
        // One that is there was left behind by a rig that was killed: nobody else uses this name.
        if let Err(error) = fs::create_dir(&own)
            && error.kind() != std::io::ErrorKind::AlreadyExists
        {
            let message = format!("{} cannot be made: {error}", own.display());
            let help = "let the user make it: run the rig with the rights for it, or make a trigger once and name it \
                        by `trigger`";
            return Err(Refusal::new(codes::IIO_TRIGGER, message, help));
        }
        let mut trigger = Trigger::named(root, &name)?;
        trigger.own = Some(own);
        Ok(trigger)
    }

    /// Whether it starts the conversion: a timer and what a program fires do. Any other reports that one is done.
    pub(super) fn starts(&self) -> bool {
        self.folder.join("sampling_frequency").exists() || self.folder.join("trigger_now").exists()
    }

    /// Sets how often it comes, where it or else the device takes that.
    pub(super) fn pace(&self, device: &Path, period: Span) -> Result<(), Refusal> {
        let own = self.folder.join("sampling_frequency");
        // What fires when somebody says so has no frequency.
        let file = match () {
            () if own.exists() => own,
            () if self.folder.join("trigger_now").exists() => return Ok(()),
            () => device.join("sampling_frequency"),
        };
        if !file.exists() {
            return Ok(());
        }
        let wanted = frequency(period);
        let refused = |message: String| {
            let offered = line(&file.with_file_name("sampling_frequency_available"));
            let help = match offered.is_empty() {
                true => "take another `period`".to_owned(),
                false => format!("take a `period` that is one of these frequencies: {offered}"),
            };
            Refusal::new(codes::IIO_SETTING, message, help)
        };
        write(&file, &wanted).map_err(|error| refused(error.to_string()))?;
        let set = read(&file).map_err(|error| refused(error.to_string()))?;
        let (asked, got) = (wanted.parse().unwrap_or(0.0), set.parse().unwrap_or(0.0));
        let off: f64 = got - asked;
        if off.abs() > asked * TOLERANCE {
            return Err(refused(format!("{} is {set} Hz where {wanted} Hz were asked for", file.display())));
        }
        Ok(())
    }
}

impl Drop for Trigger {
    fn drop(&mut self) {
        if let Some(own) = &self.own {
            // Where it cannot be taken back, the next run finds and uses it.
            let _ = fs::remove_dir(own);
        }
    }
}

/// The frequency of a period in Hz with three digits after the point, as the kernel takes it.
fn frequency(period: Span) -> String {
    let period = period.as_nanos().max(1);
    let thousandths = (1_000_000_000 * THOUSANDTHS + period / 2) / period;
    format!("{}.{:03}", thousandths / THOUSANDTHS, thousandths % THOUSANDTHS)
}

/// The triggers of the machine: folders and names.
fn triggers(root: &Path) -> Vec<(PathBuf, String)> {
    let folder = root.join(DEVICES);
    let all = names(&folder).into_iter().filter(|name| name.starts_with("trigger"));
    all.map(|number| folder.join(number)).map(|folder| (folder.clone(), line(&folder.join("name")))).collect()
}

#[cfg(test)]
mod tests {
    use super::super::info::look;
    use super::super::made_up::Machine;
    use super::*;

    #[test]
    fn frequencies_have_three_digits_behind_the_point() {
        let of = |nanos| frequency(Span::from_nanos(nanos));
        assert_eq!([of(1_000_000), of(10_000_000_000), of(3_000_000)], ["1000.000", "0.100", "333.333"]);
    }

    #[test]
    fn a_trigger_is_found_by_name_and_paced() {
        let machine = Machine::new("trigger");
        let folder = machine.device(0, "adc");
        machine.file("sys/bus/iio/devices/trigger0/name", "bench");
        machine.file("sys/bus/iio/devices/trigger0/sampling_frequency", "100.000");
        machine.file("sys/bus/iio/devices/trigger1/name", "adc-dev0");
        let (root, device) = (machine.root(), machine.root().join(&folder));
        let bench = Trigger::named(root, "bench").unwrap();
        bench.pace(&device, Span::from_millis(2)).unwrap();
        assert_eq!(machine.text("sys/bus/iio/devices/trigger0/sampling_frequency"), "500.000");
        assert!(bench.starts());
        let ready = Trigger::named(root, "adc-dev0").unwrap();
        ready.pace(&device, Span::from_millis(2)).unwrap();
        assert!(!ready.starts());
        let typo = Trigger::named(root, "bensh").unwrap_err();
        assert_eq!((typo.code, typo.help.as_str()), (codes::IIO_TRIGGER, "did you mean \"bench\"?"));
        // A kernel without timers says so.
        assert_eq!(Trigger::timer(root, &look(root, "iio:device0")).unwrap_err().code, codes::IIO_TRIGGER);
    }
}
