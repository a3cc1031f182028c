//! What the caller decides about a compilation: costs, limits, the blocks that exist.

use crate::native::{Native, STANDARD};
use crate::types::{Elementary, TypeClass};
use signal::AddressLimits;
use std::borrow::Cow;

/// Modelled time of each operation of the source, in nanoseconds (controller:PERF-01, controller:PERF-03).
///
/// A load and a store share the documented figure of a load-store pair, the store taking the odd nanosecond.
/// Literals and constant expressions cost nothing: they are part of the operation that uses them. Standard functions
/// and conversions cost one operation of their type, of the wider one for a conversion. A parameter of a block costs
/// a store. What the documents do not give is a definition of the rig and says so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Costs {
    /// AND, OR, XOR, NOT and comparison of BOOL: 75.
    pub bool_op: u32,
    /// Reading a BOOL: 37. Rig definition: moving a BOOL (load and store) is one BOOL operation.
    pub bool_load: u32,
    /// Writing a BOOL: 38.
    pub bool_store: u32,
    /// Addition, subtraction, multiplication, comparison or bit operation on types of 8 and 16 bits: 42.
    pub int_op: u32,
    /// Division and MOD of those. Rig definition: 84.
    pub int_div: u32,
    /// Reading one: 32.
    pub int_load: u32,
    /// Writing one: 32.
    pub int_store: u32,
    /// The same operations on types of 32 bits and TIME: 41.
    pub dint_op: u32,
    /// Division and MOD of those. Rig definition: 82.
    pub dint_div: u32,
    /// Reading one: 24.
    pub dint_load: u32,
    /// Writing one: 25.
    pub dint_store: u32,
    /// The same operations on types of 64 bits. Rig definition: twice those of 32 bits, 82.
    pub long_op: u32,
    /// Division and MOD of those. Rig definition: 164.
    pub long_div: u32,
    /// Reading one. Rig definition: 48.
    pub long_load: u32,
    /// Writing one. Rig definition: 50.
    pub long_store: u32,
    /// Addition, subtraction, multiplication or comparison of REAL: 336.
    pub real_op: u32,
    /// Division of REAL: 678.
    pub real_div: u32,
    /// Reading one: 25.
    pub real_load: u32,
    /// Writing one: 25.
    pub real_store: u32,
    /// The same operations on LREAL. Rig definition: twice those of REAL, 672.
    pub lreal_op: u32,
    /// Division of LREAL. Rig definition: 1356.
    pub lreal_div: u32,
    /// Reading one. Rig definition: 50.
    pub lreal_load: u32,
    /// Writing one. Rig definition: 50.
    pub lreal_store: u32,
    /// Copying, comparing or converting a text, or a function of the library on texts. Rig definition: 1000.
    pub text: u32,
    /// A function of the library on numbers that is no operation, such as SQRT or SIN. Rig definition: 1000.
    pub function: u32,
    /// Each 8 bytes begun of a copied structure or array. Rig definition: 49, a load and a store of DINT.
    pub copy: u32,
    /// What a retained variable's load or store costs besides (controller:REM-05). Rig definition: 20. It
    /// applies where the declaration says RETAIN or PERSISTENT, not inside blocks of which a whole instance does.
    pub retained: u32,
    /// A condition tested, a label of CASE passed, a turn of a loop. Rig definition: 20. Turns cost at least 1.
    pub branch: u32,
    /// Calling a function, a block or a program, besides its parameters and its body. Rig definition: 200.
    pub call: u32,
    /// One call of a standard block such as TON, body included. Rig definition: 400.
    pub block: u32,
    /// Checking one index of an array. Rig definition: 42.
    pub index: u32,
}

impl Default for Costs {
    fn default() -> Self {
        Costs {
            bool_op: 75,
            bool_load: 37,
            bool_store: 38,
            int_op: 42,
            int_div: 84,
            int_load: 32,
            int_store: 32,
            dint_op: 41,
            dint_div: 82,
            dint_load: 24,
            dint_store: 25,
            long_op: 82,
            long_div: 164,
            long_load: 48,
            long_store: 50,
            real_op: 336,
            real_div: 678,
            real_load: 25,
            real_store: 25,
            lreal_op: 672,
            lreal_div: 1356,
            lreal_load: 50,
            lreal_store: 50,
            text: 1000,
            function: 1000,
            copy: 49,
            retained: 20,
            branch: 20,
            call: 200,
            block: 400,
            index: 42,
        }
    }
}

impl Costs {
    /// Costs that only bound how long a program runs, where its time is not modelled: 1 for an operation, more for those on texts
    /// and for functions and blocks of the library.
    pub const COUNTED: Costs = Costs {
        bool_op: 1,
        bool_load: 0,
        bool_store: 1,
        int_op: 1,
        int_div: 1,
        int_load: 0,
        int_store: 1,
        dint_op: 1,
        dint_div: 1,
        dint_load: 0,
        dint_store: 1,
        long_op: 1,
        long_div: 1,
        long_load: 0,
        long_store: 1,
        real_op: 1,
        real_div: 1,
        real_load: 0,
        real_store: 1,
        lreal_op: 1,
        lreal_div: 1,
        lreal_load: 0,
        lreal_store: 1,
        text: 100,
        function: 10,
        copy: 1,
        retained: 0,
        branch: 1,
        call: 10,
        block: 10,
        index: 1,
    };

    pub(crate) fn op(&self, ty: Elementary) -> u32 {
        match ty.class() {
            TypeClass::Bool => self.bool_op,
            TypeClass::Int => self.int_op,
            TypeClass::Dint => self.dint_op,
            TypeClass::Long => self.long_op,
            TypeClass::Real => self.real_op,
            TypeClass::Lreal => self.lreal_op,
        }
    }

    pub(crate) fn div(&self, ty: Elementary) -> u32 {
        match ty.class() {
            TypeClass::Bool => self.bool_op,
            TypeClass::Int => self.int_div,
            TypeClass::Dint => self.dint_div,
            TypeClass::Long => self.long_div,
            TypeClass::Real => self.real_div,
            TypeClass::Lreal => self.lreal_div,
        }
    }

    pub(crate) fn load(&self, ty: Elementary) -> u32 {
        match ty.class() {
            TypeClass::Bool => self.bool_load,
            TypeClass::Int => self.int_load,
            TypeClass::Dint => self.dint_load,
            TypeClass::Long => self.long_load,
            TypeClass::Real => self.real_load,
            TypeClass::Lreal => self.lreal_load,
        }
    }

    pub(crate) fn store(&self, ty: Elementary) -> u32 {
        match ty.class() {
            TypeClass::Bool => self.bool_store,
            TypeClass::Int => self.int_store,
            TypeClass::Dint => self.dint_store,
            TypeClass::Long => self.long_store,
            TypeClass::Real => self.real_store,
            TypeClass::Lreal => self.lreal_store,
        }
    }

    /// A jump that can close a loop is never free, so that no loop runs for ever in no time.
    pub(crate) fn turn(&self) -> u32 {
        self.branch.max(1)
    }
}

/// How large a program may become. What is beyond is refused with a code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProgramLimits {
    /// How far `%I`, `%Q` and `%M` reach (controller:ADDR-02).
    pub addresses: AddressLimits,
    /// Bytes of source text in all.
    pub source: usize,
    /// Bytes of all variables and constants.
    pub memory: u32,
    /// Characters that a STRING or WSTRING may be declared with (controller:DT-01).
    pub text: u32,
    /// Bytes of the retained image (controller:MEM-08).
    pub retained: usize,
    /// Operations of the compiled code.
    pub code: usize,
    /// Errors after which a compilation gives up.
    pub errors: usize,
}

impl Default for ProgramLimits {
    /// `%MW0` to `%MW59999`, images of 8 Kbytes, 4 Mbyte of text, 32 Mbyte of variables, texts of 65,535 characters,
    /// 64 Kbytes retained, 50 errors.
    fn default() -> Self {
        ProgramLimits {
            addresses: AddressLimits { input_bits: 65_536, output_bits: 65_536, memory_words: 60_000 },
            source: 4 << 20,
            memory: 32 << 20,
            text: 65_535,
            retained: 65_536,
            code: 1_000_000,
            errors: 50,
        }
    }
}

/// The settings of a compilation.
#[derive(Clone, Debug)]
pub struct Options {
    /// Modelled time of the operations.
    pub costs: Costs,
    /// How large the program may become.
    pub limits: ProgramLimits,
    /// The function blocks that are not written in Structured Text.
    pub blocks: &'static [Native],
    /// Names of global variables that are not assigned to: whoever runs the program writes them.
    pub read_only: Cow<'static, [&'static str]>,
    /// How many of the last sources are not the user's, who is not warned of what stands in them.
    pub provided: usize,
    /// The sources are a library: nothing has to run.
    pub library: bool,
}

impl Default for Options {
    /// The documented costs, the default limits, the standard blocks.
    fn default() -> Self {
        Options {
            costs: Costs::default(),
            limits: ProgramLimits::default(),
            blocks: STANDARD,
            read_only: Cow::Borrowed(&[]),
            provided: 0,
            library: false,
        }
    }
}
