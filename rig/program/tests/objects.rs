//! Objects, structures, pointers, texts: the parts of the language working together.

use crate::support::Rig;

/// Runs one cycle and compares what the variables show.
fn shows(text: &str, expected: &[(&str, &str)]) {
    let mut rig = Rig::new(text);
    rig.cycle();
    let shown = |path: &str| {
        rig.machine
            .show(path, &mut crate::support::Memory::default())
            .map(|shown| shown.to_string())
            .unwrap_or_default()
    };
    for (path, value) in expected {
        assert_eq!(shown(path), *value, "{path}");
    }
}

#[test]
fn types_and_objects() {
    let expected = [
        // square.area(2.0) with a side of 2.0; the cube multiplies once more and adds its side.
        ("a1", "8.0"),
        ("a2", "10.0"),
        ("k", "105"),
        ("i", "4"),
        ("j", "3"),
        ("f", "2.0"),
        ("lo", "1"),
        ("hi", "3"),
        ("s.calls", "1"),
        ("q.calls", "11"),
        ("arr[2]", "77"),
        ("arr[3]", "78"),
        ("arr[4]", "79"),
        ("arr[9]", "6"),
        // STRING(20) cuts.
        ("text", "'hello world and more'"),
        ("len1", "20"),
        ("bt", "TRUE"),
        ("b0", "16#12"),
        ("w", "16#1235"),
        ("un.b[0]", "16#CD"),
        ("un.b[1]", "16#AB"),
        ("c", "blue"),
        ("cs", "2"),
        ("ok", "TRUE"),
        ("dt1", "DT#2024-02-29-00:00:01"),
        ("t", "T#1d1s"),
        ("n5", "3628800"),
        ("pt.x", "2.5"),
        ("pt.y", "1.5"),
        ("pt.name", "'longer tha'"),
        ("pt.z", "1E300"),
        ("tt", "T#1s500ms"),
        ("ws", "'wider'"),
        ("st", "'1.5-42'"),
    ];
    shows(include_str!("programs/objects.st"), &expected);
}

#[test]
fn calls() {
    let expected = [
        // Arguments from left to right: 2, then 3, then the variable that is 3 by now.
        ("MAIN.k", "332"),
        ("MAIN.a", "11"),
        ("fs", "9"),
        ("s", "'HELLO'"),
        ("t1", "'wau'"),
        ("t2", "'piep'"),
        ("t3", "'pieppiep'"),
        ("ss", "'wauwau'"),
        ("legs", "24"),
        // A chain of calls on what each gives back by reference.
        ("l.n", "2"),
        ("l.items[1]", "4"),
        ("tot", "28"),
        // VAR_TEMP begins at 5 in every call: 6, 7 and 8.
        ("z", "22"),
        // The task runs it too.
        ("helper.c", "3"),
        ("hs", "42"),
        ("acc", "30"),
        ("r.id", "43"),
        ("ok", "TRUE"),
        ("si", "-128"),
        ("re", "3.5"),
        ("w", "16#F08"),
        // OR computes both sides.
        ("b", "2"),
    ];
    shows(include_str!("programs/calls.st"), &expected);
}
