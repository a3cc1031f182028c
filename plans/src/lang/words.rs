//! Names: of steps, rows and references, and of variables.

/// Length of an identifier at the beginning of `text`, 0 if there is none: a letter or `_`, then letters,
/// digits and `_`; a `-` only where a letter follows, so that `busy-2 ms` is a subtraction.
pub(crate) fn id_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let starts = |byte: &u8| byte.is_ascii_alphabetic() || *byte == b'_';
    if !bytes.first().is_some_and(starts) {
        return 0;
    }
    let mut at = 1;
    while at < bytes.len() {
        let inner = bytes[at].is_ascii_alphanumeric() || bytes[at] == b'_';
        let joint = bytes[at] == b'-' && bytes.get(at + 1).is_some_and(u8::is_ascii_alphabetic);
        if !inner && !joint {
            break;
        }
        at += 1;
    }
    at
}

/// Whether `text` can be the id of a step or the name of a row, sweep or parameter: letters, digits, `_`
/// and, before a letter, `-`; it begins with a letter or `_`. At most 64 bytes.
pub fn is_id(text: &str) -> bool {
    !text.is_empty() && text.len() <= 64 && id_length(text) == text.len()
}

/// Whether `text` can be the path of a variable: identifiers joined by `.`, each with optional `[n]` or
/// `[n,m]`, as in `MAIN.t1.Q` or `a[3].x`. At most 256 bytes.
pub fn is_path(text: &str) -> bool {
    !text.is_empty() && text.len() <= 256 && text.split('.').all(is_part)
}

fn is_part(part: &str) -> bool {
    let name_end = part.find('[').unwrap_or(part.len());
    let (name, mut rest) = part.split_at(name_end);
    let mut chars = name.chars();
    let first = chars.next().is_some_and(|c| c.is_ascii_alphabetic() || c == '_');
    if !first || !chars.all(|c| c.is_ascii_alphanumeric() || c == '_') {
        return false;
    }
    while let Some(inside) = rest.strip_prefix('[') {
        let Some(end) = inside.find(']') else { return false };
        let number = |text: &str| {
            let digits = text.trim().strip_prefix('-').unwrap_or_else(|| text.trim());
            !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit())
        };
        if !inside[..end].split(',').all(number) {
            return false;
        }
        rest = &inside[end + 1..];
    }
    rest.is_empty()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_told_from_what_is_no_name() {
        for good in ["busy", "power-cut", "_x1", "a-b_c"] {
            assert!(is_id(good), "{good}");
        }
        for bad in ["", "1a", "a-1", "a.b", "a b", "-a", "a-", "ü"] {
            assert!(!is_id(bad), "{bad}");
        }
        for good in ["n", "MAIN.t1.Q", "a[3].x", "m[1, -2]", "PLC_R.i_wStatus"] {
            assert!(is_path(good), "{good}");
        }
        for bad in ["", ".", "a.", "a[", "a[]", "a[x]", "%QX0.4", "a-b", "a b"] {
            assert!(!is_path(bad), "{bad}");
        }
        assert_eq!(id_length("busy-2 ms"), 4);
    }
}
