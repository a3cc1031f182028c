//! Writes mutations into a source file, each behind a switch of its own.

use crate::points::{Form, Point};
use std::ops::Range;

/// Where a mutation stands in what was written.
#[derive(Clone, Debug)]
pub struct Place {
    pub number: usize,
    /// The mutated text.
    pub mutated: Range<usize>,
    /// All that was written for it, the original text among it.
    pub whole: Range<usize>,
    pub line: usize,
}

/// The source with these numbered mutations in it, and where they are. No line moves.
pub fn rewrite(source: &str, points: &[(usize, &Point)]) -> (String, Vec<Place>) {
    // What is written at a byte of the source: ends before beginnings, inner ends and outer beginnings first.
    let mut writes = Vec::new();
    for (order, (number, point)) in points.iter().enumerate() {
        let Range { start, end } = point.range;
        let order = order as i64;
        let (opening, closing) = match point.form {
            Form::Replace => {
                // What is left out is a statement: its value does not count.
                let closing = if point.after.is_empty() { "; })" } else { " })" };
                (format!("(if crate::mutants::on({number}) {{ {} }} else {{ ", point.after), closing)
            }
            Form::Never => (format!("!crate::mutants::on({number}) && "), ""),
            Form::Insert => (format!("if crate::mutants::on({number}) {{ {} }} ", point.after), ""),
        };
        let outermost = if point.form == Form::Insert { usize::MAX } else { end };
        writes.push(((start, 1, usize::MAX - outermost, order), opening, Some(*number)));
        if point.form == Form::Insert {
            continue;
        }
        writes.push(((end, 0, usize::MAX - start, -order), closing.to_string(), None));
    }
    writes.sort_by_key(|write| write.0);
    let (mut text, mut at) = (String::new(), 0);
    let mut places: Vec<Place> = Vec::new();
    let mut open: Vec<usize> = Vec::new();
    for ((byte, ..), written, number) in writes {
        text.push_str(&source[at..byte]);
        at = byte;
        let begin = text.len();
        text.push_str(&written);
        match number {
            Some(number) => {
                let point = points.iter().find(|(n, _)| *n == number).expect("is one of them").1;
                if point.form != Form::Insert {
                    open.push(places.len());
                }
                let range = begin..text.len();
                places.push(Place { number, mutated: range.clone(), whole: range, line: point.line });
            }
            None => {
                let place = open.pop().expect("every end has a beginning");
                places[place].whole.end = text.len();
            }
        }
    }
    text.push_str(&source[at..]);
    (text, places)
}
