//! The units that quantities are written in: one table for reading and writing.

/// What a quantity is a quantity of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Dimension {
    /// A plain number: a count, a factor.
    Number,
    /// s
    Time,
    /// Hz
    Frequency,
    /// V
    Voltage,
    /// A
    Current,
    /// Ohm
    Resistance,
    /// W
    Power,
    /// degC
    Temperature,
    /// %
    Ratio,
    /// rpm
    RotationalSpeed,
    /// m
    Length,
    /// Pa
    Pressure,
}

impl Dimension {
    /// Every dimension.
    pub const ALL: [Dimension; 12] = [
        Dimension::Number,
        Dimension::Time,
        Dimension::Frequency,
        Dimension::Voltage,
        Dimension::Current,
        Dimension::Resistance,
        Dimension::Power,
        Dimension::Temperature,
        Dimension::Ratio,
        Dimension::RotationalSpeed,
        Dimension::Length,
        Dimension::Pressure,
    ];

    /// The base unit; empty for plain numbers.
    pub const fn unit(self) -> &'static str {
        match self {
            Dimension::Number => "",
            Dimension::Time => "s",
            Dimension::Frequency => "Hz",
            Dimension::Voltage => "V",
            Dimension::Current => "A",
            Dimension::Resistance => "Ohm",
            Dimension::Power => "W",
            Dimension::Temperature => "degC",
            Dimension::Ratio => "%",
            Dimension::RotationalSpeed => "rpm",
            Dimension::Length => "m",
            Dimension::Pressure => "Pa",
        }
    }

    /// The dimension in the words of the user: `a voltage`.
    pub const fn name(self) -> &'static str {
        match self {
            Dimension::Number => "a plain number",
            Dimension::Time => "a duration",
            Dimension::Frequency => "a frequency",
            Dimension::Voltage => "a voltage",
            Dimension::Current => "a current",
            Dimension::Resistance => "a resistance",
            Dimension::Power => "a power",
            Dimension::Temperature => "a temperature",
            Dimension::Ratio => "a percentage",
            Dimension::RotationalSpeed => "a speed of rotation",
            Dimension::Length => "a length",
            Dimension::Pressure => "a pressure",
        }
    }
}

/// Billionths in one.
pub(super) const NANO: i128 = 1_000_000_000;

/// One spelling of one unit.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Unit {
    symbol: &'static str,
    /// Billionths of the base unit.
    nano: i128,
    dimension: Dimension,
    /// Whether quantities are written in it.
    written: bool,
}

const fn written(symbol: &'static str, nano: i128, dimension: Dimension) -> Unit {
    Unit { symbol, nano, dimension, written: true }
}

const fn read(symbol: &'static str, nano: i128, dimension: Dimension) -> Unit {
    Unit { symbol, nano, dimension, written: false }
}

/// Of one dimension the written units go from small to large. All written scales are powers of ten.
const UNITS: &[Unit] = {
    use Dimension as D;
    &[
        written("ns", 1, D::Time),
        written("us", 1_000, D::Time),
        read("µs", 1_000, D::Time),
        read("μs", 1_000, D::Time),
        written("ms", 1_000_000, D::Time),
        written("s", NANO, D::Time),
        read("min", 60 * NANO, D::Time),
        read("h", 3_600 * NANO, D::Time),
        read("d", 86_400 * NANO, D::Time),
        written("mHz", NANO / 1_000, D::Frequency),
        written("Hz", NANO, D::Frequency),
        written("kHz", 1_000 * NANO, D::Frequency),
        written("MHz", 1_000_000 * NANO, D::Frequency),
        written("uV", NANO / 1_000_000, D::Voltage),
        read("µV", NANO / 1_000_000, D::Voltage),
        read("μV", NANO / 1_000_000, D::Voltage),
        written("mV", NANO / 1_000, D::Voltage),
        written("V", NANO, D::Voltage),
        written("kV", 1_000 * NANO, D::Voltage),
        written("uA", NANO / 1_000_000, D::Current),
        read("µA", NANO / 1_000_000, D::Current),
        read("μA", NANO / 1_000_000, D::Current),
        written("mA", NANO / 1_000, D::Current),
        written("A", NANO, D::Current),
        written("Ohm", NANO, D::Resistance),
        read("Ω", NANO, D::Resistance),
        read("\u{2126}", NANO, D::Resistance),
        written("kOhm", 1_000 * NANO, D::Resistance),
        read("kΩ", 1_000 * NANO, D::Resistance),
        read("k\u{2126}", 1_000 * NANO, D::Resistance),
        written("MOhm", 1_000_000 * NANO, D::Resistance),
        written("mW", NANO / 1_000, D::Power),
        written("W", NANO, D::Power),
        written("kW", 1_000 * NANO, D::Power),
        written("degC", NANO, D::Temperature),
        read("°C", NANO, D::Temperature),
        read("ppm", NANO / 10_000, D::Ratio),
        written("%", NANO, D::Ratio),
        written("rpm", NANO, D::RotationalSpeed),
        written("um", NANO / 1_000_000, D::Length),
        read("µm", NANO / 1_000_000, D::Length),
        read("μm", NANO / 1_000_000, D::Length),
        written("mm", NANO / 1_000, D::Length),
        read("cm", NANO / 100, D::Length),
        written("m", NANO, D::Length),
        written("Pa", NANO, D::Pressure),
        written("kPa", 1_000 * NANO, D::Pressure),
        read("mbar", 100 * NANO, D::Pressure),
        read("bar", 100_000 * NANO, D::Pressure),
    ]
};

impl Unit {
    /// The unit of this spelling; else the only one that differs in nothing but capitals.
    pub(super) fn find(symbol: &str) -> Result<&'static Unit, Option<&'static Unit>> {
        if let Some(unit) = UNITS.iter().find(|unit| unit.symbol == symbol) {
            return Ok(unit);
        }
        let mut near = UNITS.iter().filter(|unit| unit.symbol.eq_ignore_ascii_case(symbol));
        match (near.next(), near.next()) {
            (Some(unit), None) => Err(Some(unit)),
            _ => Err(None),
        }
    }

    pub(super) const fn symbol(&self) -> &'static str {
        self.symbol
    }

    pub(super) const fn nano(&self) -> i128 {
        self.nano
    }

    pub(super) const fn dimension(&self) -> Dimension {
        self.dimension
    }
}

/// Scale and symbol of the largest written unit that is not larger than the magnitude; for less than one of
/// the smallest, and for 0, the smallest and the base unit.
pub(super) fn display_unit(magnitude: u128, dimension: Dimension) -> (u128, &'static str) {
    let mut best = (NANO as u128, dimension.unit());
    if magnitude == 0 {
        return best;
    }
    let mut found = false;
    for unit in UNITS.iter().filter(|unit| unit.written && unit.dimension == dimension) {
        if !found || unit.nano as u128 <= magnitude {
            best = (unit.nano as u128, unit.symbol);
            found = true;
        }
    }
    best
}
