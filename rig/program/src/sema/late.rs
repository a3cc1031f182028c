//! What makes an instance before the first cycle beyond its initial bytes: initial values that are addresses, and
//! FB_Init with what the declaration gives it. It becomes code, which runs once when the program has been compiled;
//! what it leaves after are the initial values of the program.

use super::Sema;
use super::scope::{Callable, CallableKind, Home, ScopeSymbol};
use super::types::{Type, TypeId, elements, stride};
use crate::codes::Code;
use crate::findings::SourcePlace;
use crate::parse::ast::{self, Argument, Key, PouKind, SectionKind};
use crate::tree::{
    Callee, Expr, ExprKind, Stmt, StmtKind, Target, TreeCall, TreePlace, TreeRoot, Ty, UnitTree,
};

/// Statements that make all instances of one unit.
const MOST_STATEMENTS: usize = 100_000;

/// An initial value that is known only when everything has its place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Late<'a> {
    /// Of the instance, or the address of the variable.
    pub offset: u32,
    pub ty: TypeId,
    pub value: &'a ast::Expr,
}

/// Where the image that is being written stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LateBase {
    /// In no instance: constants and defaults of types.
    None,
    /// At the start of an instance of this block.
    Block(u32),
    /// At an address.
    At(u32),
}

impl<'a> Sema<'a> {
    /// Takes an initial value that has to wait; FALSE where it is a constant or has to be one.
    pub(super) fn wait_for(&mut self, value: &'a ast::Expr, ty: TypeId, offset: u32) -> bool {
        let waits = self.is_address(ty) || self.takes_address(value) || self.of_constants(value);
        if !waits || self.base == LateBase::None || self.is_constant_expr(value) {
            return false;
        }
        match self.base {
            LateBase::Block(place) => {
                self.pous[place as usize].late.push(Late { offset, ty, value });
            }
            LateBase::At(base) => {
                let pou = self.context.pou;
                self.late.push((pou, Late { offset: base + offset, ty, value }));
            }
            LateBase::None => {}
        }
        true
    }

    /// Whether a value is made of constants and of members of constant structures: libraries keep their settings so.
    fn of_constants(&self, value: &ast::Expr) -> bool {
        match &value.kind {
            ast::ExprKind::Name(name) => {
                self.find(name.key).is_none_or(|found| self.is_constant_symbol(found))
            }
            ast::ExprKind::Member(of, _) => self.of_constants(of),
            ast::ExprKind::Index(of, indices) => {
                self.of_constants(of) && indices.iter().all(|index| self.of_constants(index))
            }
            ast::ExprKind::Unary(_, of) => self.of_constants(of),
            ast::ExprKind::Chain(first, rest) => {
                self.of_constants(first) && rest.iter().all(|(_, _, e)| self.of_constants(e))
            }
            _ => self.is_constant_expr(value),
        }
    }

    /// Whether something in an initial value may have to wait, by its looks.
    pub(super) fn is_late(&self, initial: &ast::Initializer) -> bool {
        match initial {
            ast::Initializer::One(value) => !self.is_constant_expr(value),
            ast::Initializer::List(list, _) => list.iter().any(|(_, value)| self.is_late(value)),
            ast::Initializer::Members(members, _) => members.iter().any(|(_, value)| self.is_late(value)),
        }
    }

    /// Whether ADR or REF is called in an expression.
    fn takes_address(&self, value: &ast::Expr) -> bool {
        match &value.kind {
            ast::ExprKind::Call(callee, _) => self.is_address_call(callee),
            ast::ExprKind::Unary(_, of) => self.takes_address(of),
            ast::ExprKind::Chain(first, rest) => {
                self.takes_address(first) || rest.iter().any(|(_, _, e)| self.takes_address(e))
            }
            _ => false,
        }
    }

    /// Whether a variable of a type needs more than its initial bytes.
    fn is_made(&mut self, ty: TypeId) -> bool {
        match self.ty(ty).clone() {
            Type::Array { of, .. } => self.is_made(of),
            Type::Structure(place) => {
                let fields: Vec<TypeId> = self
                    .structures
                    .get(place as usize)
                    .map_or(Vec::new(), |s| s.fields.iter().map(|field| field.ty).collect());
                fields.into_iter().any(|ty| self.is_made(ty))
            }
            Type::Block(place) => self.maker(place).is_some() || self.constructors(place).next().is_some(),
            _ => false,
        }
    }

    /// FB_Init of a block and of those that it extends, those first.
    fn constructors(&self, block: u32) -> impl Iterator<Item = u32> + use<'a> {
        let key = self.names.get("FB_INIT");
        let lineage: Vec<u32> = self.lineage(block).collect();
        let of = |owner: u32| self.pous.get(owner as usize)?.methods.get(&key?).copied();
        let found: Vec<u32> = lineage.into_iter().rev().filter_map(of).collect();
        found.into_iter()
    }

    /// The unit that makes instances of a block, where there is something to do.
    fn maker(&mut self, block: u32) -> Option<u16> {
        if let Some(known) = self.pous.get(block as usize)?.maker {
            return known;
        }
        // Blocks do not contain themselves: this ends.
        let base = self.pous[block as usize].base;
        let inherited = base.is_some_and(|base| self.maker(base).is_some());
        let members: Vec<TypeId> = self.pous[block as usize]
            .symbols
            .iter()
            .filter(|symbol| matches!(symbol.home, Home::This(_)))
            .map(ScopeSymbol::type_id)
            .collect();
        let own = !self.pous[block as usize].late.is_empty()
            || members.into_iter().any(|ty| self.is_made(ty))
            || self.pous[block as usize].symbols.iter().any(|symbol| symbol.decl.built.is_some());
        let unit = (inherited || own).then(|| (self.callables.len() + self.makers.len()) as u16);
        if unit.is_some() {
            self.makers.push(Some(block));
        }
        self.pous[block as usize].maker = Some(unit);
        unit
    }

    /// The code that makes everything, after the units of the sources; its last unit is to be run.
    pub(super) fn making(&mut self, units: &mut Vec<UnitTree>) -> Option<u16> {
        let mut statements = Vec::new();
        let mut frame = Vec::new();
        for (pou, symbols) in self.lasting() {
            self.context = super::ScopeContext { pou, frame, ..Default::default() };
            for symbol in symbols {
                if let Home::Absolute(address) = symbol.home {
                    self.made_variable(&symbol, (TreeRoot::Absolute, address), &mut statements);
                }
            }
            frame = std::mem::take(&mut self.context).frame;
        }
        for (pou, late) in std::mem::take(&mut self.late) {
            self.context = super::ScopeContext { pou, frame, ..Default::default() };
            let place = self.place(TreeRoot::Absolute, late.offset, late.ty, false, late.value.at);
            self.assign_late(&late, place, &mut statements);
            frame = std::mem::take(&mut self.context).frame;
        }
        // Found by number: making one may ask for others.
        let mut next = 0;
        while let Some(Some(block)) = self.makers.get(next).copied() {
            units.push(self.maker_unit(block));
            next += 1;
        }
        if statements.is_empty() {
            return None;
        }
        units.push(UnitTree {
            name: "(initial values)".to_owned(),
            file: 0,
            frame,
            body: statements,
            end: SourcePlace::default(),
        });
        Some((units.len() - 1) as u16)
    }

    /// Variables that are there from the start: those of programs, the global ones, VAR_STAT.
    fn lasting(&self) -> Vec<(Option<u32>, Vec<ScopeSymbol<'a>>)> {
        let mut all = vec![(None, self.globals.clone())];
        for (place, pou) in (0u32..).zip(&self.pous) {
            let program = pou.ast.kind == PouKind::Program;
            let lasting = pou.symbols.iter().filter(|s| program || s.kind == SectionKind::Static);
            all.push((Some(place), lasting.cloned().collect()));
        }
        for callable in &self.callables {
            let lasting = callable.symbols.iter().filter(|s| s.kind == SectionKind::Static);
            all.push((callable.owner, lasting.cloned().collect()));
        }
        all
    }

    fn maker_unit(&mut self, block: u32) -> UnitTree {
        let (shown, at, base) = {
            let pou = &self.pous[block as usize];
            (pou.shown.clone(), pou.ast.end, pou.base)
        };
        self.context = super::ScopeContext { pou: Some(block), ..Default::default() };
        let mut statements = Vec::new();
        if let Some(unit) = base.and_then(|base| self.maker(base)) {
            statements.push(called(Callee::Same(unit), at));
        }
        let late = std::mem::take(&mut self.pous[block as usize].late);
        let symbols = self.pous[block as usize].symbols.clone();
        for symbol in symbols {
            let Home::This(offset) = symbol.home else { continue };
            let end = offset + self.layout(symbol.type_id()).size;
            for late in late.iter().filter(|late| (offset..end).contains(&late.offset)) {
                let place = self.place(TreeRoot::This, late.offset, late.ty, false, late.value.at);
                self.assign_late(late, place, &mut statements);
            }
            self.made_variable(&symbol, (TreeRoot::This, offset), &mut statements);
        }
        let context = std::mem::take(&mut self.context);
        let name = format!("{shown} (initial values)");
        UnitTree { name, file: at.file, frame: context.frame, body: statements, end: at }
    }

    fn assign_late(&mut self, late: &Late<'a>, place: TreePlace, statements: &mut Vec<Stmt>) {
        if let Some(value) = self.value(late.value, late.ty) {
            // A reference is given what it refers to: it is an address in memory.
            let ty = value.ty;
            let kind = StmtKind::Assign(Target::Place(TreePlace { ty, ..place }), value);
            statements.push(Stmt { kind, at: late.value.at });
        }
    }

    /// Makes the instances in one variable.
    pub(super) fn made_variable(
        &mut self,
        symbol: &ScopeSymbol<'a>,
        to: (TreeRoot, u32),
        statements: &mut Vec<Stmt>,
    ) {
        let ty = symbol.type_id();
        let built = symbol.decl.built.as_ref();
        if let Some(built) = built {
            let block = match self.ty(ty).clone() {
                Type::Array { of, .. } => self.ty(of).clone(),
                other => other,
            };
            let takes = match block {
                Type::Block(block) => self.constructors(block).next().is_some(),
                _ => false,
            };
            // Empty brackets give nothing.
            let given = built.lists.iter().any(|list| !list.is_empty());
            if given && !takes && !super::is_wrong(ty) {
                let message = format!("{} has no FB_Init that takes these", self.type_name(ty));
                let help = "give initial values to the inputs, as in t : TON := (PT := T#1s)";
                self.findings.error(Code::UnknownParameter, built.at, message, help);
                return;
            }
        }
        if self.is_made(ty) {
            self.made(symbol, ty, to, None, statements);
        }
    }

    /// Makes what stands at a place of a variable; `nth` counts the elements of an array.
    fn made(
        &mut self,
        symbol: &ScopeSymbol<'a>,
        ty: TypeId,
        (root, offset): (TreeRoot, u32),
        nth: Option<usize>,
        statements: &mut Vec<Stmt>,
    ) {
        let at = symbol.name.at;
        if statements.len() > MOST_STATEMENTS {
            let message = format!("`{}` has too many instances to make", symbol.shown);
            self.findings.error(Code::Length, at, message, "use smaller arrays");
            return;
        }
        match self.ty(ty).clone() {
            Type::Array { dimensions, of } => {
                let step = stride(self.layout(of));
                for element in 0..elements(&dimensions) {
                    let to = (root.clone(), offset + element as u32 * step);
                    self.made(symbol, of, to, Some(element as usize), statements);
                    if self.findings.failed() || statements.len() > MOST_STATEMENTS {
                        break;
                    }
                }
            }
            Type::Structure(place) => {
                let fields: Vec<(TypeId, u32)> = self
                    .structures
                    .get(place as usize)
                    .map_or(Vec::new(), |s| s.fields.iter().map(|f| (f.ty, f.offset)).collect());
                for (ty, inner) in fields {
                    if self.is_made(ty) {
                        self.made(symbol, ty, (root.clone(), offset + inner), None, statements);
                    }
                }
            }
            Type::Block(block) => {
                let place = self.place(root, offset, ty, false, at);
                if let Some(unit) = self.maker(block) {
                    statements.push(called(Callee::Of(unit, place.clone()), at));
                }
                let list = match &symbol.decl.built {
                    Some(built) if built.each => built.lists.get(nth.unwrap_or(0)),
                    Some(built) => built.lists.first(),
                    None => None,
                };
                let at = symbol.decl.built.as_ref().map_or(at, |built| built.at);
                let arguments = list.map_or(&[][..], Vec::as_slice);
                self.construct(block, &place, arguments, at, statements);
            }
            _ => {}
        }
    }

    /// Calls FB_Init of a block, and before it those of what it extends with the arguments that they know.
    fn construct(
        &mut self,
        block: u32,
        place: &TreePlace,
        arguments: &[Argument],
        at: SourcePlace,
        statements: &mut Vec<Stmt>,
    ) {
        let constructors: Vec<u32> = self.constructors(block).collect();
        let last = constructors.last().copied();
        for constructor in constructors {
            let Some(callable) = self.callables.get(constructor as usize).cloned() else { continue };
            let parameters = self.frame_parameters(&callable);
            let implied = |key: Key| match self.names.key_text(key) {
                "BINITRETAINS" => Some(true),
                "BINCOPYCODE" => Some(false),
                _ => None,
            };
            let own: Vec<_> = parameters
                .iter()
                .filter(|p| p.kind == SectionKind::Input && implied(p.key).is_none())
                .collect();
            let mut given: Vec<Argument> = parameters
                .iter()
                .filter_map(|p| Some((p, implied(p.key)?)))
                .map(|(p, value)| {
                    let value = ast::Expr { kind: ast::ExprKind::Bool(value), at };
                    Argument::Input(ast::Name { key: p.key, at }, value)
                })
                .collect();
            let mut positional = own.iter();
            for argument in arguments {
                let name = match argument {
                    Argument::Positional(value) => match positional.next() {
                        Some(p) => ast::Name { key: p.key, at: value.at },
                        None => ast::Name { key: callable.name.key, at: value.at },
                    },
                    Argument::Input(name, _) | Argument::Empty(name) => *name,
                    Argument::Output { name, .. } => *name,
                };
                if Some(constructor) != last && own.iter().all(|p| p.key != name.key) {
                    continue;
                }
                given.push(match argument {
                    Argument::Positional(value) => Argument::Input(name, value.clone()),
                    other => other.clone(),
                });
            }
            let named =
                |key: Key| given.iter().any(|a| matches!(a, Argument::Input(name, _) if name.key == key));
            let missing: Vec<&str> =
                own.iter().filter(|p| !p.optional && !named(p.key)).map(|p| p.shown.as_str()).collect();
            if !missing.is_empty() {
                let message = format!("`{}` needs a value for {}", callable.shown, missing.join(", "));
                let help = "give it where the instance is declared, as in name : block(level := 1)";
                self.findings.error(Code::Arguments, at, message, help);
                return;
            }
            let shown = callable.shown.clone();
            if let Some((inputs, outputs)) = self.arguments(&shown, &parameters, &given, None, at) {
                let callee = Callee::Of(constructor as u16, place.clone());
                let result = callable.result.map(|_| 0);
                let ty = callable.result.map_or(Ty::Block { bytes: 0 }, |ty| self.tree_type(ty));
                let call = TreeCall { callee, inputs, outputs, result, at };
                let call = Expr { kind: ExprKind::Call(Box::new(call)), ty, at };
                statements.push(Stmt { kind: StmtKind::Call(Box::new(call)), at });
            }
        }
    }

    /// What a method with a name of its own for the tool needs to be said of.
    pub(super) fn check_hook(&mut self, method: &Callable<'a>) {
        let name = method.name;
        if method.kind == CallableKind::Method
            && matches!(self.names.key_text(name.key), "FB_EXIT" | "FB_REINIT")
        {
            let message = format!("`{}` is never called by itself here", self.shown(name));
            let help = "instances live as long as the program; FB_Init is called before the first cycle";
            self.findings.warning(Code::Lifecycle, name.at, message, help);
        }
    }
}

/// A call without parameters.
fn called(callee: Callee, at: SourcePlace) -> Stmt {
    let call = TreeCall { callee, inputs: Vec::new(), outputs: Vec::new(), result: None, at };
    let call = Expr { kind: ExprKind::Call(Box::new(call)), ty: Ty::Block { bytes: 0 }, at };
    Stmt { kind: StmtKind::Call(Box::new(call)), at }
}
