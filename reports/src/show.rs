//! How names, verdicts and figures are written, the same in every report.

use record::{
    CaseRecord, CaseStatus, Figure, InstrumentRecord, InstrumentStatement, MeasurementRecord, RunRecord,
    Statistics, Unguarded, Verdict,
};
use signal::{Span, Value};
use std::borrow::Cow;

/// What a case came to, with "not applicable" and "skipped" beside the verdicts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum ShownOutcome {
    Judged(Verdict),
    Skipped,
    NotApplicable,
}

impl ShownOutcome {
    pub(crate) fn of(case: &CaseRecord) -> ShownOutcome {
        match case.status {
            CaseStatus::Judged => ShownOutcome::Judged(case.verdict),
            CaseStatus::NotApplicable { .. } => ShownOutcome::NotApplicable,
            CaseStatus::Skipped { .. } => ShownOutcome::Skipped,
        }
    }

    /// A word that is also the class in the page.
    pub(crate) const fn word(self) -> &'static str {
        match self {
            ShownOutcome::Judged(verdict) => verdict.word(),
            ShownOutcome::Skipped => "skipped",
            ShownOutcome::NotApplicable => "not-applicable",
        }
    }

    /// A sign beside the colour, so that colour is never the only difference.
    pub(crate) const fn sign(self) -> &'static str {
        match self {
            ShownOutcome::Judged(verdict) => sign(verdict),
            ShownOutcome::Skipped | ShownOutcome::NotApplicable => "–",
        }
    }
}

/// The sign of a verdict.
pub(crate) const fn sign(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::None => "·",
        Verdict::Pass => "✓",
        Verdict::Inconclusive => "?",
        Verdict::Fail => "✗",
        Verdict::Error => "!",
    }
}

/// Why a case came to its verdict, or why it has none; may be empty.
pub(crate) fn reason(case: &CaseRecord) -> &str {
    match &case.status {
        CaseStatus::Judged => &case.reason,
        CaseStatus::NotApplicable { reason } | CaseStatus::Skipped { reason } => reason,
    }
}

/// The stop by an exception that failed the case, if one did.
pub(crate) fn exception(case: &CaseRecord) -> Option<&str> {
    (case.verdict == Verdict::Fail && !case.exception.is_empty()).then_some(&case.exception)
}

/// The text with everything that a terminal or a reader of markup could act on made visible or blank:
/// control characters (escape sequences) and invisible direction marks become `�`, line ends and tabs blanks.
pub fn clean(text: &str) -> Cow<'_, str> {
    if text.chars().all(|c| replacement(c).is_none()) {
        return Cow::Borrowed(text);
    }
    Cow::Owned(text.chars().map(|c| replacement(c).unwrap_or(c)).collect())
}

fn replacement(c: char) -> Option<char> {
    match c {
        '\n' | '\r' | '\t' => Some(' '),
        '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}' => {
            Some('\u{fffd}')
        }
        '\u{fffe}' | '\u{ffff}' => Some('\u{fffd}'),
        c if c.is_control() => Some('\u{fffd}'),
        _ => None,
    }
}

/// A duration in nanoseconds.
pub(crate) fn span(ns: i64) -> String {
    Span::from_nanos(ns).to_string()
}

/// The instant or interval relative to `origin`: `+1.1002 s`, `+5.1 ms .. +5.3 ms`.
pub(crate) fn relative([earliest, latest]: [i64; 2], origin: i64) -> String {
    let one = |at: i64| {
        let ns = at.saturating_sub(origin);
        if ns < 0 { span(ns) } else { format!("+{}", span(ns)) }
    };
    if earliest == latest { one(earliest) } else { format!("{} .. {}", one(earliest), one(latest)) }
}

/// A measured value with its unit: of a time an interval as `low .. high`, of all else `middle ± half of it`. Ends that are
/// written alike are one value.
pub(crate) fn value(measurement: &MeasurementRecord) -> String {
    match measurement.value {
        None => "never taken".to_owned(),
        Some([low, high]) if figure(low, &measurement.unit) == figure(high, &measurement.unit) => {
            figure(low, &measurement.unit)
        }
        // Beyond 2^53 a middle would be rounded.
        Some([low, high])
            if measurement.unit != "ns" && low.abs().max(high.abs()) < 9_007_199_254_740_992.0 =>
        {
            let shown = Value::measured(low + (high - low) / 2.0, (high - low) / 2.0);
            format!("{shown} {}", measurement.unit).trim_end().to_owned()
        }
        Some([low, high]) => {
            format!("{} .. {}", figure(low, &measurement.unit), figure(high, &measurement.unit))
        }
    }
}

/// A measured value with what its interval covers: `23.990 ± 0.030 V (coverage 95 %)`.
pub(crate) fn covered(measurement: &MeasurementRecord) -> String {
    match measurement.coverage.as_str() {
        "" => value(measurement),
        coverage => format!("{} (coverage {coverage})", value(measurement)),
    }
}

/// What an instrument file states of each of its parts: `timebase` and `error = 25 ppm, resolution = 10 ns`.
pub(crate) fn instrument(instrument: &InstrumentRecord) -> Vec<(&str, String)> {
    let mut parts: Vec<(&str, String)> = Vec::new();
    for InstrumentStatement { of, key, value } in &instrument.statements {
        let stated = format!("{key} = {value}");
        match parts.last_mut() {
            Some((last, words)) if last == of => *words = format!("{words}, {stated}"),
            _ => parts.push((of, stated)),
        }
    }
    parts
}

/// The limits of a measurement as the plan gave them; empty when it has none. Where no guard band belongs to them they say so:
/// `≤ 6 us, guard none`.
pub(crate) fn limits(measurement: &MeasurementRecord) -> String {
    let mut limits = bare_limits(measurement);
    if !limits.is_empty() && !measurement.guard_band.is_uncertainty() {
        limits.push_str(", guard none");
    }
    limits
}

/// The reason of a verdict that the middle of a value alone decided; empty for all others.
pub(crate) fn by_middle(measurement: &MeasurementRecord) -> &str {
    if measurement.by_middle { &measurement.reason } else { "" }
}

/// What of a run was measured without a guard band, in words; empty for nothing.
pub(crate) fn unguarded(run: &RunRecord) -> String {
    unguarded_words(run.unguarded())
}

/// How many cases of a run were measured without a guard band, in words; empty for none.
pub fn unguarded_words(Unguarded { cases, by_middle }: Unguarded) -> String {
    let measured = match cases {
        0 => return String::new(),
        1 => "1 case measured without a guard band".to_owned(),
        n => format!("{n} cases measured without a guard band"),
    };
    match by_middle {
        0 => measured,
        n => format!("{measured}, {n} of them decided by a middle"),
    }
}

fn bare_limits(measurement: &MeasurementRecord) -> String {
    let unit = &measurement.unit;
    match (measurement.nominal, measurement.tolerance, measurement.min, measurement.max) {
        (Some(nominal), Some(tolerance), ..) => {
            format!("{} ± {}", figure(nominal, unit), figure(tolerance, unit))
        }
        (_, _, Some(min), Some(max)) => format!("{} .. {}", figure(min, unit), figure(max, unit)),
        (_, _, Some(min), None) => format!("≥ {}", figure(min, unit)),
        (_, _, None, Some(max)) => format!("≤ {}", figure(max, unit)),
        (_, _, None, None) => String::new(),
    }
}

/// The limits of a measurement as numbers, whichever way they were given. Those of a nominal value are in the record as they were
/// judged, exact; only records of early rigs lack them.
pub(crate) fn bounds(measurement: &MeasurementRecord) -> (Option<f64>, Option<f64>) {
    match (measurement.min, measurement.max, measurement.nominal, measurement.tolerance) {
        (None, None, Some(nominal), Some(tolerance)) => {
            (Some(nominal - tolerance), Some(nominal + tolerance))
        }
        (min, max, ..) => (min, max),
    }
}

/// What a figure came to over several turns: `99.8 ms .. 100.1 ms, mean 99.9 ms, spread 45 us, drift 1 us a turn`.
pub(crate) fn statistics(found: &Statistics, unit: &str) -> String {
    let Statistics { min, mean, max, spread, drift, .. } = *found;
    // What is computed from many turns is no better known than to a few digits of what the turns differ by.
    let digits = |value: f64| format!("{value:.2e}").parse().unwrap_or(value);
    let middle = if unit == "ns" { mean.round() } else { mean };
    let [min, max, mean] = [min, max, middle].map(|value| figure(value, unit));
    let [spread, drift] = [spread, drift].map(|value| figure(digits(value), unit));
    format!("{min} .. {max}, mean {mean}, spread {spread}, drift {drift} a turn")
}

fn figure(value: f64, unit: &str) -> String {
    Figure::new(value, unit).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use record::GuardBand;

    #[test]
    fn nothing_in_a_name_acts_on_a_terminal() {
        assert_eq!(clean("lamp\u{1b}[31m\nfalls\u{202e}"), "lamp\u{fffd}[31m falls\u{fffd}");
        assert!(matches!(clean("lamp ± 1 µs"), Cow::Borrowed(_)));
    }

    #[test]
    fn a_quantity_is_shown_with_how_far_it_is_known_and_a_time_with_its_ends() {
        let shown = |found: [f64; 2], unit: &str| {
            value(&MeasurementRecord {
                value: Some(found),
                unit: unit.to_owned(),
                ..MeasurementRecord::default()
            })
        };
        assert_eq!(shown([4.98, 5.02], "V"), "5.000 ± 0.020 V");
        assert_eq!(shown([5.0, 5.0], "V"), "5 V");
        assert_eq!(shown([2.82842712474619, 2.8284271247461907], "V"), "2.82842712 V");
        assert_eq!(
            shown([9007199254740992.0, 9007199254740994.0], "V"),
            "9007199254740992 V .. 9007199254740994 V"
        );
        assert_eq!(shown([1e6, 2e6], "ns"), "1 ms .. 2 ms");
        assert_eq!(shown([1.0, f64::INFINITY], "V"), "1 V .. inf V");
    }

    #[test]
    fn limits_say_that_they_have_no_guard_band() {
        let mut taken = MeasurementRecord {
            unit: "ns".into(),
            guard_band: GuardBand::None,
            ..MeasurementRecord::default()
        };
        assert_eq!(limits(&taken), "");
        taken.max = Some(6_000.0);
        assert_eq!(limits(&taken), "≤ 6 us, guard none");
        taken.guard_band = GuardBand::Uncertainty;
        assert_eq!(limits(&taken), "≤ 6 us");
    }

    #[test]
    fn limits_around_a_value_are_those_that_it_was_judged_by() {
        let stated = MeasurementRecord {
            nominal: Some(0.3),
            tolerance: Some(0.1),
            min: Some(0.2),
            max: Some(0.4),
            ..MeasurementRecord::default()
        };
        // In floats 0.3 - 0.1 is below 0.2.
        assert_eq!(bounds(&stated), (Some(0.2), Some(0.4)));
        let early =
            MeasurementRecord { min: None, max: None, nominal: Some(24.0), tolerance: Some(0.5), ..stated };
        assert_eq!(bounds(&early), (Some(23.5), Some(24.5)));
    }

    #[test]
    fn instants_are_relative_to_the_start() {
        assert_eq!(relative([1_100_200_000, 1_100_200_000], 1_000_000_000), "+100.2 ms");
        assert_eq!(relative([-5, 5], 0), "-5 ns .. +5 ns");
        assert_eq!(relative([i64::MAX, i64::MAX], -1), "+9223372036.854775807 s");
    }
}
