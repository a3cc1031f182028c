//! The table of inputs and outputs.

use crate::sample;
use crate::setup::{DashboardSetup, LOOK, SMALL};
use control::{RequestOperation, Value, WireValue};
use ratatui::crossterm::event::KeyCode;

fn setup() -> DashboardSetup {
    DashboardSetup::new(sample::rig(), SMALL, LOOK)
}

const ON: WireValue = WireValue(Value::Bool(true));
const OFF: WireValue = WireValue(Value::Bool(false));

/// The row that begins with this name.
fn row(setup: &mut DashboardSetup, name: &str) -> String {
    let screen = setup.screen();
    let found = screen.lines().find(|line| line.split_whitespace().take(2).any(|word| word == name));
    found.unwrap_or_else(|| panic!("no {name} in\n{screen}")).to_owned()
}

#[test]
fn a_force_proposes_the_other_value() {
    let mut setup = setup();
    setup.press("f").key(KeyCode::Enter);
    assert_eq!(setup.asked, [RequestOperation::Force { name: "%IX0.0".to_owned(), value: OFF }]);
    assert!(setup.screen().contains("%IX0.0 is forced to FALSE"));
    setup.key(KeyCode::Down).press("f").key(KeyCode::Enter);
    assert_eq!(setup.asked[1], RequestOperation::Force { name: "%IX0.1".to_owned(), value: ON });
    setup.press("f").control('u').enter("maybe");
    assert_eq!(setup.asked.len(), 2);
    assert!(setup.screen().contains("`maybe` is not a valid value: type TRUE or FALSE, 1 or 0"));
}

#[test]
fn what_is_forced_is_marked_and_can_be_released() {
    let mut setup = setup();
    assert!(row(&mut setup, "I3").starts_with(" F I3"));
    setup.press("r");
    assert!(setup.asked.is_empty() && setup.screen().contains("this is not forced"));
    setup.click("I3").press("r");
    assert_eq!(setup.asked, [RequestOperation::Release { name: "%IX0.3".to_owned() }]);
    setup.press("R").press("y");
    assert_eq!(setup.asked[1], RequestOperation::ReleaseAll);
}

#[test]
fn values_are_written_to_variables_as_they_are() {
    let mut setup = setup();
    setup.press("v/").enter("speed").press("w").control('u').enter("1.5");
    let (name, value) = ("main.speed".to_owned(), WireValue(Value::Real(1.5)));
    assert_eq!(setup.asked, [RequestOperation::Write { name, value }]);
}

#[test]
fn values_edges_and_health_follow_the_rig() {
    let mut setup = setup();
    assert!(row(&mut setup, "I2").contains("37/36"));
    setup.change("%IX0.1", 9_600_000_000, ON);
    setup.change("line-i1", 9_600_000_000, ON);
    setup.rig.status.points[1].rising = 1;
    setup.report_status();
    let shown = row(&mut setup, "I1");
    assert_eq!(shown.matches("TRUE").count(), 2, "{shown}");
    assert!(shown.contains("1/0"), "{shown}");
    setup.press("/").enter("adc");
    assert!(row(&mut setup, "AI0").starts_with(" ! AI0") && setup.stands_out("! adc"));
    let screen = setup.screen();
    assert!(screen.contains("on adc (spi /dev/spidev0.0): gives no sign of life for 200 ms"), "{screen}");
}

#[test]
fn a_word_of_an_analogue_channel_has_its_unit_and_a_bar() {
    let mut setup = setup();
    setup.press("/").enter("AI0");
    // A word is an INT: this one is below the low end of 0 to 10 V for 0 to 10000.
    for (word, meaning, bar) in
        [(2_500, "2.5 V", "██▎······"), (10_000, "10 V", "█████████"), (0xFFFF, "-0.001 V", "·········")]
    {
        setup.change("%IW10", 9_600_000_000, WireValue(Value::Int(word)));
        let shown = row(&mut setup, "AI0");
        assert!(shown.contains(meaning) && shown.contains(bar), "{shown}");
    }
    assert!(setup.screen().contains("image -1 = -0.001 V"), "{}", setup.screen());
}

#[test]
fn rows_are_found_and_sorted() {
    let mut setup = setup();
    setup.press("/").enter("output lamp");
    assert!(setup.screen().contains("1 of 26, by order, filter `output lamp`"));
    setup.key(KeyCode::Esc);
    let first = |setup: &mut DashboardSetup| {
        let screen = setup.screen();
        let at = screen.lines().position(|line| line.contains("Address")).unwrap() + 1;
        screen.lines().nth(at).unwrap().to_owned()
    };
    setup.click("Edges");
    assert!(first(&mut setup).contains("I2"));
    setup.click("Driver");
    assert!(first(&mut setup).contains("AI0"));
    // Numbers in names count as numbers.
    setup.click("Name").key(KeyCode::Home);
    let screen = setup.screen();
    assert!(screen.find("I2 ").unwrap() < screen.find("I10 ").unwrap(), "{screen}");
}

#[test]
fn an_address_can_be_added_and_one_that_is_unknown_hides_nothing() {
    let mut setup = setup();
    setup.rig.signals.insert("%MW12".to_owned(), (0, WireValue(Value::Int(77))));
    setup.press("a").enter("%MW12");
    assert!(row(&mut setup, "%MW12").contains("77"));
    setup.press("a").enter("%MX99");
    let screen = setup.screen();
    assert!(screen.contains("!! R0600 nothing is called `%MX99`"), "{screen}");
    assert!(row(&mut setup, "%MW12").contains("77") && row(&mut setup, "I0").contains("TRUE"));
    setup.key(KeyCode::Down).press("d");
    assert!(!setup.screen().contains("%MX99"));
}
