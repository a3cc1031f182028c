//! The application bundle: what a download transfers and what the boot application file holds.
//!
//! A bundle is the user's sources with the POUs of each task, framed by lengths and closed by a checksum, so
//! that a torn or foreign file is known as an invalid boot application (controller:TR-04).

use document::SourceFile;

const MAGIC: &[u8; 8] = b"SRAPP\0\0\x01";
/// The number of programs of a task that runs none; 0 is that of one that runs what no other task names.
const NO_PROGRAMS: u32 = u32::MAX;
/// Sources and names longer than this are no bundle of ours.
const LARGEST: u32 = 64 << 20;

/// The PROGRAMs that a task runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TaskPrograms {
    /// The name of the task.
    pub task: String,
    /// The PROGRAMs in order; `None` for every one that no other task names.
    pub programs: Option<Vec<String>>,
}

impl TaskPrograms {
    /// The names in the list.
    pub fn named(&self) -> &[String] {
        self.programs.as_deref().unwrap_or_default()
    }
}

/// The sources of an application and the POUs that each of its tasks runs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Bundle {
    /// Structured Text files in the user's order.
    pub sources: Vec<SourceFile>,
    /// What each task runs, in the controller's order of tasks.
    pub tasks: Vec<TaskPrograms>,
}

/// Why bytes are no bundle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BundleError {
    /// Not written by this version of the rig.
    Foreign,
    /// Cut off or damaged: the checksum does not fit.
    Damaged,
}

impl std::fmt::Display for BundleError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            BundleError::Foreign => "no application bundle of this rig",
            BundleError::Damaged => "the application bundle is cut off or damaged",
        })
    }
}

impl std::error::Error for BundleError {}

impl Bundle {
    /// The bundle as bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = MAGIC.to_vec();
        put_count(&mut out, self.sources.len());
        for source in &self.sources {
            put_text(&mut out, &source.name);
            put_text(&mut out, &source.text);
        }
        put_count(&mut out, self.tasks.len());
        for task in &self.tasks {
            put_text(&mut out, &task.task);
            match &task.programs {
                Some(none) if none.is_empty() => out.extend_from_slice(&NO_PROGRAMS.to_le_bytes()),
                _ => put_count(&mut out, task.named().len()),
            }
            task.named().iter().for_each(|program| put_text(&mut out, program));
        }
        let sum = crc32fast::hash(&out);
        out.extend_from_slice(&sum.to_le_bytes());
        out
    }

    /// Reads a bundle back.
    ///
    /// # Errors
    /// [`BundleError`] for anything that [`Bundle::to_bytes`] did not write.
    pub fn from_bytes(bytes: &[u8]) -> Result<Bundle, BundleError> {
        if !bytes.starts_with(MAGIC) {
            return Err(BundleError::Foreign);
        }
        let (body, sum) = bytes.split_last_chunk::<4>().ok_or(BundleError::Damaged)?;
        if crc32fast::hash(body) != u32::from_le_bytes(*sum) {
            return Err(BundleError::Damaged);
        }
        let mut rest = &body[MAGIC.len()..];
        let mut bundle = Bundle::default();
        for _ in 0..take_count(&mut rest)? {
            let name = take_text(&mut rest)?;
            let text = take_text(&mut rest)?;
            bundle.sources.push(SourceFile { name, text });
        }
        for _ in 0..take_count(&mut rest)? {
            let task = take_text(&mut rest)?;
            let programs = take_programs(&mut rest)?;
            bundle.tasks.push(TaskPrograms { task, programs });
        }
        if rest.is_empty() { Ok(bundle) } else { Err(BundleError::Damaged) }
    }
}

fn put_count(out: &mut Vec<u8>, count: usize) {
    out.extend_from_slice(&u32::try_from(count).unwrap_or(u32::MAX).to_le_bytes());
}

fn put_text(out: &mut Vec<u8>, text: &str) {
    put_count(out, text.len());
    out.extend_from_slice(text.as_bytes());
}

fn take_count(rest: &mut &[u8]) -> Result<u32, BundleError> {
    let (count, after) = rest.split_first_chunk::<4>().ok_or(BundleError::Damaged)?;
    *rest = after;
    let count = u32::from_le_bytes(*count);
    if count > LARGEST { Err(BundleError::Damaged) } else { Ok(count) }
}

fn take_programs(rest: &mut &[u8]) -> Result<Option<Vec<String>>, BundleError> {
    if let Some(after) = rest.strip_prefix(&NO_PROGRAMS.to_le_bytes()) {
        *rest = after;
        return Ok(Some(Vec::new()));
    }
    let count = take_count(rest)?;
    let programs: Result<Vec<String>, BundleError> = (0..count).map(|_| take_text(rest)).collect();
    programs.map(|programs| (count > 0).then_some(programs))
}

fn take_text(rest: &mut &[u8]) -> Result<String, BundleError> {
    let length = take_count(rest)? as usize;
    let (text, after) = rest.split_at_checked(length).ok_or(BundleError::Damaged)?;
    *rest = after;
    String::from_utf8(text.to_vec()).map_err(|_| BundleError::Damaged)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn example() -> Bundle {
        Bundle {
            sources: vec![SourceFile { name: "lamp.st".into(), text: "PROGRAM MAIN END_PROGRAM".into() }],
            tasks: [("MAST", None), ("FAST", Some(vec!["F".to_owned()])), ("IDLE", Some(Vec::new()))]
                .map(|(task, programs)| TaskPrograms { task: task.to_owned(), programs })
                .to_vec(),
        }
    }

    #[test]
    fn reads_back() {
        assert_eq!(Bundle::from_bytes(&example().to_bytes()), Ok(example()));
    }

    proptest! {
        #[test]
        fn a_damaged_bundle_is_refused(at in 0usize..80, bit in 0u8..8, cut in 0usize..80) {
            let whole = example().to_bytes();
            let mut flipped = whole.clone();
            let place = at % flipped.len();
            flipped[place] ^= 1 << bit;
            prop_assert!(Bundle::from_bytes(&flipped).is_err());
            prop_assert!(Bundle::from_bytes(&whole[..cut % whole.len()]).is_err());
        }

        #[test]
        fn no_bytes_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let _ = Bundle::from_bytes(&bytes);
            let mut framed = MAGIC.to_vec();
            framed.extend_from_slice(&bytes);
            framed.extend_from_slice(&crc32fast::hash(&framed).to_le_bytes());
            let _ = Bundle::from_bytes(&framed);
        }
    }
}
