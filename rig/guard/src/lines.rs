//! Output lines as the guard drives them: all of a claim at once, through a descriptor of its own.

use drivers::{LineApi, OutputClaim};
use gpiocdev_uapi::{Error, v1, v2};
use rustix::io::{Errno, pread, pwrite};
use std::fs::File;
use std::io;

/// A claim on output lines. Bits are lines, in the order of the claim; those outside of the claim are ignored.
pub trait OutputLines: Send {
    /// Drives all lines to these levels.
    ///
    /// # Errors
    /// What the kernel says.
    fn drive(&mut self, levels: u64) -> io::Result<()>;

    /// What the lines are driven to, as the device says.
    ///
    /// # Errors
    /// What the kernel says.
    fn read(&mut self) -> io::Result<u64>;
}

/// Lines of a GPIO chip, behind either of the kernel's interfaces, or an output of a PWM chip.
#[derive(Debug)]
pub struct KernelLines {
    claim: File,
    api: LineApi,
    mask: u64,
}

impl KernelLines {
    /// Takes the claim over.
    pub fn new(held: OutputClaim) -> KernelLines {
        KernelLines { claim: held.claim.into(), api: held.api, mask: held.mask }
    }
}

impl OutputLines for KernelLines {
    fn drive(&mut self, levels: u64) -> io::Result<()> {
        match self.api {
            LineApi::V2 => {
                let values = v2::LineValues { bits: levels, mask: self.mask };
                v2::set_line_values(&self.claim, &values)
            }
            LineApi::V1 { lines } => {
                // The first version knows no mask: lines outside of it keep what they have.
                let mut values = v1::LineValues::default();
                let mask = first(lines);
                if self.mask & mask != mask {
                    v1::get_line_values(&self.claim, &mut values).map_err(plain)?;
                }
                for (line, value) in values.0.iter_mut().enumerate().take(usize::from(lines)) {
                    if self.mask >> line & 1 == 1 {
                        *value = (levels >> line & 1) as u8;
                    }
                }
                v1::set_line_values(&self.claim, &values)
            }
            LineApi::Pwm => return self.rest(levels),
        }
        .map_err(plain)
    }

    fn read(&mut self) -> io::Result<u64> {
        match self.api {
            LineApi::V2 => {
                let mut values = v2::LineValues { bits: 0, mask: self.mask };
                v2::get_line_values(&self.claim, &mut values).map_err(plain)?;
                Ok(values.bits & self.mask)
            }
            LineApi::V1 { lines } => {
                let mut values = v1::LineValues::default();
                v1::get_line_values(&self.claim, &mut values).map_err(plain)?;
                let bits = values.0.iter().enumerate().take(usize::from(lines));
                Ok(bits.fold(0, |bits, (line, value)| bits | u64::from(*value != 0) << line) & self.mask)
            }
            LineApi::Pwm => {
                let mut text = [0; 24];
                let used = pread(&self.claim, &mut text, 0)?;
                // Anything but a 0 and the end of its line is a wave, or nonsense.
                Ok(u64::from(text[..used].trim_ascii() != b"0") & self.mask)
            }
        }
    }
}

impl KernelLines {
    /// Brings an output of a PWM chip to rest: all that can be asked of it without its period.
    fn rest(&self, levels: u64) -> io::Result<()> {
        if levels & self.mask != 0 {
            return Err(Errno::INVAL.into());
        }
        pwrite(&self.claim, b"0\n", 0)?;
        Ok(())
    }
}

/// The bits of the first lines.
fn first(lines: u8) -> u64 {
    1u64.checked_shl(u32::from(lines)).map_or(u64::MAX, |bit| bit - 1)
}

/// The kernel's error number.
fn plain(error: Error) -> io::Error {
    match error {
        Error::Os(number) => io::Error::from_raw_os_error(number.0),
        Error::UnderRead(_) => io::ErrorKind::UnexpectedEof.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_descriptor_that_is_no_claim_is_an_error_of_the_kernel() {
        for api in [LineApi::V2, LineApi::V1 { lines: 2 }] {
            let claim = File::open("/dev/null").unwrap().into();
            let held = OutputClaim { device: "null".into(), claim, api, mask: 1, safe: 0 };
            let mut lines = KernelLines::new(held);
            assert!(lines.drive(0).unwrap_err().raw_os_error().is_some());
            assert!(lines.read().is_err());
        }
    }

    #[test]
    fn an_output_of_a_pwm_chip_is_made_to_rest_and_nothing_else() {
        let path = std::env::temp_dir().join(format!("duty-{}", std::process::id()));
        std::fs::write(&path, "7\n").unwrap();
        let claim = File::options().read(true).write(true).open(&path).unwrap().into();
        let held = OutputClaim { device: "pwmchip0".into(), claim, api: LineApi::Pwm, mask: 1, safe: 0 };
        let mut lines = KernelLines::new(held);
        assert_eq!(lines.read().unwrap(), 1);
        assert!(lines.drive(1).is_err());
        lines.drive(0).unwrap();
        assert_eq!((lines.read().unwrap(), std::fs::read_to_string(&path).unwrap().as_str()), (0, "0\n"));
        std::fs::remove_file(&path).unwrap();
    }

    #[test]
    fn masks_of_the_first_lines_end_at_64() {
        assert_eq!((first(0), first(3), first(64)), (0, 7, u64::MAX));
    }
}
