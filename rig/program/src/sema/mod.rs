//! Names, types, places: from the syntax tree to the checked tree.
//!
//! The order: names of everything first, then types and constants as they are needed, then what blocks consist of,
//! then where variables stand with their initial bytes, at last the bodies. So nothing depends on the order of the
//! sources.

mod any;
mod argument;
mod block;
mod call;
mod class;
mod constant;
mod convert;
mod declare;
mod edge;
mod element;
mod expr;
mod initial;
mod late;
mod literal;
mod member;
mod open;
mod operator;
mod place;
mod promote;
mod resolve;
mod scope;
mod standard;
mod stmt;
mod table;
mod task;
mod types;

use crate::findings::{CompileFindings, SourcePlace};
use crate::options::Options;
use crate::parse::NameTable;
use crate::parse::ast::{self, Key, Name, SectionKind};
use crate::program::{ImagePlace, Located, ProgramPin, Retained};
use crate::shape::{MemoryLayout, Root, ShapeId};
use crate::tree::{Tree, UnitTree};
use crate::types::Elementary;
use document::SourceFile;
use scope::{Callable, Pou, ScopeContext, ScopeSymbol};
use signal::Address;
use std::collections::{BTreeMap, HashMap};
use std::hash::{BuildHasherDefault, Hasher};
use types::{Enumeration, Structure, Type, TypeId, WRONG};

/// Hashes small keys; the order of the maps is never used.
#[derive(Default)]
struct KeyHasher(u64);

impl Hasher for KeyHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    fn write_u32(&mut self, n: u32) {
        self.0 = (self.0 ^ u64::from(n)).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(29);
    }
}

type KeyMap<K, V> = HashMap<K, V, BuildHasherDefault<KeyHasher>>;

/// How deep types may contain each other.
const TYPE_DEPTH: u32 = 100;
/// Most bytes of the initial images of types, blocks and frames together: a type counts again in each that it is part of.
const MOST_IMAGES: u64 = 128 << 20;

/// What a name at the outside means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Global {
    /// A place in `Sema::globals`.
    Variable(u32),
    /// A place in `Sema::pous`.
    Pou(u32),
    /// A place in `Sema::type_decls`.
    Type(u32),
    /// A place in `Sema::interfaces`.
    Interface(u32),
}

/// A TYPE with what has become of it.
struct TypeEntry<'a> {
    decl: &'a ast::TypeDecl,
    /// `None` while it is being found out.
    state: State<TypeId>,
}

/// What is found out when it is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State<T> {
    Untouched,
    Busy,
    Done(T),
}

/// An interface.
struct Interface<'a> {
    ast: &'a ast::InterfaceDecl,
    shown: String,
    extends: Vec<u32>,
    /// Heads of its methods and accessors with those that it inherits.
    heads: Vec<(scope::MethodSelector, Callable<'a>)>,
    state: State<()>,
}

/// The work on one application.
struct Sema<'a> {
    unit: &'a ast::SourceUnit,
    names: &'a NameTable,
    options: &'a Options,
    findings: CompileFindings<'a>,
    sources: &'a [SourceFile],
    /// How many of them are the user's: they stand first.
    own: usize,

    types: Vec<Type>,
    type_index: HashMap<Type, TypeId>,
    enumerations: Vec<Enumeration>,
    structures: Vec<Structure>,
    type_decls: Vec<TypeEntry<'a>>,
    /// Types of inline enumerations and the like by the place of their declaration.
    inline_types: HashMap<(u16, u32), TypeId>,
    enumerators: KeyMap<Key, Vec<(TypeId, i64)>>,
    outside: KeyMap<Key, Global>,
    globals: Vec<ScopeSymbol<'a>>,
    pous: Vec<Pou<'a>>,
    interfaces: Vec<Interface<'a>>,
    native_index: KeyMap<Key, u16>,
    native_layouts: Vec<(Vec<u16>, u32)>,
    callables: Vec<Callable<'a>>,
    selectors: Vec<scope::MethodSelector>,
    selector_index: HashMap<scope::MethodSelector, u32>,
    kinds: Vec<scope::SymbolKind>,
    depth: u32,
    /// Bytes of the initial images of types, blocks and frames so far.
    images: u64,
    /// Methods and properties that interfaces inherit, so far.
    heads: usize,
    /// Whether the type of an in-out is being found out, which may be an array of variable length.
    in_out: bool,
    /// Whether the type of an input is being found out, which may be any type.
    any: bool,

    /// Initial bytes of the variables, from `map::FIRST` on.
    data: Vec<u8>,
    retained: Vec<Retained>,
    /// Bytes of those.
    kept: u64,
    /// Whether a type holds members that are retained by themselves.
    retaining: HashMap<TypeId, bool>,
    located: Vec<Located>,
    roots: Vec<Root>,
    pins: Vec<ProgramPin>,
    shapes: Vec<MemoryLayout>,
    shape_index: HashMap<TypeId, ShapeId>,
    context: ScopeContext,
    /// The first LREAL of the sources.
    /// Places of %I and %Q, each with its bits and where it is named first.
    image_places: BTreeMap<(Address, u32), SourcePlace>,
    lreal: Option<SourcePlace>,
    /// Where the image stands whose initial values are being written.
    base: late::LateBase,
    /// Initial values of variables at addresses that wait, with the unit whose names they use.
    late: Vec<(Option<u32>, late::Late<'a>)>,
    /// Blocks whose instances are made by code: places in `pous`.
    makers: Vec<Option<u32>>,
}

/// Checks the declarations and bodies. What is wrong is in the findings, and then the tree is not whole.
pub(crate) fn check<'a>(
    unit: &'a ast::SourceUnit,
    names: &'a NameTable,
    options: &'a Options,
    findings: CompileFindings<'a>,
    (sources, own): (&'a [SourceFile], usize),
) -> (Tree, CompileFindings<'a>) {
    let mut sema = Sema {
        unit,
        names,
        options,
        findings,
        sources,
        own,
        types: Vec::new(),
        type_index: HashMap::new(),
        enumerations: Vec::new(),
        structures: Vec::new(),
        type_decls: Vec::new(),
        inline_types: HashMap::new(),
        enumerators: KeyMap::default(),
        outside: KeyMap::default(),
        globals: Vec::new(),
        pous: Vec::new(),
        interfaces: Vec::new(),
        native_index: KeyMap::default(),
        native_layouts: Vec::new(),
        callables: Vec::new(),
        selectors: Vec::new(),
        selector_index: HashMap::new(),
        kinds: Vec::new(),
        depth: 0,
        images: 0,
        heads: 0,
        in_out: false,
        any: false,
        data: Vec::new(),
        retained: Vec::new(),
        kept: 0,
        retaining: HashMap::new(),
        located: Vec::new(),
        roots: Vec::new(),
        pins: Vec::new(),
        shapes: Vec::new(),
        shape_index: HashMap::new(),
        context: ScopeContext::default(),
        image_places: BTreeMap::new(),
        lreal: None,
        base: late::LateBase::None,
        late: Vec::new(),
        makers: Vec::new(),
    };
    sema.intern(Type::Wrong);
    for ty in Elementary::ALL {
        sema.intern(Type::Elementary(ty));
    }
    sema.collect();
    sema.resolve_types();
    sema.resolve_pous();
    sema.resolve_globals();
    let mut units = sema.bodies();
    let initial = sema.making(&mut units);
    let tree = sema.finish(units, initial);
    (tree, sema.findings)
}

impl<'a> Sema<'a> {
    /// The text of a place in the sources.
    fn text(&self, at: SourcePlace) -> &'a str {
        let sources: &'a [SourceFile] = self.sources;
        let text = sources.get(usize::from(at.file)).map_or("", |source| source.text.as_str());
        text.get(at.start as usize..at.end as usize).unwrap_or("")
    }

    /// A name as it is written.
    fn shown(&self, name: Name) -> &'a str {
        self.text(name.at)
    }

    /// Code of every callable.
    fn bodies(&mut self) -> Vec<UnitTree> {
        let mut units = Vec::with_capacity(self.callables.len());
        for place in 0..self.callables.len() as u32 {
            units.push(self.body(place));
        }
        units
    }

    fn body(&mut self, place: u32) -> UnitTree {
        let Some(callable) = self.callables.get(place as usize) else { return UnitTree::default() };
        let (body, end, name) = (callable.body, callable.end, callable.shown.clone());
        self.context = ScopeContext {
            callable: Some(place),
            pou: callable.owner,
            frame: callable.frame.clone(),
            loops: 0,
            constant: false,
        };
        if callable.modifiers.is_abstract && !body.is_empty() {
            let message = format!("`{name}` is ABSTRACT: it has no statements");
            let at = callable.name.at;
            if callable.kind == scope::CallableKind::Method {
                self.findings.error(
                    crate::codes::Code::Section,
                    at,
                    message,
                    "remove ABSTRACT or the statements",
                );
            }
        }
        let mut statements = self.prologue(place);
        statements.extend(self.statements(body));
        let context = std::mem::take(&mut self.context);
        UnitTree { name, file: end.file, frame: context.frame, body: statements, end }
    }

    fn finish(&mut self, units: Vec<UnitTree>, initial: Option<u16>) -> Tree {
        let programs: Vec<u32> = (0..self.pous.len() as u32)
            .filter(|place| self.pous[*place as usize].ast.kind == ast::PouKind::Program)
            .collect();
        if programs.is_empty() && !self.options.library && !self.findings.failed() {
            let at = SourcePlace::default();
            let message = "the sources have no PROGRAM";
            let help = "a task runs programs: write PROGRAM name ... END_PROGRAM";
            self.findings.error(crate::codes::Code::NoProgram, at, message, help);
        }
        let tasks = self.tasks(&programs);
        if units.len() > usize::from(u16::MAX) {
            let message = format!("the sources have {} units", units.len());
            self.findings.error(
                crate::codes::Code::Length,
                SourcePlace::default(),
                message,
                "65535 are too many",
            );
        }
        self.retained.sort_by_key(|kept| kept.address);
        // The image carries eight bytes of its own.
        if self.kept > 0 && self.kept + 8 > self.options.limits.retained as u64 {
            let message = format!("the retained variables need {} bytes", self.kept + 8);
            let help = format!("the controller keeps {}", self.options.limits.retained);
            self.findings.error(crate::codes::Code::RetainedSize, SourcePlace::default(), message, help);
        }
        let kinds = self
            .kinds
            .iter()
            .map(|kind| match kind {
                scope::SymbolKind::Block(place) => self.pous[*place as usize].shown.clone(),
                scope::SymbolKind::Interface(place) => self.interfaces[*place as usize].shown.clone(),
            })
            .collect();
        Tree {
            makers: units.len() - self.makers.len() - usize::from(initial.is_some())..units.len(),
            initial,
            units,
            programs: programs.iter().map(|place| self.pous[*place as usize].callable as u16).collect(),
            program_names: programs.iter().map(|place| self.pous[*place as usize].shown.clone()).collect(),
            classes: self.classes(),
            kinds,
            natives: self.options.blocks.iter().collect(),
            variables: std::mem::take(&mut self.data),
            retained: std::mem::take(&mut self.retained),
            located: std::mem::take(&mut self.located),
            roots: std::mem::take(&mut self.roots),
            shapes: std::mem::take(&mut self.shapes),
            tasks,
            pins: std::mem::take(&mut self.pins),
            images: std::mem::take(&mut self.image_places).into_iter().map(image_place).collect(),
            lreal: self.lreal.map(|at| (at.file, at.start as usize..at.end as usize)),
        }
    }

    /// Room for a variable in the data.
    fn allocate(&mut self, bytes: &[u8], align: u32) -> u32 {
        let first = crate::code::map::FIRST as usize;
        let at = (first + self.data.len()).next_multiple_of(align.max(1) as usize);
        self.data.resize(at - first, 0);
        self.data.extend_from_slice(bytes);
        at as u32
    }

    /// Whether there is room for so many more bytes of variables; reports where not.
    fn has_room(&mut self, bytes: u32, at: SourcePlace) -> bool {
        let room = (self.options.limits.memory as usize).saturating_sub(self.data.len());
        if bytes as usize <= room {
            return true;
        }
        let message = format!("the variables need more than {} bytes", self.options.limits.memory);
        self.findings.error(crate::codes::Code::DataSize, at, message, "use smaller arrays");
        false
    }
}

impl Sema<'_> {
    /// Whether there is room for so many more bytes of the initial images of types, blocks and frames, which stand beside
    /// each other while a program is compiled; reports the first that has none. Each of them alone may be as large as
    /// the memory of all variables.
    fn has_image_room(&mut self, bytes: u32, at: SourcePlace) -> bool {
        if self.images > MOST_IMAGES {
            return false;
        }
        self.images = self.images.saturating_add(u64::from(bytes));
        if self.images <= MOST_IMAGES {
            return true;
        }
        let message = format!("the types and blocks need more than {MOST_IMAGES} bytes together");
        self.findings.error(
            crate::codes::Code::DataSize,
            at,
            message,
            "use smaller arrays, or fewer types with them",
        );
        false
    }
}

/// A place of the images as the program lists it.
fn image_place(((address, bits), at): ((Address, u32), SourcePlace)) -> ImagePlace {
    ImagePlace { address, bits, file: at.file, span: at.start as usize..at.end as usize }
}

/// Whether a section's variables are seen from outside of the block.
fn is_pin(kind: SectionKind) -> bool {
    matches!(kind, SectionKind::Input | SectionKind::Output | SectionKind::InOut)
}

/// Sections with those of constants first: bounds and lengths may name constants that are declared further down.
fn constants_first<'a>(sections: impl Iterator<Item = &'a ast::Section>) -> Vec<&'a ast::Section> {
    let (mut first, others): (Vec<_>, Vec<_>) =
        sections.partition(|section| section.constant && !is_pin(section.kind));
    first.extend(others);
    first
}

const fn is_wrong(ty: TypeId) -> bool {
    ty.0 == WRONG.0
}
