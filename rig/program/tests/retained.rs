//! What is kept over restarts (controller:REM-01, controller:REM-02, controller:REM-06).

use crate::support::{Rig, build, codes};
use scanrig_program::Retention;
use signal::Value;

const TEXT: &str = "
    FUNCTION_BLOCK block VAR_INPUT x : INT; END_VAR VAR RETAIN kept : INT; END_VAR VAR lost : INT; END_VAR
      kept := kept + 1; lost := lost + 1;
    END_FUNCTION_BLOCK
    VAR_GLOBAL PERSISTENT RETAIN p : DINT := 7; END_VAR
    PROGRAM MAIN
    VAR v : INT := 3; b : block; END_VAR
    VAR RETAIN r : SINT; big : ULINT; whole : block; END_VAR
      p := p + 1; v := v + 1; r := r - 1; big := big - 1; b(); whole();
    END_PROGRAM";

fn all(rig: &Rig) -> Vec<i128> {
    ["p", "v", "r", "big", "b.kept", "b.lost", "whole.kept", "whole.lost"].map(|path| rig.int(path)).to_vec()
}

#[test]
fn resets_keep_what_the_table_says() {
    // controller:REM-02
    for (retain, persistent, expected) in [
        (true, true, vec![8, 3, -1, u64::MAX.into(), 1, 0, 1, 1]),
        (false, true, vec![8, 3, 0, 0, 0, 0, 0, 0]),
        (false, false, vec![7, 3, 0, 0, 0, 0, 0, 0]),
    ] {
        let mut rig = Rig::new(TEXT);
        rig.cycle();
        rig.machine.reset(retain, persistent);
        assert_eq!(all(&rig), expected, "{retain} {persistent}");
    }
}

#[test]
fn an_image_brings_back_what_is_retained() {
    let mut rig = Rig::new(TEXT);
    assert!(!rig.machine.retained_dirty());
    rig.cycle();
    assert!(rig.machine.retained_dirty() && !rig.machine.retained_dirty());
    // 4 of p, 1 of r, 8 of big, 2 of b.kept, 3 times 2 of whole, 8 of the hash.
    assert_eq!(rig.machine.retained_len(), 29);
    let mut image = vec![0; 40];
    assert!(rig.machine.save_retained(&mut image));
    assert!(!rig.machine.save_retained(&mut image[..28]));
    let mut other = Rig::new(TEXT);
    assert!(other.machine.restore_retained(&image[..29]));
    assert_eq!(all(&other), [8, 3, -1, u64::MAX.into(), 1, 0, 1, 1]);
    assert!(!other.machine.restore_retained(&image));
}

#[test]
fn an_image_of_other_variables_is_refused() {
    // controller:REM-06 - the same sizes under other names are other variables.
    let mut image = vec![0; 29];
    assert!(Rig::new(TEXT).machine.save_retained(&mut image));
    let mut other = Rig::new(&TEXT.replace("big", "huge"));
    assert!(!other.machine.restore_retained(&image));
    // Code alone may differ.
    let mut same = Rig::new(&TEXT.replace("v := v + 1;", "v := v + 2;"));
    assert!(same.machine.restore_retained(&image));
}

#[test]
fn another_program_takes_the_persistent_variables_that_both_have() {
    // controller:REM-02 note 2, controller:REM-06
    let mut old = Rig::new(TEXT);
    old.cycle();
    let (map, mut image) = (old.machine.retained_map(), vec![0; 29]);
    assert!(old.machine.save_retained(&mut image));
    let adopt = |text: &str| {
        let mut new = Rig::new(text);
        let all = new.machine.adopt_retained(&map, &image);
        (all, new.int("p"), new.int("big"))
    };
    assert_eq!(adopt(TEXT), (true, 8, 0), "only what is persistent");
    let moved = TEXT.replace("VAR_GLOBAL PERSISTENT RETAIN", "VAR_GLOBAL PERSISTENT RETAIN first : LINT;");
    assert_eq!(adopt(&moved), (true, 8, 0), "by its name, wherever it lies");
    assert_eq!(adopt(&TEXT.replace("r : SINT", "r : INT")), (false, 8, 0), "one is of another type");
    assert_eq!(adopt(&TEXT.replace("p : DINT", "p : UDINT")), (false, 7, 0));
    let plain = TEXT.replace("VAR_GLOBAL PERSISTENT RETAIN", "VAR_GLOBAL RETAIN");
    assert_eq!(adopt(&plain), (false, 7, 0), "it is no longer persistent");
    // Whatever does not belong together changes nothing.
    let mut new = Rig::new(TEXT);
    for (map, image) in
        [(&map[..], &image[..8]), (&map[..20], &image[..]), (&[][..], &image[..]), (&map[..], &[][..])]
    {
        assert!(!new.machine.adopt_retained(map, image));
    }
    for place in 0..map.len() {
        let mut torn = map.clone();
        torn[place] ^= 0x55;
        Rig::new(TEXT).machine.adopt_retained(&torn, &image);
    }
    assert_eq!(new.int("p"), 7);
    assert!(new.machine.adopt_retained(&[], &[]), "neither had anything to keep");
}

#[test]
fn declarations_are_the_same_where_code_alone_differs() {
    // controller:REM-02 note 1
    let of = |text: &str| build(text).declarations();
    assert_eq!(of(TEXT), of(&TEXT.replace("v := v + 1", "v := v + 2; v := v * 3")));
    for (was, is) in [("v : INT := 3", "v : INT := 4"), ("v : INT", "v : DINT"), ("v : INT", "u, v : INT")] {
        assert_ne!(of(TEXT), of(&TEXT.replace(was, is)), "{is}");
    }
    assert_ne!(of(TEXT), of(&TEXT.replace("VAR RETAIN r", "VAR PERSISTENT r")));
}

#[test]
fn identity_is_that_of_code_and_variables() {
    // controller:STATE-10
    let signature = |text: &str| build(text).signature();
    assert_eq!(signature(TEXT), signature(&TEXT.replace("PROGRAM MAIN\n", "PROGRAM MAIN (* main *)\n\n")));
    assert_ne!(signature(TEXT), signature(&TEXT.replace("v + 1", "v + 2")));
    assert_ne!(signature(TEXT), signature(&TEXT.replace("v : INT", "v : UINT")));
    assert_ne!(signature(TEXT), signature(&TEXT.replace("RETAIN r", "PERSISTENT r")));
}

#[test]
fn a_write_from_outside_counts_as_a_change() {
    let mut rig = Rig::new(TEXT);
    rig.write("v", Value::Int(9));
    assert!(!rig.machine.retained_dirty());
    rig.write("p", Value::Int(7));
    assert!(!rig.machine.retained_dirty());
    rig.write("p", Value::Int(8));
    assert!(rig.machine.retained_dirty());
}

#[test]
fn variables_report_how_they_are_kept() {
    let program = build(TEXT);
    let kept = |path: &str| program.find(path).unwrap().retention;
    assert_eq!(kept("p"), Retention::Persistent);
    assert_eq!((kept("r"), kept("whole.lost"), kept("b.kept"), kept("b.lost")), {
        use Retention::{None, Retain};
        (Retain, Retain, Retain, None)
    });
}

#[test]
fn the_store_has_64_kbytes() {
    // controller:MEM-08 - 8191 values of 8 bytes and the hash fill it.
    let with = |n: u32| {
        format!("PROGRAM MAIN VAR RETAIN a : ARRAY[1..{n}] OF LWORD; END_VAR a[1] := 1; END_PROGRAM")
    };
    assert_eq!(Rig::new(&with(8191)).machine.retained_len(), 65_536);
    assert_eq!(codes(&with(8192)), ["S0503"]);
}
