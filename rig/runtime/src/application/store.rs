//! Non-volatile storage: in memory for virtual time, on disk for a rig that must survive its own power cut.

use controller::NonVolatile;
use document::file::{self, FileFault};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

/// Storage in memory, for virtual time.
#[derive(Clone, Debug, Default)]
pub struct MemoryStore {
    files: BTreeMap<String, Vec<u8>>,
}

impl NonVolatile for MemoryStore {
    fn read(&self, name: &str) -> Option<Vec<u8>> {
        self.files.get(name).cloned()
    }

    fn write(&mut self, name: &str, bytes: &[u8]) {
        // Reuses the file's buffer: a save in every cycle allocates nothing once the image has its size.
        if let Some(file) = self.files.get_mut(name) {
            file.clear();
            file.extend_from_slice(bytes);
        } else {
            self.files.insert(name.to_owned(), bytes.to_vec());
        }
    }

    fn remove(&mut self, name: &str) {
        self.files.remove(name);
    }

    fn list(&self, each: &mut dyn FnMut(&str, u64)) {
        self.files.iter().for_each(|(name, bytes)| each(name, bytes.len() as u64));
    }

    fn tear(&mut self, name: &str, bytes: &[u8], kept: usize) {
        let old = self.files.get(name).map_or(&[][..], Vec::as_slice);
        let torn = torn(old, bytes, kept);
        self.files.insert(name.to_owned(), torn);
    }
}

/// What a medium holds when writing `new` over `old` stopped after `kept` bytes.
fn torn(old: &[u8], new: &[u8], kept: usize) -> Vec<u8> {
    let kept = kept.min(new.len());
    let mut file = new[..kept].to_vec();
    if old.len() > kept {
        file.extend_from_slice(&old[kept..]);
    }
    file
}

/// Most bytes of a file that is read: above what a controller's memory for files has.
const MOST_BYTES: u64 = 1 << 30;

const MAGIC: &[u8; 8] = b"SRNV\0\0\0\x01";
const HEADER: usize = 8 + 8 + 4;

/// A file of a [`DiskStore`] that cannot be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StoreFault {
    /// The file is cut off, damaged or foreign.
    Damaged,
    /// The operating system refused the call.
    Io(std::io::ErrorKind),
}

/// Storage in a directory. Every file is replaced atomically and carries a checksum and the time of its
/// writing, so that a reader knows whether it is whole and how old it is.
#[derive(Debug)]
pub struct DiskStore {
    root: PathBuf,
    fault: Option<StoreFault>,
}

impl DiskStore {
    /// Storage below `root`, which is created.
    ///
    /// # Errors
    /// What the operating system says of creating the directory.
    pub fn open(root: &Path) -> std::io::Result<DiskStore> {
        std::fs::create_dir_all(root)?;
        Ok(DiskStore { root: root.to_owned(), fault: None })
    }

    /// The first fault since the last call: the runtime turns it into the verdict `error`.
    pub fn take_fault(&mut self) -> Option<StoreFault> {
        self.fault.take()
    }

    /// Seconds since 1970-01-01 UTC at which a file was written.
    ///
    /// # Errors
    /// [`StoreFault`] when the file is missing or cannot be trusted.
    pub fn written_at(&self, name: &str) -> Result<u64, StoreFault> {
        self.load(name).map(|(written, _)| written)
    }

    /// Where a name of the controller's file tree (`/usr/App/...`) lives; `..` cannot leave the root.
    fn path(&self, name: &str) -> PathBuf {
        let parts = name.split('/').filter(|part| !part.is_empty() && *part != "." && *part != "..");
        parts.fold(self.root.clone(), |path, part| path.join(part))
    }

    fn load(&self, name: &str) -> Result<(u64, Vec<u8>), StoreFault> {
        let mut bytes = file::read(&self.path(name), MOST_BYTES).map_err(|fault| match fault {
            FileFault::Io(error) => StoreFault::Io(error.kind()),
            FileFault::NotRegular(_) | FileFault::TooLarge { .. } => StoreFault::Damaged,
        })?;
        if bytes.len() < HEADER || !bytes.starts_with(MAGIC) {
            return Err(StoreFault::Damaged);
        }
        let mut written = [0; 8];
        written.copy_from_slice(&bytes[8..16]);
        let mut sum = [0; 4];
        sum.copy_from_slice(&bytes[16..20]);
        if checksum(written, &bytes[HEADER..]) != u32::from_le_bytes(sum) {
            return Err(StoreFault::Damaged);
        }
        bytes.drain(..HEADER);
        Ok((u64::from_le_bytes(written), bytes))
    }

    fn save(&self, name: &str, bytes: &[u8]) -> std::io::Result<()> {
        let path = self.path(name);
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        let written =
            SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs()).to_le_bytes();
        let mut file = atomic_write_file::AtomicWriteFile::open(&path)?;
        file.write_all(MAGIC)?;
        file.write_all(&written)?;
        file.write_all(&checksum(written, bytes).to_le_bytes())?;
        file.write_all(bytes)?;
        file.commit()
    }
}

fn checksum(written: [u8; 8], bytes: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&written);
    hasher.update(bytes);
    hasher.finalize()
}

impl NonVolatile for DiskStore {
    fn read(&self, name: &str) -> Option<Vec<u8>> {
        self.load(name).ok().map(|(_, bytes)| bytes)
    }

    fn write(&mut self, name: &str, bytes: &[u8]) {
        if let Err(error) = self.save(name, bytes) {
            self.fault.get_or_insert(StoreFault::Io(error.kind()));
        }
    }

    fn remove(&mut self, name: &str) {
        if let Err(error) = std::fs::remove_file(self.path(name))
            && error.kind() != std::io::ErrorKind::NotFound
        {
            self.fault.get_or_insert(StoreFault::Io(error.kind()));
        }
    }

    fn list(&self, each: &mut dyn FnMut(&str, u64)) {
        let mut found = Vec::new();
        let mut folders = vec![String::from("/")];
        while let Some(at) = folders.pop() {
            for entry in std::fs::read_dir(self.path(&at)).into_iter().flatten().flatten() {
                let name = format!("{at}{}", entry.file_name().to_string_lossy());
                match entry.metadata() {
                    Ok(data) if data.is_dir() => folders.push(name + "/"),
                    Ok(data) => found.push((name, data.len().saturating_sub(HEADER as u64))),
                    Err(_) => {}
                }
            }
        }
        found.sort();
        found.iter().for_each(|(name, bytes)| each(name, *bytes));
    }

    fn tear(&mut self, name: &str, bytes: &[u8], kept: usize) {
        // The medium under an atomic replacement keeps the old file; what a controller without one would
        // hold is written here as it would be found: without a fitting checksum.
        let old = file::read(&self.path(name), MOST_BYTES).unwrap_or_default();
        let mut new = MAGIC.to_vec();
        new.extend_from_slice(&[0; 12]);
        new.extend_from_slice(bytes);
        if let Err(error) = std::fs::write(self.path(name), torn(&old, &new, HEADER + kept))
            && error.kind() != std::io::ErrorKind::NotFound
        {
            self.fault.get_or_insert(StoreFault::Io(error.kind()));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_on_disk_is_whole_or_known_to_be_damaged() {
        let folder = tempfile::tempdir().unwrap();
        let mut store = DiskStore::open(folder.path()).unwrap();
        store.write("/data/retain.0", b"first context");
        store.write("/data/retain.0", b"second");
        assert_eq!(store.read("/data/retain.0").as_deref(), Some(&b"second"[..]));
        assert!(store.written_at("/data/retain.0").unwrap() > 1_600_000_000);

        let path = folder.path().join("data/retain.0");
        let whole = std::fs::read(&path).unwrap();
        for cut in 0..whole.len() {
            std::fs::write(&path, &whole[..cut]).unwrap();
            assert_eq!(store.read("/data/retain.0"), None, "cut after {cut} bytes");
        }
        for place in 0..whole.len() {
            let mut flipped = whole.clone();
            flipped[place] ^= 0x10;
            std::fs::write(&path, &flipped).unwrap();
            assert_eq!(store.read("/data/retain.0"), None, "bit flipped in byte {place}");
        }
        std::fs::write(&path, &whole).unwrap();
        store.write("/usr/Rcp/a.rcp", b"abc");
        let mut names = Vec::new();
        store.list(&mut |name, bytes| names.push((name.to_owned(), bytes)));
        assert_eq!(names, [("/data/retain.0".to_owned(), 6), ("/usr/Rcp/a.rcp".to_owned(), 3)]);
        assert_eq!(store.take_fault(), None);
    }

    #[test]
    fn files_are_listed_in_order() {
        let disk = tempfile::tempdir().unwrap();
        let stores: [&mut dyn NonVolatile; 2] =
            [&mut MemoryStore::default(), &mut DiskStore::open(disk.path()).unwrap()];
        for store in stores {
            for name in ["/usr/Log/b.log", "/usr/App/Application.app", "/usr/Log/a/c.log"] {
                store.write(name, b"12345");
            }
            let mut seen = Vec::new();
            store.list(&mut |name, bytes| seen.push((name.to_owned(), bytes)));
            let names = ["/usr/App/Application.app", "/usr/Log/a/c.log", "/usr/Log/b.log"];
            assert_eq!(seen, names.map(|name| (name.to_owned(), 5)));
        }
    }

    #[test]
    fn a_name_cannot_leave_the_root() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().join("nv");
        let mut store = DiskStore::open(&root).unwrap();
        store.write("/../../outside", b"x");
        assert!(root.join("outside").exists());
        assert!(!folder.path().join("outside").exists());
    }

    #[test]
    fn torn_writes_mix_old_and_new() {
        let mut store = MemoryStore::default();
        store.write("a", b"old-context");
        store.tear("a", b"NEW-CONTEXT", 4);
        assert_eq!(store.read("a").as_deref(), Some(&b"NEW-context"[..]));
    }
}
