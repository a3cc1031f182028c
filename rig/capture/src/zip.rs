//! Archives as sigrok writes them: files stored or deflated, one after another, with a directory at the end.

use crate::CaptureError;
use miniz_oxide::inflate::decompress_to_vec_with_limit;

/// The most files of an archive.
pub const MAX_FILES: usize = 65_535;

/// The most bytes of one file of an archive.
pub const MAX_ENTRY: usize = 64 << 20;

/// What to do about an archive that is damaged.
const AGAIN: &str = "save it again: a part is missing or damaged";

/// A file of an archive, where it stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ZipEntry {
    /// Its name.
    pub name: String,
    method: u16,
    crc: u32,
    packed: usize,
    size: usize,
    header: usize,
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    let found = bytes.get(at..at.checked_add(2)?)?;
    Some(u16::from_le_bytes([found[0], found[1]]))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<usize> {
    let found = bytes.get(at..at.checked_add(4)?)?;
    usize::try_from(u32::from_le_bytes([found[0], found[1], found[2], found[3]])).ok()
}

/// The files of an archive, in the order of its directory.
///
/// # Errors
/// [`CaptureError`]: no archive, a damaged one, or one with more than is read here.
pub fn entries(bytes: &[u8]) -> Result<Vec<ZipEntry>, CaptureError> {
    let damaged = || CaptureError::whole("no whole archive", AGAIN);
    // The end of the directory stands before a comment of at most 65535 bytes.
    let least = bytes.len().saturating_sub(22 + 65_535);
    let end =
        (least..=bytes.len().saturating_sub(22)).rev().find(|at| bytes[*at..].starts_with(b"PK\x05\x06"));
    let end = end.ok_or_else(damaged)?;
    let count = usize::from(u16_at(bytes, end + 10).ok_or_else(damaged)?);
    let mut at = u32_at(bytes, end + 16).ok_or_else(damaged)?;
    let mut found = Vec::new();
    for _ in 0..count.min(MAX_FILES) {
        let (entry, next) = entry(bytes, at).ok_or_else(damaged)?;
        found.push(entry);
        at = next;
    }
    Ok(found)
}

/// The entry of the directory at this byte, and where the next one stands.
fn entry(bytes: &[u8], at: usize) -> Option<(ZipEntry, usize)> {
    let head = bytes.get(at..)?;
    if !head.starts_with(b"PK\x01\x02") {
        return None;
    }
    let lengths = [u16_at(head, 28)?, u16_at(head, 30)?, u16_at(head, 32)?].map(usize::from);
    let name = head.get(46..46 + lengths[0])?;
    let entry = ZipEntry {
        name: String::from_utf8_lossy(name).into_owned(),
        method: u16_at(head, 10)?,
        crc: u32::try_from(u32_at(head, 16)?).ok()?,
        packed: u32_at(head, 20)?,
        size: u32_at(head, 24)?,
        header: u32_at(head, 42)?,
    };
    Some((entry, at + 46 + lengths.iter().sum::<usize>()))
}

impl ZipEntry {
    /// Its size when it is unpacked, as the directory says.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Unpacks it.
    ///
    /// # Errors
    /// [`CaptureError`]: it is too large, damaged, or packed in another way.
    pub fn unpack(&self, bytes: &[u8]) -> Result<Vec<u8>, CaptureError> {
        let wrong = |what: String, fix| CaptureError::entry(&self.name, what, fix);
        let damaged = || wrong("it is damaged".to_owned(), AGAIN);
        if self.size > MAX_ENTRY {
            return Err(wrong(format!("it has more than {MAX_ENTRY} bytes"), "capture for a shorter time"));
        }
        let head =
            bytes.get(self.header..).filter(|head| head.starts_with(b"PK\x03\x04")).ok_or_else(damaged)?;
        let lengths = [u16_at(head, 26), u16_at(head, 28)].map(|length| length.map(usize::from));
        let (Some(name), Some(extra)) = (lengths[0], lengths[1]) else { return Err(damaged()) };
        let begin = 30 + name + extra;
        let packed =
            begin.checked_add(self.packed).and_then(|end| head.get(begin..end)).ok_or_else(damaged)?;
        let unpacked = match self.method {
            0 => packed.to_vec(),
            8 => decompress_to_vec_with_limit(packed, self.size).map_err(|_| damaged())?,
            other => {
                return Err(wrong(
                    format!("it is packed by method {other}"),
                    "save it with sigrok or PulseView",
                ));
            }
        };
        if unpacked.len() != self.size || crc32fast::hash(&unpacked) != self.crc {
            return Err(damaged());
        }
        Ok(unpacked)
    }
}
