//! `rig modules`: the table of a plan's terminals, and what it says where there is none.

use crate::project_folder::TestProject;

const PLAN: &str = r#"format = 1
title = "A valve"
program-text = "PROGRAM MAIN VAR n : INT; END_VAR n := 1; END_PROGRAM"
expect = [{ state = { stays = "RUNNING" } }]
[settings]
modules = [
  { type = "TM3AI4", inputs = [{ mode = "4..20 mA", min = 0, max = 10000 }, "0..10 V"] },
  { type = "TM3TI4", inputs = [{ mode = "PT100", scope = "fahrenheit" }, "thermocouple K"], status = false },
  { type = "TM3DM8R", optional = true },
]
"#;

#[test]
fn the_table_has_every_terminal_with_its_address() {
    let bench = TestProject::new();
    bench.write("valve.toml", PLAN);
    let shown = "valve.toml: TM241CEC24T, 3 of 7 local modules (valve)

terminal           module    index  address           status  mode            unit  words
I0 to I13          embedded         %IX0.0..%IX1.5
status of outputs  embedded         %IX2.0
Q0 to Q9           embedded         %QX0.0..%QX1.1
rearming           embedded         %QX2.0
M1.IW0             TM3AI4    0      %IW2              %IB12   4..20 mA        mA    0 to 10000
M1.IW1             TM3AI4    0      %IW3              %IB13   0..10 V         V     -32768 to 32767
M1.IW2             TM3AI4    0      %IW4              %IB14   not used
M1.IW3             TM3AI4    0      %IW5              %IB15   not used
M2.IW0             TM3TI4    1      %IW8                      PT100           degC  steps of 0.1 degF
M2.IW1             TM3TI4    1      %IW9                      thermocouple K  degC  steps of 0.1 degC
M2.IW2             TM3TI4    1      %IW10                     not used
M2.IW3             TM3TI4    1      %IW11                     not used
M3.I0 to M3.I3     TM3DM8R   2      %IX24.0..%IX24.3
M3.Q0 to M3.Q3     TM3DM8R   2      %QX3.0..%QX3.3

";
    let table = bench.expect(0, &["modules", "valve.toml"]).out;
    assert_eq!(table, shown, "{table}");
    let json: serde_json::Value =
        serde_json::from_str(&bench.expect(0, &["modules", "valve.toml", "--format", "json"]).out).unwrap();
    let row = &json[0]["terminals"][4];
    assert_eq!((row["terminal"].as_str(), row["index"].as_i64()), (Some("M1.IW0"), Some(0)), "{row}");
    assert_eq!((row["address"].as_str(), row["words"].as_str()), (Some("%IW2"), Some("0 to 10000")), "{row}");
}

#[test]
fn cases_of_one_list_share_a_table_and_a_list_that_is_refused_says_why() {
    let bench = TestProject::new();
    let rows = "[rows]\na = { m = \"TM3DI8\" }\nb = { m = \"TM3DI8\" }\nc = { m = \"TM3DI16\" }\n";
    let plan = PLAN.split("[settings]").next().unwrap();
    bench.write("valve.toml", &format!("{plan}settings = {{ modules = [\"$m\"] }}\n{rows}"));
    let table = bench.expect(0, &["modules", "valve.toml"]).out;
    assert_eq!(table.matches("valve.toml: ").count(), 2, "{table}");
    assert!(table.contains("and 1 more)") && table.contains("%IX4.0..%IX5.7"), "{table}");
    bench.write("full.toml", &format!("{plan}settings = {{ modules = [\"TM3XTRA1\"] }}\n"));
    bench.refused(&["modules", "full.toml"], &["R0258"]);
    bench.refused(&["modules"], &["required"]);
}
