//! Addresses of the controller: `%IX0.0`, `%MW10`.

use document::{Findings, Node};
use signal::{Address, Area, Size};

use crate::codes;

/// An address; reports what is wrong with it.
pub(crate) fn address(node: &Node, text: &str, out: &mut Findings) -> Option<Address> {
    match Address::parse(text.trim()) {
        Ok(address) => Some(address),
        Err(error) => {
            let shift = text.len() - text.trim_start().len();
            let at = (shift + error.offset()).min(text.len());
            out.bad_inside(
                codes::ADDRESS,
                node,
                Some(at..text.trim_end().len().max(at)),
                error.to_string(),
                "write an address such as %IX0.0, %QX0.4, %MW10 or %MX2.7",
            );
            None
        }
    }
}

/// The text as the address of an input or output.
pub(crate) fn terminal(node: &Node, text: &str, area: Area, out: &mut Findings) -> Option<Address> {
    let address = address(node, text, out)?;
    if address.area() != area || address.size() != Size::Bit {
        let example =
            if area == Area::Input { "an input such as \"%IX0.0\"" } else { "an output such as \"%QX0.4\"" };
        out.bad(codes::ADDRESS, node, format!("`{text}` is not {example}"), format!("write {example}"));
        return None;
    }
    Some(address)
}
