//! `rig board scan`: a first board file from what is there.

use super::scanned_devices::{self, ScannedDevices};
use super::toml_text::{bare, is_name, quoted};
use crate::exit::ExitStatus;
use crate::{files, output};
use clap::Args;
use document::Diagnostic;
use drivers::gpio::{self, ChipInfo, Direction, GpioError, LineInfo, MAX_LINES};
use drivers::inventory::{self, Device, DeviceKind};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// The machine has no GPIO lines.
const NO_LINES: &str = "R0240";
/// A chip that cannot be looked at.
const REFUSED: &str = "R0241";
/// The file that is to be written is there.
const FILE_EXISTS: &str = "R0242";

/// `rig board scan`.
#[derive(Debug, Args)]
pub struct BoardScanArgs {
    /// Write the board file here, never over a file that is there [default: standard output].
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Where `/dev` and `/sys` lie, for other devices than GPIO.
    #[arg(long, value_name = "DIR", default_value = "/", hide = true)]
    root: PathBuf,
}

/// Writes the board file.
pub fn run(args: &BoardScanArgs) -> ExitStatus {
    let devices = inventory::devices(&args.root);
    let others = scanned_devices::look(&args.root, &devices);
    let (chips, refused) = match gpio::list() {
        Ok(all) => split(all),
        Err(error) => (Vec::new(), vec![error]),
    };
    let mut found: Vec<Diagnostic> = refused.iter().map(|error| refusal(error, !chips.is_empty())).collect();
    if chips.is_empty() && found.is_empty() && !others.live {
        let others = match devices.len() {
            0 => "nor another device that a board could be made of".to_owned(),
            _ => format!("only\n{}", listed(&devices.iter().collect::<Vec<_>>(), "  ").trim_end()),
        };
        found.push(
            Diagnostic::error(NO_LINES, format!("this machine has no GPIO lines, {others}"))
                .help("run it on the machine with the lines; `rig doctor` says what this one can do"),
        );
    }
    output::findings(&found, &[]);
    if chips.is_empty() && !others.live {
        return ExitStatus::UserFiles;
    }
    let text = board_file(&chips, &others, &devices);
    let Some(path) = &args.output else {
        output::print(&text);
        return ExitStatus::Passed;
    };
    match write_new(path, &text) {
        Ok(()) => {
            output::print(&format!("{}\n", path.display()));
            ExitStatus::Passed
        }
        Err(wrong) => {
            output::findings(&[wrong], &[]);
            ExitStatus::UserFiles
        }
    }
}

fn split(all: Vec<Result<ChipInfo, GpioError>>) -> (Vec<ChipInfo>, Vec<GpioError>) {
    let mut chips = Vec::new();
    let mut refused = Vec::new();
    for one in all {
        match one {
            Ok(chip) => chips.push(chip),
            Err(error) => refused.push(error),
        }
    }
    (chips, refused)
}

/// What is said of a chip that cannot be looked at: a warning where there are others.
fn refusal(error: &GpioError, others: bool) -> Diagnostic {
    let new = if others { Diagnostic::warning } else { Diagnostic::error };
    let help = match error.io().kind() {
        ErrorKind::PermissionDenied => {
            let device = error.device.display();
            format!(
                "`stat -c %G {device}` names the group that may: `sudo usermod -aG GROUP $USER`, and log in again"
            )
        }
        _ => "look into the kernel's log: `dmesg`".to_owned(),
    };
    new(REFUSED, error.to_string()).help(help)
}

fn write_new(path: &Path, text: &str) -> Result<(), Diagnostic> {
    let written = std::fs::File::create_new(path).and_then(|mut file| file.write_all(text.as_bytes()));
    written.map_err(|error| match error.kind() {
        ErrorKind::AlreadyExists => {
            Diagnostic::error(FILE_EXISTS, format!("`{}` is there already", path.display()))
                .help("name another file: a board file is never written over")
        }
        _ => files::failed(path, &error),
    })
}

const HEAD: &str = "\
# A first board file: the GPIO lines of this machine that nobody holds, each as an input, so that nothing moves,
# and its converters, counters, generators of pulses and buses.
# Strike out what is not wired, and name terminals of the controller under [bind]. For a line that the rig is to
# drive write `drives = true, safe = false` (or true) in place of `drives = false`.
format = 1
title = \"As scanned\"

[board]
kind = \"real\"
";

/// The board file of these devices. Equal devices give an equal text.
fn board_file(chips: &[ChipInfo], others: &ScannedDevices, devices: &[Device]) -> String {
    let mut text = HEAD.to_owned();
    if !chips.is_empty() {
        text.push_str("\n[chips]\n");
    }
    let keys = chip_keys(chips);
    for (chip, key) in chips.iter().zip(&keys) {
        let twin = chips.iter().filter(|other| other.label == chip.label).count() > 1;
        let by = match twin || chip.label.is_empty() {
            // Two chips of one label: only the path tells them apart, though it may change with the next start.
            true => format!("path = {}", quoted(&chip.path.to_string_lossy())),
            false => format!("label = {}", quoted(&chip.label)),
        };
        let (path, lines, backend) = (chip.path.display(), chip.lines.len(), chip.backend.name());
        text.push_str(&format!("{key} = {{ {by} }} # {path}, {lines} lines, interface {backend}\n"));
    }
    let parts = [
        ("converters", &others.converters),
        ("counters", &others.counters),
        ("generators", &others.generators),
        ("buses", &others.buses),
    ];
    for (title, lines) in parts {
        if !lines.is_empty() {
            text.push_str(&format!("\n[{title}]\n{lines}"));
        }
    }
    text.push_str("\n[channels]\n");
    let mut first = None;
    for (chip, key) in chips.iter().zip(&keys) {
        let mut taken = 0;
        for line in &chip.lines {
            let name = channel_name(chips, key, line);
            let channel = channel(chip, key, line, &name);
            let full = || (taken == MAX_LINES).then(|| format!("a claim takes {MAX_LINES} lines of a chip"));
            let comment = obstacle(line).or_else(full);
            if comment.is_none() {
                taken += 1;
                first.get_or_insert(name);
            }
            match comment {
                Some(why) => text.push_str(&format!("# {channel} # {why}\n")),
                None => text.push_str(&format!("{channel}\n")),
            }
        }
    }
    text.push_str(&others.channels);
    let first = first.unwrap_or_else(|| "CHANNEL".to_owned());
    text.push_str(&format!("\n[bind]\n# \"%IX0.0\" = {}\n", quoted(&first)));
    let rest: Vec<&Device> = devices.iter().filter(|device| !is_part(device.kind)).collect();
    if !rest.is_empty() {
        text.push_str("\n# Other devices of this machine, which a board has no use for:\n");
        text.push_str(&listed(&rest, "#   "));
    }
    text
}

/// Whether a board can have such a device beside its lines.
fn is_part(kind: DeviceKind) -> bool {
    !matches!(kind, DeviceKind::Watchdog)
}

/// Why a line is written down as a comment only.
fn obstacle(line: &LineInfo) -> Option<String> {
    match line.holder() {
        Some(holder) => Some(format!("held by {holder}")),
        None if line.direction == Direction::Output => {
            Some("an output now: as an input it would let go".to_owned())
        }
        None => None,
    }
}

fn channel(chip: &ChipInfo, key: &str, line: &LineInfo, name: &str) -> String {
    let named = line.name.as_ref().filter(|name| {
        let same = |other: &&LineInfo| other.name.as_ref() == Some(name);
        chip.lines.iter().filter(same).count() == 1
    });
    let at = named.map_or_else(|| line.number.to_string(), |name| quoted(name));
    let chip = quoted(key.trim_matches('"'));
    format!("{} = {{ kind = \"digital\", chip = {chip}, line = {at}, drives = false }}", bare(name))
}

/// What chips are called in the file: by their labels, as far as these are names and differ.
fn chip_keys(chips: &[ChipInfo]) -> Vec<String> {
    let key = |chip: &ChipInfo| {
        let twin = chips.iter().filter(|other| other.label == chip.label).count() > 1;
        let name = if twin || !is_name(&chip.label) { &chip.name } else { &chip.label };
        bare(name)
    };
    chips.iter().map(key).collect()
}

/// What a line's channel is called: as the line, where no other line of the machine has the name.
fn channel_name(chips: &[ChipInfo], key: &str, line: &LineInfo) -> String {
    let all = || chips.iter().flat_map(|chip| &chip.lines);
    match &line.name {
        Some(name) if is_name(name) && all().filter(|other| other.name == line.name).count() == 1 => {
            name.clone()
        }
        _ => format!("{}-{}", key.trim_matches('"'), line.number),
    }
}

/// Devices, one a line.
fn listed(devices: &[&Device], indent: &str) -> String {
    let wide = devices.iter().map(|device| device.path.chars().count()).max().unwrap_or(0);
    let line = |device: &&Device| {
        let (kind, path) = (device.kind.name(), &device.path);
        // A driver's own words may hold anything; a line stays a line.
        let what: String = device.what.chars().filter(|c| !c.is_control()).collect();
        format!("{}\n", format!("{indent}{kind:<9} {path:<wide$} {what}").trim_end())
    };
    devices.iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use drivers::gpio::Backend;

    fn line(number: u32, name: &str) -> LineInfo {
        LineInfo {
            number,
            name: (!name.is_empty()).then(|| name.to_owned()),
            used: false,
            consumer: None,
            direction: Direction::Input,
            active_low: false,
            bias: None,
            drive: None,
            backend: Backend::V2,
        }
    }

    fn chip(number: u32, label: &str, lines: Vec<LineInfo>) -> ChipInfo {
        let name = format!("gpiochip{number}");
        ChipInfo {
            path: Path::new("/dev").join(&name),
            name,
            label: label.to_owned(),
            backend: Backend::V2,
            lines,
        }
    }

    #[test]
    fn a_file_names_every_line_and_says_who_holds_which() {
        let held = LineInfo { used: true, consumer: Some("lab-hog".into()), ..line(1, "HOGGED") };
        let driven = LineInfo { direction: Direction::Output, ..line(2, "") };
        let chips = [
            chip(0, "pinctrl-bcm2711", vec![line(0, "ID_SDA"), line(1, "SAME"), line(2, "odd name")]),
            chip(1, "raspberrypi,expander", vec![line(0, "SAME"), held, driven]),
        ];
        let device = |kind, path: &str, what: &str| Device { kind, path: path.into(), what: what.into() };
        let devices = [
            device(DeviceKind::Counter, "/dev/counter0", "ti-eqep"),
            device(DeviceKind::Watchdog, "/dev/watchdog0", "a\nb"),
        ];
        let others = ScannedDevices {
            converters: "adc = {}\n".into(),
            counters: "wheel = {}\n".into(),
            generators: "# fan = {}\n".into(),
            channels: "adc-0 = {}\n".into(),
            buses: "can0 = {}\n".into(),
            live: true,
        };
        let text = board_file(&chips, &others, &devices);
        let expected = format!(
            "{HEAD}
[chips]
pinctrl-bcm2711 = {{ label = \"pinctrl-bcm2711\" }} # /dev/gpiochip0, 3 lines, interface v2
gpiochip1 = {{ label = \"raspberrypi,expander\" }} # /dev/gpiochip1, 3 lines, interface v2

[converters]
adc = {{}}

[counters]
wheel = {{}}

[generators]
# fan = {{}}

[buses]
can0 = {{}}

[channels]
ID_SDA = {{ kind = \"digital\", chip = \"pinctrl-bcm2711\", line = \"ID_SDA\", drives = false }}
pinctrl-bcm2711-1 = {{ kind = \"digital\", chip = \"pinctrl-bcm2711\", line = \"SAME\", drives = false }}
pinctrl-bcm2711-2 = {{ kind = \"digital\", chip = \"pinctrl-bcm2711\", line = \"odd name\", drives = false }}
gpiochip1-0 = {{ kind = \"digital\", chip = \"gpiochip1\", line = \"SAME\", drives = false }}
# HOGGED = {{ kind = \"digital\", chip = \"gpiochip1\", line = \"HOGGED\", drives = false }} # held by lab-hog
# gpiochip1-2 = {{ kind = \"digital\", chip = \"gpiochip1\", line = 2, drives = false }} # an output now: as an input \
it would let go
adc-0 = {{}}

[bind]
# \"%IX0.0\" = \"ID_SDA\"

# Other devices of this machine, which a board has no use for:
#   watchdog  /dev/watchdog0 ab
"
        );
        assert_eq!(text, expected);
    }

    #[test]
    fn chips_of_one_label_go_by_their_paths_and_names_are_written_as_toml_takes_them() {
        let chips = [
            chip(0, "mcp23017", vec![line(0, "quoted \"x\"")]),
            chip(1, "mcp23017", vec![]),
            chip(2, "1e780000.gpio", vec![line(0, "")]),
        ];
        let text = board_file(&chips, &ScannedDevices::default(), &[]);
        for part in [
            "gpiochip0 = { path = \"/dev/gpiochip0\" }",
            "gpiochip1 = { path = \"/dev/gpiochip1\" }",
            "\"1e780000.gpio\" = { label = \"1e780000.gpio\" }",
            "gpiochip0-0 = { kind = \"digital\", chip = \"gpiochip0\", line = \"quoted \\\"x\\\"\"",
            "\"1e780000.gpio-0\" = { kind = \"digital\", chip = \"1e780000.gpio\", line = 0,",
        ] {
            assert!(text.contains(part), "{part} is missing in\n{text}");
        }
    }

    #[test]
    fn no_more_lines_are_taken_than_one_claim_takes() {
        let text = board_file(
            &[chip(0, "wide", (0..100).map(|number| line(number, "")).collect())],
            &ScannedDevices::default(),
            &[],
        );
        let taken = text.lines().filter(|line| line.starts_with("wide-")).count();
        let left =
            text.lines().filter(|line| line.starts_with("# wide-") && line.ends_with("of a chip")).count();
        assert_eq!((taken, left), (64, 36));
    }
}
