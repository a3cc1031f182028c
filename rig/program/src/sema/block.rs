//! Where the members of blocks and programs and the global variables stand.

use super::declare::initial_at;
use super::late::LateBase;
use super::scope::{Home, ScopeSymbol};
use super::types::{Type, TypeId, WRONG, elements, stride};
use super::{Sema, State};
use crate::code::map;
use crate::codes::Code;
use crate::findings::{SourcePlace, count};
use crate::parse::ast::{self, Section, SectionKind};
use crate::program::{Located, ProgramPin, Retained, Retention};
use crate::shape::{Member, Root};
use signal::{Address, Area, Size};

/// The number of an instance's class stands in its first bytes.
const HEADER: u32 = 4;

impl<'a> Sema<'a> {
    /// Lays a block out; FALSE where it is in the middle of that: it contains itself.
    pub(super) fn resolve_block(&mut self, place: u32) -> bool {
        match self.pous.get(place as usize).map(|pou| pou.state) {
            Some(State::Untouched) => {}
            Some(State::Busy) => return false,
            _ => return true,
        }
        if self.depth >= super::TYPE_DEPTH {
            let at = self.pous[place as usize].ast.name.at;
            let message = "blocks extend each other too deeply";
            self.findings.error(Code::Depth, at, message, "use fewer levels");
            return true;
        }
        self.depth += 1;
        self.pous[place as usize].state = State::Busy;
        let outer = std::mem::take(&mut self.context);
        self.context.pou = Some(place);
        self.context.constant = true;
        let base = self.pous[place as usize].base;
        let mut image = Vec::new();
        if let Some(base) = base {
            let closed = self.resolve_block(base);
            self.pous[place as usize].depth = self.pous[base as usize].depth;
            if closed {
                image = self.pous[base as usize].image.clone();
            }
        }
        image.resize(image.len().max(HEADER as usize), 0);
        let class = self.pous[place as usize].class + 1;
        if let Some(header) = image.first_chunk_mut::<4>() {
            *header = class.to_le_bytes();
        }
        let size = self.members(place, image.len() as u32);
        self.pous[place as usize].size = size;
        let at = self.pous[place as usize].ast.name.at;
        if self.has_image_room(size, at) {
            image.resize(size as usize, 0);
            self.member_initials(place, &mut image, 0);
        }
        self.pous[place as usize].image = image;
        self.pous[place as usize].state = State::Done(());
        self.context = outer;
        self.depth -= 1;
        true
    }

    /// The same for a program, of which there is one instance, in the data.
    pub(super) fn resolve_program(&mut self, place: u32) {
        self.pous[place as usize].state = State::Busy;
        let outer = std::mem::take(&mut self.context);
        self.context.pou = Some(place);
        self.context.constant = true;
        let size = self.members(place, 0);
        self.pous[place as usize].size = size;
        let at = self.pous[place as usize].ast.name.at;
        if self.has_room(size, at) {
            let base = self.allocate(&vec![0; size as usize], 8);
            for symbol in &mut self.pous[place as usize].symbols {
                symbol.home = match symbol.home {
                    Home::This(offset) => Home::Absolute(base + offset),
                    Home::ThisAddress(offset) => Home::AbsoluteAddress(base + offset),
                    home => home,
                };
            }
            let mut image = vec![0; size as usize];
            self.member_initials(place, &mut image, base);
            let from = (base - map::FIRST) as usize;
            if let Some(room) = self.data.get_mut(from..from + size as usize) {
                room.copy_from_slice(&image);
            }
            let members = self.instance_members(place);
            let members =
                members.into_iter().map(|m| Member { offset: m.offset - base, ..m }).collect::<Vec<_>>();
            let path = self.pous[place as usize].shown.clone();
            let shape = crate::shape::ShapeId(self.shapes.len() as u32);
            self.shapes.push(crate::shape::MemoryLayout::Members {
                name: path.clone(),
                members,
                size: size.max(1),
                block: true,
            });
            self.roots.push(Root { path: path.clone(), shape, address: base, bit: 0, file: at.file });
            for nth in 0..self.pous[place as usize].symbols.len() {
                let symbol = &self.pous[place as usize].symbols[nth];
                let (name, ty, home, retention) =
                    (symbol.shown, symbol.type_id(), symbol.home, symbol.retention);
                if matches!(symbol.kind, SectionKind::Input | SectionKind::Output) && !symbol.constant {
                    let is_input = symbol.kind == SectionKind::Input;
                    let ty = match self.ty(ty) {
                        Type::Elementary(ty) => Some(*ty),
                        _ => None,
                    };
                    let path = format!("{path}.{name}");
                    self.pins.push(ProgramPin { name: name.to_owned(), path, is_input, ty });
                }
                self.locate_root(&format!("{path}.{name}"), ty, home, at.file);
                if let Home::Absolute(address) = home
                    && address < map::OWN_END
                {
                    self.retain(ty, address, retention);
                }
            }
        }
        self.pous[place as usize].state = State::Done(());
        self.context = outer;
    }

    /// Gives every member of a block or program its offset from `size` on; the size with them.
    fn members(&mut self, place: u32, mut size: u32) -> u32 {
        let pou = self.pous[place as usize].ast;
        let own = super::constants_first(pou.sections.iter());
        let mut sections: Vec<(Option<u32>, &'a Section)> = own.into_iter().map(|own| (None, own)).collect();
        // Variables of methods that live with the instance; only their method knows their names.
        for method in &pou.methods {
            let callable = self.pous[place as usize].methods.get(&method.name.key).copied();
            let instance = method.sections.iter().filter(|section| section.kind == SectionKind::Instance);
            sections.extend(instance.map(|section| (callable, section)));
        }
        for (method, section) in sections {
            match section.kind {
                SectionKind::Temp => continue,
                SectionKind::External => {
                    self.check_external(section);
                    continue;
                }
                SectionKind::Global => {
                    let message = "VAR_GLOBAL stands outside of units";
                    self.findings.error(Code::Section, section.at, message, "");
                    continue;
                }
                _ => {}
            }
            for decl in &section.variables {
                let mut symbol = self.symbol(section, decl);
                self.check_name(decl.name);
                if let Some(first) = self.member(place, decl.name.key).filter(|_| {
                    // A method's own name space covers that of its block.
                    section.kind != SectionKind::Instance
                }) {
                    let first = self.member_symbol(first.0, first.1).map_or(decl.name.at, |s| s.name.at);
                    self.twice(decl.name, first);
                    continue;
                }
                // Where a constant is needed for what follows, this one is known by name already.
                let own = self.pous[place as usize].symbols.len() as u32;
                if section.constant && section.kind != SectionKind::Instance {
                    self.pous[place as usize].index.insert(decl.name.key, own);
                    self.pous[place as usize].symbols.push(symbol.clone());
                }
                self.in_out = section.kind == SectionKind::InOut;
                self.any =
                    section.kind == SectionKind::Input && matches!(decl.ty.kind, ast::TypeKind::Named(_));
                let mut ty = self.resolve(&decl.ty);
                (self.in_out, self.any) = (false, false);
                if !self.check_depth(ty, decl.ty.at) {
                    ty = WRONG;
                }
                let depth = 1 + self.type_depth(ty);
                let own_depth = &mut self.pous[place as usize].depth;
                *own_depth = depth.max(*own_depth);
                symbol.ty = State::Done(ty);
                let layout = self.layout(ty);
                if decl.address.is_some() {
                    symbol.home = self.located(decl, section, true, ty);
                } else if section.kind == SectionKind::Static {
                    if self.has_room(layout.size, decl.name.at) {
                        let mut bytes = Vec::new();
                        self.default_bytes(ty, &mut bytes);
                        symbol.home = Home::Absolute(self.allocate(&bytes, layout.align));
                    }
                } else if section.kind == SectionKind::InOut {
                    size = size.next_multiple_of(4);
                    symbol.home = Home::ThisAddress(size);
                    size += self.in_out_size(ty);
                } else {
                    size = size.next_multiple_of(layout.align);
                    symbol.home = Home::This(size);
                    size = size.saturating_add(layout.size);
                    if size > self.options.limits.memory {
                        let message = format!("`{}` needs {size} bytes", self.pous[place as usize].shown);
                        self.findings.error(Code::DataSize, decl.name.at, message, "use smaller arrays");
                        return HEADER;
                    }
                }
                if decl.edge.is_some() && self.check_edge(section, decl, ty, true) {
                    symbol.edge = Some(size);
                    size += 2;
                }
                let pou = &mut self.pous[place as usize];
                match pou.symbols.get_mut(own as usize) {
                    Some(known) => {
                        symbol.value = known.value;
                        *known = symbol;
                    }
                    None => {
                        if section.kind != SectionKind::Instance {
                            pou.index.insert(decl.name.key, own);
                        }
                        pou.symbols.push(symbol);
                        if let Some(method) = method.and_then(|place| self.callables.get_mut(place as usize))
                        {
                            method.kept.insert(decl.name.key, own);
                        }
                    }
                }
            }
        }
        size.next_multiple_of(8)
    }

    /// Initial bytes of the own members; `base` is where the image stands, for a program.
    fn member_initials(&mut self, place: u32, image: &mut [u8], base: u32) {
        for nth in 0..self.pous[place as usize].symbols.len() {
            let Some(symbol) = self.pous[place as usize].symbols.get(nth).cloned() else { continue };
            let offset = match symbol.home {
                Home::This(offset) => offset,
                Home::Absolute(address) if base > 0 && symbol.kind != SectionKind::Static => {
                    match address.checked_sub(base) {
                        Some(offset) if address < map::OWN_END => offset,
                        _ => continue,
                    }
                }
                Home::Absolute(address) if symbol.kind == SectionKind::Static => {
                    self.data_initial(&symbol, address);
                    continue;
                }
                _ => continue,
            };
            let at = if base > 0 { LateBase::At(base) } else { LateBase::Block(place) };
            self.variable_initial(&symbol, image, offset, at);
        }
    }

    /// Default and given initial value of one variable.
    fn variable_initial(&mut self, symbol: &ScopeSymbol<'a>, image: &mut [u8], offset: u32, base: LateBase) {
        let ty = symbol.type_id();
        let mut bytes = Vec::new();
        self.default_bytes(ty, &mut bytes);
        if let Some(room) = image.get_mut(offset as usize..offset as usize + bytes.len()) {
            room.copy_from_slice(&bytes);
        }
        let inherited = self.type_initial(&symbol.decl.ty);
        if let Some(initial) = symbol.decl.initial.as_ref().or(inherited) {
            // Constants have their values before anything has a place.
            let base = if symbol.constant { LateBase::None } else { base };
            let outer = std::mem::replace(&mut self.base, base);
            self.write_initial(ty, initial, image, offset);
            self.base = outer;
        } else {
            self.check_constant(symbol);
        }
    }

    /// The same for a variable in the data.
    pub(super) fn data_initial(&mut self, symbol: &ScopeSymbol<'a>, address: u32) {
        let mut data = std::mem::take(&mut self.data);
        self.variable_initial(symbol, &mut data, address - map::FIRST, LateBase::At(map::FIRST));
        self.data = data;
    }

    /// Places of the global variables, then their initial values.
    pub(super) fn resolve_globals(&mut self) {
        for place in 0..self.globals.len() {
            let ty = self.global_type(place as u32);
            let symbol = self.globals[place].clone();
            let layout = self.layout(ty);
            let home = if symbol.decl.address.is_some() {
                let section = Section {
                    kind: symbol.kind,
                    retention: symbol.retention,
                    constant: symbol.constant,
                    variables: Vec::new(),
                    at: symbol.name.at,
                };
                self.located(symbol.decl, &section, true, ty)
            } else if self.has_room(layout.size, symbol.name.at) {
                let mut bytes = Vec::new();
                self.default_bytes(ty, &mut bytes);
                Home::Absolute(self.allocate(&bytes, layout.align))
            } else {
                Home::Nowhere
            };
            self.globals[place].home = home;
        }
        for place in 0..self.globals.len() {
            let symbol = self.globals[place].clone();
            if let Home::Absolute(address) = symbol.home
                && address < map::OWN_END
            {
                self.data_initial(&symbol, address);
                let shape = self.shape(symbol.type_id());
                let path = symbol.shown.to_string();
                self.roots.push(Root { path, shape, address, bit: 0, file: symbol.name.at.file });
                self.retain(symbol.type_id(), address, symbol.retention);
            } else {
                self.locate_root(symbol.shown, symbol.type_id(), symbol.home, symbol.name.at.file);
            }
        }
    }

    /// A variable at an address is a root of its own.
    fn locate_root(&mut self, path: &str, ty: TypeId, home: Home, file: u16) {
        let (address, bit) = match home {
            Home::Absolute(address) if address >= map::OWN_END => (address, 0),
            Home::Bit(address, bit) => (address, bit as u8),
            _ => return,
        };
        let shape = self.shape(ty);
        self.roots.push(Root { path: path.to_string(), shape, address, bit, file });
    }

    /// Notes which bytes of a variable are kept.
    fn retain(&mut self, ty: TypeId, address: u32, retention: Retention) {
        let full = self.kept > self.options.limits.retained as u64;
        if full || retention == Retention::None && !self.retains(ty) {
            return;
        }
        match self.ty(ty).clone() {
            Type::Block(place) => {
                let lineage: Vec<u32> = self.lineage(place).collect();
                for owner in lineage.into_iter().rev() {
                    let symbols = self.pous.get(owner as usize).map_or(0, |pou| pou.symbols.len());
                    for nth in 0..symbols {
                        let Some(symbol) = self.member_symbol(owner, nth as u32) else { continue };
                        if let Home::This(offset) = symbol.home {
                            let (ty, kept) = (symbol.type_id(), symbol.retention.max(retention));
                            self.retain(ty, address + offset, kept);
                        }
                    }
                }
            }
            Type::Structure(place) => {
                let fields: Vec<(TypeId, u32)> = self
                    .structures
                    .get(place as usize)
                    .map_or(Vec::new(), |s| s.fields.iter().map(|f| (f.ty, f.offset)).collect());
                for (ty, offset) in fields {
                    self.retain(ty, address + offset, retention);
                }
            }
            Type::Array { dimensions, of } => {
                let step = stride(self.layout(of));
                if self.scalar(of).is_some() || matches!(self.ty(of), Type::Text { .. }) {
                    self.keep(address, self.layout(ty).size, retention);
                } else {
                    for nth in 0..elements(&dimensions).min(u64::from(map::OWN_END)) {
                        self.retain(of, address + nth as u32 * step, retention);
                    }
                }
            }
            // Addresses mean nothing after a restart.
            Type::Pointer(_)
            | Type::RefTo(_)
            | Type::Reference(_)
            | Type::Interface(_)
            | Type::Open { .. }
            | Type::Wrong => {}
            Type::Elementary(_)
            | Type::Text { .. }
            | Type::Enumeration(_)
            | Type::Subrange { .. }
            | Type::Native(_) => self.keep(address, self.layout(ty).size, retention),
        }
    }

    /// Whether some member of a variable of this type is retained by itself.
    fn retains(&mut self, ty: TypeId) -> bool {
        if let Some(known) = self.retaining.get(&ty) {
            return *known;
        }
        let retains = match self.ty(ty).clone() {
            Type::Array { of, .. } => self.retains(of),
            Type::Structure(place) => {
                let fields: Vec<TypeId> = self
                    .structures
                    .get(place as usize)
                    .map_or(Vec::new(), |s| s.fields.iter().map(|f| f.ty).collect());
                fields.into_iter().any(|ty| self.retains(ty))
            }
            Type::Block(place) => {
                let lineage: Vec<u32> = self.lineage(place).collect();
                let members: Vec<(Retention, TypeId)> = lineage
                    .into_iter()
                    .filter_map(|owner| self.pous.get(owner as usize))
                    .flat_map(|pou| &pou.symbols)
                    .map(|symbol| (symbol.retention, symbol.type_id()))
                    .collect();
                members.into_iter().any(|(kept, ty)| kept != Retention::None || self.retains(ty))
            }
            _ => false,
        };
        self.retaining.insert(ty, retains);
        retains
    }

    fn keep(&mut self, address: u32, bytes: u32, retention: Retention) {
        if retention == Retention::None || bytes == 0 {
            return;
        }
        self.kept += u64::from(bytes);
        if let Some(last) = self.retained.last_mut()
            && last.address + last.bytes == address
            && last.retention == retention
        {
            last.bytes += bytes;
            return;
        }
        self.retained.push(Retained { address, bytes, retention });
    }

    /// Members of an instance as the outside sees them, inherited ones first.
    pub(super) fn instance_members(&mut self, place: u32) -> Vec<Member> {
        let mut lineage: Vec<u32> = self.lineage(place).collect();
        lineage.reverse();
        let mut members = Vec::new();
        for owner in lineage {
            for nth in 0..self.pous.get(owner as usize).map_or(0, |pou| pou.symbols.len()) {
                let Some(symbol) = self.member_symbol(owner, nth as u32) else { continue };
                let (name, ty, home) = (symbol.shown.to_string(), symbol.type_id(), symbol.home);
                let offset = match home {
                    Home::This(offset) => offset,
                    Home::Absolute(address)
                        if address < map::OWN_END && symbol.kind != SectionKind::Static =>
                    {
                        address
                    }
                    _ => continue,
                };
                let shape = self.shape(ty);
                members.push(Member { name, offset, shape });
            }
        }
        members
    }

    /// Where a variable at an address is.
    fn located(&mut self, decl: &'a ast::VarDecl, section: &Section, allowed: bool, ty: TypeId) -> Home {
        let Some((text, at)) = &decl.address else { return Home::Nowhere };
        let shown = self.shown(decl.name);
        if !allowed || super::is_pin(section.kind) {
            let message = format!("`{shown}` cannot be located here");
            let help = "locate variables in VAR of a PROGRAM or in VAR_GLOBAL";
            self.findings.error(Code::Located, *at, message, help);
            return Home::Nowhere;
        }
        if section.retention != Retention::None || section.constant {
            let message = format!("`{shown}` is located: it cannot be CONSTANT, RETAIN or PERSISTENT");
            self.findings.error(Code::Located, *at, message, "where it lies decides what is kept");
            return Home::Nowhere;
        }
        let Some(place) = self.address(text, *at) else { return Home::Nowhere };
        let Some(elementary) = self.scalar(ty) else { return self.located_block(decl, place, ty, *at) };
        if !elementary.fits(place.size()) {
            let message = format!(
                "{} has {}, {place} has {}",
                self.type_name(ty),
                count(elementary.bits(), "bit"),
                place.size().bits()
            );
            let help = "choose the type or the address to suit";
            self.findings.error(Code::AddressSize, decl.ty.at, message, help);
            return Home::Nowhere;
        }
        let initial = decl.initial.as_ref().and_then(|initial| self.constant_initial(initial, ty));
        let bits = place.size().bits();
        let mask = if bits >= 64 { u64::MAX } else { (1 << bits) - 1 };
        let initial = initial.map(|cell| cell as u64 & mask);
        self.note_image(place, bits, *at);
        self.located.push(Located { address: place, bits, initial });
        home_of(place)
    }

    /// Arrays and structures at an address.
    fn located_block(&mut self, decl: &'a ast::VarDecl, place: Address, ty: TypeId, at: SourcePlace) -> Home {
        if ty == WRONG {
            return Home::Nowhere;
        }
        if self.contains_block(ty) || !self.only_scalars(ty) {
            let message = format!("a variable of type {} cannot be located", self.type_name(ty));
            let help = "locate numbers, arrays and structures of them";
            self.findings.error(Code::Located, decl.ty.at, message, help);
            return Home::Nowhere;
        }
        let first = place.bit_offset() / 8;
        let layout = self.layout(ty);
        if !place.bit_offset().is_multiple_of(8) || !first.is_multiple_of(layout.align) {
            let message = format!("{} does not begin where the address does", self.type_name(ty));
            self.findings.error(Code::AddressSize, at, message, "choose an address of the element's size");
            return Home::Nowhere;
        }
        let last = Address::new(place.area(), Size::Byte, first + layout.size.max(1) - 1);
        if last.is_none_or(|last| last.check(&self.options.limits.addresses).is_err()) {
            let message = format!("{} does not fit after {place}", self.type_name(ty));
            self.findings.error(Code::Address, at, message, "choose a lower address or a smaller type");
            return Home::Nowhere;
        }
        if let Some(initial) = &decl.initial {
            let message = "an initial value of a located array or structure is not supported yet";
            self.findings.error(
                Code::Unsupported,
                initial_at(initial),
                message,
                "assign the values in the program",
            );
        }
        self.note_image(place, layout.size * 8, at);
        self.located.push(Located { address: place, bits: layout.size * 8, initial: None });
        home_of(place)
    }

    fn only_scalars(&self, ty: TypeId) -> bool {
        match self.ty(ty) {
            Type::Array { of, .. } => self.only_scalars(*of),
            Type::Structure(place) => self
                .structures
                .get(*place as usize)
                .is_some_and(|s| s.fields.iter().all(|field| self.only_scalars(field.ty))),
            _ => self.scalar(ty).is_some(),
        }
    }

    /// An address that exists; reports it otherwise (controller:ADDR-02, controller:ADDR-04).
    pub(super) fn address(&mut self, text: &str, at: SourcePlace) -> Option<Address> {
        let limits = &self.options.limits.addresses;
        match Address::parse(text).and_then(|address| address.check(limits).map(|()| address)) {
            Ok(address) => Some(address),
            Err(error) => {
                let start = (at.start + error.offset() as u32).min(at.end);
                self.findings.error(Code::Address, SourcePlace { start, ..at }, error.to_string(), "");
                None
            }
        }
    }
}

/// The machine's address of a place in an image or the mapped memory.
pub(super) fn home_of(address: Address) -> Home {
    let region = match address.area() {
        Area::Input => map::INPUTS,
        Area::Output => map::OUTPUTS,
        Area::Memory => map::MEMORY,
    };
    let byte = region + address.bit_offset() / 8;
    if address.size() == Size::Bit { Home::Bit(byte, address.bit_offset() % 8) } else { Home::Absolute(byte) }
}
