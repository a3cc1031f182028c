//! What GPIO chips and lines there are, and who holds them. Nothing is claimed to find out.

use std::fs::OpenOptions;
use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use rustix::fs::OFlags;

use super::error::{GpioCall, GpioError};

/// Through which of the kernel's interfaces lines are claimed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Backend {
    /// The first interface: no debounce, sixteen edges of room for a line, and a lost edge cannot be noticed.
    V1,
    /// The second one, since Linux 5.10.
    V2,
}

impl Backend {
    /// Its name in a board file.
    pub const fn name(self) -> &'static str {
        match self {
            Backend::V1 => "v1",
            Backend::V2 => "v2",
        }
    }
}

/// Which way a line goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Direction {
    /// It is read.
    Input,
    /// It is driven.
    Output,
}

/// What pulls a line that nobody drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Bias {
    /// A resistor to the supply.
    PullUp,
    /// A resistor to 0 V.
    PullDown,
    /// Nothing.
    Disabled,
}

/// How an output drives its two levels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Drive {
    /// Both.
    #[default]
    PushPull,
    /// 0 only; at 1 it lets go.
    OpenDrain,
    /// 1 only; at 0 it lets go.
    OpenSource,
}

/// A line as it is now.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LineInfo {
    /// Its number on the chip.
    pub number: u32,
    /// Its name, where the chip gives it one. Names need not be unique.
    pub name: Option<String>,
    /// Somebody holds it: a program, or a driver in the kernel.
    pub used: bool,
    /// What its holder calls itself, if it says so.
    pub consumer: Option<String>,
    /// Which way it goes.
    pub direction: Direction,
    /// Its holder takes a low level for 1.
    pub active_low: bool,
    /// Its pull, if one is set and the interface says so.
    pub bias: Option<Bias>,
    /// How an output drives.
    pub drive: Option<Drive>,
    /// The interface through which this was asked.
    pub backend: Backend,
}

impl LineInfo {
    /// Who holds the line, in words; `None` for a free one.
    pub fn holder(&self) -> Option<&str> {
        self.used.then(|| self.consumer.as_deref().unwrap_or("a driver of the kernel"))
    }
}

/// A chip with its lines as they are now.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChipInfo {
    /// Its device, as in `/dev/gpiochip0`.
    pub path: PathBuf,
    /// Its name, as in `gpiochip0`: it can be another after the next start of the machine.
    pub name: String,
    /// What its driver calls it, as in `pinctrl-bcm2711`: it stays.
    pub label: String,
    /// The best interface that the kernel offers for it.
    pub backend: Backend,
    /// Its lines by number.
    pub lines: Vec<LineInfo>,
}

/// Every GPIO chip of the machine, in the order of their numbers; an error where one cannot be looked at, for
/// want of permission as a rule. Empty on a machine without GPIO.
///
/// # Errors
/// The devices cannot be listed at all.
pub fn list() -> Result<Vec<Result<ChipInfo, GpioError>>, GpioError> {
    let paths = gpiocdev::chip::chips().map_err(|error| GpioError::v2("/dev", GpioCall::List, &error))?;
    Ok(paths.iter().map(|path| look(path)).collect())
}

/// One chip.
///
/// # Errors
/// It cannot be opened or asked; a path that is no GPIO chip is `ENODEV`.
pub fn look(path: &Path) -> Result<ChipInfo, GpioError> {
    let failed = |call, error: &gpiocdev::Error| GpioError::v2(path, call, error);
    let unopened = |error: &std::io::Error| GpioError::new(path, GpioCall::Open, error);
    let no_chip = || GpioError { device: path.into(), call: GpioCall::Open, errno: rustix::io::Errno::NODEV };
    // What the board file names may be a pipe, whose opening waits for whoever writes into it.
    let about = std::fs::metadata(path).map_err(|error| unopened(&error))?;
    if !about.file_type().is_char_device() {
        return Err(no_chip());
    }
    let flags = i32::try_from(OFlags::NONBLOCK.bits()).unwrap_or(0);
    let opened = OpenOptions::new().read(true).custom_flags(flags).open(path);
    drop(opened.map_err(|error| unopened(&error))?);
    let chip = match gpiocdev::chip::Chip::from_path(path) {
        Ok(chip) => chip,
        Err(gpiocdev::Error::GpioChip(..)) => return Err(no_chip()),
        Err(error) => return Err(failed(GpioCall::Open, &error)),
    };
    let info = chip.info().map_err(|error| failed(GpioCall::ChipInfo, &error))?;
    // A chip without lines has nothing to be asked with, and nothing to claim.
    let backend = match info.num_lines == 0 || chip.line_info(0).is_ok() {
        true => Backend::V2,
        false => Backend::V1,
    };
    let lines = match backend {
        Backend::V2 => (0..info.num_lines)
            .map(|number| chip.line_info(number).map(line_v2))
            .collect::<Result<_, _>>()
            .map_err(|error| failed(GpioCall::LineInfo, &error))?,
        Backend::V1 => lines_v1(chip.path())?,
    };
    let path = chip.path().to_path_buf();
    Ok(ChipInfo { path, name: info.name, label: info.label, backend, lines })
}

fn some(text: String) -> Option<String> {
    if text.is_empty() { None } else { Some(text) }
}

fn line_v2(line: gpiocdev::line::Info) -> LineInfo {
    use gpiocdev::line;
    LineInfo {
        number: line.offset,
        name: some(line.name),
        used: line.used,
        consumer: some(line.consumer),
        direction: match line.direction {
            line::Direction::Input => Direction::Input,
            line::Direction::Output => Direction::Output,
        },
        active_low: line.active_low,
        bias: line.bias.map(|bias| match bias {
            line::Bias::PullUp => Bias::PullUp,
            line::Bias::PullDown => Bias::PullDown,
            line::Bias::Disabled => Bias::Disabled,
        }),
        drive: line.drive.map(|drive| match drive {
            line::Drive::PushPull => Drive::PushPull,
            line::Drive::OpenDrain => Drive::OpenDrain,
            line::Drive::OpenSource => Drive::OpenSource,
        }),
        backend: Backend::V2,
    }
}

fn lines_v1(path: &Path) -> Result<Vec<LineInfo>, GpioError> {
    let chip = gpio_cdev::Chip::new(path).map_err(|error| GpioError::v1(path, GpioCall::Open, &error))?;
    let line = |line: gpio_cdev::Line| {
        let info = line.info().map_err(|error| GpioError::v1(path, GpioCall::LineInfo, &error))?;
        let output = info.direction() == gpio_cdev::LineDirection::Out;
        Ok(LineInfo {
            number: line.offset(),
            name: info.name().map(str::to_owned),
            used: info.is_kernel(),
            consumer: info.consumer().map(str::to_owned),
            direction: if output { Direction::Output } else { Direction::Input },
            active_low: info.is_active_low(),
            bias: None,
            drive: output.then(|| match (info.is_open_drain(), info.is_open_source()) {
                (true, _) => Drive::OpenDrain,
                (_, true) => Drive::OpenSource,
                _ => Drive::PushPull,
            }),
            backend: Backend::V1,
        })
    };
    chip.lines().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_machine_without_chips_has_an_empty_list_and_other_files_are_no_chips() {
        assert!(list().is_ok());
        let error = look(Path::new("/dev/null")).unwrap_err();
        assert_eq!((error.call, error.errno), (GpioCall::Open, rustix::io::Errno::NODEV));
        let error = look(Path::new("/dev/gpiochip-none")).unwrap_err();
        assert_eq!(
            error.to_string(),
            "opening /dev/gpiochip-none failed: No such file or directory (os error 2)"
        );
    }
}
