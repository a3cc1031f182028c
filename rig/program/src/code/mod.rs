//! Operations of the machine: three addresses on byte memory.
//!
//! An operand is a place: two bits say from where the other thirty count. Constants are places too, in the part of
//! the memory that holds them. A destination is never read, so that an operation has its effect at once.

mod op;

pub(crate) use op::Op;

/// Where an operand's offset counts from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AddressBase {
    /// The start of the address space ([`map`]).
    Absolute,
    /// The running block's instance.
    This,
    /// The running unit's frame.
    Frame,
    /// The address that stands at this offset of the frame (4 bytes).
    Indirect,
}

/// A place: base and offset in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub(crate) struct Operand(pub u32);

impl Operand {
    pub const OFFSET: u32 = (1 << 30) - 1;

    pub const fn new(base: AddressBase, offset: u32) -> Operand {
        let base = match base {
            AddressBase::Absolute => 0,
            AddressBase::This => 1,
            AddressBase::Frame => 2,
            AddressBase::Indirect => 3,
        };
        Operand(base << 30 | (offset & Self::OFFSET))
    }

    pub const fn base(self) -> AddressBase {
        match self.0 >> 30 {
            0 => AddressBase::Absolute,
            1 => AddressBase::This,
            2 => AddressBase::Frame,
            _ => AddressBase::Indirect,
        }
    }

    pub const fn offset(self) -> u32 {
        self.0 & Self::OFFSET
    }
}

/// The address space, which is also what pointers hold: the machine's own memory from 0 (constants, then variables,
/// then the tasks' stacks), then the images and the mapped memory of the controller, one byte an address.
pub(crate) mod map {
    /// No variable stands below: NULL and small offsets from it are bad references.
    pub const FIRST: u32 = 64;
    /// The end of what the machine's own memory may grow to.
    pub const OWN_END: u32 = 1 << 26;
    pub const INPUTS: u32 = 0x1000_0000;
    pub const OUTPUTS: u32 = 0x2000_0000;
    pub const MEMORY: u32 = 0x3000_0000;
    pub const END: u32 = 0x4000_0000;
}

/// An operation with its operands and its modelled time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct CodeStep {
    pub op: Op,
    pub a: u32,
    pub b: u32,
    pub c: u32,
    /// Nanoseconds.
    pub cost: u32,
}

/// How an index becomes an address: the place `of` + (index - low) * stride.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct IndexOf {
    pub of: Operand,
    pub low: i64,
    pub high: i64,
    /// Bytes from one element to the next.
    pub stride: u32,
    /// What is found is stored to: a base that leads nowhere is a write there.
    pub stored: bool,
}

/// A text in memory: its place and its size in bytes with the closing unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TextAt {
    pub at: Operand,
    pub bytes: u32,
    pub wide: bool,
}

/// Two texts, which may be of different width: for a move, from `of` to `to`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TextPair {
    pub to: TextAt,
    pub of: TextAt,
}

/// An argument of a function of the library.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LibraryArgument {
    Cell(Operand, crate::types::Elementary),
    Text(TextAt),
}

/// What a call of the library runs.
#[derive(Clone, Copy, Debug)]
pub(crate) enum LibraryCode {
    Function(&'static crate::library::Function),
    /// A scalar to a text.
    ToText(crate::types::Elementary),
    /// A text to a scalar.
    FromText(crate::types::Elementary),
}

/// A call of a function of the library.
#[derive(Clone, Debug)]
pub(crate) struct LibraryCall {
    pub code: LibraryCode,
    /// The generic type, BOOL where there is none.
    pub generic: crate::types::Elementary,
    pub arguments: Vec<LibraryArgument>,
    pub result: LibraryArgument,
}

impl LibraryCall {
    /// Whether the controller is asked, and answers.
    pub(crate) fn asks(&self) -> bool {
        use crate::library::Body;
        matches!(self.code, LibraryCode::Function(function) if matches!(function.body, Body::Service(_)))
    }
}

/// Code that can be called.
#[derive(Clone, Debug)]
pub(crate) struct CodeUnit {
    /// As declared; a method with its block, `block.method`.
    pub name: String,
    /// Place of the source file.
    pub file: u16,
    pub entry: u32,
    /// Bytes of the frame, a multiple of 8.
    pub frame: u32,
    /// The first bytes of the frame at a call: initial values of the result, the parameters and the variables.
    pub template: Vec<u8>,
    /// Units that it calls, each once; virtual calls are there with every unit that they may reach.
    pub calls: Vec<u16>,
    /// Bits of `%Q` that its code writes: first and number, each range once.
    pub writes: Vec<(u32, u32)>,
    /// Bits of `%I` that its code reads, in the same form.
    pub reads: Vec<(u32, u32)>,
}

/// What an object knows of its class: the first 4 bytes of an instance of a block with methods hold the place of its
/// class + 1.
#[derive(Clone, Debug)]
pub(crate) struct ObjectClass {
    /// Unit of each selector that it has, by selector.
    pub methods: Vec<Option<u16>>,
    /// Places in `Program::kinds` of what it is: itself, what it extends, its interfaces. Sorted.
    pub kinds: Vec<u32>,
}

/// A statement's first operation: where breakpoints can be, and what coverage counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Statement {
    pub pc: u32,
    pub file: u16,
    /// From 1.
    pub line: u32,
}
