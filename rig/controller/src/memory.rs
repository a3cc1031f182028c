//! The memory that application and controller share: the images of inputs and outputs, and %M.

use profile::{ChannelSet, Profile, REMANENT_WORDS};
use signal::{Address, Area, Cause, Image, Size, Value};

/// %I, %Q and %M (controller:MEM-06, controller:ADDR-01), with the last writer of every output bit.
#[derive(Clone, Debug)]
pub struct Memory {
    inputs: Image,
    outputs: Image,
    words: Image,
    /// A 1 for every bit whose change ends a slice.
    watched: [Image; 3],
    any_watched: bool,
    /// Last writer of each bit of %Q.
    writers: Box<[Cause]>,
    cause: Cause,
    remanent_dirty: bool,
}

impl Memory {
    /// Memory of zeros with the areas of a profile.
    pub fn new(profile: Profile) -> Memory {
        let limits = profile.address_limits();
        let image = |area| Image::new(limits.bits(area));
        let images = [image(Area::Input), image(Area::Output), image(Area::Memory)];
        let [inputs, outputs, words] = images.clone();
        Memory {
            inputs,
            outputs,
            words,
            watched: images,
            any_watched: false,
            writers: vec![Cause::Unknown; limits.bits(Area::Output) as usize].into_boxed_slice(),
            cause: Cause::Unknown,
            remanent_dirty: false,
        }
    }

    /// Who makes the following stores.
    #[inline]
    pub fn set_cause(&mut self, cause: Cause) {
        self.cause = cause;
    }

    /// Who made the last stores.
    pub(crate) fn cause(&self) -> Cause {
        self.cause
    }

    /// The value at an address in the low bits; 0 beyond the end of its area.
    #[inline]
    pub fn load(&self, at: Address) -> u64 {
        match at.area() {
            Area::Input => self.inputs.get(at),
            Area::Output => self.outputs.get(at),
            Area::Memory => self.words.get(at),
        }
    }

    /// What is at an address: a Boolean for a bit, else a bit string.
    pub(crate) fn value(&self, at: Address) -> Value {
        let value = self.load(at);
        if at.size() == Size::Bit { Value::Bool(value != 0) } else { Value::Word(value) }
    }

    /// Stores the low bits of `value`; TRUE when a watched place changed. Beyond the end of its area nothing happens.
    #[inline]
    pub fn store(&mut self, at: Address, value: u64) -> bool {
        let changed = match at.area() {
            Area::Input => self.inputs.set(at, value),
            Area::Output => {
                let first = at.bit_offset() as usize;
                if at.size() == Size::Bit {
                    if let Some(writer) = self.writers.get_mut(first) {
                        *writer = self.cause;
                    }
                } else if let Some(writers) = self.writers.get_mut(first..first + at.bit_len() as usize) {
                    writers.fill(self.cause);
                }
                self.outputs.set(at, value)
            }
            Area::Memory => {
                let changed = self.words.set(at, value);
                self.remanent_dirty |= changed && at.bit_offset() < REMANENT_WORDS * 16;
                changed
            }
        };
        changed && self.any_watched && self.watched[at.area() as usize].get(at) != 0
    }

    /// From now on, a store that changes this place reports it.
    pub(crate) fn watch(&mut self, at: Address) {
        self.any_watched = true;
        self.watched[at.area() as usize].set(at, u64::MAX);
    }

    /// Ends [`Memory::watch`], also of other places that it covers.
    pub(crate) fn unwatch(&mut self, at: Address) {
        self.watched[at.area() as usize].set(at, 0);
    }

    /// Who wrote a bit of %Q last; unknown for a bit that nobody wrote since the memory was cleared.
    pub(crate) fn writer(&self, output_bit: usize) -> Cause {
        self.writers.get(output_bit).copied().unwrap_or_default()
    }

    /// Sets every bit to 0 and forgets who wrote it. Watched places stay watched.
    pub(crate) fn clear(&mut self) {
        self.inputs.clear();
        self.words.clear();
        self.clear_outputs();
        self.cause = Cause::Unknown;
        self.remanent_dirty = false;
    }

    /// Sets every output bit to 0 and forgets who wrote it.
    pub(crate) fn clear_outputs(&mut self) {
        self.outputs.clear();
        self.writers.fill(Cause::Unknown);
    }

    /// Sets %I to 0, and %M except the words that `keep` keeps.
    pub(crate) fn reset(&mut self, keep: impl Fn(u32) -> bool) {
        self.inputs.clear();
        self.clear_outputs();
        let remanent = REMANENT_WORDS as usize * 2;
        self.words.bytes_mut()[remanent..].fill(0);
        for word in (0..REMANENT_WORDS).filter(|word| !keep(*word)) {
            self.words.bytes_mut()[word as usize * 2..][..2].fill(0);
        }
        self.remanent_dirty = true;
    }

    /// Sets the bits in %I of the embedded inputs `which`, to 1 those of `on`; whether any changed.
    #[inline]
    pub(crate) fn set_inputs(&mut self, on: ChannelSet, which: ChannelSet) -> bool {
        !set_channels(&mut self.inputs, on, which).is_empty()
    }

    /// Sets a place of %I; whether it changed.
    #[inline]
    pub(crate) fn set_input(&mut self, at: Address, value: u64) -> bool {
        self.inputs.set(at, value)
    }

    /// Sets these bits of a word of 64 of %I; whether any changed.
    #[inline]
    pub(crate) fn set_input_bits(&mut self, at: usize, mask: u64, bits: u64) -> bool {
        self.inputs.set_bits(at, mask, bits)
    }

    /// Sets these bits of a word of 64 of %Q to 0; whether any changed.
    pub(crate) fn clear_output_bits(&mut self, at: usize, mask: u64) -> bool {
        self.outputs.set_bits(at, mask, 0)
    }

    /// A word of 64 bits of %Q.
    #[inline]
    pub(crate) fn output_word(&self, at: usize) -> u64 {
        self.outputs.word(at)
    }

    /// The embedded outputs whose bits in %Q are 1.
    #[inline]
    pub(crate) fn outputs(&self) -> ChannelSet {
        self.outputs.bytes().first_chunk().map_or(ChannelSet::EMPTY, |word| ChannelSet::from_image(*word))
    }

    /// Sets the bits in %Q of the embedded outputs `which`, to 1 those of `on`; whether any changed. Changed ones have the
    /// writer `cause`.
    #[inline]
    pub(crate) fn set_outputs(&mut self, on: ChannelSet, which: ChannelSet, cause: Cause) -> bool {
        let changed = set_channels(&mut self.outputs, on, which);
        for output in changed {
            self.writers[output] = cause;
        }
        !changed.is_empty()
    }

    /// The embedded outputs whose bits in %Q somebody wrote since they were cleared.
    pub(crate) fn written_outputs(&self) -> ChannelSet {
        let written = |output: &usize| self.writer(*output) != Cause::Unknown;
        (0..ChannelSet::CAPACITY).filter(written).collect()
    }

    /// The bytes of %MW0...%MW999.
    pub(crate) fn remanent(&self) -> &[u8] {
        &self.words.bytes()[..REMANENT_WORDS as usize * 2]
    }

    /// The bytes of %MW0...%MW999, to be filled from a saved context.
    pub(crate) fn remanent_mut(&mut self) -> &mut [u8] {
        &mut self.words.bytes_mut()[..REMANENT_WORDS as usize * 2]
    }

    /// Whether a remanent word changed since the last call.
    #[inline]
    pub(crate) fn take_remanent_dirty(&mut self) -> bool {
        std::mem::take(&mut self.remanent_dirty)
    }
}

/// Sets the bits of embedded channels; which of them changed.
#[inline]
fn set_channels(image: &mut Image, on: ChannelSet, which: ChannelSet) -> ChannelSet {
    let Some(word) = image.bytes_mut().first_chunk_mut() else { return ChannelSet::EMPTY };
    let old = ChannelSet::from_image(*word);
    let new = old.updated(which, on);
    *word = new.to_image();
    old ^ new
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(text: &str) -> Address {
        Address::parse(text).unwrap()
    }

    #[test]
    fn only_watched_changes_are_reported() {
        let mut memory = Memory::new(Profile::default());
        memory.watch(at("%MW10"));
        assert!(!memory.store(at("%MW9"), 1));
        assert!(memory.store(at("%MX20.3"), 1), "a bit of the word");
        assert!(!memory.store(at("%MX20.3"), 1), "no change");
        assert!(memory.store(at("%MD5"), 0), "overlaps the word (controller:ADDR-01)");
    }

    #[test]
    fn output_bits_know_their_writer() {
        let mut memory = Memory::new(Profile::default());
        let program = Cause::Program { task: 0, file: 1, line: 7 };
        memory.set_cause(program);
        memory.store(at("%QX0.4"), 1);
        assert_eq!((memory.writer(4), memory.writer(5)), (program, Cause::Unknown));
        assert_eq!((memory.outputs(), memory.written_outputs()), (ChannelSet::of(4), ChannelSet::of(4)));
        memory.set_outputs(ChannelSet::EMPTY, ChannelSet::first(8), Cause::Controller);
        assert_eq!(memory.writer(4), Cause::Controller);
        assert_eq!(memory.writer(5), Cause::Unknown, "it did not change");
    }

    // controller:REM-03
    #[test]
    fn remanent_words_end_at_999() {
        let mut memory = Memory::new(Profile::default());
        memory.store(at("%MW1000"), 5);
        assert!(!memory.take_remanent_dirty());
        memory.store(at("%MW999"), 5);
        memory.store(at("%MW3"), 6);
        assert!(memory.take_remanent_dirty());
        memory.reset(|word| word != 3);
        assert_eq!(["%MW3", "%MW999", "%MW1000"].map(|text| memory.load(at(text))), [0, 5, 0]);
    }
}
