//! Inputs that are read one by one, each when it is asked for.

use std::fs::File;
use std::io;

use host::HostInstant;
use rustix::io::{Errno, pread};
use signal::Span;

use super::info::{IioInput, Scaling};
use crate::adc::{Adc, AdcPace, AdcReading, InRange, Resolution};

/// More than a value of any driver takes.
const VALUE: usize = 64;

/// A device whose inputs are read from their files.
#[derive(Debug)]
pub(super) struct AskedAdc {
    device: String,
    period: Span,
    inputs: Vec<Source>,
    /// Keeps other programs from the device, where it has a node.
    _node: Option<File>,
}

/// An input and its open file.
#[derive(Debug)]
struct Source {
    file: File,
    scaling: Scaling,
    /// The lowest and the highest code, where the driver says.
    ends: Option<(f64, f64)>,
    resolution: Resolution,
}

impl AskedAdc {
    /// Opens the files of these inputs.
    pub(super) fn open(
        device: String,
        period: Span,
        inputs: &[&IioInput],
        node: Option<File>,
    ) -> io::Result<AskedAdc> {
        let source = |input: &&IioInput| {
            let file = File::open(&input.file)?;
            let ends = input.element.map(|(element, _)| (element.lowest() as f64, element.highest() as f64));
            Ok(Source { file, scaling: input.scaling, ends, resolution: input.resolution() })
        };
        let inputs = inputs.iter().map(source).collect::<io::Result<_>>()?;
        Ok(AskedAdc { device, period, inputs, _node: node })
    }
}

impl Adc for AskedAdc {
    fn device(&self) -> &str {
        &self.device
    }

    fn kind(&self) -> &'static str {
        "iio"
    }

    fn pace(&self) -> AdcPace<'_> {
        AdcPace::Asked(self.period)
    }

    fn read(&mut self, out: &mut Vec<AdcReading>) -> io::Result<()> {
        for (input, source) in self.inputs.iter().enumerate() {
            let mut text = [0u8; VALUE];
            let before = HostInstant::now();
            let length = pread(&source.file, &mut text, 0)?;
            let after = HostInstant::now();
            // Only a driver that breaks the rules of /sys says anything but a number.
            let code = number(&text[..length]).ok_or(Errno::BADMSG)?;
            let value = (code + source.scaling.offset) * source.scaling.scale;
            let range = match source.ends {
                Some((lowest, _)) if code <= lowest => InRange::Below,
                Some((_, highest)) if code >= highest => InRange::Above,
                _ => InRange::Yes,
            };
            out.push(AdcReading { input: input as u16, before, after, value, range });
        }
        Ok(())
    }

    fn resolution(&self, input: u16) -> Resolution {
        self.inputs.get(usize::from(input)).map_or(Resolution::default(), |source| source.resolution)
    }
}

/// What a file says, as a number.
fn number(text: &[u8]) -> Option<f64> {
    let number: f64 = std::str::from_utf8(text).ok()?.trim().parse().ok()?;
    Some(number).filter(|number| number.is_finite())
}

#[cfg(test)]
mod tests {
    use super::super::info::list;
    use super::super::made_up::Machine;
    use super::*;

    #[test]
    fn inputs_are_read_and_scaled_each_time_anew() {
        let machine = Machine::new("asked");
        let folder = machine.device(0, "adc");
        for (file, text) in [
            ("in_voltage0_raw", "40960"),
            ("in_voltage1_raw", "65535"),
            ("in_voltage_scale", "0.3125"),
            ("in_voltage_offset", "-32768"),
            ("in_temp_input", "21500"),
            ("scan_elements/in_voltage_type", "le:u16/16>>0"),
            ("scan_elements/in_voltage1_index", "1"),
        ] {
            machine.file(&format!("{folder}/{file}"), text);
        }
        let device = list(machine.root()).remove(0);
        let named = |name| device.inputs.iter().find(|input| input.name == name).unwrap();
        let inputs = [named("temp"), named("voltage0"), named("voltage1")];
        let mut asked = AskedAdc::open("adc".into(), Span::from_millis(1), &inputs, None).unwrap();
        let mut readings = Vec::new();
        asked.read(&mut readings).unwrap();
        let told: Vec<(u16, f64, InRange)> =
            readings.iter().map(|reading| (reading.input, reading.value, reading.range)).collect();
        let top = 32_767.0 * (0.3125 / 1_000.0);
        assert_eq!(told, [(0, 21.5, InRange::Yes), (1, 2.56, InRange::Yes), (2, top, InRange::Above)]);
        assert!(
            readings.windows(2).all(|two| two[0].before <= two[0].after && two[0].after <= two[1].before)
        );
        machine.file(&format!("{folder}/in_voltage0_raw"), "32768");
        readings.clear();
        asked.read(&mut readings).unwrap();
        assert_eq!(readings[1].value, 0.0);
        machine.file(&format!("{folder}/in_voltage0_raw"), "nothing");
        assert_eq!(asked.read(&mut readings).unwrap_err().raw_os_error(), Some(Errno::BADMSG.raw_os_error()));
    }
}
