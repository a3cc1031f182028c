//! `rig board check`: whether the devices of a board file can be had, without claiming any.

use super::real_board_file::{OtherDevices, RealBoardFile};
use crate::exit::ExitStatus;
use crate::output;
use clap::Args;
use document::Diagnostic;
use drivers::ChannelId;
use drivers::file::BoardKind;
use drivers::gpio::{self, Direction, FoundChip, GpioSpec, LineInfo};
use drivers::real::{self, DeviceSpec};
use std::path::PathBuf;

/// `rig board check`.
#[derive(Debug, Args)]
pub struct BoardCheckArgs {
    /// The board file.
    #[arg(value_name = "FILE")]
    file: PathBuf,
}

/// Looks for every line of the file.
pub fn run(args: &BoardCheckArgs) -> ExitStatus {
    let bench = match RealBoardFile::read(&args.file) {
        Ok(bench) => bench,
        Err(exit) => return exit,
    };
    // A board without lines needs no chip.
    let whole = match bench.spec.of::<GpioSpec>().filter(|gpio| gpio.is_used()) {
        None => Ok(Vec::new()),
        Some(gpio) => gpio::find(&bench.file.name, gpio),
    };
    let others = real::look(&bench.file.channel_table(), &bench.spec);
    let rows: Vec<Option<FoundLine>> = (0..bench.file.circuit.channels.len())
        .map(|at| {
            let channel = ChannelId(u16::try_from(at).ok()?);
            let measured = others.inputs.iter().find(|(measured, _)| *measured == channel);
            match (measured, &whole) {
                (Some((_, words)), _) => Some(FoundLine { head: String::new(), lines: words.clone()? }),
                (None, Ok(chips)) => found(chips, channel),
                (None, Err(_)) => alone(&bench, at),
            }
        })
        .collect();
    let mut shown = Vec::new();
    for row in rows.iter().flatten() {
        if !shown.contains(&&row.head) {
            shown.push(&row.head);
            output::print(&row.head);
        }
    }
    let named = (0..rows.len()).map(|at| bench.name(at).len());
    let wide = named.chain(others.buses.iter().map(|(_, name, _)| name.len())).max().unwrap_or(0);
    for (at, row) in rows.iter().enumerate() {
        let text = row.as_ref().map_or("not available", |row| row.lines.as_str());
        let relay = bench.relay(at).map_or_else(String::new, |what| format!("; {what}"));
        output::print(&format!("{:<wide$}  {text}{relay}\n", bench.name(at)));
    }
    for (_, name, words) in &others.buses {
        output::print(&format!("{name:<wide$}  {}\n", words.as_deref().unwrap_or("not available")));
    }
    let wrong: Vec<Diagnostic> = whole.err().into_iter().flatten().chain(others.found).collect();
    if !wrong.is_empty() {
        return bench.wrong(&wrong);
    }
    let buses = match others.buses.len() {
        0 => String::new(),
        1 => " and the bus".to_owned(),
        count => format!(" and {count} buses"),
    };
    output::print(&format!("{}: all {} channels{buses} can be had\n", args.file.display(), rows.len()));
    ExitStatus::Passed
}

/// What is said of a channel that can be had.
#[derive(Debug)]
struct FoundLine {
    head: String,
    lines: String,
}

/// A channel on its chip.
fn found(chips: &[FoundChip], channel: ChannelId) -> Option<FoundLine> {
    let chip = chips.iter().find(|chip| chip.drives.contains(&channel) || chip.senses.contains(&channel))?;
    Some(FoundLine { head: head(chip), lines: lines(chip, channel) })
}

/// A channel that is looked for without the others, some of which cannot be had.
fn alone(bench: &RealBoardFile, at: usize) -> Option<FoundLine> {
    let file = bench.subset(|other, line| (other == at).then(|| line.clone()), OtherDevices::Excluded);
    let BoardKind::Real(spec) = &file.kind else { return None };
    found(&gpio::find(&file.name, spec.of()?).ok()?, ChannelId(0))
}

/// A chip in a line.
fn head(chip: &FoundChip) -> String {
    let (path, label) = (chip.info.path.display(), &chip.info.label);
    format!("{path} ({label}): {} lines, interface {}\n", chip.info.lines.len(), chip.backend.name())
}

/// The lines of one channel.
fn lines(chip: &FoundChip, channel: ChannelId) -> String {
    let of = |number: u32| {
        chip.info.lines.iter().find(|line| line.number == number).map_or_else(String::new, words)
    };
    let outputs = chip.claim.outputs.iter().zip(&chip.drives).map(|(line, of)| ("drives", line.number, of));
    let inputs = chip.claim.inputs.iter().zip(&chip.senses).map(|(line, of)| ("reads", line.number, of));
    let mine = outputs.chain(inputs).filter(|(_, _, owner)| **owner == channel);
    let parts: Vec<String> = mine.map(|(what, number, _)| format!("{what} {}", of(number))).collect();
    format!("{}, on {}, free", parts.join(", "), chip.info.name)
}

fn words(line: &LineInfo) -> String {
    let name = line.name.as_ref().map(|name| format!(" ({name})")).unwrap_or_default();
    // What a claim would change is worth knowing.
    let now = if line.direction == Direction::Output { ", an output now" } else { "" };
    format!("line {}{name}{now}", line.number)
}
