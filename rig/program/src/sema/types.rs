//! The types of a program: each once in a table, with its size.

use super::Sema;
use crate::parse::ast::Key;
use crate::shape::{Member as ShapeMember, MemoryLayout, ShapeId};
use crate::tree::Ty;
use crate::types::Elementary;

/// A place in the table of types. Equal places are equal types.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct TypeId(pub u32);

/// What was reported already: it goes with everything.
pub(super) const WRONG: TypeId = TypeId(0);

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) enum Type {
    Wrong,
    Elementary(Elementary),
    Text {
        wide: bool,
        length: u32,
    },
    /// A place in `Sema::enumerations`.
    Enumeration(u32),
    Subrange {
        base: Elementary,
        low: i64,
        high: i64,
    },
    Array {
        dimensions: Vec<(i64, i64)>,
        of: TypeId,
    },
    /// An array of variable length: the number of dimensions.
    Open {
        dimensions: u32,
        of: TypeId,
    },
    /// A structure or union: a place in `Sema::structures`.
    Structure(u32),
    /// A function block: a place in `Sema::pous`.
    Block(u32),
    /// A native block: a place in the options.
    Native(u16),
    Pointer(TypeId),
    /// REF_TO, which differs from a pointer in that no arithmetic is done on it.
    RefTo(TypeId),
    /// REFERENCE TO, which stands for what it refers to.
    Reference(TypeId),
    /// A place in `Sema::interfaces`.
    Interface(u32),
}

/// An enumeration.
#[derive(Clone, Debug)]
pub(super) struct Enumeration {
    pub name: String,
    pub base: Elementary,
    /// Names as declared, with their cells.
    pub values: Vec<(Key, String, i64)>,
    /// Cell of a variable without an initial value.
    pub default: i64,
}

/// A member of a structure.
#[derive(Clone, Debug)]
pub(super) struct TypeField {
    pub key: Key,
    pub name: String,
    pub ty: TypeId,
    pub offset: u32,
}

/// A structure or union, laid out.
#[derive(Clone, Debug, Default)]
pub(super) struct Structure {
    pub name: String,
    pub fields: Vec<TypeField>,
    pub size: u32,
    pub align: u32,
    /// Levels of what it contains.
    pub depth: u32,
    /// Initial bytes.
    pub image: Vec<u8>,
}

/// Bytes of a type with what they begin at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TypeLayout {
    pub size: u32,
    pub align: u32,
}

impl Sema<'_> {
    /// The place of a type, the same for equal ones.
    pub(super) fn intern(&mut self, ty: Type) -> TypeId {
        if let Some(id) = self.type_index.get(&ty) {
            return *id;
        }
        let id = TypeId(self.types.len() as u32);
        self.type_index.insert(ty.clone(), id);
        self.types.push(ty);
        id
    }

    pub(super) fn ty(&self, id: TypeId) -> &Type {
        self.types.get(id.0 as usize).unwrap_or(&Type::Wrong)
    }

    pub(super) fn elementary(&mut self, ty: Elementary) -> TypeId {
        // The elementary types stand first, in their order.
        TypeId(1 + ty as u32)
    }

    /// The elementary type that a value of this type computes as: enumerations and subranges as their base.
    pub(super) fn scalar(&self, id: TypeId) -> Option<Elementary> {
        match self.ty(id) {
            Type::Elementary(ty) => Some(*ty),
            Type::Enumeration(place) => self.enumerations.get(*place as usize).map(|e| e.base),
            Type::Subrange { base, .. } => Some(*base),
            _ => None,
        }
    }

    /// Whether a value of this type is an address.
    pub(super) fn is_address(&self, id: TypeId) -> bool {
        matches!(self.ty(id), Type::Pointer(_) | Type::RefTo(_) | Type::Interface(_) | Type::Reference(_))
    }

    /// What a pointer or reference leads to.
    pub(super) fn target_of(&self, id: TypeId) -> Option<TypeId> {
        match self.ty(id) {
            Type::Pointer(to) | Type::RefTo(to) | Type::Reference(to) => Some(*to),
            _ => None,
        }
    }

    pub(super) fn layout(&self, id: TypeId) -> TypeLayout {
        match self.ty(id) {
            Type::Wrong => TypeLayout { size: 1, align: 1 },
            Type::Elementary(ty) => TypeLayout { size: ty.bytes() as u32, align: ty.bytes() as u32 },
            Type::Text { wide, length } => {
                let unit = 1 + u32::from(*wide);
                TypeLayout { size: (length + 1) * unit, align: unit }
            }
            Type::Enumeration(_) | Type::Subrange { .. } => {
                let bytes = self.scalar(id).map_or(1, |ty| ty.bytes() as u32);
                TypeLayout { size: bytes, align: bytes }
            }
            Type::Array { dimensions, of } => {
                let element = self.layout(*of);
                let count = elements(dimensions);
                let size = count.saturating_mul(u64::from(stride(element))).min(u64::from(u32::MAX / 2));
                TypeLayout { size: size as u32, align: element.align }
            }
            Type::Structure(place) => {
                self.structures.get(*place as usize).map_or(TypeLayout { size: 1, align: 1 }, |s| {
                    TypeLayout { size: s.size, align: s.align.max(1) }
                })
            }
            Type::Block(place) => {
                self.pous.get(*place as usize).map_or(TypeLayout { size: 8, align: 8 }, |pou| TypeLayout {
                    size: pou.size.max(4),
                    align: 8,
                })
            }
            Type::Native(place) => self
                .native_layouts
                .get(usize::from(*place))
                .map_or(TypeLayout { size: 8, align: 8 }, |(_, size)| TypeLayout { size: *size, align: 8 }),
            Type::Pointer(_)
            | Type::RefTo(_)
            | Type::Reference(_)
            | Type::Interface(_)
            | Type::Open { .. } => TypeLayout { size: 4, align: 4 },
        }
    }

    /// Levels of structures and blocks inside each other.
    pub(super) fn type_depth(&self, id: TypeId) -> u32 {
        match self.ty(id) {
            Type::Array { of, .. } => 1 + self.type_depth(*of),
            Type::Structure(place) => self.structures.get(*place as usize).map_or(0, |s| s.depth),
            Type::Block(place) => self.pous.get(*place as usize).map_or(0, |pou| pou.depth),
            _ => 0,
        }
    }

    /// Whether what contains a variable of this type is not too deep; reports where it is.
    pub(super) fn check_depth(&mut self, id: TypeId, at: crate::findings::SourcePlace) -> bool {
        if self.type_depth(id) < super::TYPE_DEPTH {
            return true;
        }
        let message = "types contain each other too deeply";
        self.findings.error(crate::codes::Code::Depth, at, message, "use fewer levels");
        false
    }

    /// The type as the tree speaks of it.
    pub(super) fn tree_type(&self, id: TypeId) -> Ty {
        if let Some(ty) = self.scalar(id) {
            return Ty::Scalar(ty);
        }
        match self.ty(id) {
            Type::Text { wide, length } => Ty::Text { wide: *wide, length: *length },
            Type::Pointer(_) | Type::RefTo(_) | Type::Reference(_) | Type::Interface(_) => Ty::Address,
            _ => Ty::Block { bytes: self.layout(id).size },
        }
    }

    /// The type's name for a message.
    pub(super) fn type_name(&self, id: TypeId) -> String {
        match self.ty(id) {
            Type::Wrong => "an unknown type".into(),
            Type::Elementary(ty) => ty.name().into(),
            Type::Text { wide, length } => format!("{}({length})", if *wide { "WSTRING" } else { "STRING" }),
            Type::Enumeration(place) => {
                self.enumerations.get(*place as usize).map_or(String::new(), |e| e.name.clone())
            }
            Type::Subrange { base, low, high } => format!("{} ({low}..{high})", base.name()),
            Type::Array { dimensions, of } => {
                let ranges: Vec<String> =
                    dimensions.iter().map(|(low, high)| format!("{low}..{high}")).collect();
                format!("ARRAY[{}] OF {}", ranges.join(", "), self.type_name(*of))
            }
            Type::Open { dimensions, of } => {
                let stars = vec!["*"; *dimensions as usize];
                format!("ARRAY[{}] OF {}", stars.join(", "), self.type_name(*of))
            }
            Type::Structure(place) => {
                self.structures.get(*place as usize).map_or(String::new(), |s| s.name.clone())
            }
            Type::Block(place) => self.pous.get(*place as usize).map_or(String::new(), |p| p.shown.clone()),
            Type::Native(place) => {
                self.options.blocks.get(usize::from(*place)).map_or(String::new(), |n| n.name.to_string())
            }
            Type::Pointer(to) => format!("POINTER TO {}", self.type_name(*to)),
            Type::RefTo(to) => format!("REF_TO {}", self.type_name(*to)),
            Type::Reference(to) => format!("REFERENCE TO {}", self.type_name(*to)),
            Type::Interface(place) => {
                self.interfaces.get(*place as usize).map_or(String::new(), |i| i.shown.clone())
            }
        }
    }

    /// The initial bytes of a variable of this type without an initial value.
    pub(super) fn default_bytes(&self, id: TypeId, out: &mut Vec<u8>) {
        match self.ty(id) {
            Type::Enumeration(place) => {
                let (cell, bytes) =
                    self.enumerations.get(*place as usize).map_or((0, 1), |e| (e.default, e.base.bytes()));
                out.extend_from_slice(cell.to_le_bytes().get(..bytes).unwrap_or(&[]));
            }
            Type::Subrange { base, low, high } => {
                let cell = if (*low..=*high).contains(&0) { 0 } else { *low };
                out.extend_from_slice(cell.to_le_bytes().get(..base.bytes()).unwrap_or(&[]));
            }
            Type::Array { dimensions, of } => {
                let element = self.layout(*of);
                let size = self.layout(id).size as usize;
                let stride = stride(element) as usize;
                let start = out.len();
                let mut one = Vec::with_capacity(stride);
                self.default_bytes(*of, &mut one);
                one.resize(stride, 0);
                if one.iter().all(|byte| *byte == 0) {
                    out.resize(start + size, 0);
                } else {
                    for _ in 0..elements(dimensions) {
                        if out.len() - start >= size {
                            break;
                        }
                        out.extend_from_slice(&one);
                    }
                }
            }
            Type::Structure(place) => {
                if let Some(structure) = self.structures.get(*place as usize) {
                    let end = out.len() + structure.size as usize;
                    out.extend_from_slice(&structure.image);
                    out.resize(end, 0);
                }
            }
            Type::Block(place) => {
                if let Some(pou) = self.pous.get(*place as usize) {
                    let start = out.len();
                    out.extend_from_slice(&pou.image);
                    out.resize(start + self.layout(id).size as usize, 0);
                }
            }
            _ => {
                let size = self.layout(id).size as usize;
                out.resize(out.len() + size, 0);
            }
        }
    }

    /// The type as the outside sees it.
    pub(super) fn shape(&mut self, id: TypeId) -> ShapeId {
        if let Some(shape) = self.shape_index.get(&id) {
            return *shape;
        }
        let shape = match self.ty(id).clone() {
            Type::Wrong => MemoryLayout::Address,
            Type::Elementary(ty) => MemoryLayout::Elementary(ty),
            Type::Text { wide, length } => MemoryLayout::Text { wide, length },
            Type::Enumeration(place) => match self.enumerations.get(place as usize) {
                Some(e) => MemoryLayout::Enumeration {
                    name: e.name.clone(),
                    base: e.base,
                    values: e.values.iter().map(|(_, name, cell)| (name.clone(), *cell)).collect(),
                },
                None => MemoryLayout::Address,
            },
            Type::Subrange { base, low, high } => MemoryLayout::Subrange { base, low, high },
            Type::Array { dimensions, of } => {
                let stride = stride(self.layout(of));
                let of = self.shape(of);
                MemoryLayout::Array { dimensions, of, stride }
            }
            Type::Structure(place) => {
                let structure = self.structures.get(place as usize).cloned().unwrap_or_default();
                let members = structure
                    .fields
                    .iter()
                    .map(|field| ShapeMember {
                        name: field.name.clone(),
                        offset: field.offset,
                        shape: self.shape(field.ty),
                    })
                    .collect();
                MemoryLayout::Members { name: structure.name, members, size: structure.size, block: false }
            }
            Type::Block(place) => {
                let name = self.type_name(id);
                let members = self.instance_members(place);
                MemoryLayout::Members { name, members, size: self.layout(id).size, block: true }
            }
            Type::Native(place) => {
                let mut members = Vec::new();
                let native = self.options.blocks.get(usize::from(place));
                let offsets = self.native_layouts.get(usize::from(place)).map(|(o, _)| o.clone());
                if let (Some(native), Some(offsets)) = (native, offsets) {
                    for (pin, offset) in native.pins.iter().zip(offsets) {
                        if pin.kind != crate::native::PinKind::Hidden {
                            let ty = self.elementary(pin.ty);
                            let shape = self.shape(ty);
                            members.push(ShapeMember {
                                name: pin.name.to_string(),
                                offset: u32::from(offset),
                                shape,
                            });
                        }
                    }
                }
                MemoryLayout::Members {
                    name: self.type_name(id),
                    members,
                    size: self.layout(id).size,
                    block: true,
                }
            }
            Type::Pointer(_)
            | Type::RefTo(_)
            | Type::Reference(_)
            | Type::Interface(_)
            | Type::Open { .. } => MemoryLayout::Address,
        };
        let place = ShapeId(self.shapes.len() as u32);
        self.shapes.push(shape);
        self.shape_index.insert(id, place);
        place
    }
}

/// Elements of an array in all.
pub(super) fn elements(dimensions: &[(i64, i64)]) -> u64 {
    dimensions.iter().fold(1u64, |n, (low, high)| {
        let width = i128::from(*high) - i128::from(*low) + 1;
        n.saturating_mul(u64::try_from(width).unwrap_or(if width < 0 { 0 } else { u64::MAX }))
    })
}

/// Bytes from one element to the next.
pub(super) fn stride(element: TypeLayout) -> u32 {
    element.size.next_multiple_of(element.align.max(1))
}
