//! The system variables in programs: structures that are compiled with a program that mentions them, and with no
//! other, so that nothing else changes for it.

use crate::application::enumerations;
use controller::SystemVariable;
use document::SourceFile;
use profile::{MODULE_INDICES, Profile};
use std::borrow::Cow;
use std::fmt::Write;

/// Name of the source that declares the structures: their list, whose name may stand before theirs (plcsystem:GVL-01).
const NAME: &str = "PLC_GVL";

/// The structures: first those that programs only read.
const STRUCTURES: [&str; 4] = ["PLC_R", MODULES, "PLC_W", "TM3_BUS_W"];

/// The one that is an array, with a structure for each expansion module (io:DIAG-01).
const MODULES: &str = "TM3_MODULE_R";

/// Sources with what they mention of the system variables behind them, so that their own places stay; and the
/// variables that they may not write. What the sources declare themselves is theirs.
///
/// A structure that a controller of the profile does not have is not declared.
pub fn with_system(
    sources: &[SourceFile],
    profile: Profile,
) -> (Cow<'_, [SourceFile]>, &'static [&'static str]) {
    let mut text = String::new();
    let mut declared = [false; STRUCTURES.len()];
    for (structure, declared) in STRUCTURES.into_iter().zip(&mut declared) {
        let mut members = SystemVariable::ALL.iter().filter(|known| known.name().starts_with(structure));
        if !members.any(|known| known.exists(profile)) {
            continue;
        }
        let mentioned = sources.iter().any(|source| program::mentions(&source.text, structure));
        if !mentioned || sources.iter().any(|source| program::declares(&source.text, structure)) {
            continue;
        }
        declare(structure, &mut text);
        *declared = true;
    }
    enumerations::declare(sources, profile, &mut text);
    let read_only: &[&str] = match declared {
        [true, true, ..] => &["PLC_R", MODULES],
        [true, false, ..] => &["PLC_R"],
        [false, true, ..] => &[MODULES],
        [false, false, ..] => &[],
    };
    if text.is_empty() {
        return (Cow::Borrowed(sources), read_only);
    }
    let mut all = sources.to_vec();
    all.push(SourceFile::new(NAME, text));
    (Cow::Owned(all), read_only)
}

/// The type and the variable of a structure.
fn declare(structure: &str, out: &mut String) {
    let (first, ty) = match structure {
        MODULES => (format!("{MODULES}[0]"), format!("ARRAY[0..{}] OF {MODULES}_STRUCT", MODULE_INDICES - 1)),
        _ => (structure.to_owned(), format!("{structure}_STRUCT")),
    };
    let members = SystemVariable::ALL.iter().filter_map(|variable| {
        let name = variable.name().strip_prefix(first.as_str())?.strip_prefix('.')?;
        Some((name, variable.ty().name()))
    });
    // Writing to a text does not fail.
    let _ = write!(out, "TYPE {structure}_STRUCT : STRUCT ");
    for (name, member) in members {
        let _ = write!(out, "{name} : {member}; ");
    }
    let _ = writeln!(out, "END_STRUCT END_TYPE VAR_GLOBAL {structure} : {ty}; END_VAR");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::application::compile;
    use program::Elementary;

    fn source(statements: &str) -> [SourceFile; 1] {
        [SourceFile::new(
            "a.st",
            format!("PROGRAM MAIN VAR w : WORD; b : BOOL; END_VAR {statements} END_PROGRAM"),
        )]
    }

    fn codes(statements: &str) -> Vec<&'static str> {
        match compile(&source(statements), Profile::default()) {
            Ok(_) => Vec::new(),
            Err(found) => found.iter().map(|found| found.code).collect(),
        }
    }

    #[test]
    fn every_system_variable_has_its_type() {
        let program = compile(
            &source("w := PLC_R.i_wStatus; plc_w.q_wPLCControl := tm3_module_r[1].i_wModuleState; TM3_BUS_W.q_wIOBusRestart := 1;"),
            Profile::default(),
        )
        .unwrap();
        for variable in SystemVariable::ALL {
            let found = program.find(variable.name()).unwrap();
            let ty = match variable.ty() {
                controller::SystemType::Bool => Elementary::Bool,
                controller::SystemType::Byte => Elementary::Byte,
                controller::SystemType::Word => Elementary::Word,
                controller::SystemType::Uint => Elementary::Uint,
                controller::SystemType::Dword => Elementary::Dword,
                controller::SystemType::Lword => Elementary::Lword,
            };
            assert_eq!(found.ty, ty, "{}", variable.name());
        }
    }

    #[test]
    fn a_program_that_mentions_none_is_as_it_was() {
        for text in ["w := 1; // PLC_R", "(* PLC_W *) w := 1;", "w := 1; {PLC_R}"] {
            let sources = source(text);
            let (all, _) = with_system(&sources, Profile::default());
            assert!(matches!(all, Cow::Borrowed(_)), "{text}");
        }
        let sources = source("w := PLC_R.i_wStatus;");
        let (all, read_only) = with_system(&sources, Profile::default());
        assert_eq!((all.len(), read_only), (2, &["PLC_R"][..]));
        assert!(!all[1].text.contains("PLC_W"));
    }

    // plcsystem:TM3V-06
    #[test]
    fn the_controller_of_2014_has_no_commands_to_the_bus() {
        let source = source("TM3_BUS_W.q_wIOBusErrPassiv := 1;");
        assert!(compile(&source, Profile::M241_2014).is_err());
        assert!(compile(&source, Profile::M241_2019).is_ok());
    }

    #[test]
    fn plc_r_is_only_read() {
        assert_eq!(codes("b := PLC_R.i_x1sClk; PLC_W.q_wPLCControl := PLC_R.i_wStatus;"), Vec::<&str>::new());
        let read_only = codes("PLC_R.i_wStatus := 1;");
        assert_eq!(read_only, ["S0401"]);
        assert_eq!(codes("PLC_R.i_wStatus.1 := TRUE;"), read_only);
        assert_eq!(codes("TM3_MODULE_R[3].i_wModuleState := 3;"), read_only);
        assert_eq!(codes("w := TM3_MODULE_R[14].i_wModuleState;").len(), 1);
        assert_eq!(codes("PLC_GVL.PLC_R.i_wStatus := 1;"), read_only);
        assert_eq!(codes("PLC_GVL.PLC_W.q_wPLCControl := PLC_GVL.plc_r.i_wStatus;"), Vec::<&str>::new());
        assert_eq!(codes("w := PLC_GVL.PLC_R.no_member;"), codes("w := PLC_R.no_member;"));
        // A local variable of the name is the program's own.
        let own = "PROGRAM MAIN VAR plc_r : WORD; END_VAR plc_r := 1; END_PROGRAM";
        assert!(compile(&[SourceFile::new("a.st", own)], Profile::default()).is_ok());
    }
}
