//! What a bench says of claims before anything moves: which values its signals can have, and how exactly they are
//! known there.

use signal::{Policy, Sampling, SignalInfo, Span, Value, ValueKind};

use crate::expect::{ClaimDemand, TraceClaim};
use crate::monitor::{Number, ValueTest, distance, slack};

/// The values that a signal of whole numbers can have. FALSE is 0, TRUE is 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SignalBounds {
    /// The least.
    pub least: i128,
    /// The greatest.
    pub most: i128,
    /// It is a line, which nobody may drive.
    pub line: bool,
}

impl SignalBounds {
    /// From the least to the greatest, both included.
    pub const fn new(least: i128, most: i128) -> SignalBounds {
        SignalBounds { least, most, line: false }
    }

    /// A bit.
    pub const BIT: SignalBounds = SignalBounds::new(0, 1);

    /// A line that carries a level.
    pub const LINE: SignalBounds = SignalBounds { least: 0, most: 1, line: true };

    /// A number of so many bits without a sign.
    pub const fn bits(bits: u32) -> SignalBounds {
        SignalBounds::new(0, if bits >= 127 { i128::MAX } else { (1 << bits) - 1 })
    }

    /// A count.
    pub const COUNT: SignalBounds = SignalBounds::new(0, i64::MAX as i128);
}

/// Why a claim says nothing on a bench, one sentence each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Doubt {
    /// It can never be met.
    Never(String),
    /// It can never fail.
    Always(String),
    /// The signals are not known exactly enough for a pass.
    Blind(String),
}

/// What is wrong with a claim on a bench with these signals. `bounds` says which values one can have, where that is
/// known.
pub fn doubt(
    claim: &dyn TraceClaim,
    signals: &[SignalInfo],
    bounds: &dyn Fn(&str) -> Option<SignalBounds>,
) -> Option<Doubt> {
    let demands = claim.demands();
    let find = |name: &str| signals.iter().find(|info| info.name == name);
    let enters =
        |name: &str| demands.iter().any(|one| matches!(one, ClaimDemand::Change(signal) if *signal == name));
    let wants = |name: &str| {
        demands.iter().any(|one| matches!(one, ClaimDemand::Value { signal, .. } if *signal == name))
    };
    demands.iter().find_map(|demand| match demand {
        ClaimDemand::Value { signal, condition, forbidden } => {
            let info = find(signal)?;
            let test = condition.bind(info).ok()?;
            let possible = bounds(signal).and_then(|bounds| {
                let (some, all) = reach(&test, &bounds);
                let has = format!("`{signal}` is {}", shown(&bounds, info));
                match (some, all, forbidden) {
                    (false, _, false) => Some(Doubt::Never(format!("{has} and never {condition}"))),
                    (false, _, true) => Some(Doubt::Always(format!("{has} and never {condition}"))),
                    (_, true, true) => Some(Doubt::Never(format!("{has}, always {condition}"))),
                    (_, true, false) if enters(signal) => {
                        Some(Doubt::Never(format!("{has}, always {condition}: it never comes to be so")))
                    }
                    (_, true, false) => Some(Doubt::Always(format!("{has}, always {condition}"))),
                    _ => None,
                }
            });
            if possible.is_some() {
                return possible;
            }
            (!forbidden && is_too_narrow(&test, slack(info))).then(|| {
                Doubt::Blind(format!(
                    "`{signal}` is recorded to within {}, too coarsely for {condition}",
                    slack(info)
                ))
            })
        }
        ClaimDemand::Change(signal) => {
            let info = find(signal)?;
            let coarse = matches!(info.policy, Policy::Deadband(_)) && !wants(signal);
            coarse.then(|| {
                Doubt::Blind(format!(
                    "`{signal}` is recorded with a deadband: whether it changes is not known"
                ))
            })
        }
        ClaimDemand::Delay { limits, signal, .. } => {
            let known = match find(signal)?.sampling {
                Sampling::Edges { resolution } => resolution,
                Sampling::Sampled { period } => period,
            };
            let apart = Span::from_nanos(limits.1.saturating_sub(limits.0.max(0)));
            (apart < known).then(|| {
                Doubt::Blind(format!(
                    "`{signal}` is known to within {known}, and the limits lie {apart} apart"
                ))
            })
        }
        ClaimDemand::Window { .. } | ClaimDemand::At(_) | ClaimDemand::Differ(..) => None,
    })
}

/// Whether a claim is the same for all of these values of a signal: whether it matters to it which of them it has.
pub fn is_same_for(claim: &dyn TraceClaim, info: &SignalInfo, values: &[Value]) -> bool {
    if !claim.signals().contains(&info.name) {
        return true;
    }
    let mut conditions = 0;
    for demand in claim.demands() {
        let ClaimDemand::Value { signal, condition, .. } = demand else { continue };
        if signal != info.name {
            continue;
        }
        conditions += 1;
        let Ok(test) = condition.bind(info) else { return false };
        let mut truths = values.iter().map(|value| test.holds(*value, 0.0));
        let first = truths.next();
        if truths.any(|truth| Some(truth) != first) {
            return false;
        }
    }
    // One that looks at the signal in another way is not known to be.
    conditions > 0
}

/// Whether some value meets the test, and whether all do.
fn reach(test: &ValueTest, bounds: &SignalBounds) -> (bool, bool) {
    match test {
        ValueTest::Not(inner) => {
            let (some, all) = reach(inner, bounds);
            (!all, !some)
        }
        ValueTest::HighZ => (bounds.line, false),
        ValueTest::OneOf(wanted) => {
            let whole = |number: &Number| Some(number.floor()).filter(|floor| *floor == number.ceil());
            let mut met: Vec<i128> = wanted.iter().filter_map(whole).collect();
            met.retain(|number| (bounds.least..=bounds.most).contains(number));
            met.sort_unstable();
            met.dedup();
            let count = bounds.most.saturating_sub(bounds.least).saturating_add(1);
            (!met.is_empty(), !bounds.line && i128::try_from(met.len()).is_ok_and(|met| met == count))
        }
        ValueTest::Range { min, max } => {
            let least = min.map_or(bounds.least, |min| min.ceil().max(bounds.least));
            let most = max.map_or(bounds.most, |max| max.floor().min(bounds.most));
            (least <= most, !bounds.line && (least, most) == (bounds.least, bounds.most))
        }
    }
}

/// Whether a value that is known to within `slack` can never be seen to meet the test.
fn is_too_narrow(test: &ValueTest, slack: f64) -> bool {
    slack > 0.0
        && match test {
            ValueTest::OneOf(_) => true,
            ValueTest::Range { min: Some(min), max: Some(max) } => distance(*min, *max) < 2.0 * slack,
            ValueTest::Range { .. } | ValueTest::HighZ | ValueTest::Not(_) => false,
        }
}

/// The values in words.
fn shown(bounds: &SignalBounds, info: &SignalInfo) -> String {
    match (info.kind, bounds.most) {
        (ValueKind::Bool, _) => String::from("TRUE or FALSE"),
        (_, most) if most >= i128::from(i64::MAX) => format!("at least {}", bounds.least),
        (_, most) => format!("{} .. {most}", bounds.least),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_that_a_signal_can_have_meet_a_test_or_not() {
        let range = |min: Option<f64>, max: Option<f64>| ValueTest::Range {
            min: min.map(Number::Real),
            max: max.map(Number::Real),
        };
        let one_of = |list: &[i128]| ValueTest::OneOf(list.iter().map(|one| Number::Int(*one)).collect());
        let byte = SignalBounds::bits(8);
        assert_eq!(reach(&one_of(&[256]), &byte), (false, false));
        assert_eq!(reach(&one_of(&[255, 255]), &byte), (true, false));
        assert_eq!(reach(&range(Some(0.0), None), &byte), (true, true));
        assert_eq!(reach(&range(Some(-5.0), Some(255.5)), &byte), (true, true));
        assert_eq!(reach(&range(Some(0.5), None), &byte), (true, false));
        assert_eq!(reach(&range(Some(254.2), Some(254.8)), &byte), (false, false));
        assert_eq!(reach(&one_of(&[0, 1]), &SignalBounds::BIT), (true, true));
        // A line may be driven by nobody.
        assert_eq!(reach(&one_of(&[0, 1]), &SignalBounds::LINE), (true, false));
        assert_eq!(reach(&ValueTest::HighZ, &SignalBounds::BIT), (false, false));
        assert_eq!(reach(&ValueTest::Not(Box::new(one_of(&[2]))), &SignalBounds::BIT), (true, true));
    }
}
