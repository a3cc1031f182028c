//! Writes a tree as text again: everything that is in the tree, so that what was not read into it is missed.

use super::super::NameTable;
use super::super::ast::*;
use crate::program::Retention;
use crate::types::Elementary;

/// A token, and whether the tree must have it. Brackets that only group and the like are not counted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Piece {
    pub text: String,
    pub counted: bool,
}

/// Cells and how they are written.
pub const MOMENTS: &[(&str, i64, Elementary)] = &[
    ("T#1500ms", 1_500, Elementary::Time),
    ("LTIME#7ns", 7, Elementary::Ltime),
    ("D#1970-01-02", 86_400, Elementary::Date),
    ("TOD#00:00:01", 1_000, Elementary::Tod),
    ("DT#1970-01-01-00:01:00", 60, Elementary::Dt),
    ("LDATE#1970-01-01", 0, Elementary::Ldate),
    ("LTOD#00:00:00.000000002", 2, Elementary::Ltod),
    ("LDT#1970-01-01-00:00:00.000000003", 3, Elementary::Ldt),
];

pub fn print(unit: &SourceUnit, names: &NameTable) -> Vec<Piece> {
    let mut printer = Printer { names, pieces: Vec::new() };
    for section in &unit.globals {
        printer.section(section);
    }
    for ty in &unit.types {
        printer.skip("TYPE");
        printer.type_decl(ty);
        printer.skip("END_TYPE");
    }
    for interface in &unit.interfaces {
        printer.interface(interface);
    }
    for pou in &unit.pous {
        printer.pou(pou);
    }
    for configuration in &unit.configurations {
        printer.configuration(configuration);
    }
    printer.pieces
}

pub(super) struct Printer<'n> {
    pub(super) names: &'n NameTable,
    pieces: Vec<Piece>,
}

impl Printer<'_> {
    pub(super) fn put(&mut self, text: &str) {
        self.pieces.push(Piece { text: text.to_string(), counted: true });
    }

    pub(super) fn skip(&mut self, text: &str) {
        self.pieces.push(Piece { text: text.to_string(), counted: false });
    }

    pub(super) fn name(&mut self, name: Name) {
        self.put(self.names.key_text(name.key));
    }

    pub(super) fn named(&mut self, word: &str, names: &[Name]) {
        for (place, name) in names.iter().enumerate() {
            self.put(if place == 0 { word } else { "," });
            self.name(*name);
        }
    }

    fn modifiers(&mut self, modifiers: Modifiers) {
        for (set, word) in [
            (modifiers.private, "PRIVATE"),
            (modifiers.protected, "PROTECTED"),
            (modifiers.is_abstract, "ABSTRACT"),
            (modifiers.is_final, "FINAL"),
            (modifiers.is_override, "OVERRIDE"),
        ] {
            if set {
                self.put(word);
            }
        }
    }

    fn pou(&mut self, pou: &Pou) {
        self.put(pou.kind.keyword());
        self.modifiers(pou.modifiers);
        self.name(pou.name);
        self.named("EXTENDS", pou.extends.as_slice());
        self.named("IMPLEMENTS", &pou.implements);
        self.result(&pou.result);
        pou.sections.iter().for_each(|section| self.section(section));
        pou.methods.iter().for_each(|method| self.method(method));
        pou.properties.iter().for_each(|property| self.property(property));
        for action in &pou.actions {
            self.put("ACTION");
            self.name(action.name);
            self.skip(":");
            self.body(&action.body);
            self.put("END_ACTION");
        }
        self.body(&pou.body);
        self.put(&format!("END_{}", pou.kind.keyword()));
    }

    fn result(&mut self, result: &Option<TypeRef>) {
        if let Some(ty) = result {
            self.put(":");
            self.ty(ty);
        }
    }

    fn method(&mut self, method: &Method) {
        self.put("METHOD");
        self.modifiers(method.modifiers);
        self.name(method.name);
        self.result(&method.result);
        method.sections.iter().for_each(|section| self.section(section));
        self.body(&method.body);
        self.put("END_METHOD");
    }

    fn property(&mut self, property: &Property) {
        self.put("PROPERTY");
        self.modifiers(property.modifiers);
        self.name(property.name);
        self.put(":");
        self.ty(&property.ty);
        for (word, accessor) in [("GET", &property.get), ("SET", &property.set)] {
            if let Some(accessor) = accessor {
                self.put(word);
                accessor.sections.iter().for_each(|section| self.section(section));
                self.body(&accessor.body);
                self.put(&format!("END_{word}"));
            }
        }
        self.put("END_PROPERTY");
    }

    fn interface(&mut self, interface: &InterfaceDecl) {
        self.put("INTERFACE");
        self.name(interface.name);
        self.named("EXTENDS", &interface.extends);
        interface.methods.iter().for_each(|method| self.method(method));
        interface.properties.iter().for_each(|property| self.property(property));
        self.put("END_INTERFACE");
    }

    fn configuration(&mut self, configuration: &Configuration) {
        self.put("CONFIGURATION");
        self.name(configuration.name);
        configuration.globals.iter().for_each(|section| self.section(section));
        for task in &configuration.tasks {
            self.put("TASK");
            self.name(task.name);
            for (place, (name, value)) in task.parameters.iter().enumerate() {
                self.put(if place == 0 { "(" } else { "," });
                self.name(*name);
                self.put(":=");
                self.expr(value);
            }
            self.put(")");
            self.put(";");
        }
        for program in &configuration.programs {
            self.put("PROGRAM");
            self.name(program.instance);
            self.named("WITH", program.task.as_slice());
            self.put(":");
            self.name(program.program);
            self.put(";");
        }
        self.put("END_CONFIGURATION");
    }

    fn section(&mut self, section: &Section) {
        self.put(match section.kind {
            SectionKind::Input => "VAR_INPUT",
            SectionKind::Output => "VAR_OUTPUT",
            SectionKind::InOut => "VAR_IN_OUT",
            SectionKind::Local => "VAR",
            SectionKind::Temp => "VAR_TEMP",
            SectionKind::Static => "VAR_STAT",
            SectionKind::Instance => "VAR_INST",
            SectionKind::Global => "VAR_GLOBAL",
            SectionKind::External => "VAR_EXTERNAL",
        });
        if section.constant {
            self.put("CONSTANT");
        }
        match section.retention {
            Retention::None => {}
            Retention::Retain => self.put("RETAIN"),
            Retention::Persistent => self.put("PERSISTENT"),
        }
        self.variables(&section.variables);
        self.put("END_VAR");
    }

    fn variables(&mut self, variables: &[VarDecl]) {
        for variable in variables {
            self.name(variable.name);
            if let Some((address, _)) = &variable.address {
                self.put("AT");
                self.put(address);
            }
            self.put(":");
            self.ty(&variable.ty);
            if let Some(built) = &variable.built {
                if built.each {
                    self.put("[");
                }
                for (nth, list) in built.lists.iter().enumerate() {
                    if nth > 0 {
                        self.put(",");
                    }
                    self.arguments(list);
                }
                if built.each {
                    self.put("]");
                }
            }
            if let Some((falling, _)) = variable.edge {
                self.put(if falling { "F_EDGE" } else { "R_EDGE" });
            }
            self.initial_of(&variable.initial);
            self.put(";");
        }
    }

    fn type_decl(&mut self, decl: &TypeDecl) {
        self.name(decl.name);
        if let TypeKind::Struct { extends, .. } = &decl.ty.kind {
            self.named("EXTENDS", extends.as_slice());
        }
        self.put(":");
        self.ty(&decl.ty);
        self.initial_of(&decl.initial);
        self.skip(";");
    }

    fn ty(&mut self, ty: &TypeRef) {
        match &ty.kind {
            TypeKind::Named(name) => self.name(*name),
            TypeKind::Text { wide, length } => {
                self.put(if *wide { "WSTRING" } else { "STRING" });
                if let Some(length) = length {
                    self.skip("[");
                    self.expr(length);
                    self.skip("]");
                }
            }
            TypeKind::Subrange { base, low, high } => {
                self.name(*base);
                self.put("(");
                self.expr(low);
                self.put("..");
                self.expr(high);
                self.put(")");
            }
            TypeKind::Array { ranges, of } => {
                self.put("ARRAY");
                for (place, range) in ranges.iter().enumerate() {
                    self.put(if place == 0 { "[" } else { "," });
                    match range {
                        None => self.put("*"),
                        Some((low, high)) => {
                            self.expr(low);
                            self.put("..");
                            self.expr(high);
                        }
                    }
                }
                self.put("]");
                self.put("OF");
                self.ty(of);
            }
            TypeKind::Pointer(to) => {
                self.put("POINTER");
                self.put("TO");
                self.ty(to);
            }
            TypeKind::RefTo(to) => {
                self.put("REF_TO");
                self.ty(to);
            }
            TypeKind::Reference(to) => {
                self.put("REFERENCE");
                self.put("TO");
                self.ty(to);
            }
            TypeKind::Enumeration { values, base } => {
                for (place, (name, value)) in values.iter().enumerate() {
                    self.put(if place == 0 { "(" } else { "," });
                    self.name(*name);
                    if let Some(value) = value {
                        self.put(":=");
                        self.expr(value);
                    }
                }
                self.put(")");
                if let Some(base) = base {
                    self.name(*base);
                }
            }
            TypeKind::Struct { members, .. } => {
                self.put("STRUCT");
                self.variables(members);
                self.put("END_STRUCT");
            }
            TypeKind::Union { members } => {
                self.put("UNION");
                self.variables(members);
                self.put("END_UNION");
            }
        }
    }

    fn initial_of(&mut self, initial: &Option<Initializer>) {
        if let Some(initial) = initial {
            self.put(":=");
            self.initial(initial);
        }
    }

    fn initial(&mut self, initial: &Initializer) {
        match initial {
            Initializer::One(expr) => self.expr(expr),
            Initializer::List(list, _) => {
                self.put("[");
                for (place, (count, value)) in list.iter().enumerate() {
                    if place > 0 {
                        self.put(",");
                    }
                    if let Some(count) = count {
                        self.expr(count);
                        self.put("(");
                        self.initial(value);
                        self.put(")");
                    } else {
                        self.initial(value);
                    }
                }
                self.put("]");
            }
            Initializer::Members(members, _) => {
                for (place, (name, value)) in members.iter().enumerate() {
                    self.put(if place == 0 { "(" } else { "," });
                    self.name(*name);
                    self.put(":=");
                    self.initial(value);
                }
                self.put(")");
            }
        }
    }
}
