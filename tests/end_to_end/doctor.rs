//! `rig doctor`: what it says of machines of several kinds, and of the one that the test runs on.

use crate::goldens::golden;
use crate::project_folder::{TestProject, root};
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::Path;

/// Makes the files of a machine: after `== PATH` come its text, and beside it its mode and the name of its group.
/// `@gpio` stands for the group that the files have, `@other` for a user and a group that they do not have.
fn make(bench: &TestProject, name: &str) {
    let text = std::fs::read_to_string(root().join(format!("tests/end_to_end/machines/{name}.txt"))).unwrap();
    bench.write("machine/made", "");
    let about = std::fs::metadata(bench.path("machine/made")).unwrap();
    std::fs::remove_file(bench.path("machine/made")).unwrap();
    let (gpio, other) = (about.gid().to_string(), (about.uid().max(about.gid()) + 1).to_string());
    let text = text.replace("@gpio", &gpio).replace("@other", &other);
    for part in text.split("\n== ").skip(1) {
        let (head, body) = part.split_once('\n').unwrap_or((part, ""));
        let mut words = head.split(' ');
        let path = format!("machine/{}", words.next().unwrap());
        bench.write(&path, body);
        if let Some(mode) = words.next() {
            let mode = u32::from_str_radix(mode, 8).unwrap();
            std::fs::set_permissions(bench.path(&path), std::fs::Permissions::from_mode(mode)).unwrap();
        }
    }
}

#[test]
fn machines_of_several_kinds() {
    for (name, code) in [("pi-stock", 1), ("pi-ready", 0), ("pc", 1), ("container", 1), ("silent", 1)] {
        let bench = TestProject::new();
        make(&bench, name);
        let ran = bench.expect(code, &["doctor", "--root", "machine"]);
        golden(&format!("doctor-{name}.txt"), &format!("rig doctor # {name}"), &ran);
        // A program reads the same.
        let ran = bench.expect(code, &["doctor", "--root", "machine", "--format", "json"]);
        let json: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
        assert_eq!(json["verdict"] == "fit", code == 0, "{name}");
        assert!(json["checks"].as_array().unwrap().len() > 15, "{name}");
    }
}

#[test]
fn a_board_file_says_which_devices_count() {
    let bench = TestProject::new();
    make(&bench, "container");
    let last = |code, board: &str| {
        bench.write("board.toml", board);
        let ran = bench.expect(code, &["doctor", "board.toml", "--root", "machine"]);
        ran.out.lines().last().unwrap().to_owned()
    };
    let real = "format = 1\n[board]\nkind = \"real\"\n";
    let bus = "[buses]\nmachine = { kind = \"can\", interface = \"can0\", bitrate = 250_000 }\n";
    assert_eq!(last(1, &format!("{real}{bus}")), "not fit for real lines: CAN");
    let line = "[chips]\nmain = { label = \"a\" }\n[channels]\nI0 = { kind = \"digital\", line = 0 }\n";
    assert_eq!(last(1, &format!("{real}{line}")), "not fit for real lines: GPIO");
    // A port of the machine's own stands in no list of adapters.
    let port = "[buses]\nline = { kind = \"serial\", path = \"/dev/ttyAMA9\", baud = 9600 }\n";
    assert_eq!(last(1, &format!("{real}{port}")), "not fit for real lines: serial");
    bench.write("machine/dev/ttyAMA9", "");
    let ran = bench.rig(&["doctor", "board.toml", "--root", "machine"]);
    assert!(ran.out.lines().last().unwrap().starts_with("fit for real lines"), "{}", ran.out);
    bench.write("board.toml", "format = 1\n[board]\nkind = \"simulated\"\n");
    let ran = bench.rig(&["doctor", "board.toml", "--root", "machine"]);
    assert!(ran.out.lines().last().unwrap().starts_with("fit for real lines"), "{}", ran.out);
    bench.refused(&["doctor", "missing.toml", "--root", "machine"], &["missing.toml"]);
}

#[test]
fn this_machine_is_looked_at_without_a_word_that_is_no_finding() {
    let bench = TestProject::new();
    let ran = bench.rig(&["doctor"]);
    assert!(matches!(ran.code, Some(0 | 1 | 3)), "{ran:?}");
    assert_eq!(ran.err, "");
    let last = ran.out.lines().last().unwrap();
    assert!(last.starts_with("fit for real lines") || last.starts_with("not fit for real lines: "), "{last}");
    let chip = Path::new("/dev").read_dir().unwrap().flatten();
    let chip = chip.map(|entry| entry.file_name()).any(|name| name.to_string_lossy().starts_with("gpiochip"));
    assert_eq!(ran.out.contains("bad   GPIO              none"), !chip, "{}", ran.out);
}
