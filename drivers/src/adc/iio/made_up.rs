//! A made-up machine, for tests without devices.

use std::fs;
use std::path::{Path, PathBuf};

/// Its `/sys` and `/dev` go with the test.
#[derive(Debug)]
pub(super) struct Machine(PathBuf);

impl Machine {
    pub(super) fn new(name: &str) -> Machine {
        let root = std::env::temp_dir().join(format!("scanrig-iio-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&root);
        fs::create_dir_all(&root).unwrap();
        Machine(root)
    }

    pub(super) fn root(&self) -> &Path {
        &self.0
    }

    pub(super) fn file(&self, path: &str, text: &str) {
        let path = self.0.join(path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, format!("{text}\n")).unwrap();
    }

    pub(super) fn text(&self, path: &str) -> String {
        fs::read_to_string(self.0.join(path)).unwrap()
    }

    /// A device without inputs; its folder.
    pub(super) fn device(&self, number: u8, name: &str) -> String {
        let folder = format!("sys/bus/iio/devices/iio:device{number}");
        self.file(&format!("{folder}/name"), name);
        folder
    }
}

impl Drop for Machine {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}
