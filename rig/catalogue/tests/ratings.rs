//! Ratings, kinds, resolution and modes against the tables of the hardware guide, typed a second time (io: 10.3, 10.4).

use profile::{AnalogueChannels, ModuleKind, ModuleType};
use signal::Quantity;

/// References without spring terminals; what their inputs and outputs are: `kind voltage most of an output/most of a common
/// line`.
const DIGITAL: &[(&str, &str, &str)] = &[
    ("TM3DI8A TM2DAI8DT", "120 Vac 7.5 mA", ""),
    ("TM3DI8 TM3DI16 TM2DDI8DT TM2DDI16DT", "24 Vdc 7 mA", ""),
    ("TM3DI16K TM3DI32K TM2DDI16DK TM2DDI32DK", "24 Vdc 5 mA", ""),
    ("TM3DQ8R", "", "relay 24 Vdc / 240 Vac 2 A/7 A"),
    ("TM3DQ16R", "", "relay 24 Vdc / 240 Vac 2 A/8 A"),
    ("TM3DQ8T", "", "source 24 Vdc 0.5 A/4 A"),
    ("TM3DQ8U", "", "sink 24 Vdc 0.5 A/4 A"),
    ("TM3DQ16T", "", "source 24 Vdc 0.5 A/8 A"),
    ("TM3DQ16U", "", "sink 24 Vdc 0.5 A/8 A"),
    ("TM3DQ16TK TM3DQ32TK", "", "source 24 Vdc 0.1 A/2 A"),
    ("TM3DQ16UK TM3DQ32UK", "", "sink 24 Vdc 0.1 A/2 A"),
    ("TM3DM8R TM3DM24R TM2DMM8DRT TM2DMM24DRF", "24 Vdc 7 mA", "relay 24 Vdc / 240 Vac 2 A/7 A"),
    ("TM3DM16R TM3DM32R", "24 Vdc 5 mA", "relay 24 Vdc / 240 Vac 2 A/4 A"),
    ("TM2DRA8RT TM2DRA16RT", "", "relay 30 Vdc / 240 Vac 2 A/"),
    ("TM2DDO8UT", "", "sink 24 Vdc 0.3 A/"),
    ("TM2DDO8TT", "", "source 24 Vdc 0.5 A/"),
    ("TM2DDO16UK TM2DDO32UK", "", "sink 24 Vdc 0.1 A/"),
    ("TM2DDO16TK TM2DDO32TK", "", "source 24 Vdc 0.4 A/"),
];

/// The four modes that most modules have.
const FOUR: &str = "0..10 V, -10..10 V, 0..20 mA, 4..20 mA";

/// References without spring terminals; bits and modes of inputs and of outputs.
const ANALOGUE: &[(&str, &str, &str)] = &[
    ("TM3AI2H", "16 bit: FOUR", ""),
    ("TM3AI4", "12 bit: FOUR", ""),
    ("TM3AI8", "12 bit: FOUR, 0..20 mA extended, 4..20 mA extended", ""),
    ("TM3TI4", "16 bit: FOUR, thermocouple, PT100, PT1000, NI100, NI1000", ""),
    ("TM3TI4D", "16 bit: thermocouple", ""),
    ("TM3TI8T", "16 bit: thermocouple, NTC, PTC, ohmmeter", ""),
    ("TM3AQ2 TM3AQ4", "", "12 bit: FOUR"),
    ("TM3AM6", "12 bit: FOUR", "12 bit: FOUR"),
    ("TM3TM3", "16 bit: FOUR, thermocouple, PT100, PT1000, NI100, NI1000", "12 bit: FOUR"),
    ("TM2AMI2HT", "0..10 V, 4..20 mA", ""),
    ("TM2AMI2LT", "thermocouple J, thermocouple K, thermocouple T", ""),
    ("TM2AMI4LT", "0..10 V, 0..20 mA, PT100, PT1000, NI100, NI1000", ""),
    ("TM2AMI8HT", "0..10 V, 0..20 mA", ""),
    ("TM2ARI8HT", "NTC, PTC", ""),
    ("TM2ARI8LRJ TM2ARI8LT", "PT100, PT1000", ""),
    ("TM2AMO1HT", "", "0..10 V, 4..20 mA"),
    ("TM2AVO2HT", "", "-10..10 V"),
    ("TM2AMM3HT TM2AMM6HT", "0..10 V, 4..20 mA", "0..10 V, 4..20 mA"),
    ("TM2ALM3LT", "thermocouple J, thermocouple K, thermocouple T, PT100", "0..10 V, 4..20 mA"),
];

/// Compares each row with what `shown` makes of its modules; every module of the kind on the bus has a row.
fn compare(rows: &[(&str, &str, &str)], kind: ModuleKind, shown: impl Fn(&ModuleType) -> [String; 2]) {
    let mut seen = 0;
    for (references, inputs, outputs) in rows {
        for reference in references.split(' ') {
            let module = scanrig_catalogue::find(reference).unwrap();
            let expected = [inputs, outputs].map(|text| text.replace("FOUR", FOUR));
            assert_eq!(shown(module), expected, "{reference}");
            seen += 1;
        }
    }
    let all = scanrig_catalogue::modules().iter().filter(|one| one.kind == kind && one.is_on_bus());
    assert_eq!(all.filter(|one| !one.reference.ends_with('G')).count(), seen);
}

#[test]
fn digital_channels_have_the_ratings_of_the_tables() {
    let current = |most: &Option<Quantity>| {
        most.as_ref().map_or(String::new(), |most| format!("{} {}", most.number, most.unit))
    };
    compare(DIGITAL, ModuleKind::Digital, |module| {
        let inputs = module.digital_inputs.as_ref().and_then(|inputs| inputs.rating.clone());
        let outputs = module.digital_outputs.as_ref().map(|outputs| {
            let (kind, rating) = (outputs.kind.unwrap().name(), outputs.rating.as_ref().unwrap());
            let (output, common) = (current(&outputs.output_current), current(&outputs.common_current));
            format!("{kind} {rating} {output}/{common}")
        });
        [inputs.unwrap_or_default(), outputs.unwrap_or_default()]
    });
}

#[test]
fn analogue_channels_have_the_resolution_and_modes_of_the_tables() {
    let channels = |channels: &Option<AnalogueChannels>| {
        let Some(channels) = channels else { return String::new() };
        let bits = channels.bits.map_or(String::new(), |bits| format!("{bits} bit: "));
        let mut modes: Vec<&str> = Vec::new();
        for mode in &channels.modes {
            // Of a module of TM3 the tables say "thermocouple", of which there are nine types.
            let plain = if bits.is_empty() { &mode.name } else { mode.name.split(" J").next().unwrap() };
            if bits.is_empty() || !mode.name.starts_with("thermocouple") || mode.name.ends_with(" J") {
                modes.push(plain);
            }
        }
        bits + &modes.join(", ")
    };
    compare(ANALOGUE, ModuleKind::Analogue, |module| {
        [channels(&module.analogue_inputs), channels(&module.analogue_outputs)]
    });
}
