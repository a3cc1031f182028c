//! What the network and plans see of every system variable.

use crate::support::*;
use profile::{
    BusWrite, EthernetRead, EthernetWrite, MemberSource, MemberType, PlcRead, PlcWrite, Profile, READ_TABLE,
    SerialWrite, SystemMember, SystemStructure, SystemVariable, WRITE_TABLE,
};
use scanrig_controller::*;
use signal::{Cause, Span, Value};

fn script() -> Script {
    Script::new(vec![vec![(1_000, Act::Nop)]])
}

/// A running controller of the profile with these rows in its relocation table.
fn running(profile: Profile, read: &[&str], write: &[&str]) -> Rig {
    let names = |rows: &[&str]| rows.iter().map(|row| (*row).to_owned()).collect();
    let relocation = RelocationConfig { read: names(read), write: names(write) };
    Rig::running(Config { relocation, ..Config::new(profile) }, script())
}

fn words(rig: &Rig, first: u16, count: u16) -> Vec<u16> {
    let mut words = vec![0; usize::from(count)];
    rig.plc.read_registers(first, &mut words).unwrap();
    words
}

fn write(rig: &mut Rig, register: u16, value: u16) {
    rig.plc.write_registers(rig.now, register, &[value], Cause::Step(0), &mut rig.fx).unwrap();
}

fn value(rig: &Rig, variable: impl Into<SystemVariable>) -> Value {
    rig.plc.read(&Probe::System(variable.into()))
}

fn names(
    structure: SystemStructure,
    profile: Profile,
) -> impl Iterator<Item = (&'static SystemMember, u8, String)> {
    (0..structure.elements().unwrap_or(1)).flat_map(move |element| {
        let whole = match structure.elements() {
            Some(_) => format!("{}[{element}]", structure.name()),
            None => structure.name().to_owned(),
        };
        let named = move |member: &'static SystemMember| {
            let whole = whole.clone();
            member.names_of_it().map(move |name| (member, element as u8, format!("{whole}.{name}")))
        };
        structure.members_of(profile).flat_map(named)
    })
}

// plcsystem:GVL-04, plcsystem:GVL-11, plcsystem: section 1.2
#[test]
fn every_member_is_reached_by_a_row_with_its_length_and_value() {
    for profile in Profile::ALL {
        for (member, part, name) in SystemStructure::ALL.into_iter().flat_map(|it| names(it, profile)) {
            let length = member.ty(profile).words();
            let rig = running(profile, &[&name, "%MW9"], &[]);
            let row = |place, fact: fn(RelocationPart, u16) -> RegisterProbe| {
                rig.plc.read(&Probe::Register(fact(RelocationPart::Read, place)))
            };
            assert_eq!(row(0, RegisterProbe::Valid), Value::Bool(true), "{name}");
            assert_eq!(row(0, RegisterProbe::Length), Value::Int(i64::from(length)), "{name}");
            let next = Value::Int(i64::from(READ_TABLE + length));
            assert_eq!(row(1, RegisterProbe::Address), next, "{name}");
            let shown = words(&rig, READ_TABLE, length);
            let of = |part| value(&rig, SystemVariable { field: member.field, part });
            let expected: Vec<u16> = match member.ty(profile) {
                MemberType::Text(_) => {
                    assert_eq!(shown.last().map(|last| last >> 8), Some(0), "{name} ends with 0");
                    continue;
                }
                MemberType::Bytes(bytes) => {
                    let all: Vec<u8> = (0..bytes).map(|byte| of(byte).as_int().unwrap() as u8).collect();
                    all.chunks(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect()
                }
                _ => {
                    let bits = of(part).as_int().unwrap() as u64;
                    (0..length).map(|word| (bits >> (16 * word)) as u16).collect()
                }
            };
            assert_eq!(shown, expected, "{name}");
            if let MemberSource::Rest(rest) = member.source {
                let bits = shown.iter().rev().fold(0, |bits, word| bits << 16 | u64::from(*word));
                assert_eq!(bits, rest, "{name}");
            }
            if let Some(first) = member.register {
                assert_eq!(words(&rig, first, length), shown, "{name}");
            }
        }
    }
}

// What had no row before: clock bits, modules, a byte of an array.
#[test]
fn rows_of_clocks_modules_and_bytes_have_values() {
    let rows = [
        "PLC_R.i_x1sClk",
        "TM3_MODULE_R[13].i_wModuleState",
        "PLC_GVL.PLC_R.i_byFirmVersion[0]",
        "ETH_R.i_wPortAIpStatus_If2",
    ];
    let mut rig = running(Profile::M241_2019, &rows, &[]);
    assert_eq!(words(&rig, READ_TABLE, 4), [0, 0, 1, 3]);
    rig.after(Span::from_millis(600));
    assert_eq!(words(&rig, READ_TABLE, 1), [1]);
    for gone in [
        "TM3_BUS_W.q_wIOBusRestart",
        "PLC_R.i_byFirmVersion[4]",
        "TM3_MODULE_R[14].i_wModuleState",
        "PLC_R.none",
    ] {
        let rig = running(Profile::M241_2014, &[gone], &[]);
        assert_eq!(value_of_row(&rig), Value::Int(-1), "{gone}");
    }
    let rig = running(Profile::M251_2024, &["PLC_R.i_wIOStatus1"], &[]);
    assert_eq!(value_of_row(&rig), Value::Int(-1));
}

fn value_of_row(rig: &Rig) -> Value {
    rig.plc.read(&Probe::Register(RegisterProbe::Address(RelocationPart::Read, 0)))
}

// A register of a clock bit is seen to change as the bit does, whether or not the program mentions it.
#[test]
fn a_register_of_a_clock_bit_follows_it() {
    let mut rig = running(Profile::M241_2019, &["PLC_R.i_x100msClk"], &[]);
    let probe = rig.plc.watch(Probe::Register(RegisterProbe::Value(READ_TABLE)));
    rig.seen.clear();
    rig.after(Span::from_millis(260));
    let changed = |effect: &&Effect| matches!(effect, Effect::Changed { probe: of, .. } if *of == probe);
    assert_eq!(rig.seen.iter().filter(changed).count(), 5);
}

// plcsystem:PLCW-08: the words are 0 after a reset, those of Ethernet and of serial lines as well.
#[test]
fn words_of_clients_show_and_end_with_a_reset() {
    let rows = [
        "ETH_W.q_wResetCounter",
        "SERIAL_W[1].q_wResetCounter",
        "PLC_W.q_wPLCControl",
        "TM3_BUS_W.q_wIOBusErrPassiv",
    ];
    let mut rig = running(Profile::M241_2019, &[], &rows);
    for (place, number) in (0..).zip([1, 2, 8, 1]) {
        write(&mut rig, WRITE_TABLE + place, number);
    }
    assert_eq!(words(&rig, WRITE_TABLE, 4), [1, 2, 8, 1]);
    assert_eq!(value(&rig, EthernetWrite::ResetCounter), Value::Word(1));
    let second = SystemVariable { part: 1, ..SerialWrite::ResetCounter.into() };
    assert_eq!(
        (value(&rig, SerialWrite::ResetCounter), value(&rig, second)),
        (Value::Word(0), Value::Word(2))
    );
    assert_eq!(value(&rig, BusWrite::ErrorPassive), Value::Word(1));
    rig.command(Command::ResetWarm).unwrap();
    rig.after(Span::from_millis(100));
    assert_eq!(words(&rig, WRITE_TABLE, 4), [0; 4]);
    assert_eq!(value(&rig, PlcWrite::PlcControl), Value::Word(0));
}

// plcsystem:GVL-02
#[test]
fn what_is_only_read_stays_as_it_is() {
    let mut rig = running(Profile::M241_2019, &[], &["PLC_R.i_wVendorID", "PLC_R.i_byFirmVersion[0]"]);
    write(&mut rig, WRITE_TABLE, 7);
    write(&mut rig, WRITE_TABLE + 1, 7);
    assert_eq!(words(&rig, WRITE_TABLE, 2), [0x101A, 1]);
    for variable in [SystemVariable::from(PlcRead::VendorId), EthernetRead::IpMode.into()] {
        let probe = Probe::System(variable);
        let cause = Cause::Step(0);
        assert_eq!(
            rig.plc.write(rig.now, &probe, Value::Word(1), cause, &mut rig.fx),
            Err(WriteError::ReadOnly)
        );
    }
}

// plcsystem: 9.7
#[test]
fn the_port_of_the_tool_follows_it() {
    let mut rig = running(Profile::M241_2019, &[], &[]);
    let probe = rig.plc.watch(Probe::System(PlcRead::TerminalPort.into()));
    assert_eq!(rig.system(PlcRead::TerminalPort), 2);
    rig.seen.clear();
    rig.command(Command::LogOut { keep_forcing: true }).unwrap();
    rig.command(Command::LogIn).unwrap();
    let seen = |effect: &Effect| match effect {
        Effect::Changed { probe: of, value, .. } if *of == probe => value.as_int(),
        _ => None,
    };
    assert_eq!(rig.seen.iter().filter_map(seen).collect::<Vec<_>>(), [0, 2]);
}

// The bytes that are free are looked for where a file was written, and nowhere else.
#[test]
fn free_bytes_follow_the_files() {
    let mut rig = running(Profile::M241_2019, &[], &[]);
    let before = rig.system(PlcRead::FreeBytes);
    rig.plc.put_file(rig.now, "/usr/Cfg/any.bin", &[1; 1000], FileUser::Service, &mut rig.fx).unwrap();
    let free = rig.system(PlcRead::FreeBytes);
    assert!(free <= before - 1000, "{before} {free}");
    rig.plc.remove_file(rig.now, "/usr/Cfg/any.bin", FileUser::Service, &mut rig.fx).unwrap();
    assert!(rig.system(PlcRead::FreeBytes) > free);
}
