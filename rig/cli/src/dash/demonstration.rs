//! A rig that is started for the dashboard: a conveyor on a simulated board.

use control::ControlClient;
use document::Diagnostic;
use std::fs::{self, DirBuilder, File};
use std::os::unix::fs::DirBuilderExt;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Its files.
const FILES: [(&str, &str); 3] = [
    ("sim.toml", include_str!("../../demo/sim.toml")),
    ("conveyor.toml", include_str!("../../demo/conveyor.toml")),
    ("conveyor.st", include_str!("../../demo/conveyor.st")),
];

/// What it says goes here.
const LOG: &str = "rig.log";

/// How long it may take to answer.
const PATIENCE: Duration = Duration::from_secs(30);

/// How often it is looked whether it answers.
const LOOK: Duration = Duration::from_millis(20);

/// How long it may take to put its things in order.
const GOODBYE: Duration = Duration::from_secs(5);

/// The rig that was started. It ends, and its files go, when this is dropped.
#[derive(Debug)]
pub struct Demonstration {
    folder: PathBuf,
    socket: PathBuf,
    rig: Option<Child>,
}

impl Demonstration {
    /// Starts it, and waits until it answers.
    ///
    /// # Errors
    /// Files that cannot be written, or a rig that ends or does not answer: its messages are reported.
    pub fn start(interrupt: &AtomicBool) -> Result<Demonstration, Diagnostic> {
        let folder = std::env::temp_dir().join(format!("scanrig-demonstration-{}", std::process::id()));
        let socket = folder.join("sim.sock");
        let mut own = Demonstration { folder, socket, rig: None };
        own.spawn().map_err(|error| not_started(&error.to_string()))?;
        let until = Instant::now() + PATIENCE;
        loop {
            if ControlClient::connect(&own.socket, "rig dash").is_ok() {
                return Ok(own);
            }
            let ended = own.rig.as_mut().is_none_or(|rig| !matches!(rig.try_wait(), Ok(None)));
            if ended || Instant::now() > until || interrupt.load(Ordering::Relaxed) {
                let said = fs::read_to_string(own.folder.join(LOG)).unwrap_or_default();
                return Err(not_started(said.trim()));
            }
            std::thread::sleep(LOOK);
        }
    }

    /// Where it answers.
    pub fn socket(&self) -> &Path {
        &self.socket
    }

    fn spawn(&mut self) -> std::io::Result<()> {
        DirBuilder::new().mode(0o700).create(&self.folder)?;
        for (name, text) in FILES {
            fs::write(self.folder.join(name), text)?;
        }
        let log = File::create(self.folder.join(LOG))?;
        let mut rig = Command::new(std::env::current_exe()?);
        rig.args(["run", "--board", "sim.toml", "--case", "conveyor", "--booted", "--control"])
            .arg(&self.socket);
        // Its end of the pipe is closed however this program ends: nobody is left to end the rig where it is killed.
        rig.arg("--until-input-ends");
        rig.current_dir(&self.folder).stdin(Stdio::piped()).stdout(log.try_clone()?).stderr(log);
        // What the terminal sends to a program and all that it started is for the dashboard alone.
        self.rig = Some(rig.process_group(0).spawn()?);
        Ok(())
    }
}

impl Drop for Demonstration {
    fn drop(&mut self) {
        if let Some(mut rig) = self.rig.take() {
            let until = Instant::now() + GOODBYE;
            let asked = host::ask_to_end(&rig).is_ok();
            while asked && matches!(rig.try_wait(), Ok(None)) && Instant::now() < until {
                std::thread::sleep(LOOK);
            }
            // One that has ended cannot be killed, which is as well.
            let _ = rig.kill();
            let _ = rig.wait();
        }
        // A folder that cannot be removed is left: it holds nothing but these files.
        let _ = fs::remove_dir_all(&self.folder);
    }
}

fn not_started(why: &str) -> Diagnostic {
    let found = Diagnostic::error("R0661", format!("the rig of the demonstration does not run: {why}"));
    found.help("see whether `rig run` works on this machine: `rig doctor` says more")
}
