//! The key that stops a program (Ctrl-Z).

use std::io;

/// Keeps the key from stopping this process until it is dropped: a stopped rig would look like one that hangs.
#[derive(Debug)]
pub struct Unstoppable {
    before: libc::sighandler_t,
}

impl Unstoppable {
    /// From now on SIGTSTP is ignored.
    ///
    /// # Errors
    /// What the kernel says.
    pub fn new() -> io::Result<Unstoppable> {
        Ok(Unstoppable { before: on_stop(libc::SIG_IGN)? })
    }
}

impl Drop for Unstoppable {
    fn drop(&mut self) {
        // What the kernel gave before it takes back.
        let _ = on_stop(self.before);
    }
}

/// Sets what SIGTSTP does, and returns what it did. Neither std nor rustix can, and nix's call is as unsafe.
#[allow(unsafe_code)]
fn on_stop(action: libc::sighandler_t) -> io::Result<libc::sighandler_t> {
    // SAFETY: the action is SIG_IGN or what this very call returned before, so no handler of ours runs.
    match unsafe { libc::signal(libc::SIGTSTP, action) } {
        libc::SIG_ERR => Err(io::Error::last_os_error()),
        before => Ok(before),
    }
}

/// Stops this process as the key does, until somebody lets it go on: job control of a shell.
#[allow(unsafe_code)]
pub fn stop_here() {
    // SAFETY: raise takes a number and touches no memory; the signal's action is the default, or one of `on_stop`.
    // It is sent to this very thread, so it has taken effect when the call returns. Whether it could be sent makes no
    // difference to what follows.
    let _ = unsafe { libc::raise(libc::SIGTSTP) };
}
