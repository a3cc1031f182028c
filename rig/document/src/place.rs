//! From bytes to what a person counts.

/// Line and column of a byte, both from 1; columns count characters. A byte after the text is its end; a
/// byte inside a character is that character.
pub fn line_col(text: &str, byte: usize) -> (usize, usize) {
    let byte = floor(text, byte);
    let before = &text[..byte];
    let line_start = before.rfind('\n').map_or(0, |at| at + 1);
    (before.bytes().filter(|b| *b == b'\n').count() + 1, before[line_start..].chars().count() + 1)
}

/// The nearest boundary between characters at or before `byte`.
pub(crate) fn floor(text: &str, byte: usize) -> usize {
    let mut byte = byte.min(text.len());
    while !text.is_char_boundary(byte) {
        byte -= 1;
    }
    byte
}

#[cfg(test)]
mod tests {
    use super::line_col;

    #[test]
    fn characters_are_counted_not_bytes() {
        assert_eq!(line_col("a\nµs x", 5), (2, 3));
        assert_eq!(line_col("", 0), (1, 1));
        assert_eq!(line_col("a\n", 99), (2, 1));
        assert_eq!(line_col("µ", 1), (1, 1));
    }
}
