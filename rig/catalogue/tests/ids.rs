//! The internal ID codes against the table of the documents, typed a second time: reference by reference, not by page.

// io:OPT-04: the table of internal ID codes, in its order.
const TABLE: &[(&str, u8)] = &[
    ("TM2DDI16DT TM2DDI16DK", 0),
    ("TM2DRA16RT TM2DDO16UK TM2DDO16TK", 1),
    ("TM2DDI8DT TM2DAI8DT", 4),
    ("TM2DRA8RT TM2DDO8UT TM2DDO8TT", 5),
    ("TM2DDO32TK TM2DDO32UK", 3),
    ("TM2DMM24DRF TM2DDI32DK", 2),
    ("TM2DMM8DRT", 6),
    ("TM2ALM3LT TM2AMI2HT TM2AMI2LT TM2AMI4LT TM2AMI8HT TM2AMM3HT", 96),
    ("TM2AMM6HT TM2AMO1HT TM2ARI8HT TM2ARI8LRJ TM2ARI8LT TM2AVO2HT", 96),
    ("TM3DI16K TM3DI16 TM3DI16G", 128),
    ("TM3DI8 TM3DI8G TM3DI8A", 132),
    ("TM3DQ16R TM3DQ16RG TM3DQ16T TM3DQ16TG TM3DQ16TK TM3DQ16U TM3DQ16UG TM3DQ16UK", 129),
    ("TM3DQ32TK TM3DQ32UK", 131),
    ("TM3DQ8R TM3DQ8RG TM3DQ8T TM3DQ8TG TM3DQ8U TM3DQ8UG", 133),
    ("TM3DM8R TM3DM8RG", 134),
    ("TM3DM16R", 141),
    ("TM3DM24R TM3DM24RG", 135),
    ("TM3DM32R", 143),
    ("TM3SAK6R TM3SAK6RG", 144),
    ("TM3SAF5R TM3SAF5RG", 145),
    ("TM3SAC5R TM3SAC5RG", 146),
    ("TM3SAFL5R TM3SAFL5RG", 147),
    ("TM3AI2H TM3AI2HG", 192),
    ("TM3AI4 TM3AI4G", 193),
    ("TM3AI8 TM3AI8G", 194),
    ("TM3AQ2 TM3AQ2G", 195),
    ("TM3AQ4 TM3AQ4G", 196),
    ("TM3AM6 TM3AM6G", 197),
    ("TM3TM3 TM3TM3G", 198),
    ("TM3TI4 TM3TI4G", 199),
    ("TM3TI4D TM3TI4DG", 203),
    ("TM3TI8T TM3TI8TG", 200),
    ("TM3DI32K", 130),
    ("TM3XTYS4", 136),
    ("TM3XHSC202 TM3XHSC202G", 217),
];

#[test]
fn every_reference_of_the_table_has_its_code() {
    let mut expected: Vec<(&str, u8)> =
        TABLE.iter().flat_map(|(names, id)| names.split(' ').map(move |name| (name, *id))).collect();
    let mut found: Vec<(&str, u8)> = scanrig_catalogue::modules()
        .iter()
        .filter_map(|one| Some((one.reference.as_str(), one.id?)))
        .collect();
    expected.sort_unstable();
    found.sort_unstable();
    assert_eq!(expected.len(), 87);
    assert_eq!(found, expected);
}

#[test]
fn modules_of_one_code_are_known_to_each_other() {
    let others = |reference: &str| {
        let others = scanrig_catalogue::with_the_same_id(scanrig_catalogue::find(reference).unwrap());
        others.map(|other| other.reference.as_str()).collect::<Vec<_>>()
    };
    assert_eq!(others("TM3DI8"), ["TM3DI8A", "TM3DI8G"]);
    assert_eq!(others("TM2DMM24DRF"), ["TM2DDI32DK"]);
    assert!(others("TM3XTRA1").is_empty() && others("TM4ES4").is_empty());
}
