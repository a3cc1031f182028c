//! The system variables in programs: structures that are compiled with a program that mentions them, and with no
//! other, so that nothing else changes for it.

use document::SourceFile;
use profile::{ENUMERATIONS, Profile, SYSTEM_NAMESPACE, SystemStructure};
use std::borrow::Cow;
use std::fmt::Write;

/// Sources with what they mention of the system variables after them, so that their own places stay; and the
/// variables that they may not write (plcsystem:GVL-02). What the sources declare themselves is theirs.
///
/// What a controller of the profile does not have is not declared.
pub fn with_system(
    sources: &[SourceFile],
    profile: Profile,
) -> (Cow<'_, [SourceFile]>, Cow<'static, [&'static str]>) {
    let wanted = |name: &str| {
        sources.iter().any(|source| program::mentions(&source.text, name))
            && !sources.iter().any(|source| program::declares(&source.text, name))
    };
    let mut text = String::new();
    let mut read_only = Vec::new();
    for structure in SystemStructure::ALL {
        if structure.exists(profile) && wanted(structure.name()) {
            declare(structure, profile, &mut text);
            read_only.extend(structure.is_read_only().then_some(structure.name()));
        }
    }
    for one in ENUMERATIONS {
        if one.profiles.contains(&profile) && wanted(one.name) {
            let values: Vec<String> =
                one.values.iter().map(|(name, number)| format!("{name} := {number}")).collect();
            // Writing to a text does not fail.
            let _ = writeln!(text, "TYPE {} : ({}) WORD; END_TYPE", one.name, values.join(", "));
        }
    }
    if text.is_empty() {
        return (Cow::Borrowed(sources), Cow::Borrowed(&[]));
    }
    let mut all = sources.to_vec();
    // Their list, whose name may stand before theirs (plcsystem:GVL-01).
    all.push(SourceFile::new(SYSTEM_NAMESPACE, text));
    (Cow::Owned(all), Cow::Owned(read_only))
}

/// The type and the variable of a structure.
fn declare(structure: SystemStructure, profile: Profile, out: &mut String) {
    let name = structure.name();
    // Writing to a text does not fail.
    let _ = write!(out, "TYPE {name}_STRUCT : STRUCT ");
    for member in structure.members_of(profile) {
        let ty = member.ty(profile).declaration();
        for name in member.names_of_it() {
            let _ = write!(out, "{name} : {ty}; ");
        }
    }
    let array = structure.elements().map(|elements| format!("ARRAY[0..{}] OF ", elements - 1));
    let array = array.unwrap_or_default();
    let _ = writeln!(out, "END_STRUCT END_TYPE VAR_GLOBAL {name} : {array}{name}_STRUCT; END_VAR");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::application::compile;
    use profile::{MemberType, SystemVariable};
    use program::Elementary;

    fn source(statements: &str) -> [SourceFile; 1] {
        [SourceFile::new(
            "a.st",
            format!("PROGRAM MAIN VAR w : WORD; b : BOOL; s : STRING(255); END_VAR {statements} END_PROGRAM"),
        )]
    }

    fn codes(statements: &str, profile: Profile) -> Vec<&'static str> {
        match compile(&source(statements), profile) {
            Ok(_) => Vec::new(),
            Err(found) => found.iter().map(|found| found.code).collect(),
        }
    }

    #[test]
    fn every_system_variable_has_its_type() {
        for profile in Profile::ALL {
            let structures = SystemStructure::ALL.into_iter().filter(|structure| structure.exists(profile));
            let mention = |structure: SystemStructure| match structure.elements() {
                Some(_) => format!("w := SIZEOF({}[1]); ", structure.name()),
                None => format!("w := SIZEOF({}); ", structure.name()),
            };
            let text: String = structures.map(mention).collect();
            let program = compile(&source(&text), profile).unwrap();
            for variable in SystemVariable::all(profile) {
                let found = program.find(&variable.to_string()).unwrap();
                let ty = match variable.ty(profile) {
                    MemberType::Bool => Elementary::Bool,
                    MemberType::Byte | MemberType::Bytes(_) => Elementary::Byte,
                    MemberType::Word => Elementary::Word,
                    MemberType::Uint => Elementary::Uint,
                    MemberType::Dword => Elementary::Dword,
                    MemberType::Udint => Elementary::Udint,
                    MemberType::Lword => Elementary::Lword,
                    MemberType::Text(_) => unreachable!("a text is no single value"),
                };
                assert_eq!(found.ty, ty, "{variable}");
            }
            // What takes registers takes as many bytes in a program, and one more where they are odd.
            for structure in
                SystemStructure::ALL.into_iter().filter(|structure| structure.elements().is_none())
            {
                for member in structure.members_of(profile) {
                    if !matches!(member.ty(profile), MemberType::Bytes(_) | MemberType::Text(_)) {
                        continue;
                    }
                    for name in member.names_of_it() {
                        let path = format!("{}.{name}", structure.name());
                        let bytes = program.extent(&path).unwrap().bytes;
                        assert_eq!(bytes.div_ceil(2), u32::from(member.ty(profile).words()), "{path}");
                    }
                }
            }
        }
    }

    /// The name of a variable of each type, and its declaration.
    const TYPES: [(&str, &str); 8] = [
        ("BOOL", "b : BOOL"),
        ("BYTE", "y : BYTE"),
        ("WORD", "w : WORD"),
        ("UINT", "u : UINT"),
        ("DWORD", "d : DWORD"),
        ("UDINT", "n : UDINT"),
        ("LWORD", "l : LWORD"),
        ("STRING", "s : STRING(255)"),
    ];

    /// The statements that read the members of the listing in the manual, each with the profiles that have it.
    fn listing() -> Vec<(String, Vec<Profile>)> {
        let mut found = Vec::new();
        let mut structure = None;
        for line in include_str!("../../../../docs/system-variables.md").lines() {
            if let Some(name) = line.strip_prefix("<!-- table: ") {
                structure = SystemStructure::find(name.trim_end_matches(" -->"));
            }
            let cells: Vec<&str> = line.split('|').map(str::trim).collect();
            let (Some(structure), ["", names, ty, _, _, _, _, profiles, ..]) = (structure, &cells[..]) else {
                continue;
            };
            if !names.starts_with('`') {
                continue;
            }
            let of = |profile: &Profile| {
                *profiles == "all" || profiles.split(", ").any(|name| name == profile.name())
            };
            let profiles: Vec<Profile> = Profile::ALL.into_iter().filter(of).collect();
            let element =
                structure.elements().map_or(String::new(), |elements| format!("[{}]", elements - 1));
            let (ty, end) = match ty.strip_prefix("ARRAY[0..") {
                Some(rest) => ("BYTE", format!("[{}]", rest.split(']').next().unwrap())),
                None => (*ty, String::new()),
            };
            let (_, declared) = TYPES.iter().find(|(known, _)| ty.starts_with(known)).unwrap();
            let variable = declared.split(' ').next().unwrap();
            for name in names.split(", ") {
                let path = format!("{}{element}.{}{end}", structure.name(), name.trim_matches('`'));
                found.push((format!("{variable} := {path};"), profiles.clone()));
            }
        }
        found
    }

    fn reading(statements: &str) -> [SourceFile; 1] {
        let variables: Vec<&str> = TYPES.iter().map(|(_, declared)| *declared).collect();
        let variables = variables.join("; ");
        [SourceFile::new("a.st", format!("PROGRAM MAIN VAR {variables}; END_VAR {statements} END_PROGRAM"))]
    }

    #[test]
    fn a_program_reads_every_variable_of_the_listing() {
        let listing = listing();
        let members = SystemStructure::ALL.into_iter().flat_map(|structure| structure.members());
        assert_eq!(listing.len(), members.flat_map(|member| member.names_of_it()).count());
        for profile in Profile::ALL {
            let has = |(_, profiles): &&(String, Vec<Profile>)| profiles.contains(&profile);
            let all: String = listing.iter().filter(has).map(|(statement, _)| statement.as_str()).collect();
            match compile(&reading(&all), profile) {
                // Names of more than 32 characters are the library's.
                Ok(program) => assert!(program.warnings.is_empty(), "{:?}", program.warnings),
                Err(found) => panic!("{}: {}", profile.name(), found[0].message),
            }
            for (statement, _) in listing.iter().filter(|line| !has(line)) {
                let found = compile(&reading(statement), profile).unwrap_err();
                assert_eq!(found.iter().map(|one| one.code).collect::<Vec<_>>(), ["S0301"], "{statement}");
            }
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
        assert_eq!((all.len(), &*read_only), (2, &["PLC_R"][..]));
        assert!(!all[1].text.contains("PLC_W"));
    }

    // plcsystem:TM3V-06
    #[test]
    fn the_controller_of_2014_has_no_commands_to_the_bus() {
        let text = "TM3_BUS_W.q_wIOBusErrPassiv := 1;";
        assert!(!codes(text, Profile::M241_2014).is_empty());
        assert_eq!(codes(text, Profile::M241_2019), Vec::<&str>::new());
    }

    // plcsystem: section 2: the table of the M251 has neither a second field of errors nor embedded inputs and outputs.
    #[test]
    fn an_m251_has_no_members_of_embedded_channels() {
        for member in ["i_wIOStatus1", "i_wLocalIOStatus"] {
            let text = format!("w := PLC_R.{member};");
            assert_eq!(codes(&text, Profile::M241_2014), Vec::<&str>::new(), "{member}");
            assert!(!codes(&text, Profile::M251_2024).is_empty(), "{member}");
        }
    }

    #[test]
    fn texts_and_bytes_are_read() {
        let text = "s := PLC_R.i_sNodeName; s := PLC_GVL.ETH_R.i_sDeviceName_If2; w := PLC_R.i_byFirmVersion[3]; w := SERIAL_R[1].i_uiSlaveNakCount; w := ETH_R.i_byMACAddress_I2[5];";
        for profile in Profile::ALL {
            assert_eq!(codes(text, profile), Vec::<&str>::new());
            assert!(!codes("w := PLC_R.i_byFirmVersion[4];", profile).is_empty());
            assert!(!codes("w := SERIAL_R[2].i_uiSlaveNakCount;", profile).is_empty());
        }
    }

    // plcsystem:GVL-02
    #[test]
    fn structures_that_end_in_r_are_only_read() {
        let codes = |text: &str| codes(text, Profile::default());
        assert_eq!(codes("b := PLC_R.i_x1sClk; PLC_W.q_wPLCControl := PLC_R.i_wStatus;"), Vec::<&str>::new());
        let read_only = codes("PLC_R.i_wStatus := 1;");
        assert_eq!(read_only, ["S0401"]);
        for text in [
            "PLC_R.i_wStatus.1 := TRUE;",
            "TM3_MODULE_R[3].i_wModuleState := 3;",
            "PLC_GVL.PLC_R.i_wStatus := 1;",
            "PLC_R.i_sNodeName := 'mine';",
            "ETH_R.i_byIPAddress[0] := 1;",
            "ETH_R.i_wIpMode_If2 := 0;",
            "SERIAL_R[0].i_udiFramesReceivedOK := 0;",
            "PROFIBUS_R.i_wBusAdr := 1;",
            "w := PLC_R.i_wStatus; ETH_R.i_wPortASpeed := 10; s := PLC_R.i_sVendorName;",
        ] {
            assert_eq!(codes(text), read_only, "{text}");
        }
        for text in [
            "SERIAL_W[1].q_wResetCounter := SERIAL_W[0].q_wResetCounter;",
            "ETH_W.q_wResetCounter := 1;",
            "PLC_W.q_wResetCounterEvent := 1;",
            "PLC_GVL.PLC_W.q_wPLCControl := PLC_GVL.plc_r.i_wStatus;",
        ] {
            assert_eq!(codes(text), Vec::<&str>::new(), "{text}");
        }
        assert_eq!(codes("w := TM3_MODULE_R[14].i_wModuleState;").len(), 1);
        assert_eq!(codes("w := PLC_GVL.PLC_R.no_member;"), codes("w := PLC_R.no_member;"));
        // A local variable of the name is the program's own.
        let own = "PROGRAM MAIN VAR plc_r : WORD; END_VAR plc_r := 1; END_PROGRAM";
        assert!(compile(&[SourceFile::new("a.st", own)], Profile::default()).is_ok());
    }

    // plcsystem: section 9
    #[test]
    fn each_value_of_an_enumeration_has_its_name() {
        for profile in Profile::ALL {
            for one in ENUMERATIONS {
                for (value, _) in one.values {
                    let text = format!("w := {}.{value}; b := w = {}#{value};", one.name, one.name);
                    assert_eq!(codes(&text, profile).is_empty(), one.profiles.contains(&profile), "{text}");
                }
            }
        }
    }

    #[test]
    fn enumerations_go_with_what_they_are_of() {
        for text in [
            "b := TM3_MODULE_R[1].i_wModuleState = TM3_MODULE_STATE.TM3_OK;",
            "b := PLC_R.i_uiTM3BusState = PLC_R_TM3_BUS_STATE.TM3_POWER_SUPPLY_ERROR;",
            "b := TM3_GetModuleBusStatus(0) = TM3_ERR_CODE.TM3_NO_ERR;",
            "TM3_BUS_W.q_wIOBusErrPassiv := TM3_BUS_W_IOBUSERRMOD.ERR_PASSIVE;",
            "CASE TM3_MODULE_R[0].i_wModuleState OF TM3_MODULE_STATE.TM3_OK: b := TRUE; END_CASE",
            "PLC_W.q_wPLCControl := PLC_W_COMMAND.PLC_W_STOP;",
            "b := PLC_R.i_wStatus = PLC_R_STATUS.PLC_R_RUNNING AND ETH_R.i_wIpMode = ETH_R_IP_MODE.ETH_R_DHCP;",
        ] {
            assert_eq!(codes(text, Profile::default()), Vec::<&str>::new(), "{text}");
        }
    }

    #[test]
    fn a_program_has_its_own_enumeration_of_the_name() {
        let own = "TYPE TM3_ERR_CODE : (FINE, WRONG); END_TYPE PROGRAM MAIN VAR e : TM3_ERR_CODE; END_VAR e := FINE; END_PROGRAM";
        assert!(compile(&[SourceFile::new("a.st", own)], Profile::default()).is_ok());
    }
}
