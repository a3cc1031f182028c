//! The remanent context: two alternating images, each with a number and a checksum (controller:REM-07).

use crate::{Application, Memory, NonVolatile, RETAIN_FILES, RETAIN_MAP};
use profile::{NON_VOLATILE_SAVE, REMANENT_WORDS};
use signal::Time;

const MAGIC: &[u8; 8] = b"SRCTX\0\0\x02";
const WORDS: usize = REMANENT_WORDS as usize * 2;
/// Magic, sequence, signature, boot application, declarations, length of the variables.
const HEADER: usize = 8 + 8 + 8 + 8 + 8 + 4;

/// An image that is whole.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Saved {
    pub sequence: u64,
    /// Of the application that saved it.
    pub signature: u64,
    /// The boot application then: another one where an online change was not written to it.
    pub parent: u64,
    /// The declarations of the application that was loaded last (controller:REM-02 note 1).
    pub declarations: u64,
    /// %MW0...%MW999.
    pub words: Vec<u8>,
    /// The application's own image.
    pub variables: Vec<u8>,
}

/// Takes an image apart; nothing for one that is cut off, torn or foreign.
pub(crate) fn decode(bytes: &[u8]) -> Option<Saved> {
    let (body, sum) = bytes.split_last_chunk::<4>()?;
    if !body.starts_with(MAGIC) || crc32fast::hash(body) != u32::from_le_bytes(*sum) {
        return None;
    }
    let number = |at: usize| body.get(at..at + 8)?.try_into().ok().map(u64::from_le_bytes);
    let [sequence, signature, parent, declarations] = [number(8)?, number(16)?, number(24)?, number(32)?];
    let length = u32::from_le_bytes(body.get(40..HEADER)?.try_into().ok()?) as usize;
    let data = body.get(HEADER..)?;
    if data.len() != WORDS.checked_add(length)? {
        return None;
    }
    let (words, variables) = data.split_at(WORDS);
    let (words, variables) = (words.to_vec(), variables.to_vec());
    Some(Saved { sequence, signature, parent, declarations, words, variables })
}

/// Saves the context beside the scan.
#[derive(Clone, Debug, Default)]
pub(crate) struct RemanentContext {
    image: Vec<u8>,
    /// Number of the next image.
    sequence: u64,
    /// Which file it goes to.
    slot: usize,
    /// Start and end of the save under way.
    saving: Option<(Time, Time)>,
    /// A change is not yet in an image.
    pub dirty: bool,
    /// The application in memory, the boot application, the declarations that were loaded last.
    signature: u64,
    parent: u64,
    declarations: u64,
}

impl RemanentContext {
    /// The newest whole image; later saves go to the other file.
    pub(crate) fn newest(&mut self, store: &dyn NonVolatile) -> Option<Saved> {
        let images = RETAIN_FILES.map(|name| store.read(name).and_then(|bytes| decode(&bytes)));
        let [first, second] = images;
        let (slot, newest) = match (first, second) {
            (Some(first), Some(second)) if first.sequence > second.sequence => (1, Some(first)),
            (_, Some(second)) => (0, Some(second)),
            (Some(first), None) => (1, Some(first)),
            (None, None) => (0, None),
        };
        self.slot = slot;
        self.sequence = newest.as_ref().map_or(1, |saved| saved.sequence.wrapping_add(1));
        newest
    }

    /// Makes room for the images of an application that was loaded, so that a save allocates nothing. `boot` says
    /// whether it is the boot application, too.
    pub(crate) fn prepare(&mut self, application: &dyn Application, boot: bool, store: &mut dyn NonVolatile) {
        self.declarations = application.declarations();
        self.parent = if boot { application.signature() } else { 0 };
        self.prepare_change(application, store);
    }

    /// The same for an application that took over by online change: for the boot application and the declarations
    /// of the images it remains the one before.
    pub(crate) fn prepare_change(&mut self, application: &dyn Application, store: &mut dyn NonVolatile) {
        self.signature = application.signature();
        store.write(RETAIN_MAP, &application.retained_map());
        self.saving = None;
        self.dirty = false;
        self.image.clear();
        self.image.resize(HEADER + WORDS + application.retained_len() + 4, 0);
    }

    /// The application in memory has become the boot application.
    pub(crate) fn adopt_parent(&mut self) {
        self.parent = self.signature;
        self.dirty = true;
    }

    /// Takes the image of this instant.
    fn capture(&mut self, application: &dyn Application, memory: &Memory) {
        let end = self.image.len() - 4;
        let length = end - HEADER - WORDS;
        self.image[..8].copy_from_slice(MAGIC);
        self.image[8..16].copy_from_slice(&self.sequence.to_le_bytes());
        self.image[16..24].copy_from_slice(&self.signature.to_le_bytes());
        self.image[24..32].copy_from_slice(&self.parent.to_le_bytes());
        self.image[32..40].copy_from_slice(&self.declarations.to_le_bytes());
        self.image[40..HEADER].copy_from_slice(&(length as u32).to_le_bytes());
        self.image[HEADER..HEADER + WORDS].copy_from_slice(memory.remanent());
        application.save_retained(&mut self.image[HEADER + WORDS..end]);
        let sum = crc32fast::hash(&self.image[..end]);
        self.image[end..].copy_from_slice(&sum.to_le_bytes());
        self.dirty = false;
    }

    /// Starts a save at `now` of what is dirty, unless one is under way.
    #[inline]
    pub(crate) fn start(&mut self, now: Time, application: &dyn Application, memory: &Memory) {
        if self.dirty && self.saving.is_none() {
            self.capture(application, memory);
            self.saving = Some((now, now.saturating_add(NON_VOLATILE_SAVE)));
        }
    }

    /// Saves at once: part of a download, which takes no modelled time.
    pub(crate) fn save_now(
        &mut self,
        application: &dyn Application,
        memory: &Memory,
        store: &mut dyn NonVolatile,
    ) {
        self.saving = None;
        self.capture(application, memory);
        self.write(store);
    }

    fn write(&mut self, store: &mut dyn NonVolatile) {
        store.write(RETAIN_FILES[self.slot], &self.image);
        self.slot ^= 1;
        self.sequence = self.sequence.wrapping_add(1);
    }

    /// When the save under way is complete; [`Time::MAX`] for none.
    #[inline]
    pub(crate) fn next(&self) -> Time {
        self.saving.map_or(Time::MAX, |(_, end)| end)
    }

    /// Completes the save that is due at `now`; whether there was one.
    pub(crate) fn fire(&mut self, now: Time, store: &mut dyn NonVolatile) -> bool {
        let due = self.next() <= now;
        if due {
            self.saving = None;
            self.write(store);
        }
        due
    }

    /// Completes a save under way before its time: an orderly end waits for it.
    pub(crate) fn complete(&mut self, store: &mut dyn NonVolatile) {
        if self.saving.take().is_some() {
            self.write(store);
        }
    }

    /// The power goes at `now`: a save under way stops where it is.
    pub(crate) fn tear(&mut self, now: Time, store: &mut dyn NonVolatile) {
        if let Some((start, end)) = self.saving.take() {
            let (passed, whole) =
                (i128::from((now - start).as_nanos()), i128::from((end - start).as_nanos()));
            let kept = self.image.len() as i128 * passed / whole.max(1);
            store.tear(RETAIN_FILES[self.slot], &self.image, usize::try_from(kept).unwrap_or(0));
        }
        self.dirty = false;
    }

    /// Gives up a save under way: its application is gone.
    pub(crate) fn abandon(&mut self) {
        self.saving = None;
        self.dirty = false;
    }
}
