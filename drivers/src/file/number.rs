//! Numbers with the unit of their channel.

use document::{Data, Findings, Node};

use super::codes;

/// The number of a value whose unit, where one is written, must be `unit`. Reports what is wrong.
pub(super) fn quantity(node: &Node, unit: &str, out: &mut Findings) -> Option<f64> {
    match &node.data {
        Data::Integer(number) => Some(*number as f64),
        Data::Float(text) => finite(node, text, out),
        Data::Text(text) => {
            let end = text.find(|c: char| !(c.is_ascii_digit() || " +-._".contains(c))).unwrap_or(text.len());
            let (number, written) = (&text[..end], text[end..].trim());
            let number = finite(node, number, out)?;
            if !written.is_empty() && plain(written) != plain(unit) {
                let expected = match unit {
                    "" => String::from("its channel has no unit: write the number alone"),
                    unit => format!("its channel is in {unit}: write \"{number} {unit}\""),
                };
                let message = format!("the unit is {written}");
                out.bad_inside(codes::UNIT, node, Some(end..text.trim_end().len()), message, expected);
                return None;
            }
            Some(number)
        }
        _ => {
            out.bad(codes::WRONG_TYPE, node, "a number or a quantity is expected here", "");
            None
        }
    }
}

/// A unit in one spelling.
fn plain(unit: &str) -> &str {
    match unit {
        "°C" | "degC" => "degC",
        "µA" | "μA" | "uA" => "uA",
        other => other,
    }
}

fn finite(node: &Node, text: &str, out: &mut Findings) -> Option<f64> {
    let digits: String = text.trim().chars().filter(|c| *c != '_').collect();
    let number = digits.parse::<f64>().ok().filter(|number| number.is_finite());
    if number.is_none() {
        let help = "write a number, or a number with the unit of its channel, as in \"20.5 degC\"";
        out.bad(codes::UNREADABLE, node, "this does not read as a finite number", help);
    }
    number
}

/// A chance in millionths. Reports one that is none.
pub(super) fn chance(node: &Node, out: &mut Findings) -> Option<u32> {
    let chance = quantity(node, "", out)?;
    if !(0.0..=1.0).contains(&chance) {
        out.bad(
            codes::CHANCE,
            node,
            format!("{chance} is no chance"),
            "write a number from 0 (never) to 1 (always)",
        );
        return None;
    }
    Some(libm::round(chance * 1e6) as u32)
}
