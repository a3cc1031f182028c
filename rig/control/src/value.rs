//! A value as it stands in a line.

use serde::de::{self, Deserializer, MapAccess, Visitor};
use serde::ser::{SerializeMap, Serializer};
use serde::{Deserialize, Serialize};
use signal::Value;
use std::fmt;

/// What stands for a line that nobody drives.
const HIGH_Z: &str = "high-z";

/// A value in a line: `true`, `12`, `0.5`, `"high-z"`, `null` for one that is not known, and `{"value": 0.5,
/// "uncertainty": 0.01}` for one that was measured. Real numbers that JSON cannot write are `"nan"`, `"inf"`, `"-inf"`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WireValue(pub Value);

impl Serialize for WireValue {
    fn serialize<S: Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            Value::Bool(on) => out.serialize_bool(on),
            Value::Int(number) => out.serialize_i64(number),
            Value::Word(word) => out.serialize_u64(word),
            Value::Real(number) if number.is_nan() => out.serialize_str("nan"),
            Value::Real(number) if number.is_infinite() => {
                out.serialize_str(if number > 0.0 { "inf" } else { "-inf" })
            }
            Value::Real(number) => out.serialize_f64(number),
            Value::Measured(number, uncertainty) => {
                let mut map = out.serialize_map(Some(2))?;
                map.serialize_entry("value", &WireValue(Value::Real(number)))?;
                if uncertainty.is_finite() {
                    map.serialize_entry("uncertainty", &uncertainty)?;
                } else {
                    map.serialize_entry("uncertainty", &WireValue(Value::Real(uncertainty.into())))?;
                }
                map.end()
            }
            Value::HighZ => out.serialize_str(HIGH_Z),
            Value::Unknown => out.serialize_unit(),
        }
    }
}

impl<'de> Deserialize<'de> for WireValue {
    fn deserialize<D: Deserializer<'de>>(input: D) -> Result<WireValue, D::Error> {
        input.deserialize_any(Reader).map(WireValue)
    }
}

struct Reader;

impl<'de> Visitor<'de> for Reader {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a Boolean, a number, \"high-z\", or null")
    }

    fn visit_bool<E>(self, on: bool) -> Result<Value, E> {
        Ok(Value::Bool(on))
    }

    fn visit_i64<E>(self, number: i64) -> Result<Value, E> {
        Ok(Value::Int(number))
    }

    fn visit_u64<E>(self, number: u64) -> Result<Value, E> {
        Ok(i64::try_from(number).map_or(Value::Word(number), Value::Int))
    }

    fn visit_f64<E>(self, number: f64) -> Result<Value, E> {
        Ok(Value::Real(number))
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Unknown)
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<Value, E> {
        match text {
            HIGH_Z => Ok(Value::HighZ),
            "nan" => Ok(Value::Real(f64::NAN)),
            "inf" => Ok(Value::Real(f64::INFINITY)),
            "-inf" => Ok(Value::Real(f64::NEG_INFINITY)),
            _ => Err(E::invalid_value(de::Unexpected::Str(text), &self)),
        }
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Value, A::Error> {
        let (mut value, mut uncertainty) = (None, None);
        while let Some(key) = map.next_key::<String>()? {
            match key.as_str() {
                "value" => value = map.next_value::<WireValue>()?.0.as_real(),
                "uncertainty" => uncertainty = map.next_value::<WireValue>()?.0.as_real(),
                _ => return Err(de::Error::unknown_field(&key, &["value", "uncertainty"])),
            }
        }
        match (value, uncertainty) {
            (Some(value), Some(uncertainty)) => Ok(Value::Measured(value, uncertainty as f32)),
            _ => Err(de::Error::missing_field("value and uncertainty")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_comes_back() {
        for (value, line) in [
            (Value::Bool(true), "true"),
            (Value::Int(-3), "-3"),
            (Value::Word(u64::MAX), "18446744073709551615"),
            (Value::Real(0.5), "0.5"),
            (Value::Real(f64::NEG_INFINITY), "\"-inf\""),
            (Value::Measured(0.5, 0.01), "{\"value\":0.5,\"uncertainty\":0.01}"),
            (Value::Measured(f64::INFINITY, f32::INFINITY), "{\"value\":\"inf\",\"uncertainty\":\"inf\"}"),
            (Value::HighZ, "\"high-z\""),
            (Value::Unknown, "null"),
        ] {
            assert_eq!(serde_json::to_string(&WireValue(value)).expect("a line"), line);
            assert_eq!(serde_json::from_str::<WireValue>(line).expect(line), WireValue(value));
        }
        // More than the uncertainty can be is no less than that.
        let much = "{\"value\": 1, \"uncertainty\": 1e85}";
        let read = serde_json::from_str::<WireValue>(much).expect(much);
        assert_eq!(read, WireValue(Value::Measured(1.0, f32::INFINITY)));
    }
}
