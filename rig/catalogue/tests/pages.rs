//! Every page is read without a finding, and what it says goes together.

use profile::{ModuleFamily, ModuleKind, ModuleType, Profile};
use signal::{Decimal, Span};

fn module(reference: &str) -> &'static ModuleType {
    scanrig_catalogue::find(reference).unwrap_or_else(|| panic!("no {reference}"))
}

#[test]
fn no_page_has_a_finding() {
    let (modules, findings) = scanrig_catalogue::read_pages();
    let shown: Vec<String> = findings
        .iter()
        .map(|(file, found)| {
            let place = found.labels.first().map(|label| document::line_col(&file.text, label.span.start));
            format!("{} {place:?}: {}: {}", file.name, found.message, found.help)
        })
        .collect();
    assert!(shown.is_empty(), "{}", shown.join("\n"));
    assert_eq!(modules, scanrig_catalogue::modules());
    // 62 references with an ID and the 25 of them with spring terminals, the link, TM4, cartridges.
    assert_eq!(modules.len(), 87 + 2 + 2 + 5);
}

#[test]
fn references_are_unique_and_found_in_any_case() {
    for (place, module) in scanrig_catalogue::modules().iter().enumerate() {
        assert_eq!(scanrig_catalogue::find(&module.reference.to_lowercase()), Some(module));
        assert!(
            scanrig_catalogue::modules()[..place].iter().all(|other| other.reference != module.reference)
        );
    }
    assert_eq!(scanrig_catalogue::find("TM3AI5"), None);
}

// io: 10.3, 10.4
#[test]
fn what_a_page_says_goes_together() {
    for module in scanrig_catalogue::modules() {
        let name = &module.reference;
        assert_eq!(module.id.is_some(), module.is_on_bus(), "{name}");
        assert!(!module.profiles.is_empty(), "{name}");
        let (digital, analogue) = (
            module.digital_input_count() + module.digital_output_count(),
            module.analogue_input_count() + module.analogue_output_count(),
        );
        match module.kind {
            ModuleKind::Digital => assert!(digital > 0 && analogue == 0, "{name}"),
            ModuleKind::Analogue => assert!(digital == 0 && analogue > 0, "{name}"),
            ModuleKind::Safety => assert!(module.safety.is_some() && analogue == 0, "{name}"),
            ModuleKind::Expert => assert!(analogue == 0, "{name}"),
            ModuleKind::Communication | ModuleKind::Transmitter | ModuleKind::Receiver => {
                assert!(digital == 0 && analogue == 0, "{name}");
            }
        }
        for mode in [&module.analogue_inputs, &module.analogue_outputs]
            .into_iter()
            .flatten()
            .flat_map(|one| &one.modes)
        {
            let ends = [mode.under_range, mode.low, mode.high, mode.over_range];
            let ends: Vec<Decimal> = ends.into_iter().flatten().collect();
            assert!(ends.is_sorted_by(|a, b| a < b), "{name}: {}", mode.name);
        }
    }
}

// io: 10.1, io:CART-01
#[test]
fn profiles_know_the_families_that_their_document_lists() {
    for module in scanrig_catalogue::modules() {
        let newer = module.family == ModuleFamily::Tm3
            && matches!(module.kind, ModuleKind::Analogue | ModuleKind::Safety);
        let expected: &[Profile] = match module.family {
            ModuleFamily::Tmc4 => &[Profile::M241_2014, Profile::M241_2019],
            _ if newer => &[Profile::M241_2019, Profile::M251_2024],
            _ => &Profile::ALL,
        };
        assert_eq!(module.profiles, expected, "{}", module.reference);
    }
}

// io: 10.3
#[test]
fn the_name_of_a_digital_module_says_what_it_has() {
    for module in scanrig_catalogue::modules().iter().filter(|module| module.kind == ModuleKind::Digital) {
        let digits = module.reference[3..].chars().filter(char::is_ascii_digit).collect::<String>();
        let count: u32 = digits.parse().unwrap();
        assert_eq!(
            module.digital_input_count() + module.digital_output_count(),
            count,
            "{}",
            module.reference
        );
    }
}

#[test]
fn a_module_with_spring_terminals_is_the_same_module() {
    let spring: Vec<_> =
        scanrig_catalogue::modules().iter().filter(|module| module.reference.ends_with('G')).collect();
    assert_eq!(spring.len(), 25);
    for of in spring {
        let screw = module(of.reference.trim_end_matches('G'));
        assert!(of.terminals.as_ref().unwrap().contains("spring"), "{}", of.reference);
        let same =
            ModuleType { reference: of.reference.clone(), terminals: of.terminals.clone(), ..screw.clone() };
        assert_eq!(&same, of);
    }
}

// io: 10.3: resolution and modes
#[test]
fn an_analogue_module_has_its_modes_with_exact_ends() {
    let inputs = module("TM3AI4").analogue_inputs.as_ref().unwrap();
    assert_eq!((inputs.count, inputs.bits, inputs.modes.len()), (4, Some(12), 4));
    let mode = inputs.mode("4..20 mA").unwrap();
    assert_eq!((mode.low, mode.high), (Some(Decimal::from(4)), Some(Decimal::from(20))));
    assert_eq!(
        (mode.under_range, mode.over_range),
        (Some(Decimal::new(368, -2)), Some(Decimal::new(2032, -2)))
    );
    assert!(mode.sources.iter().any(|one| one.figure == "under-range"));
    let inputs = module("TM3TM3").analogue_inputs.as_ref().unwrap();
    assert_eq!(inputs.modes.len(), 4 + 9 + 4);
    let per_channel = &inputs.conversion.as_ref().unwrap().per_channel;
    assert_eq!(per_channel, &[Span::from_millis(100), Span::from_millis(10)]);
    assert_eq!(module("TM3TM3").analogue_outputs.as_ref().unwrap().bits, Some(12));
    assert_eq!(module("TM3AM6").status_bytes(), 6);
}

#[test]
fn a_figure_without_a_source_is_from_the_documents() {
    let relay = module("TM3DQ8R");
    assert_eq!(relay.source("id"), None);
    assert_eq!(relay.source("firmware"), Some("rig definition"));
    assert!(relay.source("digital-outputs.on-delay").unwrap().contains("product help"));
    // A source of the page counts where the module has the figure.
    assert!(relay.sources.iter().all(|one| !one.figure.starts_with("digital-inputs")));
    assert!(module("TM3DQ8TG").source("digital-outputs.on-delay").unwrap().contains("data sheet"));
    assert_eq!(module("TMC4AI2").source("analogue-inputs"), Some("rig definition"));
}
