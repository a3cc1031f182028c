//! `settings.expert`: the controller's fast counters and pulse generators (io: sections 6, 7 and 17).
//!
//! What a function is and which of its parameters go together is the model's to say. Here its keys are read: one table
//! has them, with the kinds of functions that know each.

use std::ops::Range;

use document::{Data, Fields, Findings, KeySpec, KeyType, Node, Table};
use signal::{Area, Quantity, Span, Unit};

use crate::codes;
use crate::lang::terminal;

/// What an expert function is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FunctionType {
    /// HSC Simple.
    Simple,
    /// HSC Main with one phase.
    MainSingle,
    /// HSC Main with two phases.
    MainDual,
    /// A frequency meter.
    FrequencyMeter,
    /// A period meter.
    PeriodMeter,
    /// A pulse train output with its axis.
    Pto,
    /// Pulse width modulation.
    Pwm,
    /// A frequency generator.
    FreqGen,
}

/// The types as they are written, in the order of [`FunctionType`].
const TYPES: &[&str] =
    &["simple", "main-single", "main-dual", "frequency-meter", "period-meter", "pto", "pwm", "freq-gen"];

impl FunctionType {
    const ALL: [FunctionType; 8] = [
        FunctionType::Simple,
        FunctionType::MainSingle,
        FunctionType::MainDual,
        FunctionType::FrequencyMeter,
        FunctionType::PeriodMeter,
        FunctionType::Pto,
        FunctionType::Pwm,
        FunctionType::FreqGen,
    ];

    const fn bit(self) -> u16 {
        1 << self as u16
    }
}

const SIMPLE: u16 = FunctionType::Simple.bit();
const SINGLE: u16 = FunctionType::MainSingle.bit();
const DUAL: u16 = FunctionType::MainDual.bit();
const FREQUENCY: u16 = FunctionType::FrequencyMeter.bit();
const PERIOD: u16 = FunctionType::PeriodMeter.bit();
const PTO: u16 = FunctionType::Pto.bit();
const WAVES: u16 = FunctionType::Pwm.bit() | FunctionType::FreqGen.bit();
const COUNTERS: u16 = SIMPLE | SINGLE | DUAL;
const MAIN: u16 = SINGLE | DUAL;
const METERS: u16 = FREQUENCY | PERIOD;
const COMPARING: u16 = MAIN | METERS;

/// What a key takes, besides what its type says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Takes {
    /// Nothing more.
    Plain,
    /// The address of an input.
    Input,
    /// The address of an output.
    Output,
    /// An input for a counter, an output for a generator.
    Terminal,
    /// A whole number of hertz.
    Hertz,
}

const EDGES: KeyType = KeyType::Choice(&["rising", "falling", "both"]);
const DINT: KeyType = KeyType::Integer(i32::MIN as i64, i32::MAX as i64);
const COUNT: KeyType = KeyType::Integer(0, u32::MAX as i64);
const EVENT: KeyType =
    KeyType::Choice(&["none", "upwards", "downwards", "both", "below", "above", "between"]);
const ZONE: KeyType = KeyType::Integer(0, 4);
const ACTIVE_LOW: KeyType =
    KeyType::Choice(&["ref", "index", "probe", "limit-positive", "limit-negative", "drive-ready"]);

macro_rules! functions {
    ($(($name:literal, $ty:expr, $takes:ident, $kinds:expr, $doc:literal)),* $(,)?) => {
        /// The keys of a function.
        pub(super) const FUNCTION_KEYS: &[KeySpec] = &[
            KeySpec::required("kind", KeyType::Choice(TYPES), "What the function is."),
            $(KeySpec::optional($name, $ty, $doc)),*
        ];

        /// What each key takes and which kinds of functions know it.
        const MEANINGS: &[(&str, Takes, u16)] = &[$(($name, Takes::$takes, $kinds)),*];
    };
}

functions![
    ("a", KeyType::Text, Terminal, !0, "The input of the pulses, or the output of a generator."),
    ("b", KeyType::Text, Terminal, DUAL | PTO, "The input of the second phase, or the output B of a PTO."),
    (
        "inputs",
        KeyType::Choice(&[
            "up-down",
            "pulse-direction",
            "quadrature-x1",
            "quadrature-x2",
            "quadrature-x4",
            "reverse-x1",
            "reverse-x2",
            "reverse-x4",
        ]),
        Plain,
        DUAL,
        "How two phases count; `up-down` if left out."
    ),
    (
        "mode",
        KeyType::Choice(&["one-shot", "modulo-loop", "free-large", "event-counting"]),
        Plain,
        COUNTERS,
        "What a counter does with its pulses."
    ),
    ("preset", DINT, Plain, COUNTERS, "The value that a preset loads: `one-shot`, `free-large`."),
    ("modulo", DINT, Plain, COUNTERS, "The number of values of `modulo-loop`."),
    (
        "limits",
        KeyType::Choice(&["lock", "rollover"]),
        Plain,
        DUAL,
        "What `free-large` does at its ends; `lock` if left out."
    ),
    ("window", KeyType::Duration, Plain, SINGLE | FREQUENCY, "The window in which pulses are counted."),
    (
        "measures",
        KeyType::Choice(&["period", "pulse-width"]),
        Plain,
        PERIOD,
        "What a period meter measures; `period` if left out."
    ),
    ("resolution", KeyType::Duration, Plain, PERIOD, "The unit of a period meter: 0.1, 1, 100 or 1000 us."),
    (
        "timeout",
        KeyType::Duration,
        Plain,
        PERIOD,
        "Without an edge for so long a period is not valid; never if left out."
    ),
    ("expected", KeyType::Quantity, Hertz, COUNTERS | METERS, "The highest frequency that it has to count."),
    ("enable", KeyType::Text, Input, COMPARING | WAVES, "The input EN."),
    ("sync", KeyType::Text, Input, MAIN | WAVES, "The input SYNC."),
    ("sync-edges", EDGES, Plain, MAIN | WAVES, "The edges of SYNC that count; `rising` if left out."),
    (
        "sync-while-enable",
        KeyType::Bool,
        Plain,
        MAIN,
        "The level of EN at which SYNC counts; any if left out."
    ),
    ("capture", KeyType::Text, Input, MAIN, "The input CAP, CAP0."),
    ("capture-edges", EDGES, Plain, MAIN, "The edges of CAP0 that count; `rising` if left out."),
    ("capture1", KeyType::Text, Input, MAIN, "The input CAP1."),
    ("capture1-edges", EDGES, Plain, MAIN, "The edges of CAP1 that count; `rising` if left out."),
    ("thresholds", KeyType::List(&DINT), Plain, COMPARING, "Up to four thresholds, in order."),
    (
        "threshold-events",
        KeyType::List(&EVENT),
        Plain,
        COMPARING,
        "When each threshold raises its event; never if left out."
    ),
    ("reflex0", KeyType::Text, Output, COMPARING, "The output of reflex 0."),
    (
        "reflex0-zones",
        KeyType::List(&ZONE),
        Plain,
        COMPARING,
        "The zones in which reflex 0 is on: so many thresholds are reached."
    ),
    ("reflex1", KeyType::Text, Output, COMPARING, "The output of reflex 1."),
    ("reflex1-zones", KeyType::List(&ZONE), Plain, COMPARING, "The zones in which reflex 1 is on."),
    (
        "output",
        KeyType::Choice(&["pulse-direction", "clockwise", "pulse", "quadrature"]),
        Plain,
        PTO,
        "What A and B of a PTO say; `pulse-direction` if left out."
    ),
    ("drive-enable", KeyType::Text, Output, PTO, "The output that enables the drive."),
    ("ref", KeyType::Text, Input, PTO, "The input of the switch of homing."),
    ("index", KeyType::Text, Input, PTO, "The input of the zero mark of homing."),
    ("probe", KeyType::Text, Input, PTO, "The input that captures positions and starts moves."),
    ("limit-positive", KeyType::Text, Input, PTO, "The input of the limit switch for larger positions."),
    ("limit-negative", KeyType::Text, Input, PTO, "The input of the limit switch for smaller positions."),
    ("drive-ready", KeyType::Text, Input, PTO, "The input that says that the drive is ready."),
    ("active-low", KeyType::List(&ACTIVE_LOW), Plain, PTO, "Inputs of the axis that act with their 0."),
    ("start-velocity", KeyType::Quantity, Hertz, PTO, "Velocity at which motions begin."),
    ("stop-velocity", KeyType::Quantity, Hertz, PTO, "Velocity at which motions end."),
    ("max-velocity", KeyType::Quantity, Hertz, PTO, "Highest velocity."),
    (
        "ramp-unit",
        KeyType::Choice(&["Hz/ms", "ms"]),
        Plain,
        PTO,
        "Unit of all accelerations; `Hz/ms` if left out."
    ),
    ("max-acceleration", COUNT, Plain, PTO, "Highest acceleration."),
    ("max-deceleration", COUNT, Plain, PTO, "Highest deceleration."),
    ("fast-stop", COUNT, Plain, PTO, "Deceleration after errors of the axis."),
    ("jerk-ratio", KeyType::Integer(0, 100), Plain, PTO, "Part of a ramp that is curved, in percent."),
    ("software-limits", KeyType::List(&DINT), Plain, PTO, "The smallest and the largest position."),
    ("backlash", COUNT, Plain, PTO, "Pulses that a change of direction needs in a quadrature."),
    ("direction-delay", KeyType::Duration, Plain, PTO, "From a change of direction to the next pulse."),
    ("direction-inverted", KeyType::Bool, Plain, PTO, "Whether B is 0 for larger positions."),
];

const FUNCTION_TYPE: KeyType = KeyType::Table(FUNCTION_KEYS);

/// The type of `expert`.
pub(super) const EXPERT_TYPE: KeyType = KeyType::Map(&FUNCTION_TYPE);

/// What a key of a function says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FunctionValue {
    /// n for In or Qn.
    Terminal(u8),
    /// A number, or a frequency in hertz.
    Number(i64),
    /// A duration.
    Time(Span),
    /// A Boolean.
    Flag(bool),
    /// A word.
    Word(String),
    /// Numbers.
    Numbers(Vec<i64>),
    /// Words.
    Words(Vec<String>),
}

/// An expert function, as a plan has it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FunctionSettings {
    /// Its name.
    pub name: String,
    /// Bytes of the name in the plan.
    pub name_span: Range<usize>,
    /// What it is.
    pub kind: FunctionType,
    /// Its keys, without `kind`, with the bytes of their values.
    values: Vec<(String, FunctionValue, Range<usize>)>,
    /// Bytes of its table.
    pub span: Range<usize>,
}

impl FunctionSettings {
    /// What a key says.
    pub fn get(&self, key: &str) -> Option<&FunctionValue> {
        self.values.iter().find(|(known, ..)| known == key).map(|(_, value, _)| value)
    }

    /// The bytes of a key's value, or of the whole function where it is left out.
    pub fn place(&self, key: &str) -> Range<usize> {
        let found = self.values.iter().find(|(known, ..)| known == key);
        found.map_or_else(|| self.span.clone(), |(_, _, span)| span.clone())
    }

    /// An input or output: n for In or Qn.
    pub fn terminal(&self, key: &str) -> Option<u8> {
        if let Some(FunctionValue::Terminal(n)) = self.get(key) { Some(*n) } else { None }
    }

    /// A number, or a frequency in hertz.
    pub fn number(&self, key: &str) -> Option<i64> {
        if let Some(FunctionValue::Number(number)) = self.get(key) { Some(*number) } else { None }
    }

    /// A duration.
    pub fn time(&self, key: &str) -> Option<Span> {
        if let Some(FunctionValue::Time(span)) = self.get(key) { Some(*span) } else { None }
    }

    /// A Boolean.
    pub fn flag(&self, key: &str) -> Option<bool> {
        if let Some(FunctionValue::Flag(on)) = self.get(key) { Some(*on) } else { None }
    }

    /// A word.
    pub fn word(&self, key: &str) -> Option<&str> {
        if let Some(FunctionValue::Word(word)) = self.get(key) { Some(word) } else { None }
    }

    /// Numbers; none where the key is left out.
    pub fn numbers(&self, key: &str) -> &[i64] {
        if let Some(FunctionValue::Numbers(numbers)) = self.get(key) { numbers } else { &[] }
    }

    /// Words; none where the key is left out.
    pub fn words(&self, key: &str) -> &[String] {
        if let Some(FunctionValue::Words(words)) = self.get(key) { words } else { &[] }
    }
}

impl FunctionSettings {
    /// What a plan says of it, key by key with values as TOML has them.
    pub fn written(&self) -> impl Iterator<Item = (&str, String)> {
        let kind = TYPES.get(self.kind as usize).map(|kind| ("kind", format!("{kind:?}")));
        let of = |(key, value, _): &'_ (String, FunctionValue, Range<usize>)| -> String {
            match value {
                FunctionValue::Terminal(n) => {
                    let takes = MEANINGS.iter().find(|(name, ..)| name == key).map(|(_, takes, _)| *takes);
                    let area = match takes.map(|takes| self.area(takes)) {
                        Some(Area::Output) => 'Q',
                        _ => 'I',
                    };
                    format!("\"%{area}X{}.{}\"", n / 8, n % 8)
                }
                FunctionValue::Number(number) => number.to_string(),
                FunctionValue::Time(span) => format!("\"{span}\""),
                FunctionValue::Flag(on) => on.to_string(),
                FunctionValue::Word(word) => format!("{word:?}"),
                FunctionValue::Numbers(numbers) => format!("{numbers:?}"),
                FunctionValue::Words(words) => format!("{words:?}"),
            }
        };
        kind.into_iter().chain(self.values.iter().map(move |value| (value.0.as_str(), of(value))))
    }

    /// Where the terminals of a key lie.
    const fn area(&self, takes: Takes) -> Area {
        match takes {
            Takes::Output => Area::Output,
            Takes::Terminal if self.kind.bit() & (PTO | WAVES) != 0 => Area::Output,
            _ => Area::Input,
        }
    }
}

/// Reads `expert`, which was held against its keys.
pub(super) fn read(fields: &Fields<'_>, out: &mut Findings) -> Vec<FunctionSettings> {
    let mut functions: Vec<FunctionSettings> = Vec::new();
    let Some(table) = fields.get("expert").and_then(Node::as_table) else { return functions };
    for entry in &table.entries {
        let Some(own) = entry.node.as_table() else { continue };
        if functions.iter().any(|known| known.name.eq_ignore_ascii_case(&entry.key)) {
            let message = format!("the function `{}` is given twice", entry.key);
            let help = "names differ not only in capitals";
            out.error(codes::NAME_TWICE, entry.key_span.clone(), message, help);
            continue;
        }
        let kind = Fields::checked(own, FUNCTION_KEYS).text("kind");
        let place = kind.and_then(|kind| TYPES.iter().position(|known| *known == kind));
        let Some(kind) = place.and_then(|place| FunctionType::ALL.get(place)) else { continue };
        functions.push(FunctionSettings {
            name: entry.key.clone(),
            name_span: entry.key_span.clone(),
            kind: *kind,
            values: values(*kind, own, out),
            span: entry.node.span.clone(),
        });
    }
    functions
}

fn values(
    kind: FunctionType,
    table: &Table,
    out: &mut Findings,
) -> Vec<(String, FunctionValue, Range<usize>)> {
    let mut values = Vec::new();
    for entry in &table.entries {
        let Some((_, takes, kinds)) = MEANINGS.iter().find(|(name, ..)| *name == entry.key) else { continue };
        if kinds & kind.bit() == 0 {
            let word = TYPES.get(kind as usize).copied().unwrap_or_default();
            let message = format!("`{}` does not apply to `{word}`", entry.key);
            let known = MEANINGS.iter().filter(|(_, _, kinds)| kinds & kind.bit() != 0);
            let known: Vec<&str> = known.map(|(name, ..)| *name).collect();
            let help = format!("its keys are {}", known.join(", "));
            out.error(codes::FUNCTION_KEY, entry.key_span.clone(), message, help);
            continue;
        }
        if let Some(value) = value(kind, *takes, &entry.node, out) {
            values.push((entry.key.clone(), value, entry.node.span.clone()));
        }
    }
    values
}

fn value(kind: FunctionType, takes: Takes, node: &Node, out: &mut Findings) -> Option<FunctionValue> {
    let area = match takes {
        Takes::Hertz => return hertz(node, out).map(FunctionValue::Number),
        Takes::Plain => return plain(node),
        Takes::Input => Area::Input,
        Takes::Output => Area::Output,
        Takes::Terminal if kind.bit() & (PTO | WAVES) != 0 => Area::Output,
        Takes::Terminal => Area::Input,
    };
    let address = terminal(node, node.as_text()?, area, out)?;
    // Beyond what any controller has, which its check says.
    Some(FunctionValue::Terminal(u8::try_from(address.bit_offset()).unwrap_or(u8::MAX)))
}

fn plain(node: &Node) -> Option<FunctionValue> {
    Some(match &node.data {
        Data::Integer(number) => FunctionValue::Number(*number),
        Data::Bool(on) => FunctionValue::Flag(*on),
        Data::Text(text) => match Span::parse(text) {
            Ok(span) => FunctionValue::Time(span),
            Err(_) => FunctionValue::Word(text.clone()),
        },
        Data::Array(list) if list.iter().all(|node| node.as_text().is_some()) && !list.is_empty() => {
            FunctionValue::Words(list.iter().filter_map(Node::as_text).map(str::to_owned).collect())
        }
        Data::Array(list) => FunctionValue::Numbers(
            list.iter()
                .filter_map(|node| if let Data::Integer(number) = node.data { Some(number) } else { None })
                .collect(),
        ),
        _ => return None,
    })
}

/// A frequency in whole hertz.
fn hertz(node: &Node, out: &mut Findings) -> Option<i64> {
    let frequency = match &node.data {
        Data::Integer(number) => return Some(*number).filter(|number| u32::try_from(*number).is_ok()),
        _ => node.as_text().and_then(|text| Quantity::parse(text).ok()),
    };
    let whole = frequency.and_then(|it| it.in_unit(&Unit::new("Hz"))?.as_whole());
    let hertz = whole.and_then(|whole| u32::try_from(whole).ok());
    if hertz.is_none() {
        out.bad(codes::UNIT, node, "not a frequency in whole hertz", "write it as in \"100 kHz\"");
    }
    hertz.map(i64::from)
}
