//! What a case came to in one line, for lists of failures, and texts cut to a length.

use crate::show;
use record::{CaseRecord, ClaimRecord, MeasurementRecord, Verdict};

/// The claim or measurement that decided a case, or the case's own reason.
pub(crate) enum DecidingResult<'a> {
    Claim(&'a ClaimRecord),
    Measurement(&'a MeasurementRecord),
    Reason(&'a str),
}

impl<'a> DecidingResult<'a> {
    /// The first that has the case's verdict: claims before measurements. A stop by an exception goes before them: what they
    /// lack is for its sake.
    pub(crate) fn of(case: &'a CaseRecord) -> DecidingResult<'a> {
        if let Some(exception) = show::exception(case) {
            return DecidingResult::Reason(exception);
        }
        let claim = case.claims.iter().find(|claim| claim.verdict == case.verdict);
        let measurement = case.measurements.iter().find(|m| m.verdict == case.verdict);
        match (claim, measurement) {
            (Some(claim), _) => DecidingResult::Claim(claim),
            (None, Some(measurement)) => DecidingResult::Measurement(measurement),
            (None, None) => DecidingResult::Reason(show::reason(case)),
        }
    }

    /// Its line in the plan; 0 where it has none.
    pub(crate) fn line(&self) -> u32 {
        match self {
            DecidingResult::Claim(claim) => claim.line,
            DecidingResult::Measurement(measurement) => measurement.line,
            DecidingResult::Reason(_) => 0,
        }
    }
}

/// Why a case did not pass, in one line: the worst claim or measurement, or the case's own reason.
pub(crate) fn message(case: &CaseRecord) -> String {
    let mut text = match DecidingResult::of(case) {
        DecidingResult::Claim(claim) => {
            let mut text =
                format!("{}: expected {}, observed {}", claim.name, claim.expected, claim.observed);
            if let Some(margin) = &claim.margin {
                text.push_str(&format!(", margin {margin}"));
            }
            if let Some(miss) = &claim.nearest_miss {
                text.push_str(&format!(", nearest miss: {miss}"));
            }
            text
        }
        DecidingResult::Measurement(m) => {
            let by_middle = match show::by_middle(m) {
                "" => String::new(),
                reason => format!(", {reason}"),
            };
            format!("{}: limits {}, measured {}{by_middle}", m.name, show::limits(m), show::value(m))
        }
        DecidingResult::Reason(reason) => reason.to_owned(),
    };
    if text.is_empty() && case.is_judged() && case.verdict != Verdict::Pass {
        text = case.verdict.word().to_owned();
    }
    show::clean(&text).into_owned()
}

/// The first part of a text, at most `most` bytes of it, and how much was cut, where something was.
pub(crate) fn cut(text: &str, most: usize) -> String {
    if text.len() <= most {
        return text.to_owned();
    }
    let mut end = most;
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    format!("{} [... {} bytes more: see record.json]", &text[..end], text.len() - end)
}

/// A name without its middle, where it is longer than `most` bytes: rows and points stand at the end.
pub(crate) fn shorten(name: &str, most: usize) -> String {
    if name.len() <= most {
        return name.to_owned();
    }
    let half = most.saturating_sub(5) / 2;
    let (mut head, mut tail) = (half, name.len() - half);
    while !name.is_char_boundary(head) {
        head -= 1;
    }
    while !name.is_char_boundary(tail) {
        tail += 1;
    }
    format!("{} ... {}", &name[..head], &name[tail..])
}

/// The file of waves beside a case's trace, relative to the record.
pub(crate) fn waves(case: &CaseRecord) -> Option<String> {
    Some(format!("{}.vcd", case.trace_file.as_deref()?.strip_suffix(".trace")?))
}

/// The file of CAN frames beside a case's trace, relative to the record.
pub(crate) fn frames(case: &CaseRecord) -> Option<String> {
    case.frames?;
    Some(format!("{}.log", case.trace_file.as_deref()?.strip_suffix(".trace")?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_cut_between_characters_and_say_so() {
        assert_eq!(cut("µµµ", 6), "µµµ");
        assert_eq!(cut("µµµ", 3), "µ [... 4 bytes more: see record.json]");
        assert_eq!(shorten("abcdefghijklmnop[x]", 13), "abcd ... p[x]");
        assert_eq!(shorten("µµµµµµµµ", 12), "µ ... µ");
    }
}
