//! The quantities of plants that have no channel to take their unit from.

use signal::{Quantity, Unit};

/// What a number of a plant measures; each is computed with in its own unit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// A plain number.
    Plain,
    /// In this unit, that of a channel: a number without a unit is in it, too.
    Of(String),
    /// A part, 1 for 100 %.
    Part,
    /// Seconds.
    Time,
    /// Metres.
    Length,
    /// Square metres.
    Area,
    /// Cubic metres.
    Volume,
    /// Cubic metres in a second.
    Flow,
    /// Metres in a second.
    Speed,
    /// Turns in a second.
    Rotation,
    /// A quantity of this unit in a second.
    Rate(String),
}

/// Volumes in cubic metres, as what they are a part of.
const VOLUMES: &[(&str, f64)] =
    &[("m3", 1.0), ("l", 1e3), ("L", 1e3), ("dl", 1e4), ("cl", 1e5), ("ml", 1e6), ("mL", 1e6)];
/// Areas in square metres, as what they are a part of.
const AREAS: &[(&str, f64)] = &[("m2", 1.0), ("dm2", 1e2), ("cm2", 1e4), ("mm2", 1e6)];
/// Rotations in turns in a second, as what they are a part of.
const ROTATIONS: &[(&str, f64)] = &[("1/s", 1.0), ("rpm", 60.0), ("1/min", 60.0)];

impl Dimension {
    /// The number of a quantity; `None` where the quantity is of another kind.
    pub fn number(&self, quantity: &Quantity) -> Option<f64> {
        let (number, unit) = (quantity.number.as_f64(), quantity.unit.to_string());
        let in_unit = |unit: &str| quantity.in_unit(&Unit::new(unit)).map(|number| number.as_f64());
        let of = |table: &[(&str, f64)]| {
            table.iter().find(|(name, _)| *name == unit).map(|(_, parts)| number / parts)
        };
        match self {
            Dimension::Plain => unit.is_empty().then_some(number),
            Dimension::Of(own) => {
                if unit.is_empty() {
                    Some(number)
                } else {
                    in_unit(own)
                }
            }
            Dimension::Part => in_unit("%").map(|percent| percent / 100.0),
            Dimension::Time => in_unit("s"),
            Dimension::Length => in_unit("m"),
            Dimension::Area => of(AREAS),
            Dimension::Volume => of(VOLUMES),
            Dimension::Rotation => of(ROTATIONS).or_else(|| in_unit("Hz")),
            Dimension::Flow => {
                let (volume, time) = unit.split_once('/')?;
                let (_, parts) = VOLUMES.iter().find(|(name, _)| *name == volume)?;
                Some(number / parts / seconds(time)?)
            }
            Dimension::Speed => {
                let (length, time) = unit.split_once('/')?;
                let length = Quantity { number: quantity.number, unit: Unit::new(length) };
                Some(length.in_unit(&Unit::new("m"))?.as_f64() / seconds(time)?)
            }
            Dimension::Rate(own) => {
                let (part, time) = unit.split_once('/').unwrap_or(("", &unit));
                let part = Quantity { number: quantity.number, unit: Unit::new(part) };
                Some(Dimension::Of(own.clone()).number(&part)? / seconds(time)?)
            }
        }
    }

    /// How much of it a channel has of which one unit is written `unit`; `None` where the unit is of another kind.
    pub fn of_unit(&self, unit: &str) -> Option<f64> {
        let one = Quantity { number: signal::Decimal::from(1_i128), unit: Unit::new(unit) };
        self.number(&one)
    }

    /// What to write where a number has to lie within these limits, as in `0 to 300 rpm`. [`f64::MIN_POSITIVE`] and [`f64::MAX`]
    /// stand for anything above 0 and for no limit.
    pub fn limits(&self, least: f64, most: f64) -> String {
        let (unit, parts) = match self {
            Dimension::Plain => (String::new(), 1.0),
            Dimension::Of(unit) => (unit.clone(), 1.0),
            Dimension::Part => ("%".into(), 100.0),
            Dimension::Time => ("s".into(), 1.0),
            Dimension::Length => ("m".into(), 1.0),
            Dimension::Area => ("m2".into(), 1.0),
            Dimension::Volume => ("m3".into(), 1.0),
            Dimension::Flow => ("m3/s".into(), 1.0),
            Dimension::Speed => ("m/s".into(), 1.0),
            Dimension::Rotation => ("rpm".into(), 60.0),
            Dimension::Rate(unit) => (format!("{unit}/s"), 1.0),
        };
        let (low, high) = (least * parts, most * parts);
        let numbers = match (least == f64::MIN_POSITIVE, most == f64::MAX) {
            (true, true) => "more than 0".into(),
            (true, false) => format!("more than 0 and at most {high}"),
            (false, true) => format!("at least {low}"),
            (false, false) => format!("{low} to {high}"),
        };
        format!("{numbers} {unit}").trim_end().to_owned()
    }

    /// What to write, as in `"2 l/min"`.
    pub fn example(&self) -> String {
        match self {
            Dimension::Plain => "a number without a unit, such as 1.5".into(),
            Dimension::Of(unit) if unit.is_empty() => "a number without a unit: its channel has none".into(),
            Dimension::Of(unit) => format!("a quantity such as \"2 {unit}\""),
            Dimension::Part => "a part such as \"50 %\"".into(),
            Dimension::Time => "a duration such as \"2 s\"".into(),
            Dimension::Length => "a length such as \"2 m\"".into(),
            Dimension::Area => "an area such as \"0.5 m2\" or \"80 cm2\"".into(),
            Dimension::Volume => "a volume such as \"20 l\" or \"0.5 m3\"".into(),
            Dimension::Flow => "a flow such as \"2 l/min\" or \"7.2 m3/h\"".into(),
            Dimension::Speed => "a speed such as \"0.5 m/s\"".into(),
            Dimension::Rotation => "a speed such as \"1500 rpm\"".into(),
            Dimension::Rate(unit) => format!("a rate such as \"2 {unit}/h\""),
        }
    }
}

/// The seconds of a unit of time.
fn seconds(unit: &str) -> Option<f64> {
    let one = Quantity { number: signal::Decimal::from(1_i128), unit: Unit::new(unit) };
    one.in_unit(&Unit::new("s")).map(|number| number.as_f64())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_named_in_the_unit_of_what_is_measured() {
        assert_eq!(Dimension::Rotation.limits(0.0, 5.0), "0 to 300 rpm");
        assert_eq!(Dimension::Rotation.limits(f64::MIN_POSITIVE, 5.0), "more than 0 and at most 300 rpm");
        assert_eq!(Dimension::Of("V".into()).limits(f64::MIN_POSITIVE, f64::MAX), "more than 0 V");
        assert_eq!(Dimension::Part.limits(0.0, 0.5), "0 to 50 %");
        assert_eq!(Dimension::Plain.limits(0.01, 1e3), "0.01 to 1000");
        assert_eq!(Dimension::Rate("m".into()).limits(-1.0, f64::MAX), "at least -1 m/s");
    }

    #[test]
    fn quantities_are_read_by_what_they_measure() {
        let number = |dimension: Dimension, text: &str| dimension.number(&Quantity::parse(text).unwrap());
        assert_eq!(number(Dimension::Flow, "6 l/min"), Some(0.0001));
        assert_eq!(number(Dimension::Flow, "3.6 m3/h"), Some(0.001));
        assert_eq!(number(Dimension::Flow, "6 l"), None);
        assert_eq!(number(Dimension::Flow, "6"), None);
        assert_eq!(number(Dimension::Volume, "20 l"), Some(0.02));
        assert_eq!(number(Dimension::Area, "50 cm2"), Some(0.005));
        assert_eq!(number(Dimension::Speed, "30 m/min"), Some(0.5));
        assert_eq!(number(Dimension::Speed, "500 mm/s"), Some(0.5));
        assert_eq!(number(Dimension::Rotation, "1500 rpm"), Some(25.0));
        assert_eq!(number(Dimension::Rotation, "25 Hz"), Some(25.0));
        assert_eq!(number(Dimension::Part, "50 %"), Some(0.5));
        assert_eq!(number(Dimension::Part, "0.5"), None);
        assert_eq!(number(Dimension::Length, "25 cm"), Some(0.25));
        assert_eq!(number(Dimension::Time, "2 min"), Some(120.0));
        assert_eq!(number(Dimension::Of("mA".into()), "0.004 A"), Some(4.0));
        assert_eq!(number(Dimension::Of("mA".into()), "4"), Some(4.0));
        assert_eq!(number(Dimension::Of("mA".into()), "4 V"), None);
        assert_eq!(number(Dimension::Rate("degC".into()), "36 degC/h"), Some(0.01));
        let rate = number(Dimension::Rate("m".into()), "36 mm/h").unwrap();
        assert!((rate - 1e-5).abs() < 1e-18, "{rate}");
        assert_eq!(number(Dimension::Plain, "2"), Some(2.0));
        assert_eq!(number(Dimension::Plain, "2 m"), None);
        assert_eq!(Dimension::Flow.of_unit("l/min"), Some(1.0 / 1e3 / 60.0));
        assert_eq!(Dimension::Flow.of_unit("%"), None);
    }
}
