//! Writes the example page, to be looked at: `cargo run -p scanrig-reports --example page > page.html`.

#[path = "../tests/fixture/mod.rs"]
mod fixture;

fn main() -> Result<(), scanrig_reports::html::HtmlError> {
    let form = std::env::args().nth(1).unwrap_or_default();
    let run = fixture::example();
    let text = match form.as_str() {
        "junit" => scanrig_reports::junit::render(&run),
        "text" => scanrig_reports::text::render(&run, scanrig_reports::text::Style::default()),
        "json" => run.to_json(),
        "hostile" => scanrig_reports::html::render(&fixture::hostile())?,
        _ => scanrig_reports::html::render(&run)?,
    };
    print!("{text}");
    Ok(())
}
