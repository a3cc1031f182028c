//! Showing, setting, listing.

use super::{Board, Builder, at, frame};
use crate::code::{Op::*, Operand, TextAt, TextPair};
use crate::machine::Machine;
use crate::set::SetError;
use crate::shape::{Member, MemoryLayout};
use crate::types::Elementary::{self, *};

fn machine() -> Machine {
    let mut build = Builder::default();
    for ty in Elementary::ALL {
        build.global(ty.name(), ty, 0);
    }
    let byte = build.shape(MemoryLayout::Elementary(Byte));
    let colour = MemoryLayout::Enumeration {
        name: "COLOUR".into(),
        base: Int,
        values: vec![("red".into(), 1), ("Green".into(), -5)],
    };
    let colour = build.shape(colour);
    let percent = build.shape(MemoryLayout::Subrange { base: Usint, low: 10, high: 100 });
    let text = build.shape(MemoryLayout::Text { wide: false, length: 5 });
    let wide = build.shape(MemoryLayout::Text { wide: true, length: 3 });
    let list = build.shape(MemoryLayout::Array { dimensions: vec![(1, 3)], of: byte, stride: 1 });
    let pointer = build.shape(MemoryLayout::Address);
    let shapes = [
        ("c", 0, colour),
        ("p", 2, percent),
        ("t", 3, text),
        ("w", 10, wide),
        ("a", 18, list),
        ("q", 24, pointer),
    ];
    let members = shapes.map(|(name, offset, shape)| Member { name: name.into(), offset, shape });
    let address = build.variable(&[0; 32]);
    build.root(
        "s",
        MemoryLayout::Members { name: "S".into(), members: members.into(), size: 28, block: false },
        address,
    );
    build.root("%q", MemoryLayout::Array { dimensions: vec![(0, 1)], of: byte, stride: 1 }, 0x2000_0002);
    build.machine()
}

#[test]
fn what_is_set_is_shown() {
    let mut machine = machine();
    let mut board = Board::default();
    let cases = [
        ("BOOL", "true", "TRUE"),
        ("SINT", "-128", "-128"),
        ("UINT", "16#FF_FF", "65535"),
        ("DINT", "DINT#-2#101", "-5"),
        ("ULINT", "18446744073709551615", "18446744073709551615"),
        ("LINT", "-9223372036854775808", "-9223372036854775808"),
        ("WORD", "8#17", "16#F"),
        ("REAL", "1.5", "1.5"),
        ("LREAL", "-2e3", "-2000.0"),
        ("TIME", "T#1m30s500ms", "T#1m30s500ms"),
        ("DATE", "D#2024-02-29", "D#2024-02-29"),
        ("TIME_OF_DAY", "TOD#12:30:15.25", "TOD#12:30:15.250"),
        ("DATE_AND_TIME", "DT#2024-02-29-12:30:15", "DT#2024-02-29-12:30:15"),
        ("CHAR", "'x'", "'x'"),
        ("s.c", "green", "Green"),
        ("s.c", "COLOUR#red", "red"),
        ("s.p", "100", "100"),
        ("s.t", "'it$'s$N'", "'it$'s$N'"),
        ("s.t", "plain", "'plain'"),
        ("s.w", "\"\u{20AC}\"", "'\u{20AC}'"),
        ("s.a[2]", "7", "16#7"),
        ("%q[1]", "5", "16#5"),
    ];
    for (path, text, expected) in cases {
        assert_eq!(machine.set(path, text, &mut board), Ok(()), "{path} {text}");
        let shown = machine.show(path, &mut board).unwrap().to_string();
        assert_eq!(shown, expected, "{path} {text}");
    }
    assert_eq!(board.get("%QB3"), 5);
    let shown = machine.show("s", &mut board).unwrap().to_string();
    assert_eq!(
        shown,
        "(c := red, p := 100, t := 'plain', w := '\u{20AC}', a := [16#0, 16#7, 16#0], q := NULL)"
    );
}

#[test]
fn what_cannot_be_set_says_why() {
    let mut machine = machine();
    let mut board = Board::default();
    let before = machine.memory().to_vec();
    let range = |low, high| SetError::Range { low, high };
    let cases = [
        ("nobody", "1", SetError::NoSuchVariable),
        ("s", "1", SetError::NotSettable),
        ("s.a", "1", SetError::NotSettable),
        ("s.q", "1", SetError::NotSettable),
        ("SINT", "128", range(-128, 127)),
        ("USINT", "-1", range(0, 255)),
        ("s.p", "9", range(10, 100)),
        ("INT", "", SetError::Form("12")),
        ("INT", "1.5", SetError::Form("12")),
        ("INT", "16#G", SetError::Form("12")),
        ("WORD", "x", SetError::Form("16#FF")),
        ("BOOL", "2", SetError::Form("TRUE")),
        ("REAL", "NaN", SetError::Form("1.5")),
        ("REAL", "1e99", SetError::Magnitude(Elementary::Real)),
        ("REAL", "-1e-40", SetError::Magnitude(Elementary::Real)),
        ("TIME", "T#", SetError::Form("T#1m30s")),
        ("TIME", "T#5", SetError::Form("T#1m30s")),
        ("TIME", "T#60d", range(0, 4_294_967_295)),
        ("DATE", "D#2023-02-29", SetError::Form("D#2024-02-29")),
        ("TIME_OF_DAY", "TOD#24:00:00", SetError::Form("TOD#12:30:00")),
        ("s.c", "blue", SetError::NoSuchName),
        ("s.c", "2", SetError::NoSuchName),
        ("s.t", "too long", SetError::TooLong(5)),
        ("s.t", "\u{20AC}", SetError::Character),
        ("s.t", "'$Q'", SetError::Form("'one$Ntwo'")),
    ];
    for (path, text, error) in cases {
        assert_eq!(machine.set(path, text, &mut board), Err(error), "{path} {text}");
        assert!(!error.to_string().is_empty());
    }
    assert_eq!(machine.memory(), before);
}

#[test]
fn a_listing_names_operands() {
    let mut build = Builder::default();
    let text = build.constant(b"hi\0");
    let seven = build.constant(&7i32.to_le_bytes());
    let n = build.global("n", Dint, 0);
    let int = build.shape(MemoryLayout::Elementary(Int));
    let list = build.variable(&[0; 8]);
    build.root("a", MemoryLayout::Array { dimensions: vec![(1, 4)], of: int, stride: 2 }, list);
    let line = TextAt { at: Operand(at(text)), bytes: 3, wide: false };
    build.program.texts.push(TextPair { to: TextAt { at: Operand(frame(8)), ..line }, of: line });
    build.program("MAIN", &[1]);
    build.op(Add32, at(n), at(n), at(seven));
    build.op(Move16, at(list + 4), frame(2), 0);
    build.program.lines[1] = 1;
    build.op(MoveText, 0, 0, 0);
    build.op(Call, 1, 0, 0);
    build.op(JumpIf, 0, frame(0), 0);
    build.unit(8, &[], &[]);
    build.op(Return, 0, 0, 0);
    let program = build.finish();
    let source = document::SourceFile { name: "x.st".into(), text: "  first\nsecond\n third ".into() };
    let units = program.listing(&[source]);
    let mut shown = Vec::new();
    for unit in &units {
        shown.push(unit.name.clone());
        for line in &unit.lines {
            shown.push(format!("{} {}", line.line, line.text));
            shown.extend(line.steps.iter().map(|step| format!("  {} {} {}", step.pc, step.text, step.cost)));
        }
    }
    let expected = [
        "U0",
        "1 first",
        "  0 Add32 n, n, #7 10",
        "  1 Move16 a[3], @2 10",
        "3 third",
        "  2 MoveText @8, 'hi' 10",
        "4 ",
        "  3 Call U1 10",
        "5 ",
        "  4 JumpIf @0, to 0 10",
        "U1",
        "6 ",
        "  5 Return 10",
    ];
    assert_eq!(shown, expected);
}
