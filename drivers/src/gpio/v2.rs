//! Lines through the second interface of the kernel.

use std::fs::File;
use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::path::Path;
use std::time::Duration;

use gpiocdev::line::{EdgeDetection, Value};
use gpiocdev_uapi::v2::{self, LineEdgeEvent, LineEdgeEventKind, LineValues};
use host::HostInstant;

use super::error::uapi;
use super::port::{Claim, Edge, GpioPort, LineLevels, Wanted};
use super::{Backend, Bias, Drive, GpioCall, GpioError};
use crate::{LineApi, OutputClaim};

/// Edges that the kernel keeps for a claim until they are read; it takes no more.
const KERNEL_ROOM: u32 = 1024;
/// Edges that one call reads at most.
const BATCH: usize = 32;
/// Length of an edge in the words that the kernel writes it in.
const EDGE_WORDS: usize = size_of::<LineEdgeEvent>() / 8;

/// The lines of a chip: a claim for outputs, a claim for inputs.
///
/// A lone input is claimed together with the outputs: the kernel numbers the interrupts of a claim, so that it shows
/// when two became one edge, but not those of a claim of a single line.
#[derive(Debug)]
pub(super) struct PortV2 {
    outputs: Option<File>,
    inputs: Option<File>,
    /// Bits of outputs in their claim: (place among the outputs, bit), packed where they are the same.
    drive: Places,
    sense: Places,
    /// Line numbers of the inputs, rising.
    numbers: Vec<u32>,
    safe: u64,
}

/// Where lines lie in their claim.
#[derive(Clone, Copy, Debug)]
struct Places {
    /// The claim's bits that are theirs.
    mask: u64,
    /// The place of the first: they lie side by side but for one line of the other kind in between.
    gap: Option<u32>,
}

impl Places {
    /// All lines of a claim.
    fn all(count: usize) -> Places {
        Places { mask: low(count), gap: None }
    }

    /// Lines as bits of the claim.
    fn spread(self, bits: u64) -> u64 {
        match self.gap {
            None => bits,
            Some(gap) => {
                let below = low(gap as usize);
                bits & below | (bits & !below) << 1
            }
        }
    }
}

/// So many bits from the lowest.
fn low(count: usize) -> u64 {
    if count >= 64 { u64::MAX } else { (1 << count) - 1 }
}

impl PortV2 {
    /// Claims lines.
    pub(super) fn claim(path: &Path, consumer: &str, claim: &Claim) -> Result<PortV2, GpioError> {
        let Claim { outputs, inputs } = claim;
        let numbers = inputs.iter().map(|line| line.number).collect();
        let safe = bits(outputs);
        let together = inputs.len() == 1 && !outputs.is_empty() && outputs.len() < super::MAX_LINES;
        if together {
            let both = request(path, consumer, outputs, inputs)?;
            let again = both.try_clone().map_err(|error| GpioError::new(path, GpioCall::Claim, &error))?;
            // The kernel's places in a claim are those of the request, which is by rising number.
            let gap = outputs.iter().filter(|line| line.number < inputs[0].number).count();
            let drive = Places { mask: low(outputs.len() + 1) & !(1 << gap), gap: Some(gap as u32) };
            let sense = Places { mask: 1 << gap, gap: None };
            return Ok(PortV2 { outputs: Some(both), inputs: Some(again), drive, sense, numbers, safe });
        }
        let one = |outputs: &[Wanted], inputs: &[Wanted]| match outputs.is_empty() && inputs.is_empty() {
            true => Ok(None),
            false => request(path, consumer, outputs, inputs).map(Some),
        };
        Ok(PortV2 {
            outputs: one(outputs, &[])?,
            inputs: one(&[], inputs)?,
            drive: Places::all(outputs.len()),
            sense: Places::all(inputs.len()),
            numbers,
            safe,
        })
    }
}

/// The safe levels of outputs, by their place.
fn bits(outputs: &[Wanted]) -> u64 {
    outputs.iter().enumerate().fold(0, |bits, (at, line)| bits | u64::from(line.safe) << at)
}

fn request(path: &Path, consumer: &str, outputs: &[Wanted], inputs: &[Wanted]) -> Result<File, GpioError> {
    let mut builder = gpiocdev::Request::builder();
    builder.on_chip(path).with_consumer(consumer).with_kernel_event_buffer_size(KERNEL_ROOM);
    for line in outputs {
        builder.with_line(line.number).as_output(if line.safe { Value::Active } else { Value::Inactive });
        builder.with_drive(match line.drive {
            Drive::PushPull => gpiocdev::line::Drive::PushPull,
            Drive::OpenDrain => gpiocdev::line::Drive::OpenDrain,
            Drive::OpenSource => gpiocdev::line::Drive::OpenSource,
        });
        common(&mut builder, line);
    }
    for line in inputs {
        builder.with_line(line.number).as_input().with_edge_detection(EdgeDetection::BothEdges);
        if line.debounce_us > 0 {
            builder.with_debounce_period(Duration::from_micros(line.debounce_us.into()));
        }
        common(&mut builder, line);
    }
    let request = builder.request().map_err(|error| GpioError::v2(path, GpioCall::Claim, &error))?;
    // The calls of the scan go to the kernel without the library's maps, which allocate.
    let claim = request.as_fd().try_clone_to_owned();
    Ok(claim.map_err(|error| GpioError::new(path, GpioCall::Claim, &error))?.into())
}

fn common(builder: &mut gpiocdev::request::Builder, line: &Wanted) {
    if line.active_low {
        builder.as_active_low();
    } else {
        builder.as_active_high();
    }
    builder.with_bias(line.bias.map(|bias| match bias {
        Bias::PullUp => gpiocdev::line::Bias::PullUp,
        Bias::PullDown => gpiocdev::line::Bias::PullDown,
        Bias::Disabled => gpiocdev::line::Bias::Disabled,
    }));
}

impl GpioPort for PortV2 {
    fn backend(&self) -> Backend {
        Backend::V2
    }

    fn set(&self, bits: u64) -> io::Result<()> {
        let Some(outputs) = &self.outputs else { return Ok(()) };
        let values = LineValues { bits: self.drive.spread(bits), mask: self.drive.mask };
        v2::set_line_values(outputs, &values).map_err(uapi)
    }

    fn get(&self) -> io::Result<LineLevels> {
        let Some(inputs) = &self.inputs else {
            // Whether the chip is still there shows all the same.
            let Some(outputs) = &self.outputs else { return Ok(LineLevels::default()) };
            let mut values = LineValues { bits: 0, mask: self.drive.mask };
            return v2::get_line_values(outputs, &mut values).map_err(uapi).map(|()| LineLevels::default());
        };
        let mut values = LineValues { bits: 0, mask: self.sense.mask };
        v2::get_line_values(inputs, &mut values).map_err(uapi)?;
        Ok(match self.numbers.len() {
            1 => LineLevels { bits: u64::from(values.bits & self.sense.mask != 0), known: 1 },
            _ => LineLevels { bits: values.bits & self.sense.mask, known: self.sense.mask },
        })
    }

    fn survey(&self) -> io::Result<LineLevels> {
        self.get()
    }

    fn source(&self, number: usize) -> Option<BorrowedFd<'_>> {
        // Of outputs alone there are no edges, but the kernel reports there when the chip goes.
        let only = self.inputs.as_ref().or(self.outputs.as_ref());
        only.filter(|_| number == 0).map(File::as_fd)
    }

    fn edges(&self, _source: usize, out: &mut Vec<Edge>) -> io::Result<()> {
        let Some(inputs) = &self.inputs else {
            // Readable means gone.
            return self.get().and(Err(rustix::io::Errno::NODEV.into()));
        };
        let mut words = [0u64; BATCH * EDGE_WORDS];
        let room = (out.capacity() - out.len()).min(BATCH);
        let read = gpiocdev_uapi::read_event(inputs, &mut words[..room * EDGE_WORDS]).map_err(uapi)?;
        for words in words[..read.min(words.len())].chunks_exact(EDGE_WORDS) {
            let event = LineEdgeEvent::from_slice(words).map_err(uapi)?;
            let Ok(input) = self.numbers.binary_search(&event.offset) else { continue };
            out.push(Edge {
                input: input as u8,
                high: event.kind == LineEdgeEventKind::RisingEdge as u32,
                stamp: HostInstant::of_kernel(event.timestamp_ns),
                numbers: Some((event.seqno, event.line_seqno)),
            });
        }
        Ok(())
    }

    fn output_claims(&self, device: &str) -> io::Result<Vec<OutputClaim>> {
        let Some(outputs) = &self.outputs else { return Ok(Vec::new()) };
        let claim: OwnedFd = outputs.try_clone()?.into();
        let (mask, safe) = (self.drive.mask, self.drive.spread(self.safe));
        Ok(vec![OutputClaim { device: device.to_owned(), claim, api: LineApi::V2, mask, safe }])
    }
}
