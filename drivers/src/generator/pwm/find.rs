//! From what a board file says to a PWM chip.

use std::fs;
use std::path::{Path, PathBuf};

use document::suggest;

use super::super::{FindPwm, PwmSpec};
use crate::codes;
use crate::inventory::{line, names};
use crate::refusal::Refusal;

/// A PWM chip of the machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FoundPwm {
    /// Its folder in `/sys`.
    pub folder: PathBuf,
    /// Its name in the kernel, as in `pwmchip0`.
    pub name: String,
    /// The name of its device, as in `fe20c000.pwm`; empty where it does not say.
    pub label: String,
    /// How many outputs it has.
    pub outputs: u16,
}

impl FoundPwm {
    /// What messages call it.
    pub fn words(&self) -> String {
        match self.label.is_empty() {
            true => self.name.clone(),
            false => format!("{} ({})", self.name, self.label),
        }
    }
}

/// The chips of the machine whose `/sys` lies under `root`.
pub(super) fn list(root: &Path) -> Vec<FoundPwm> {
    let class = root.join("sys/class/pwm");
    let chip = |name: String| {
        let folder = class.join(&name);
        let outputs = line(&folder.join("npwm")).parse().ok()?;
        let device = fs::canonicalize(folder.join("device")).ok();
        let label = device.and_then(|path| Some(path.file_name()?.to_str()?.to_owned())).unwrap_or_default();
        Some(FoundPwm { folder, name, label, outputs })
    };
    names(&class).into_iter().filter_map(chip).collect()
}

/// The chip that a board file means. Nothing is opened.
///
/// # Errors
/// There is none, or several answer to this.
pub fn find(root: &Path, spec: &PwmSpec) -> Result<FoundPwm, Refusal> {
    let machine = list(root);
    let (what, wanted) = match &spec.find {
        FindPwm::Label(label) => (format!("the label \"{label}\""), label.as_str()),
        FindPwm::Name(name) => (format!("the name \"{name}\""), name.as_str()),
        FindPwm::Path(path) => (format!("the path \"{}\"", path.display()), ""),
    };
    let is_meant = |chip: &&FoundPwm| match &spec.find {
        FindPwm::Label(label) => chip.label == *label,
        FindPwm::Name(name) => chip.name == *name,
        FindPwm::Path(path) => is_at(root, chip, path),
    };
    let matches: Vec<&FoundPwm> = machine.iter().filter(is_meant).collect();
    match matches[..] {
        [one] => Ok(one.clone()),
        [] => {
            let known = machine.iter().map(|chip| match spec.find {
                FindPwm::Label(_) => chip.label.as_str(),
                _ => chip.name.as_str(),
            });
            let known: Vec<&str> = known.filter(|name| !name.is_empty()).collect();
            let help = match (suggest(wanted, known.iter().copied()), known.is_empty()) {
                (Some(meant), _) => format!("did you mean \"{meant}\"?"),
                (None, true) => {
                    "the machine has no PWM chip at all: is it switched on in the device tree, and its \
                                 driver loaded?"
                        .to_owned()
                }
                (None, false) => format!("the machine has {}", known.join(", ")),
            };
            Err(Refusal::new(codes::GENERATOR_MISSING, format!("no PWM chip has {what}"), help))
        }
        _ => {
            let names: Vec<&str> = matches.iter().map(|chip| chip.name.as_str()).collect();
            let message =
                format!("{} PWM chips of the machine have {what}: {}", names.len(), names.join(", "));
            let help = "say which by `path`: what `readlink -f` says of its place below /sys/class/pwm";
            Err(Refusal::new(codes::GENERATORS_ALIKE, message, help))
        }
    }
}

/// Whether a path is a chip's place in `/sys`, or that of its device.
fn is_at(root: &Path, chip: &FoundPwm, path: &Path) -> bool {
    let Ok(meant) = root.join(path.strip_prefix("/").unwrap_or(path)).canonicalize() else { return false };
    let places = [chip.folder.clone(), chip.folder.join("device")];
    places.iter().filter_map(|place| place.canonicalize().ok()).any(|place| place == meant)
}

#[cfg(test)]
mod tests {
    use super::*;
    use signal::Span;
    use std::os::unix::fs::symlink;

    #[test]
    fn a_chip_is_found_by_what_stays_and_told_apart_from_others() {
        let root = std::env::temp_dir().join(format!("scanrig-pwm-{}", std::process::id()));
        let _ = fs::remove_dir_all(&root);
        // One device with two chips, one with one, and a chip of which nothing more is known.
        for (device, chip) in [("ehrpwm", "pwmchip0"), ("ehrpwm", "pwmchip2"), ("fe20c000.pwm", "pwmchip10")]
        {
            let place = root.join(format!("sys/devices/{device}/pwm/{chip}"));
            fs::create_dir_all(&place).unwrap();
            fs::write(place.join("npwm"), "2\n").unwrap();
            symlink("../..", place.join("device")).unwrap();
            fs::create_dir_all(root.join("sys/class/pwm")).unwrap();
            symlink(format!("../../devices/{device}/pwm/{chip}"), root.join("sys/class/pwm").join(chip))
                .unwrap();
        }
        fs::create_dir_all(root.join("sys/class/pwm/pwmchip11")).unwrap();
        let asked = |find: FindPwm| {
            let (shortest, longest) = (Span::from_nanos(1), Span::from_secs(1));
            super::find(&root, &PwmSpec { find, clock: None, shortest, longest })
        };
        let found =
            |find| asked(find).map(|chip| chip.words()).map_err(|refusal| (refusal.code, refusal.help));
        let one = Ok("pwmchip10 (fe20c000.pwm)".to_owned());
        assert_eq!(found(FindPwm::Label("fe20c000.pwm".into())), one);
        assert_eq!(found(FindPwm::Name("pwmchip10".into())), one);
        assert_eq!(found(FindPwm::Path("/sys/class/pwm/pwmchip10".into())), one);
        assert_eq!(found(FindPwm::Path("/sys/devices/fe20c000.pwm".into())), one);
        assert_eq!(asked(FindPwm::Name("pwmchip10".into())).unwrap().outputs, 2);
        assert_eq!(found(FindPwm::Label("ehrpwm".into())).unwrap_err().0, "B0231");
        let missing = found(FindPwm::Label("fe20c00.pwm".into())).unwrap_err();
        assert_eq!(missing, ("B0230", "did you mean \"fe20c000.pwm\"?".to_owned()));
        assert_eq!(found(FindPwm::Name("pwmchip11".into())).unwrap_err().0, "B0230");
        fs::remove_dir_all(&root).unwrap();
    }
}
