//! Lines through the first interface of the kernel: one claim for outputs that are driven alike, one for each input.

use std::fs::File;
use std::io;
use std::os::fd::{AsFd, AsRawFd, BorrowedFd, OwnedFd};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use gpio_cdev::{EventRequestFlags, LineRequestFlags};
use gpiocdev_uapi::v1::{self, LineEdgeEvent, LineEdgeEventKind, LineValues};
use host::HostInstant;

use super::error::uapi;
use super::port::{Claim, Edge, GpioPort, LineLevels, Wanted};
use super::{Backend, Bias, Drive, GpioCall, GpioError};
use crate::{LineApi, OutputClaim};

/// Edges that one call reads at most: all that the kernel keeps for a line.
const BATCH: usize = 16;
/// Length of an edge in the words that the kernel writes it in.
const EDGE_WORDS: usize = size_of::<LineEdgeEvent>() / 8;

/// The kernel's flags for a pull, which the library has no names for.
const PULL_UP: u32 = 1 << 5;
const PULL_DOWN: u32 = 1 << 6;
const NO_PULL: u32 = 1 << 7;

#[derive(Debug)]
pub(super) struct PortV1 {
    outputs: Vec<Group>,
    inputs: Vec<File>,
    /// The input that is read next: a call reads one.
    next: AtomicUsize,
    safe: u64,
}

/// Outputs that are driven alike: the interface has one way of driving for a claim.
#[derive(Debug)]
struct Group {
    claim: File,
    /// Places of its lines among all outputs, in the claim's order.
    places: Vec<u8>,
    /// Lines of it whose low level is 1: turned round here, for they would need claims of their own.
    inverted: u64,
}

impl Group {
    /// The levels of its lines, from those of all outputs; bit 0 is the claim's first line.
    fn levels(&self, bits: u64) -> u64 {
        let own = self.places.iter().enumerate();
        own.fold(0, |own, (at, place)| own | (bits >> place & 1) << at) ^ self.inverted
    }
}

impl PortV1 {
    /// Claims lines.
    pub(super) fn claim(path: &Path, consumer: &str, claim: &Claim) -> Result<PortV1, GpioError> {
        let mut chip =
            gpio_cdev::Chip::new(path).map_err(|error| GpioError::v1(path, GpioCall::Open, &error))?;
        let mut outputs = Vec::new();
        let mut kinds: Vec<(Drive, Option<Bias>)> = Vec::new();
        for line in &claim.outputs {
            if !kinds.contains(&(line.drive, line.bias)) {
                kinds.push((line.drive, line.bias));
            }
        }
        for (drive, bias) in kinds {
            let own =
                claim.outputs.iter().enumerate().filter(|(_, line)| (line.drive, line.bias) == (drive, bias));
            let (places, lines): (Vec<u8>, Vec<&Wanted>) = own.map(|(at, line)| (at as u8, line)).unzip();
            outputs.push(group(path, &mut chip, consumer, places, &lines)?);
        }
        let mut inputs = Vec::new();
        for line in &claim.inputs {
            inputs.push(input(path, &mut chip, consumer, line)?);
        }
        let safe =
            claim.outputs.iter().enumerate().fold(0, |bits, (at, line)| bits | u64::from(line.safe) << at);
        Ok(PortV1 { outputs, inputs, next: AtomicUsize::new(0), safe })
    }

    fn read(&self, input: usize) -> io::Result<u64> {
        let mut values = LineValues::default();
        v1::get_line_values(&self.inputs[input], &mut values).map_err(uapi)?;
        Ok(u64::from(values.get(0) != 0) << input)
    }
}

fn group(
    path: &Path,
    chip: &mut gpio_cdev::Chip,
    consumer: &str,
    places: Vec<u8>,
    lines: &[&Wanted],
) -> Result<Group, GpioError> {
    let numbers: Vec<u32> = lines.iter().map(|line| line.number).collect();
    let first: Vec<u8> = lines.iter().map(|line| u8::from(line.safe != line.active_low)).collect();
    let inverted =
        lines.iter().enumerate().fold(0, |bits, (at, line)| bits | u64::from(line.active_low) << at);
    let mut flags = LineRequestFlags::OUTPUT | pull(lines[0].bias);
    match lines[0].drive {
        Drive::PushPull => {}
        Drive::OpenDrain => flags |= LineRequestFlags::OPEN_DRAIN,
        Drive::OpenSource => flags |= LineRequestFlags::OPEN_SOURCE,
    }
    let claimed = chip.get_lines(&numbers).and_then(|lines| lines.request(flags, &first, consumer));
    let handle = claimed.map_err(|error| GpioError::v1(path, GpioCall::Claim, &error))?;
    Ok(Group { claim: own(path, &handle)?, places, inverted })
}

fn input(path: &Path, chip: &mut gpio_cdev::Chip, consumer: &str, line: &Wanted) -> Result<File, GpioError> {
    let mut flags = LineRequestFlags::INPUT | pull(line.bias);
    if line.active_low {
        flags |= LineRequestFlags::ACTIVE_LOW;
    }
    let edges = EventRequestFlags::BOTH_EDGES;
    let claimed = chip.get_line(line.number).and_then(|line| line.events(flags, edges, consumer));
    let handle = claimed.map_err(|error| GpioError::v1(path, GpioCall::Claim, &error))?;
    own(path, &handle)
}

/// The calls of the scan go to the kernel without the library's lists, which allocate.
fn own(path: &Path, handle: &impl AsRawFd) -> Result<File, GpioError> {
    let claim = host::duplicate(handle).map_err(|error| GpioError::new(path, GpioCall::Claim, &error))?;
    Ok(claim.into())
}

fn pull(bias: Option<Bias>) -> LineRequestFlags {
    LineRequestFlags::from_bits_retain(match bias {
        None => 0,
        Some(Bias::PullUp) => PULL_UP,
        Some(Bias::PullDown) => PULL_DOWN,
        Some(Bias::Disabled) => NO_PULL,
    })
}

impl GpioPort for PortV1 {
    fn backend(&self) -> Backend {
        Backend::V1
    }

    fn set(&self, bits: u64) -> io::Result<()> {
        let mut outcome = Ok(());
        for group in &self.outputs {
            let own = group.levels(bits);
            let mut values = LineValues::default();
            for at in 0..group.places.len() {
                values.set(at, (own >> at & 1) as u8);
            }
            // The others are driven even when one of them cannot be.
            outcome = v1::set_line_values(&group.claim, &values).map_err(uapi).and(outcome);
        }
        outcome
    }

    fn get(&self) -> io::Result<LineLevels> {
        if self.inputs.is_empty() {
            // Whether the chip is still there shows all the same.
            let Some(group) = self.outputs.first() else { return Ok(LineLevels::default()) };
            let mut values = LineValues::default();
            return v1::get_line_values(&group.claim, &mut values)
                .map_err(uapi)
                .map(|()| LineLevels::default());
        }
        let input = self.next.fetch_add(1, Ordering::Relaxed) % self.inputs.len();
        Ok(LineLevels { bits: self.read(input)?, known: 1 << input })
    }

    fn survey(&self) -> io::Result<LineLevels> {
        let mut levels = LineLevels::default();
        for input in 0..self.inputs.len() {
            levels.bits |= self.read(input)?;
            levels.known |= 1 << input;
        }
        Ok(levels)
    }

    fn source(&self, number: usize) -> Option<BorrowedFd<'_>> {
        self.inputs.get(number).map(File::as_fd)
    }

    fn edges(&self, source: usize, out: &mut Vec<Edge>) -> io::Result<()> {
        let mut words = [0u64; BATCH * EDGE_WORDS];
        let room = (out.capacity() - out.len()).min(BATCH);
        let read =
            gpiocdev_uapi::read_event(&self.inputs[source], &mut words[..room * EDGE_WORDS]).map_err(uapi)?;
        for words in words[..read.min(words.len())].chunks_exact(EDGE_WORDS) {
            let event = LineEdgeEvent::from_slice(words).map_err(uapi)?;
            out.push(Edge {
                input: source as u8,
                high: event.kind == LineEdgeEventKind::RisingEdge as u32,
                stamp: HostInstant::of_kernel(event.timestamp_ns),
                numbers: None,
            });
        }
        Ok(())
    }

    fn output_claims(&self, device: &str) -> io::Result<Vec<OutputClaim>> {
        let one = |group: &Group| {
            let count = group.places.len();
            Ok(OutputClaim {
                device: device.to_owned(),
                claim: OwnedFd::from(group.claim.try_clone()?),
                api: LineApi::V1 { lines: count as u8 },
                mask: if count >= 64 { u64::MAX } else { (1 << count) - 1 },
                safe: group.levels(self.safe),
            })
        };
        self.outputs.iter().map(one).collect()
    }
}
