//! Where the channels of configured modules are in the images (io: section 2).

use super::{ConfiguredModule, ModuleFamily, ModuleType};
use crate::{IMAGE_BITS, Reference, rearming_command, short_circuit_status};
use signal::{Address, Area, Size};
use std::fmt;

/// The addresses of channels of one kind: `count` objects of one size, one after the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChannelAddresses {
    area: Area,
    size: Size,
    /// The place of the first one among the objects of its size.
    first: u32,
    count: u32,
}

impl ChannelAddresses {
    /// How many there are.
    pub const fn count(&self) -> u32 {
        self.count
    }

    /// The address of a channel, from 0.
    pub fn get(&self, channel: u32) -> Option<Address> {
        (channel < self.count).then(|| Address::new(self.area, self.size, self.first + channel)).flatten()
    }

    /// The addresses in the order of the channels.
    pub fn iter(&self) -> impl Iterator<Item = Address> + use<> {
        let all = *self;
        (0..all.count).filter_map(move |channel| all.get(channel))
    }
}

impl fmt::Display for ChannelAddresses {
    /// The first and the last: `%IX4.0..%IX5.7`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.get(0), self.count.checked_sub(1).and_then(|last| self.get(last))) {
            (Some(first), Some(last)) if first != last => write!(f, "{first}..{last}"),
            (Some(first), _) => write!(f, "{first}"),
            (None, _) => Ok(()),
        }
    }
}

/// Where a module is in the images; what it has not, or what no document gives, is absent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ModuleAddresses {
    /// Digital inputs, bits of %I.
    pub digital_inputs: Option<ChannelAddresses>,
    /// Analogue inputs, words of %I.
    pub analogue_inputs: Option<ChannelAddresses>,
    /// Status bytes, bytes of %I: those of the inputs, then those of the outputs (io:DIAG-06). They follow the words of
    /// the module (rig definition).
    pub status: Option<ChannelAddresses>,
    /// Digital outputs, bits of %Q.
    pub digital_outputs: Option<ChannelAddresses>,
    /// Analogue outputs, words of %Q.
    pub analogue_outputs: Option<ChannelAddresses>,
}

/// Modules that an image has no room for (io:ADR-06).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageFull {
    /// The place in the list of the first module that does not fit.
    pub place: usize,
    /// The image.
    pub area: Area,
}

impl fmt::Display for ImageFull {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let letter = if self.area == Area::Input { 'I' } else { 'Q' };
        write!(
            f,
            "module {} of the list does not fit into %{letter}, which has {IMAGE_BITS} bits",
            self.place + 1
        )
    }
}

impl std::error::Error for ImageFull {}

/// One image, filled from below.
struct Filled {
    area: Area,
    /// The first byte that is free.
    free: u32,
}

/// The image has no room left.
struct Full(Area);

impl Filled {
    /// Room for `count` objects of `size` that take `bytes`, at an even byte where `even`.
    fn take(
        &mut self,
        size: Size,
        count: u32,
        bytes: u32,
        even: bool,
    ) -> Result<Option<ChannelAddresses>, Full> {
        if count == 0 {
            return Ok(None);
        }
        let start = if even { self.free.next_multiple_of(2) } else { self.free };
        let end = start.saturating_add(bytes);
        if end > IMAGE_BITS / 8 {
            return Err(Full(self.area));
        }
        self.free = end;
        Ok(Some(ChannelAddresses { area: self.area, size, first: start * 8 / size.bits(), count }))
    }

    /// Digital channels: groups of 16 begin at an even byte (io:ADR-05).
    fn digital(&mut self, count: u32) -> Result<Option<ChannelAddresses>, Full> {
        self.take(Size::Bit, count, digital_bytes(count), count > 8)
    }

    /// Analogue channels: words (io:ADR-05).
    fn words(&mut self, count: u32) -> Result<Option<ChannelAddresses>, Full> {
        self.take(Size::Word, count, count.saturating_mul(2), true)
    }
}

/// The bytes of digital channels: up to 8 are a byte, more are groups of 16 (io:ADR-05).
fn digital_bytes(count: u32) -> u32 {
    if count <= 8 { count.div_ceil(8) } else { count.div_ceil(16).saturating_mul(2) }
}

impl ModuleType {
    /// The bytes of %I that its inputs take, status bytes left out.
    pub fn input_bytes(&self) -> u32 {
        digital_bytes(self.digital_input_count()) + 2 * self.analogue_input_count()
    }

    /// The bytes of %Q that its outputs take.
    pub fn output_bytes(&self) -> u32 {
        digital_bytes(self.digital_output_count()) + 2 * self.analogue_output_count()
    }
}

/// The first byte of %I and of %Q after the embedded I/O: after the status of the outputs and the command that rearms them
/// (io:ADR-01, io:ADR-02); 0 without embedded I/O.
fn first_free(reference: &Reference) -> (u32, u32) {
    let after = |place: Option<(u32, u32)>| place.map_or(0, |(byte, _)| byte + 1);
    (after(short_circuit_status(reference)), after(rearming_command(reference)))
}

impl Reference {
    /// Where each of these modules is in the images of a controller of this reference, in the order of the list: cartridges
    /// come first, then the others as they are configured, %I and %Q apart (io:ADR-05). TM4 modules have no place there.
    ///
    /// # Errors
    /// [`ImageFull`] with the first module that does not fit (io:ADR-06).
    pub fn module_addresses(
        &self,
        modules: &[ConfiguredModule<'_>],
    ) -> Result<Vec<ModuleAddresses>, ImageFull> {
        let (input, output) = first_free(self);
        let mut inputs = Filled { area: Area::Input, free: input };
        let mut outputs = Filled { area: Area::Output, free: output };
        let mut addresses = vec![ModuleAddresses::default(); modules.len()];
        for cartridges in [true, false] {
            let of_turn =
                |one: &ConfiguredModule<'_>| (one.module.family == ModuleFamily::Tmc4) == cartridges;
            for (place, configured) in modules.iter().enumerate().filter(|(_, one)| of_turn(one)) {
                addresses[place] = one_module(configured, &mut inputs, &mut outputs)
                    .map_err(|Full(area)| ImageFull { place, area })?;
            }
        }
        Ok(addresses)
    }
}

/// Room for a module.
fn one_module(
    configured: &ConfiguredModule<'_>,
    inputs: &mut Filled,
    outputs: &mut Filled,
) -> Result<ModuleAddresses, Full> {
    let module = configured.module;
    let status = if configured.status_enabled { module.status_bytes() } else { 0 };
    Ok(ModuleAddresses {
        digital_inputs: inputs.digital(module.digital_input_count())?,
        analogue_inputs: inputs.words(module.analogue_input_count())?,
        status: inputs.take(Size::Byte, status, status, false)?,
        digital_outputs: outputs.digital(module.digital_output_count())?,
        analogue_outputs: outputs.words(module.analogue_output_count())?,
    })
}
