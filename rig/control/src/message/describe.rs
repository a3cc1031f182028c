//! What a rig is: reported once, when somebody connects or asks.

use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// The first line of a rig.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Greeting {
    /// Always `scanrig`.
    pub rig: String,
    /// The version of the protocol: [`crate::PROTOCOL`].
    pub protocol: u32,
    /// The version of the program.
    pub version: String,
    /// The board file, as it was named.
    pub board: String,
    /// The controller that is modelled, as in `TM241CEC24T`.
    pub reference: String,
    /// The number of this connection, from 1.
    pub client: u64,
}

/// What makes time pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TimeSource {
    /// The host's clock.
    #[default]
    Real,
    /// Clients: time stands still until one advances it ([`crate::RequestOperation::Advance`]).
    #[serde(alias = "led")]
    Stepped,
}

/// What is under test.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SubjectKind {
    /// The modelled controller.
    #[default]
    Model,
    /// A real controller on the wires.
    External,
}

/// What a rig is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Description {
    /// The board file, as it was named.
    pub board: String,
    /// The controller that is modelled.
    pub reference: String,
    /// Its profile.
    pub profile: String,
    /// The program files, as they were named.
    pub program: Vec<String>,
    /// What makes time pass.
    pub clock: TimeSource,
    /// What is under test.
    pub subject: SubjectKind,
    /// The terminals of the controller and the lines of the board, in the order in which they are shown.
    pub points: Vec<PointInfo>,
    /// Everything inside that has a name: variables, system variables, indicators, facts of functions. Addresses such
    /// as `%MW12` can be named besides.
    pub signals: Vec<Signal>,
    /// The tasks of the application, in the order of the configuration.
    pub tasks: Vec<TaskInfo>,
    /// The expert functions.
    pub functions: Vec<FunctionInfo>,
    /// The buses of the board.
    pub buses: Vec<BusInfo>,
    /// The expansion modules that are configured, in the order of the bus.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub modules: Vec<ModuleInfo>,
    /// The devices of the board.
    pub devices: Vec<DeviceInfo>,
    /// What happens to forces when a connection that set them is lost.
    pub on_disconnect: String,
    /// The load above which the controller is overloaded, in per mille of its processor.
    pub load_limit: u32,
}

impl Description {
    /// The listed signal of this name, in any case of letters.
    pub fn signal(&self, name: &str) -> Option<&Signal> {
        self.signals.iter().find(|signal| signal.name.eq_ignore_ascii_case(name))
    }

    /// What is known of a name in the order in which the rig looks names up, in any case of letters: a listed signal, a line of the
    /// board, a variable that is named without its program.
    pub fn named(&self, name: &str) -> Option<Cow<'_, Signal>> {
        let line = |point: &PointInfo| {
            let channel = point.channel.as_ref().filter(|it| it.name.eq_ignore_ascii_case(name))?;
            Some(Signal::unlisted(&channel.name, &channel.unit))
        };
        let inside = |signal: &&Signal| {
            signal.name.split_once('.').is_some_and(|(_, path)| path.eq_ignore_ascii_case(name))
        };
        let signal = self.signal(name).map(Cow::Borrowed);
        let line = || self.points.iter().find_map(line).map(Cow::Owned);
        signal.or_else(line).or_else(|| self.signals.iter().find(inside).map(Cow::Borrowed))
    }
}

/// Which way a point goes, seen from the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PointDirection {
    /// Into the controller.
    Input,
    /// Out of it.
    Output,
    /// A line of the board that no terminal is bound to.
    Loose,
}

/// A terminal of the controller, or a line of the board that has none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointInfo {
    /// The terminal, as in `I0` or `Q4`, else the channel's name.
    pub name: String,
    /// Its address in the image, as in `%IX0.0`; none for a line without a terminal.
    pub address: Option<String>,
    /// The program's name for it, where a variable is located there.
    pub variable: Option<String>,
    /// Which way it goes.
    pub direction: PointDirection,
    /// What it carries.
    pub kind: SignalKind,
    /// The channel of the board behind it; none where nothing is bound.
    pub channel: Option<ChannelInfo>,
    /// The signal that shows its image, of the kind `kind`: what the program sees or wrote.
    pub image: Option<String>,
    /// Whether it can be forced.
    pub forcible: bool,
    /// Whether its line can be written: a line that nothing of the rig drives.
    #[serde(default)]
    pub writable: bool,
    /// What the words of an analogue channel stand for; none for a level, and for a mode whose ends are not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<WordScale>,
}

/// What the words of an analogue channel stand for: two of them, and between those words and values are proportional.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WordScale {
    /// The words at the low and at the high end of the channel's mode.
    pub words: [f64; 2],
    /// The values there, in `unit`.
    pub values: [f64; 2],
    /// The unit of the values.
    pub unit: String,
}

impl WordScale {
    /// The value that a word stands for, also beyond the ends.
    pub fn value(&self, word: f64) -> f64 {
        let [low, high] = self.values;
        low + (high - low) * self.share(word)
    }

    /// How far a word is from the low end to the high one: 0 to 1, less below it and more above it.
    pub fn share(&self, word: f64) -> f64 {
        let [low, high] = self.words;
        (word - low) / (high - low)
    }
}

/// A channel of the board.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChannelInfo {
    /// Its name in the board file. It names a signal, too: what is on the line.
    pub name: String,
    /// The unit of what is on the line; empty for a level or count.
    pub unit: String,
    /// The place in [`Description::devices`] of the device behind it; none for a simulated line.
    pub device: Option<usize>,
    /// The rig drives it.
    pub drives: bool,
}

/// What the values of a signal are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SignalKind {
    /// A Boolean or a line's level.
    Bool,
    /// A whole number.
    Int,
    /// A bit string.
    Word,
    /// A real number.
    Real,
    /// A number that has names: see [`Signal::labels`].
    State,
}

/// Something that can be read and watched.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Signal {
    /// Its number: what changes name it by. The same for the same name as long as the rig runs.
    pub number: u32,
    /// Its name.
    pub name: String,
    /// What its values are.
    pub kind: SignalKind,
    /// The unit of its values; empty for none.
    pub unit: String,
    /// The names of its values, where they have any.
    pub labels: Vec<(i64, String)>,
    /// Whether it can be written.
    pub writable: bool,
}

impl Signal {
    /// A signal that no list has, with a unit or none.
    pub fn unlisted(name: &str, unit: &str) -> Signal {
        Signal {
            number: 0,
            name: name.to_owned(),
            kind: SignalKind::Real,
            unit: unit.to_owned(),
            labels: Vec::new(),
            writable: false,
        }
    }
}

/// A task.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TaskInfo {
    /// Its name.
    pub name: String,
    /// `cyclic`, `freewheeling`, `event` or `external-event`.
    pub kind: String,
    /// Its interval, nanoseconds; 0 where it has none.
    pub interval: i64,
    /// Its priority; 0 is the highest.
    pub priority: u8,
    /// Its watchdog's time, nanoseconds; none where it is off.
    pub watchdog: Option<i64>,
    /// The programs that it runs.
    pub programs: Vec<String>,
}

/// An expansion module.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ModuleInfo {
    /// Its index in TM3_MODULE_R.
    pub index: u8,
    /// The reference that is configured, as in `TM3DI16`.
    pub reference: String,
    /// It may be missing.
    pub optional: bool,
}

/// An expert function.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FunctionInfo {
    /// Its name, as in `HSC0`.
    pub name: String,
    /// Its kind in words, as in `HSC main, dual phase x4` or `PTO`.
    pub kind: String,
    /// The signals of its facts, most important first.
    pub signals: Vec<String>,
    /// The terminals that it has, as in `I0`.
    pub terminals: Vec<String>,
}

/// A bus.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BusInfo {
    /// Its name in the board file.
    pub name: String,
    /// `can`, `can-fd` or `serial`.
    pub kind: String,
    /// Its speed and format in words, as in `500 kbit/s` or `19200 Bd 8E1`.
    pub settings: String,
    /// The port of the controller that is on it, as in `SL1`; empty where none is.
    #[serde(default)]
    pub port: String,
}

/// A device of the board.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DeviceInfo {
    /// Its name in the board file.
    pub name: String,
    /// Its kind, as in `gpio`, `spi`, `can`.
    pub kind: String,
    /// Where it is, as in `/dev/gpiochip0`; empty where it has no place.
    pub path: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_variable_may_be_named_without_its_program() {
        let signal = |number, name: &str| Signal {
            number,
            name: name.into(),
            kind: SignalKind::Int,
            unit: String::new(),
            labels: Vec::new(),
            writable: true,
        };
        let signals = vec![signal(0, "MAIN.delay.ET"), signal(1, "MAIN.state"), signal(2, "state")];
        let it = Description { signals, ..Description::default() };
        let number = |name: &str| it.named(name).map(|signal| signal.number);
        assert_eq!(
            [number("main.Delay.et"), number("delay.ET"), number("STATE")],
            [Some(0), Some(0), Some(2)]
        );
        assert_eq!([number("ET"), number("MAIN"), number("")], [None; 3]);
    }
}
