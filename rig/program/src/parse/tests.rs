//! Tests of the parser.

mod broken;
mod constructs;
mod print;
mod print_body;
mod robust;
mod speed;
mod walk;

use super::ast::SourceUnit;
use super::{NameTable, parse};
use crate::findings::CompileFindings;
use document::{Diagnostic, SourceFile};

/// What a text is read as, and the findings.
fn read(text: &str) -> (SourceUnit, NameTable, Vec<Diagnostic>) {
    let sources = [SourceFile::new("test.st", text)];
    let mut names = NameTable::new();
    let mut findings = CompileFindings::new(&sources, 50);
    let unit = parse(&sources, sources.len(), &mut names, &mut findings);
    (unit, names, findings.finish())
}
