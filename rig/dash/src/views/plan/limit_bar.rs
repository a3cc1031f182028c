//! A value against its limits, drawn as a bar.

use crate::canvas::{self, Canvas};
use crate::show;
use control::Measured;

/// The part of the numbers that a bar shows: limits and value with a fifth of their distance around.
fn scale(measured: &Measured) -> Option<(f64, f64)> {
    let value = measured.value.map(|(from, to)| [Some(from), Some(to)]).unwrap_or_default();
    let points = [measured.low, measured.high].into_iter().chain(value).flatten().filter(|at| at.is_finite());
    let (low, high) =
        points.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
    if low > high {
        return None;
    }
    let distance = high - low;
    let around = if distance > 0.0 { distance / 5.0 } else { (low.abs() / 10.0).max(1e-9) };
    let (from, to) = (low - around, high + around);
    (from.is_finite() && to.is_finite() && from < to).then_some((from, to))
}

/// Draws a measurement's bar: the allowed band, and in it, or beside it, the value.
pub fn draw(canvas: &mut Canvas<'_>, x: u16, y: u16, width: u16, measured: &Measured) {
    let Some((from, to)) = scale(measured).filter(|_| width > 0) else { return };
    let column = |at: f64| {
        let share = ((at - from) / (to - from)).clamp(0.0, 1.0);
        ((share * f64::from(width)) as u16).min(width - 1)
    };
    let [outside, inside, edge, value] =
        if canvas.features.utf8 { ['·', '═', '┃', '█'] } else { ['.', '=', '|', '#'] };
    let low = measured.low.map(column);
    let high = measured.high.map(column);
    for place in 0..width {
        let allowed = low.is_none_or(|low| place >= low) && high.is_none_or(|high| place <= high);
        let limit = low == Some(place) || high == Some(place);
        let glyph = match (limit, allowed) {
            (true, _) => edge,
            (false, true) => inside,
            (false, false) => outside,
        };
        canvas.glyph(x + place, y, glyph, ratatui::style::Style::new());
    }
    if let Some((begin, end)) = measured.value.filter(|(begin, end)| begin.is_finite() && end.is_finite()) {
        let style = if measured.verdict == "pass" { canvas.good() } else { canvas.alarm() };
        for place in column(begin.min(end))..=column(end.max(begin)) {
            canvas.glyph(x + place, y, value, style.patch(canvas::bold()));
        }
    }
}

/// A measurement in words: `12.5 ms, 10 .. 15 ms asked`.
pub fn words(measured: &Measured) -> String {
    let numbers = measured.value.map(|(from, to)| [from, to]).into_iter().flatten();
    let greatest = numbers.chain(measured.low).chain(measured.high).filter(|number| number.is_finite());
    // Durations are nanoseconds on the wire, and shown in the unit that fits the greatest of them.
    let (scale, unit) = match measured.unit.as_str() {
        show::NANOSECONDS => show::scale(greatest.fold(0.0, |most, number| number.abs().max(most)) as i64),
        unit => (1, unit),
    };
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    let number = |number: f64| show::real(number / scale as f64, 9);
    let value = match measured.value {
        None => "not taken".to_owned(),
        Some((from, to)) if from == to => format!("{}{unit}", number(from)),
        Some((from, to)) => format!("{} .. {}{unit}", number(from), number(to)),
    };
    match (measured.low, measured.high) {
        (None, None) => value,
        (Some(low), None) => format!("{value} (>= {}{unit})", number(low)),
        (None, Some(high)) => format!("{value} (<= {}{unit})", number(high)),
        (Some(low), Some(high)) => format!("{value} ({} .. {}{unit})", number(low), number(high)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measured(value: Option<(f64, f64)>, low: Option<f64>, high: Option<f64>) -> Measured {
        let (name, unit, verdict) = ("t".to_owned(), "ms".to_owned(), "pass".to_owned());
        Measured { name, value, low, high, unit, verdict }
    }

    #[test]
    fn every_limit_has_a_scale_or_no_bar() {
        assert_eq!(scale(&measured(Some((1.0, 1.0)), Some(0.0), Some(5.0))), Some((-1.0, 6.0)));
        assert_eq!(scale(&measured(None, None, None)), None);
        assert_eq!(scale(&measured(Some((f64::NAN, f64::INFINITY)), None, None)), None);
        assert!(
            scale(&measured(Some((3.0, 3.0)), None, None)).is_some_and(|(from, to)| from < 3.0 && 3.0 < to)
        );
        assert!(scale(&measured(None, Some(f64::MIN), Some(f64::MAX))).is_none());
    }

    #[test]
    fn words_say_value_and_limits() {
        assert_eq!(words(&measured(Some((1.0, 2.5)), Some(0.0), None)), "1 .. 2.5 ms (>= 0 ms)");
        assert_eq!(words(&measured(None, Some(1.0), Some(2.0))), "not taken (1 .. 2 ms)");
        let lag =
            Measured { unit: "ns".to_owned(), ..measured(Some((520_035e3, 520_035e3)), None, Some(5e8)) };
        assert_eq!(words(&lag), "520.035 ms (<= 500 ms)");
    }
}
