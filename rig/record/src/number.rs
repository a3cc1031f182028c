//! Real numbers in JSON: finite ones as numbers, the others as the words `NaN`, `inf`, `-inf`.

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

/// A real number that survives JSON whatever it is.
#[derive(Clone, Copy)]
pub(crate) struct Real(pub f64);

impl Serialize for Real {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.0.is_finite() {
            serializer.serialize_f64(self.0)
        } else if self.0.is_nan() {
            serializer.serialize_str("NaN")
        } else if self.0 > 0.0 {
            serializer.serialize_str("inf")
        } else {
            serializer.serialize_str("-inf")
        }
    }
}

impl<'de> Deserialize<'de> for Real {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Written {
            Number(f64),
            Word(String),
        }
        match Written::deserialize(deserializer)? {
            Written::Number(n) => Ok(Real(n)),
            Written::Word(word) => match word.as_str() {
                "NaN" => Ok(Real(f64::NAN)),
                "inf" => Ok(Real(f64::INFINITY)),
                "-inf" => Ok(Real(f64::NEG_INFINITY)),
                _ => Err(de::Error::custom("expected a number, \"NaN\", \"inf\" or \"-inf\"")),
            },
        }
    }
}

/// `#[serde(with = "number::real")]`
pub(crate) mod real {
    use super::{Deserialize, Deserializer, Real, Serialize, Serializer};

    pub(crate) fn serialize<S: Serializer>(n: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        Real(*n).serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
        Ok(Real::deserialize(deserializer)?.0)
    }
}

/// `#[serde(with = "number::option")]`
pub(crate) mod option {
    use super::{Deserialize, Deserializer, Real, Serialize, Serializer};

    pub(crate) fn serialize<S: Serializer>(n: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
        n.map(Real).serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
        Ok(Option::<Real>::deserialize(deserializer)?.map(|n| n.0))
    }
}

/// `#[serde(with = "number::interval")]`
pub(crate) mod interval {
    use super::{Deserialize, Deserializer, Real, Serialize, Serializer};

    pub(crate) fn serialize<S: Serializer>(n: &Option<[f64; 2]>, serializer: S) -> Result<S::Ok, S::Error> {
        n.map(|[low, high]| [Real(low), Real(high)]).serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Option<[f64; 2]>, D::Error> {
        Ok(Option::<[Real; 2]>::deserialize(deserializer)?.map(|[low, high]| [low.0, high.0]))
    }
}
