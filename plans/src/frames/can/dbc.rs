//! DBC files: what messages a bus carries, and which values stand in them.
//!
//! The crate `can-dbc` reads the text; what a plan may use of it is here, with the limits that a plan has.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::sync::Arc;

use can_dbc::{Dbc, DbcError, MessageId, MultiplexIndicator, SignalExtendedValueType, ValueType};
use document::{Data, Diagnostic, Node, SourceFile, Table, line_col};
use signal::Unit;

use super::coding::{ByteOrder, Coding, FrameSelector, RawKind};
use super::pattern::MAX_ID;
use crate::codes;
use crate::frames::MAX_DATA;

/// What the path of a DBC file ends with.
const ENDING: &str = ".dbc";
/// Most bytes of a DBC file.
const MOST_BYTES: usize = 4 << 20;
/// Most DBC files of a plan.
const MOST_FILES: usize = 16;
/// The deepest that multiplexed signals select each other.
const DEEPEST: usize = 8;

/// The messages of a DBC file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DbcDatabase {
    /// By their names; of two with one name the first.
    pub messages: BTreeMap<String, Arc<MessageSpec>>,
}

/// A message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MessageSpec {
    /// Its name.
    pub name: String,
    /// Its identifier.
    pub id: u32,
    /// Whether that has 29 bits.
    pub extended: bool,
    /// Number of data bytes, at most 64.
    pub size: usize,
    /// Its signals.
    pub fields: Vec<FieldSpec>,
}

impl MessageSpec {
    /// The signal of this name.
    pub fn field(&self, name: &str) -> Option<&FieldSpec> {
        self.fields.iter().find(|field| field.name == name)
    }
}

/// A signal of a message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FieldSpec {
    /// Its name.
    pub name: String,
    /// Its bits and what they mean.
    pub coding: Coding,
    /// What selects it, where it is multiplexed.
    pub selector: Option<FrameSelector>,
    /// The signal that selects it.
    pub selected_by: Option<String>,
    /// Its unit; empty for none.
    pub unit: String,
    /// Names of its values, by their numbers without factor and offset.
    pub labels: Vec<(i64, String)>,
}

/// Why a DBC file does not read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DbcFault {
    /// Bytes of the file.
    pub at: std::ops::Range<usize>,
    /// What is wrong, one sentence.
    pub message: String,
}

impl fmt::Display for DbcFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl DbcDatabase {
    /// Reads a DBC file.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn parse(text: &str) -> Result<DbcDatabase, DbcFault> {
        let whole = |message: String| DbcFault { at: 0..0, message };
        if text.len() > MOST_BYTES {
            return Err(whole(format!("the file has more than {MOST_BYTES} bytes")));
        }
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let dbc = Dbc::try_from(text).map_err(|error| fault(text, &error))?;
        let mut messages = BTreeMap::new();
        for message in &dbc.messages {
            if let Some(spec) = message_of(message, &dbc) {
                messages.entry(spec.name.clone()).or_insert_with(|| Arc::new(spec));
            }
        }
        Ok(DbcDatabase { messages })
    }
}

/// The place and the words of what the reader did not understand.
fn fault(text: &str, error: &DbcError) -> DbcFault {
    let DbcError::Pest(error) = error else {
        return DbcFault { at: 0..0, message: format!("it is no DBC file: {error}") };
    };
    // The reader keeps the line that it stopped at; an empty one is found nowhere, and the file as a whole is shown.
    let line = error.line();
    let start = if line.trim().is_empty() { 0 } else { text.find(line).unwrap_or(0) };
    let at = start..start + if start > 0 { line.trim_end().len() } else { 0 };
    let (number, _) = line_col(text, start);
    DbcFault { message: format!("line {number} is not what a DBC file has there"), at }
}

/// A message as a plan may use it; `None` for what stands for no frame, as signals without a message do.
fn message_of(message: &can_dbc::Message, dbc: &Dbc) -> Option<MessageSpec> {
    let (id, extended) = match message.id {
        MessageId::Standard(id) => (u32::from(id), false),
        MessageId::Extended(id) => (id, true),
    };
    let size = usize::try_from(message.size).ok().filter(|size| *size <= MAX_DATA)?;
    if !extended && id > MAX_ID {
        return None;
    }
    let fields = message.signals.iter().filter_map(|signal| field_of(signal, message, dbc));
    Some(MessageSpec { name: message.name.clone(), id, extended, size, fields: fields.collect() })
}

fn field_of(signal: &can_dbc::Signal, message: &can_dbc::Message, dbc: &Dbc) -> Option<FieldSpec> {
    let coding = coding_of(signal, message, dbc)?;
    let size = usize::try_from(message.size).ok()?;
    if coding.bytes() > size {
        return None;
    }
    let (selected_by, selector) = match selector_of(signal, message, dbc, 0) {
        Ok(Some((by, selector))) => (Some(by), Some(selector)),
        Ok(None) => (None, None),
        Err(()) => return None,
    };
    let described = dbc.value_descriptions_for_signal(message.id, &signal.name).unwrap_or_default();
    Some(FieldSpec {
        name: signal.name.clone(),
        coding,
        selector,
        selected_by,
        unit: Unit::new(&signal.unit).to_string(),
        labels: described.iter().map(|one| (one.id, one.description.clone())).collect(),
    })
}

fn coding_of(signal: &can_dbc::Signal, message: &can_dbc::Message, dbc: &Dbc) -> Option<Coding> {
    let order = match signal.byte_order {
        can_dbc::ByteOrder::LittleEndian => ByteOrder::Little,
        can_dbc::ByteOrder::BigEndian => ByteOrder::Big,
    };
    let raw = match (dbc.extended_value_type_for_signal(message.id, &signal.name), signal.value_type) {
        (Some(SignalExtendedValueType::IEEEfloat32Bit | SignalExtendedValueType::IEEEdouble64bit), _) => {
            RawKind::Float
        }
        (_, ValueType::Signed) => RawKind::Signed,
        (_, ValueType::Unsigned) => RawKind::Unsigned,
    };
    Coding::new((signal.start_bit, signal.size), order, raw, signal.factor, signal.offset)
}

/// What selects a multiplexed signal, and the name of what does. `Err` where nothing does that it speaks of.
fn selector_of(
    signal: &can_dbc::Signal,
    message: &can_dbc::Message,
    dbc: &Dbc,
    depth: usize,
) -> Result<Option<(String, FrameSelector)>, ()> {
    let value = match signal.multiplexer_indicator {
        MultiplexIndicator::Plain | MultiplexIndicator::Multiplexor => return Ok(None),
        MultiplexIndicator::MultiplexedSignal(value)
        | MultiplexIndicator::MultiplexorAndMultiplexedSignal(value) => value,
    };
    let extended = dbc
        .extended_multiplex
        .iter()
        .find(|one| one.message_id == message.id && one.signal_name == signal.name);
    let (selecting, ranges) = match extended {
        Some(one) => {
            let ranges = one.mappings.iter().map(|range| (range.min_value, range.max_value)).collect();
            (message.signals.iter().find(|other| other.name == one.multiplexor_signal_name), ranges)
        }
        None => {
            let switch =
                |other: &&can_dbc::Signal| other.multiplexer_indicator == MultiplexIndicator::Multiplexor;
            (message.signals.iter().find(switch), vec![(value, value)])
        }
    };
    let selecting = selecting.filter(|_| depth < DEEPEST).ok_or(())?;
    let of = coding_of(selecting, message, dbc).ok_or(())?;
    let under = selector_of(selecting, message, dbc, depth + 1)?.map(|(_, under)| Box::new(under));
    Ok(Some((selecting.name.clone(), FrameSelector { of, ranges, under })))
}

/// The DBC files that a plan may name, each with what is wrong with it if it does not read.
#[derive(Clone, Debug, Default)]
pub(crate) struct Databases(BTreeMap<String, Result<Arc<DbcDatabase>, Vec<Diagnostic>>>);

/// For where nothing names a DBC file.
pub(crate) static NONE: Databases = Databases(BTreeMap::new());

impl Databases {
    /// Opens every DBC file that a plan with these tables of TOML may name: all texts that end in `.dbc`, for a name may
    /// come out of a row or an argument. `open` gives the file of a name as it is written.
    pub(crate) fn gather<'t>(
        roots: impl Iterator<Item = &'t Table>,
        open: &mut dyn FnMut(&str) -> Result<SourceFile, String>,
    ) -> Databases {
        let mut names = BTreeSet::new();
        for entry in roots.flat_map(|root| &root.entries) {
            find(&entry.node, &mut names);
        }
        let mut databases = Databases::default();
        for name in names.into_iter().take(MOST_FILES) {
            let read = match open(&name) {
                Ok(file) => DbcDatabase::parse(&file.text).map(Arc::new).map_err(|fault| {
                    let help =
                        "have the tool that wrote it write it again, or remove what is beside the standard";
                    let found = Diagnostic::error(codes::DBC_FILE, fault.message);
                    vec![found.at(file.name.clone(), fault.at, "").help(help)]
                }),
                // Nobody may use it: what is wrong then is said where somebody does.
                Err(why) => Err(vec![Diagnostic::error(codes::DBC_FILE, why)]),
            };
            databases.0.insert(name, read);
        }
        databases
    }

    /// The DBC file of this name. `None`: no text of the plan is one.
    pub(crate) fn get(&self, name: &str) -> Option<&Result<Arc<DbcDatabase>, Vec<Diagnostic>>> {
        self.0.get(name)
    }
}

/// The texts that may name a DBC file.
fn find(node: &Node, names: &mut BTreeSet<String>) {
    match &node.data {
        Data::Text(text) if text.to_ascii_lowercase().ends_with(ENDING) => {
            names.insert(text.clone());
        }
        Data::Array(list) => list.iter().for_each(|node| find(node, names)),
        Data::Table(table) => table.entries.iter().for_each(|entry| find(&entry.node, names)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use signal::Value;

    const TEXT: &str = r#"VERSION ""

NS_ :

BS_:

BU_: PLC DRIVE

BO_ 256 Engine: 8 DRIVE
 SG_ Speed : 0|16@1+ (0.25,0) [0|8000] "rpm" PLC
 SG_ Temp : 23|8@0- (1,-40) [-40|215] "degC" PLC
 SG_ Gear : 24|3@1+ (1,0) [0|7] "" PLC

BO_ 2566844926 Mode: 8 PLC
 SG_ Page M : 0|8@1+ (1,0) [0|255] "" DRIVE
 SG_ First m1 : 8|16@1+ (1,0) [0|0] "" DRIVE
 SG_ Second m2 : 8|16@1+ (0.1,0) [0|0] "" DRIVE

VAL_ 256 Gear 0 "Neutral" 1 "First" ;
"#;

    #[test]
    fn messages_are_read_with_their_signals() {
        let base = DbcDatabase::parse(TEXT).unwrap();
        let engine = &base.messages["Engine"];
        assert_eq!((engine.id, engine.extended, engine.size), (256, false, 8));
        let data = [0x10, 0x27, 90, 1, 0, 0, 0, 0];
        assert_eq!(engine.field("Speed").unwrap().coding.value(&data), Value::Real(2500.0));
        assert_eq!(engine.field("Temp").unwrap().coding.value(&data), Value::Real(50.0));
        assert_eq!(engine.field("Gear").unwrap().labels[1], (1, String::from("First")));
        assert_eq!(engine.field("Speed").unwrap().unit, "rpm");
    }

    #[test]
    fn a_multiplexed_signal_is_there_where_it_is_selected() {
        let base = DbcDatabase::parse(TEXT).unwrap();
        let mode = &base.messages["Mode"];
        assert_eq!((mode.id, mode.extended), (0x18FE_F1FE, true));
        let second = mode.field("Second").unwrap();
        assert_eq!(second.selected_by.as_deref(), Some("Page"));
        let selector = second.selector.as_ref().unwrap();
        assert!(selector.selects(&[2, 0, 0]) && !selector.selects(&[1, 0, 0]) && !selector.selects(&[]));
    }

    #[test]
    fn what_is_no_dbc_has_its_place() {
        let fault = DbcDatabase::parse("VERSION \"\"\n\nBO_ nonsense\n").unwrap_err();
        assert!(fault.message.starts_with("line 3 "), "{fault}");
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "\\PC{0,200}", at in 0usize..TEXT.len(), len in 0usize..40, with in "[ -~\\n]{0,10}") {
            let _ = DbcDatabase::parse(&text);
            let end = (at + len).min(TEXT.len());
            let _ = DbcDatabase::parse(&format!("{}{with}{}", &TEXT[..at], &TEXT[end..]));
        }
    }
}
