//! What the tests read out of a page: its sentences, its tables and its blocks of code.

use crate::project_folder::{list, root};

/// A page of the manual.
pub struct Page {
    /// Its path below `docs`, without `.md`, as in `boards/gpio`.
    pub name: String,
    pub text: String,
}

/// A block of code.
pub struct Block {
    /// The page and the line that it begins on.
    pub place: String,
    pub language: String,
    pub text: String,
}

/// A table, with the heading that it stands below.
pub struct Table {
    pub heading: String,
    /// The first cell of its first row.
    pub header: String,
    pub rows: Vec<Row>,
}

pub struct Row {
    /// The page and the line.
    pub place: String,
    /// What stands in the first cell in code.
    pub names: Vec<String>,
    /// The other cells.
    pub rest: String,
}

/// A page by its name.
pub fn page(name: &str) -> Page {
    let path = root().join(format!("docs/{name}.md"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    Page { name: name.to_owned(), text }
}

/// The pages of a folder below `docs`; of `docs` itself if it has no name.
pub fn pages(folder: &str) -> Vec<Page> {
    let files = list(&root().join("docs").join(folder));
    let names = files.iter().filter_map(|file| file.strip_suffix(".md"));
    names
        .map(|name| page(&if folder.is_empty() { name.to_owned() } else { format!("{folder}/{name}") }))
        .collect()
}

/// The pages that say how things are: all but the decisions, which say why they became so, and the codes, whose examples
/// have a test of their own.
pub fn manual() -> Vec<Page> {
    ["", "plans", "boards"].into_iter().flat_map(pages).collect()
}

/// What stands in code in a text: between single backticks.
pub fn code(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

/// The sentences of a paragraph: one ends at a full stop before a word that can begin the next. A row of a table is one.
fn split_sentences(text: &str) -> Vec<String> {
    let mut sentences = vec![String::new()];
    for word in text.split_whitespace() {
        let begins = word.starts_with(|first: char| first.is_uppercase() || "`*[(\"".contains(first));
        let last = sentences.last_mut().expect("one at least");
        if begins && last.ends_with('.') && !text.starts_with('|') {
            sentences.push(word.to_owned());
        } else {
            *last = format!("{last} {word}").trim_start().to_owned();
        }
    }
    sentences
}

impl Page {
    /// The lines outside of blocks of code, with their numbers and the heading that they stand below.
    fn prose(&self) -> impl Iterator<Item = (usize, &str, &str)> {
        let (mut fenced, mut heading) = (false, "");
        self.text.lines().enumerate().filter_map(move |(number, line)| {
            if line.starts_with("```") {
                fenced = !fenced;
                return None;
            }
            if !fenced && line.starts_with('#') {
                heading = line.trim_start_matches('#').trim_start();
            }
            (!fenced).then_some((number + 1, heading, line))
        })
    }

    /// The text in which line breaks are blanks, as a sentence reads.
    pub fn sentences(&self) -> String {
        self.text.split_whitespace().collect::<Vec<_>>().join(" ")
    }

    /// The sentences outside of code, each with the heading that it stands below. A row of a table is one, with its bars.
    pub fn each_sentence(&self) -> Vec<(&str, String)> {
        let mut paragraphs: Vec<(&str, String)> = Vec::new();
        // The line before, if a paragraph goes on after it.
        let mut open = None;
        for (number, heading, line) in self.prose() {
            let row = line.starts_with('|');
            let item = line.trim_start().strip_prefix("- ");
            let goes_on = open.is_some_and(|before| before + 1 == number) && !row && item.is_none();
            let code = line.starts_with("    ") && !goes_on;
            open = None;
            if line.trim().is_empty() || line.starts_with('#') || code {
                continue;
            }
            match paragraphs.last_mut().filter(|_| goes_on) {
                Some((_, text)) => {
                    text.push(' ');
                    text.push_str(line.trim());
                }
                None => paragraphs.push((heading, item.unwrap_or(line).trim().to_owned())),
            }
            open = (!row).then_some(number);
        }
        let mut sentences = Vec::new();
        for (heading, text) in paragraphs {
            sentences.extend(split_sentences(&text).into_iter().map(|sentence| (heading, sentence)));
        }
        sentences
    }

    /// What stands below a heading, up to the next one.
    pub fn section(&self, heading: &str) -> String {
        let lines = self.prose().filter(|(_, below, _)| *below == heading);
        lines.map(|(_, _, line)| line).collect::<Vec<_>>().join("\n")
    }

    pub fn headings(&self) -> Vec<&str> {
        let mut headings: Vec<&str> = self.prose().map(|(_, heading, _)| heading).collect();
        headings.dedup();
        headings
    }

    pub fn blocks(&self) -> Vec<Block> {
        let mut blocks = Vec::new();
        let mut open: Option<Block> = None;
        for (number, line) in self.text.lines().enumerate() {
            match (&mut open, line.strip_prefix("```")) {
                (Some(_), Some(_)) => blocks.extend(open.take()),
                (Some(block), None) => {
                    block.text.push_str(line);
                    block.text.push('\n');
                }
                (None, Some(language)) => {
                    let place = format!("{}.md:{}", self.name, number + 1);
                    open = Some(Block { place, language: language.to_owned(), text: String::new() });
                }
                (None, None) => {}
            }
        }
        blocks
    }

    pub fn tables(&self) -> Vec<Table> {
        let mut tables: Vec<Table> = Vec::new();
        let mut last = 0;
        for (number, heading, line) in self.prose() {
            let Some(cells) = line.strip_prefix("| ") else { continue };
            let (first, rest) = cells.split_once(" |").unwrap_or((cells, ""));
            if number != last + 1 {
                tables.push(Table {
                    heading: heading.to_owned(),
                    header: first.to_owned(),
                    rows: Vec::new(),
                });
            } else if let Some(table) = tables.last_mut().filter(|_| !first.starts_with("---")) {
                let names = code(first).map(str::to_owned).collect();
                let place = format!("{}.md:{number}", self.name);
                table.rows.push(Row { place, names, rest: rest.to_owned() });
            }
            last = number;
        }
        tables
    }
}

#[test]
fn tables_and_blocks_are_read() {
    let text =
        "# A\n\n| key | value |\n| --- | --- |\n| `a`, `b` | 1 |\n\n```toml\n# no\n| `x` | |\n```\n## B\nc\n";
    let page = Page { name: "p".to_owned(), text: text.to_owned() };
    let tables = page.tables();
    assert_eq!((tables.len(), tables[0].heading.as_str(), tables[0].header.as_str()), (1, "A", "key"));
    assert_eq!(tables[0].rows.len(), 1);
    assert_eq!(
        (&tables[0].rows[0].names[..], tables[0].rows[0].rest.as_str()),
        (&["a".to_owned(), "b".to_owned()][..], " 1 |")
    );
    let blocks = page.blocks();
    assert_eq!((blocks[0].language.as_str(), blocks[0].text.as_str()), ("toml", "# no\n| `x` | |\n"));
    assert_eq!((page.section("B").as_str(), page.headings()), ("## B\nc", vec!["A", "B"]));
}

#[test]
fn sentences_are_read() {
    let text = "# A\n\nOne\ngoes on. `two` is code. It is 1.5. ms\n- Three.\n  Four.\n- Five\n\n    not this.\n\n\
                | a. B | c |\n## B\nSix:\n```toml\nno.\n```\nSeven\n";
    let page = Page { name: "p".to_owned(), text: text.to_owned() };
    let read = page.each_sentence();
    let of = |heading: &str| {
        let found = read.iter().filter(|(below, _)| *below == heading);
        found.map(|(_, sentence)| sentence.as_str()).collect::<Vec<_>>()
    };
    let first =
        ["One goes on.", "`two` is code.", "It is 1.5. ms", "Three.", "Four.", "Five", "| a. B | c |"];
    assert_eq!((of("A"), of("B")), (first.to_vec(), vec!["Six:", "Seven"]));
}
