//! Tests of the parser.

mod broken;
mod constructs;
mod print;
mod print_body;
mod robust;
mod speed;
mod walk;

use super::ast::Unit;
use super::{Names, parse};
use crate::findings::Findings;
use document::{Diagnostic, SourceFile};

/// What a text is read as, and the findings.
fn read(text: &str) -> (Unit, Names, Vec<Diagnostic>) {
    let sources = [SourceFile::new("test.st", text)];
    let mut names = Names::new();
    let mut findings = Findings::new(&sources, 50);
    let unit = parse(&sources, &mut names, &mut findings);
    (unit, names, findings.finish())
}
