//! Expansion modules of a board: which are fitted, and their terminals, which go with the channels of their names.

use document::{Diagnostic, Fields, Findings, Node, suggest};
use signal::{Address, Area, Unit};

use super::{Binding, BoardFile, Subject, codes, keys};
use crate::circuit::{ChannelSpec, MAX_PARTS, Pull};
use crate::sensor::SensorCurve;
use crate::{ChannelId, ChannelKind};

/// A terminal of an expansion module or a cartridge.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModuleTerminal {
    /// The name of its channel: `M1.I0` is the first input of the first module.
    pub name: String,
    /// Its place in the images.
    pub address: Address,
    /// What it carries.
    pub kind: ModuleTerminalKind,
}

/// What a terminal of a module carries.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ModuleTerminalKind {
    /// A level.
    Level,
    /// A number in this unit.
    Number(Unit),
    /// A temperature in degrees Celsius, or what a sensor with this curve shows.
    Temperature(Option<SensorCurve>),
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
    /// other one, digital for a level and analog for a number; on a real board such a terminal is open.
    ///
    /// An analog channel at such a terminal reads [`Value::HighZ`](signal::Value::HighZ) while nobody drives it, but for a current:
    /// an open loop carries 0 mA.
    ///
    /// # Errors
    /// `B0305` or `B0312` for each channel of the file that does not suit its terminal.
    pub fn bind_modules(&mut self, terminals: &[ModuleTerminal]) -> Result<(), Vec<Diagnostic>> {
        let mut wrong = Vec::new();
        for terminal in terminals {
            let channel = match self.find(&terminal.name) {
                Some(channel) => {
                    wrong.extend(self.misfit(terminal, channel));
                    channel
                }
                None if self.is_real() || self.circuit.channels.len() >= MAX_PARTS => continue,
                None => {
                    let Ok(place) = u16::try_from(self.circuit.channels.len()) else { continue };
                    self.circuit.channels.push(channel_of(terminal));
                    ChannelId(place)
                }
            };
            let spec = &mut self.circuit.channels[usize::from(channel.0)];
            match &terminal.kind {
                ModuleTerminalKind::Level => {}
                ModuleTerminalKind::Number(unit) if *unit == Unit::new("mA") => spec.pull = Pull::Down,
                ModuleTerminalKind::Number(_) => spec.pull = Pull::None,
                ModuleTerminalKind::Temperature(curve) => {
                    spec.pull = Pull::None;
                    if let (Some(curve), ChannelKind::Analog { unit }) = (curve, &spec.kind)
                        && Unit::new(unit) == Unit::new(curve.unit())
                    {
                        self.sensors.push((channel, *curve));
                    }
                }
            }
            self.bind.push(Binding { address: terminal.address, channel });
        }
        self.bind.sort_by_key(|binding| binding.address);
        if wrong.is_empty() { Ok(()) } else { Err(wrong) }
    }

    /// What is wrong with a channel of the file at this terminal.
    fn misfit(&self, terminal: &ModuleTerminal, channel: ChannelId) -> Option<Diagnostic> {
        let ModuleTerminal { name, address, kind } = terminal;
        let refused = |code, message: String, help: String| {
            Some(Diagnostic::error(code, message).at(&self.name, 0..0, "").help(help))
        };
        if address.area() == Area::Output
            && *kind != ModuleTerminalKind::Level
            && self.circuit.is_target(channel)
        {
            let message = format!(
                "`{name}` is an output of the controller, and a wire or plant of the board drives it, too"
            );
            return refused(
                codes::TWO_SOURCES,
                message,
                String::from("turn the wire round, or give the plant another channel"),
            );
        }
        let (is, wanted) = match (kind, &self.circuit.channels[usize::from(channel.0)].kind) {
            (ModuleTerminalKind::Level, ChannelKind::Digital) => return None,
            // The terminal makes a level of a voltage.
            (ModuleTerminalKind::Level, ChannelKind::Analog { unit })
                if unit == "V" && address.area() == Area::Input =>
            {
                return None;
            }
            (ModuleTerminalKind::Level, _) => ("a level", "digital"),
            (_, ChannelKind::Analog { unit }) => {
                let units = units(kind);
                if units.contains(&Unit::new(unit)) {
                    return None;
                }
                let known: Vec<String> = units.iter().map(Unit::to_string).collect();
                let (has, known) = (if unit.is_empty() { "no unit" } else { unit }, known.join(" or "));
                let message = format!(
                    "the terminal {address} of a module is in {known}, the channel `{name}` has {has}"
                );
                let help =
                    format!("describe it with {known} as its unit, or choose another mode in the plan");
                return refused(codes::MODULE_UNIT, message, help);
            }
            _ => ("a number", "analog"),
        };
        let message =
            format!("the terminal {address} of a module is {is}, the channel `{name}` carries none");
        refused(
            codes::BINDING,
            message,
            format!("describe it with kind = \"{wanted}\", or give it another name"),
        )
    }
}

/// The units that a channel at a terminal of numbers can have, the usual one first.
fn units(kind: &ModuleTerminalKind) -> Vec<Unit> {
    match kind {
        ModuleTerminalKind::Level => Vec::new(),
        ModuleTerminalKind::Number(unit) => vec![unit.clone()],
        ModuleTerminalKind::Temperature(curve) => {
            std::iter::once("degC").chain(curve.map(SensorCurve::unit)).map(Unit::new).collect()
        }
    }
}

/// The channel of a terminal that the file says nothing of.
fn channel_of(terminal: &ModuleTerminal) -> ChannelSpec {
    let name = terminal.name.clone();
    match &terminal.kind {
        ModuleTerminalKind::Level => ChannelSpec::digital_at(name, terminal.address),
        kind => ChannelSpec::analog(name, units(kind).first().map(Unit::to_string).unwrap_or_default()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::circuit::WireSpec;
    use signal::Span;

    fn terminal(name: &str, address: &str, unit: Option<&str>) -> ModuleTerminal {
        let kind = match unit {
            Some("degC") => ModuleTerminalKind::Temperature(SensorCurve::of_mode("PT100")),
            Some(unit) => ModuleTerminalKind::Number(Unit::new(unit)),
            None => ModuleTerminalKind::Level,
        };
        ModuleTerminal { name: name.into(), address: address.parse().unwrap(), kind }
    }

    /// A board with one channel, bound to a terminal of its name.
    fn bind(channel: ChannelSpec, terminal: ModuleTerminal) -> Result<BoardFile, &'static str> {
        let mut board = BoardFile::default_for(&[], &[]);
        board.circuit.channels.push(channel);
        board.bind_modules(&[terminal]).map_err(|found| found[0].code)?;
        Ok(board)
    }

    #[test]
    fn a_channel_of_another_kind_or_unit_is_refused() {
        let analog = |unit: &str| ChannelSpec::analog("M1.IW0", unit);
        let wanted = |unit: &str| terminal("M1.IW0", "%IW2", Some(unit));
        assert!(bind(analog("°C"), wanted("degC")).is_ok());
        assert_eq!(bind(analog("degC"), wanted("degC")).unwrap().sensors, []);
        let resistance = bind(analog("Ohm"), wanted("degC")).unwrap();
        assert_eq!(resistance.sensors, [(ChannelId(0), SensorCurve::of_mode("PT100").unwrap())]);
        assert_eq!(bind(analog("mV"), wanted("degC")).unwrap_err(), codes::MODULE_UNIT);
        assert_eq!(bind(analog("V"), wanted("mA")).unwrap_err(), codes::MODULE_UNIT);
        assert_eq!(bind(analog(""), wanted("V")).unwrap_err(), codes::MODULE_UNIT);
        let digital = ChannelSpec::digital("M1.IW0", Pull::Down);
        assert_eq!(bind(digital, wanted("V")).unwrap_err(), codes::BINDING);
        let level = || terminal("M1.I0", "%IX4.0", None);
        assert!(bind(ChannelSpec::analog("M1.I0", "V"), level()).is_ok());
        assert_eq!(bind(ChannelSpec::analog("M1.I0", "mA"), level()).unwrap_err(), codes::BINDING);
    }

    /// A wire that was laid the wrong way round had no effect, and nothing said so.
    #[test]
    fn a_wire_into_an_output_is_refused() {
        for (to, fits) in [(0, false), (1, true)] {
            let mut board = BoardFile::default_for(&[], &[]);
            board.circuit.channels = ["M1.QW0", "level"].map(|name| ChannelSpec::analog(name, "V")).into();
            let (from, to) = (ChannelId(1 - to), ChannelId(to));
            let wire = WireSpec { from, to, delay: Span::ZERO, off_delay: None, invert: false, bounce: None };
            board.circuit.wires.push(wire);
            let bound = board.bind_modules(&[terminal("M1.QW0", "%QW2", Some("V"))]);
            let code = bound.err().map(|found| found[0].code);
            assert_eq!(code, (!fits).then_some(codes::TWO_SOURCES), "to {to:?}");
        }
    }

    #[test]
    fn what_nobody_drives_is_no_number_but_for_a_current() {
        for (unit, pull) in [("V", Pull::None), ("degC", Pull::None), ("Ohm", Pull::None), ("mA", Pull::Down)]
        {
            let described = bind(ChannelSpec::analog("M1.IW0", unit), terminal("M1.IW0", "%IW2", Some(unit)));
            assert_eq!(described.unwrap().circuit.channels[0].pull, pull, "{unit}");
            let mut board = BoardFile::default_for(&[], &[]);
            board.bind_modules(&[terminal("M1.QW0", "%QW2", Some(unit))]).unwrap();
            let own = &board.circuit.channels[0];
            assert_eq!((own.name.as_str(), own.pull), ("M1.QW0", pull), "{unit}");
        }
    }
}
