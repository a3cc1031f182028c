//! What frames mean by a DBC file, for the dashboard.

use control::{FrameSeen, RequestFault, Value};
use dash::frame_decoder::{DecodedFrame, FrameDecoder};
use plans::frames::can::{DbcDatabase, FieldSpec, MessageSpec};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// A description of frames cannot be read.
const NOT_READ: &str = "R0683";

/// The most bytes of a DBC file that are looked at.
const MOST: u64 = 4 << 20;

/// The messages of a DBC file by their identifiers; TRUE for those with 29 bits.
#[derive(Debug)]
struct Messages(BTreeMap<(bool, u32), Arc<MessageSpec>>);

/// Reads a DBC file.
///
/// # Errors
/// A file that cannot be read, or is none.
pub fn read(path: &str) -> Result<Box<dyn FrameDecoder>, RequestFault> {
    let failed = |what: &dyn std::fmt::Display| RequestFault {
        code: NOT_READ.to_owned(),
        message: format!("`{path}` cannot be read: {what}"),
        help: "name a DBC file".to_owned(),
    };
    let bytes = document::file::read(Path::new(path), MOST).map_err(|fault| failed(&fault))?;
    // Comments of older files are in other encodings; names are not.
    let text = String::from_utf8_lossy(&bytes);
    let database = DbcDatabase::parse(&text).map_err(|fault| failed(&fault))?;
    let messages = database.messages.into_values();
    Ok(Box::new(Messages(messages.map(|message| ((message.extended, message.id), message)).collect())))
}

impl FrameDecoder for Messages {
    fn decode(&self, frame: &FrameSeen) -> Option<DecodedFrame> {
        let id = u32::from_str_radix(&frame.id, 16).ok()?;
        // A short identifier is written with three digits.
        let message = self.0.get(&(frame.id.len() > 3, id))?;
        let data = bytes(&frame.data)?;
        let selected =
            |field: &&FieldSpec| field.selector.as_ref().is_none_or(|selector| selector.selects(&data));
        let fields = message.fields.iter().filter(selected);
        let fields = fields.map(|field| (field.name.clone(), value_of(field, &data)));
        Some(DecodedFrame { name: message.name.clone(), fields: fields.collect() })
    }
}

/// Bytes in hexadecimal.
fn bytes(data: &str) -> Option<Vec<u8>> {
    let digits: Option<Vec<u8>> =
        data.chars().map(|c| c.to_digit(16).and_then(|d| u8::try_from(d).ok())).collect();
    Some(digits?.chunks_exact(2).map(|pair| pair[0] << 4 | pair[1]).collect())
}

fn value_of(field: &FieldSpec, data: &[u8]) -> String {
    let raw = field.coding.number(data);
    if let Some((_, label)) = field.labels.iter().find(|(number, _)| raw == Some(i128::from(*number))) {
        return label.clone();
    }
    match field.coding.value(data) {
        // Shorter than the description says.
        Value::Unknown => "?".to_owned(),
        value if field.unit.is_empty() => value.to_string(),
        value => format!("{value} {}", field.unit),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DBC: &str = r#"VERSION ""
NS_ :
BS_:
BU_: drive
BO_ 399 Drive: 4 drive
 SG_ Mode : 0|2@1+ (1,0) [0|3] "" drive
 SG_ Speed : 8|16@1- (0.5,0) [0|0] "1/min" drive
BO_ 2566869221 Far: 1 drive
 SG_ Level : 0|8@1+ (1,0) [0|255] "" drive
VAL_ 399 Mode 0 "off" 1 "on" ;
"#;

    fn decode(id: &str, data: &str) -> Option<DecodedFrame> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("drive.dbc");
        std::fs::write(&path, DBC).unwrap();
        let decoder = read(&path.display().to_string()).unwrap();
        let (bus, id, data) = ("drive".to_owned(), id.to_owned(), data.to_owned());
        decoder.decode(&FrameSeen { bus, at: 0, sent: false, id, flags: Vec::new(), data })
    }

    #[test]
    fn frames_say_what_the_file_describes() {
        let drive = decode("18F", "01F6FF00").unwrap();
        let fields: Vec<(&str, &str)> = drive.fields.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
        assert_eq!((drive.name.as_str(), fields), ("Drive", vec![("Mode", "on"), ("Speed", "-5 1/min")]));
        assert_eq!(decode("18FF50E5", "2A").unwrap().fields, [("Level".to_owned(), "42".to_owned())]);
        // A frame that is too short says as much as it has.
        assert_eq!(decode("18F", "02").unwrap().fields[1].1, "?");
        for (id, data) in [("18E", "00"), ("0000018F", "00"), ("", "00"), ("18F", "0G")] {
            assert_eq!(decode(id, data), None, "{id} {data}");
        }
    }

    #[test]
    fn what_is_no_description_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("drive.dbc").display().to_string();
        assert_eq!(read(&path).unwrap_err().code, "R0683");
        std::fs::write(&path, "BO_ nothing").unwrap();
        assert_eq!(read(&path).unwrap_err().code, "R0683");
    }
}
