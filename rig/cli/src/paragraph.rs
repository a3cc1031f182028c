//! Text in lines for a terminal.

/// Width of the text in columns.
pub const WIDTH: usize = 80;

/// Words in lines of at most [`WIDTH`] columns.
pub fn wrap(text: &str) -> String {
    let mut wrapped = String::new();
    let mut column = 0;
    for word in text.split_whitespace() {
        let length = word.chars().count();
        if column > 0 && column + 1 + length > WIDTH {
            wrapped.push('\n');
            column = 0;
        } else if column > 0 {
            wrapped.push(' ');
            column += 1;
        }
        wrapped.push_str(word);
        column += length;
    }
    wrapped.push('\n');
    wrapped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_not_too_long() {
        let wrapped = wrap(&"twelve chars ".repeat(30));
        assert!(wrapped.lines().count() > 4 && wrapped.lines().all(|line| line.len() <= WIDTH), "{wrapped}");
    }
}
