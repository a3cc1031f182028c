//! Outputs of the kernel's PWM chips.

mod find;
mod output;
mod sysfs;

pub use find::{FoundPwm, find};
pub use output::{Attribute, Attributes, PwmOutput};

use std::io;
use std::path::Path;

use rustix::io::Errno;
use signal::Span;

use super::{Generator, OutputSpec, PwmSpec, SentPulses};
use crate::refusal::Refusal;
use crate::{LineApi, OutputClaim};
use sysfs::Exported;

/// The period of an output that rests and has none yet, where the chip can do it.
const AT_REST: Span = Span::from_millis(1);

/// Outputs of a PWM chip that are the rig's alone.
#[derive(Debug)]
pub struct Pwm {
    name: String,
    spec: PwmSpec,
    outputs: Vec<(PwmOutput, OutputSpec)>,
    /// Given back after the outputs.
    _exported: Vec<Exported>,
}

impl Pwm {
    /// Takes the outputs of a chip, and sets them to work at rest.
    ///
    /// # Errors
    /// It is not there, or an output is not free, not permitted, or refuses.
    pub fn open(spec: &PwmSpec, outputs: &[OutputSpec]) -> Result<Pwm, Refusal> {
        let chip = find(Path::new("/"), spec)?;
        let period = spec.counted(AT_REST.clamp(spec.shortest, spec.longest.max(spec.shortest)));
        let mut opened = Pwm {
            name: chip.words(),
            spec: spec.clone(),
            outputs: Vec::with_capacity(outputs.len()),
            _exported: Vec::with_capacity(outputs.len()),
        };
        for wanted in outputs {
            let (output, exported) = sysfs::claim(&chip, wanted, period)?;
            opened.outputs.push((output, wanted.clone()));
            opened._exported.push(exported);
        }
        Ok(opened)
    }

    fn output(&mut self, output: u8) -> io::Result<&mut (PwmOutput, OutputSpec)> {
        self.outputs.get_mut(usize::from(output)).ok_or_else(|| Errno::INVAL.into())
    }
}

/// The chip of these outputs in words, if none of them is held by somebody, as far as that can be seen.
pub(super) fn look(spec: &PwmSpec, outputs: &[OutputSpec]) -> Result<String, Refusal> {
    let chip = find(Path::new("/"), spec)?;
    outputs.iter().try_for_each(|output| sysfs::look(&chip, output))?;
    Ok(chip.words())
}

impl Generator for Pwm {
    fn device(&self) -> &str {
        &self.name
    }

    fn rest(&mut self) -> io::Result<()> {
        let mut outcome = Ok(());
        for (output, _) in &mut self.outputs {
            // Those that can be brought to rest are.
            let rests = output.rest();
            outcome = outcome.and(rests);
        }
        outcome
    }

    fn level(&mut self, output: u8, high: bool) -> io::Result<()> {
        let (output, spec) = self.output(output)?;
        if high == spec.safe { output.rest() } else { output.active() }
    }

    fn square(&mut self, output: u8, period: Span, high: Span) -> io::Result<()> {
        let (whole, high) = (self.spec.counted(period), self.spec.counted(high));
        let (output, spec) = self.output(output)?;
        // An output that rests high is active while it is low.
        output.wave(whole, if spec.safe { whole.saturating_sub(high) } else { high })
    }

    fn pulses(&mut self, _output: u8, _edges: &[Span]) -> io::Result<SentPulses> {
        Err(Errno::OPNOTSUPP.into())
    }

    fn lasts(&self, _edges: &[Span]) -> Span {
        Span::ZERO
    }

    fn look(&mut self) -> io::Result<()> {
        self.outputs.iter_mut().try_for_each(|(output, _)| output.look())
    }

    fn output_claims(&self) -> io::Result<Vec<OutputClaim>> {
        let held = |(output, _): &(PwmOutput, OutputSpec)| {
            let (device, claim) = (self.name.clone(), output.claim()?);
            Ok(OutputClaim { device, claim, api: LineApi::Pwm, mask: 1, safe: 0 })
        };
        self.outputs.iter().map(held).collect()
    }
}

impl Drop for Pwm {
    fn drop(&mut self) {
        for (output, spec) in &mut self.outputs {
            // An output that rests at a high level does so only while it runs.
            let _ = if spec.safe != spec.active_low { output.rest() } else { output.stop() };
        }
    }
}
