//! Names by number: each is stored once, in capitals, and compared as a number from then on.

use super::ast::Key;
use super::words::Word;

/// The names of a compilation. The words of the language come first, so that a key shows whether it is one.
#[derive(Debug)]
pub(crate) struct NameTable {
    /// The capitals of all names, one after the other.
    text: String,
    /// Where each ends in `text`.
    ends: Vec<u32>,
    /// Open addressing: keys + 1, 0 where free. The length is a power of two and at least twice that of `ends`.
    slots: Vec<u32>,
}

impl NameTable {
    pub fn new() -> NameTable {
        let mut names = NameTable { text: String::new(), ends: Vec::new(), slots: vec![0; 1024] };
        for (_, text) in Word::ALL {
            names.intern(text);
        }
        names
    }

    /// The key of a name, in whatever letters.
    pub fn intern(&mut self, name: &str) -> Key {
        let slot = self.slot(name);
        if let Some(key) = self.slots.get(slot).and_then(|held| held.checked_sub(1)) {
            return Key(key);
        }
        let key = self.ends.len() as u32;
        self.text.extend(name.chars().map(|c| c.to_ascii_uppercase()));
        self.ends.push(self.text.len() as u32);
        if let Some(slot) = self.slots.get_mut(slot) {
            *slot = key + 1;
        }
        if self.ends.len() * 2 > self.slots.len() {
            self.grow();
        }
        Key(key)
    }

    /// The key of a name in capitals, where the sources have it.
    pub fn get(&self, capitals: &str) -> Option<Key> {
        self.slots.get(self.slot(capitals)).and_then(|held| held.checked_sub(1)).map(Key)
    }

    /// The name in capitals.
    pub fn key_text(&self, key: Key) -> &str {
        let place = key.0 as usize;
        let end = self.ends.get(place).copied().unwrap_or(0);
        let start = place.checked_sub(1).and_then(|before| self.ends.get(before)).copied().unwrap_or(0);
        self.text.get(start as usize..end as usize).unwrap_or("")
    }

    /// The slot that holds a name, or the free one where it belongs. There always is a free one.
    fn slot(&self, name: &str) -> usize {
        let mask = self.slots.len() - 1;
        let mut slot = hash(name) as usize & mask;
        while let Some(key) = self.slots.get(slot).and_then(|held| held.checked_sub(1)) {
            if self.key_text(Key(key)).eq_ignore_ascii_case(name) {
                break;
            }
            slot = (slot + 1) & mask;
        }
        slot
    }

    fn grow(&mut self) {
        self.slots = vec![0; self.slots.len() * 4];
        for key in 0..self.ends.len() as u32 {
            let slot = self.slot(self.key_text(Key(key)));
            if let Some(slot) = self.slots.get_mut(slot) {
                *slot = key + 1;
            }
        }
    }
}

/// FNV-1a over the capitals, its high bits folded in because the slots use the low ones.
fn hash(name: &str) -> u64 {
    let hash = name.bytes().fold(0xcbf2_9ce4_8422_2325u64, |hash, byte| {
        (hash ^ u64::from(byte.to_ascii_uppercase())).wrapping_mul(0x100_0000_01b3)
    });
    hash ^ hash >> 32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_kept_without_case() {
        let mut names = NameTable::new();
        let keys: Vec<Key> = (0..5000).map(|n| names.intern(&format!("Name_{n}"))).collect();
        for (n, key) in keys.iter().enumerate() {
            assert_eq!(names.intern(&format!("nAME_{n}")), *key);
            assert_eq!(names.key_text(*key), format!("NAME_{n}"));
            assert_eq!(names.get(&format!("NAME_{n}")), Some(*key));
        }
        assert_eq!(names.get("OTHER"), None);
        assert_eq!(names.intern("end_If"), Word::EndIf.key());
        assert_eq!(names.key_text(Key(u32::MAX)), "");
    }
}
