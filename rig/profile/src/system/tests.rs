use super::*;
use std::collections::BTreeMap;

// The places of variants are those of the table.
#[test]
fn every_member_is_the_one_of_its_field() {
    for structure in SystemStructure::ALL {
        for member in structure.members() {
            assert!(std::ptr::eq(member, member.field.member()), "{}", member.name);
            assert_eq!(member.field.structure(), structure);
            assert_eq!(structure.name().ends_with("_R"), structure.is_read_only());
            assert!(
                member.name.starts_with(if structure.is_read_only() { "i_" } else { "q_" }),
                "{}",
                member.name
            );
        }
    }
}

// plcsystem: sections 2 and 5, controller:SYS-06
#[test]
fn located_members_have_their_registers() {
    for (profile, gaps) in [
        (Profile::M241_2014, &[60_027][..]),
        (Profile::M241_2019, &[60_027]),
        (Profile::M251_2024, &[60_020, 60_021, 60_022, 60_023, 60_024, 60_027]),
    ] {
        let mut words = BTreeMap::new();
        for member in SystemStructure::ALL.into_iter().flat_map(|structure| structure.members_of(profile)) {
            let Some(first) = member.register else { continue };
            for word in 0..member.ty(profile).words() {
                assert_eq!(words.insert(first + word, member.name), None, "{} overlaps", member.name);
                assert_eq!(SystemField::located(profile, first + word), Some((member.field, word)));
            }
        }
        let expected: Vec<u16> =
            (60_000..60_036).chain(60_050..60_067).filter(|at| !gaps.contains(at)).collect();
        assert_eq!(words.keys().copied().collect::<Vec<_>>(), expected);
        assert_eq!(SystemField::located(profile, 60_027), None);
        assert_eq!(SystemField::located(profile, 60_067), None);
    }
}

#[test]
fn every_variable_is_found_by_its_name() {
    for profile in Profile::ALL {
        let mut names = Vec::new();
        for variable in SystemVariable::all(profile) {
            let name = variable.to_string();
            assert_eq!(SystemVariable::find(&name, profile), Some(variable), "{name}");
            let long = format!("plc_gvl.{}", name.to_ascii_lowercase());
            assert_eq!(SystemVariable::find(&long, profile), Some(variable), "{long}");
            assert!(!names.contains(&name), "{name} twice");
            names.push(name);
        }
        assert!(names.iter().any(|name| name == "SERIAL_W[1].q_wResetCounter"));
        assert!(names.iter().any(|name| name == "ETH_R.i_byMACAddress_I2[5]"));
        assert!(!names.iter().any(|name| name.contains("i_sNodeName")));
    }
}

#[test]
fn what_is_no_variable_is_not_found() {
    for name in [
        "PLC_R",
        "PLC_R.",
        "PLC_R.i_sNodeName",
        "PLC_R.i_byFirmVersion",
        "PLC_R.i_byFirmVersion[4]",
        "PLC_R.i_byFirmVersion[+1]",
        "PLC_R.i_byFirmVersion[]",
        "PLC_R.i_wStatus[0]",
        "PLC_R[0].i_wStatus",
        "TM3_MODULE_R.i_wModuleState",
        "TM3_MODULE_R[14].i_wModuleState",
        "TM3_MODULE_R[256].i_wModuleState",
        "SERIAL_R[2].i_uiSlaveNakCount",
        "PLC_GVL.i_wStatus",
        "OTHER.PLC_R.i_wStatus",
        "i_wStatus",
    ] {
        assert_eq!(SystemVariable::find(name, Profile::default()), None, "{name}");
    }
    let text = SystemMember::find("PLC_GVL.PLC_R.i_sNodeName", Profile::default()).unwrap();
    assert_eq!((text.0.field, text.1), (PlcRead::NodeName.into(), 0));
}

// plcsystem:TM3V-06
#[test]
fn members_are_in_the_profiles_that_have_them() {
    let has = |name: &str| Profile::ALL.map(|profile| SystemMember::find(name, profile).is_some());
    assert_eq!(has("TM3_BUS_W.q_wIOBusRestart"), [false, true, true]);
    assert_eq!(has("TM3_BUS_W.q_wIoBusRestart"), [false, true, true]);
    assert_eq!(has("PLC_R.i_lwSystemFault_2"), [true, true, false]);
    assert_eq!(has("PLC_R.i_wIOStatus1"), [true, true, false]);
    assert_eq!(has("PLC_R.i_wLocalIOStatus"), [true, true, false]);
    assert_eq!(has("ETH_R.i_byGateway_If2"), [true; 3]);
    let exists = |structure: SystemStructure| Profile::ALL.map(|profile| structure.exists(profile));
    assert_eq!(exists(SystemStructure::Tm3BusW), [false, true, true]);
    assert_eq!(exists(SystemStructure::ProfibusR), [true; 3]);
}

// controller:REL-04: a text of n characters takes n + 1 bytes.
#[test]
fn lengths_in_registers() {
    let words = |name: &str, profile| SystemMember::find(name, profile).unwrap().0.ty(profile).words();
    assert_eq!(words("PLC_R.i_sNodeName", Profile::M241_2019), 16);
    assert_eq!(words("PLC_R.i_sNodeName", Profile::M251_2024), 50);
    assert_eq!(words("ETH_R.i_byMACAddress", Profile::M251_2024), 3);
    assert_eq!(words("ETH_R.i_sDeviceName", Profile::M251_2024), 8);
    assert_eq!(words("PLC_R.i_x1sClk", Profile::M251_2024), 1);
    assert_eq!(words("SERIAL_R[1].i_udiFramesReceivedOK", Profile::M251_2024), 2);
    assert_eq!(words("SERIAL_R[1].i_udiSlaveMsgCount", Profile::M251_2024), 1);
}

// plcsystem: section 9
#[test]
fn enumerations_name_each_number_once() {
    for one in ENUMERATIONS {
        let numbers: Vec<u16> = one.labels().map(|(_, number)| number).collect();
        assert!(
            numbers.iter().enumerate().all(|(place, number)| !numbers[..place].contains(number)),
            "{}",
            one.name
        );
        assert!(one.values.iter().all(|(_, number)| numbers.contains(number)), "{}", one.name);
    }
    let members = SystemStructure::ALL.into_iter().flat_map(|structure| structure.members());
    for known in members.filter_map(|member| member.enumeration) {
        assert!(ENUMERATIONS.contains(&known), "{}", known.name);
    }
}
