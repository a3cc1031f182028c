//! Expansion modules of a board: which are fitted, and their terminals, which go with the channels of their names.

use document::{Diagnostic, Fields, Findings, Node, suggest};
use signal::{Address, Area, Size};

use super::{Binding, BoardFile, Subject, codes, keys};
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

/// More modules than are fitted beside any controller.
const MOST: usize = 32;

/// The references of `modules`, as `known` writes them.
pub(super) fn fitted(
    fields: &Fields,
    known: &[String],
    subject: &Subject,
    out: &mut Findings,
) -> Option<Vec<String>> {
    let node = fields.get("modules")?;
    if subject.is_external() {
        out.bad(
            codes::FITTED,
            node,
            "a real controller finds its modules by itself",
            "remove `modules`: it is what is fitted beside the rig's own controller",
        );
        return None;
    }
    let list = fields.each("modules");
    if let Some(node) = list.get(MOST) {
        out.bad(codes::FITTED, node, format!("more than {MOST} modules"), "no controller takes so many");
    }
    Some(list.iter().take(MOST).filter_map(|node| reference(node, known, out)).collect())
}

fn reference(node: &Node, known: &[String], out: &mut Findings) -> Option<String> {
    let fields = node.as_table().map(|table| Fields::checked(table, keys::MODULE));
    let node = match &fields {
        Some(fields) => fields.get("type")?,
        None => node,
    };
    let name = node.as_text()?.trim();
    let found = known.iter().find(|known| known.eq_ignore_ascii_case(name)).cloned();
    if found.is_none() {
        let help = match suggest(&name.to_uppercase(), known.iter().map(String::as_str)) {
            Some(near) => format!("did you mean `{near}`? `rig explain modules` lists them"),
            None => String::from("`rig explain modules` lists them"),
        };
        out.bad(codes::FITTED, node, format!("the catalogue has no module `{name}`"), help);
    }
    found
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
