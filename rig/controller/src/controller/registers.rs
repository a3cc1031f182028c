//! Registers as clients in the network read and write them (controller:MEM-06, controller:MEM-07). Protocols come to the
//! controller's memory by these two functions alone.

use super::Controller;
use crate::location::{memory_bytes, with_word, word_of};
use crate::registers::{part_of, word_address};
use crate::relocation::{RelocationTable, RelocationTarget};
use crate::{
    Application, Effects, ExtentStart, Probe, RegisterError, RegisterFormat, RegisterProbe, RelocationPart,
    RelocationRow, VariableLocation,
};
use profile::{RegisterPermission, RegisterRange, RegisterRangeKind, SystemField, SystemVariable};
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
        self.permission(register).writes()
    }

    /// What a request may do with a register.
    fn permission(&self, register: u16) -> RegisterPermission {
        let range = RegisterRange::of(register);
        let declared =
            part_of(range.kind).is_some_and(|part| self.registers.table().at(part, register).is_some());
        range.permission(self.config.profile, declared)
    }

    fn register(&self, register: u16) -> Result<u16, RegisterError> {
        if !self.permission(register).reads() {
            return Err(RegisterError::IllegalAddress);
        }
        match RegisterRange::of(register).kind {
            RegisterRangeKind::Memory => {
                let load = |at| self.memory.load(at) as u16;
                word_address(register).map(load).ok_or(RegisterError::IllegalAddress)
            }
            RegisterRangeKind::System => {
                let found = SystemField::located(self.config.profile, register);
                Ok(found.map_or(0, |(field, word)| self.field_word(field, 0, word)))
            }
            RegisterRangeKind::ReadTable => Ok(self.table_word(RelocationPart::Read, register)),
            RegisterRangeKind::WriteTable => Ok(self.table_word(RelocationPart::Write, register)),
            RegisterRangeKind::SystemWrite | RegisterRangeKind::Reserved => Ok(0),
        }
    }

    fn table_word(&self, part: RelocationPart, register: u16) -> u16 {
        match self.registers.table().at(part, register) {
            Some((target, word)) => self.target_word(target, word),
            None => self.registers.loose(part, register),
        }
    }

    /// The member of a system structure that a row of the relocation table puts into a register.
    pub(super) fn field_at(&self, register: u16) -> Option<SystemField> {
        let part = part_of(RegisterRange::of(register).kind)?;
        match self.registers.table().at(part, register)? {
            (RelocationTarget::Member(field, _), _) => Some(field),
            _ => None,
        }
    }

    fn target_word(&self, target: RelocationTarget, word: u16) -> u16 {
        match target {
            RelocationTarget::Member(field, part) => self.field_word(field, part, word),
            RelocationTarget::Variable(variable) => {
                word_of(RegisterFormat::Whole(4), self.read_system(variable), word)
            }
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
        let kind = RegisterRange::of(register).kind;
        if kind == RegisterRangeKind::Memory
            && let Some(at) = word_address(register)
        {
            self.memory.set_cause(cause);
            self.memory.store(at, u64::from(value));
        }
        let Some(part) = part_of(kind) else { return };
        match self.registers.table().at(part, register) {
            // One that is only read stays as it is, wherever it was put; and what the state does not take is no error
            // (controller:CMD-01).
            Some((RelocationTarget::Member(field, part), _)) => {
                let _ =
                    self.write_system(SystemVariable { field, part }, Value::Word(u64::from(value)), now, fx);
            }
            Some((RelocationTarget::Variable(_), _)) => {}
            Some((RelocationTarget::Application(located), word)) => {
                self.set_located(located, word, value, cause)
            }
            None => self.registers.set_loose(part, register, value),
        }
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

    /// Packs the relocation table for an application, or for none.
    pub(super) fn relocate(&mut self) {
        let application = self.application.as_deref();
        // An application whose table does not fit was refused when it was built.
        let table = RelocationTable::pack(&self.config.relocation, application, self.config.profile)
            .unwrap_or_default();
        self.registers.set_table(table);
        self.watch_rows();
        self.start_clocks();
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
        let kind = RegisterRange::of(register).kind;
        let located = match (kind, part_of(kind)) {
            (RegisterRangeKind::Memory, _) => {
                word_address(register).map(|at| (VariableLocation::Memory(at), 0))
            }
            (_, Some(part)) => match self.registers.table().at(part, register) {
                Some((RelocationTarget::Application(located), word)) => Some((located, word)),
                Some((RelocationTarget::Member(..) | RelocationTarget::Variable(_), _)) | None => None,
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
