//! The devices that a board file uses, and what their state means to it.

use super::check::{Check, State};
use super::devices::{GROUP, grant};
use crate::exit::Exit;
use crate::output;
use drivers::convert::ConverterKind;
use drivers::file::{BoardFile, BoardKind};
use host::Machine;
use runtime::suite::{self, Disk};
use std::path::Path;

/// The check of serial ports.
const SERIAL: &str = "serial";

/// What a board file uses.
#[derive(Default)]
pub struct Used {
    /// The names of the checks of its devices, but for serial ports.
    names: Vec<&'static str>,
    /// Its serial ports: a machine has more of them than can be listed without opening them, so the board file is asked.
    ports: Vec<String>,
}

/// The devices that a board file uses.
///
/// # Errors
/// Something is wrong with the file, which was said.
pub fn devices(path: &Path) -> Result<Used, Exit> {
    let mut sources = Vec::new();
    match suite::load_board(&Disk, &path.to_string_lossy(), &mut sources) {
        Ok((file, _)) => Ok(of(&file)),
        Err(found) => {
            output::findings(&found, &sources);
            Err(Exit::UserFiles)
        }
    }
}

fn of(file: &BoardFile) -> Used {
    let BoardKind::Real(spec) = &file.kind else { return Used::default() };
    let mut used = Vec::new();
    let mut uses = |name, so: bool| {
        if so {
            used.push(name);
        }
    };
    uses("GPIO", !spec.gpio.lines.is_empty());
    // A converter that no channel uses may be missing.
    let read = |spi: bool| {
        spec.converters.samples.iter().any(|sample| {
            let kind = spec.converters.converters.get(sample.converter).map(|converter| &converter.kind);
            kind.is_some_and(|kind| matches!(kind, ConverterKind::Spi(_)) == spi)
        })
    };
    uses("SPI", read(true));
    uses("ADC", read(false));
    uses("CAN", !spec.can.buses.is_empty());
    let ports = spec.serial.iter().map(|serial| serial.port.path.to_string_lossy().into_owned());
    Used { names: used, ports: ports.collect() }
}

/// The first of the board's ports that cannot be had makes it unfit.
fn ports(machine: &Machine, ports: &[String]) -> Check {
    if let Some(missing) = ports.iter().find(|port| !machine.has(port)) {
        return Check::bad(GROUP, SERIAL, format!("{missing} is not there")).means("the board uses it");
    }
    match ports.iter().find(|port| !machine.may_use(port)) {
        Some(refused) => {
            let check = Check::bad(GROUP, SERIAL, format!("{refused} is not to be used"));
            let (mend, then) = grant(machine, refused, "tty", "dialout");
            check.means("the board uses it").mend(mend).then(then)
        }
        None => Check::good(GROUP, SERIAL, ports.join(", ")),
    }
}

/// Devices that the board does not use are no drawback, whatever they are; without one that it uses it cannot run.
pub fn judge(checks: &mut [Check], used: &Used, machine: &Machine) {
    for check in checks.iter_mut().filter(|check| check.group == GROUP) {
        if check.name == SERIAL && !used.ports.is_empty() {
            *check = ports(machine, &used.ports);
            continue;
        }
        match (used.names.contains(&check.name), check.state) {
            (false, State::Poor | State::Bad) => {
                check.state = State::Open;
                check.means = "the board does not use it";
                (check.mend, check.then) = (None, String::new());
            }
            // None is there, it is switched off, or it is not to be used.
            (true, State::Open | State::Poor | State::Bad) => {
                check.state = State::Bad;
                check.means = "the board uses it";
            }
            (_, State::Good) | (false, State::Open) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_the_board_uses_makes_a_machine_unfit() {
        let mut checks = [
            Check::bad(GROUP, "GPIO", "none").mend("do something"),
            Check::open(GROUP, "SPI", "none"),
            Check::good(GROUP, "CAN", "can0"),
            Check::poor("kernel", "kind", "PREEMPT"),
        ];
        let used = Used { names: vec!["SPI", "CAN"], ports: Vec::new() };
        judge(&mut checks, &used, &Machine::here());
        assert_eq!(
            checks.each_ref().map(|check| check.state),
            [State::Open, State::Bad, State::Good, State::Poor]
        );
        assert_eq!((&checks[0].mend, checks[1].means), (&None, "the board uses it"));
    }
}
