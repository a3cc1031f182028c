//! From what a board file says to the chips and lines of this machine.

use document::{Diagnostic, suggest};
use rustix::io::Errno;

use super::port::{Claim, Wanted};
use super::{
    Backend, ChipInfo, ChipSpec, Direction, FindChip, FindLine, GpioCall, GpioError, GpioSpec, LineInfo,
    LineSpec, NamedLine, list, look,
};
use crate::ChannelId;
use crate::codes;
use crate::refusal::Refusal;

/// A chip of the board as this machine has it, with what is to be claimed of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FoundChip {
    /// Place in [`GpioSpec::chips`].
    pub spec: usize,
    /// The chip, with the lines as they are now.
    pub info: ChipInfo,
    /// The interface to be used.
    pub backend: Backend,
    /// The lines.
    pub claim: Claim,
    /// The channel that each output of the claim drives.
    pub drives: Vec<ChannelId>,
    /// The channel that each input of the claim reports.
    pub senses: Vec<ChannelId>,
}

/// Errors on the way, at their places in the board file.
struct Search<'a> {
    file: &'a str,
    spec: &'a GpioSpec,
    found: Vec<Diagnostic>,
}

/// Finds every chip and line of a GPIO board. Nothing is claimed, so nothing changes on any line; a line that
/// somebody holds is an error that says who.
///
/// # Errors
/// All that is not there, not free or cannot be done, by place.
pub fn find(file: &str, spec: &GpioSpec) -> Result<Vec<FoundChip>, Vec<Diagnostic>> {
    find_some(file, spec, |_| true)
}

/// The chips of this machine that a board means, as [`crate::OutputClaim::device`] names them; whether they can be had
/// is not looked at.
pub fn devices(spec: &GpioSpec) -> Vec<String> {
    let meant = |info: &&ChipInfo| spec.chips.iter().any(|chip| means(chip, info));
    let machine = list().unwrap_or_default();
    there(&machine).filter(meant).map(device).collect()
}

/// The lines of this machine that a board uses, by chip; whether they can be had is not looked at, and what is not there is
/// left out.
pub fn uses(spec: &GpioSpec) -> Vec<(ChipInfo, Vec<u32>)> {
    let machine = list().unwrap_or_default();
    let mut used: Vec<(ChipInfo, Vec<u32>)> = Vec::new();
    for (at, chip) in spec.chips.iter().enumerate() {
        let Some(info) = there(&machine).find(|info| means(chip, info)) else { continue };
        let named = spec.lines.iter().filter(|line| line.chip == at);
        let named = named.flat_map(|line| std::iter::once(&line.line).chain(&line.readback));
        let number = |line: &NamedLine| match &line.find {
            FindLine::Number(number) => Some(*number),
            FindLine::Name(name) => {
                let found = info.lines.iter().find(|line| line.name.as_ref() == Some(name));
                found.map(|line| line.number)
            }
        };
        let mut numbers: Vec<u32> = named.filter_map(number).collect();
        numbers.sort_unstable();
        numbers.dedup();
        if !numbers.is_empty() {
            used.push((info.clone(), numbers));
        }
    }
    used
}

/// Whether a chip of the machine is the one that the file means.
fn means(chip: &ChipSpec, info: &ChipInfo) -> bool {
    match &chip.find {
        FindChip::Label(label) => info.label == *label,
        FindChip::Name(name) => info.name == *name,
        FindChip::Path(path) => path.canonicalize().is_ok_and(|path| info.path == path),
    }
}

/// A chip, as messages name it.
pub(super) fn device(info: &ChipInfo) -> String {
    format!("{} ({})", info.path.display(), info.label)
}

/// One chip of the board once more, by its place in [`GpioSpec::chips`].
pub(super) fn find_again(file: &str, spec: &GpioSpec, chip: usize) -> Option<FoundChip> {
    find_some(file, spec, |at| at == chip).ok()?.pop()
}

fn find_some(
    file: &str,
    spec: &GpioSpec,
    wanted: impl Fn(usize) -> bool,
) -> Result<Vec<FoundChip>, Vec<Diagnostic>> {
    let mut search = Search { file, spec, found: Vec::new() };
    let machine = match list() {
        Ok(machine) => machine,
        Err(error) => return Err(vec![refused(&error).finding(file, 0..0)]),
    };
    let mut chips: Vec<FoundChip> = Vec::new();
    for (at, chip) in spec.chips.iter().enumerate() {
        // A chip that no channel uses may be missing.
        if !wanted(at) || !spec.lines.iter().any(|line| line.chip == at) {
            continue;
        }
        let Some(info) = search.chip(chip, &machine) else { continue };
        if let Some(other) = chips.iter().find(|other| other.info.path == info.path) {
            let name = &spec.chips[other.spec].name;
            let message = format!("`{}` is the same chip as `{name}`: {}", chip.name, info.path.display());
            search.error(codes::CHIPS_ALIKE, chip.place.clone(), message, "describe it once");
            continue;
        }
        if let Some(found) = search.lines(at, info) {
            chips.push(found);
        }
    }
    if search.found.is_empty() { Ok(chips) } else { Err(search.found) }
}

impl Search<'_> {
    fn error(
        &mut self,
        code: &'static str,
        place: std::ops::Range<usize>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        self.found.push(Diagnostic::error(code, message).at(self.file.to_owned(), place, "").help(help));
    }

    fn chip(&mut self, chip: &ChipSpec, machine: &[Result<ChipInfo, GpioError>]) -> Option<ChipInfo> {
        let (what, matches): (String, Vec<&ChipInfo>) = match &chip.find {
            FindChip::Path(path) => {
                return match look(path) {
                    Ok(info) => Some(info),
                    Err(error) => {
                        self.found.push(refused(&error).finding(self.file, chip.place.clone()));
                        None
                    }
                };
            }
            FindChip::Label(label) => (
                format!("the label \"{label}\""),
                there(machine).filter(|info| info.label == *label).collect(),
            ),
            FindChip::Name(name) => {
                (format!("the name \"{name}\""), there(machine).filter(|info| info.name == *name).collect())
            }
        };
        match matches[..] {
            [one] => Some(one.clone()),
            [] => {
                self.no_chip(chip, &what, machine);
                None
            }
            _ => {
                let paths: Vec<String> = matches.iter().map(|info| info.path.display().to_string()).collect();
                let message =
                    format!("{} chips of the machine have {what}: {}", paths.len(), paths.join(", "));
                let help = "say which by `path`; a link that udev makes stays the same";
                self.error(codes::CHIPS_ALIKE, chip.place.clone(), message, help);
                None
            }
        }
    }

    fn no_chip(&mut self, chip: &ChipSpec, what: &str, machine: &[Result<ChipInfo, GpioError>]) {
        // It may be one of those that cannot be looked at.
        if let Some(Err(error)) = machine.iter().find(|chip| chip.is_err()) {
            self.found.push(refused(error).finding(self.file, chip.place.clone()));
            return;
        }
        let (wanted, known): (&str, Vec<&str>) = match &chip.find {
            FindChip::Name(name) => (name, there(machine).map(|info| info.name.as_str()).collect()),
            FindChip::Label(label) => (label, there(machine).map(|info| info.label.as_str()).collect()),
            FindChip::Path(_) => return,
        };
        let help = match (suggest(wanted, known.iter().copied()), known.is_empty()) {
            (Some(meant), _) => format!("did you mean \"{meant}\"?"),
            (None, true) => String::from("the machine has no GPIO chip at all: is its driver loaded?"),
            (None, false) => format!("the machine has {}", known.join(", ")),
        };
        self.error(codes::CHIP_MISSING, chip.place.clone(), format!("no GPIO chip has {what}"), help);
    }

    /// The lines of a chip, all errors reported.
    fn lines(&mut self, at: usize, info: ChipInfo) -> Option<FoundChip> {
        let before = self.found.len();
        let backend = self.backend(at, &info);
        let mut outputs = Vec::new();
        let mut inputs = Vec::new();
        let mut used: Vec<u32> = Vec::new();
        for line in self.spec.lines.iter().filter(|line| line.chip == at) {
            for (named, output) in
                [(Some(&line.line), line.direction == Direction::Output), (line.readback.as_ref(), false)]
            {
                let Some(named) = named else { continue };
                let Some(number) = self.line(named, &info) else { continue };
                if used.contains(&number) {
                    let message = format!("the line is number {number}, which another channel has already");
                    self.error(
                        codes::LINE_TWICE,
                        named.place.clone(),
                        message,
                        "give each channel its own line",
                    );
                    continue;
                }
                used.push(number);
                let wanted = wanted(line, number, output);
                if output { &mut outputs } else { &mut inputs }.push((wanted, line.channel));
            }
        }
        if self.found.len() > before {
            return None;
        }
        outputs.sort_by_key(|(line, _)| line.number);
        inputs.sort_by_key(|(line, _)| line.number);
        let (outputs, drives) = outputs.into_iter().unzip();
        let (inputs, senses) = inputs.into_iter().unzip();
        Some(FoundChip {
            spec: at,
            info,
            backend: backend?,
            claim: Claim { outputs, inputs },
            drives,
            senses,
        })
    }

    /// The interface for a chip, if it can do all that is asked of it.
    fn backend(&mut self, at: usize, info: &ChipInfo) -> Option<Backend> {
        let backend = self.spec.backend.unwrap_or(info.backend);
        let spec = self.spec;
        if backend == Backend::V2 && info.backend == Backend::V1 {
            let message = "this kernel has only the first interface to GPIO lines";
            let help = "write backend = \"auto\", or use Linux 5.10 or newer";
            self.error(codes::BACKEND, spec.chips[at].place.clone(), message, help);
            return None;
        }
        if backend == Backend::V1 && older_than((5, 7), kernel().as_deref().unwrap_or_default()) {
            let message = "before Linux 5.7 the first interface to GPIO lines has edges of another clock than the rig's";
            self.error(codes::BACKEND, spec.chips[at].place.clone(), message, "use Linux 5.10 or newer");
            return None;
        }
        let debounced = spec.lines.iter().find(|line| line.chip == at && line.debounce_us > 0);
        if let Some(line) = debounced.filter(|_| backend == Backend::V1) {
            let message = "the first interface to GPIO lines cannot debounce";
            let help = "remove `debounce`, or use the second interface: backend = \"v2\"";
            self.error(codes::BACKEND, line.line.place.clone(), message, help);
            return None;
        }
        Some(backend)
    }

    /// The number of a line that is there and free.
    fn line(&mut self, named: &NamedLine, info: &ChipInfo) -> Option<u32> {
        let chip = format!("{} ({})", info.path.display(), info.label);
        let line = match &named.find {
            FindLine::Number(number) => info.lines.iter().find(|line| line.number == *number),
            FindLine::Name(name) => {
                let mut alike = info.lines.iter().filter(|line| line.name.as_ref() == Some(name));
                let line = alike.next();
                if let (Some(first), Some(second)) = (line, alike.next()) {
                    let message = format!(
                        "lines {} and {} of {chip} are both named {name}",
                        first.number, second.number
                    );
                    self.error(
                        codes::LINES_ALIKE,
                        named.place.clone(),
                        message,
                        "name the line by its number",
                    );
                    return None;
                }
                line
            }
        };
        let Some(line) = line else {
            let missing = missing(named, info, &chip);
            self.found.push(missing.finding(self.file, named.place.clone()));
            return None;
        };
        if let Some(holder) = line.holder() {
            let message = format!("{} of {chip} is held by {holder}", shown(line));
            let help = match line.consumer {
                Some(_) => "end that program or driver, or take another line",
                None => {
                    "unbind that driver (`gpioinfo` and /sys/kernel/debug/gpio show more), or take another line"
                }
            };
            self.error(codes::BUSY, named.place.clone(), message, help);
            return None;
        }
        Some(line.number)
    }
}

/// The release of the kernel, as in `6.12.9-rt`.
fn kernel() -> Option<String> {
    std::fs::read_to_string("/proc/sys/kernel/osrelease").ok()
}

/// Whether a release is older than a version. One that does not read as a release is not.
fn older_than(version: (u32, u32), release: &str) -> bool {
    let mut numbers = release.split(|c: char| !c.is_ascii_digit()).map_while(|number| number.parse().ok());
    matches!((numbers.next(), numbers.next()), (Some(major), Some(minor)) if (major, minor) < version)
}

fn there(machine: &[Result<ChipInfo, GpioError>]) -> impl Iterator<Item = &ChipInfo> {
    machine.iter().filter_map(|chip| chip.as_ref().ok())
}

fn shown(line: &LineInfo) -> String {
    match &line.name {
        Some(name) => format!("line {} ({name})", line.number),
        None => format!("line {}", line.number),
    }
}

fn missing(named: &NamedLine, info: &ChipInfo, chip: &str) -> Refusal {
    let (message, help) = match &named.find {
        FindLine::Number(number) => {
            let help = match info.lines.len() {
                0 => String::from("it has no lines"),
                count => format!("its lines are 0 to {}", count - 1),
            };
            (format!("{chip} has no line {number}"), help)
        }
        FindLine::Name(name) => {
            let known: Vec<&str> = info.lines.iter().filter_map(|line| line.name.as_deref()).collect();
            let help = match (suggest(name, known.iter().copied()), known.is_empty()) {
                (Some(meant), _) => format!("did you mean {meant}?"),
                (None, true) => String::from("its lines have no names: say the line's number"),
                (None, false) => format!("its named lines are {}", known.join(", ")),
            };
            (format!("{chip} has no line named {name}"), help)
        }
    };
    Refusal::new(codes::LINE_MISSING, message, help)
}

fn wanted(line: &LineSpec, number: u32, output: bool) -> Wanted {
    // What is said of the line that reads back is said of both: they are one wire.
    Wanted {
        number,
        bias: line.bias.filter(|_| !output || line.readback.is_none()),
        active_low: line.active_low,
        drive: if output { line.drive } else { super::Drive::PushPull },
        debounce_us: if output { 0 } else { line.debounce_us },
        safe: output && line.safe,
    }
}

/// What a failed call means, and what fixes it.
pub(super) fn refused(error: &GpioError) -> Refusal {
    let (code, help) = match (error.errno, error.call) {
        (Errno::ACCESS | Errno::PERM, _) => {
            let help = format!(
                "`ls -l {}` shows the group that may: add yourself to it, as in `sudo usermod -aG gpio $USER`, \
                 and log in again",
                error.device.display()
            );
            (codes::NO_ACCESS, help)
        }
        (Errno::NOENT | Errno::NODEV | Errno::NXIO, _) => {
            (codes::CHIP_MISSING, String::from("`rig board scan` lists the chips of the machine"))
        }
        (Errno::MFILE | Errno::NFILE | Errno::NOMEM, _) => {
            (codes::HOST, String::from("close what else is open, or raise the limit (`ulimit -n`)"))
        }
        (_, GpioCall::Claim) => {
            let help = "leave out `bias`, `debounce` and `drive` in turn to see which the chip cannot do";
            (codes::REFUSED, String::from(help))
        }
        _ => (codes::REFUSED, String::from("`dmesg` shows what the chip's driver says")),
    };
    Refusal::new(code, error.to_string(), help)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn releases_are_compared_by_their_numbers() {
        for (release, older) in [
            ("5.6.19", true),
            ("4.19.0-rt", true),
            ("5.7", false),
            ("5.10.0-8", false),
            ("6.1.0", false),
            ("", false),
            ("x", false),
        ] {
            assert_eq!(older_than((5, 7), release), older, "{release}");
        }
    }
}
