//! The command at work in a folder of its own.

use devices::{PATIENCE, wait_for};
use rustix::process::{Pid, Signal, kill_process};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A run of the command; dropping it ends it.
pub struct Rig {
    process: Child,
    folder: PathBuf,
}

impl Rig {
    /// Starts it beside these files.
    pub fn start(name: &str, files: &[(&str, String)], args: &[&str]) -> Rig {
        let folder = Path::new("/tmp/trouble").join(name);
        std::fs::create_dir_all(&folder).unwrap();
        for (name, text) in files {
            std::fs::write(folder.join(name), text).unwrap();
        }
        let all = File::create(folder.join("said")).unwrap();
        let process = Command::new(devices::rig())
            .args(args)
            .current_dir(&folder)
            .env("XDG_STATE_HOME", &folder)
            .stdin(Stdio::null())
            .stdout(all.try_clone().unwrap())
            .stderr(all)
            .spawn()
            .unwrap();
        Rig { process, folder }
    }

    /// What it printed up to now.
    pub fn said(&self) -> String {
        self.file("said")
    }

    /// A file of its folder.
    pub fn file(&self, name: &str) -> String {
        std::fs::read_to_string(self.folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// Verdict, reason and what ended it, of each case.
    pub fn cases(&self) -> Vec<[String; 3]> {
        let record: serde_json::Value = serde_json::from_str(&self.file("report/record.json")).unwrap();
        let text = |case: &serde_json::Value, key: &str| case[key].as_str().unwrap_or_default().to_owned();
        let cases = record["cases"].as_array().unwrap().iter();
        cases.map(|case| ["verdict", "reason", "ended"].map(|key| text(case, key))).collect()
    }

    /// Waits for something that happens while it runs.
    pub fn until(&self, what: &str, mut condition: impl FnMut() -> bool) {
        let deadline = Instant::now() + PATIENCE * 2;
        while !condition() {
            assert!(!self.has_ended(), "it ended before: {what}\n{}", self.said());
            assert!(Instant::now() < deadline, "waited in vain: {what}\n{}", self.said());
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    pub fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.process), signal).unwrap();
    }

    /// Its exit code, when it has ended.
    pub fn exit_code(&mut self) -> Option<i32> {
        wait_for("the end of the run", PATIENCE * 5, || self.has_ended());
        self.process.wait().unwrap().code()
    }

    /// Whether it has ended.
    pub fn has_ended(&self) -> bool {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", self.process.id()));
        stat.map_or(true, |stat| stat.contains(") Z "))
    }
}

impl Drop for Rig {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// How many guards there are.
pub fn guards() -> usize {
    let names = std::fs::read_dir("/proc").unwrap().flatten().map(|entry| entry.path().join("cmdline"));
    names.filter(|path| std::fs::read(path).is_ok_and(|words| words.ends_with(b"\0guard\0"))).count()
}
