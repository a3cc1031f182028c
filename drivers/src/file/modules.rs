//! Terminals of expansion modules on a board: a channel has the name of its terminal.

use document::Diagnostic;
use signal::{Address, Area, Size};

use super::{Binding, BoardFile, codes};
use crate::circuit::{ChannelSpec, MAX_PARTS};
use crate::{ChannelId, ChannelKind};

/// A terminal of an expansion module.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModuleTerminal {
    /// The name of its channel: `M1.I0` is the first input of the first module.
    pub name: String,
    /// Its place in the images.
    pub address: Address,
}

impl BoardFile {
    /// Binds terminals of modules to the channels that have their names. A simulated board gets a channel of its own for each
    /// other one, digital for a bit and analog for more; on a real board such a terminal is open.
    ///
    /// # Errors
    /// `B0305` for each channel of the file that does not suit its terminal.
    pub fn bind_modules(&mut self, terminals: &[ModuleTerminal]) -> Result<(), Vec<Diagnostic>> {
        let mut wrong = Vec::new();
        for ModuleTerminal { name, address } in terminals {
            let channel = match self.find(name) {
                Some(channel) => {
                    wrong.extend(self.misfit(name, *address, channel));
                    channel
                }
                None if self.is_real() || self.circuit.channels.len() >= MAX_PARTS => continue,
                None => {
                    let Ok(place) = u16::try_from(self.circuit.channels.len()) else { continue };
                    self.circuit.channels.push(ChannelSpec::default_of(name.clone(), *address));
                    ChannelId(place)
                }
            };
            self.bind.push(Binding { address: *address, channel });
        }
        self.bind.sort_by_key(|binding| binding.address);
        if wrong.is_empty() { Ok(()) } else { Err(wrong) }
    }

    /// What is wrong with a channel of the file at this terminal.
    fn misfit(&self, name: &str, address: Address, channel: ChannelId) -> Option<Diagnostic> {
        let spec = &self.circuit.channels[usize::from(channel.0)];
        let (is, kind) = match (address.size(), &spec.kind) {
            (Size::Bit, ChannelKind::Digital)
            | (Size::Byte | Size::Word | Size::Double | Size::Long, ChannelKind::Analog { .. }) => {
                return None;
            }
            // The terminal makes a level of a voltage.
            (Size::Bit, ChannelKind::Analog { unit }) if unit == "V" && address.area() == Area::Input => {
                return None;
            }
            (Size::Bit, _) => ("a level", "digital"),
            _ => ("a number", "analog"),
        };
        let message =
            format!("the terminal {address} of a module is {is}, the channel `{name}` carries none");
        let help = format!("describe it with kind = \"{kind}\", or give it another name");
        Some(Diagnostic::error(codes::BINDING, message).at(&self.name, 0..0, "").help(help))
    }
}
