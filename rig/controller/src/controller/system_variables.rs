//! What the system variables show, and how a program that mentions them sees them. The values of all members come from
//! [`Controller::field_bits`] and [`Controller::field_text`]; what is beyond them is made of the tables in `profile`.

use super::Controller;
use crate::location::ExtentStart;
use crate::probes::class;
use crate::registers::signature_word;
use crate::system_words::{SystemLink, element_names};
use crate::{Effects, Probe, RegisterProbe, VariableLocation};
use profile::{
    FILE_HANDLES, FIRMWARE_VERSION, Family, IoStatus, MemberSource, MemberType, ModuleRead, PlcRead,
    SERIAL_NUMBER, SystemField, SystemMember, SystemStructure, SystemVariable, USER_DISK_BYTES, VENDOR_ID,
    VENDOR_NAME,
};
use signal::{Cause, Time, Value};

impl Controller {
    /// The bits of a member: an array of bytes has its first byte lowest. A text has none.
    fn field_bits(&self, field: SystemField, part: u8) -> u64 {
        match field {
            SystemField::PlcR(field) => self.plc_bits(field),
            SystemField::Tm3ModuleR(ModuleRead::ProductId) => {
                u64::from(self.modules.bus.id(usize::from(part)))
            }
            SystemField::Tm3ModuleR(ModuleRead::State) => {
                u64::from(self.module_state(usize::from(part)).code())
            }
            SystemField::PlcW(_)
            | SystemField::SerialW(_)
            | SystemField::EthW(_)
            | SystemField::Tm3BusW(_) => u64::from(self.system.words.get(SystemVariable { field, part })),
            SystemField::SerialR(_) | SystemField::EthR(_) | SystemField::ProfibusR(_) => rest(field),
        }
    }

    /// The bits of a member of PLC_R.
    fn plc_bits(&self, field: PlcRead) -> u64 {
        let system = &self.system;
        let version = u64::from(u32::from_le_bytes(FIRMWARE_VERSION));
        let signature = |place| {
            let application = self.application.as_deref();
            signature_word(application.map_or(0, |application| application.signature()), place)
        };
        match field {
            PlcRead::VendorId => u64::from(VENDOR_ID),
            PlcRead::ProductId => u64::from(self.config.reference.product_id()),
            PlcRead::SerialNumber => u64::from(SERIAL_NUMBER),
            PlcRead::FirmwareVersion | PlcRead::BootVersion | PlcRead::CoprocessorVersion => version,
            PlcRead::HardwareVersion => 0,
            PlcRead::Status => self.state.status().map_or(0, |status| u64::from(status.code())),
            PlcRead::BootProjectStatus => u64::from(system.boot_project.code()),
            PlcRead::LastStopCause => u64::from(system.stop_cause.code()),
            PlcRead::LastApplicationError => u64::from(system.error.code()),
            PlcRead::SystemFault1 => {
                self.external.word(self.modules.bus.status() != IoStatus::Ok, self.modules.tm4_error())
            }
            PlcRead::SystemFault2 => u64::MAX,
            PlcRead::IoStatus1 => self.local_io_status().map_or(0, |status| u64::from(status.code())),
            PlcRead::IoStatus2 => u64::from(self.modules.status(self.state).code()),
            PlcRead::Battery => u64::from(self.system.rtc.charge()),
            PlcRead::Signature1 => signature(0),
            PlcRead::Signature2 => signature(1),
            PlcRead::Signature3 => signature(2),
            PlcRead::Signature4 => signature(3),
            PlcRead::LastStopTime => u64::from(system.dates.stop),
            PlcRead::LastPowerOffDate => u64::from(system.dates.off),
            PlcRead::EventsCounter => u64::from(system.events),
            // None or connected: a tool is there at once (controller:SYS-06).
            PlcRead::TerminalPort => 2 * u64::from(self.power.tool_connected),
            PlcRead::FreeFileHandles => u64::from(FILE_HANDLES),
            PlcRead::TotalBytes => USER_DISK_BYTES,
            PlcRead::FreeBytes => self.files.free_bytes(),
            PlcRead::Tm3BusState => u64::from(self.modules.bus.start_state().code()),
            PlcRead::RunStopInput => match (self.config.reference.family, self.config.run_stop_input) {
                (Family::M251, _) => 0,
                (Family::M241, Some(input)) => input as u64,
                (Family::M241, None) => 0xFF,
            },
            PlcRead::Clock10Ms | PlcRead::Clock100Ms | PlcRead::Clock1S => {
                u64::from(system.clocks.level(field, self.scheduler.now()))
            }
            PlcRead::SdCard | PlcRead::VendorName | PlcRead::ProductReference | PlcRead::NodeName => {
                rest(field.into())
            }
        }
    }

    /// The characters of a text.
    fn field_text(&self, field: SystemField) -> &'static str {
        match field {
            SystemField::PlcR(PlcRead::VendorName) => VENDOR_NAME,
            // A controller without a configured name has its reference as name (rig definition).
            SystemField::PlcR(PlcRead::ProductReference | PlcRead::NodeName) => self.config.reference.name,
            _ => "",
        }
    }

    /// A register of a member: the lower bits and characters come first (controller:REL-04).
    pub(super) fn field_word(&self, field: SystemField, part: u8, word: u16) -> u16 {
        let place = usize::from(word);
        match field.member().ty(self.config.profile) {
            MemberType::Text(_) => {
                let text = self.field_text(field).as_bytes();
                let byte = |at: usize| text.get(at).copied().unwrap_or(0);
                u16::from_le_bytes([byte(2 * place), byte(2 * place + 1)])
            }
            _ if place < 4 => (self.field_bits(field, part) >> (16 * place)) as u16,
            _ => 0,
        }
    }

    /// What a system variable shows; unknown while no service answers.
    pub(super) fn read_system(&self, variable: SystemVariable) -> Value {
        if self.state.status().is_none() {
            return Value::Unknown;
        }
        let SystemVariable { field, part } = variable;
        match field.member().ty(self.config.profile) {
            MemberType::Bool => Value::Bool(self.field_bits(field, part) != 0),
            MemberType::Bytes(_) => {
                Value::Word(self.field_bits(field, 0) >> (8 * u32::from(part.min(7))) & 0xFF)
            }
            _ => Value::Word(self.field_bits(field, part)),
        }
    }

    /// Looks up the system variables that a new application mentions.
    pub(super) fn link_system(&mut self) {
        self.system.links.clear();
        if self.application.is_none() {
            return;
        }
        for structure in SystemStructure::ALL {
            for (part, whole) in element_names(structure) {
                for member in structure.members_of(self.config.profile) {
                    for name in member.names_of_it() {
                        self.link(member, part, &format!("{whole}.{name}"));
                    }
                }
            }
        }
        self.watch_system();
        self.start_clocks();
        self.show_fixed();
        self.show_system();
    }

    /// Looks up a member by a name of it.
    fn link(&mut self, member: &SystemMember, part: u8, name: &str) {
        let Some(application) = &self.application else { return };
        let links = &mut self.system.links;
        let (field, is_fixed) = (member.field, member.source != MemberSource::Live);
        let list = match field.is_writable() {
            true => &mut links.written,
            false if is_fixed => &mut links.fixed,
            false => &mut links.live,
        };
        let link = |word, number| SystemLink { field, part, word, number };
        let ty = member.ty(self.config.profile);
        if !matches!(ty, MemberType::Bytes(_) | MemberType::Text(_)) {
            list.extend(application.variable(name).map(|number| link(None, number)));
            return;
        }
        let Some(VariableLocation::Extent { first: ExtentStart::Variable(first), bytes }) =
            application.locate(name)
        else {
            return;
        };
        let words = ty.words().min(bytes.div_ceil(2) as u16);
        list.extend(
            (0..words).filter_map(|word| Some(link(Some(word), application.word_of(first, bytes, word)?))),
        );
    }

    /// Has the application stop where it writes a system variable.
    pub(super) fn watch_system(&mut self) {
        let Some(application) = &mut self.application else { return };
        for link in &self.system.links.written {
            application.watch(link.number);
        }
    }

    /// Has the edges come of the clock bits that somebody looks at.
    pub(super) fn start_clocks(&mut self) {
        let mut clocks = self.system.clocks;
        clocks.observe(self.scheduler.now(), |bit| {
            self.system.links.shows(bit.into())
                || self.probes.find(&Probe::System(bit.into())).is_some()
                || self.is_register_observed(bit.into())
        });
        self.system.clocks = clocks;
    }

    /// Whether somebody looks at a register of a member.
    fn is_register_observed(&self, field: SystemField) -> bool {
        self.probes.iter().any(|probe| match probe {
            Probe::Register(RegisterProbe::Value(register)) => self.field_at(*register) == Some(field),
            _ => false,
        })
    }

    /// When the next edge of a clock bit is due.
    pub(super) fn clock_due(&self) -> Time {
        if self.state.status().is_some() { self.system.clocks.next() } else { Time::MAX }
    }

    /// The edges of clock bits due at `now`.
    pub(super) fn fire_clocks(&mut self, now: Time, fx: &mut Effects) {
        if self.clock_due() <= now {
            self.system.clocks.fire(now);
            self.observe(class::STATE, now, Cause::Controller, fx);
        }
    }

    /// Shows the program the system variables that it mentions, but for those that never change.
    #[inline]
    pub(super) fn show_system(&mut self) {
        if self.state.status().is_some() {
            for place in 0..self.system.links.live.len() {
                self.show(self.system.links.live[place]);
            }
        }
    }

    /// Shows the program the system variables that never change: they are its variables, which a reset gives other values.
    pub(super) fn show_fixed(&mut self) {
        for place in 0..self.system.links.fixed.len() {
            self.show(self.system.links.fixed[place]);
        }
    }

    fn show(&mut self, link: SystemLink) {
        let SystemLink { field, part, word, number } = link;
        let value = match word {
            Some(word) => Value::Word(u64::from(self.field_word(field, part, word))),
            None if field.member().ty(self.config.profile) == MemberType::Bool => {
                Value::Bool(self.field_bits(field, part) != 0)
            }
            None => Value::Word(self.field_bits(field, part)),
        };
        if let Some(application) = &mut self.application {
            application.write(number, value);
        }
    }
}

/// The value of a member that nothing feeds yet.
const fn rest(field: SystemField) -> u64 {
    match field.member().source {
        MemberSource::Rest(value) => value,
        MemberSource::Live | MemberSource::Fixed => 0,
    }
}
