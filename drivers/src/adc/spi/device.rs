//! A converter behind `spidev`.

use std::fs::OpenOptions;
use std::io;
use std::path::Path;

use host::HostInstant;
use rustix::fs::{FlockOperation, flock};
use rustix::io::Errno;
use signal::Span;
use spidev::{SpiModeFlags, Spidev, SpidevOptions, SpidevTransfer};

use super::super::{Adc, AdcPace, AdcReading, AdcSpec, Noise, Resolution, SampleSpec};
use super::codec::{Bytes, FRAME};
use super::sweep::{Sweep, answered};
use super::{Chosen, SpiSpec, choose};
use crate::codes;
use crate::device_file::device_file;
use crate::holder::{all_holders, words};
use crate::refusal::Refusal;

/// Where the driver says how many bytes it takes at once, and how many it takes where it does not say.
const BUFFER: &str = "/sys/module/spidev/parameters/bufsiz";
const SMALLEST_BUFFER: usize = 4_096;

/// What a transfer takes of the driver's buffer at least: on some machines each begins on a boundary of this.
const ROOM: usize = 128;

/// The most transfers of one call.
const TRANSFERS: usize = 64;

/// Bits of a word.
const WORD: u8 = 8;

/// A converter on an SPI bus that is open, set up, and the rig's alone.
#[derive(Debug)]
pub struct SpiAdc {
    name: String,
    spi: Spidev,
    sweep: Sweep,
    period: signal::Span,
    oversample: usize,
    /// Frames of one call: whole sweeps, as far as the driver's buffer goes.
    chunk: usize,
    /// Bytes of a frame.
    frame: usize,
    /// How long a frame is on the bus at least, in ns.
    lasts: Span,
    sent: Vec<u8>,
    answers: Vec<u8>,
}

/// Opens a converter for these inputs: takes it for the rig alone, sets up bus and part, and sees that both were
/// understood.
///
/// # Errors
/// It is not there, held by another rig, not permitted, or does not do what the file says.
pub fn open(converter: &AdcSpec, spec: &SpiSpec, inputs: &[SampleSpec]) -> Result<Box<dyn Adc>, Refusal> {
    let chosen: Vec<Chosen> = inputs.iter().map(|sample| choose(spec, sample)).collect::<Result<_, _>>()?;
    let path = spec.path.display();
    let spi = claim(&spec.path)?;
    let refused = |what: &str, error: &io::Error| {
        let help = "`dmesg` tells what the controller's driver says; look at `mode` and `speed`";
        Refusal::new(codes::CONVERTER_REFUSED, format!("{path} does not take {what}: {error}"), help)
    };
    let spi = configured(spi, spec).map_err(|(what, error)| refused(&what, &error))?;
    let buffer = std::fs::read_to_string(BUFFER).ok().and_then(|text| text.trim().parse().ok());
    let sweep = Sweep::new(spec.part, chosen.clone());
    let frames = sweep.frames().len();
    let room = (buffer.unwrap_or(SMALLEST_BUFFER) / ROOM).clamp(1, TRANSFERS);
    let oversample = usize::from(spec.oversample.max(1));
    // Whole sweeps where one fits.
    let chunk = if room >= frames { (room / frames).min(oversample) * frames } else { room };
    let frame = spec.part.frame().min(FRAME);
    let sent =
        sweep.frames().iter().cycle().take(frames.max(chunk)).flat_map(|one| one.send[..frame].to_vec());
    let mut opened = SpiAdc {
        name: format!("{} ({})", path, spec.part.name()),
        spi,
        period: converter.period,
        oversample,
        chunk,
        frame,
        lasts: shortest(frame as i64 * i64::from(WORD), spec),
        sent: sent.collect(),
        answers: vec![0; chunk * frame],
        sweep,
    };
    opened.set_up(spec, &chosen)?;
    Ok(Box::new(opened))
}

/// The device, for the rig alone.
pub(crate) fn claim(path: &Path) -> Result<Spidev, Refusal> {
    let no_device = || {
        let help = "`ls /dev/spidev*` shows what is there; it needs SPI switched on and a `spidev` node for the chip";
        Refusal::new(codes::CONVERTER_MISSING, format!("{} is no SPI device", path.display()), help)
    };
    if path.exists() && !device_file(path).may_be("spidev") {
        return Err(no_device());
    }
    let file = OpenOptions::new().read(true).write(true).open(path).map_err(|error| {
        let help = match error.kind() {
            io::ErrorKind::PermissionDenied => "become a member of the group that may use it, often `spi`",
            _ => "`ls /dev/spidev*` shows what is there; it needs SPI switched on and a `spidev` node for the chip",
        };
        Refusal::new(codes::CONVERTER_MISSING, format!("{} cannot be opened: {error}", path.display()), help)
    })?;
    if let Err(error) = flock(&file, FlockOperation::NonBlockingLockExclusive) {
        let message = match error {
            Errno::WOULDBLOCK => {
                format!("{} is held by {}", path.display(), words(&all_holders(path), "another rig"))
            }
            error => {
                format!("{} cannot be taken for the rig alone: {}", path.display(), io::Error::from(error))
            }
        };
        let help = "end that run first: `fuser` names who has the device open";
        return Err(Refusal::new(codes::CONVERTER_BUSY, message, help));
    }
    let spi = Spidev::new(file);
    // Only a device of this kind answers.
    spi.query_configuration().map_err(|_| no_device())?;
    Ok(spi)
}

/// How long so many bits last at least, by what the clock of the bus may be off.
fn shortest(bits: i64, spec: &SpiSpec) -> Span {
    let lasts = Span::from_nanos(bits * 1_000_000_000 / i64::from(spec.speed.max(1)));
    lasts - spec.clock_error.of(lasts)
}

/// Mode, speed and bits as the file wants them, seen to be so. On failure what was not taken.
fn configured(mut spi: Spidev, spec: &SpiSpec) -> Result<Spidev, (String, io::Error)> {
    let mode = SpiModeFlags::from_bits_truncate(u32::from(spec.mode & 3));
    let part = |what: &str, options: SpidevOptions| (what.to_owned(), options);
    let wanted = [
        part(&format!("mode {}", spec.mode), SpidevOptions::new().mode(mode).build()),
        part(
            "8 bits a word, highest first",
            SpidevOptions::new().bits_per_word(WORD).lsb_first(false).build(),
        ),
        part(&format!("{} Hz", spec.speed), SpidevOptions::new().max_speed_hz(spec.speed).build()),
    ];
    for (what, options) in wanted {
        spi.configure(&options).map_err(|error| (what.clone(), error))?;
        let now = spi.query_configuration().map_err(|error| (what.clone(), error))?;
        let modes = SpiModeFlags::SPI_MODE_3;
        let kept = options.bits_per_word.is_none_or(|bits| now.bits_per_word == Some(bits))
            && options.max_speed_hz.is_none_or(|speed| now.max_speed_hz.is_some_and(|now| now <= speed))
            && options.lsb_first.is_none_or(|first| now.lsb_first == Some(first))
            && options.spi_mode.is_none_or(|mode| now.spi_mode.is_some_and(|now| now & modes == mode));
        if !kept {
            return Err((what, io::Error::other("it keeps another setting")));
        }
    }
    Ok(spi)
}

impl SpiAdc {
    /// The frames that set the part up, each a transfer of its own.
    fn set_up(&mut self, spec: &SpiSpec, inputs: &[Chosen]) -> Result<(), Refusal> {
        let failed = |message: String| {
            let help = "look at the wires of the bus, its chip select, the supply of the part, and `mode` and `speed`";
            Refusal::new(codes::CONVERTER_REFUSED, message, help)
        };
        for frame in spec.part.setup(inputs) {
            let mut answer = [0; FRAME];
            let (send, got) = (&frame.send[..self.frame], &mut answer[..self.frame]);
            self.spi
                .transfer(&mut SpidevTransfer::read_write(send, got))
                .map_err(|error| failed(format!("a transfer with {} failed: {error}", self.name)))?;
            if let Some((mask, wanted)) = frame.expects
                && !answered(&answer, &mask, &wanted)
            {
                let message = format!(
                    "{} does not answer as {}: {send:02X?} brought {:02X?}",
                    self.name,
                    spec.part.name(),
                    &answer[..self.frame]
                );
                return Err(failed(message));
            }
        }
        Ok(())
    }

    /// One call: these frames of the sweeps, from this place on. The instants around it.
    fn transfer(&mut self, first: usize, count: usize) -> io::Result<(HostInstant, HostInstant)> {
        let frames = self.sweep.frames().len();
        let mut transfers: [SpidevTransfer<'_, '_>; TRANSFERS] =
            std::array::from_fn(|_| SpidevTransfer::default());
        let answers = self.answers.chunks_exact_mut(self.frame);
        for (at, (transfer, answer)) in transfers.iter_mut().zip(answers).take(count).enumerate() {
            let from = (first + at) % frames * self.frame;
            *transfer = SpidevTransfer::read_write(&self.sent[from..from + self.frame], answer);
            // Each frame is one of its own for the part.
            transfer.cs_change = u8::from(at + 1 < count);
        }
        let before = HostInstant::now();
        self.spi.transfer_multiple(&mut transfers[..count])?;
        Ok((before, HostInstant::now()))
    }
}

impl Adc for SpiAdc {
    fn device(&self) -> &str {
        &self.name
    }

    fn kind(&self) -> &'static str {
        "spi"
    }

    fn pace(&self) -> AdcPace<'_> {
        AdcPace::Asked(self.period)
    }

    fn read(&mut self, out: &mut Vec<AdcReading>) -> io::Result<()> {
        let frames = self.sweep.frames().len();
        let all = self.oversample * frames;
        self.sweep.clear();
        let mut first = 0;
        while first < all {
            let count = self.chunk.min(all - first);
            let (before, after) = self.transfer(first, count)?;
            for at in 0..count {
                let mut answer: Bytes = [0; FRAME];
                answer[..self.frame].copy_from_slice(&self.answers[at * self.frame..(at + 1) * self.frame]);
                // The bus is no faster than it was set to be, so that those in front and after took so long.
                let earliest = before + self.lasts * at as i64;
                let latest = after - self.lasts * (count - 1 - at) as i64;
                if !self.sweep.take((first + at) % frames, &answer, earliest, latest.max(earliest)) {
                    // The part cannot have said that: a wire is stuck, or the clock is too fast for it.
                    return Err(Errno::BADMSG.into());
                }
            }
            first += count;
        }
        self.sweep.readings(out);
        Ok(())
    }

    fn resolution(&self, input: u16) -> Resolution {
        self.sweep.resolution(usize::from(input))
    }

    fn noise(&self, input: u16) -> Option<Noise> {
        self.sweep.noise(usize::from(input))
    }
}
