//! The enumerations of the expansion bus in programs (plcsystem: 9.8, 9.15, 9.17): each is compiled with a program that
//! mentions its name, and with no other.

use document::SourceFile;
use profile::{ExchangeCode, ModuleState, Profile, Tm3BusState};
use std::fmt::Write;

/// The choices of TM3_BUS_W.q_wIOBusErrPassiv, which the controller of 2014 does not have (plcsystem:TM3V-06).
const HANDLING: &str = "TM3_BUS_W_IOBUSERRMOD";

/// A name and its number.
type EnumerationValue = (&'static str, u16);

/// Each enumeration with its values.
const ENUMERATIONS: [(&str, &[EnumerationValue]); 4] = [
    (
        "TM3_MODULE_STATE",
        &[
            ("TM3_EMPTY", ModuleState::Empty.code()),
            ("TM3_CONF_ERROR", ModuleState::ConfigurationError.code()),
            ("TM3_BUS_ERROR", ModuleState::BusError.code()),
            ("TM3_OK", ModuleState::Ok.code()),
            ("TM3_MISSING_OPT_MOD", ModuleState::MissingOptional.code()),
        ],
    ),
    (
        "TM3_ERR_CODE",
        &[
            ("TM3_NO_ERR", ExchangeCode::NoError.code()),
            ("TM3_ERR_FAILED", ExchangeCode::Failed.code()),
            ("TM3_ERR_PARAMETER", ExchangeCode::Parameter.code()),
            ("TM3_ERR_COK", ExchangeCode::Hardware.code()),
            ("TM3_ERR_BUS", ExchangeCode::Bus.code()),
        ],
    ),
    (
        "PLC_R_TM3_BUS_STATE",
        &[
            ("TM3_CONF_ERROR", Tm3BusState::ConfigurationError.code()),
            ("TM3_OK", Tm3BusState::Ok.code()),
            ("TM3_POWER_SUPPLY_ERROR", Tm3BusState::PowerSupplyError.code()),
        ],
    ),
    // The text of the library has the names with IOBUS, that of the bus those without.
    (HANDLING, &[("IOBUS_ERR_ACTIVE", 0), ("IOBUS_ERR_PASSIVE", 1), ("ERR_ACTIVE", 0), ("ERR_PASSIVE", 1)]),
];

/// Declares those that the sources mention and do not declare themselves.
pub(super) fn declare(sources: &[SourceFile], profile: Profile, out: &mut String) {
    for (name, values) in ENUMERATIONS {
        let exists = profile != Profile::M241_2014 || name != HANDLING;
        let mentioned = sources.iter().any(|source| program::mentions(&source.text, name));
        if !exists || !mentioned || sources.iter().any(|source| program::declares(&source.text, name)) {
            continue;
        }
        let values: Vec<String> = values.iter().map(|(name, number)| format!("{name} := {number}")).collect();
        // Writing to a text does not fail.
        let _ = writeln!(out, "TYPE {name} : ({}) WORD; END_TYPE", values.join(", "));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::application::compile;

    fn compiles(statements: &str, profile: Profile) -> bool {
        let text = format!("PROGRAM MAIN VAR w : WORD; b : BOOL; END_VAR {statements} END_PROGRAM");
        compile(&[SourceFile::new("a.st", text)], profile).is_ok()
    }

    // io:DIAG-03
    #[test]
    fn each_value_has_its_name() {
        for (name, values) in ENUMERATIONS {
            for (value, _) in values {
                let text = format!("w := {name}.{value}; b := w = {name}#{value};");
                assert!(compiles(&text, Profile::M251_2024), "{text}");
                assert_eq!(compiles(&text, Profile::M241_2014), name != HANDLING, "{text}");
            }
        }
    }

    #[test]
    fn they_go_with_what_they_are_of() {
        for text in [
            "b := TM3_MODULE_R[1].i_wModuleState = TM3_MODULE_STATE.TM3_OK;",
            "b := PLC_R.i_uiTM3BusState = PLC_R_TM3_BUS_STATE.TM3_POWER_SUPPLY_ERROR;",
            "b := TM3_GetModuleBusStatus(0) = TM3_ERR_CODE.TM3_NO_ERR;",
            "TM3_BUS_W.q_wIOBusErrPassiv := TM3_BUS_W_IOBUSERRMOD.ERR_PASSIVE;",
        ] {
            assert!(compiles(text, Profile::default()), "{text}");
        }
        let states = "CASE TM3_MODULE_R[0].i_wModuleState OF TM3_MODULE_STATE.TM3_OK: b := TRUE; END_CASE";
        assert!(compiles(states, Profile::default()));
    }

    #[test]
    fn a_program_has_its_own_of_the_name() {
        let own = "TYPE TM3_ERR_CODE : (FINE, WRONG); END_TYPE PROGRAM MAIN VAR e : TM3_ERR_CODE; END_VAR e := FINE; END_PROGRAM";
        assert!(compile(&[SourceFile::new("a.st", own)], Profile::default()).is_ok());
    }
}
