//! What a list of modules may be. A `?` after a reference makes the module optional; places are counted from 0.

use profile::{
    CompositionError, CompositionFault, ConfiguredModule, ModuleChain, Profile, Reference, check_modules,
    module_indices,
};

fn list(modules: &str) -> Vec<ConfiguredModule<'static>> {
    let one = |name: &str| {
        let module =
            scanrig_catalogue::find(name.trim_end_matches('?')).unwrap_or_else(|| panic!("no {name}"));
        ConfiguredModule { optional: name.ends_with('?'), ..ConfiguredModule::new(module) }
    };
    modules.split_whitespace().map(one).collect()
}

fn on(profile: Profile, controller: &str, modules: &str) -> Result<(), (usize, CompositionFault)> {
    let controller = Reference::find(controller).unwrap();
    check_modules(profile, controller, &list(modules)).map_err(|error| (error.place, error.fault))
}

/// On an M251, and the same on an M241 of 2019.
fn check(modules: &str) -> Result<(), (usize, CompositionFault)> {
    let found = on(Profile::M251_2024, "TM251MESE", modules);
    assert_eq!(on(Profile::M241_2019, "TM241C40T", modules), found, "{modules}");
    found
}

fn times(count: usize, module: &str) -> String {
    format!("{module} ").repeat(count)
}

const LINK: &str = "TM3XTRA1 TM3XREC1 ";

// io:BUS-01
#[test]
fn each_chain_has_its_limit() {
    let full = times(7, "TM3DI8") + "TM3XTRA1 TM3XREC1 " + &times(7, "TM3DQ8R") + &times(3, "TM4ES4");
    assert_eq!(check(&full), Ok(()));
    let too_many = |chain, most| CompositionFault::TooMany { chain, most };
    assert_eq!(check(&times(8, "TM3DI8")), Err((7, too_many(ModuleChain::Local, 7))));
    let tm2 = times(6, "TM3DI8") + &times(2, "TM2DDI8DT");
    assert_eq!(check(&tm2), Err((7, too_many(ModuleChain::Local, 7))));
    let remote = LINK.to_owned() + &times(8, "TM3DI8");
    assert_eq!(check(&remote), Err((9, too_many(ModuleChain::Remote, 7))));
    assert_eq!(check(&times(4, "TM4PDPS1")), Err((3, too_many(ModuleChain::Tm4, 3))));
    assert_eq!(check(""), Ok(()));
}

// io:BUS-04: TM4 modules count for no other chain, wherever they stand.
#[test]
fn tm4_modules_are_a_chain_of_their_own() {
    assert_eq!(check(&(times(3, "TM4ES4") + &times(7, "TM3DI8"))), Ok(()));
    assert_eq!(check("TM2DDI8DT TM4ES4 TM2DDI8DT"), Ok(()));
    assert_eq!(check("TM3XTRA1 TM4ES4 TM3XREC1"), Ok(()));
}

// io:BUS-02
#[test]
fn tm2_modules_are_last() {
    assert_eq!(check("TM3DI8 TM3DQ8R TM2DDI8DT TM2DRA8RT"), Ok(()));
    assert_eq!(
        check("TM3DI8 TM2DDI8DT TM2DRA8RT TM3DQ8R"),
        Err((1, CompositionFault::Tm2BeforeTm3 { tm3: 3 }))
    );
}

// io:BUS-03
#[test]
fn tm2_modules_go_with_no_link() {
    let refused = |tm2, link| Err((tm2, CompositionFault::Tm2WithLink { link }));
    assert_eq!(check("TM3DI8 TM2DDI8DT TM3XTRA1 TM3XREC1"), refused(1, 2));
    assert_eq!(check("TM3XTRA1 TM3XREC1 TM3DI8 TM2DDI8DT"), refused(3, 0));
}

// io:BUS-01: transmitter and receiver are a pair.
#[test]
fn a_link_is_whole() {
    assert_eq!(check("TM3DI8 TM3XTRA1 TM3XREC1"), Ok(()));
    assert_eq!(check("TM3DI8 TM3XTRA1"), Err((1, CompositionFault::NoReceiver)));
    assert_eq!(check("TM3XTRA1 TM3DI8 TM3XREC1"), Err((0, CompositionFault::NoReceiver)));
    assert_eq!(check("TM3XTRA1 TM3XTRA1 TM3XREC1"), Err((0, CompositionFault::NoReceiver)));
    assert_eq!(check("TM3DI8 TM3XREC1"), Err((1, CompositionFault::NoTransmitter)));
    assert_eq!(check("TM3XTRA1 TM3XREC1 TM3XREC1"), Err((2, CompositionFault::SecondLink)));
    assert_eq!(check("TM3XTRA1 TM3XREC1 TM3DI8 TM3XTRA1 TM3XREC1"), Err((3, CompositionFault::SecondLink)));
}

// io:OPT-01, io:CART-02
#[test]
fn only_modules_with_channels_are_optional() {
    assert_eq!(check("TM3DI8? TM3AI4? TM3SAC5R? TM3XTYS4? TM2DDI16DT?"), Ok(()));
    let never = |place| Err((place, CompositionFault::NeverOptional));
    assert_eq!(check("TM3XTRA1? TM3XREC1"), never(0));
    assert_eq!(check("TM3XTRA1 TM3XREC1?"), never(1));
    assert_eq!(check("TM3DI8 TM4ES4?"), never(1));
    assert_eq!(on(Profile::M241_2019, "TM241C24T", "TMC4AI2?"), never(0));
}

// io:OPT-05
#[test]
fn optional_modules_of_one_code_have_a_mandatory_one_between_them() {
    let twin = |place, other, id| Err((place, CompositionFault::OptionalTwin { other, id }));
    assert_eq!(check("TM3DI8? TM3DI8?"), twin(1, 0, 132));
    // It is the code that counts, not the reference.
    assert_eq!(check("TM3DI8? TM3DQ8R? TM3DI8A?"), twin(2, 0, 132));
    assert_eq!(check("TM3DI8? TM3DQ8R TM3DI8A?"), Ok(()));
    assert_eq!(check("TM3DI8? TM3DI8 TM3DI8?"), Ok(()));
    assert_eq!(check("TM3DI8? TM3DI8"), Ok(()));
    assert_eq!(check("TM3DI8? TM3DI16?"), Ok(()));
    // What is on another bus, or has no code, is not between them.
    assert_eq!(check("TM3DI8? TM4ES4 TM3DI8?"), twin(2, 0, 132));
    assert_eq!(check("TM3DI8? TM3XTRA1 TM3XREC1 TM3DI8?"), twin(3, 0, 132));
    assert_eq!(check("TM2AMI2HT? TM2AMO1HT?"), twin(1, 0, 96));
}

// io:CART-01
#[test]
fn cartridges_are_of_an_m241() {
    let m241 = |controller, modules| on(Profile::M241_2019, controller, modules);
    let too_many =
        |place, most| Err((place, CompositionFault::TooMany { chain: ModuleChain::Cartridges, most }));
    assert_eq!(m241("TM241CEC24T", "TMC4AI2"), Ok(()));
    assert_eq!(m241("TM241CEC24T", "TM3DI8 TMC4AI2 TMC4AQ2"), too_many(2, 1));
    assert_eq!(m241("TM241C40R", "TMC4AI2 TMC4AQ2"), Ok(()));
    assert_eq!(m241("TM241C40R", "TMC4AI2 TMC4AQ2 TMC4TI2"), too_many(2, 2));
    let refused = on(Profile::M251_2024, "TM251MESC", "TM3DI8 TMC4AI2");
    assert_eq!(refused, Err((1, CompositionFault::NotOfProfile(Profile::M251_2024))));
}

// io: 10.1
#[test]
fn the_older_profile_knows_no_analogue_and_safety_modules_of_tm3() {
    let older = |modules| on(Profile::M241_2014, "TM241CEC24T", modules);
    let unknown = |place| Err((place, CompositionFault::NotOfProfile(Profile::M241_2014)));
    assert_eq!(older("TM3DI8 TM3XTYS4 TM2AMI2HT"), Ok(()));
    assert_eq!(older("TM3DI8 TM3AI4"), unknown(1));
    assert_eq!(older("TM3SAC5R"), unknown(0));
}

// io: section 12
#[test]
fn the_older_profile_has_no_optional_modules() {
    let refused = CompositionFault::NoOptionalModules(Profile::M241_2014);
    assert_eq!(on(Profile::M241_2014, "TM241CEC24T", "TM3DI8 TM3DI16?"), Err((1, refused)));
}

// io:BUS-05
#[test]
fn indices_are_of_local_modules_and_then_of_remote_ones() {
    let indices = module_indices(&list("TM4ES4 TM3DI8 TM3DQ8R TM3XTRA1 TM3XREC1 TM3AI4 TMC4AI2 TM3AQ2"));
    assert_eq!(indices, [None, Some(0), Some(1), None, None, Some(7), None, Some(8)]);
    let full = times(7, "TM3DI8") + LINK + &times(7, "TM3DI8");
    let indices: Vec<usize> = module_indices(&list(&full)).into_iter().flatten().collect();
    assert_eq!(indices, (0..profile::MODULE_INDICES).collect::<Vec<_>>());
}

#[test]
fn errors_are_sentences_with_places_from_1() {
    let error = CompositionError { place: 1, fault: CompositionFault::OptionalTwin { other: 0, id: 132 } };
    let expected = "module 2 of the list and module 1 are optional and of ID code 132, and no mandatory module is between them";
    assert_eq!(error.to_string(), expected);
    let error = CompositionError {
        place: 7,
        fault: CompositionFault::TooMany { chain: ModuleChain::Local, most: 7 },
    };
    assert_eq!(
        error.to_string(),
        "module 8 of the list is one too many: at most 7 local TM3 and TM2 modules"
    );
}
