//! Ways through the variables: to one by its path, and over all of them.

use crate::code::map;
use crate::program::{NameEntry, Program, Storage, VarRef, Variable};
use crate::shape::{MemoryLayout, Root, ShapeId, count};
use crate::types::Elementary;
use signal::{Address, Area, Size};
use std::fmt::Write;

/// Types that stand inside each other, at most.
const DEPTH: u32 = 200;

/// Area and first bit of an address outside the machine's memory.
fn host_bit(address: u32, bit: u8) -> Option<(Area, u32)> {
    let (area, offset) = match address {
        map::INPUTS..map::OUTPUTS => (Area::Input, address - map::INPUTS),
        map::OUTPUTS..map::MEMORY => (Area::Output, address - map::OUTPUTS),
        map::MEMORY..map::END => (Area::Memory, address - map::MEMORY),
        _ => return None,
    };
    Some((area, offset.checked_mul(8)?.checked_add(u32::from(bit))?))
}

/// Where a path leads.
#[derive(Clone, Debug)]
pub(crate) struct Spot {
    /// As declared.
    pub path: String,
    pub address: u32,
    pub bit: u8,
    pub shape: ShapeId,
    pub file: u16,
}

impl Program {
    /// The variable with this path, in capitals or not: `MAIN.n`, or `n` where no other program has one. A
    /// global variable goes before those of programs. A variable of an elementary type, an enumeration or a subrange, or an array
    /// of such ones as a whole; its elements too, `MAIN.a[3]`, and those inside structures and blocks, `MAIN.t[2].Q`.
    pub fn find(&self, path: &str) -> Option<Variable> {
        let spot = Spot::find(self, path)?;
        let (ty, dimensions) = match self.shape(spot.shape)? {
            MemoryLayout::Array { dimensions, of, .. } => {
                (self.shape(*of)?.elementary()?, dimensions.clone())
            }
            shape => (shape.elementary()?, Vec::new()),
        };
        Some(Variable {
            storage: spot.storage(ty)?,
            retention: self.retention_at(spot.address),
            path: spot.path,
            ty,
            dimensions,
            file: spot.file,
        })
    }

    /// The reference of a path: of a single variable or element as in [`Program::find`]. `None` for whole arrays and
    /// located variables, which [`Program::find`] describes.
    pub fn resolve(&self, path: &str) -> Option<VarRef> {
        let spot = Spot::find(self, path)?;
        match spot.storage(self.shape(spot.shape)?.elementary()?)? {
            Storage::Cell(variable) => Some(variable),
            Storage::Located(_) => None,
        }
    }
}

impl Spot {
    fn root(root: &Root) -> Spot {
        Spot {
            path: root.path.clone(),
            address: root.address,
            bit: root.bit,
            shape: root.shape,
            file: root.file,
        }
    }

    /// Follows a path in capitals or not, full or short.
    pub fn find(program: &Program, path: &str) -> Option<Spot> {
        let key: String =
            path.chars().filter(|c| !c.is_whitespace()).map(|c| c.to_ascii_uppercase()).collect();
        let end = key.find(['.', '[']).unwrap_or(key.len());
        let (first, rest) = key.split_at(end);
        // A located variable of a program is a root of its own: two names.
        let two = rest.strip_prefix('.').map_or(0, |rest| rest.find(['.', '[']).unwrap_or(rest.len()) + 1);
        let (both, after) = key.split_at(end + two);
        let (entry, mut rest) = match program.index.get(both) {
            Some(Some(entry)) if two > 0 => (*entry, after),
            _ => ((*program.index.get(first)?)?, rest),
        };
        let mut spot = Spot::root(program.roots.get(entry.root as usize)?);
        if let Some(member) = entry.member {
            spot.enter(program, |nth, _| nth == member as usize)?;
        }
        while !rest.is_empty() {
            if let Some(after) = rest.strip_prefix('.') {
                let (name, after) = after.split_at(after.find(['.', '[']).unwrap_or(after.len()));
                spot.enter(program, |_, known| known.eq_ignore_ascii_case(name))?;
                rest = after;
            } else {
                let (indices, after) = rest.strip_prefix('[')?.split_once(']')?;
                spot.element(program, indices)?;
                rest = after;
            }
        }
        Some(spot)
    }

    /// To a member.
    fn enter(&mut self, program: &Program, is: impl Fn(usize, &str) -> bool) -> Option<()> {
        let MemoryLayout::Members { members, .. } = program.shape(self.shape)? else { return None };
        let (_, member) = members.iter().enumerate().find(|(nth, member)| is(*nth, &member.name))?;
        self.path.push('.');
        self.path.push_str(&member.name);
        self.address = self.address.checked_add(member.offset)?;
        self.shape = member.shape;
        Some(())
    }

    /// To an element, whose indices are written with commas; missing ones are those of arrays in the array.
    fn element(&mut self, program: &Program, indices: &str) -> Option<()> {
        let mut indices = indices.split(',').map(|text| text.parse::<i64>().ok());
        let mut next = indices.next();
        while let Some(first) = next {
            let MemoryLayout::Array { dimensions, of, stride } = program.shape(self.shape)? else {
                return None;
            };
            let (mut nth, mut index) = (0i64, first);
            self.path.push('[');
            for (place, (low, high)) in dimensions.iter().enumerate() {
                if place > 0 {
                    index = indices.next()?;
                    self.path.push(',');
                }
                let index = index.filter(|index| index >= low && index <= high)?;
                let width = high.checked_sub(*low)?.checked_add(1)?;
                nth = nth.checked_mul(width)?.checked_add(index.checked_sub(*low)?)?;
                // Writing to a string does not fail.
                let _ = write!(self.path, "{index}");
            }
            self.path.push(']');
            let offset = u32::try_from(nth).ok()?.checked_mul(*stride)?;
            self.address = self.address.checked_add(offset)?;
            self.shape = *of;
            next = indices.next();
        }
        Some(())
    }

    /// Where a value of this type stands.
    pub fn storage(&self, ty: Elementary) -> Option<Storage> {
        storage(self.address, self.bit, ty)
    }
}

/// Where a value of this type stands.
fn storage(address: u32, bit: u8, ty: Elementary) -> Option<Storage> {
    if address < map::OWN_END {
        return Some(Storage::Cell(VarRef::new(address, ty)));
    }
    let (area, first) = host_bit(address, bit)?;
    let size = match ty.bits() {
        1 => Size::Bit,
        8 => Size::Byte,
        16 => Size::Word,
        32 => Size::Double,
        _ => Size::Long,
    };
    let address = Address::new(area, size, first / size.bits())?;
    Some(Storage::Located(address)).filter(|_| first.is_multiple_of(size.bits()))
}

/// One variable of an elementary type or an array of such ones, a text, or an address; or an instance of a native
/// block, whose pins follow.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leaf<'a> {
    pub path: &'a str,
    pub root: &'a Root,
    pub address: u32,
    pub bytes: u32,
    pub shape: ShapeId,
    /// Of the elements, for an array; `None` for a text, an address or an instance.
    pub ty: Option<Elementary>,
}

impl Leaf<'_> {
    pub fn storage(&self) -> Option<Storage> {
        storage(self.address, self.root.bit, self.ty?)
    }
}

struct LeafWalk<'a> {
    program: &'a Program,
    root: &'a Root,
    path: String,
    within: &'a dyn Fn(u32, u32) -> bool,
}

/// Visits every leaf whose bytes may be `within` (first, end), until `visit` says FALSE.
pub(crate) fn leaves(
    program: &Program,
    within: &dyn Fn(u32, u32) -> bool,
    visit: &mut dyn FnMut(&Leaf<'_>) -> bool,
) {
    for root in &program.roots {
        let mut walk = LeafWalk { program, root, path: root.path.clone(), within };
        if !walk.open(root.shape, root.address, 0, visit) {
            return;
        }
    }
}

impl LeafWalk<'_> {
    fn open(
        &mut self,
        id: ShapeId,
        address: u32,
        depth: u32,
        visit: &mut dyn FnMut(&Leaf<'_>) -> bool,
    ) -> bool {
        let Some(shape) = self.program.shape(id) else { return true };
        let bytes = shape.bytes();
        // What has no bytes may be there very many times.
        if bytes == 0 || depth > DEPTH || !(self.within)(address, address.saturating_add(bytes)) {
            return true;
        }
        let length = self.path.len();
        let ty = match shape {
            MemoryLayout::Members { members, name, .. } => {
                // A native block keeps more than its pins show: it is a leaf besides.
                if self.program.native(name).is_some() {
                    let root = self.root;
                    let leaf = Leaf { path: &self.path, root, address, bytes, shape: id, ty: None };
                    if !visit(&leaf) {
                        return false;
                    }
                }
                return members.iter().all(|member| {
                    self.path.push('.');
                    self.path.push_str(&member.name);
                    let more =
                        self.open(member.shape, address.saturating_add(member.offset), depth + 1, visit);
                    self.path.truncate(length);
                    more
                });
            }
            MemoryLayout::Array { dimensions, of, stride } => {
                match self.program.shape(*of).and_then(MemoryLayout::elementary) {
                    Some(ty) => Some(ty),
                    None => {
                        return (0..count(dimensions)).all(|nth| {
                            let at = address.saturating_add(nth.saturating_mul(*stride));
                            if !(self.within)(at, at.saturating_add(*stride)) {
                                return true;
                            }
                            self.path.push_str(&indices(dimensions, nth));
                            let more = self.open(*of, at, depth + 1, visit);
                            self.path.truncate(length);
                            more
                        });
                    }
                }
            }
            shape => shape.elementary(),
        };
        visit(&Leaf { path: &self.path, root: self.root, address, bytes, shape: id, ty })
    }
}

/// `[i,j]` for the `nth` element.
pub(crate) fn indices(dimensions: &[(i64, i64)], nth: u32) -> String {
    let mut rest = i64::from(nth);
    let mut list: Vec<String> = Vec::new();
    for (low, high) in dimensions.iter().rev() {
        let width = high.saturating_sub(*low).saturating_add(1).max(1);
        list.push(low.saturating_add(rest % width).to_string());
        rest /= width;
    }
    list.reverse();
    format!("[{}]", list.join(","))
}

/// What first names mean: full ones of roots, short ones of what programs have.
pub(crate) fn index(program: &Program) -> std::collections::BTreeMap<String, Option<NameEntry>> {
    let mut index = std::collections::BTreeMap::new();
    let mut short = |name: &str, entry: NameEntry| {
        index.entry(name.to_ascii_uppercase()).and_modify(|known| *known = None).or_insert(Some(entry));
    };
    let of_program = |path: &str| program.program_names.iter().any(|name| name.eq_ignore_ascii_case(path));
    for (root, known) in (0..).zip(&program.roots) {
        if let Some((_, name)) = known.path.split_once('.').filter(|(unit, _)| of_program(unit)) {
            short(name, NameEntry { root, member: None });
        } else if let (true, Some(MemoryLayout::Members { members, .. })) =
            (of_program(&known.path), program.shape(known.shape))
        {
            for (member, known) in (0..).zip(members) {
                short(&known.name, NameEntry { root, member: Some(member) });
            }
        }
    }
    // Full paths come last: they go before short ones.
    for (root, known) in (0..).zip(&program.roots) {
        index.insert(known.path.to_ascii_uppercase(), Some(NameEntry { root, member: None }));
    }
    index
}
