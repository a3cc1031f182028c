//! Code that no compiler makes: it may fault, and nothing else.

use super::{Board, Builder, at, frame, this, via};
use crate::code::{
    CodeStep, IndexOf, LibraryArgument, LibraryCall, LibraryCode, ObjectClass, Op, Operand, Statement,
    TextAt, TextPair,
};
use crate::host::StopReason;
use crate::machine::Machine;
use crate::program::{Program, Retention};
use crate::types::Elementary;
use proptest::prelude::*;
use signal::{Span, Time};
use std::sync::Arc;

/// Every operation. The list ends with `Return`.
fn operations() -> Vec<Op> {
    let mut all = Vec::new();
    macro_rules! list {
        ($($op:ident)*) => { $(all.push(Op::$op);)* };
    }
    list! {
        Move8 Move16 Move32 Move64 Copy Address Add8 Add16 Add32 Add64 AddF32 AddF64 SubF32 MulF64 DivI8 DivU64 DivF32
        ModI32 NegF32 AbsI64 AbsF32 MinF32 MaxF64 MinI8 MaxU64 NotBool Not64 Shl8 ShrU64 ShrI32 Rol16 Ror32 EqF32 LtU8
        LeI64 Sign8To64 Zero32To64 I16ToF32 F32ToF64 Convert IndexI8 IndexU8 IndexI32 IndexU64 LoadBit StoreBit Jump JumpIf
        JumpIfNot JumpEq8 JumpLtF32 JumpNotLeF64 ForI8 ForU64 Frame FrameVirtual Call CallThis
        CallSame CallVirtual CallNative CallLibrary MoveText CompareText IsKind Return
    }
    all
}

/// An operand or a small number, likely to lead somewhere.
fn field() -> impl Strategy<Value = u32> {
    let offset = || prop_oneof![0u32..40, 60u32..200, 190u32..300];
    let host = prop::sample::select(vec![
        0x1000_0000u32,
        0x1000_0007,
        0x2000_0000,
        0x2000_000F,
        0x3000_0000,
        0x3FFF_FFFF,
    ]);
    prop_oneof![
        offset().prop_map(at),
        offset().prop_map(this),
        offset().prop_map(frame),
        (0u32..40).prop_map(via),
        (host, 0u32..9).prop_map(|(host, more)| at(host.saturating_add(more))),
        0u32..30,
        any::<u32>(),
    ]
}

fn step() -> impl Strategy<Value = CodeStep> {
    let fields = (field(), field(), field(), 0u32..3);
    (prop::sample::select(operations()), fields).prop_map(|(op, (a, b, c, cost))| CodeStep {
        op,
        a,
        b,
        c,
        cost: cost * 5 + 1,
    })
}

fn text() -> impl Strategy<Value = TextAt> {
    (field(), 0u32..20, any::<bool>()).prop_map(|(at, bytes, wide)| TextAt { at: Operand(at), bytes, wide })
}

fn elementary() -> impl Strategy<Value = Elementary> {
    prop::sample::select(Elementary::ALL.to_vec())
}

fn argument() -> impl Strategy<Value = LibraryArgument> {
    prop_oneof![
        (field(), elementary()).prop_map(|(at, ty)| LibraryArgument::Cell(Operand(at), ty)),
        text().prop_map(LibraryArgument::Text),
    ]
}

fn library() -> impl Strategy<Value = LibraryCall> {
    let names = vec!["CONCAT", "LEFT", "FIND", "SIN", "EXPT", "REPLACE"];
    let function = prop::sample::select(names).prop_map(crate::library::find);
    let code = prop_oneof![
        function.prop_map(
            |function| function.map_or(LibraryCode::ToText(Elementary::Real), LibraryCode::Function)
        ),
        elementary().prop_map(LibraryCode::ToText),
        elementary().prop_map(LibraryCode::FromText),
    ];
    (code, elementary(), prop::collection::vec(argument(), 0..40), argument())
        .prop_map(|(code, generic, arguments, result)| LibraryCall { code, generic, arguments, result })
}

prop_compose! {
    fn program()(
        code in prop::collection::vec(step(), 1..60),
        memory in prop::collection::vec(prop_oneof![0u8..3, any::<u8>()], 128),
        texts in prop::collection::vec((text(), text()), 4),
        library in prop::collection::vec(library(), 4),
        indexes in prop::collection::vec((field(), any::<i64>(), any::<i64>(), any::<u32>()), 4),
        units in prop::collection::vec((0u32..60, 0u32..80, prop::collection::vec(0u16..4, 0..3)), 3),
        methods in prop::collection::vec(prop::option::of(0u16..5), 0..4),
    ) -> Arc<Program> {
        let mut build = Builder::default();
        build.constant(&memory[..32]);
        let variables = build.variable(&memory[32..]);
        build.root("TEXT", crate::shape::MemoryLayout::Text { wide: false, length: 20 }, variables);
        build.retain(variables + 3, 9, Retention::Retain);
        build.program("MAIN", &[1, 2, 3]);
        for (entry, frame, calls) in units {
            let unit = build.unit(frame, &memory[..frame.min(40) as usize], &calls);
            build.program.units[usize::from(unit)].entry = entry;
        }
        build.program.natives = crate::native::STANDARD.iter().collect();
        build.program.classes = vec![ObjectClass { methods, kinds: vec![0, 2] }; 2];
        build.program.texts = texts.into_iter().map(|(to, of)| TextPair { to, of }).collect();
        build.program.library = library;
        build.program.indexes = indexes
            .into_iter()
            .map(|(of, low, high, stride)| IndexOf { of: Operand(of), low, high, stride, stored: low < 0 })
            .collect();
        build.program.lines = vec![1; code.len()];
        build.program.statements = (0..code.len() as u32).map(|pc| Statement { pc, file: 0, line: pc }).collect();
        build.program.code = code;
        build.finish()
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn random_code_only_faults(program in program(), debug in any::<bool>()) {
        let mut machine = Machine::new(program.clone(), &[vec![0], vec![0]]).unwrap();
        machine.set_coverage(debug);
        let constants = program.variables_from as usize;
        let mut board = Board::default();
        for task in [0, 1, 0] {
            machine.begin(task);
            let mut left = Span::from_nanos(5_000);
            for _ in 0..100 {
                let slice = machine.resume(task, Time::ZERO, left, &mut board);
                left = left - slice.used;
                match slice.stop {
                    StopReason::Touched { .. } => {}
                    StopReason::Break => panic!("there is no breakpoint"),
                    _ => break,
                }
            }
        }
        prop_assert_eq!(&machine.memory()[..constants], &program.image[..constants]);
        machine.coverage();
        machine.reset(true, false);
    }
}
