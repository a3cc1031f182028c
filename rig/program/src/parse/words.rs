//! Words that belong to the language.

/// Keywords of what is supported, in order.
const KEYWORDS: &[&str] = &[
    "AND",
    "ARRAY",
    "AT",
    "BY",
    "CASE",
    "CONSTANT",
    "CONTINUE",
    "DO",
    "ELSE",
    "ELSIF",
    "END_CASE",
    "END_FOR",
    "END_FUNCTION",
    "END_FUNCTION_BLOCK",
    "END_IF",
    "END_PROGRAM",
    "END_REPEAT",
    "END_VAR",
    "END_WHILE",
    "EXIT",
    "FALSE",
    "FOR",
    "FUNCTION",
    "FUNCTION_BLOCK",
    "IF",
    "MOD",
    "NON_RETAIN",
    "NOT",
    "OF",
    "OR",
    "PERSISTENT",
    "PROGRAM",
    "REPEAT",
    "RETAIN",
    "RETURN",
    "THEN",
    "TO",
    "TRUE",
    "UNTIL",
    "VAR",
    "VAR_GLOBAL",
    "VAR_INPUT",
    "VAR_OUTPUT",
    "WHILE",
    "XOR",
];

/// Words of the language that have no meaning here yet, in order.
const UNSUPPORTED: &[&str] = &[
    "ACTION",
    "AND_THEN",
    "CHAR",
    "CLASS",
    "CONFIGURATION",
    "DATE",
    "DATE_AND_TIME",
    "DT",
    "END_ACTION",
    "END_CLASS",
    "END_CONFIGURATION",
    "END_INTERFACE",
    "END_METHOD",
    "END_NAMESPACE",
    "END_PROPERTY",
    "END_RESOURCE",
    "END_STRUCT",
    "END_TYPE",
    "EXPT",
    "EXTENDS",
    "GOTO",
    "IMPLEMENTS",
    "INTERFACE",
    "JMP",
    "LDATE",
    "LREAL",
    "LTIME",
    "METHOD",
    "NAMESPACE",
    "OR_ELSE",
    "POINTER",
    "PROPERTY",
    "REAL",
    "REFERENCE",
    "REF_TO",
    "RESOURCE",
    "STRING",
    "STRUCT",
    "SUPER",
    "TASK",
    "THIS",
    "TIME_OF_DAY",
    "TOD",
    "TYPE",
    "UNION",
    "VAR_ACCESS",
    "VAR_CONFIG",
    "VAR_EXTERNAL",
    "VAR_INST",
    "VAR_IN_OUT",
    "VAR_STAT",
    "VAR_TEMP",
    "WCHAR",
    "WSTRING",
];

pub(crate) fn is_keyword(key: &str) -> bool {
    KEYWORDS.binary_search(&key).is_ok()
}

pub(crate) fn is_unsupported(key: &str) -> bool {
    UNSUPPORTED.binary_search(&key).is_ok()
}

/// Whether a list of statements ends before this word.
pub(super) fn ends_statements(key: &str) -> bool {
    matches!(key, "ELSE" | "ELSIF" | "UNTIL" | "PROGRAM" | "FUNCTION" | "FUNCTION_BLOCK")
        || key.starts_with("END_")
        || key.starts_with("VAR")
            && matches!(key.get(3..4), None | Some("_"))
            && (is_keyword(key) || is_unsupported(key))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_in_order() {
        assert!(KEYWORDS.windows(2).all(|pair| pair[0] < pair[1]));
        assert!(UNSUPPORTED.windows(2).all(|pair| pair[0] < pair[1]));
        assert!(ends_statements("VAR_INPUT") && ends_statements("VAR") && !ends_statements("VARIO"));
    }
}
