//! Which loop of a board is measured.

use crate::exit::ExitStatus;
use crate::output::refuse;
use clap::Args;
use drivers::{BoardFile, ChannelId, LoopbackPair};
use std::path::Path;

/// The options that name another loop than that of the board file.
#[derive(Debug, Args)]
pub struct LoopbackPairArgs {
    /// The output, or the line of a generator, at which another loop begins. It is driven up and down as fast as can be.
    #[arg(long, value_name = "CHANNEL", requires = "input")]
    out: Option<String>,
    /// The input to which that output is wired; the same channel where the board reads it back.
    #[arg(long = "in", value_name = "CHANNEL", requires = "out")]
    input: Option<String>,
}

impl LoopbackPairArgs {
    /// The loop.
    ///
    /// # Errors
    /// R0254: a channel that is not there, or a board without a loop; it was said.
    pub fn find(&self, file: &BoardFile, path: &Path) -> Result<LoopbackPair, ExitStatus> {
        match (&self.out, &self.input, file.check) {
            (Some(out), Some(input), _) => {
                let channel = |option: &str, name: &str| -> Result<ChannelId, ExitStatus> {
                    file.find(name).ok_or_else(|| {
                        let message = format!("{option} {name}: the board has no such channel");
                        refuse("R0254", message, "name a channel of the board file")
                    })
                };
                Ok(LoopbackPair { out: channel("--out", out)?, input: channel("--in", input)? })
            }
            (_, _, Some(looped)) => Ok(looped),
            _ => {
                let message = format!("`{}` names no loop", path.display());
                let help = "add `check = { out = ..., in = ... }` to its `[board]`, or give --out and --in";
                Err(refuse("R0254", message, help))
            }
        }
    }
}
