//! Several files that are read as one.

use std::ops::Range;

use crate::{Diagnostic, SourceFile, Table, line_col};

/// Files one after another: a byte of the second counts on from the end of the first, so that a value needs no more
/// than its bytes to say where it stands, whichever file it is from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Joined {
    /// The byte at which each file begins, with the file. The first one begins at 0.
    files: Vec<(usize, SourceFile)>,
}

impl Joined {
    /// A first file alone.
    pub fn new(file: SourceFile) -> Joined {
        Joined { files: vec![(0, file)] }
    }

    /// The first file.
    pub fn first(&self) -> &SourceFile {
        &self.files[0].1
    }

    /// Gives the first file another name.
    pub fn rename_first(&mut self, name: &str) {
        name.clone_into(&mut self.files[0].1.name);
    }

    /// The files after the first one.
    pub fn others(&self) -> impl Iterator<Item = &SourceFile> {
        self.files.iter().skip(1).map(|(_, file)| file)
    }

    /// Appends a file whose values are those of `table`, and moves these to where the file begins.
    pub fn append(&mut self, file: SourceFile, table: &mut Table) {
        let base = self.next();
        table.shift(base);
        self.files.push((base, file));
    }

    /// Where the next file would begin: a byte after the end of the last one, which is still of that file.
    pub fn next(&self) -> usize {
        self.files.last().map_or(0, |(base, file)| base + file.text.len() + 1)
    }

    /// The file of a byte, and which byte of it that is.
    pub fn place(&self, byte: usize) -> (&SourceFile, usize) {
        let at = self.files.partition_point(|(base, _)| *base <= byte).saturating_sub(1);
        let (base, file) = &self.files[at];
        (file, byte - base)
    }

    /// Whether a byte is of the first file.
    pub fn is_first(&self, byte: usize) -> bool {
        self.files.get(1).is_none_or(|(base, _)| byte < *base)
    }

    /// The file of some bytes, and which bytes of it these are.
    pub fn span(&self, span: &Range<usize>) -> (&SourceFile, Range<usize>) {
        let (file, start) = self.place(span.start);
        (file, start..start + span.len())
    }

    /// The line of a byte in its file, from 1.
    pub fn line(&self, byte: usize) -> u32 {
        let (file, byte) = self.place(byte);
        u32::try_from(line_col(&file.text, byte).0).unwrap_or(u32::MAX)
    }

    /// Names the right file in findings that were made as if all stood in the first one.
    pub fn locate(&self, found: &mut [Diagnostic]) {
        let first = self.first().name.as_str();
        for label in found.iter_mut().flat_map(|one| &mut one.labels) {
            if label.file == first && !self.is_first(label.span.start) {
                let (file, span) = self.span(&label.span);
                (label.file, label.span) = (file.name.clone(), span);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Codes, toml};

    const CODES: Codes = Codes {
        syntax: "X0001",
        newer_toml: "X0002",
        too_large: "X0003",
        unknown_key: "X0004",
        missing_key: "X0005",
        wrong_type: "X0006",
        unreadable: "X0007",
    };

    #[test]
    fn bytes_of_every_file_find_back() {
        let first = SourceFile::new("a", "a = 1\n");
        let second = SourceFile::new("b", "\nb = { c = \"x\" }\n");
        let mut table = toml::parse(&second, CODES).unwrap();
        let mut joined = Joined::new(first);
        joined.append(second, &mut table);
        let inner = table.get("b").unwrap().as_table().unwrap().get("c").unwrap();
        assert_eq!(inner.content, Some(inner.span.start + 1));
        assert!(joined.is_first(6) && !joined.is_first(7));
        let (file, span) = joined.span(&inner.span);
        assert_eq!((file.name.as_str(), &file.text[span]), ("b", "\"x\""));
        assert_eq!((joined.line(inner.span.start), joined.line(0)), (2, 1));
        let mut found =
            vec![Diagnostic::error("X0001", "m").at("a", inner.span.clone(), "").at("a", 0..1, "")];
        joined.locate(&mut found);
        assert_eq!((found[0].labels[0].file.as_str(), found[0].labels[0].span.start), ("b", 11));
        assert_eq!(found[0].labels[1].file, "a");
    }
}
