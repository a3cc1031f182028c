//! Tests of the parser.

mod broken;
mod constructs;
mod print;
mod print_body;
mod robust;
mod speed;
mod walk;

use super::ast::Unit;
use super::{NameTable, parse};
use crate::findings::Findings;
use document::{Diagnostic, SourceFile};

/// What a text is read as, and the findings.
fn read(text: &str) -> (Unit, NameTable, Vec<Diagnostic>) {
    let sources = [SourceFile::new("test.st", text)];
    let mut names = NameTable::new();
    let mut findings = Findings::new(&sources, 50);
    let unit = parse(&sources, &mut names, &mut findings);
    (unit, names, findings.finish())
}
