//! The board file of `rig board check`, `watch` and `exercise`, and boards of some of its lines.

use crate::exit::ExitStatus;
use crate::output;
use document::{Diagnostic, SourceFile};
use drivers::circuit::ChannelSpec;
use drivers::file::{BoardFile, BoardKind};
use drivers::gpio::{Direction, GpioSpec, LineSpec};
use drivers::real::{DeviceSpec, FaultWay, OfflineBoard, RealSpec};
use drivers::{Board, BoardContext, BoardError, ChannelId};
use runtime::suite::{self, Disk};
use signal::Time;
use std::any::Any;
use std::path::Path;
use std::sync::Arc;

/// The board file has no real lines.
const NO_REAL_LINES: &str = "R0243";
/// A call on a device failed.
const CALL_FAILED: &str = "R0244";

/// What becomes of the devices that have no lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OtherDevices {
    /// They are on the board, too.
    Included,
    /// Nobody touches them.
    Excluded,
}

/// A board file of real lines.
#[derive(Debug)]
pub struct RealBoardFile {
    /// The file.
    pub file: BoardFile,
    /// Its devices.
    pub spec: RealSpec,
    sources: Vec<SourceFile>,
}

impl RealBoardFile {
    /// Reads a board file.
    ///
    /// # Errors
    /// Something is wrong with it, which was said.
    pub fn read(path: &Path) -> Result<RealBoardFile, ExitStatus> {
        let mut sources = Vec::new();
        let wrong = |found: Vec<Diagnostic>, sources: &[SourceFile]| {
            output::findings(&found, sources);
            ExitStatus::UserFiles
        };
        let (file, _) = suite::load_board(&Disk, &path.to_string_lossy(), &mut sources)
            .map_err(|found| wrong(found, &sources))?;
        match file.kind.clone() {
            BoardKind::Real(spec) => Ok(RealBoardFile { file, spec: *spec, sources }),
            BoardKind::Simulated => {
                let message = format!("`{}` describes a simulated board", path.display());
                let help =
                    "it has no lines on this machine; `rig board scan` writes a file of those that it has";
                Err(wrong(vec![Diagnostic::error(NO_REAL_LINES, message).help(help)], &sources))
            }
        }
    }

    /// The name of a channel.
    pub fn name(&self, channel: usize) -> &str {
        self.file.circuit.channels.get(channel).map_or("", |channel| channel.name.as_str())
    }

    /// The GPIO line of a channel.
    pub fn line(&self, channel: usize) -> Option<&LineSpec> {
        self.spec.of::<GpioSpec>()?.lines.iter().find(|line| usize::from(line.channel.0) == channel)
    }

    /// What the channel does where it is that of a fault relay, in words.
    pub fn relay(&self, channel: usize) -> Option<String> {
        let mut relays = self.spec.relays.iter().flat_map(|wire| {
            FaultWay::ALL.into_iter().filter_map(|way| Some((wire.channel, way, wire.relay(way)?)))
        });
        let (wire, way, _) = relays.find(|(_, _, relay)| usize::from(relay.0) == channel)?;
        let wire = self.name(usize::from(wire.0));
        Some(match way {
            FaultWay::Open => format!("opens the wire of {wire}"),
            FaultWay::Ground => format!("shorts the wire of {wire} to ground"),
            FaultWay::Supply => format!("shorts the wire of {wire} to the supply"),
        })
    }

    /// The board of some of the lines: each as `keep` has it, or not at all; and with what else there is, converters and
    /// buses, or with lines alone. Nothing is bound on it.
    pub fn subset(
        &self,
        keep: impl Fn(usize, &LineSpec) -> Option<LineSpec>,
        others: OtherDevices,
    ) -> BoardFile {
        let is_gpio = |devices: &&Arc<dyn DeviceSpec>| (devices.as_ref() as &dyn Any).is::<GpioSpec>();
        let others: Vec<&Arc<dyn DeviceSpec>> = match others {
            OtherDevices::Included => self.spec.devices.iter().filter(|one| !is_gpio(one)).collect(),
            OtherDevices::Excluded => Vec::new(),
        };
        // What makes pulses reports nothing by itself, and is not to be moved.
        let described = OfflineBoard::new(&self.file.channel_table(), &self.spec);
        let is_moved = |id: &ChannelId| {
            described
                .channels()
                .get(usize::from(id.0))
                .is_none_or(|known| known.drives || known.emits.is_some())
        };
        let mut sensed: Vec<ChannelId> = others.iter().flat_map(|devices| devices.serves()).collect();
        sensed.retain(|id| !is_moved(id));
        let mut file = BoardFile { bind: Vec::new(), ..self.file.clone() };
        file.circuit.channels.clear();
        let mut lines = Vec::new();
        let mut numbers = Vec::new();
        for (at, channel) in self.file.circuit.channels.iter().enumerate() {
            let line = self.line(at).and_then(|line| keep(at, line));
            let Ok(place) = u16::try_from(file.circuit.channels.len()) else { break };
            let id = ChannelId(place);
            let drives = line.as_ref().is_some_and(|line| line.direction == Direction::Output);
            let other = sensed.iter().find(|other| usize::from(other.0) == at);
            if line.is_none() && other.is_none() {
                continue;
            }
            file.circuit.channels.push(ChannelSpec { drives, senses: true, ..channel.clone() });
            lines.extend(line.map(|line| LineSpec { channel: id, ..line }));
            numbers.extend(other.map(|other| (*other, id)));
        }
        let number = |old: ChannelId| numbers.iter().find(|(other, _)| *other == old).map(|(_, new)| *new);
        let gpio = self.spec.of::<GpioSpec>().map(|gpio| GpioSpec { lines, ..gpio.clone() });
        let gpio = gpio.map(|gpio| Arc::new(gpio) as Arc<dyn DeviceSpec>);
        let devices = gpio.into_iter().chain(others.iter().map(|devices| devices.with_channels(&number)));
        // A relay is an output like any other here: nobody asks for faults.
        let spec = RealSpec { limits: self.spec.limits, devices: devices.collect(), relays: Vec::new() };
        file.kind = BoardKind::Real(Box::new(spec));
        file
    }

    /// Claims the lines of a board of this file.
    ///
    /// # Errors
    /// They cannot be had, which was said.
    pub fn open(&self, file: &BoardFile, surroundings: &BoardContext) -> Result<Box<dyn Board>, ExitStatus> {
        let opened = drivers::file::open(file, surroundings).map_err(|found| self.wrong(&found))?;
        // Only a simulated board has nothing to open, and such files were refused.
        let mut board = opened.ok_or(ExitStatus::UserFiles)?;
        // Finding lines takes a while, and what is shown counts from when they are watched.
        surroundings.time.restart();
        board.start(surroundings.time.now()).map_err(failed)?;
        Ok(board)
    }

    /// Says what is wrong with the file on this machine.
    pub fn wrong(&self, found: &[Diagnostic]) -> ExitStatus {
        output::findings(found, &self.sources);
        ExitStatus::UserFiles
    }
}

/// The line of a channel as somebody sees it who drives nothing: `None` for an output that no other line reports.
pub fn listening(line: &LineSpec) -> Option<LineSpec> {
    let listened = match (line.direction, &line.readback) {
        (Direction::Input, _) => &line.line,
        (Direction::Output, Some(readback)) => readback,
        (Direction::Output, None) => return None,
    };
    Some(LineSpec { line: listened.clone(), direction: Direction::Input, readback: None, ..line.clone() })
}

/// Says that a call on a device failed.
pub fn failed(error: BoardError) -> ExitStatus {
    let found = Diagnostic::error(CALL_FAILED, error.to_string()).help(
        "`rig board check` shows whether the lines are there; `dmesg` shows what the device's driver reports",
    );
    output::findings(&[found], &[]);
    ExitStatus::Error
}

/// An instant or a duration of so many nanoseconds, in seconds with the digits that a terminal has room for.
pub fn seconds(at: Time) -> String {
    let micros = at.as_nanos() / 1_000;
    format!("{}.{:06} s", micros / 1_000_000, micros.rem_euclid(1_000_000))
}
