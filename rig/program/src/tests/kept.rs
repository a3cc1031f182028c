//! What survives and what is looked at from outside: retained images, Reset, forces, coverage, breakpoints, online
//! change.

use super::{Board, Builder, at, cycle, done};
use crate::code::Op::*;
use crate::host::StopReason;
use crate::machine::{ChangeError, ChangeReport, Machine};
use crate::program::{Program, Retention, Storage};
use crate::shape::{Member, MemoryLayout, ShapeId};
use crate::state::{BranchCoverage, StatementCoverage};
use crate::types::Elementary::{Bool, Dint, Int, Lint};
use signal::{Span, Time, Value};
use std::sync::Arc;

/// Four variables that grow by 1 each cycle: r (RETAIN), p (PERSISTENT), n, and a flag b (RETAIN).
fn four(order: [&str; 4]) -> Builder {
    let mut build = Builder::default();
    let one = build.constant(&1i32.to_le_bytes());
    let addresses = order.map(|name| {
        let ty = if name == "b" { Bool } else { Dint };
        let address = build.global(name, ty, i64::from(name != "b") * 10);
        match name {
            "r" => build.retain(address, 8, Retention::Retain),
            "b" => build.retain(address, 8, Retention::Retain),
            "p" => build.retain(address, 4, Retention::Persistent),
            _ => {}
        }
        (name, address)
    });
    build.program("MAIN", &[]);
    for (name, address) in addresses {
        if name == "b" {
            build.op(NotBool, at(address), at(address), 0);
        } else {
            build.op(Add32, at(address), at(address), at(one));
        }
    }
    build.op(Return, 0, 0, 0);
    build
}

fn values(machine: &Machine) -> [Value; 4] {
    ["r", "p", "n", "b"].map(|name| machine.read(machine.find(name).unwrap()))
}

#[test]
fn reset_keeps_what_it_says() {
    for (retain, persistent, expected) in
        [(true, true, [11, 11, 10, 1]), (false, true, [10, 11, 10, 0]), (false, false, [10, 10, 10, 0])]
    {
        let mut machine = four(["r", "p", "n", "b"]).machine();
        done(&mut machine);
        assert!(machine.retained_dirty() && !machine.retained_dirty());
        machine.reset(retain, persistent);
        assert_eq!(values(&machine), expected.map(Value::Int));
        assert_eq!(machine.retained_dirty(), !retain);
    }
}

#[test]
fn a_retained_image_goes_round() {
    let mut machine = four(["r", "p", "n", "b"]).machine();
    done(&mut machine);
    // 8 bytes of layout, two DINT, a BOOL: gaps are not kept.
    assert_eq!(machine.retained_len(), 8 + 4 + 4 + 1);
    let mut image = [0xEE; 20];
    assert!(!machine.save_retained(&mut image[..16]));
    assert_eq!(image, [0xEE; 20]);
    assert!(machine.save_retained(&mut image));
    assert_eq!(image[8..], [11, 0, 0, 0, 11, 0, 0, 0, 1, 0xEE, 0xEE, 0xEE]);
    let image = &image[..17];
    // A program with other variables in other places takes it, one with another layout does not.
    let mut other = four(["n", "r", "p", "b"]).machine();
    assert!(other.restore_retained(image));
    assert_eq!(values(&other), [11, 11, 10, 1].map(Value::Int));
    let mut swapped = four(["p", "r", "n", "b"]).machine();
    assert!(!swapped.restore_retained(image));
    assert_eq!(values(&swapped), [10, 10, 10, 0].map(Value::Int));
    // Damage.
    for length in 0..17 {
        assert!(!other.restore_retained(&image[..length]));
    }
    let mut damaged = image.to_vec();
    damaged[3] ^= 1;
    assert!(!other.restore_retained(&damaged));
    // A BOOL is 0 or 1.
    let mut odd = image.to_vec();
    odd[16] = 0xFE;
    assert!(other.restore_retained(&odd));
    let b = other.program().find("b").unwrap();
    let Storage::Cell(b) = b.storage else { panic!() };
    assert_eq!(other.memory()[b.address() as usize], 0);
}

#[test]
fn a_program_without_retained_variables_has_no_image() {
    let mut build = Builder::default();
    build.global("n", Dint, 1);
    let mut machine = build.machine();
    assert_eq!(machine.retained_len(), 0);
    assert!(machine.save_retained(&mut []) && machine.restore_retained(&[]));
}

#[test]
fn forces_hold_at_both_ends_of_a_cycle() {
    let mut machine = four(["r", "p", "n", "b"]).machine();
    let n = machine.find("n").unwrap();
    assert!(machine.force(n, Value::Int(100)));
    assert!(!machine.force(n, Value::Unknown));
    assert_eq!(machine.forced().collect::<Vec<_>>(), [(n, Value::Int(100))]);
    machine.begin(0);
    // In the middle the program has its way.
    let slice = machine.resume(0, Time::ZERO, Span::from_nanos(30), &mut Board::default());
    assert!(matches!(slice.stop, StopReason::Budget { .. }));
    assert_eq!(machine.read(n), Value::Int(101));
    let slice = machine.resume(0, Time::ZERO, Span::from_nanos(30), &mut Board::default());
    assert_eq!((slice.stop, machine.read(n)), (StopReason::Done, Value::Int(100)));
    assert!(machine.write(n, Value::Int(5)));
    machine.begin(0);
    assert_eq!(machine.read(n), Value::Int(100));
    assert!(machine.release(n) && !machine.release(n));
    done(&mut machine);
    assert_eq!(machine.read(n), Value::Int(101));
    assert!(machine.force(n, Value::Int(1)));
    machine.release_all();
    assert_eq!(machine.forced().count(), 0);
}

/// IF n < 2 THEN n := n + 1; END_IF; m := n;
fn branches() -> Builder {
    let mut build = Builder::default();
    let one = build.constant(&1i32.to_le_bytes());
    let two = build.constant(&2i32.to_le_bytes());
    let n = build.global("n", Dint, 0);
    let m = build.global("m", Dint, 0);
    build.program("MAIN", &[]);
    build.statement(JumpLeI32, 2, at(two), at(n));
    build.statement(Add32, at(n), at(n), at(one));
    build.statement(Move32, at(m), at(n), 0);
    build.op(Return, 0, 0, 0);
    build
}

#[test]
fn coverage_of_statements_and_branches() {
    let mut machine = branches().machine();
    let executed = |machine: &Machine| {
        let coverage = machine.coverage();
        assert_eq!(coverage.statements.iter().map(|s| s.line).collect::<Vec<_>>(), [1, 2, 3]);
        let [branch] = coverage.branches[..] else { panic!() };
        (coverage.statements.iter().map(|s| s.executed).collect::<Vec<_>>(), branch.taken, branch.passed)
    };
    done(&mut machine);
    machine.set_coverage(true);
    assert_eq!(executed(&machine), (vec![false; 3], false, false));
    done(&mut machine);
    assert_eq!(executed(&machine), (vec![true; 3], false, true));
    done(&mut machine);
    assert_eq!(executed(&machine), (vec![true; 3], true, true));
    machine.set_coverage(true);
    done(&mut machine);
    assert_eq!(executed(&machine), (vec![true, false, true], true, false));
    let coverage = machine.coverage();
    assert_eq!(coverage.statements[1], StatementCoverage { file: 0, line: 2, executed: false });
    assert_eq!(coverage.branches, [BranchCoverage { file: 0, line: 1, taken: true, passed: false }]);
}

#[test]
fn breakpoints_and_single_steps() {
    let mut machine = branches().machine();
    assert_eq!(machine.set_breakpoint(0, 2), Some(2));
    assert_eq!(machine.set_breakpoint(0, 4), None);
    assert_eq!(machine.set_breakpoint(1, 1), None);
    let mut board = Board::default();
    let mut go = |machine: &mut Machine, budget| {
        let slice = machine.resume(0, Time::ZERO, Span::from_nanos(budget), &mut board);
        (slice.stop, slice.used.as_nanos())
    };
    machine.begin(0);
    assert_eq!(go(&mut machine, 1000), (StopReason::Break, 10));
    assert_eq!(machine.read(machine.find("n").unwrap()), Value::Int(0));
    // It goes on, even in slices that are too short.
    assert_eq!(go(&mut machine, 5), (StopReason::Budget { next: Span::from_nanos(10) }, 0));
    assert_eq!(go(&mut machine, 10), (StopReason::Budget { next: Span::from_nanos(10) }, 10));
    assert_eq!(go(&mut machine, 1000), (StopReason::Done, 20));
    machine.clear_breakpoints();
    machine.begin(0);
    for used in [0, 10, 10] {
        machine.step(0);
        assert_eq!(go(&mut machine, 1000), (StopReason::Break, used));
    }
    machine.step(0);
    assert_eq!(go(&mut machine, 1000), (StopReason::Done, 20));
    // A step that meets no statement waits for the next cycle.
    machine.begin(0);
    assert_eq!(go(&mut machine, 1000), (StopReason::Break, 0));
    assert_eq!(go(&mut machine, 1000), (StopReason::Done, 30));
}

/// A block with a counter and a running timer, an array, and a plain variable, at places that depend on `shift`.
fn changing(shift: u32, members: &[&str], bounds: (i64, i64)) -> Arc<Program> {
    let mut build = Builder::default();
    build.program.natives = crate::native::STANDARD.iter().filter(|native| native.name == "TON").collect();
    let native = build.program.natives[0];
    let (offsets, timer_size) = native.layout();
    if shift > 0 {
        build.variable(&vec![0; shift as usize]);
    }
    let dint = build.shape(MemoryLayout::Elementary(Dint));
    let lint = build.shape(MemoryLayout::Elementary(Lint));
    let address = build.shape(MemoryLayout::Address);
    // Only IN shows here.
    let pins = vec![Member { name: "IN".into(), offset: u32::from(offsets[0]), shape: dint }];
    let timer = build.shape(MemoryLayout::Members {
        name: "TON".into(),
        members: pins,
        size: timer_size,
        block: true,
    });
    let mut list = Vec::new();
    let mut size = 8;
    for name in members {
        let (shape, bytes): (ShapeId, u32) = match *name {
            "t" => (timer, timer_size),
            "p" => (address, 8),
            "wide" => (lint, 8),
            _ => (dint, 8),
        };
        let name = if *name == "wide" { "n" } else { name };
        list.push(Member { name: name.into(), offset: size, shape });
        size += bytes;
    }
    let block = build.variable(&vec![0; size as usize]);
    build.root("fb", MemoryLayout::Members { name: "FB".into(), members: list, size, block: true }, block);
    let count = (bounds.1 - bounds.0 + 1) as u32;
    let array = build.variable(&vec![0; (4 * count) as usize]);
    build.root("a", MemoryLayout::Array { dimensions: vec![bounds], of: dint, stride: 4 }, array);
    build.program("MAIN", &[]);
    build.op(Return, 0, 0, 0);
    build.finish()
}

#[test]
fn an_online_change_keeps_values_by_path_and_type() {
    let old = changing(0, &["n", "t", "p", "gone"], (0, 9));
    let mut machine = Machine::new(old.clone(), &[vec![0]]).unwrap();
    let set = |machine: &mut Machine, path: &str, value| {
        let variable = machine.find(path).unwrap();
        assert!(machine.write(variable, Value::Int(value)), "{path}");
    };
    for (path, value) in [("fb.n", 7), ("FB.T.in", 1), ("a[3]", 33), ("a[9]", 99), ("fb.gone", 5)] {
        set(&mut machine, path, value);
    }
    // The timer's hidden state.
    let timer = machine.program().find("fb.t.IN").unwrap();
    let Storage::Cell(timer) = timer.storage else { panic!() };
    let (_, size) = old.natives[0].layout();
    machine.set_variable(timer.address() + size - 3, &[42]);
    let n = machine.find("fb.n").unwrap();
    assert!(machine.force(n, Value::Int(8)));
    // In the middle of a cycle it is refused.
    machine.begin(0);
    assert_eq!(machine.change(old, &[vec![0]]), Err(ChangeError::Busy { task: 0 }));
    assert_eq!(cycle(&mut machine, &mut Board::default()).stop, StopReason::Done);
    let new = changing(24, &["more", "t", "n", "p"], (0, 9));
    let report = machine.change(new, &[vec![0]]).unwrap();
    // Kept: n, t.IN, a; lost: p and `gone`; new: p and `more`.
    assert_eq!(report, ChangeReport { kept: 3, new: 2, lost: 2 });
    let read = |machine: &Machine, path: &str| machine.read(machine.find(path).unwrap());
    for (path, value) in [("fb.n", 8), ("fb.t.IN", 1), ("a[3]", 33), ("a[9]", 99), ("fb.more", 0)] {
        assert_eq!(read(&machine, path), Value::Int(value), "{path}");
    }
    let timer = machine.find("fb.t.IN").unwrap();
    assert_eq!(machine.memory()[(timer.address() + size - 3) as usize], 42);
    assert_eq!(machine.forced().collect::<Vec<_>>(), [(machine.find("fb.n").unwrap(), Value::Int(8))]);
    // Another type is another variable; of an array what is in both stays.
    let report = machine.change(changing(0, &["wide"], (3, 4)), &[vec![0]]).unwrap();
    assert_eq!(report, ChangeReport { kept: 1, new: 1, lost: 4 });
    assert_eq!([read(&machine, "fb.n"), read(&machine, "a[3]")], [0, 33].map(Value::Int));
}

#[test]
fn paths_lead_to_variables() {
    let mut build = Builder::default();
    let int = build.shape(MemoryLayout::Elementary(Int));
    let row = build.shape(MemoryLayout::Array { dimensions: vec![(0, 2), (-1, 1)], of: int, stride: 2 });
    let point = build.shape(MemoryLayout::Members {
        name: "POINT".into(),
        members: vec![
            Member { name: "x".into(), offset: 0, shape: int },
            Member { name: "m".into(), offset: 2, shape: row },
        ],
        size: 20,
        block: false,
    });
    let points = MemoryLayout::Array { dimensions: vec![(1, 3)], of: point, stride: 20 };
    let points = build.shape(points);
    let both = [("P", 0), ("Q", 0)];
    for (name, _) in both {
        let members = vec![
            Member { name: "s".into(), offset: 0, shape: points },
            Member { name: format!("only{name}"), offset: 60, shape: int },
        ];
        let address = build.variable(&[0; 64]);
        build.root(
            name,
            MemoryLayout::Members { name: name.into(), members, size: 62, block: true },
            address,
        );
        build.program(name, &[]);
    }
    build.root("P.lamp", MemoryLayout::Elementary(Bool), 0x2000_0001);
    build.program.roots.last_mut().unwrap().bit = 3;
    let program = build.finish();
    let at = |path: &str| program.resolve(path).map(|variable| variable.address());
    let base = program.roots[0].address;
    assert_eq!(at("p.s[2].x"), Some(base + 20));
    assert_eq!(at(" P . S [ 3 ] . m [ 2 , 0 ] "), Some(base + 40 + 2 + 2 * (2 * 3 + 1)));
    assert_eq!(at("onlyQ"), Some(base + 64 + 60));
    for wrong in [
        "s[1].x",
        "P.s[0].x",
        "P.s[4].x",
        "P.s[1]",
        "P.s[1].m",
        "P.s[1].m[1]",
        "P",
        "",
        "P.",
        "P.s[",
        "lamp",
        "x[1",
    ] {
        assert_eq!(at(wrong), None, "{wrong}");
    }
    let array = program.find("P.s[1].M").unwrap();
    assert_eq!((array.path.as_str(), array.ty, array.dimensions), ("P.s[1].m", Int, vec![(0, 2), (-1, 1)]));
    let lamp = program.find("LAMP").unwrap();
    assert_eq!(lamp.storage, Storage::Located(signal::Address::parse("%QX1.3").unwrap()));
    let paths: Vec<&str> = program.variables().iter().map(|variable| variable.path.as_str()).collect();
    assert_eq!(paths.len(), 2 * (3 * 2 + 1) + 1);
    assert_eq!(paths[..3], ["P.s[1].x", "P.s[1].m", "P.s[2].x"]);
}
