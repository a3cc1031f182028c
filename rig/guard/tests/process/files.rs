//! Lines whose levels stand in a file.

use drivers::{LineApi, OutputClaim};
use scanrig_guard::OutputLines;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::os::unix::fs::FileExt;
use std::path::Path;
use std::time::Duration;

/// The levels that are safe.
pub const SAFE: u64 = 0b0101;
/// All lines of a device.
pub const MASK: u64 = 0b1111;

/// The levels of a device.
pub fn levels(folder: &Path, device: &str) -> u64 {
    let mut bytes = [0; 8];
    File::open(folder.join(device)).unwrap().read_exact_at(&mut bytes, 0).unwrap();
    u64::from_ne_bytes(bytes)
}

/// What the rig writes.
pub fn write(file: &File, levels: u64) -> io::Result<()> {
    file.write_all_at(&levels.to_ne_bytes(), 0)
}

/// A device in its folder, as its board would hand it to the guard. What its name begins with is what is wrong
/// with it: see [`open`].
pub fn held(folder: &Path, device: &str) -> OutputClaim {
    let claim = OpenOptions::new().read(true).write(true).open(folder.join(device)).unwrap().into();
    OutputClaim { device: device.into(), claim, api: LineApi::V2, mask: MASK, safe: SAFE }
}

/// How many allocations the guard had made at each of the drives of a device.
pub fn allocations(folder: &Path, device: &str) -> Vec<u64> {
    let log = std::fs::read(folder.join(device).with_extension("log")).unwrap();
    log.chunks_exact(8).map(|eight| u64::from_ne_bytes(eight.try_into().unwrap())).collect()
}

struct FileLines {
    file: File,
    log: File,
    drives: u32,
    device: String,
}

/// Lines of a file. `slow` ones take a second from the second drive on; `tardy` ones about as long as the guard waits
/// until it drives again; `broken` ones fail; `stubborn` ones read
/// otherwise from the second drive on.
pub fn open(held: OutputClaim) -> Box<dyn OutputLines> {
    let file = File::from(held.claim);
    let here = rustix::fs::readlink(format!("/proc/self/fd/{}", std::os::fd::AsRawFd::as_raw_fd(&file)), []);
    let log = Path::new(here.unwrap().to_str().unwrap()).with_extension("log");
    let log = OpenOptions::new().append(true).create(true).open(log).unwrap();
    Box::new(FileLines { file, log, drives: 0, device: held.device })
}

impl OutputLines for FileLines {
    fn drive(&mut self, levels: u64) -> io::Result<()> {
        self.log.write_all(&counting::of_all_threads().to_ne_bytes())?;
        self.drives += 1;
        if self.device.starts_with("broken") {
            return Err(io::Error::from_raw_os_error(5));
        }
        if self.device.starts_with("slow") && self.drives > 1 {
            std::thread::sleep(Duration::from_secs(1));
        }
        if self.device.starts_with("tardy") {
            std::thread::sleep(Duration::from_millis(2));
        }
        write(&self.file, levels)
    }

    fn read(&mut self) -> io::Result<u64> {
        let mut bytes = [0; 8];
        self.file.read_exact_at(&mut bytes, 0)?;
        let stubborn = self.device.starts_with("stubborn") && self.drives > 1;
        Ok(u64::from_ne_bytes(bytes) ^ u64::from(stubborn))
    }
}
