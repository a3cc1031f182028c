//! A rig in stepped time: what a script does to it happens at the same instant each time.

use crate::project_folder::{CommandOutput, TestProject, run};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

/// A rig that runs until this is dropped.
pub struct SteppedRig {
    child: Child,
    folder: PathBuf,
}

impl SteppedRig {
    /// Starts a rig in the bench's folder and waits until it answers.
    pub fn start(bench: &TestProject, board: &str, program: &str) -> SteppedRig {
        let folder = bench.path("");
        let mut command =
            bench.command(&["run", "--board", board, "--program", program, "--stepped", "--control"]);
        command.arg(folder.join(SOCKET)).stdout(Stdio::null()).stderr(Stdio::null());
        let stepped = SteppedRig { child: command.spawn().unwrap(), folder };
        let ran = stepped.ctl(&["state", "--wait", "60s"]);
        assert_eq!(ran.code, Some(0), "{}", ran.err);
        stepped
    }

    pub fn socket(&self) -> PathBuf {
        self.folder.join(SOCKET)
    }

    /// `rig ctl` without running it.
    pub fn command(&self, args: &[&str]) -> Command {
        let mut all = vec!["ctl", "--socket", SOCKET];
        all.extend(args);
        crate::project_folder::command(&self.folder, &all)
    }

    /// Runs `rig ctl` to its end.
    pub fn ctl(&self, args: &[&str]) -> CommandOutput {
        run(self.command(args))
    }

    /// Runs `rig ctl` and expects this exit code.
    pub fn expect(&self, code: i32, args: &[&str]) -> CommandOutput {
        let ran = self.ctl(args);
        assert_eq!(ran.code, Some(code), "rig ctl {args:?}\n{}{}", ran.out, ran.err);
        ran
    }

    /// The process of the rig.
    pub fn process(&self) -> u32 {
        self.child.id()
    }
}

/// The socket within the bench's folder.
pub const SOCKET: &str = "rig.sock";

impl Drop for SteppedRig {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
