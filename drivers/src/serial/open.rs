//! Opening a serial port and setting it up as asked, or saying in words why not.

use signal::{Parity, SerialSettings};
use std::fmt;
use std::fs::{File, OpenOptions};
use std::io;
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use host::{is_exclusive, low_latency, set_low_latency, set_rs485};
use rustix::fs::{FlockOperation, OFlags, flock, major};
use rustix::io::Errno;
use rustix::termios::{ControlModes, InputModes, OptionalActions, Termios, tcgetattr, tcsetattr};
use tokio_serial::SerialStream;

use super::{PortSpec, SerialCall, SerialError};
use crate::codes;
use crate::holder::{all_holders, holders, words};
use crate::refusal::Refusal;

/// How far the speed of a port may be from what was asked, in parts of a thousand: a receiver samples the last bit of a
/// byte half a bit early or late when both ends are off by a little over 2 % each.
const SPEED_TOLERANCE: u64 = 20;

/// The major numbers of the user's side of pseudo-terminals.
const PSEUDO: std::ops::RangeInclusive<u32> = 136..=143;

/// Why a port is not open.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum OpenError {
    /// A call failed.
    Call(SerialError),
    /// Somebody has it: [`crate::holders`] tells who.
    Busy(PathBuf),
    /// It is no serial port.
    NoPort(PathBuf),
    /// It cannot do what was asked.
    Cannot {
        /// The device as it was named.
        path: PathBuf,
        /// The setting, as it is called in a board file.
        key: &'static str,
        /// What it cannot do.
        what: String,
    },
}

impl OpenError {
    /// Whether it says that there is no such port now.
    pub fn is_gone(&self) -> bool {
        matches!(self, OpenError::Call(error) if error.is_gone())
    }
}

impl From<SerialError> for OpenError {
    fn from(error: SerialError) -> OpenError {
        OpenError::Call(error)
    }
}

impl fmt::Display for OpenError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            OpenError::Call(error) => error.fmt(f),
            OpenError::Busy(path) => write!(f, "{} is held by somebody else", path.display()),
            OpenError::NoPort(path) => write!(f, "{} is no serial port", path.display()),
            OpenError::Cannot { path, what, .. } => write!(f, "{} {what}", path.display()),
        }
    }
}

impl std::error::Error for OpenError {}

/// What it means that a port does not open, and what fixes it.
pub(crate) fn refused(error: &OpenError) -> Refusal {
    let (code, help) = match error {
        OpenError::Busy(path) => {
            let by = all_holders(path);
            let own = !by.is_empty() && by.iter().all(|holder| holder.process == std::process::id());
            let message = format!("{} is held by {}", path.display(), words(&by, "somebody else"));
            let help = match own {
                true => "that is this rig: another line of the board is on the same port",
                false => {
                    "end that program, or take another port; a console on it ends with \
                     `sudo systemctl stop serial-getty@ttyS0`"
                }
            };
            return Refusal::new(codes::SERIAL_BUSY, message, help);
        }
        OpenError::NoPort(_) => {
            (codes::SERIAL_NONE, String::from("name a serial port: `ls /dev/serial/by-id` lists adapters"))
        }
        OpenError::Cannot { key, .. } => {
            (codes::SERIAL_CANNOT, format!("change `{key}`, or take a port whose driver can do it"))
        }
        OpenError::Call(failed) => match Errno::from_raw_os_error(failed.code) {
            Errno::ACCESS | Errno::PERM => {
                let help = format!(
                    "`ls -l {}` shows the group that may: add yourself to it, as in `sudo usermod -aG dialout $USER`, \
                     and log in again",
                    failed.path.display()
                );
                (codes::SERIAL_ACCESS, help)
            }
            _ if error.is_gone() => (
                codes::SERIAL_MISSING,
                String::from("`ls /dev/serial/by-id` lists adapters, `dmesg` says what became of one"),
            ),
            _ => (codes::SERIAL_REFUSED, String::from("`dmesg` shows what the port's driver says")),
        },
    };
    Refusal::new(code, error.to_string(), help)
}

/// An open port.
#[derive(Debug)]
pub(super) struct Opened {
    pub(super) stream: SerialStream,
    /// The same port, for settings.
    pub(super) control: File,
    pub(super) pseudo: bool,
}

/// Opens a port. Its settings stay when it is closed.
pub(super) fn open(spec: &PortSpec) -> Result<Opened, OpenError> {
    let path = &spec.path;
    let control = look(path, spec.exclusive)?;
    let pseudo = control.metadata().is_ok_and(|about| PSEUDO.contains(&major(about.rdev())));
    let name = path.to_str().ok_or_else(|| SerialError::of(path, SerialCall::Open, Errno::INVAL))?;
    let builder = tokio_serial::new(name, spec.line.baud)
        .data_bits(match spec.line.data_bits {
            5 => tokio_serial::DataBits::Five,
            6 => tokio_serial::DataBits::Six,
            7 => tokio_serial::DataBits::Seven,
            _ => tokio_serial::DataBits::Eight,
        })
        .parity(match spec.line.parity {
            Parity::None => tokio_serial::Parity::None,
            Parity::Even => tokio_serial::Parity::Even,
            Parity::Odd => tokio_serial::Parity::Odd,
        })
        .stop_bits(match spec.line.stop_bits {
            2 => tokio_serial::StopBits::Two,
            _ => tokio_serial::StopBits::One,
        })
        .exclusive(spec.exclusive);
    let stream = SerialStream::open(&builder).map_err(|_| SerialError::last(path, SerialCall::Open))?;
    mark_harm(&control).map_err(|error| SerialError::new(path, SerialCall::Settings, &error))?;
    let settings = tcgetattr(&control).map_err(|errno| SerialError::of(path, SerialCall::Settings, errno))?;
    granted(&settings, &spec.line, pseudo).map_err(|(key, what)| OpenError::Cannot {
        path: path.clone(),
        key,
        what,
    })?;
    direction(spec, &control)?;
    latency(spec, &control)?;
    Ok(Opened { stream, control, pseudo })
}

/// Opens a port for a look, without settings. Some drivers raise DTR and RTS when they are opened.
fn look(path: &Path, exclusive: bool) -> Result<File, OpenError> {
    let flags = (OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC).bits() as i32;
    let opened = OpenOptions::new().read(true).write(true).custom_flags(flags).open(path);
    let port = opened.map_err(|error| match error.raw_os_error().map(Errno::from_raw_os_error) {
        Some(Errno::BUSY) => OpenError::Busy(path.to_owned()),
        // A folder, or a file that is no device.
        Some(Errno::ISDIR) => OpenError::NoPort(path.to_owned()),
        _ => SerialError::new(path, SerialCall::Open, &error).into(),
    })?;
    // A superuser may open what is another's alone.
    match is_exclusive(&port) {
        Ok(false) => {}
        Ok(true) => return Err(OpenError::Busy(path.to_owned())),
        Err(error) if error.raw_os_error() == Some(Errno::NOTTY.raw_os_error()) => {
            return Err(OpenError::NoPort(path.to_owned()));
        }
        Err(error) => return Err(SerialError::new(path, SerialCall::Open, &error).into()),
    }
    // The lock that terminal programs take beside it. The library takes it itself, but where it fails to, it takes away
    // the other's claim on the port, too.
    let lock = match exclusive {
        true => FlockOperation::NonBlockingLockExclusive,
        false => FlockOperation::NonBlockingLockShared,
    };
    flock(&port, lock).map_err(|errno| match errno {
        Errno::WOULDBLOCK => OpenError::Busy(path.to_owned()),
        errno => SerialError::of(path, SerialCall::Hold, errno).into(),
    })?;
    flock(&port, FlockOperation::Unlock).map_err(|errno| SerialError::of(path, SerialCall::Hold, errno))?;
    // Who took no lock reads bytes away all the same.
    if exclusive && !holders(path).is_empty() {
        return Err(OpenError::Busy(path.to_owned()));
    }
    Ok(port)
}

/// The kernel marks breaks and damaged bytes among the others, whatever the parity.
fn mark_harm(port: &File) -> io::Result<()> {
    let mut settings = tcgetattr(port)?;
    settings.input_modes.remove(InputModes::IGNBRK | InputModes::BRKINT | InputModes::IGNPAR);
    settings.input_modes.insert(InputModes::PARMRK | InputModes::INPCK);
    Ok(tcsetattr(port, OptionalActions::Now, &settings)?)
}

/// Whether the driver took the settings; else which it did not take, and what it does instead.
fn granted(settings: &Termios, line: &SerialSettings, pseudo: bool) -> Result<(), (&'static str, String)> {
    let (speed, asked) = (u64::from(settings.output_speed()), u64::from(line.baud));
    if speed.abs_diff(asked) * 1_000 > asked * SPEED_TOLERANCE {
        return Err(("baud", format!("cannot do {asked} Bd: it would do {speed} Bd")));
    }
    // A pseudo-terminal has no bits, and says so.
    if pseudo {
        return Ok(());
    }
    let modes = settings.control_modes;
    let size = match line.data_bits {
        5 => ControlModes::CS5,
        6 => ControlModes::CS6,
        7 => ControlModes::CS7,
        _ => ControlModes::CS8,
    };
    if modes & ControlModes::CSIZE != size {
        return Err(("data-bits", format!("cannot do {} data bits", line.data_bits)));
    }
    let parity = match (modes.contains(ControlModes::PARENB), modes.contains(ControlModes::PARODD)) {
        (false, _) => Parity::None,
        (true, false) => Parity::Even,
        (true, true) => Parity::Odd,
    };
    if parity != line.parity {
        return Err(("parity", String::from("cannot do this parity")));
    }
    if modes.contains(ControlModes::CSTOPB) != (line.stop_bits == 2) {
        return Err(("stop-bits", format!("cannot do {} stop bits", line.stop_bits)));
    }
    Ok(())
}

fn not_able(error: &io::Error) -> bool {
    [Errno::NOTTY, Errno::INVAL, Errno::OPNOTSUPP]
        .iter()
        .any(|errno| error.raw_os_error() == Some(errno.raw_os_error()))
}

fn direction(spec: &PortSpec, port: &File) -> Result<(), OpenError> {
    let Some(wanted) = spec.rs485 else { return Ok(()) };
    let cannot = |what: String| OpenError::Cannot { path: spec.path.clone(), key: "rs485", what };
    let granted = set_rs485(port, wanted).map_err(|error| match not_able(&error) {
        true => cannot(String::from("has a driver that does not drive the direction of RS-485")),
        false => SerialError::new(&spec.path, SerialCall::Rs485, &error).into(),
    })?;
    // What is switched off has no further settings.
    if granted == wanted || (!wanted.enabled && !granted.enabled) {
        return Ok(());
    }
    let level = |high| if high { "high" } else { "low" };
    let what = if granted.enabled != wanted.enabled {
        String::from("does not drive the direction of RS-485")
    } else if granted.rts_on_send != wanted.rts_on_send {
        format!("cannot send with RTS {}", level(wanted.rts_on_send))
    } else if granted.rx_during_tx != wanted.rx_during_tx {
        format!(
            "{} what it sends, whatever is asked",
            if granted.rx_during_tx { "hears" } else { "cannot hear" }
        )
    } else if granted.terminate != wanted.terminate {
        String::from("has no resistor of its own to end the bus")
    } else {
        format!(
            "cannot keep the delays: it would take {} ms and {} ms",
            granted.delay_before, granted.delay_after
        )
    };
    Err(cannot(what))
}

fn latency(spec: &PortSpec, port: &File) -> Result<(), OpenError> {
    let Some(wanted) = spec.low_latency else { return Ok(()) };
    let cannot = |what: &str| OpenError::Cannot {
        path: spec.path.clone(),
        key: "low-latency",
        what: String::from(what),
    };
    let set = set_low_latency(port, wanted).and_then(|()| low_latency(port));
    match set {
        Ok(granted) if granted == wanted => Ok(()),
        Ok(_) => Err(cannot("keeps its latency, whatever is asked")),
        Err(error) if not_able(&error) => Err(cannot("has a driver without a setting of its latency")),
        Err(error) => Err(SerialError::new(&spec.path, SerialCall::LowLatency, &error).into()),
    }
}
