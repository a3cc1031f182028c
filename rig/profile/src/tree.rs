//! The tree of the non-volatile store (controller:NV-03) and where files are moved to (controller:NV-05).

use crate::{Family, Profile, Reference};

/// Bytes of the disk /usr (rig definition: the documents give the size of the flash as a whole, controller:HW-01).
pub const USER_DISK_BYTES: u64 = 32 << 20;

/// Bytes of the flash memory (controller:HW-01).
pub const FLASH_BYTES: u64 = 128 << 20;

/// Bytes of the file in which the controller keeps its log; what is older gives way (rig definition).
pub const SYSTEM_LOG_BYTES: usize = 32 << 10;

/// A folder of the tree, or a file that every controller of the profile has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TreeEntry {
    /// The path as it is spelt in listings.
    pub path: &'static str,
    /// Whether it is a folder.
    pub folder: bool,
    profiles: [bool; 3],
    ethernet: bool,
}

const fn folder(path: &'static str) -> TreeEntry {
    TreeEntry { path, folder: true, profiles: [true; 3], ethernet: false }
}

const fn file(path: &'static str) -> TreeEntry {
    TreeEntry { path, folder: false, profiles: [true; 3], ethernet: false }
}

impl TreeEntry {
    /// Only in these profiles: 2014, 2019, M251.
    const fn only(mut self, profiles: [bool; 3]) -> TreeEntry {
        self.profiles = profiles;
        self
    }

    const fn with_ethernet(mut self) -> TreeEntry {
        self.ethernet = true;
        self
    }
}

/// The folders and the files that are there without an application. Firmware files carry the version that the rig
/// gives its controllers, 01.00.
const TREE: &[TreeEntry] = &[
    folder("/sys/OS"),
    file("/sys/OS/M241FW1v_01.00").only([true, false, false]),
    file("/sys/OS/M241FW2v_01.00").only([true, false, false]),
    file("/sys/OS/M241M251FW1v_01.00").only([false, true, true]),
    file("/sys/OS/M241M251FW2v_01.00").only([false, true, true]),
    file("/sys/OS/Version.ini"),
    folder("/sys/OS/FWM").only([true, false, false]),
    folder("/sys/Web"),
    file("/sys/Web/Index.htm"),
    file("/sys/Web/Conf.htm"),
    folder("/usr/App"),
    folder("/usr/App/MFW").only([true, false, false]),
    folder("/usr/Cfg"),
    file("/usr/Cfg/FirewallDefault.cmd"),
    folder("/usr/Log"),
    folder("/usr/Rcp"),
    folder("/usr/Syslog"),
    file("/usr/Syslog/FwLog.txt").only([false, true, true]),
    folder("/usr/Dta").only([false, false, true]),
    folder("/usr/TM3fwupdate").only([false, true, true]),
    folder("/usr/web"),
    folder("/usr/Fdr/FDRS").only([false, true, true]).with_ethernet(),
    folder("/data"),
];

/// Files that may come to be, by the spelling that listings show whatever the case in which they were written.
const SPELLINGS: &[&str] = &[
    "/usr/App/Application.app",
    "/usr/App/Application.crc",
    "/usr/App/Application.map",
    "/usr/App/Archive.prj",
    "/usr/App/settings.conf",
    "/usr/App/OpcUASymbolConf.map",
    "/usr/Cfg/Machine.cfg",
    "/usr/Cfg/CodesysLateConf.cfg",
];

/// Folders of extensions.
const REDIRECTIONS: &[(&str, &str)] = &[
    ("app", "/usr/App"),
    ("ap_", "/usr/App"),
    ("err", "/usr/App"),
    ("crc", "/usr/App"),
    ("frc", "/usr/App"),
    ("prj", "/usr/App"),
    ("cfg", "/usr/Cfg"),
    ("cf_", "/usr/Cfg"),
    ("log", "/usr/Log"),
    ("rcp", "/usr/Rcp"),
    ("rsi", "/usr/Rcp"),
];

impl Profile {
    const fn place(self) -> usize {
        match self {
            Profile::M241_2014 => 0,
            Profile::M241_2019 => 1,
            Profile::M251_2024 => 2,
        }
    }

    /// Folders and files that a controller has without an application (controller:NV-03). The folder of FDR clients
    /// is on references with Ethernet alone, of an M251 on TM251MESE alone.
    pub fn file_tree(self, reference: &Reference) -> impl Iterator<Item = &'static TreeEntry> {
        let serves = match reference.family {
            Family::M241 => reference.ethernet_count() > 0,
            Family::M251 => reference.ethernet_count() > 1,
        };
        TREE.iter().filter(move |entry| entry.profiles[self.place()] && (serves || !entry.ethernet))
    }

    /// The file that holds what the tool's page Log shows (controller:NV-03, controller:NV-09).
    pub const fn system_log(self) -> &'static str {
        match self {
            Profile::M241_2014 => "/usr/Syslog/System.log",
            Profile::M241_2019 | Profile::M251_2024 => "/usr/Syslog/PlcLog.txt",
        }
    }

    /// The record of a system error, for the vendor's support (controller:NV-03).
    pub const fn crash_record(self) -> &'static str {
        match self {
            Profile::M241_2014 => "/usr/Syslog/Crash.log",
            Profile::M241_2019 | Profile::M251_2024 => "/usr/Syslog/crashC1.txt",
        }
    }

    /// The known spelling of a file's path, whatever its case (controller:NV-04).
    pub fn spelling(self, path: &str) -> Option<&'static str> {
        let own = [self.system_log(), self.crash_record()];
        SPELLINGS.iter().copied().chain(own).find(|known| known.eq_ignore_ascii_case(path))
    }

    /// The folder that a file with this extension is moved to when it is created under /usr (controller:NV-05).
    pub fn redirection(self, extension: &str) -> Option<&'static str> {
        if self == Profile::M241_2014 {
            return None;
        }
        let found = REDIRECTIONS.iter().find(|(known, _)| known.eq_ignore_ascii_case(extension));
        found.map(|(_, folder)| *folder)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // controller:NV-03
    #[test]
    fn trees_differ_as_the_table_says() {
        let has = |profile: Profile, reference: &str, path: &str| {
            let reference = Reference::find(reference).unwrap();
            profile.file_tree(reference).any(|entry| entry.path == path)
        };
        assert!(has(Profile::M241_2014, "TM241C24T", "/sys/OS/FWM"));
        assert!(!has(Profile::M241_2019, "TM241C24T", "/sys/OS/FWM"));
        assert!(!has(Profile::M241_2019, "TM241C24T", "/usr/Fdr/FDRS"));
        assert!(has(Profile::M241_2019, "TM241CE24T", "/usr/Fdr/FDRS"));
        assert!(!has(Profile::M251_2024, "TM251MESC", "/usr/Fdr/FDRS"));
        assert!(has(Profile::M251_2024, "TM251MESE", "/usr/Fdr/FDRS"));
        assert!(has(Profile::M251_2024, "TM251MESC", "/usr/Dta"));
    }
}
