//! Registers as clients in the network read and write them (controller:MEM-06, controller:MEM-07). Protocols come to the
//! controller's memory by these two functions alone.

use super::Controller;
use crate::location::{memory_bytes, with_word, word_of};
use crate::probes::class;
use crate::registers::{Block, block, signature_word, word_address};
use crate::relocation::{RelocationTable, RelocationTarget};
use crate::{
    Application, Effects, ExtentStart, Probe, RegisterError, RegisterFormat, RegisterProbe, RelocationPart,
    RelocationRow, SystemVariable, VariableLocation,
};
use profile::{
    FILE_HANDLES, FIRMWARE_VERSION, Profile, SERIAL_NUMBER, SystemField, USER_DISK_BYTES, VENDOR_NAME,
};
use signal::{Cause, Time, Value};

impl Controller {
    /// Reads registers from `first` on for a client in the network, at any moment between two operations of the
    /// application (controller:MEM-11).
    ///
    /// # Errors
    /// [`RegisterError`]; `out` is then not to be used.
    pub fn read_registers(&self, first: u16, out: &mut [u16]) -> Result<(), RegisterError> {
        if self.state.status().is_none() {
            return Err(RegisterError::NoAnswer);
        }
        for (place, word) in out.iter_mut().enumerate() {
            let offset = u16::try_from(place).map_err(|_| RegisterError::IllegalAddress)?;
            let register = first.checked_add(offset).ok_or(RegisterError::IllegalAddress)?;
            *word = self.register(register)?;
        }
        Ok(())
    }

    /// Writes registers from `first` on for a client in the network; all of them or none.
    ///
    /// # Errors
    /// [`RegisterError`]; nothing is written then.
    pub fn write_registers(
        &mut self,
        now: Time,
        first: u16,
        values: &[u16],
        cause: Cause,
        fx: &mut Effects,
    ) -> Result<(), RegisterError> {
        if self.state.status().is_none() {
            return Err(RegisterError::NoAnswer);
        }
        let mut all = (0..values.len()).map(|place| {
            let offset = u16::try_from(place).ok();
            offset.and_then(|offset| first.checked_add(offset)).filter(|register| self.is_open(*register))
        });
        if all.any(|open| open.is_none()) {
            return Err(RegisterError::IllegalAddress);
        }
        for (register, value) in (first..=u16::MAX).zip(values) {
            self.set_register(now, register, *value, cause, fx);
        }
        self.observe_memory(now, cause, fx);
        Ok(())
    }

    /// Whether a register may be written (controller:MEM-07).
    fn is_open(&self, register: u16) -> bool {
        let first_edition = self.config.profile == Profile::M241_2014;
        match block(register) {
            Block::Memory | Block::SystemWrite | Block::Table(RelocationPart::Write) => true,
            Block::System | Block::Reserved => false,
            Block::Table(RelocationPart::Read) => {
                first_edition && self.registers.table().at(RelocationPart::Read, register).is_none()
            }
        }
    }

    fn register(&self, register: u16) -> Result<u16, RegisterError> {
        let first_edition = self.config.profile == Profile::M241_2014;
        match block(register) {
            Block::Memory => {
                let load = |at| self.memory.load(at) as u16;
                word_address(register).map(load).ok_or(RegisterError::IllegalAddress)
            }
            Block::System => {
                let found = SystemField::located(self.config.profile, register);
                Ok(found.map_or(0, |(field, word)| self.field_word(field, word)))
            }
            Block::Table(part) => match self.registers.table().at(part, register) {
                // What is declared in the write table may only be written in 2014 (controller:MEM-07).
                Some(_) if first_edition && part == RelocationPart::Write => {
                    Err(RegisterError::IllegalAddress)
                }
                Some((target, word)) => Ok(self.target_word(target, word)),
                None => Ok(self.registers.loose(part, register)),
            },
            Block::SystemWrite => Ok(0),
            Block::Reserved => Err(RegisterError::IllegalAddress),
        }
    }

    fn target_word(&self, target: RelocationTarget, word: u16) -> u16 {
        match target {
            RelocationTarget::System(field) => self.field_word(field, word),
            RelocationTarget::Application(located) => self.located_word(located, word),
        }
    }

    fn located_word(&self, located: VariableLocation, word: u16) -> u16 {
        let read =
            |number, form, word| self.application.as_ref().map(|it| word_of(form, it.read(number), word));
        match located {
            VariableLocation::Memory(at) => (self.memory.load(at) >> (16 * u32::from(word.min(3)))) as u16,
            VariableLocation::Variable(number, form) => read(number, form, word).unwrap_or(0),
            VariableLocation::Extent { first: ExtentStart::Memory(first), bytes } => {
                let mut pair = [0; 2];
                for (byte, at) in pair.iter_mut().zip(memory_bytes(first, bytes, word)) {
                    *byte = self.memory.load(at) as u8;
                }
                u16::from_le_bytes(pair)
            }
            VariableLocation::Extent { first: ExtentStart::Variable(first), bytes } => {
                let number = self.application.as_ref().and_then(|it| it.word_of(first, bytes, word));
                number.and_then(|number| read(number, RegisterFormat::Whole(1), 0)).unwrap_or(0)
            }
        }
    }

    fn set_register(&mut self, now: Time, register: u16, value: u16, cause: Cause, fx: &mut Effects) {
        match block(register) {
            Block::Memory => {
                if let Some(at) = word_address(register) {
                    self.memory.set_cause(cause);
                    self.memory.store(at, u64::from(value));
                }
            }
            Block::Table(part) => match self.registers.table().at(part, register) {
                Some((RelocationTarget::System(field), _)) => self.set_field(now, field, value, fx),
                Some((RelocationTarget::Application(located), word)) => {
                    self.set_located(located, word, value, cause)
                }
                None => self.registers.set_loose(part, register, value),
            },
            Block::System | Block::SystemWrite | Block::Reserved => {}
        }
    }

    /// A client writes a system variable; one that is only read stays as it is, wherever it was put.
    fn set_field(&mut self, now: Time, field: SystemField, value: u16, fx: &mut Effects) {
        let commands = match field {
            SystemField::PlcControl => SystemVariable::PlcControl,
            SystemField::OpenPlcControl => SystemVariable::OpenPlcControl,
            SystemField::Writable(place) => {
                // PLC_W.q_wResetCounterEvent acts as it goes from 0 to 1 (plcsystem:PLCR-11).
                if (place, self.registers.writable(place), value) == (0, 0, 1) {
                    self.system.events = 0;
                    self.observe(class::STATE, now, Cause::Controller, fx);
                }
                self.registers.set_writable(place, value);
                return;
            }
            _ => return,
        };
        // A command that the state does not take is no error (controller:CMD-01).
        let _ = self.write_system(commands, Value::Word(u64::from(value)), now, fx);
    }

    fn set_located(&mut self, located: VariableLocation, word: u16, value: u16, cause: Cause) {
        match located {
            VariableLocation::Memory(at) => {
                let form = if at.bit_len() == 1 { RegisterFormat::Bit } else { RegisterFormat::Whole(4) };
                let new = with_word(form, Value::Word(self.memory.load(at)), word, value);
                self.memory.set_cause(cause);
                self.memory.store(at, new.as_int().map_or(0, |bits| bits as u64));
            }
            VariableLocation::Variable(number, form) => {
                if let Some(application) = &mut self.application {
                    let new = with_word(form, application.read(number), word, value);
                    application.write(number, new);
                }
            }
            VariableLocation::Extent { first: ExtentStart::Memory(first), bytes } => {
                self.memory.set_cause(cause);
                for (byte, at) in value.to_le_bytes().into_iter().zip(memory_bytes(first, bytes, word)) {
                    self.memory.store(at, u64::from(byte));
                }
            }
            VariableLocation::Extent { first: ExtentStart::Variable(first), bytes } => {
                if let Some(application) = &mut self.application
                    && let Some(number) = application.word_of(first, bytes, word)
                {
                    application.write(number, Value::Word(u64::from(value)));
                }
            }
        }
    }

    /// A register of a system variable (controller:SYS-06); what no document gives is a rig definition.
    fn field_word(&self, field: SystemField, word: u16) -> u16 {
        use SystemField as Field;
        let part = |bits: u64| (bits >> (16 * u32::from(word.min(3)))) as u16;
        let text = |text: &str| {
            let byte = |at: usize| text.as_bytes().get(at).copied().unwrap_or(0);
            u16::from_le_bytes([byte(usize::from(word) * 2), byte(usize::from(word) * 2 + 1)])
        };
        let signature = self.application.as_ref().map_or(0, |application| application.signature());
        match field {
            Field::VendorId => self.system_word(SystemVariable::VendorId, word),
            Field::ProductId => self.config.reference.product_id(),
            Field::SerialNumber => part(u64::from(SERIAL_NUMBER)),
            Field::FirmwareVersion | Field::BootVersion | Field::CoprocessorVersion => {
                part(u64::from(u32::from_le_bytes(FIRMWARE_VERSION)))
            }
            Field::HardwareVersion => 0,
            Field::Status => self.system_word(SystemVariable::Status, word),
            Field::BootProjectStatus => self.system_word(SystemVariable::BootProjectStatus, word),
            Field::LastStopCause => self.system_word(SystemVariable::LastStopCause, word),
            Field::LastApplicationError => self.system_word(SystemVariable::LastApplicationError, word),
            Field::SystemFault1 => self.system_word(SystemVariable::SystemFault1, word),
            Field::SystemFault2 => u16::MAX,
            Field::IoStatus1 => self.system_word(SystemVariable::IoStatus1, word),
            Field::IoStatus2 => self.system_word(SystemVariable::IoStatus2, word),
            Field::Battery => self.system_word(SystemVariable::ClockBatteryStatus, word),
            Field::LastStopTime => self.system_word(SystemVariable::LastStopTime, word),
            Field::LastPowerOffDate => self.system_word(SystemVariable::LastPowerOffDate, word),
            Field::EventsCounter => self.system_word(SystemVariable::EventsCounter, word),
            Field::RunStopInput => self.system_word(SystemVariable::RunStopInput, word),
            Field::PlcControl => self.system_word(SystemVariable::PlcControl, word),
            Field::OpenPlcControl => self.system_word(SystemVariable::OpenPlcControl, word),
            Field::Signature(place) => part(signature_word(signature, place)),
            Field::VendorName => text(VENDOR_NAME),
            Field::ProductReference => text(self.config.reference.name),
            // A controller without a configured name has its reference as name (rig definition).
            Field::NodeName => text(self.config.reference.name),
            Field::FreeFileHandles => FILE_HANDLES,
            Field::TotalBytes => part(USER_DISK_BYTES),
            Field::FreeBytes => part(self.files.free_bytes()),
            // None or connected: a tool is there at once (controller:SYS-06).
            Field::TerminalPort => 2 * u16::from(self.power.tool_connected),
            Field::SdCard => 0,
            Field::Tm3Bus => self.system_word(SystemVariable::Tm3BusState, word),
            Field::Writable(place) => self.registers.writable(place),
        }
    }

    /// A register of a system variable; 0 where it is not known.
    fn system_word(&self, variable: SystemVariable, word: u16) -> u16 {
        word_of(RegisterFormat::Whole(4), self.read_system(variable), word)
    }

    /// Packs the relocation table for an application, or for none.
    pub(super) fn relocate(&mut self) {
        let application = self.application.as_deref();
        // An application whose table does not fit was refused when it was built.
        let table = RelocationTable::pack(&self.config.relocation, application, self.config.profile)
            .unwrap_or_default();
        self.registers.set_table(table);
        self.watch_rows();
    }

    /// Whether the relocation table fits with this application; else its first row that does not.
    pub(super) fn check_relocation(
        &self,
        application: &dyn Application,
    ) -> Result<(), (RelocationPart, usize)> {
        RelocationTable::pack(&self.config.relocation, Some(application), self.config.profile).map(|_| ())
    }

    /// A row of the relocation table.
    fn row(&self, part: RelocationPart, place: u16) -> Option<&RelocationRow> {
        self.registers.table().part(part).get(usize::from(place))
    }

    /// What a fact of the registers is now.
    pub(super) fn read_register_probe(&self, fact: RegisterProbe) -> Value {
        let answers = self.state.status().is_some();
        match fact {
            _ if !answers => Value::Unknown,
            RegisterProbe::Value(register) => {
                self.register(register).map_or(Value::Unknown, |word| Value::Word(u64::from(word)))
            }
            RegisterProbe::Exception(register) => {
                Value::Int(if self.register(register).is_err() { 2 } else { 0 })
            }
            RegisterProbe::Address(part, place) => self
                .row(part, place)
                .map_or(Value::Unknown, |row| Value::Int(row.address.map_or(-1, i64::from))),
            RegisterProbe::Length(part, place) => {
                self.row(part, place).map_or(Value::Unknown, |row| Value::Int(i64::from(row.words)))
            }
            RegisterProbe::Valid(part, place) => {
                self.row(part, place).map_or(Value::Unknown, |row| Value::Bool(row.address.is_some()))
            }
        }
    }

    /// Has the application stop at changes of what observed registers show.
    pub(super) fn watch_rows(&mut self) {
        for place in 0..self.probes.len() {
            if let Some(Probe::Register(RegisterProbe::Value(register))) = self.probes.get(place) {
                self.watch_register(register);
            }
        }
    }

    pub(super) fn watch_register(&mut self, register: u16) {
        let located = match block(register) {
            Block::Memory => word_address(register).map(|at| (VariableLocation::Memory(at), 0)),
            Block::Table(part) => match self.registers.table().at(part, register) {
                Some((RelocationTarget::Application(located), word)) => Some((located, word)),
                Some((RelocationTarget::System(_), _)) | None => None,
            },
            _ => None,
        };
        let Some((located, word)) = located else { return };
        let number = match located {
            VariableLocation::Memory(at) => {
                self.memory.watch(at);
                None
            }
            VariableLocation::Extent { first: ExtentStart::Memory(first), bytes } => {
                memory_bytes(first, bytes, word).for_each(|at| self.memory.watch(at));
                None
            }
            VariableLocation::Variable(number, _) => Some(number),
            VariableLocation::Extent { first: ExtentStart::Variable(first), bytes } => {
                self.application.as_ref().and_then(|it| it.word_of(first, bytes, word))
            }
        };
        if let (Some(number), Some(application)) = (number, &mut self.application) {
            application.watch(number);
        }
    }
}
