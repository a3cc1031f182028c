//! A count of the kernel's counter subsystem: its files in `/sys`, and its events.

use std::fs::File;
use std::io::{self, ErrorKind};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use host::{
    COUNTER_RECORD, CounterEvent, HostInstant, disable_counter_events, enable_counter_events, watch_count,
};
use rustix::fs::OFlags;
use rustix::io::Errno;

use super::find::{CounterDevice, HardwareCount, look, named};
use super::follow::{CounterReading, unseen};
use super::spec::CounterSpec;
use super::{Counter, Way};
use crate::codes;
use crate::inventory::{line, names};
use crate::refusal::Refusal;

/// A counter of 64 bits that says nothing of its ceiling wraps there.
const HIGHEST: u64 = u64::MAX;
/// Events that one call brings.
const AT_ONCE: usize = 64;

/// One count of a device, set up as the board file says. Dropping it sets it back as it was.
#[derive(Debug)]
pub struct KernelCounter {
    device: String,
    ceiling: u64,
    count: File,
    /// The node, where events are to come.
    node: Option<File>,
    /// Events that the kernel keeps.
    queue: usize,
    buffer: Vec<u8>,
    /// Settings that were changed, with what they were.
    before: Vec<(PathBuf, String)>,
}

impl KernelCounter {
    /// Finds the count that a board file means, and sets it up.
    ///
    /// # Errors
    /// It is not there, not permitted, or cannot do what the file says.
    pub fn open(root: &Path, spec: &CounterSpec) -> Result<KernelCounter, Refusal> {
        let (device, count) = look(root, spec)?;
        let mut before = Vec::new();
        let opened = set_up(spec, &device, &count, &mut before).and_then(|()| {
            let value = count.folder.join("count");
            let count_file = File::open(&value).map_err(|error| refused(&device, &value, &error))?;
            let ceiling = ceiling(&count.folder);
            follows(spec, &device, ceiling)?;
            let (node, queue) = events(spec, &device, &count, &mut before)?;
            Ok((count_file, ceiling, node, queue))
        });
        match opened {
            Ok((count, ceiling, node, queue)) => Ok(KernelCounter {
                device: named(&device),
                ceiling,
                count,
                node,
                queue,
                buffer: vec![0; AT_ONCE * COUNTER_RECORD],
                before,
            }),
            Err(refusal) => {
                set_back(&before);
                Err(refusal)
            }
        }
    }
}

impl Drop for KernelCounter {
    fn drop(&mut self) {
        if let Some(node) = &self.node {
            // Of a device that is gone nothing is left to end.
            let _ = disable_counter_events(node);
        }
        set_back(&self.before);
    }
}

impl Counter for KernelCounter {
    fn device(&self) -> &str {
        &self.device
    }

    fn ceiling(&self) -> u64 {
        self.ceiling
    }

    fn begin(&mut self) -> io::Result<()> {
        let Some(node) = &self.node else { return Ok(()) };
        // What waits is from before. More than the kernel keeps is news.
        let mut left = self.queue;
        while left > 0 {
            match rustix::io::read(node, &mut self.buffer[..]) {
                Err(Errno::AGAIN) | Ok(0) => break,
                Err(Errno::INTR) => {}
                other => left = left.saturating_sub(other? / COUNTER_RECORD),
            }
        }
        Ok(())
    }

    fn read(&mut self) -> io::Result<CounterReading> {
        let mut text = [0; 24];
        let before = HostInstant::now();
        let length = rustix::io::pread(&self.count, &mut text, 0)?;
        let after = HostInstant::now();
        let value = shown(&text[..length]).ok_or(ErrorKind::InvalidData)?;
        Ok(CounterReading { before, after, value })
    }

    fn events(&mut self, out: &mut Vec<CounterEvent>) -> io::Result<bool> {
        let Some(node) = &self.node else { return Ok(true) };
        let mut whole = true;
        let mut came = 0;
        loop {
            let length = match rustix::io::read(node, &mut self.buffer[..]) {
                Err(Errno::AGAIN) | Ok(0) => break,
                Err(Errno::INTR) => continue,
                other => other?,
            };
            let (records, rest) = self.buffer[..length].as_chunks::<COUNTER_RECORD>();
            // What does not read as an event that was asked for is one that is lost.
            whole &= rest.is_empty();
            came += records.len();
            for record in records {
                match CounterEvent::read(record) {
                    Some(event) => out.push(event),
                    None => whole = false,
                }
            }
            if came >= self.queue {
                break;
            }
        }
        // The kernel forgets without a word what finds its queue full.
        Ok(whole && came < self.queue)
    }
}

/// The number in the file of a count.
pub fn shown(text: &[u8]) -> Option<u64> {
    std::str::from_utf8(text).ok()?.trim_ascii().parse().ok()
}

/// Function, edge, ceiling, and that it counts at all.
fn set_up(
    spec: &CounterSpec,
    device: &CounterDevice,
    count: &HardwareCount,
    before: &mut Vec<(PathBuf, String)>,
) -> Result<(), Refusal> {
    let mut set = |file: &Path, value: &str| set(device, file, value, before);
    if let Some(function) = spec.function {
        set(&count.folder.join("function"), function.kernel())?;
    }
    if let Some(edge) = spec.edge {
        let actions = names(&count.folder);
        let action = actions.iter().find(|name| name.starts_with("signal") && name.ends_with("_action"));
        let Some(action) = action else {
            let message = format!("{} does not tell which edges it counts", named(device));
            return Err(Refusal::new(codes::COUNTER_SETTING, message, "remove `edge`"));
        };
        set(&count.folder.join(action), edge.kernel())?;
    }
    if let Some(ceiling) = spec.ceiling {
        set(&count.folder.join("ceiling"), &ceiling.to_string())?;
        let value = count.folder.join("count");
        // From beyond its ceiling a count would go on to wherever its hardware ends.
        if line(&value).parse().is_ok_and(|value: u64| value > ceiling) {
            write(&value, "0").map_err(|error| refused(device, &value, &error))?;
        }
    }
    let enable = count.folder.join("enable");
    if enable.exists() {
        set(&enable, "1")?;
    }
    Ok(())
}

/// Sets a file of the device to this, where it is something else.
fn set(
    device: &CounterDevice,
    file: &Path,
    value: &str,
    before: &mut Vec<(PathBuf, String)>,
) -> Result<(), Refusal> {
    let was = line(file);
    if was == value {
        return Ok(());
    }
    write(file, value).map_err(|error| {
        if error.kind() == ErrorKind::PermissionDenied {
            return refused(device, file, &error);
        }
        let name = file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let message = format!("{} does not take \"{value}\" as its {name}: {error}", named(device));
        let help = match line(&file.with_file_name(format!("{name}_available"))).as_str() {
            "" => format!("its {name} is \"{was}\": leave it so, or ask its driver's documentation"),
            _ => format!("{}/{name}_available lists what it takes", device.folder.display()),
        };
        Refusal::new(codes::COUNTER_SETTING, message, help)
    })?;
    before.push((file.to_owned(), was));
    Ok(())
}

fn set_back(before: &[(PathBuf, String)]) {
    for (file, was) in before.iter().rev() {
        // A device that is gone has nothing to be set back, and one that refuses keeps what it has.
        let _ = write(file, was);
    }
}

/// Writes a file of the kernel. It is never made: a device that went away leaves no file behind.
fn write(path: &Path, text: &str) -> io::Result<()> {
    let mut file = File::options().write(true).open(path)?;
    io::Write::write_all(&mut file, text.as_bytes())
}

fn ceiling(count: &Path) -> u64 {
    line(&count.join("ceiling")).parse().unwrap_or(HIGHEST)
}

/// Whether wraps of the count can be told from its readings, or are reported by the device.
fn follows(spec: &CounterSpec, device: &CounterDevice, ceiling: u64) -> Result<(), Refusal> {
    let apart = spec.period * 2;
    if spec.reports_wraps() || unseen(ceiling, spec.way(), spec.fastest()) >= apart {
        return Ok(());
    }
    let fastest = spec.fastest();
    let message = format!(
        "{} wraps at {ceiling}, which can go unseen within {} at {fastest} counts a second",
        named(device),
        apart
    );
    let both = if spec.way() == Way::Up { "\"overflow\"" } else { "\"overflow\", \"underflow\"" };
    let help = format!(
        "say how fast it gets by `counts-up-to`, take a higher `ceiling` or a shorter `period`, or let it tell of its \
         wraps: events = [{both}]"
    );
    Err(Refusal::new(codes::COUNTER_WRAPS, message, help))
}

/// Opens the node of a device whose events are asked for.
fn events(
    spec: &CounterSpec,
    device: &CounterDevice,
    count: &HardwareCount,
    before: &mut Vec<(PathBuf, String)>,
) -> Result<(Option<File>, usize), Refusal> {
    if spec.events.is_empty() {
        return Ok((None, 0));
    }
    let Some(node) = &device.node else {
        let message = format!("{} reports no events: it has no node in /dev", named(device));
        return Err(Refusal::new(codes::COUNTER_SETTING, message, "remove `events`"));
    };
    let size = device.folder.join("events_queue_size");
    set(device, &size, &spec.buffer.to_string(), before)?;
    let queue = line(&size).parse().unwrap_or(spec.buffer as usize);
    let flags = i32::try_from(OFlags::NONBLOCK.bits()).unwrap_or_default();
    let file = File::options()
        .read(true)
        .custom_flags(flags)
        .open(node)
        .map_err(|error| refused(device, node, &error))?;
    for kind in &spec.events {
        watch_count(&file, *kind, count.number).map_err(|error| {
            let name = super::spec::event_name(*kind);
            let message = format!("{} does not tell of \"{name}\": {error}", named(device));
            Refusal::new(codes::COUNTER_SETTING, message, "remove it from `events`")
        })?;
    }
    enable_counter_events(&file).map_err(|error| refused(device, node, &error))?;
    Ok((Some(file), queue))
}

fn refused(device: &CounterDevice, file: &Path, error: &io::Error) -> Refusal {
    let (device, file) = (named(device), file.display());
    match error.kind() {
        ErrorKind::PermissionDenied => Refusal::new(
            codes::COUNTER_DENIED,
            format!("{device} may not be used by this user: {file} is not to be had"),
            format!("give {file} to a group of the user: `rig doctor` has the rule"),
        ),
        _ => Refusal::new(
            codes::COUNTER_REFUSED,
            format!("{device} cannot be used: {file}: {error}"),
            "look into the kernel's log: `dmesg`",
        ),
    }
}
