//! The table of inputs and outputs.

use crate::bench::{Bench, LOOK, SMALL};
use crate::sample;
use control::{Ask, Value, WireValue};
use ratatui::crossterm::event::KeyCode;

fn bench() -> Bench {
    Bench::new(sample::rig(), SMALL, LOOK)
}

const ON: WireValue = WireValue(Value::Bool(true));
const OFF: WireValue = WireValue(Value::Bool(false));

/// The row that begins with this name.
fn row(bench: &mut Bench, name: &str) -> String {
    let screen = bench.screen();
    let found = screen.lines().find(|line| line.split_whitespace().take(2).any(|word| word == name));
    found.unwrap_or_else(|| panic!("no {name} in\n{screen}")).to_owned()
}

#[test]
fn a_force_proposes_the_other_value() {
    let mut bench = bench();
    bench.press("f").key(KeyCode::Enter);
    assert_eq!(bench.asked, [Ask::Force { name: "%IX0.0".to_owned(), value: OFF }]);
    assert!(bench.screen().contains("%IX0.0 is forced to FALSE"));
    bench.key(KeyCode::Down).press("f").key(KeyCode::Enter);
    assert_eq!(bench.asked[1], Ask::Force { name: "%IX0.1".to_owned(), value: ON });
    bench.press("f").control('u').enter("maybe");
    assert_eq!(bench.asked.len(), 2);
    assert!(bench.screen().contains("`maybe` is no value here: type TRUE or FALSE, 1 or 0"));
}

#[test]
fn what_is_forced_is_marked_and_can_be_released() {
    let mut bench = bench();
    assert!(row(&mut bench, "I3").starts_with(" F I3"));
    bench.press("r");
    assert!(bench.asked.is_empty() && bench.screen().contains("this is not forced"));
    bench.click("I3").press("r");
    assert_eq!(bench.asked, [Ask::Release { name: "%IX0.3".to_owned() }]);
    bench.press("R").press("y");
    assert_eq!(bench.asked[1], Ask::ReleaseAll);
}

#[test]
fn values_are_written_to_variables_as_they_are() {
    let mut bench = bench();
    bench.press("v/").enter("speed").press("w").control('u').enter("1.5");
    let (name, value) = ("main.speed".to_owned(), WireValue(Value::Real(1.5)));
    assert_eq!(bench.asked, [Ask::Write { name, value }]);
}

#[test]
fn values_edges_and_health_follow_the_rig() {
    let mut bench = bench();
    assert!(row(&mut bench, "I2").contains("37/36"));
    bench.change("%IX0.1", 9_600_000_000, ON);
    bench.change("line-i1", 9_600_000_000, ON);
    bench.rig.status.points[1].rising = 1;
    bench.tell_status();
    let shown = row(&mut bench, "I1");
    assert_eq!(shown.matches("TRUE").count(), 2, "{shown}");
    assert!(shown.contains("1/0"), "{shown}");
    bench.press("/").enter("adc");
    assert!(row(&mut bench, "AI0").starts_with(" ! AI0") && bench.stands_out("! adc"));
    let screen = bench.screen();
    assert!(screen.contains("on adc (spi /dev/spidev0.0): gives no sign of life for 200 ms"), "{screen}");
}

#[test]
fn rows_are_found_and_sorted() {
    let mut bench = bench();
    bench.press("/").enter("output lamp");
    assert!(bench.screen().contains("1 of 26, by order, filter `output lamp`"));
    bench.key(KeyCode::Esc);
    let first = |bench: &mut Bench| {
        let screen = bench.screen();
        let at = screen.lines().position(|line| line.contains("Address")).unwrap() + 1;
        screen.lines().nth(at).unwrap().to_owned()
    };
    bench.click("Edges");
    assert!(first(&mut bench).contains("I2"));
    bench.click("Driver");
    assert!(first(&mut bench).contains("AI0"));
    // Numbers in names count as numbers.
    bench.click("Name").key(KeyCode::Home);
    let screen = bench.screen();
    assert!(screen.find("I2 ").unwrap() < screen.find("I10 ").unwrap(), "{screen}");
}

#[test]
fn an_address_can_be_added_and_one_that_is_unknown_hides_nothing() {
    let mut bench = bench();
    bench.rig.signals.insert("%MW12".to_owned(), (0, WireValue(Value::Int(77))));
    bench.press("a").enter("%MW12");
    assert!(row(&mut bench, "%MW12").contains("77"));
    bench.press("a").enter("%MX99");
    let screen = bench.screen();
    assert!(screen.contains("!! R0600 nothing is called `%MX99`"), "{screen}");
    assert!(row(&mut bench, "%MW12").contains("77") && row(&mut bench, "I0").contains("TRUE"));
    bench.key(KeyCode::Down).press("d");
    assert!(!bench.screen().contains("%MX99"));
}
