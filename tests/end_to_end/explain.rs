//! Every code has a page, and every example of a page provokes its code.

use crate::project_folder::{LAMP, TestProject, root};

/// Codes without an example, and why.
const WITHOUT_EXAMPLE: &[(&str, &str)] = &[
    ("P0003", "a file of over 1 MiB"),
    ("P0208", "over 10 000 steps"),
    ("P0505", "a trace of another plan"),
    ("P0507", "over 10 000 claims"),
    ("P0607", "a second file"),
    ("P0644", "a table with a fault in its rows"),
    ("P0645", "a table with columns of another plan"),
    ("P0674", "a DBC file"),
    ("P0676", "a DBC file"),
    ("B0003", "a file of over 1 MiB"),
    ("B0125", "a day that has passed"),
    ("B0127", "a machine that lacks something"),
    ("B0128", "a machine that lacks something"),
    ("B0129", "a machine that lacks something"),
    ("B0130", "a machine that lacks a converter"),
    ("B0131", "two converters of one name"),
    ("B0132", "a converter that lacks an input"),
    ("B0133", "a converter that somebody holds"),
    ("B0134", "a machine with a converter"),
    ("B0135", "a converter that refuses something"),
    ("B0136", "a converter without a buffer"),
    ("B0137", "a converter that may not be used"),
    ("B0144", "a machine that lacks something"),
    ("B0145", "a second user of a port"),
    ("B0146", "a port that may not be opened"),
    ("B0147", "a machine that has the device"),
    ("B0148", "a port that cannot do something"),
    ("B0149", "a device that fails"),
    ("B0154", "a machine without an interface"),
    ("B0155", "an interface that is down"),
    ("B0156", "an interface that is set up"),
    ("B0157", "an interface that the kernel refuses"),
    ("B0158", "a rig without the privilege"),
    ("B0159", "a controller that lacks something"),
    ("B0166", "over 64 lines"),
    ("B017", "a machine that lacks something"),
    ("B0204", "over 4 096 parts"),
    ("B0208", "a machine that lacks a counter"),
    ("B0209", "two counters of one name"),
    ("B0210", "a machine with a counter"),
    ("B0211", "a machine with a counter"),
    ("B0212", "a machine with a counter"),
    ("B0213", "a machine with a counter"),
    ("B0214", "a machine with a counter"),
    ("B023", "a machine that lacks something"),
    ("B0312", "a plan with modules"),
    ("S0107", "64 brackets"),
    ("S0501", "4 MiB of sources"),
    ("S0504", "a chain of 64 blocks"),
    ("S0505", "1 000 000 operations"),
    ("S0506", "50 errors"),
    ("R0101", "two names that differ only in a trace"),
    ("R0111", "an analog channel of a board"),
    ("R0121", "a second program with other tasks"),
    ("R0140", "a question of a plan that another example would need without"),
    ("R0149", "a board of another profile"),
    ("R0162", "two runs"),
    ("R0163", "two runs"),
    ("R0164", "two runs"),
    ("R0166", "a run whose traces are lost"),
    ("R0167", "a folder that nobody may write to"),
    ("R0169", "a history that another command uses"),
    ("R0179", "a capture of another instrument"),
    ("R0300", "a board file with a count"),
    ("R0301", "a board file with a count"),
    ("R019", "real lines"),
    ("R018", "a machine that refuses something, or one with real lines"),
    ("R0203", "a trace of another plan"),
    ("R0205", "a file beside the plan"),
    ("R0206", "a folder that several users write to"),
    ("R021", "a capture with an instrument file"),
    ("R0220", "a temporary folder without room"),
    ("R0221", "a second board"),
    ("R0223", "a board file beside the plan"),
    ("R0224", "real lines"),
    ("R0226", "a variable of the environment"),
    ("R0262", "fourteen modules do not fill the images"),
    ("R0230", "a folder beside the plan"),
    ("R0231", "a case that does not apply"),
    ("R0232", "a full disk"),
    ("R0233", "a plan that is given twice"),
    ("R0240", "a machine without lines"),
    ("R0241", "a chip that may not be opened"),
    ("R0242", "a machine with lines"),
    ("R0244", "a device that fails"),
    ("R0251", "a home that nobody may write to"),
    ("R0252", "figures of another machine"),
    ("R0253", "the file of a board"),
    ("R0254", "a machine with real lines"),
    ("R0255", "a machine with real lines"),
    ("R0270", "a board file beside the plan"),
    ("R0271", "a board file and a plan"),
    ("R0272", "a board file beside the plan"),
    ("R0305", "a board with a generator"),
    ("R0306", "a board with a generator"),
    ("R0307", "a board with a generator"),
    ("R0308", "a board with a generator"),
    ("R0309", "a board with real lines"),
    ("R0310", "a board with a generator"),
    ("R0315", "a board file beside the plan"),
    ("R0316", "a machine with real lines"),
    ("R0267", "a board that drives a terminal"),
    ("R0331", "a board with a plant"),
    ("R0332", "a board with a plant"),
    ("R0333", "a board with a plant"),
    ("R0334", "a plant that fails while it runs"),
    ("R034", "a service manager"),
    ("R04", "records that somebody edited"),
    ("R062", "a client of a rig that runs"),
    ("R063", "a rig that runs"),
    ("R028", "another user, or a machine that lacks something"),
    ("R060", "a client of a rig that runs, or real lines"),
    ("R061", "a client of a rig that runs"),
    ("R0640", "a machine without a rig"),
    ("R0641", "two rigs"),
    ("R0643", "a socket of something else"),
    ("R0644", "a rig of another release"),
    ("R0645", "a rig that dies"),
    ("R0646", "a rig that ends"),
    ("R0647", "a rig that stands still"),
    ("R0648", "a rig of another release"),
    ("R0649", "a rig"),
    ("R0661", "a machine that lacks something"),
    ("R068", "a dashboard on a terminal"),
];

/// A block of a page.
#[derive(Debug)]
struct ExampleBlock {
    code: String,
    language: String,
    role: String,
    text: String,
}

/// The examples of all pages, in order.
fn blocks() -> Vec<ExampleBlock> {
    let mut blocks = Vec::new();
    for letter in ["P", "B", "S", "R"] {
        let path = root().join(format!("docs/codes/{letter}.md"));
        let text = std::fs::read_to_string(path).unwrap();
        let (mut code, mut open): (String, Option<ExampleBlock>) = (String::new(), None);
        for line in text.lines() {
            match (&mut open, line.strip_prefix("```")) {
                (Some(_), Some(_)) => blocks.extend(open.take()),
                (Some(block), None) => block.text += &format!("{line}\n"),
                (None, Some(info)) => {
                    let (language, role) = info.split_once(' ').unwrap();
                    let (code, language, role) = (code.clone(), language.to_owned(), role.to_owned());
                    open = Some(ExampleBlock { code, language, role, text: String::new() });
                }
                (None, None) => {
                    if let Some(heading) = line.strip_prefix("## ") {
                        heading.clone_into(&mut code);
                    }
                }
            }
        }
    }
    blocks
}

/// The plan of the lamp with these keys in place of its own; a part of several lines that says its format is whole.
fn plan(part: &str) -> String {
    if part.starts_with("format") && part.lines().count() > 1 {
        return part.to_owned();
    }
    let key =
        |line: &str| line.split([' ', ']']).next().unwrap_or_default().trim_start_matches('[').to_owned();
    let given: Vec<String> = part.lines().map(key).collect();
    let mut plan = String::new();
    let mut kept = true;
    for line in LAMP.lines() {
        if !line.starts_with([' ', ']']) {
            let key = key(line);
            let program = key == "program" && given.iter().any(|key| key == "program-text");
            kept = !program && !given.contains(&key);
        }
        if kept {
            plan += &format!("{line}\n");
        }
    }
    plan + part
}

/// A board file with what every one has.
fn board(part: &str) -> String {
    let format = if part.starts_with("format") { "" } else { "format = 1\n" };
    let board = part.starts_with("board") || part.contains("[board]");
    format!("{format}{part}{}", if board { "" } else { "[board]\nkind = \"simulated\"\n" })
}

/// A program with what every one has.
fn program(part: &str, complete: bool) -> String {
    let unit = ["PROGRAM", "FUNCTION", "CONFIGURATION"].iter().any(|word| part.starts_with(word));
    let main = part.replace("END_PROGRAM", "").contains("PROGRAM ");
    match (unit, main || complete) {
        (false, _) => format!("PROGRAM MAIN\n{part}END_PROGRAM\n"),
        (true, false) => format!("{part}PROGRAM MAIN END_PROGRAM\n"),
        (true, true) => part.to_owned(),
    }
}

/// The codes that the command finds in an example, and whether it is content.
fn found(bench: &TestProject, block: &ExampleBlock) -> (Vec<String>, bool) {
    let ran = match block.language.as_str() {
        "console" => {
            let words = block.text.trim().trim_start_matches("rig ");
            let mut quoted = false;
            let words = words.split(|c| {
                quoted ^= c == '"';
                c == ' ' && !quoted
            });
            let args: Vec<&str> = words.map(|word| word.trim_matches('"')).collect();
            bench.rig(&args)
        }
        "iecst" => {
            bench.write("example.st", &program(&block.text, block.code == "S0211"));
            bench.rig(&["check", "example.st"])
        }
        _ if block.code.starts_with('B') => {
            bench.write("example.toml", &board(&block.text));
            bench.rig(&["check", "example.toml"])
        }
        _ => {
            bench.write("example.toml", &plan(&block.text));
            bench.rig(&["check", "example.toml"])
        }
    };
    let codes = ran.err.lines().filter_map(|line| {
        let rest = line.strip_prefix("error[").or_else(|| line.strip_prefix("warning["))?;
        Some(rest.split_once(']')?.0.to_owned())
    });
    // An example has the signals of the lamp and need not speak of all.
    let leftover = |code: &String| code == "P0623" && block.code != *code;
    (codes.filter(|code| !leftover(code)).collect(), ran.code == Some(0))
}

#[test]
fn every_example_provokes_its_code_and_its_fix_does_not() {
    let bench = TestProject::new();
    let mut wrong = Vec::new();
    for block in blocks() {
        match block.role.as_str() {
            // What the command of the next block works with.
            "with" if block.language == "csv" => bench.write("lamp.csv", &block.text),
            "with" if block.language == "iecst" => bench.write("plant.st", &block.text),
            "with" => bench.write("lamp.toml", &plan(&block.text)),
            "wrong" => {
                let (codes, _) = found(&bench, &block);
                if !codes.contains(&block.code) {
                    wrong.push(format!("{} is not provoked, but {codes:?}", block.code));
                }
            }
            "right" => {
                let (codes, content) = found(&bench, &block);
                // Other warnings may come of what the example leaves out.
                if codes.contains(&block.code) || !content {
                    wrong.push(format!("the fix of {} has {codes:?}", block.code));
                }
            }
            role => wrong.push(format!("{}: `{role}`", block.code)),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_code_has_a_page_and_all_but_a_few_an_example() {
    let blocks = blocks();
    let mut wrong = Vec::new();
    let known = [
        plans::CODES,
        drivers::CODES,
        program::CODES,
        runtime::CODES,
        guard::CODES,
        services::CODES,
        control::CODES,
        dash::CODES,
    ]
    .concat();
    let bench = TestProject::new();
    let listed = bench.expect(0, &["explain"]).out;
    for (code, title) in &known {
        if !listed.contains(&format!("{code}  {title}\n")) {
            wrong.push(format!("{code} has no page: docs/codes.md has no row for it"));
        }
    }
    for line in listed.lines() {
        let code = &line[..5];
        let page = bench.expect(0, &["explain", code]).out;
        if !page.starts_with(&format!("{code}: ")) || !page.contains("\nFix: ") {
            wrong.push(format!("the page of {code} lacks title or fix"));
        }
        let has = blocks.iter().any(|block| block.code == code && block.role == "wrong");
        let excused = WITHOUT_EXAMPLE.iter().any(|(prefix, _)| code.starts_with(prefix));
        if has && excused {
            wrong.push(format!("{code} has an example and is excused from one"));
        }
        if !has && !excused {
            wrong.push(format!("{code} has no example in docs/codes, and no reason in {}", file!()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_page_is_read_by_a_person() {
    let page = TestProject::new().expect(0, &["explain", " p0302"]).out;
    let shown = "P0302: An instant of an unknown step

An instant counts from `start`, from `end` or from a step of the same case.

This is refused:

    expect = [{ rises = { signal = \"lamp\", from = \"pres\", within = \"500 ms .. 550 ms\" } }]

This is right:

    expect = [{ rises = { signal = \"lamp\", from = \"press\", within = \"500 ms .. 550 ms\" } }]

Fix: Name a step that the case has (steps of other rows do not count), or a
pulse that the train has.
";
    assert_eq!(page, shown);
}

#[test]
fn a_code_that_does_not_exist_is_refused() {
    let bench = TestProject::new();
    bench.refused(
        &["explain", "P0199"],
        &["R0152", "there is no code or module `P0199`", "did you mean `P0109`"],
    );
    bench.refused(
        &["explain", "tm3ai5"],
        &["R0152", "`tm3ai5`", "did you mean `TM3AI4`", "`rig explain modules`"],
    );
    bench.refused(&["explain", "nothing"], &["R0152", "`rig explain` lists all codes"]);
}

#[test]
fn the_page_of_a_module_is_read_by_a_person() {
    let page = TestProject::new().expect(0, &["explain", " tm3am6"]).out;
    let shown = "TM3AM6: TM3 analogue, 4 analogue inputs of 12 bit, 2 analogue outputs of 12 bit

Internal ID code      197, shared with TM3AM6G
Profiles              m241-2019, m251-2024
Terminals             removable screw terminal block
Analogue inputs       4, 12 bit
  modes               0..10 V, -10..10 V, 0..20 mA, 4..20 mA
Analogue outputs      2, 12 bit
  modes               0..10 V, -10..10 V, 0..20 mA, 4..20 mA
Firmware              26

Alone, with status bytes, it is at

    on an M251                %IW0..%IW3, status %IB8..%IB13, %QW0..%QW1
    on an M241 of 24 channels %IW2..%IW5, status %IB12..%IB17, %QW2..%QW3
    on an M241 of 40 channels %IW2..%IW5, status %IB12..%IB17, %QW2..%QW3

    mode                        from      to   under range  over range
    0..10 V                        0      10          -0.2        10.2  V
    -10..10 V                    -10      10         -10.4        10.4  V
    0..20 mA                       0      20          -0.4        20.4  mA
    4..20 mA                       4      20          3.68       20.32  mA

Not in the documents of the controllers:

rig definition: firmware

manufacturer's product help, TM3 analogue modules: under-range, over-range of
0..10 V

rig definition: a fiftieth of the span beyond the end, as in 0..10 V:
under-range, over-range of -10..10 V

manufacturer's answers to questions, TM3 analogue modules: under-range,
over-range of 0..20 mA, 4..20 mA
";
    assert_eq!(page, shown);
}

#[test]
fn every_module_has_a_page() {
    let bench = TestProject::new();
    let listed = bench.expect(0, &["explain", "modules"]).out;
    assert_eq!(listed.lines().count(), catalogue::modules().len());
    for line in listed.lines() {
        let reference = line.split_whitespace().next().unwrap();
        let page = bench.expect(0, &["explain", reference]).out;
        assert!(page.starts_with(&format!("{reference}: ")) && page.contains("\nProfiles "), "{page}");
        assert!(page.lines().all(|line| line.chars().count() <= 80), "{page}");
    }
}
