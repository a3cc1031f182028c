//! Addresses of lists of modules: the rows that the documents have, and every module alone on each kind of controller.

use profile::{ConfiguredModule, ImageFull, ModuleAddresses, ModuleFamily, ModuleKind, Reference};
use signal::{Area, Size};

fn configured(reference: &str) -> ConfiguredModule<'static> {
    ConfiguredModule::new(scanrig_catalogue::find(reference).unwrap_or_else(|| panic!("no {reference}")))
}

fn addresses(controller: &str, modules: &str) -> Vec<ModuleAddresses> {
    let list: Vec<_> = modules.split_whitespace().map(configured).collect();
    Reference::find(controller).unwrap().module_addresses(&list).unwrap()
}

/// All addresses of a module in a line.
fn shown(of: &ModuleAddresses) -> String {
    let status = of.status.map(|status| format!("st {status}"));
    let inputs = [of.digital_inputs, of.analogue_inputs].map(|one| one.map(|one| one.to_string()));
    let outputs = [of.digital_outputs, of.analogue_outputs].map(|one| one.map(|one| one.to_string()));
    inputs.into_iter().chain([status]).chain(outputs).flatten().collect::<Vec<_>>().join(" ")
}

fn lines(controller: &str, modules: &str) -> Vec<String> {
    addresses(controller, modules).iter().map(shown).collect()
}

// io:ADR-05: input 12 of the second module is %IX3.4, the third has its outputs at %QX1.0, the fourth its inputs at %IX4.0.
#[test]
fn the_sample_of_an_m251_comes_out() {
    let found = addresses("TM251MESE", "TM3DM8R TM3DI16 TM3DQ8T TM3DI8");
    let text = |of: Option<profile::ChannelAddresses>, channel| of.unwrap().get(channel).unwrap().to_string();
    assert_eq!(text(found[1].digital_inputs, 12), "%IX3.4");
    assert_eq!(text(found[1].digital_inputs, 0), "%IX2.0");
    assert_eq!(text(found[2].digital_outputs, 0), "%QX1.0");
    assert_eq!(text(found[2].digital_outputs, 7), "%QX1.7");
    assert_eq!(text(found[3].digital_inputs, 0), "%IX4.0");
    assert_eq!(text(found[3].digital_inputs, 7), "%IX4.7");
    assert_eq!(found[3].digital_inputs.unwrap().get(8), None);
}

// io:ADR-01: 16 outputs after the embedded I/O are %QX4.0 to %QX5.7; byte 3 stays unused.
#[test]
fn the_sample_of_an_m241_comes_out() {
    assert_eq!(lines("TM241CEC24T", "TM3DQ16T"), ["%QX4.0..%QX5.7"]);
}

/// Each module alone, with status bytes: on an M251, an M241 of 24 channels, an M241 of 40 channels (io:ADR-01, io:ADR-02,
/// io:ADR-05; the place of the status bytes is a rig definition). A reference with spring terminals is its other one.
const ALONE: &[(&str, [&str; 3])] = &[
    (
        "TM3DQ8R TM3DQ8T TM3DQ8U TM2DRA8RT TM2DDO8UT TM2DDO8TT",
        ["%QX0.0..%QX0.7", "%QX3.0..%QX3.7", "%QX3.0..%QX3.7"],
    ),
    (
        "TM3DQ16R TM3DQ16T TM3DQ16U TM3DQ16TK TM3DQ16UK TM2DRA16RT TM2DDO16UK TM2DDO16TK",
        ["%QX0.0..%QX1.7", "%QX4.0..%QX5.7", "%QX4.0..%QX5.7"],
    ),
    ("TM3DQ32TK TM3DQ32UK TM2DDO32UK TM2DDO32TK", ["%QX0.0..%QX3.7", "%QX4.0..%QX7.7", "%QX4.0..%QX7.7"]),
    (
        "TM3DM8R TM2DMM8DRT",
        ["%IX0.0..%IX0.3 %QX0.0..%QX0.3", "%IX3.0..%IX3.3 %QX3.0..%QX3.3", "%IX4.0..%IX4.3 %QX3.0..%QX3.3"],
    ),
    ("TM3DI8A TM3DI8 TM2DAI8DT TM2DDI8DT", ["%IX0.0..%IX0.7", "%IX3.0..%IX3.7", "%IX4.0..%IX4.7"]),
    (
        "TM3DM16R",
        ["%IX0.0..%IX0.7 %QX0.0..%QX0.7", "%IX3.0..%IX3.7 %QX3.0..%QX3.7", "%IX4.0..%IX4.7 %QX3.0..%QX3.7"],
    ),
    ("TM3DI16 TM3DI16K TM2DDI16DT TM2DDI16DK", ["%IX0.0..%IX1.7", "%IX4.0..%IX5.7", "%IX4.0..%IX5.7"]),
    (
        "TM3DM24R TM2DMM24DRF",
        ["%IX0.0..%IX1.7 %QX0.0..%QX0.7", "%IX4.0..%IX5.7 %QX3.0..%QX3.7", "%IX4.0..%IX5.7 %QX3.0..%QX3.7"],
    ),
    (
        "TM3DM32R",
        ["%IX0.0..%IX1.7 %QX0.0..%QX1.7", "%IX4.0..%IX5.7 %QX4.0..%QX5.7", "%IX4.0..%IX5.7 %QX4.0..%QX5.7"],
    ),
    ("TM3DI32K TM2DDI32DK", ["%IX0.0..%IX3.7", "%IX4.0..%IX7.7", "%IX4.0..%IX7.7"]),
    ("TM2AMO1HT", ["st %IB0 %QW0", "st %IB3 %QW2", "st %IB4 %QW2"]),
    (
        "TM3AQ2 TM2AVO2HT",
        ["st %IB0..%IB1 %QW0..%QW1", "st %IB3..%IB4 %QW2..%QW3", "st %IB4..%IB5 %QW2..%QW3"],
    ),
    ("TM3AQ4", ["st %IB0..%IB3 %QW0..%QW3", "st %IB3..%IB6 %QW2..%QW5", "st %IB4..%IB7 %QW2..%QW5"]),
    (
        "TM3AI2H TM2AMI2HT TM2AMI2LT",
        ["%IW0..%IW1 st %IB4..%IB5", "%IW2..%IW3 st %IB8..%IB9", "%IW2..%IW3 st %IB8..%IB9"],
    ),
    (
        "TM3TM3 TM2AMM3HT TM2ALM3LT",
        ["%IW0..%IW1 st %IB4..%IB6 %QW0", "%IW2..%IW3 st %IB8..%IB10 %QW2", "%IW2..%IW3 st %IB8..%IB10 %QW2"],
    ),
    (
        "TM3AI4 TM3TI4 TM3TI4D TM2AMI4LT",
        ["%IW0..%IW3 st %IB8..%IB11", "%IW2..%IW5 st %IB12..%IB15", "%IW2..%IW5 st %IB12..%IB15"],
    ),
    (
        "TM3AM6 TM2AMM6HT",
        [
            "%IW0..%IW3 st %IB8..%IB13 %QW0..%QW1",
            "%IW2..%IW5 st %IB12..%IB17 %QW2..%QW3",
            "%IW2..%IW5 st %IB12..%IB17 %QW2..%QW3",
        ],
    ),
    (
        "TM3AI8 TM3TI8T TM2AMI8HT TM2ARI8HT TM2ARI8LRJ TM2ARI8LT",
        ["%IW0..%IW7 st %IB16..%IB23", "%IW2..%IW9 st %IB20..%IB27", "%IW2..%IW9 st %IB20..%IB27"],
    ),
];

#[test]
fn each_module_alone_is_where_the_table_says() {
    let mut seen = Vec::new();
    for (references, expected) in ALONE {
        for reference in references.split(' ') {
            for (controller, expected) in ["TM251MESC", "TM241CE24R", "TM241C40T"].into_iter().zip(expected) {
                assert_eq!(lines(controller, reference), [*expected], "{reference} on {controller}");
            }
            seen.push(reference);
        }
    }
    // Every digital and analogue module of the bus is in the table.
    let modules = scanrig_catalogue::modules().iter();
    let modules = modules.filter(|module| {
        module.is_on_bus() && matches!(module.kind, ModuleKind::Digital | ModuleKind::Analogue)
    });
    let missing: Vec<_> = modules
        .map(|module| module.reference.trim_end_matches('G'))
        .filter(|reference| !seen.contains(reference))
        .collect();
    assert_eq!(missing, Vec::<&str>::new());
}

#[test]
fn a_list_is_laid_out_in_its_order_and_the_images_apart() {
    let found = lines("TM241CEC24T", "TM3DI16 TM3DQ16T TM3AI4 TM3AQ2 TM3AM6 TM3DI8 TM3DQ8R");
    let expected = [
        "%IX4.0..%IX5.7",
        "%QX4.0..%QX5.7",
        "%IW3..%IW6 st %IB14..%IB17",
        "st %IB18..%IB19 %QW3..%QW4",
        "%IW10..%IW13 st %IB28..%IB33 %QW5..%QW6",
        "%IX34.0..%IX34.7",
        "%QX14.0..%QX14.7",
    ];
    assert_eq!(found, expected);
}

#[test]
fn cartridges_come_first_and_links_and_tm4_take_nothing() {
    let found = lines("TM241C40T", "TM3DI8 TM4ES4 TM3XTRA1 TM3XREC1 TM3AI2H TMC4AI2");
    assert_eq!(
        found,
        ["%IX10.0..%IX10.7", "", "", "", "%IW6..%IW7 st %IB16..%IB17", "%IW2..%IW3 st %IB8..%IB9"]
    );
}

#[test]
fn without_status_bytes_the_addresses_close_up() {
    let mut list = [configured("TM3AI4"), configured("TM3AI4")];
    list[0].status_enabled = false;
    let found = Reference::find("TM251MESC").unwrap().module_addresses(&list).unwrap();
    assert_eq!(found.iter().map(shown).collect::<Vec<_>>(), ["%IW0..%IW3", "%IW4..%IW7 st %IB16..%IB19"]);
}

// io:ADR-06. No list of 14 modules reaches the end.
#[test]
fn a_list_beyond_the_image_names_the_module_that_does_not_fit() {
    let controller = Reference::find("TM251MESC").unwrap();
    let inputs = vec![configured("TM3AI8"); 22];
    assert_eq!(controller.module_addresses(&inputs), Err(ImageFull { place: 21, area: Area::Input }));
    assert!(controller.module_addresses(&inputs[..21]).is_ok());
    let outputs = vec![configured("TM3DQ32TK"); 129];
    let full = controller.module_addresses(&outputs).unwrap_err();
    assert_eq!(full, ImageFull { place: 128, area: Area::Output });
    assert_eq!(full.to_string(), "module 129 of the list does not fit into %Q, which has 4096 bits");
    for controller in ["TM251MESC", "TM241C40T"] {
        for module in scanrig_catalogue::modules() {
            let list = vec![ConfiguredModule::new(module); 14];
            assert!(
                Reference::find(controller).unwrap().module_addresses(&list).is_ok(),
                "{}",
                module.reference
            );
        }
    }
}

// Two channels never share a place, whatever is configured.
#[test]
fn no_two_channels_overlap() {
    let modules: Vec<_> = scanrig_catalogue::modules().iter().map(ConfiguredModule::new).collect();
    for controller in ["TM251MESC", "TM241C24T", "TM241C40T"] {
        let controller = Reference::find(controller).unwrap();
        for start in 0..modules.len() {
            let list: Vec<_> =
                (0..14).map(|step| modules[(start + step * 5) % modules.len()].clone()).collect();
            let found = controller.module_addresses(&list).unwrap();
            let all = found.iter().flat_map(|of| {
                [of.digital_inputs, of.analogue_inputs, of.status, of.digital_outputs, of.analogue_outputs]
            });
            let all: Vec<_> = all.flatten().flat_map(|channels| channels.iter()).collect();
            for (place, one) in all.iter().enumerate() {
                assert!(all[..place].iter().all(|other| !one.overlaps(other)), "{one}");
                // Beyond the embedded I/O.
                let first = match (controller.input_count(), one.area()) {
                    (0, _) => 0,
                    (24, Area::Input) => 32,
                    _ => 24,
                };
                assert!(one.bit_offset() >= first, "{one}");
                assert!(one.size() != Size::Word || one.bit_offset() % 16 == 0);
            }
        }
    }
    assert!(modules.iter().any(|one| one.module.family == ModuleFamily::Tmc4));
}
