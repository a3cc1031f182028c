//! Operations of the machine: three addresses on byte memory.
//!
//! An operand is a place: two bits say from where the other thirty count. Constants are places too, in the part of
//! the memory that holds them. A destination is never read, so that an operation has its effect at once.

/// Where an operand's offset counts from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Base {
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

    pub const fn new(base: Base, offset: u32) -> Operand {
        let base = match base {
            Base::Absolute => 0,
            Base::This => 1,
            Base::Frame => 2,
            Base::Indirect => 3,
        };
        Operand(base << 30 | (offset & Self::OFFSET))
    }

    pub const fn base(self) -> Base {
        match self.0 >> 30 {
            0 => Base::Absolute,
            1 => Base::This,
            2 => Base::Frame,
            _ => Base::Indirect,
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

/// What an operation does with its fields `a`, `b` and `c`. Unless said otherwise: `a` is the destination, `b` and
/// `c` the operands. A suffix is the type: I8..I64 signed, U8..U64 unsigned, F32, F64; a plain 8..64 is a width.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub(crate) enum Op {
    Move8,
    Move16,
    Move32,
    Move64,
    /// `c` bytes from `b` to `a`, which may overlap.
    Copy,
    /// The address of the place `b`, 4 bytes.
    Address,
    Add8,
    Add16,
    Add32,
    Add64,
    AddF32,
    AddF64,
    Sub8,
    Sub16,
    Sub32,
    Sub64,
    SubF32,
    SubF64,
    Mul8,
    Mul16,
    Mul32,
    Mul64,
    MulF32,
    MulF64,
    DivI8,
    DivU8,
    DivI16,
    DivU16,
    DivI32,
    DivU32,
    DivI64,
    DivU64,
    DivF32,
    DivF64,
    ModI8,
    ModU8,
    ModI16,
    ModU16,
    ModI32,
    ModU32,
    ModI64,
    ModU64,
    /// `b` alone.
    Neg8,
    Neg16,
    Neg32,
    Neg64,
    NegF32,
    NegF64,
    AbsI8,
    AbsI16,
    AbsI32,
    AbsI64,
    AbsF32,
    AbsF64,
    MinI8,
    MinU8,
    MinI16,
    MinU16,
    MinI32,
    MinU32,
    MinI64,
    MinU64,
    MinF32,
    MinF64,
    MaxI8,
    MaxU8,
    MaxI16,
    MaxU16,
    MaxI32,
    MaxU32,
    MaxI64,
    MaxU64,
    MaxF32,
    MaxF64,
    And8,
    And16,
    And32,
    And64,
    Or8,
    Or16,
    Or32,
    Or64,
    Xor8,
    Xor16,
    Xor32,
    Xor64,
    /// `b` alone; `NotBool` turns 0 into 1 and everything else into 0.
    NotBool,
    Not8,
    Not16,
    Not32,
    Not64,
    /// `c` is the count, I64: a negative one or one not below the width gives 0 (shifts) or counts modulo the width
    /// (rotations). ShrI.. fill with the sign: a count not below the width gives 0 or -1.
    Shl8,
    Shl16,
    Shl32,
    Shl64,
    ShrI8,
    ShrU8,
    ShrI16,
    ShrU16,
    ShrI32,
    ShrU32,
    ShrI64,
    ShrU64,
    Rol8,
    Rol16,
    Rol32,
    Rol64,
    Ror8,
    Ror16,
    Ror32,
    Ror64,
    /// Comparisons give a BOOL (1 byte).
    Eq8,
    Eq16,
    Eq32,
    Eq64,
    EqF32,
    EqF64,
    Ne8,
    Ne16,
    Ne32,
    Ne64,
    NeF32,
    NeF64,
    LtI8,
    LtU8,
    LtI16,
    LtU16,
    LtI32,
    LtU32,
    LtI64,
    LtU64,
    LtF32,
    LtF64,
    LeI8,
    LeU8,
    LeI16,
    LeU16,
    LeI32,
    LeU32,
    LeI64,
    LeU64,
    LeF32,
    LeF64,
    /// `b` alone. Cutting to a narrower width is a Move of that width: memory is little-endian.
    Sign8To16,
    Sign8To32,
    Sign8To64,
    Sign16To32,
    Sign16To64,
    Sign32To64,
    Zero8To16,
    Zero8To32,
    Zero8To64,
    Zero16To32,
    Zero16To64,
    Zero32To64,
    I16ToF32,
    I32ToF32,
    I32ToF64,
    F32ToF64,
    /// `b` of any scalar type to any: `c` = from << 8 | to, places in `Elementary::ALL`.
    Convert,
    /// An element's address (4 bytes) to the frame's `a`: `b` is the index of this type, `c` an entry of
    /// `Program::indexes`.
    IndexI8,
    IndexU8,
    IndexI16,
    IndexU16,
    IndexI32,
    IndexU32,
    IndexI64,
    IndexU64,
    /// Bit `c` of the memory from `b` on, as BOOL.
    LoadBit,
    /// The BOOL `b` to bit `c` of the memory from `a` on.
    StoreBit,
    /// To operation `a`.
    Jump,
    /// To operation `a` if the BOOL `b` is TRUE, or not.
    JumpIf,
    JumpIfNot,
    /// To operation `a` if `b` and `c` compare so.
    JumpEq8,
    JumpEq16,
    JumpEq32,
    JumpEq64,
    JumpEqF32,
    JumpEqF64,
    JumpNe8,
    JumpNe16,
    JumpNe32,
    JumpNe64,
    JumpNeF32,
    JumpNeF64,
    JumpLtI8,
    JumpLtU8,
    JumpLtI16,
    JumpLtU16,
    JumpLtI32,
    JumpLtU32,
    JumpLtI64,
    JumpLtU64,
    JumpLtF32,
    JumpLtF64,
    JumpLeI8,
    JumpLeU8,
    JumpLeI16,
    JumpLeU16,
    JumpLeI32,
    JumpLeU32,
    JumpLeI64,
    JumpLeU64,
    JumpLeF32,
    JumpLeF64,
    /// The negations, which differ for NaN.
    JumpNotLtF32,
    JumpNotLtF64,
    JumpNotLeF32,
    JumpNotLeF64,
    /// FOR by 1: where `b` < `c`, `b` grows by 1 and `a` is the next operation; else `b` grows by 1 if its type holds
    /// that, and the loop is over.
    ForI8,
    ForU8,
    ForI16,
    ForU16,
    ForI32,
    ForU32,
    ForI64,
    ForU64,
    /// FOR by `c` (I64): `b` grows by it, or, where its type cannot hold that, `a` is the next operation.
    StepI8,
    StepU8,
    StepI16,
    StepU16,
    StepI32,
    StepU32,
    StepI64,
    StepU64,
    /// Prepares the frame of unit `a` behind the running one, with its template.
    Frame,
    /// The same for the method with selector `a` of the instance whose address (4 bytes) is at `b`.
    FrameVirtual,
    /// Calls unit `a`, in the frame behind the running one; `b` is no place.
    Call,
    /// The same with the place `b` as its instance.
    CallThis,
    /// The same with the instance of the running unit.
    CallSame,
    /// Calls the method with selector `a` of the instance whose address (4 bytes) is at `b`.
    CallVirtual,
    /// Calls native block `a` with the instance at place `b`.
    CallNative,
    /// Calls a function of the library: `b` is an entry of `Program::library`, `a` the destination.
    CallLibrary,
    /// Copies texts: `c` is an entry of `Program::texts`.
    MoveText,
    /// Compares texts, -1, 0 or 1 as I8: `c` is an entry of `Program::texts`, whose `to` is an operand too.
    CompareText,
    /// TRUE where the instance with the address at `b` (4 bytes, 0 for none) is of a class that has interface or
    /// block `c` (a place in `Program::kinds`).
    IsKind,
    /// To the caller; at the end of a program, to the next one.
    Return,
    /// The rest is made of others when a program is loaded, and stands in no program: `c` is a constant itself.
    Set8,
    Set16,
    Set32,
    /// `a` grows by the constant.
    Grow16,
    Grow32,
    /// `a` is `b` and the constant.
    Sum16,
    Sum32,
    /// To step `a` where `b` compares so with the constant.
    Equal8,
    Equal16,
    Equal32,
    Other8,
    Other16,
    Other32,
    Less16,
    Less32,
    LessEqual16,
    LessEqual32,
    Greater16,
    Greater32,
    GreaterEqual16,
    GreaterEqual32,
    /// FOR by 1 to the constant.
    Turn16,
    Turn32,
}

/// An operation with its operands and its modelled time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Step {
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

/// Code that can be called.
#[derive(Clone, Debug)]
pub(crate) struct Unit {
    /// As declared; a method with its block, `block.method`.
    pub name: String,
    /// Place of the source file.
    pub file: u8,
    pub entry: u32,
    /// Bytes of the frame, a multiple of 8.
    pub frame: u32,
    /// The first bytes of the frame at a call: initial values of the result, the parameters and the variables.
    pub template: Vec<u8>,
    /// Units that it calls, each once; virtual calls are there with every unit that they may reach.
    pub calls: Vec<u16>,
    /// Bits of `%Q` that its code writes: first and number, each range once.
    pub writes: Vec<(u32, u32)>,
}

/// What an object knows of its class: the first 4 bytes of an instance of a block with methods hold the place of its
/// class + 1.
#[derive(Clone, Debug)]
pub(crate) struct Class {
    /// Unit of each selector that it has, by selector.
    pub methods: Vec<Option<u16>>,
    /// Places in `Program::kinds` of what it is: itself, what it extends, its interfaces. Sorted.
    pub kinds: Vec<u32>,
}

/// A statement's first operation: where breakpoints can be, and what coverage counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Statement {
    pub pc: u32,
    pub file: u8,
    /// From 1.
    pub line: u32,
}
