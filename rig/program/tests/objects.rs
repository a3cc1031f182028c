//! Objects, structures, pointers, texts: the parts of the language working together.

mod support;

use support::Rig;

const TEXT: &str = include_str!("programs/objects.st");

#[test]
fn everything_together() {
    let mut rig = Rig::new(TEXT);
    rig.cycle();
    let shown = |path: &str| {
        rig.machine
            .show(path, &mut support::Memory::default())
            .map(|shown| shown.to_string())
            .unwrap_or_default()
    };
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
    for (path, value) in expected {
        assert_eq!(shown(path), value, "{path}");
    }
}
