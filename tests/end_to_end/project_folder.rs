//! A folder with files, in which the command runs.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value as Json;
use tempfile::TempDir;

/// The longest that a command of these tests may take: far above what any does, below what a CI server waits.
const PATIENCE: Duration = Duration::from_secs(600);

/// The program of the examples: the lamp lights 500 ms after the button.
pub const LAMP_ST: &str = "\
PROGRAM MAIN
VAR
    button AT %IX0.0 : BOOL;
    lamp AT %QX0.4 : BOOL;
    delay : TON;
END_VAR
delay(IN := button, PT := T#500ms);
lamp := delay.Q;
END_PROGRAM
";

/// A plan for it, with the two claims that the program meets.
pub const LAMP: &str = r#"format = 1
title = "The lamp lights half a second after the button"
proves = ["controller:TASK-10"]
program = "lamp.st"
signals = { button = "%IX0.0", lamp = "%QX0.4" }
steps = [
  { id = "press", at = "start + 1 s", set = { signal = "button", value = true } },
]
expect = [
  { rises = { signal = "lamp", from = "press", within = "500 ms .. 550 ms" } },
  { stays = { signal = "lamp", is = false, from = "start", until = "press + 500 ms" } },
]
"#;

/// A folder of its own for each test.
pub struct TestProject {
    folder: TempDir,
}

/// What a command left.
#[derive(Debug)]
pub struct CommandOutput {
    /// Exit code; `None` where a signal ended it.
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
}

impl TestProject {
    /// A folder with `lamp.st` and `lamp.toml`.
    pub fn new() -> TestProject {
        let bench = TestProject { folder: tempfile::tempdir().unwrap() };
        bench.write("lamp.st", LAMP_ST);
        bench.write("lamp.toml", LAMP);
        bench
    }

    /// Writes a file, and the folders that it stands in.
    pub fn write(&self, path: &str, text: &str) {
        let path = self.path(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }

    /// Writes the plan of the lamp with a part replaced.
    pub fn write_lamp(&self, path: &str, part: &str, by: &str) {
        assert!(LAMP.contains(part), "{part}");
        self.write(path, &LAMP.replace(part, by));
    }

    pub fn path(&self, path: &str) -> PathBuf {
        self.folder.path().join(path)
    }

    pub fn read(&self, path: &str) -> String {
        std::fs::read_to_string(self.path(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
    }

    pub fn json(&self, path: &str) -> Json {
        serde_json::from_str(&self.read(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
    }

    /// The command in this folder, without running it.
    pub fn command(&self, args: &[&str]) -> Command {
        command(self.folder.path(), args)
    }

    /// Runs the command to its end.
    pub fn rig(&self, args: &[&str]) -> CommandOutput {
        run(self.command(args))
    }

    /// Runs the command and expects this exit code.
    pub fn expect(&self, code: i32, args: &[&str]) -> CommandOutput {
        let ran = self.rig(args);
        assert_eq!(ran.code, Some(code), "rig {args:?}\n{}{}", ran.out, ran.err);
        ran
    }

    /// Expects something wrong with the user's files or arguments, said in these words and nothing printed as a result.
    pub fn refused(&self, args: &[&str], words: &[&str]) {
        let ran = self.expect(2, args);
        assert_eq!(ran.out, "", "rig {args:?}");
        for word in words {
            assert!(ran.err.contains(word), "rig {args:?}: `{word}` is missing in\n{}", ran.err);
        }
    }

    /// Names of the files in a folder, sorted.
    pub fn list(&self, folder: &str) -> Vec<String> {
        list(&self.path(folder))
    }
}

/// Names of the files in a folder, sorted.
pub fn list(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut names: Vec<String> =
        entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Every file below a folder, by its path within, sorted.
pub fn files(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    for name in list(folder) {
        let path = folder.join(&name);
        if path.is_dir() {
            found.extend(files(&path).iter().map(|inner| format!("{name}/{inner}")));
        } else {
            found.push(name);
        }
    }
    found
}

/// The command in a folder, the same whatever the shell of the caller has set.
pub fn command(folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rig"));
    command.current_dir(folder).args(args).stdin(Stdio::null()).env_remove("NO_COLOR").env_remove("RUST_LOG");
    command
}

/// Runs a command to its end, and ends one that hangs.
pub fn run(mut command: Command) -> CommandOutput {
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let out = drain(child.stdout.take().unwrap());
    let err = drain(child.stderr.take().unwrap());
    let began = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if began.elapsed() > PATIENCE {
            child.kill().unwrap();
            panic!("{command:?} does not end");
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    CommandOutput { code: status.code(), out: out.join().unwrap(), err: err.join().unwrap() }
}

/// Reads a pipe to its end, beside the waiting, so that a full pipe holds nobody up.
pub fn drain(mut pipe: impl std::io::Read + Send + 'static) -> std::thread::JoinHandle<String> {
    std::thread::spawn(move || {
        let mut bytes = Vec::new();
        pipe.read_to_end(&mut bytes).unwrap();
        String::from_utf8(bytes).unwrap()
    })
}

/// The repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}
