//! Slices, watches and faults.

use super::{Board, Builder, at, cycle, done, frame, this, via};
use crate::code::{IndexOf, ObjectClass, Op::*, Operand, TextAt, TextPair};
use crate::host::{ProgramFault, ProgramFaultKind, StopReason};
use crate::machine::Machine;
use crate::program::VarRef;
use crate::types::Elementary::{Bool, Byte, Dint, Int, Lint, Real};
use proptest::prelude::*;
use signal::{Span, Time, Value};

/// A loop with calls and an array: ten turns of a[i] := a[i] + F(i), where F(x) = x * 2.
fn sample() -> Builder {
    let mut build = Builder::default();
    let zero = build.constant(&0i32.to_le_bytes());
    let two = build.constant(&2i32.to_le_bytes());
    let nine = build.constant(&9i32.to_le_bytes());
    let i = build.global("i", Dint, 0);
    let array = build.variable(&[0; 40]);
    build.program.indexes.push(IndexOf { of: Operand(at(array)), low: 0, high: 9, stride: 4, stored: false });
    build.program("MAIN", &[1]);
    build.statement(Move32, at(i), at(zero), 0);
    let turn = build.statement(Frame, 1, 0, 0);
    build.op(Move32, frame(64 + 4), at(i), 0);
    build.op(Call, 1, 0, 0);
    build.op(IndexI32, frame(8), at(i), 0);
    build.op(Add32, via(8), via(8), frame(64));
    build.statement(ForI32, turn, at(i), at(nine));
    build.op(Return, 0, 0, 0);
    build.unit(8, &[7; 8], &[]);
    build.statement(Mul32, frame(0), frame(4), at(two));
    build.op(Return, 0, 0, 0);
    build
}

#[test]
fn a_sample_computes() {
    let build = sample();
    let array = build.program.variables_to - 40;
    let mut machine = build.machine();
    for round in 1..4 {
        let slice = cycle(&mut machine, &mut Board::default());
        // Ten turns of eight operations between two others.
        assert_eq!((slice.stop, slice.used), (StopReason::Done, Span::from_nanos(10 * (1 + 10 * 8 + 1))));
        for n in 0..10u32 {
            assert_eq!(machine.read(VarRef::new(array + 4 * n, Dint)), Value::Int(i64::from(2 * n * round)));
        }
    }
    assert_eq!(machine.read(machine.find("I").unwrap()), Value::Int(10));
}

proptest! {
    #[test]
    fn slices_do_not_matter(budgets in prop::collection::vec(0i64..200, 1..200)) {
        let mut whole = sample().machine();
        let expected = cycle(&mut whole, &mut Board::default());
        let mut cut = sample().machine();
        cut.begin(0);
        let (mut used, mut stop) = (Span::ZERO, None);
        for budget in budgets.into_iter().chain(std::iter::repeat_n(1000, 50)) {
            let slice = cut.resume(0, Time::ZERO + used, Span::from_nanos(budget), &mut Board::default());
            prop_assert!(slice.used.as_nanos() <= budget);
            used = used + slice.used;
            match slice.stop {
                StopReason::Budget { next } => prop_assert!(slice.used.as_nanos() + next.as_nanos() > budget),
                other => {
                    stop = Some(other);
                    break;
                }
            }
        }
        prop_assert_eq!((used, stop), (expected.used, Some(StopReason::Done)));
        // Temporaries that nobody reads any more may differ.
        let variables = cut.program().image.len();
        prop_assert_eq!(cut.memory().get(..variables), whole.memory().get(..variables));
    }
}

/// Runs a cycle, and counts the slices that ended because something watched changed.
fn touches(machine: &mut Machine, board: &mut Board) -> Vec<i64> {
    machine.begin(0);
    let (mut times, mut now) = (Vec::new(), Time::ZERO);
    loop {
        let slice = machine.resume(0, now, Span::from_secs(1), board);
        now = now.saturating_add(slice.used);
        match slice.stop {
            StopReason::Touched { .. } => times.push(now.as_nanos()),
            StopReason::Done => return times,
            stop => panic!("{stop:?}"),
        }
    }
}

#[test]
fn watches_are_exact_by_the_byte() {
    // A wide store over neighbours touches when the watched byte changes, and only then.
    let mut build = Builder::default();
    let values: Vec<u32> =
        [0u64, 0xFF00, 0xFF, 1 << 56, 1 << 56].iter().map(|n| build.constant(&n.to_le_bytes())).collect();
    let to = build.variable(&[0; 24]);
    build.program("MAIN", &[]);
    for value in &values {
        build.op(Move64, at(to + 3), at(*value), 0);
    }
    build.op(Copy, at(to + 3), at(values[0]), 8);
    build.op(Return, 0, 0, 0);
    let program = build.finish();
    for watched in 0..12u32 {
        let mut machine = Machine::new(program.clone(), &[vec![0]]).unwrap();
        machine.watch(VarRef::new(to + watched, Byte));
        let expected: &[i64] = match watched {
            3 => &[30, 40],
            4 => &[20, 30],
            10 => &[40, 60],
            _ => &[],
        };
        assert_eq!(touches(&mut machine, &mut Board::default()), expected, "byte {watched}");
        machine.unwatch(VarRef::new(to + watched, Byte));
        assert_eq!(touches(&mut machine, &mut Board::default()), [0i64; 0], "byte {watched}");
    }
}

#[test]
fn every_way_to_store_minds_watches() {
    let mut build = Builder::default();
    let text = build.constant(b"abc\0\0\0\0\0");
    let wide = build.constant(b"x\0y\0\0\0\0\0");
    let one = build.constant(&1i64.to_le_bytes());
    let to = build.variable(&[0; 8]);
    let pair = |of, wide| TextPair {
        to: TextAt { at: Operand(at(to)), bytes: 8, wide: false },
        of: TextAt { at: Operand(at(of)), bytes: 8, wide },
    };
    build.program.texts = vec![pair(text, false), pair(wide, true)];
    build.program.natives = crate::native::STANDARD.iter().filter(|native| native.name == "TON").collect();
    build.program("MAIN", &[]);
    build.op(MoveText, 0, 0, 0);
    build.op(MoveText, 0, 0, 1);
    build.op(StoreBit, at(to), at(one), 1);
    build.op(Convert, at(to), at(one), (Lint as u32) << 8 | Bool as u32);
    build.op(NotBool, at(to), at(to), 0);
    build.op(Return, 0, 0, 0);
    let mut machine = build.machine();
    machine.watch(VarRef::new(to, Byte));
    // "abc", "xy" (x is 16#78), bit 1 of x, 1, 0.
    assert_eq!(touches(&mut machine, &mut Board::default()), [10, 20, 30, 40, 50]);
    assert_eq!(machine.memory()[to as usize..][..4], [0, b'y', 0, 0]);
}

#[test]
fn native_blocks_touch_and_take_the_time_of_their_end() {
    let mut build = Builder::default();
    build.program.natives = crate::native::STANDARD.iter().filter(|native| native.name == "TON").collect();
    let native = build.program.natives[0];
    let (offsets, bytes) = native.layout();
    let instance = build.variable(&vec![0; bytes as usize]);
    let pin = |name: &str| {
        let place = native.pins.iter().position(|pin| pin.name == name).unwrap();
        VarRef::new(instance + u32::from(offsets[place]), native.pins[place].ty)
    };
    let one = build.constant_behind(&[1]);
    let delay = build.constant_behind(&2u32.to_le_bytes());
    build.program("MAIN", &[]);
    build.op(Move8, at(pin("IN").address()), at(one), 0);
    build.op(Move32, at(pin("PT").address()), at(delay), 0);
    build.op(CallNative, 0, at(instance), 0);
    build.op(Return, 0, 0, 0);
    let mut machine = build.machine();
    machine.watch(pin("Q"));
    let mut board = Board::default();
    machine.begin(0);
    assert_eq!(machine.resume(0, Time::ZERO, Span::from_secs(1), &mut board).stop, StopReason::Done);
    // The call completes at 30 ns; 2 ms later it has run for PT.
    let touched = StopReason::Touched { file: 0, line: 3 };
    for (start, stop) in [(2_000_000 - 1, StopReason::Done), (2_000_000, touched)] {
        machine.begin(0);
        let slice = machine.resume(0, Time::from_nanos(start), Span::from_secs(1), &mut board);
        assert_eq!(slice.stop, stop, "{start}");
        assert_eq!(machine.read(pin("Q")), Value::Bool(stop == touched));
    }
}

/// The fault of a program of a few operations.
fn fault(build: Builder) -> ProgramFault {
    let mut machine = build.machine();
    match cycle(&mut machine, &mut Board::default()).stop {
        StopReason::Fault(fault) => {
            // The cycle is over.
            let slice = machine.resume(0, Time::ZERO, Span::from_secs(1), &mut Board::default());
            assert_eq!((slice.stop, slice.used), (StopReason::Done, Span::ZERO));
            fault
        }
        stop => panic!("{stop:?}"),
    }
}

#[test]
fn faults_name_kind_and_line() {
    let small = |op, a, b, c| {
        let mut build = Builder::default();
        let constant = build.constant(&(-1i64).to_le_bytes());
        let variable = build.global("x", Lint, 0);
        assert_eq!((constant, variable), (64, 72));
        build.program.indexes.push(IndexOf {
            of: Operand(at(variable)),
            low: 0,
            high: 7,
            stride: 1,
            stored: false,
        });
        build.program("MAIN", &[]);
        build.op(Move64, frame(0), at(constant), 0);
        build.op(op, a, b, c);
        build.op(Return, 0, 0, 0);
        fault(build)
    };
    let (constant, variable) = (at(64), at(72));
    let cases = [
        (small(DivI32, variable, constant, variable), ProgramFaultKind::DivisionByZero),
        (small(IndexI8, frame(8), constant, 0), ProgramFaultKind::Bounds),
        (small(IndexU64, frame(8), constant, 0), ProgramFaultKind::Bounds),
        (small(IndexU64, frame(8), variable, 7), ProgramFaultKind::Internal),
        // Constants are not written, nor what lies below them.
        (small(Move8, constant, variable, 0), ProgramFaultKind::ReservedWrite),
        (small(Move64, at(60), variable, 0), ProgramFaultKind::ReservedWrite),
        (small(Copy, constant, variable, 4), ProgramFaultKind::ReservedWrite),
        // 16#FFFF_FFFF leads nowhere.
        (small(Move8, via(0), variable, 0), ProgramFaultKind::ReservedWrite),
        (small(Move8, variable, via(0), 0), ProgramFaultKind::BadReference),
        (small(Copy, variable, via(0), 8), ProgramFaultKind::BadReference),
        (small(CallThis, 0, via(0), 0), ProgramFaultKind::BadReference),
        (small(CallVirtual, 0, frame(0), 0), ProgramFaultKind::BadReference),
        (small(CallVirtual, 0, variable, 0), ProgramFaultKind::BadReference),
        (small(IsKind, variable, frame(0), 0), ProgramFaultKind::BadReference),
        // Inputs are not written, and images have an end.
        (small(Move8, at(0x1000_0000), variable, 0), ProgramFaultKind::ReservedWrite),
        (small(Move8, variable, at(0x1000_0008), 0), ProgramFaultKind::BadReference),
        (small(Move64, variable, at(0x1000_0001), 0), ProgramFaultKind::BadReference),
        (small(Move16, at(0x3000_00C7), variable, 0), ProgramFaultKind::ReservedWrite),
        (small(Call, 9, 0, 0), ProgramFaultKind::Internal),
        (small(Jump, 1000, 0, 0), ProgramFaultKind::Internal),
    ];
    for (nth, (fault, kind)) in cases.into_iter().enumerate() {
        assert_eq!((fault.kind, fault.file, fault.line), (kind, 0, 2), "case {nth}");
    }
}

#[test]
fn null_is_a_bad_reference() {
    for op in [Move8, Move64] {
        for (a, b, kind) in [
            (via(0), frame(8), ProgramFaultKind::ReservedWrite),
            (frame(8), via(0), ProgramFaultKind::BadReference),
        ] {
            let mut build = Builder::default();
            build.program("MAIN", &[]);
            build.op(op, a, b, 0);
            build.op(Return, 0, 0, 0);
            assert_eq!(fault(build).kind, kind);
        }
    }
}

#[test]
fn recursion_ends_at_the_stack() {
    // n := n + 1 in each call: the stack of circles has room for 1000 calls or 64 Kbytes.
    for (bytes, expected) in [(8, 1000), (1024, 64)] {
        let mut build = Builder::default();
        let one = build.constant(&1u64.to_le_bytes());
        let n = build.global("n", Lint, 0);
        build.program("MAIN", &[1]);
        build.op(Call, 1, 0, 0);
        build.op(Return, 0, 0, 0);
        build.unit(bytes, &[], &[1]);
        build.op(Add64, at(n), at(n), at(one));
        let call = build.op(Call, 1, 0, 0);
        build.op(Return, 0, 0, 0);
        let mut machine = build.machine();
        let StopReason::Fault(fault) = cycle(&mut machine, &mut Board::default()).stop else { panic!() };
        assert_eq!((fault.kind, fault.line), (ProgramFaultKind::StackDepth, call + 1));
        let Value::Int(calls) = machine.read(machine.find("n").unwrap()) else { panic!() };
        assert!((calls - expected).abs() <= 1, "{calls}");
    }
}

#[test]
fn calls_without_circles_always_have_room() {
    // A chain of frames, twice: the deepest one counts.
    let mut build = Builder::default();
    build.program("MAIN", &[1, 2]);
    for callee in [1, 2] {
        build.op(Frame, callee, 0, 0);
        build.op(Call, callee, 0, 0);
    }
    build.op(Return, 0, 0, 0);
    build.unit(4096, &[1; 4096], &[3]);
    build.op(Frame, 3, 0, 0);
    build.op(Call, 3, 0, 0);
    build.op(Return, 0, 0, 0);
    build.unit(16, &[], &[]);
    build.op(Return, 0, 0, 0);
    build.unit(8192, &[2; 8192], &[]);
    build.op(Return, 0, 0, 0);
    let mut machine = build.machine();
    done(&mut machine);
    let expected = 64 + 4096 + 8192;
    let stack = machine.memory().len() - machine.program().image.len();
    assert!((expected..expected + 16).contains(&stack), "{stack}");
}

#[test]
fn methods_are_found_by_the_class() {
    let mut build = Builder::default();
    let one = build.constant(&1u32.to_le_bytes());
    // Two instances, of classes 1 and 2; the first 4 bytes name the class, then a number.
    let objects = [1u32, 2].map(|class| build.variable(&[class.to_le_bytes(), [0; 4]].concat()));
    let pointer = build.variable(&objects[1].to_le_bytes());
    let is = build.variable(&[9, 9]);
    let class = |unit, kinds: &[u32]| ObjectClass { methods: vec![None, Some(unit)], kinds: kinds.into() };
    build.program.classes = vec![class(1, &[0]), class(2, &[0, 3])];
    build.program("MAIN", &[1, 2]);
    build.op(FrameVirtual, 1, at(pointer), 0);
    build.op(CallVirtual, 1, at(pointer), 0);
    build.op(IsKind, at(is), at(pointer), 3);
    build.op(IsKind, at(is + 1), at(pointer), 1);
    build.op(CallThis, 1, at(objects[0]), 0);
    build.op(Return, 0, 0, 0);
    build.unit(8, &[], &[]);
    build.op(Add32, this(4), this(4), at(one));
    build.op(Return, 0, 0, 0);
    build.unit(8, &5u32.to_le_bytes(), &[1]);
    build.op(Move32, this(4), frame(0), 0);
    build.op(Frame, 1, 0, 0);
    build.op(CallSame, 1, 0, 0);
    build.op(Return, 0, 0, 0);
    let mut machine = build.machine();
    done(&mut machine);
    let number = |object: u32| machine.read(VarRef::new(object + 4, Dint));
    assert_eq!((number(objects[0]), number(objects[1])), (Value::Int(1), Value::Int(6)));
    assert_eq!(machine.memory()[is as usize..][..2], [1, 0]);
}

#[test]
fn texts_are_cut_and_compared() {
    let mut build = Builder::default();
    let long = build.constant(b"abcdefgh");
    let wide = build.constant(&[0x41, 0, 0xAC, 0x20, 0, 0]);
    let short = build.variable(&[b'z'; 4]);
    let narrow = build.variable(&[b'z'; 8]);
    let order = build.variable(&[0; 4]);
    let text = |of, bytes, wide| TextAt { at: Operand(at(of)), bytes, wide };
    let pair = |to, of| TextPair { to, of };
    build.program.texts = vec![
        // The storage ends the source.
        pair(text(short, 4, false), text(long, 8, false)),
        pair(text(narrow, 8, false), text(wide, 6, true)),
        pair(text(short, 4, false), text(long, 8, false)),
        pair(text(long, 8, false), text(short, 4, false)),
        pair(text(short, 4, false), text(short, 4, false)),
    ];
    build.program("MAIN", &[]);
    build.op(MoveText, 0, 0, 0);
    build.op(MoveText, 0, 0, 1);
    build.op(CompareText, at(order), 0, 2);
    build.op(CompareText, at(order + 1), 0, 3);
    build.op(CompareText, at(order + 2), 0, 4);
    build.op(Return, 0, 0, 0);
    let mut machine = build.machine();
    done(&mut machine);
    assert_eq!(machine.memory()[short as usize..][..4], *b"abc\0");
    assert_eq!(machine.memory()[narrow as usize..][..8], *b"A?\0zzzzz");
    assert_eq!(machine.memory()[order as usize..][..3], [0xFF, 1, 0]);
}

#[test]
fn the_images_in_every_width() {
    // Aligned: as one; else byte by byte. A line is named.
    let mut build = Builder::default();
    let value = build.constant(&0x8877_6655_4433_2211u64.to_le_bytes());
    let back = build.variable(&[0; 8]);
    let bit = build.variable(&[0; 8]);
    build.program("MAIN", &[]);
    build.op(Move32, at(0x3000_0004), at(value), 0);
    build.op(Move32, at(0x3000_000A), at(value), 0);
    build.op(Move64, at(back), at(0x3000_0006), 0);
    build.op(Copy, at(0x2000_0000), at(value), 4);
    build.op(Copy, at(0x2000_0001), at(0x2000_0000), 3);
    build.op(StoreBit, at(0x2000_0000), at(value), 33);
    build.op(LoadBit, at(bit), at(0x1000_0001), 3);
    build.op(Return, 0, 0, 0);
    let mut machine = build.machine();
    let mut board = Board::default();
    board.set("%IX1.3", 1);
    assert_eq!(cycle(&mut machine, &mut board).stop, StopReason::Done);
    assert_eq!(board.get("%MD1"), 0x4433_2211);
    assert_eq!((board.get("%MW5"), board.get("%MW6")), (0x2211, 0x4433));
    let stored: Vec<String> =
        board.stores.iter().map(|(at, value, line)| format!("{line} {at} {value:X}")).collect();
    let expected = [
        "1 %MD1 44332211",
        "2 %MB10 11",
        "2 %MB11 22",
        "2 %MB12 33",
        "2 %MB13 44",
        "4 %QW0 2211",
        "4 %QW1 4433",
        "5 %QB3 33",
        "5 %QB2 22",
        "5 %QB1 11",
        "6 %QX4.1 1",
    ];
    assert_eq!(stored, expected);
    // %MB6 and %MB7 are the high bytes of %MD1, then %MB8, %MB9 and those stored last.
    assert_eq!(machine.memory()[back as usize..][..8], [0x33, 0x44, 0, 0, 0x11, 0x22, 0x33, 0x44]);
    assert_eq!(machine.memory()[bit as usize], 1);
    // A watched location stops the slice.
    board.set("%MD1", 0);
    board.watched = Some(signal::Address::parse("%MX5.0").unwrap());
    machine.begin(0);
    let slice = machine.resume(0, Time::ZERO, Span::from_secs(1), &mut board);
    assert_eq!((slice.stop, slice.used), (StopReason::Touched { file: 0, line: 1 }, Span::from_nanos(10)));
}

#[test]
fn programs_of_a_task_follow_each_other() {
    let mut build = Builder::default();
    let half = build.constant(&0.5f32.to_le_bytes());
    let x = build.global("x", Real, 0);
    let n = build.global("n", Int, 0);
    for _ in 0..3 {
        build.program("P", &[]);
        build.op(AddF32, at(x), at(x), at(half));
        build.op(Return, 0, 0, 0);
    }
    let mut machine = build.machine();
    done(&mut machine);
    assert_eq!(machine.read(VarRef::new(x, Real)), Value::Real(1.5));
    assert!(machine.write(VarRef::new(n, Int), Value::Int(70_000)));
    assert_eq!(machine.read(VarRef::new(n, Int)), Value::Int(70_000 - 65_536));
    assert!(!machine.write(VarRef::new(0, Int), Value::Int(1)));
    assert_eq!(machine.read(VarRef(u32::MAX)), Value::Unknown);
}
