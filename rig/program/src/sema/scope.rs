//! What names mean inside units, and what can be called.

use super::types::TypeId;
use super::{KeyMap, Sema, State};
use crate::findings::SourcePlace;
use crate::parse::ast::{self, Key, Modifiers, Name, Section, SectionKind};
use crate::program::Retention;
use crate::tree::Ty;

/// Where a variable is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Home {
    /// Not known yet, or wrong.
    Nowhere,
    Absolute(u32),
    This(u32),
    Frame(u32),
    /// The address of the variable stands there.
    ThisAddress(u32),
    FrameAddress(u32),
    AbsoluteAddress(u32),
    /// A bit of the byte at an address.
    Bit(u32, u32),
}

/// A variable or a constant.
#[derive(Clone, Debug)]
pub(super) struct ScopeSymbol<'a> {
    pub name: Name,
    pub shown: &'a str,
    pub kind: SectionKind,
    pub decl: &'a ast::VarDecl,
    pub retention: Retention,
    pub constant: bool,
    pub ty: State<TypeId>,
    pub home: Home,
    /// Of an input that detects edges: where the block keeps the edge, and after it what the input was.
    pub edge: Option<u32>,
    /// Cell of a constant of a scalar type.
    pub value: State<Option<i64>>,
}

impl ScopeSymbol<'_> {
    pub(super) fn type_id(&self) -> TypeId {
        match self.ty {
            State::Done(ty) => ty,
            _ => super::types::WRONG,
        }
    }

    /// Whether it stands for one value, known when the program is compiled. A parameter that is CONSTANT is only
    /// read.
    pub(super) fn is_value(&self) -> bool {
        self.constant && !super::is_pin(self.kind)
    }

    pub(super) fn given(&self) -> bool {
        self.decl.initial.is_some()
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum SelectorKind {
    Method,
    Get,
    Set,
}

/// The name under which a method is chosen at run time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct MethodSelector {
    pub key: Key,
    pub kind: SelectorKind,
}

/// What an object can be asked to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SymbolKind {
    Block(u32),
    Interface(u32),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CallableKind {
    Function,
    /// The body of a program or block.
    Body,
    Method,
    Getter,
    Setter,
    Action,
}

/// A piece of code with its parameters: its place is that of the unit in the tree.
#[derive(Clone, Debug)]
pub(super) struct Callable<'a> {
    pub kind: CallableKind,
    pub shown: String,
    pub name: Name,
    /// The block or program it belongs to; `None` for functions and heads of interfaces.
    pub owner: Option<u32>,
    pub modifiers: Modifiers,
    pub sections: &'a [Section],
    pub body: &'a [ast::Stmt],
    pub end: SourcePlace,
    pub result_ref: Option<&'a ast::TypeRef>,
    pub result: Option<TypeId>,
    /// Variables of the frame, parameters among them, in order.
    pub symbols: Vec<ScopeSymbol<'a>>,
    pub index: KeyMap<Key, u32>,
    /// VAR_INST of a method: places among the members of its block.
    pub kept: KeyMap<Key, u32>,
    /// Initial bytes of the frame.
    pub frame: Vec<u8>,
    pub selector: Option<u32>,
}

impl<'a> Callable<'a> {
    pub(super) fn new(kind: CallableKind, shown: String, name: Name, end: SourcePlace) -> Self {
        Callable {
            kind,
            shown,
            name,
            owner: None,
            modifiers: Modifiers::default(),
            sections: &[],
            body: &[],
            end,
            result_ref: None,
            result: None,
            symbols: Vec::new(),
            index: KeyMap::default(),
            kept: KeyMap::default(),
            frame: Vec::new(),
            selector: None,
        }
    }
}

/// A unit at the outside.
pub(super) struct Pou<'a> {
    pub ast: &'a ast::Pou,
    pub shown: String,
    /// The function, or the body.
    pub callable: u32,
    pub base: Option<u32>,
    pub interfaces: Vec<u32>,
    /// Members of the instance, own ones only.
    pub symbols: Vec<ScopeSymbol<'a>>,
    pub index: KeyMap<Key, u32>,
    /// Methods and actions by name, accessors by name: places in `Sema::callables`, own ones only.
    pub methods: KeyMap<Key, u32>,
    pub getters: KeyMap<Key, u32>,
    pub setters: KeyMap<Key, u32>,
    pub actions: KeyMap<Key, u32>,
    /// The tree's class, of blocks.
    pub class: u32,
    /// Bytes of an instance with their initial values.
    pub size: u32,
    pub image: Vec<u8>,
    /// Levels of what it contains.
    pub depth: u32,
    pub state: State<()>,
    /// Initial values of members that wait until everything has its place.
    pub late: Vec<super::late::Late<'a>>,
    /// The unit that makes its instances, once that was asked for.
    pub maker: Option<Option<u16>>,
}

/// Where the walk through the bodies is.
#[derive(Debug, Default)]
pub(super) struct ScopeContext {
    pub callable: Option<u32>,
    pub pou: Option<u32>,
    /// Bytes of the frame, which hidden variables make longer.
    pub frame: Vec<u8>,
    pub loops: u32,
    /// Only constants are allowed, no code.
    pub constant: bool,
}

/// What a name is found to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FoundName {
    /// A variable of the running unit's frame: its place there.
    Local(u32),
    /// A member: the block that declares it, its place there.
    Member(u32, u32),
    Global(u32),
    Pou(u32),
    Type(u32),
    Interface(u32),
    Native(u16),
    Method(u32),
    Action(u32),
    /// A property of the running block.
    Property,
    Enumerator(TypeId, i64),
    /// Several enumerations have it.
    Ambiguous,
    /// The result of the running function, method or getter.
    Result,
}

impl<'a> Sema<'a> {
    /// What a name means where the walk is, from the inside out.
    pub(super) fn find(&self, key: Key) -> Option<FoundName> {
        if let Some(callable) = self.context.callable.and_then(|place| self.callables.get(place as usize)) {
            if let Some(place) = callable.index.get(&key) {
                return Some(FoundName::Local(*place));
            }
            if let (Some(owner), Some(place)) = (callable.owner, callable.kept.get(&key)) {
                return Some(FoundName::Member(owner, *place));
            }
            if callable.name.key == key && callable.result.is_some() {
                return Some(FoundName::Result);
            }
        }
        if let Some(found) = self.context.pou.and_then(|pou| self.find_in_pou(pou, key)) {
            return Some(found);
        }
        self.find_outside(key)
    }

    fn find_in_pou(&self, pou: u32, key: Key) -> Option<FoundName> {
        if let Some((owner, place)) = self.member(pou, key) {
            return Some(FoundName::Member(owner, place));
        }
        if let Some(method) = self.method(pou, key) {
            return Some(FoundName::Method(method));
        }
        if let Some(action) = self.action(pou, key) {
            return Some(FoundName::Action(action));
        }
        if self
            .accessor(pou, key, SelectorKind::Get)
            .or_else(|| self.accessor(pou, key, SelectorKind::Set))
            .is_some()
        {
            return Some(FoundName::Property);
        }
        None
    }

    /// What a name means at the outside.
    pub(super) fn find_outside(&self, key: Key) -> Option<FoundName> {
        match self.outside.get(&key) {
            Some(super::Global::Variable(place)) => return Some(FoundName::Global(*place)),
            Some(super::Global::Pou(place)) => return Some(FoundName::Pou(*place)),
            Some(super::Global::Type(place)) => return Some(FoundName::Type(*place)),
            Some(super::Global::Interface(place)) => return Some(FoundName::Interface(*place)),
            None => {}
        }
        if let Some(native) = self.native_index.get(&key) {
            return Some(FoundName::Native(*native));
        }
        match self.enumerators.get(&key).map(Vec::as_slice) {
            Some([(ty, cell)]) => Some(FoundName::Enumerator(*ty, *cell)),
            Some([_, ..]) => Some(FoundName::Ambiguous),
            _ => None,
        }
    }

    /// The pous from this one through those it extends.
    pub(super) fn lineage(&self, pou: u32) -> impl Iterator<Item = u32> + '_ {
        let next = |place: &u32| self.pous.get(*place as usize).and_then(|pou| pou.base);
        // A circle of EXTENDS was reported; here it must only come to an end.
        std::iter::successors(Some(pou), next).take(1 + self.pous.len())
    }

    /// A member of an instance, own or inherited: the block that declares it and the place there.
    pub(super) fn member(&self, pou: u32, key: Key) -> Option<(u32, u32)> {
        self.lineage(pou).find_map(|owner| {
            let place = self.pous.get(owner as usize)?.index.get(&key)?;
            Some((owner, *place))
        })
    }

    pub(super) fn method(&self, pou: u32, key: Key) -> Option<u32> {
        self.lineage(pou).find_map(|owner| self.pous.get(owner as usize)?.methods.get(&key).copied())
    }

    pub(super) fn action(&self, pou: u32, key: Key) -> Option<u32> {
        self.lineage(pou).find_map(|owner| self.pous.get(owner as usize)?.actions.get(&key).copied())
    }

    pub(super) fn accessor(&self, pou: u32, key: Key, kind: SelectorKind) -> Option<u32> {
        self.lineage(pou).find_map(|owner| {
            let pou = self.pous.get(owner as usize)?;
            match kind {
                SelectorKind::Get => pou.getters.get(&key).copied(),
                SelectorKind::Set => pou.setters.get(&key).copied(),
                SelectorKind::Method => None,
            }
        })
    }

    pub(super) fn member_symbol(&self, owner: u32, place: u32) -> Option<&ScopeSymbol<'a>> {
        self.pous.get(owner as usize)?.symbols.get(place as usize)
    }

    /// Room in the running unit's frame for a value without a name.
    pub(super) fn hidden(&mut self, ty: Ty) -> u32 {
        let at = self.context.frame.len().next_multiple_of(ty.align().max(1) as usize);
        self.context.frame.resize(at + ty.bytes() as usize, 0);
        at as u32
    }
}
