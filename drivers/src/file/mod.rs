//! The board file: which controller is tested, on which board, bound how.

mod bench;
mod codes;
mod keys;
mod number;
mod parts;
mod read;

use signal::{Address, Size};

use crate::circuit::{ChannelSpec, Circuit, CircuitError, Pull};
use crate::wrap::{Disturbance, Faulty};
use crate::{Board, ChannelId, SimulatedBoard};

pub use codes::CODES;
pub use keys::KEYS;
pub use read::read;

/// The controller under test: the rig's own model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Subject {
    /// Name of its profile, as in `m241-2019`.
    pub profile: String,
    /// Its reference, as in `TM241CEC24T`; `None` for the profile's usual one.
    pub reference: Option<String>,
}

impl Default for Subject {
    /// `m241-2019`, `TM241CEC24T`.
    fn default() -> Self {
        Subject { profile: "m241-2019".into(), reference: Some("TM241CEC24T".into()) }
    }
}

/// The terminals of a controller that a board can be bound to, in the order of their numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Terminals {
    /// Its inputs: `I0` is the first.
    pub inputs: Vec<Address>,
    /// Its outputs: `Q0` is the first.
    pub outputs: Vec<Address>,
}

/// A subject that does not exist, with the names that do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum UnknownSubject {
    /// No such profile.
    Profile {
        /// The profiles.
        known: Vec<String>,
    },
    /// The profile has no such reference.
    Reference {
        /// The profile's references.
        known: Vec<String>,
    },
}

/// A terminal of the controller and the channel that it is wired to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Binding {
    /// The terminal, in the input or output area.
    pub address: Address,
    /// The channel.
    pub channel: ChannelId,
}

/// A board file that was read and is sound.
#[derive(Clone, Debug, PartialEq)]
pub struct BoardFile {
    /// Path as the user gave it; `default board` for the one without a file.
    pub name: String,
    /// Its title; may be empty.
    pub title: String,
    /// The controller under test.
    pub subject: Subject,
    /// What the simulated board is made of.
    pub circuit: Circuit,
    /// Terminals and channels, by address; inputs first. Each address once.
    pub bind: Vec<Binding>,
    /// Trouble that the board is to make by itself, if any.
    pub disturbance: Option<Disturbance>,
}

impl BoardFile {
    /// The board without a file: a simulated one with a channel `I0`, `I1`, ... for every input and `Q0`, `Q1`,
    /// ... for every output, in the order given: digital for a bit, analog for more; and nothing between them. The subject is the default one.
    pub fn default_for(inputs: &[Address], outputs: &[Address]) -> Self {
        let mut circuit = Circuit::default();
        let mut bind = Vec::new();
        for (letter, pull, addresses) in [('I', Pull::Down, inputs), ('Q', Pull::None, outputs)] {
            for (number, address) in addresses.iter().enumerate() {
                let Ok(place) = u16::try_from(circuit.channels.len()) else { break };
                let name = format!("{letter}{number}");
                circuit.channels.push(match address.size() {
                    Size::Bit => ChannelSpec::digital(name, pull),
                    _ => ChannelSpec::analog(name, ""),
                });
                bind.push(Binding { address: *address, channel: ChannelId(place) });
            }
        }
        bind.sort_by_key(|binding| binding.address);
        BoardFile {
            name: "default board".into(),
            title: String::new(),
            subject: Subject::default(),
            circuit,
            bind,
            disturbance: None,
        }
    }

    /// The channel that a terminal is wired to.
    pub fn channel_of(&self, address: Address) -> Option<ChannelId> {
        self.bind.iter().find(|binding| binding.address == address).map(|binding| binding.channel)
    }

    /// The channel of this name.
    pub fn find(&self, name: &str) -> Option<ChannelId> {
        let place = self.circuit.channels.iter().position(|channel| channel.name == name)?;
        u16::try_from(place).ok().map(ChannelId)
    }
}

/// Builds the board of a file; all that is random on it follows from `seed`.
///
/// # Errors
/// The first of [`Circuit::check`]: none for a file that [`read`] let through.
pub fn build(file: &BoardFile, seed: u64) -> Result<Box<dyn Board>, CircuitError> {
    let board = SimulatedBoard::new(&file.circuit, seed)?;
    Ok(match file.disturbance {
        Some(disturbance) => Box::new(Faulty::new(board, disturbance, seed)),
        None => Box::new(board),
    })
}
