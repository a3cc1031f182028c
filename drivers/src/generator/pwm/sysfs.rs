//! Outputs of a PWM chip as the kernel shows them in `/sys`.

use std::fs;
use std::io::{self, Write};
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rustix::fs::{Access, FlockOperation, Mode, OFlags, access, flock, open};
use rustix::io::{Errno, pread, pwrite};

use super::super::OutputSpec;
use super::output::{Attribute, Attributes};
use super::{FoundPwm, PwmOutput};
use crate::codes;
use crate::refusal::Refusal;

/// How long the files of an output may take to be there and to be the user's: a rule of the machine may have to hand
/// them over first.
const HANDED_OVER: Duration = Duration::from_secs(2);

/// How often they are looked for meanwhile.
const LOOK: Duration = Duration::from_millis(5);

/// Room for a number and the end of its line.
const NUMBER: usize = 24;

/// The files of an output, open. No other call of theirs allocates.
#[derive(Debug)]
struct Files {
    period: OwnedFd,
    duty: OwnedFd,
    enable: OwnedFd,
}

impl Files {
    fn file(&self, attribute: Attribute) -> &OwnedFd {
        match attribute {
            Attribute::Period => &self.period,
            Attribute::Duty => &self.duty,
            Attribute::Enable => &self.enable,
        }
    }
}

impl Attributes for Files {
    fn write(&mut self, attribute: Attribute, value: u64) -> io::Result<()> {
        let mut text = [0; NUMBER];
        let mut room = &mut text[..];
        writeln!(room, "{value}")?;
        let used = NUMBER - room.len();
        pwrite(self.file(attribute), &text[..used], 0)?;
        Ok(())
    }

    fn read(&mut self, attribute: Attribute) -> io::Result<u64> {
        let mut text = [0; NUMBER];
        let used = pread(self.file(attribute), &mut text, 0)?;
        let number = std::str::from_utf8(&text[..used]).ok().and_then(|text| text.trim().parse().ok());
        number.ok_or_else(|| Errno::BADMSG.into())
    }

    fn claim(&self) -> io::Result<OwnedFd> {
        self.duty.try_clone()
    }
}

/// An output that is the rig's. Dropping it gives it back.
#[derive(Debug)]
pub(super) struct Exported {
    chip: PathBuf,
    number: u16,
    /// Held as long as the output is the rig's: other rigs see it.
    lock: Option<OwnedFd>,
}

impl Drop for Exported {
    fn drop(&mut self) {
        // One that is gone needs nothing.
        let _ = fs::write(self.chip.join("unexport"), self.number.to_string());
        drop(self.lock.take());
    }
}

/// An output of a chip, as messages have it.
struct Wanted<'a> {
    chip: &'a FoundPwm,
    spec: &'a OutputSpec,
    folder: PathBuf,
}

impl<'a> Wanted<'a> {
    /// The output, if the chip has it.
    fn of(chip: &'a FoundPwm, spec: &'a OutputSpec) -> Result<Wanted<'a>, Refusal> {
        let number = spec.output;
        if number >= chip.outputs {
            let message = format!("{} has no output {number}", chip.words());
            let help = format!("its outputs are 0 to {}", chip.outputs.saturating_sub(1));
            return Err(Refusal::new(codes::OUTPUT, message, help).at(spec.place.clone()));
        }
        Ok(Wanted { chip, spec, folder: chip.folder.join(format!("pwm{number}")) })
    }

    fn words(&self) -> String {
        format!("output {} of {}", self.spec.output, self.chip.words())
    }

    fn exported(&self, lock: Option<OwnedFd>) -> Exported {
        Exported { chip: self.chip.folder.clone(), number: self.spec.output, lock }
    }

    /// Its folder, locked against other rigs.
    fn lock(&self) -> Result<OwnedFd, Refusal> {
        let locked = wait_for(|| {
            let lock =
                open(&self.folder, OFlags::RDONLY | OFlags::DIRECTORY | OFlags::CLOEXEC, Mode::empty())?;
            flock(&lock, FlockOperation::NonBlockingLockExclusive)?;
            Ok(lock)
        });
        locked.map_err(|error| match is(&error, Errno::WOULDBLOCK) {
            true => self.busy("another rig", "end that run first"),
            false => self.refused("be opened", &error),
        })
    }

    /// One that somebody else exported is left to him as long as it runs; one that a rig left behind rests.
    fn rests(&self, files: &mut Files) -> Result<(), Refusal> {
        let runs =
            files.read(Attribute::Enable).and_then(|on| Ok(on != 0 && files.read(Attribute::Duty)? != 0));
        if runs.map_err(|error| self.refused("be read", &error))? {
            let help = format!(
                "if nobody needs it: echo {} > {}/unexport",
                self.spec.output,
                self.chip.folder.display()
            );
            return Err(self.busy("somebody who lets it run", &help));
        }
        Ok(())
    }

    fn files(&self) -> Result<Files, Refusal> {
        files(&self.folder).map_err(|error| self.refused("be opened", &error))
    }

    fn busy(&self, who: &str, help: &str) -> Refusal {
        let message = format!("{} is held by {who}", self.words());
        Refusal::new(codes::GENERATOR_BUSY, message, help).at(self.spec.place.clone())
    }

    fn refused(&self, how: &str, error: &io::Error) -> Refusal {
        let message = format!("{} cannot {how}: {error}", self.words());
        let refusal = match error.kind() {
            io::ErrorKind::PermissionDenied => {
                let help =
                    "let your group write the files below /sys/class/pwm by a rule of udev, or run as root";
                Refusal::new(codes::GENERATOR_ACCESS, message, help)
            }
            _ => {
                let help = "`dmesg` shows what its driver says; a chip that cannot turn its outputs over takes no \
                            `active-low` and no `safe = true`";
                Refusal::new(codes::GENERATOR_REFUSED, message, help)
            }
        };
        refusal.at(self.spec.place.clone())
    }
}

/// Whether an output can be had, as far as that can be seen without taking it.
pub(super) fn look(chip: &FoundPwm, spec: &OutputSpec) -> Result<(), Refusal> {
    let wanted = Wanted::of(chip, spec)?;
    if wanted.folder.exists() {
        let _lock = wanted.lock()?;
        return wanted.rests(&mut wanted.files()?);
    }
    let export = chip.folder.join("export");
    access(&export, Access::WRITE_OK).map_err(|errno| wanted.refused("be had", &errno.into()))
}

/// Takes an output for the rig alone and sets it to work, at rest.
///
/// # Errors
/// The chip does not have it, somebody else has it, it is not permitted, or the chip refuses.
pub(super) fn claim(
    chip: &FoundPwm,
    spec: &OutputSpec,
    period: u64,
) -> Result<(PwmOutput, Exported), Refusal> {
    let wanted = Wanted::of(chip, spec)?;
    let exported = match fs::write(chip.folder.join("export"), spec.output.to_string()) {
        Ok(()) => Some(wanted.exported(None)),
        // Somebody else did that, or a rig that is gone.
        Err(error) if is(&error, Errno::BUSY) && wanted.folder.exists() => None,
        Err(error) if is(&error, Errno::BUSY) => {
            let help = "take another output, or that driver out of the device tree";
            return Err(wanted.busy("a driver of the kernel", help));
        }
        Err(error) => return Err(wanted.refused("be had", &error)),
    };
    let lock = wanted.lock()?;
    let mut files = wanted.files()?;
    if exported.is_none() {
        wanted.rests(&mut files)?;
    }
    let mut exported = exported.unwrap_or_else(|| wanted.exported(None));
    exported.lock = Some(lock);
    let output =
        set_up(&wanted.folder, files, spec, period).map_err(|error| wanted.refused("be set up", &error))?;
    Ok((output, exported))
}

/// At rest, with the polarity that makes an output without active time rest at its safe level.
fn set_up(folder: &Path, mut files: Files, spec: &OutputSpec, period: u64) -> io::Result<PwmOutput> {
    let polarity = if spec.safe != spec.active_low { "inversed" } else { "normal" };
    let file = folder.join("polarity");
    if fs::read_to_string(&file)?.trim() != polarity {
        // It can be changed only of an output that has a period and does not run.
        if files.read(Attribute::Period)? == 0 {
            files.write(Attribute::Period, period.max(1))?;
        }
        files.write(Attribute::Duty, 0)?;
        files.write(Attribute::Enable, 0)?;
        fs::write(&file, polarity)?;
        if fs::read_to_string(&file)?.trim() != polarity {
            return Err(Errno::OPNOTSUPP.into());
        }
    }
    PwmOutput::new(Box::new(files), period)
}

fn files(folder: &Path) -> io::Result<Files> {
    let file =
        |name: &str| wait_for(|| Ok(open(folder.join(name), OFlags::RDWR | OFlags::CLOEXEC, Mode::empty())?));
    Ok(Files { period: file("period")?, duty: file("duty_cycle")?, enable: file("enable")? })
}

/// Tries until the files of an output that was made a moment ago are there and permitted.
fn wait_for<T>(mut attempt: impl FnMut() -> io::Result<T>) -> io::Result<T> {
    let due = Instant::now() + HANDED_OVER;
    loop {
        match attempt() {
            Err(error) if (is(&error, Errno::ACCESS) || is(&error, Errno::NOENT)) && Instant::now() < due => {
                std::thread::sleep(LOOK);
            }
            outcome => return outcome,
        }
    }
}

fn is(error: &io::Error, errno: Errno) -> bool {
    error.raw_os_error() == Some(errno.raw_os_error())
}
