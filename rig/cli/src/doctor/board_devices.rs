//! The devices that a board file uses, and what their state means to it.

use super::check::{CheckState, DoctorCheck};
use super::devices::{GROUP, grant};
use super::settings::{self, TRANSFERS};
use crate::exit::ExitStatus;
use crate::output;
use drivers::adc::{AdcKind, AdcsSpec};
use drivers::can::CanSpec;
use drivers::counter::CountersSpec;
use drivers::file::{BoardFile, BoardKind};
use drivers::generator::{GeneratorKind, GeneratorsSpec};
use drivers::gpio::GpioSpec;
use drivers::real::DeviceSpec;
use drivers::serial::SerialLinesSpec;
use host::HostMachine;
use runtime::suite::{self, Disk};
use std::path::Path;

/// The check of serial ports.
const SERIAL: &str = "serial";

/// What a board file uses.
#[derive(Default)]
pub struct BoardDevices {
    /// The names of the checks of its devices, but for serial ports.
    names: Vec<&'static str>,
    /// What was measured of how fast it counts.
    counts: Option<DoctorCheck>,
    /// The bytes that its longest stream of bits has at once; 0 without one.
    buffer: u32,
    /// Its serial ports: a machine has more of them than can be listed without opening them, so the board file is asked.
    ports: Vec<String>,
}

/// The devices that a board file uses.
///
/// # Errors
/// Something is wrong with the file, which was said.
pub fn devices(path: &Path) -> Result<BoardDevices, ExitStatus> {
    let mut sources = Vec::new();
    match suite::load_board(&Disk, &path.to_string_lossy(), &mut sources) {
        Ok((file, _)) => Ok(of(&file)),
        Err(found) => {
            output::findings(&found, &sources);
            Err(ExitStatus::UserFiles)
        }
    }
}

fn of(file: &BoardFile) -> BoardDevices {
    let BoardKind::Real(spec) = &file.kind else { return BoardDevices::default() };
    let mut used = Vec::new();
    let mut uses = |name, so: bool| {
        if so {
            used.push(name);
        }
    };
    uses("GPIO", spec.of::<GpioSpec>().is_some_and(GpioSpec::is_used));
    // A converter that no channel uses may be missing.
    let read = |spi: bool| {
        spec.of::<AdcsSpec>().is_some_and(|adcs| {
            let kinds = adcs.samples.iter().filter_map(|sample| adcs.converters.get(sample.converter));
            kinds.into_iter().any(|converter| matches!(converter.kind, AdcKind::Spi(_)) == spi)
        })
    };
    let generators = || {
        let all = spec.of::<GeneratorsSpec>().into_iter();
        all.flat_map(|all| all.outputs.iter().filter_map(|output| all.generators.get(output.generator)))
    };
    let streams = generators().filter_map(|generator| match &generator.kind {
        GeneratorKind::Stream(stream) => Some(stream.buffer),
        GeneratorKind::Pwm(_) => None,
    });
    let buffer = streams.max().unwrap_or(0);
    uses("SPI", read(true) || buffer > 0);
    uses("PWM", generators().any(|generator| matches!(generator.kind, GeneratorKind::Pwm(_))));
    uses("ADC", read(false));
    uses("counter", spec.of::<CountersSpec>().is_some_and(CountersSpec::is_used));
    uses("CAN", spec.of::<CanSpec>().is_some_and(CanSpec::is_used));
    let serial = spec.of::<SerialLinesSpec>().into_iter().flat_map(|serial| &serial.lines);
    let ports = serial.map(|line| line.port.path.to_string_lossy().into_owned());
    BoardDevices { names: used, buffer, ports: ports.collect(), counts: super::figures::counts(file) }
}

/// The first of the board's ports that cannot be had makes it unfit.
fn ports(machine: &HostMachine, ports: &[String]) -> DoctorCheck {
    if let Some(missing) = ports.iter().find(|port| !machine.has(port)) {
        return DoctorCheck::bad(GROUP, SERIAL, format!("{missing} is not there")).means("the board uses it");
    }
    match ports.iter().find(|port| !machine.may_use(port)) {
        Some(refused) => {
            let check = DoctorCheck::bad(GROUP, SERIAL, format!("{refused} is not to be used"));
            let (fix, then) = grant(machine, refused, "tty", "dialout");
            check.means("the board uses it").fix(fix).then(then)
        }
        None => DoctorCheck::good(GROUP, SERIAL, ports.join(", ")),
    }
}

/// Adds what was measured of the board.
pub fn measured(checks: &mut Vec<DoctorCheck>, used: &mut BoardDevices, machine: &HostMachine) {
    checks.extend(used.counts.take().filter(|_| machine.is_here()));
}

/// A stream that the driver does not take at once makes the board unfit.
fn transfers(machine: &HostMachine, buffer: u32) -> DoctorCheck {
    match settings::buffer(machine) {
        Some(bytes) if bytes < buffer => {
            DoctorCheck::bad(GROUP, TRANSFERS, format!("of up to {bytes} bytes, and a stream of the board has {buffer}"))
                .means("the board cannot be opened")
                .fix(format!("echo 'options spidev bufsiz={buffer}' | sudo tee /etc/modprobe.d/rig-spidev.conf"))
                .then(format!("restart the machine; where the driver is built in: spidev.bufsiz={buffer} on the kernel's command line"))
        }
        Some(bytes) => DoctorCheck::good(GROUP, TRANSFERS, format!("of up to {bytes} bytes, enough for the board's streams")),
        None => DoctorCheck::open(GROUP, TRANSFERS, "the driver does not say how long they may be"),
    }
}

/// Devices that the board does not use are no drawback, whatever they are; without one that it uses it cannot run.
pub fn judge(checks: &mut [DoctorCheck], used: &BoardDevices, machine: &HostMachine) {
    for check in checks.iter_mut().filter(|check| check.group == GROUP) {
        if check.name == SERIAL && !used.ports.is_empty() {
            *check = ports(machine, &used.ports);
            continue;
        }
        if check.name == TRANSFERS && used.buffer > 0 {
            *check = transfers(machine, used.buffer);
            continue;
        }
        match (used.names.contains(&check.name), check.state) {
            (false, CheckState::Poor | CheckState::Bad) => {
                check.state = CheckState::Open;
                check.means = "the board does not use it";
                (check.fix, check.then) = (None, String::new());
            }
            // None is there, it is switched off, or it is not to be used.
            (true, CheckState::Open | CheckState::Poor | CheckState::Bad) => {
                check.state = CheckState::Bad;
                check.means = "the board uses it";
            }
            (_, CheckState::Good) | (false, CheckState::Open) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_the_board_uses_makes_a_machine_unfit() {
        let mut checks = [
            DoctorCheck::bad(GROUP, "GPIO", "none").fix("do something"),
            DoctorCheck::open(GROUP, "SPI", "none"),
            DoctorCheck::good(GROUP, "CAN", "can0"),
            DoctorCheck::poor("kernel", "kind", "PREEMPT"),
        ];
        let used = BoardDevices { names: vec!["SPI", "CAN"], ..BoardDevices::default() };
        judge(&mut checks, &used, &HostMachine::here());
        assert_eq!(
            checks.each_ref().map(|check| check.state),
            [CheckState::Open, CheckState::Bad, CheckState::Good, CheckState::Poor]
        );
        assert_eq!((&checks[0].fix, checks[1].means), (&None, "the board uses it"));
    }

    #[test]
    fn a_stream_that_is_longer_than_the_driver_takes_makes_a_machine_unfit() {
        let root = std::env::temp_dir().join(format!("scanrig-used-{}", std::process::id()));
        let at = root.join("sys/module/spidev/parameters");
        std::fs::create_dir_all(&at).unwrap();
        std::fs::write(at.join("bufsiz"), "4096\n").unwrap();
        let machine = HostMachine::below(&root);
        let with = |buffer: u32| {
            let mut checks = [DoctorCheck::good(GROUP, TRANSFERS, "of up to 4096 bytes")];
            judge(&mut checks, &BoardDevices { buffer, ..BoardDevices::default() }, &machine);
            let [check] = checks;
            (check.state, check.fix)
        };
        assert_eq!(with(0), (CheckState::Good, None));
        assert_eq!(with(4_096), (CheckState::Good, None));
        let fix = "echo 'options spidev bufsiz=65536' | sudo tee /etc/modprobe.d/rig-spidev.conf";
        assert_eq!(with(65_536), (CheckState::Bad, Some(fix.to_owned())));
        std::fs::remove_dir_all(&root).unwrap();
    }
}
