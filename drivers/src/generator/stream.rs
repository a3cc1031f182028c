//! The data line of an SPI bus behind `spidev`, as a stream of bits without a gap: one transfer for each emission.

use std::fs;
use std::io;
use std::path::Path;

use host::HostInstant;
use rustix::io::Errno;
use signal::Span;
use spidev::{SpiModeFlags, Spidev, SpidevOptions, SpidevTransfer};

use super::bits::{BitClock, BitLayout};
use super::{Generator, OutputSpec, SentPulses, StreamSpec};
use crate::OutputClaim;
use crate::adc::spi;
use crate::codes;
use crate::refusal::Refusal;

/// Where the driver says how many bytes it takes at once.
const LIMIT: &str = "/sys/module/spidev/parameters/bufsiz";

/// Bytes that the driver takes at once where nobody asked it for more.
pub const BUFFER: u32 = 4_096;

/// How often a byte, and at most a buffer, is sent at its opening to see how long it lasts.
const TRIES: usize = 12;

/// By how much a call may last longer than another one beside its bits.
const CALL: Span = Span::from_micros(300);

/// A clock may be slower than it was set to by one part in so many.
const OFF: i64 = 50;

/// The longest that bits may take of which the clock says that they last so long.
fn most(lasts: Span) -> Span {
    lasts + Span::from_nanos(lasts.as_nanos() / OFF) + CALL
}

/// Whether bits of which the clock says that they last so long last longer, by what was found, shortest first. A machine
/// that is too busy to tell comes back late by another time at each turn; a clock is late by the same.
fn is_late(whole: Span, found: &[Span]) -> bool {
    let best = found.first().copied().unwrap_or(Span::ZERO);
    let third = found.get(found.len() / 3).copied().unwrap_or(best);
    best > most(whole) && best - most(whole) > third - best
}

/// Bits of a word.
const WORD: u8 = 8;

/// The data line of an SPI bus that is open, set up, at rest, and the rig's alone.
#[derive(Debug)]
pub struct Stream {
    name: String,
    spi: Spidev,
    clock: BitClock,
    layout: BitLayout,
    bytes: Vec<u8>,
}

impl Stream {
    /// Takes the bus for the rig alone, sets it up, and sends it a whole buffer at rest: what it takes now it takes in a
    /// run.
    ///
    /// # Errors
    /// It is not there, held by another rig, not permitted, or does not do what the file says.
    pub fn open(spec: &StreamSpec, output: &OutputSpec) -> Result<Stream, Refusal> {
        let path = spec.path.display();
        let mut spi = look(spec)?;
        let refused = |what: &str, error: &io::Error| {
            let help = "`dmesg` shows what the controller's driver says; look at `mode`, `lsb-first`, `clock` and \
                        `buffer`";
            Refusal::new(codes::GENERATOR_REFUSED, format!("{path} does not take {what}: {error}"), help)
        };
        configure(&mut spi, spec).map_err(|(what, error)| refused(&what, &error))?;
        let mut stream = Stream {
            name: format!("{path} (SPI, {} Hz)", spec.clock.hz()),
            spi,
            clock: spec.clock,
            layout: spec.layout(output.active_low),
            bytes: vec![0; spec.buffer as usize],
        };
        stream.bytes.fill(if output.active_low { 0xff } else { 0 });
        let (whole, found) = stream.pace(spec).map_err(|error| {
            let what = format!("{} bytes at once", spec.buffer);
            refused(&what, &error)
        })?;
        if is_late(whole, &found) {
            let lasts = found[0];
            let hz = i128::from(u64::from(spec.buffer) * u64::from(WORD)) * 1_000_000_000
                / i128::from(lasts.as_nanos().max(1));
            let message = format!("{path} takes {lasts} for bits that last {whole}");
            let help = format!(
                "the controller pauses between words or has no such clock, as from {hz} bits a second: take a `clock` \
                 that it can keep"
            );
            return Err(Refusal::new(codes::STREAM_CLOCK, message, help));
        }
        Ok(stream)
    }

    /// How long a whole buffer is to last at its clock, and how long it lasts: by how much a call with it is longer than one
    /// with a single byte, a few times, shortest first.
    fn pace(&mut self, spec: &StreamSpec) -> io::Result<(Span, [Span; TRIES])> {
        let word = u64::from(WORD);
        let lasts = |bits: u64| spec.clock.lasts(bits);
        let whole = lasts(u64::from(spec.buffer) * word);
        let mut call = |bytes: usize| self.send(bytes).map(|sent| sent.after - sent.before);
        let mut least = Span::MAX;
        for _ in 0..TRIES {
            least = least.min(call(1)?);
        }
        let mut found = [Span::MAX; TRIES];
        for found in &mut found {
            let longer = call(spec.buffer as usize)? - least;
            *found = longer + lasts(word);
            if *found <= most(whole) {
                break;
            }
        }
        found.sort_unstable();
        Ok((whole, found))
    }

    /// Sends the first bytes of the buffer.
    fn send(&mut self, used: usize) -> io::Result<SentPulses> {
        let mut transfer = SpidevTransfer::write(&self.bytes[..used]);
        let before = HostInstant::now();
        self.spi.transfer(&mut transfer)?;
        Ok(SentPulses { before, after: HostInstant::now(), bits: used as u64 * u64::from(WORD) })
    }
}

/// The device, for the rig alone, if it takes as much at once as it is to.
pub(super) fn look(spec: &StreamSpec) -> Result<Spidev, Refusal> {
    let spi = claim(&spec.path)?;
    let limit = fs::read_to_string(LIMIT).ok().and_then(|text| text.trim().parse::<u32>().ok());
    match limit.filter(|limit| *limit < spec.buffer) {
        None => Ok(spi),
        Some(limit) => {
            let message = format!("the kernel takes {limit} bytes at once for {}", spec.path.display());
            let help = format!(
                "start the machine with `spidev.bufsiz={}`, or load the module with `bufsiz={}`, or take a smaller \
                 `buffer`",
                spec.buffer, spec.buffer
            );
            Err(Refusal::new(codes::STREAM_BUFFER, message, help))
        }
    }
}

/// The device, for the rig alone, as [`spi::claim`], in the words of generators.
fn claim(path: &Path) -> Result<Spidev, Refusal> {
    spi::claim(path).map_err(|refusal| {
        let code = if refusal.code == codes::CONVERTER_BUSY {
            codes::GENERATOR_BUSY
        } else {
            codes::GENERATOR_MISSING
        };
        Refusal { code, ..refusal }
    })
}

/// Mode, order of bits and clock as the file wants them, seen to be so. On failure what was not taken.
fn configure(spi: &mut Spidev, spec: &StreamSpec) -> Result<(), (String, io::Error)> {
    let mode = SpiModeFlags::from_bits_truncate(u32::from(spec.mode & 3));
    let order = if spec.lsb_first { "lowest" } else { "highest" };
    let hz = spec.clock.hz();
    let wanted = [
        (format!("mode {}", spec.mode), SpidevOptions::new().mode(mode).build()),
        (
            format!("8 bits a word, {order} first"),
            SpidevOptions::new().bits_per_word(WORD).lsb_first(spec.lsb_first).build(),
        ),
        (format!("{hz} Hz"), SpidevOptions::new().max_speed_hz(hz).build()),
    ];
    for (what, options) in wanted {
        spi.configure(&options).map_err(|error| (what.clone(), error))?;
        let now = spi.query_configuration().map_err(|error| (what.clone(), error))?;
        let kept = options.bits_per_word.is_none_or(|bits| now.bits_per_word == Some(bits))
            && options.max_speed_hz.is_none_or(|hz| now.max_speed_hz == Some(hz))
            && options.lsb_first.is_none_or(|first| now.lsb_first == Some(first))
            && options
                .spi_mode
                .is_none_or(|mode| now.spi_mode.is_some_and(|now| now & SpiModeFlags::SPI_MODE_3 == mode));
        if !kept {
            return Err((what, io::Error::other("it keeps another setting")));
        }
    }
    Ok(())
}

impl Generator for Stream {
    fn device(&self) -> &str {
        &self.name
    }

    /// Between two streams the line is at rest, and a stream that is under way comes to rest by itself.
    fn rest(&mut self) -> io::Result<()> {
        self.look()
    }

    fn level(&mut self, _output: u8, _high: bool) -> io::Result<()> {
        Err(Errno::OPNOTSUPP.into())
    }

    fn square(&mut self, _output: u8, _period: Span, _high: Span) -> io::Result<()> {
        Err(Errno::OPNOTSUPP.into())
    }

    fn pulses(&mut self, _output: u8, edges: &[Span]) -> io::Result<SentPulses> {
        let used = self.layout.write(self.clock, edges, &mut self.bytes).ok_or(Errno::MSGSIZE)?;
        self.send(used)
    }

    fn lasts(&self, edges: &[Span]) -> Span {
        let last = edges.last().map_or(0, |edge| self.clock.bit(*edge));
        self.clock.lasts(self.layout.bytes(last).saturating_mul(u64::from(WORD)))
    }

    fn look(&mut self) -> io::Result<()> {
        self.spi.query_configuration().map(|_| ())
    }

    /// Nothing: a line that is at rest by itself needs nobody to make it safe.
    fn output_claims(&self) -> io::Result<Vec<OutputClaim>> {
        Ok(Vec::new())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_clock_is_told_from_a_busy_machine() {
        let ms = Span::from_millis;
        let us = Span::from_micros;
        assert!(!is_late(ms(32), &[us(32_900), Span::MAX]));
        // Half the clock, and now and then a machine that is late.
        assert!(is_late(ms(32), &[ms(64), us(64_050), us(64_090), ms(70), ms(80), ms(95)]));
        // The clock of the lab, on a machine that has no time.
        assert!(!is_late(ms(32), &[34, 35, 38, 40, 51, 90].map(ms)));
        // So many bits a second as there are none.
        let ns = Span::from_nanos;
        assert!(is_late(ns(8_192), &[ns(655_360), us(700), us(730), ms(5), ms(5), ms(6)]));
    }
}
