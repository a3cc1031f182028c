//! `download`, `multiple-download`, `place-boot-application`, `reset-origin-device` and `firmware`: what is in the
//! controller.

use document::{Findings, KeySpec, KeyType, Node};

use super::{ProgramRef, StepNames, table_fields};
use super::{StepVerb, Stimulus};

const PROGRAM: KeySpec = KeySpec::optional(
    "program",
    KeyType::OneOrMore(&KeyType::Text),
    "Structured Text files relative to the plan; the plan's own program if left out.",
);

const PROGRAM_KEYS: &[KeySpec] = &[PROGRAM];

const DOWNLOAD_KEYS: &[KeySpec] = &[
    PROGRAM,
    KeySpec::optional(
        "create-boot-application",
        KeyType::Bool,
        "Save it as the boot application too; TRUE if left out.",
    ),
];

const MULTIPLE_KEYS: &[KeySpec] = &[
    PROGRAM,
    KeySpec::optional(
        "start",
        KeyType::Bool,
        "Start all applications after download or online change; TRUE if left out.",
    ),
];

const DEVICE_KEYS: &[KeySpec] = &[
    KeySpec::optional("user-management", KeyType::Bool, "Users and groups; FALSE if left out."),
    KeySpec::optional("plc-logic", KeyType::Bool, "Application and variables; FALSE if left out."),
    KeySpec::optional("certificates", KeyType::Bool, "Certificates; FALSE if left out."),
];

pub(super) const DOWNLOAD: StepVerb = StepVerb {
    name: "download",
    doc: "Downloads an application.",
    value: KeyType::Table(DOWNLOAD_KEYS),
    needs: &["download"],
    read: read_download,
};

pub(super) const MULTIPLE_DOWNLOAD: StepVerb = StepVerb {
    name: "multiple-download",
    doc: "Downloads an application as one of several.",
    value: KeyType::Table(MULTIPLE_KEYS),
    needs: &["download"],
    read: read_multiple,
};

pub(super) const PLACE_BOOT_APPLICATION: StepVerb = StepVerb {
    name: "place-boot-application",
    doc: "Puts a boot application into the controller by SD card or FTP.",
    value: KeyType::Table(PROGRAM_KEYS),
    needs: &["download"],
    read: |node, _, _| Some(Stimulus::PlaceBootApplication(program(node)?)),
};

pub(super) const RESET_ORIGIN_DEVICE: StepVerb = StepVerb {
    name: "reset-origin-device",
    doc: "Resets what is selected of the device to its origin.",
    value: KeyType::Table(DEVICE_KEYS),
    needs: &["commands"],
    read: read_device,
};

pub(super) const FIRMWARE: StepVerb = StepVerb {
    name: "firmware",
    doc: "Damages the controller's firmware, or restores it from an SD card.",
    value: KeyType::Choice(&["valid", "invalid"]),
    needs: &["firmware"],
    read: |node, _, _| Some(Stimulus::Firmware(node.as_text()? == "valid")),
};

/// The program of a table, `None` inside for the plan's own.
fn program(node: &Node) -> Option<Option<ProgramRef>> {
    let fields = table_fields(node, PROGRAM_KEYS)?;
    let files: Vec<String> =
        fields.each("program").iter().filter_map(Node::as_text).map(str::to_owned).collect();
    Some((!files.is_empty()).then_some(ProgramRef::Files(files)))
}

fn read_download(node: &Node, _: &dyn StepNames, _: &mut Findings) -> Option<Stimulus> {
    let boot = table_fields(node, DOWNLOAD_KEYS)?.boolean("create-boot-application").unwrap_or(true);
    Some(Stimulus::Download { program: program(node)?, boot })
}

fn read_multiple(node: &Node, _: &dyn StepNames, _: &mut Findings) -> Option<Stimulus> {
    let start = table_fields(node, MULTIPLE_KEYS)?.boolean("start").unwrap_or(true);
    Some(Stimulus::MultipleDownload { program: program(node)?, start })
}

fn read_device(node: &Node, _: &dyn StepNames, _: &mut Findings) -> Option<Stimulus> {
    let fields = table_fields(node, DEVICE_KEYS)?;
    let [user_management, plc_logic, certificates] =
        ["user-management", "plc-logic", "certificates"].map(|key| fields.boolean(key).unwrap_or(false));
    Some(Stimulus::ResetOriginDevice { user_management, plc_logic, certificates })
}
