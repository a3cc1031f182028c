//! Opening a serial port and setting it up as asked, or saying why not.

use signal::{Parity, SerialSettings};
use std::fs::{self, File, OpenOptions};
use std::io;
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use host::{is_exclusive, low_latency, set_low_latency, set_rs485};
use rustix::fs::{FlockOperation, OFlags, flock, major};
use rustix::io::Errno;
use rustix::termios::{ControlModes, InputModes, OptionalActions, Termios, tcgetattr, tcsetattr};
use thiserror::Error;
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
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum OpenError {
    /// A call failed.
    #[error(transparent)]
    Call(#[from] SerialError),
    /// Somebody has it: [`crate::holders`] tells who.
    #[error("{} is held by somebody else", .0.display())]
    Busy(PathBuf),
    /// It is no serial port.
    #[error("{} is no serial port", .0.display())]
    NoPort(PathBuf),
    /// It cannot do what was asked.
    #[error("{} {what}", .path.display())]
    Unable {
        /// The device as it was named.
        path: PathBuf,
        /// What it cannot do.
        #[source]
        what: UnsupportedSetting,
    },
}

/// What a port or its driver cannot do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum UnsupportedSetting {
    /// The speed, in Bd, and what it would do in its place.
    #[error("cannot do {asked} Bd: it would do {does} Bd")]
    Speed {
        /// What was asked.
        asked: u64,
        /// What it would do.
        does: u64,
    },
    /// So many data bits.
    #[error("cannot do {0} data bits")]
    DataBits(u8),
    /// The parity.
    #[error("cannot do this parity")]
    Parity,
    /// So many stop bits.
    #[error("cannot do {0} stop bits")]
    StopBits(u8),
    /// Its driver knows nothing of RS-485.
    #[error("has a driver that does not drive the direction of RS-485")]
    Rs485,
    /// The direction of RS-485 stays off, or on.
    #[error("does not drive the direction of RS-485")]
    Direction,
    /// RTS high while it sends.
    #[error("cannot send with RTS high")]
    RtsHighOnSend,
    /// RTS low while it sends.
    #[error("cannot send with RTS low")]
    RtsLowOnSend,
    /// Not to hear itself.
    #[error("hears what it sends, whatever is asked")]
    HearsItself,
    /// To hear itself.
    #[error("cannot hear what it sends, whatever is asked")]
    CannotHearItself,
    /// A resistor of its own.
    #[error("has no resistor of its own to end the bus")]
    Termination,
    /// The delays around the direction; what it would take, in milliseconds.
    #[error("cannot keep the delays: it would take {before} ms and {after} ms")]
    Delays {
        /// Before the first bit.
        before: u32,
        /// After the last bit.
        after: u32,
    },
    /// Another latency than it has.
    #[error("keeps its latency, whatever is asked")]
    Latency,
    /// Its driver knows nothing of a latency.
    #[error("has a driver without a setting of its latency")]
    NoLatency,
}

impl UnsupportedSetting {
    /// The setting, as it is called in a board file.
    pub const fn key(self) -> &'static str {
        match self {
            UnsupportedSetting::Speed { .. } => "baud",
            UnsupportedSetting::DataBits(_) => "data-bits",
            UnsupportedSetting::Parity => "parity",
            UnsupportedSetting::StopBits(_) => "stop-bits",
            UnsupportedSetting::Rs485
            | UnsupportedSetting::Direction
            | UnsupportedSetting::RtsHighOnSend
            | UnsupportedSetting::RtsLowOnSend
            | UnsupportedSetting::HearsItself
            | UnsupportedSetting::CannotHearItself
            | UnsupportedSetting::Termination
            | UnsupportedSetting::Delays { .. } => "rs485",
            UnsupportedSetting::Latency | UnsupportedSetting::NoLatency => "low-latency",
        }
    }
}

impl OpenError {
    /// Whether it says that there is no such port now.
    pub fn is_gone(&self) -> bool {
        matches!(self, OpenError::Call(error) if error.is_gone())
    }
}

/// What it means that a port does not open, and what fixes it.
pub(crate) fn refused(error: &OpenError) -> Refusal {
    let (code, help) = match error {
        OpenError::Busy(path) => {
            let by = all_holders(path);
            let own = !by.is_empty() && by.iter().all(|holder| holder.process == std::process::id());
            let message = format!("{} is held by {}", path.display(), words(&by, "somebody else"));
            let help = match own {
                true => "that is this rig: another line of the board is on the same port",
                false if by.is_empty() && path.starts_with("/dev/pts") => {
                    "a program that was killed leaves its claim on a pseudo-terminal: make the pair again, as by \
                     starting `socat` again"
                }
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
        OpenError::Unable { what, .. } => {
            (codes::SERIAL_CANNOT, format!("change `{}`, or take a port whose driver can do it", what.key()))
        }
        OpenError::Call(failed) => match failed.errno {
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
    let pseudo = is_pseudo(&control);
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
    granted(&settings, &spec.line, pseudo).map_err(|what| OpenError::Unable { path: path.clone(), what })?;
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
        // The flag of a pseudo-terminal outlives a killed program as long as its other end is open.
        Ok(true) if is_pseudo(&port) && !is_open_elsewhere(path, &port) => {}
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

/// Whether a port is a pseudo-terminal.
fn is_pseudo(port: &File) -> bool {
    port.metadata().is_ok_and(|about| PSEUDO.contains(&major(about.rdev())))
}

/// Whether anybody else has this port open: another process, as far as this user may see, or another file of this one.
fn is_open_elsewhere(path: &Path, port: &File) -> bool {
    let Ok(about) = port.metadata() else { return true };
    let files = fs::read_dir("/proc/self/fd").into_iter().flatten().flatten();
    let same =
        |file: &fs::DirEntry| fs::metadata(file.path()).is_ok_and(|other| other.rdev() == about.rdev());
    files.filter(same).count() > 1 || !holders(path).is_empty()
}

/// The kernel marks breaks and damaged bytes among the others, whatever the parity.
fn mark_harm(port: &File) -> io::Result<()> {
    let mut settings = tcgetattr(port)?;
    settings.input_modes.remove(InputModes::IGNBRK | InputModes::BRKINT | InputModes::IGNPAR);
    settings.input_modes.insert(InputModes::PARMRK | InputModes::INPCK);
    Ok(tcsetattr(port, OptionalActions::Now, &settings)?)
}

/// Whether the driver took the settings; else which it did not take, and what it does instead.
fn granted(settings: &Termios, line: &SerialSettings, pseudo: bool) -> Result<(), UnsupportedSetting> {
    let (speed, asked) = (u64::from(settings.output_speed()), u64::from(line.baud));
    if speed.abs_diff(asked) * 1_000 > asked * SPEED_TOLERANCE {
        return Err(UnsupportedSetting::Speed { asked, does: speed });
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
        return Err(UnsupportedSetting::DataBits(line.data_bits));
    }
    let parity = match (modes.contains(ControlModes::PARENB), modes.contains(ControlModes::PARODD)) {
        (false, _) => Parity::None,
        (true, false) => Parity::Even,
        (true, true) => Parity::Odd,
    };
    if parity != line.parity {
        return Err(UnsupportedSetting::Parity);
    }
    if modes.contains(ControlModes::CSTOPB) != (line.stop_bits == 2) {
        return Err(UnsupportedSetting::StopBits(line.stop_bits));
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
    let unable = |what| OpenError::Unable { path: spec.path.clone(), what };
    let granted = set_rs485(port, wanted).map_err(|error| match not_able(&error) {
        true => unable(UnsupportedSetting::Rs485),
        false => SerialError::new(&spec.path, SerialCall::Rs485, &error).into(),
    })?;
    // What is switched off has no further settings.
    if granted == wanted || (!wanted.enabled && !granted.enabled) {
        return Ok(());
    }
    Err(unable(if granted.enabled != wanted.enabled {
        UnsupportedSetting::Direction
    } else if granted.rts_on_send != wanted.rts_on_send {
        match wanted.rts_on_send {
            true => UnsupportedSetting::RtsHighOnSend,
            false => UnsupportedSetting::RtsLowOnSend,
        }
    } else if granted.rx_during_tx != wanted.rx_during_tx {
        match granted.rx_during_tx {
            true => UnsupportedSetting::HearsItself,
            false => UnsupportedSetting::CannotHearItself,
        }
    } else if granted.terminate != wanted.terminate {
        UnsupportedSetting::Termination
    } else {
        UnsupportedSetting::Delays { before: granted.delay_before, after: granted.delay_after }
    }))
}

fn latency(spec: &PortSpec, port: &File) -> Result<(), OpenError> {
    let Some(wanted) = spec.low_latency else { return Ok(()) };
    let unable = |what| OpenError::Unable { path: spec.path.clone(), what };
    let set = set_low_latency(port, wanted).and_then(|()| low_latency(port));
    match set {
        Ok(granted) if granted == wanted => Ok(()),
        Ok(_) => Err(unable(UnsupportedSetting::Latency)),
        Err(error) if not_able(&error) => Err(unable(UnsupportedSetting::NoLatency)),
        Err(error) => Err(SerialError::new(&spec.path, SerialCall::LowLatency, &error).into()),
    }
}
