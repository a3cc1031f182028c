//! Numbers with the unit of their channel.

use document::{Data, Findings, KeyType, Node};
use signal::{Decimal, Quantity, Unit};

use crate::codes;

/// The number of a value in the unit `unit`; where the value has a unit, it must be one of the same kind.
/// Reports what is wrong.
pub(crate) fn quantity(node: &Node, unit: &str, out: &mut Findings) -> Option<f64> {
    quantity_under(node, unit, codes::UNIT, out)
}

/// The same of another file than a board file, whose code for a unit of another kind is `code`.
pub(crate) fn quantity_under(node: &Node, unit: &str, code: &'static str, out: &mut Findings) -> Option<f64> {
    exact(node, unit, code, out).map(Decimal::as_f64)
}

fn exact(node: &Node, unit: &str, code: &'static str, out: &mut Findings) -> Option<Decimal> {
    let text = match &node.data {
        Data::Integer(number) => return Some(Decimal::from(i128::from(*number))),
        Data::Float(text) | Data::Text(text) => text,
        _ => {
            out.bad(
                out.codes().wrong_type,
                node,
                "a number or a quantity is expected here",
                format!("write {}", KeyType::Quantity.describe()),
            );
            return None;
        }
    };
    let Ok(read) = Quantity::parse(text) else {
        let help = "write a number, or a number with the unit of its channel, as in \"20.5 degC\"";
        out.bad(out.codes().unreadable, node, "this does not read as a finite number", help);
        return None;
    };
    if read.unit.is_none() {
        return Some(read.number);
    }
    let number = read.in_unit(&Unit::new(unit));
    if number.is_none() {
        let help = match unit {
            "" => format!(
                "its channel has no unit: write `unit = \"{}\"` there, or the number alone",
                read.unit
            ),
            unit => format!("its channel is in {unit}: write how much it is in {unit}"),
        };
        let place = Decimal::split(text).map(|(_, behind)| text.len() - behind.len()..text.trim_end().len());
        out.bad_inside(code, node, place.ok(), format!("the unit is {}", read.unit), help);
    }
    number
}

/// A chance in millionths. Reports one that is none.
pub(crate) fn chance(node: &Node, out: &mut Findings) -> Option<u32> {
    let chance = exact(node, "", codes::UNIT, out)?;
    let millionths = chance.shifted(6).as_whole().and_then(|number| u32::try_from(number).ok());
    let right = millionths.filter(|number| *number <= 1_000_000);
    if right.is_none() {
        let help = "write a number from 0 (never) to 1 (always), in steps of a millionth";
        out.bad(codes::CHANCE, node, format!("{chance} is no chance"), help);
    }
    right
}
