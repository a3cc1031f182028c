//! The terminals of configured modules: their names, their places in the images, and what keeps one from being used.

use profile::{
    AnalogueChannels, AnalogueEnds, ChannelAddresses, ConfiguredModule, ModuleAddresses, Reference,
};
use signal::{Address, Area};
use std::fmt;

/// The four kinds of channels of a module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ChannelKind {
    DigitalInput,
    AnalogueInput,
    DigitalOutput,
    AnalogueOutput,
}

impl ChannelKind {
    const ALL: [ChannelKind; 4] = [
        ChannelKind::DigitalInput,
        ChannelKind::AnalogueInput,
        ChannelKind::DigitalOutput,
        ChannelKind::AnalogueOutput,
    ];

    /// What stands between the module and the number in the name of a terminal.
    const fn letters(self) -> &'static str {
        match self {
            ChannelKind::DigitalInput => "I",
            ChannelKind::AnalogueInput => "IW",
            ChannelKind::DigitalOutput => "Q",
            ChannelKind::AnalogueOutput => "QW",
        }
    }

    const fn is_input(self) -> bool {
        matches!(self, ChannelKind::DigitalInput | ChannelKind::AnalogueInput)
    }

    /// The channels of this kind that a module has.
    const fn of(self, places: &ModuleAddresses) -> Option<ChannelAddresses> {
        match self {
            ChannelKind::DigitalInput => places.digital_inputs,
            ChannelKind::AnalogueInput => places.analogue_inputs,
            ChannelKind::DigitalOutput => places.digital_outputs,
            ChannelKind::AnalogueOutput => places.analogue_outputs,
        }
    }
}

/// A module with its place in the list and in the images.
#[derive(Clone, Copy, Debug)]
pub struct ListedModule<'a> {
    /// From 1, as in `M1`.
    pub number: usize,
    /// As it is configured.
    pub configured: &'a ConfiguredModule<'static>,
    /// Where it is.
    pub places: ModuleAddresses,
}

/// A terminal of a module.
#[derive(Clone, Copy, Debug)]
pub struct TerminalOfModule<'a> {
    module: ListedModule<'a>,
    kind: ChannelKind,
    channel: usize,
}

impl fmt::Display for TerminalOfModule<'_> {
    /// Its name: `M1.IW0`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "M{}.{}{}", self.module.number, self.kind.letters(), self.channel)
    }
}

impl TerminalOfModule<'_> {
    /// The reference of its module.
    pub fn reference(&self) -> &str {
        &self.module.configured.module.reference
    }

    /// The mode that a channel of the same kind has; none where it is not used.
    fn mode(&self, channel: usize) -> Option<&str> {
        let configured = self.module.configured;
        match self.kind {
            ChannelKind::AnalogueInput => configured.input(channel).map(|input| input.mode.name.as_str()),
            ChannelKind::AnalogueOutput => configured.output(channel).map(|output| output.mode.name.as_str()),
            ChannelKind::DigitalInput | ChannelKind::DigitalOutput => None,
        }
    }

    /// What the words of an analogue channel that is used stand for.
    pub fn ends(&self) -> Option<AnalogueEnds> {
        let configured = self.module.configured;
        match self.kind {
            ChannelKind::AnalogueInput => configured.input(self.channel)?.ends(),
            ChannelKind::AnalogueOutput => configured.output(self.channel)?.ends(),
            ChannelKind::DigitalInput | ChannelKind::DigitalOutput => None,
        }
    }

    /// Whether it is used: an analogue channel needs a mode for that.
    pub fn is_used(&self) -> bool {
        matches!(self.kind, ChannelKind::DigitalInput | ChannelKind::DigitalOutput)
            || self.mode(self.channel).is_some()
    }

    /// Whether its channel is analogue: a word.
    pub fn is_word(&self) -> bool {
        matches!(self.kind, ChannelKind::AnalogueInput | ChannelKind::AnalogueOutput)
    }

    /// Whether its channel is an input.
    pub fn is_input(&self) -> bool {
        self.kind.is_input()
    }

    /// Where its channel is in an image.
    pub fn place(&self) -> Option<Address> {
        self.kind.of(&self.module.places)?.iter().nth(self.channel)
    }

    /// Where the status byte of an analogue channel is; none where the module has none. Those of inputs come first.
    pub fn status(&self) -> Option<Address> {
        let before = match self.kind {
            ChannelKind::AnalogueInput => 0,
            ChannelKind::AnalogueOutput => {
                self.module.places.analogue_inputs.map_or(0, |inputs| inputs.count() as usize)
            }
            ChannelKind::DigitalInput | ChannelKind::DigitalOutput => return None,
        };
        self.module.places.status?.iter().nth(before + self.channel)
    }

    /// What to write so that an analogue channel is used.
    pub fn how_to_use(&self) -> String {
        let module = self.module.configured.module;
        let (key, what, channels) = match self.kind.is_input() {
            true => ("inputs", "an input", &module.analogue_inputs),
            false => ("outputs", "an output", &module.analogue_outputs),
        };
        let first = |channels: &AnalogueChannels| channels.modes.first().map(|mode| mode.name.clone());
        let Some(mode) = channels.as_ref().and_then(first) else {
            return format!("no document has the modes of {}: its channels cannot be used", module.reference);
        };
        let before = (0..self.channel).map(|channel| self.mode(channel).unwrap_or("not used"));
        let list: Vec<String> = before.chain([mode.as_str()]).map(|mode| format!("\"{mode}\"")).collect();
        format!(
            "{what} is used where it has a `mode`: write {{ type = \"{}\", {key} = [{}] }} in `settings.modules`; \
             `rig explain {}` lists the modes",
            module.reference,
            list.join(", "),
            module.reference
        )
    }
}

/// The modules of a configuration with their terminals.
#[derive(Clone, Debug)]
pub struct ModuleTerminals<'a> {
    modules: &'a [ConfiguredModule<'static>],
    /// Empty for a list that the images have no room for.
    places: Vec<ModuleAddresses>,
}

impl<'a> ModuleTerminals<'a> {
    /// The terminals of modules beside a controller.
    pub fn new(reference: &Reference, modules: &'a [ConfiguredModule<'static>]) -> ModuleTerminals<'a> {
        ModuleTerminals { modules, places: reference.module_addresses(modules).unwrap_or_default() }
    }

    /// The modules in the order of the list.
    pub fn modules(&self) -> impl Iterator<Item = ListedModule<'a>> {
        let numbered = (1..).zip(self.modules).zip(&self.places);
        numbered.map(|((number, configured), places)| ListedModule { number, configured, places: *places })
    }

    /// The terminals whose channels a place of an image shares bits with.
    pub fn at(&self, address: Address, bits: u32) -> impl Iterator<Item = TerminalOfModule<'a>> {
        let end = address.bit_offset().saturating_add(bits);
        self.all().filter_map(move |(terminal, place)| {
            let is_shared = place.area() == address.area()
                && place.bit_offset() < end
                && address.bit_offset() < place.bit_offset() + place.bit_len();
            is_shared.then_some(terminal)
        })
    }

    /// All terminals with their places.
    pub fn all(&self) -> impl Iterator<Item = (TerminalOfModule<'a>, Address)> {
        self.modules().flat_map(|module| {
            ChannelKind::ALL.into_iter().flat_map(move |kind| {
                let channels = kind.of(&module.places).into_iter().flat_map(|all| all.iter()).enumerate();
                channels.map(move |(channel, place)| (TerminalOfModule { module, kind, channel }, place))
            })
        })
    }

    /// What helps where a name such as `M1.IW0` means nothing; `None` for names of another form.
    pub fn help(&self, name: &str) -> Option<String> {
        let (module, rest) = name.strip_prefix(['M', 'm'])?.split_once('.')?;
        let number: usize = module.parse().ok()?;
        let digits = rest.find(|letter: char| letter.is_ascii_digit())?;
        let (letters, channel) = rest.split_at(digits);
        let channel: usize = channel.parse().ok()?;
        let kind = ChannelKind::ALL.into_iter().find(|kind| kind.letters().eq_ignore_ascii_case(letters))?;
        let Some(module) = self.modules().find(|module| module.number == number) else {
            return Some(match self.modules.len() {
                0 => String::from(
                    "no module is configured: write `settings.modules`, as in modules = [\"TM3DI16\"]",
                ),
                1 => String::from("one module is configured: its terminals begin with M1"),
                count => format!("{count} modules are configured: their terminals begin with M1 to M{count}"),
            });
        };
        let terminal = TerminalOfModule { module, kind, channel };
        let count = kind.of(&module.places).map_or(0, |channels| channels.count() as usize);
        Some(match channel < count {
            true if !terminal.is_used() => terminal.how_to_use(),
            true => format!("describe the channel `{terminal}` in the board file"),
            false => match self.names(module) {
                none if none.is_empty() => format!("{} has no terminals", terminal.reference()),
                names => format!("{} has the terminals {names}", terminal.reference()),
            },
        })
    }

    /// The terminals of a module in words: `M1.I0 to M1.I7, M1.Q0 to M1.Q7`.
    fn names(&self, module: ListedModule<'a>) -> String {
        let of_kind = |kind: ChannelKind| {
            let last = kind.of(&module.places)?.count().checked_sub(1)? as usize;
            let [first, last] =
                [0, last].map(|channel| TerminalOfModule { module, kind, channel }.to_string());
            Some(if first == last { first } else { format!("{first} to {last}") })
        };
        ChannelKind::ALL.into_iter().filter_map(of_kind).collect::<Vec<_>>().join(", ")
    }

    /// What modules have in an image, each with its name: `%IW2..%IW5 and status %IB12..%IB15 of M1 (TM3AI4)`.
    pub fn in_image(&self, area: Area) -> Vec<String> {
        let of = |module: ListedModule<'a>| {
            let shown = |channels: Option<ChannelAddresses>| channels.map(|channels| channels.to_string());
            let places = &module.places;
            let parts = match area {
                Area::Input => [
                    shown(places.digital_inputs),
                    shown(places.analogue_inputs),
                    shown(places.status).map(|status| format!("status {status}")),
                ],
                Area::Output => [shown(places.digital_outputs), shown(places.analogue_outputs), None],
                Area::Memory => [None, None, None],
            };
            let parts: Vec<String> = parts.into_iter().flatten().collect();
            let reference = &module.configured.module.reference;
            (!parts.is_empty())
                .then(|| format!("{} of M{} ({reference})", parts.join(" and "), module.number))
        };
        self.modules().filter_map(of).collect()
    }

    /// The terminals whose status bytes a place of an image shares bits with.
    pub fn of_status_at(&self, address: Address, bits: u32) -> impl Iterator<Item = TerminalOfModule<'a>> {
        let end = address.bit_offset().saturating_add(bits);
        self.all().map(|(terminal, _)| terminal).filter(move |terminal| {
            terminal.status().is_some_and(|byte| {
                byte.area() == address.area()
                    && byte.bit_offset() < end
                    && address.bit_offset() < byte.bit_offset() + byte.bit_len()
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profile::AnalogueInputSettings;

    fn list() -> Vec<ConfiguredModule<'static>> {
        let of = |reference| ConfiguredModule::new(catalogue::find(reference).unwrap());
        let mut analogue = of("TM3AI4");
        let mode = analogue.module.analogue_inputs.as_ref().unwrap().mode("4..20 mA").unwrap();
        analogue.inputs = vec![Some(AnalogueInputSettings::new(mode))];
        vec![analogue, of("TM3DQ8T"), of("TM3XTRA1")]
    }

    #[test]
    fn a_name_that_means_nothing_says_what_to_write() {
        let list = list();
        let terminals = ModuleTerminals::new(Reference::find("TM241CEC24T").unwrap(), &list);
        let help = |name: &str| terminals.help(name).unwrap_or_default();
        assert!(
            help("M1.IW1").contains("{ type = \"TM3AI4\", inputs = [\"4..20 mA\", \"0..10 V\"] }"),
            "{}",
            help("M1.IW1")
        );
        assert!(help("m1.iw2").contains("[\"4..20 mA\", \"not used\", \"0..10 V\"]"), "{}", help("m1.iw2"));
        assert_eq!(help("M1.IW4"), "TM3AI4 has the terminals M1.IW0 to M1.IW3");
        assert_eq!(help("M2.QW0"), "TM3DQ8T has the terminals M2.Q0 to M2.Q7");
        assert_eq!(help("M3.I0"), "TM3XTRA1 has no terminals");
        assert_eq!(help("M4.I0"), "3 modules are configured: their terminals begin with M1 to M3");
        assert_eq!(help("M2.Q0"), "describe the channel `M2.Q0` in the board file");
        for name in
            ["MAIN.x", "M1.X0", "M1.I", "Mx.I0", "M1", "M99999999999999999999.I0", "M1.I99999999999999999999"]
        {
            assert_eq!(terminals.help(name), None, "{name}");
        }
        let none = ModuleTerminals::new(Reference::find("TM251MESC").unwrap(), &[]);
        assert!(none.help("M1.I0").unwrap().contains("write `settings.modules`"));
    }

    #[test]
    fn a_place_has_the_terminals_and_status_bytes_that_it_touches() {
        let list = list();
        let terminals = ModuleTerminals::new(Reference::find("TM241CEC24T").unwrap(), &list);
        let at = |place: &str| {
            let address = Address::parse(place).unwrap();
            terminals.at(address, address.bit_len()).map(|terminal| terminal.to_string()).collect::<Vec<_>>()
        };
        assert_eq!(at("%IW2"), ["M1.IW0"]);
        assert_eq!(at("%ID1"), ["M1.IW0", "M1.IW1"]);
        assert_eq!(at("%QX3.7"), ["M2.Q7"]);
        assert!(at("%QX4.0").is_empty() && at("%IX3.0").is_empty());
        let status = |place: &str| {
            let of = terminals.of_status_at(Address::parse(place).unwrap(), 8);
            of.map(|terminal| terminal.to_string()).collect::<Vec<_>>()
        };
        assert_eq!((status("%IB12"), status("%IB15")), (vec!["M1.IW0".into()], vec!["M1.IW3".into()]));
        assert!(status("%IB16").is_empty() && status("%QB12").is_empty());
        assert_eq!(terminals.in_image(Area::Input), ["%IW2..%IW5 and status %IB12..%IB15 of M1 (TM3AI4)"]);
        assert_eq!(terminals.in_image(Area::Output), ["%QX3.0..%QX3.7 of M2 (TM3DQ8T)"]);
    }
}
