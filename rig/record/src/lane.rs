//! Excerpts of signals, so that reports can draw without the trace.

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use signal::{Event, SignalInfo, Value, ValueKind, When};

/// The most points that one lane keeps; what comes after them is marked by [`Lane::truncated`].
pub const MAX_LANE_POINTS: usize = 2_000;

/// How a lane is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LaneKind {
    /// High, low, not driven, unknown.
    #[default]
    Digital,
    /// A number over time.
    Analog,
    /// Named or numbered values, one box each.
    State,
}

/// What a signal is from a point on. In JSON a number, `"z"` or `"x"`; a whole number beyond 53 bits is a text of its digits, for
/// readers whose numbers are floats.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LaneValue {
    /// A number: 0 and 1 in a digital lane. Never NaN or infinite in JSON: those are written as unknown.
    Number(f64),
    /// A whole number beyond 53 bits.
    Large(i128),
    /// Not driven.
    HighZ,
    /// Not known.
    Unknown,
}

/// From this magnitude on whole numbers are not all floats.
const LARGE: u128 = 1 << 53;

/// A change of a signal. In JSON `[instant, value]`, or `[earliest, latest, value]` where the instant is not known
/// exactly; in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LanePoint {
    /// `[earliest, latest]` of the change, nanoseconds of the trace.
    pub at: [i64; 2],
    /// What the signal is from then on.
    pub value: LaneValue,
}

/// A bounded excerpt of one signal.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Lane {
    /// Name of the signal.
    pub signal: String,
    /// How to draw it.
    pub kind: LaneKind,
    /// Unit of an analog lane; empty for none.
    pub unit: String,
    /// Names of a state lane's numbers.
    pub labels: Vec<(i64, String)>,
    /// Changes in the order of the trace, at most [`MAX_LANE_POINTS`]. The first one gives the value at the
    /// beginning of the excerpt.
    pub points: Vec<LanePoint>,
    /// The lane ends at its last point because there was no more room.
    pub truncated: bool,
    /// The excerpt ends at this instant, nanoseconds: nothing is said of the signal after it. Without it the
    /// last point's value holds to the end of the case.
    pub until_ns: Option<i64>,
}

impl Lane {
    /// An empty lane for a signal of a trace.
    pub fn of(info: &SignalInfo) -> Lane {
        let kind = match info.kind {
            ValueKind::Bool => LaneKind::Digital,
            ValueKind::Real => LaneKind::Analog,
            ValueKind::Int | ValueKind::Word | ValueKind::State | ValueKind::Mark => LaneKind::State,
        };
        Lane {
            signal: info.name.clone(),
            kind,
            unit: info.unit.clone(),
            labels: info.labels.clone(),
            points: Vec::new(),
            truncated: false,
            until_ns: None,
        }
    }

    /// The last instant that the lane covers, nanoseconds; nothing when it covers all to the case's end.
    pub fn known_until_ns(&self) -> Option<i64> {
        let cut = self.points.last().filter(|_| self.truncated).map(|point| point.at[1]);
        cut.into_iter().chain(self.until_ns).min()
    }

    /// Appends a change; false, and the lane marked as truncated, when there is no room.
    pub fn push(&mut self, at: When, value: Value) -> bool {
        if self.points.len() >= MAX_LANE_POINTS {
            self.truncated = true;
            return false;
        }
        let at = [at.earliest.as_nanos(), at.latest.as_nanos()];
        self.points.push(LanePoint { at, value: LaneValue::from(value) });
        true
    }

    /// Appends the change that an event of this signal is; as [`Lane::push`].
    pub fn push_event(&mut self, event: &Event) -> bool {
        self.push(event.at, event.value)
    }
}

impl From<Value> for LaneValue {
    fn from(value: Value) -> Self {
        match value {
            Value::HighZ => LaneValue::HighZ,
            Value::Unknown => LaneValue::Unknown,
            other if other.as_int().is_some_and(|whole| whole.unsigned_abs() > LARGE) => {
                other.as_int().map_or(LaneValue::Unknown, LaneValue::Large)
            }
            other => other.as_real().filter(|n| n.is_finite()).map_or(LaneValue::Unknown, LaneValue::Number),
        }
    }
}

impl Serialize for LaneValue {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            // Whole numbers without ".0" keep the many digital points short.
            LaneValue::Number(n) if n.fract() == 0.0 && n.abs() < 9e15 => serializer.serialize_i64(*n as i64),
            LaneValue::Number(n) if n.is_finite() => serializer.serialize_f64(*n),
            LaneValue::Large(n) => serializer.collect_str(n),
            LaneValue::HighZ => serializer.serialize_str("z"),
            LaneValue::Number(_) | LaneValue::Unknown => serializer.serialize_str("x"),
        }
    }
}

impl<'de> Deserialize<'de> for LaneValue {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Written {
            Number(f64),
            Word(String),
        }
        match Written::deserialize(deserializer)? {
            Written::Number(n) => Ok(LaneValue::Number(n)),
            Written::Word(word) if word == "z" => Ok(LaneValue::HighZ),
            Written::Word(word) if word == "x" => Ok(LaneValue::Unknown),
            Written::Word(word) => match word.parse() {
                Ok(whole) => Ok(LaneValue::Large(whole)),
                Err(_) => Err(de::Error::custom("expected a number, its digits, \"z\" or \"x\"")),
            },
        }
    }
}

impl Serialize for LanePoint {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let [earliest, latest] = self.at;
        // In virtual time every instant is exact, and points are most of a record.
        if earliest == latest {
            (earliest, self.value).serialize(serializer)
        } else {
            (earliest, latest, self.value).serialize(serializer)
        }
    }
}

impl<'de> Deserialize<'de> for LanePoint {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Written {
            Within(i64, i64, LaneValue),
            Exactly(i64, LaneValue),
        }
        Ok(match Written::deserialize(deserializer)? {
            Written::Within(earliest, latest, value) => LanePoint { at: [earliest, latest], value },
            Written::Exactly(at, value) => LanePoint { at: [at; 2], value },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use signal::Time;

    #[test]
    fn no_digit_of_a_large_number_is_lost() {
        for value in [Value::Int(i64::MIN), Value::Word(u64::MAX), Value::Int((1 << 53) + 1)] {
            let kept = LaneValue::from(value);
            let text = serde_json::to_string(&kept).unwrap();
            assert_eq!(text, format!("\"{}\"", value.as_int().unwrap()));
            assert_eq!(serde_json::from_str::<LaneValue>(&text).unwrap(), kept);
        }
        assert_eq!(LaneValue::from(Value::Int(1 << 53)), LaneValue::Number((1_u64 << 53) as f64));
    }

    #[test]
    fn a_lane_is_bounded() {
        let mut lane = Lane::of(&SignalInfo::exact("lamp", ValueKind::Bool));
        for n in 0..MAX_LANE_POINTS as i64 {
            assert!(lane.push(When::exactly(Time::from_nanos(n)), Value::Bool(n % 2 == 0)));
        }
        assert!(!lane.push(When::exactly(Time::from_nanos(9_999)), Value::HighZ));
        assert_eq!((lane.points.len(), lane.truncated), (MAX_LANE_POINTS, true));
    }
}
