//! Commands of the user that bring a program into a controller, and take it away: bounded in time, with their words.

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, PidfdFlags, Signal, kill_process_group, pidfd_open};
use signal::Span;
use std::fmt;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// How long a command runs on when the user wants the run to end.
const GLANCE: Duration = Duration::from_millis(100);

/// Bytes at the end of what a command said that are kept.
const LAST_WORDS: u64 = 2_000;

/// The commands of a case, with what is the same for all of them.
#[derive(Debug, Default)]
pub struct Hook {
    environment: Vec<(String, String)>,
    /// Holds the files that the environment names; gone with it.
    _folder: Option<tempfile::TempDir>,
}

/// Why a command did not do what it is for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HookError {
    /// The key of the board file that names it.
    pub key: &'static str,
    /// The program.
    pub program: String,
    /// What became of it.
    pub why: HookFault,
}

/// What became of a command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum HookFault {
    /// It could not be started.
    NotStarted(String),
    /// It ended with this, having said that.
    Failed {
        /// Its exit code or the signal that ended it.
        status: String,
        /// The end of what it said.
        words: String,
    },
    /// It had not ended in time.
    TooLong {
        /// The limit.
        limit: Span,
        /// The end of what it had said.
        words: String,
    },
    /// The user wants the run to end.
    Interrupted,
}

impl fmt::Display for HookError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let said = |f: &mut fmt::Formatter<'_>, words: &str| match words.trim() {
            "" => Ok(()),
            words => write!(f, ": {words}"),
        };
        write!(f, "the command `{}` of `{}` ", self.program, self.key)?;
        match &self.why {
            HookFault::NotStarted(why) => write!(f, "cannot be started: {why}"),
            HookFault::Failed { status, words } => {
                write!(f, "ended with {status}")?;
                said(f, words)
            }
            HookFault::TooLong { limit, words } => {
                write!(f, "had not ended after {limit}")?;
                said(f, words)
            }
            HookFault::Interrupted => f.write_str("was interrupted"),
        }
    }
}

impl std::error::Error for HookError {}

impl Hook {
    /// Commands with these variables in their environment, some of which name files in `folder`.
    pub fn new(environment: Vec<(String, String)>, folder: Option<tempfile::TempDir>) -> Hook {
        Hook { environment, _folder: folder }
    }

    /// Runs a command to its end. What it starts in the background goes on; when it takes too long, all that it started
    /// in its group is ended.
    ///
    /// # Errors
    /// [`HookError`] where it does not end well in time.
    pub fn run(
        &self,
        key: &'static str,
        words: &[String],
        within: Span,
        interrupt: &AtomicBool,
    ) -> Result<(), HookError> {
        let Some((program, arguments)) = words.split_first() else { return Ok(()) };
        let failed = |why| HookError { key, program: program.clone(), why };
        let not_started = |error: io::Error| failed(HookFault::NotStarted(error.to_string()));
        // A file and no pipe: what goes on in the background keeps it open.
        let mut said = tempfile::tempfile().map_err(not_started)?;
        let (out, err) = (said.try_clone().map_err(not_started)?, said.try_clone().map_err(not_started)?);
        let mut child = Command::new(program)
            .args(arguments)
            .envs(self.environment.iter().map(|(name, value)| (name, value)))
            .stdin(Stdio::null())
            .stdout(out)
            .stderr(err)
            .process_group(0)
            .spawn()
            .map_err(not_started)?;
        let limit = Duration::from_nanos(u64::try_from(within.as_nanos()).unwrap_or(0));
        match wait(&mut child, limit, interrupt) {
            Ok(Some(status)) if status.success() => Ok(()),
            Ok(Some(status)) => {
                let words = last_words(&mut said);
                Err(failed(HookFault::Failed { status: show(status), words }))
            }
            Ok(None) => {
                end(&mut child);
                Err(failed(if interrupt.load(Ordering::Relaxed) {
                    HookFault::Interrupted
                } else {
                    HookFault::TooLong { limit: within, words: last_words(&mut said) }
                }))
            }
            Err(error) => {
                end(&mut child);
                Err(not_started(error))
            }
        }
    }
}

/// Waits until the command ends; `None` where it is not to be waited for any longer.
fn wait(child: &mut Child, limit: Duration, interrupt: &AtomicBool) -> io::Result<Option<ExitStatus>> {
    let process = pidfd_open(Pid::from_child(child), PidfdFlags::empty())?;
    let began = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        let left = limit.saturating_sub(began.elapsed());
        if left.is_zero() || interrupt.load(Ordering::Relaxed) {
            return Ok(None);
        }
        let glance = left.min(GLANCE);
        let timeout = Timespec { tv_sec: 0, tv_nsec: glance.subsec_nanos().into() };
        match poll(&mut [PollFd::new(&process, PollFlags::IN)], Some(&timeout)) {
            Ok(_) | Err(rustix::io::Errno::INTR) => {}
            Err(error) => return Err(error.into()),
        }
    }
}

/// Ends a command with all that it started in its group.
fn end(child: &mut Child) {
    // It may have ended meanwhile.
    let _ = kill_process_group(Pid::from_child(child), Signal::KILL);
    let _ = child.wait();
}

fn show(status: ExitStatus) -> String {
    match (status.code(), status.signal()) {
        (Some(code), _) => format!("exit code {code}"),
        (None, Some(signal)) => format!("signal {signal}"),
        (None, None) => String::from("no exit code"),
    }
}

/// The last lines of what a command said, in one.
fn last_words(said: &mut File) -> String {
    let mut bytes = Vec::new();
    let read = said.seek(SeekFrom::End(0)).and_then(|length| {
        said.seek(SeekFrom::Start(length.saturating_sub(LAST_WORDS)))?;
        said.take(LAST_WORDS).read_to_end(&mut bytes)
    });
    match read {
        Ok(_) => {
            let text = String::from_utf8_lossy(&bytes).into_owned();
            let lines: Vec<&str> = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
            lines[lines.len().saturating_sub(3)..].join("; ")
        }
        Err(_) => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(script: &str, within: Span) -> Result<(), HookError> {
        let words: Vec<String> = ["sh", "-c", script].map(String::from).to_vec();
        let environment = vec![(String::from("RIG_CASE"), String::from("lamp"))];
        Hook::new(environment, None).run("load", &words, within, &AtomicBool::new(false))
    }

    #[test]
    fn a_command_has_the_case_in_its_environment_and_its_words_are_kept() {
        assert_eq!(run("test \"$RIG_CASE\" = lamp", Span::from_secs(60)), Ok(()));
        let error = run("echo first; echo no such controller >&2; exit 3", Span::from_secs(60)).unwrap_err();
        assert_eq!(
            error.to_string(),
            "the command `sh` of `load` ended with exit code 3: first; no such controller"
        );
    }

    #[test]
    fn a_command_that_hangs_is_ended_with_what_it_started() {
        let began = Instant::now();
        let error = run("echo waiting; sleep 1000 & sleep 1000", Span::from_millis(50)).unwrap_err();
        assert_eq!(error.to_string(), "the command `sh` of `load` had not ended after 50 ms: waiting");
        assert!(began.elapsed() < Duration::from_secs(60));
    }

    #[test]
    fn what_goes_on_in_the_background_is_not_waited_for() {
        let began = Instant::now();
        assert_eq!(run("sleep 30 &", Span::from_secs(60)), Ok(()));
        assert!(began.elapsed() < Duration::from_secs(30));
    }

    #[test]
    fn an_interrupt_ends_it_and_no_such_program_is_said() {
        let words: Vec<String> = ["sleep", "1000"].map(String::from).to_vec();
        let error = Hook::default().run("load", &words, Span::from_secs(60), &AtomicBool::new(true));
        assert_eq!(error.unwrap_err().why, HookFault::Interrupted);
        let words = vec![String::from("/no/such/program")];
        let error = Hook::default().run("unload", &words, Span::from_secs(60), &AtomicBool::new(false));
        let text = error.unwrap_err().to_string();
        assert!(text.starts_with("the command `/no/such/program` of `unload` cannot be started"), "{text}");
    }
}
