//! Words that belong to the language.

use super::ast::Key;

macro_rules! words {
    ($($word:ident = $text:literal,)* ; $($open:ident = $open_text:literal,)*) => {
        /// A word with a meaning. Its key in [`super::NameTable`] is its place here.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u32)]
        pub(crate) enum Word {
            $($word,)*
            $($open,)*
        }

        impl Word {
            /// Every word, in the order of the keys: first those that cannot be names.
            pub(super) const ALL: &'static [(Word, &'static str)] =
                &[$((Word::$word, $text),)* $((Word::$open, $open_text),)*];

            const RESERVED: usize = [$($text,)*].len();
        }
    };
}

words! {
    And = "AND",
    AndThen = "AND_THEN",
    Or = "OR",
    OrElse = "OR_ELSE",
    Xor = "XOR",
    Not = "NOT",
    Mod = "MOD",
    True = "TRUE",
    False = "FALSE",
    Null = "NULL",
    This = "THIS",
    Super = "SUPER",
    If = "IF",
    Then = "THEN",
    Elsif = "ELSIF",
    Else = "ELSE",
    EndIf = "END_IF",
    Case = "CASE",
    Of = "OF",
    EndCase = "END_CASE",
    For = "FOR",
    To = "TO",
    By = "BY",
    Do = "DO",
    EndFor = "END_FOR",
    While = "WHILE",
    EndWhile = "END_WHILE",
    Repeat = "REPEAT",
    Until = "UNTIL",
    EndRepeat = "END_REPEAT",
    Exit = "EXIT",
    Continue = "CONTINUE",
    Return = "RETURN",
    Jmp = "JMP",
    Program = "PROGRAM",
    EndProgram = "END_PROGRAM",
    Function = "FUNCTION",
    EndFunction = "END_FUNCTION",
    FunctionBlock = "FUNCTION_BLOCK",
    EndFunctionBlock = "END_FUNCTION_BLOCK",
    Method = "METHOD",
    EndMethod = "END_METHOD",
    Property = "PROPERTY",
    EndProperty = "END_PROPERTY",
    EndGet = "END_GET",
    EndSet = "END_SET",
    Action = "ACTION",
    EndAction = "END_ACTION",
    Interface = "INTERFACE",
    EndInterface = "END_INTERFACE",
    Type = "TYPE",
    EndType = "END_TYPE",
    Struct = "STRUCT",
    EndStruct = "END_STRUCT",
    Union = "UNION",
    EndUnion = "END_UNION",
    Configuration = "CONFIGURATION",
    EndConfiguration = "END_CONFIGURATION",
    EndResource = "END_RESOURCE",
    EndClass = "END_CLASS",
    EndNamespace = "END_NAMESPACE",
    EndStep = "END_STEP",
    EndTransition = "END_TRANSITION",
    Extends = "EXTENDS",
    Implements = "IMPLEMENTS",
    Var = "VAR",
    VarInput = "VAR_INPUT",
    VarOutput = "VAR_OUTPUT",
    VarInOut = "VAR_IN_OUT",
    VarTemp = "VAR_TEMP",
    VarStat = "VAR_STAT",
    VarInst = "VAR_INST",
    VarGlobal = "VAR_GLOBAL",
    VarExternal = "VAR_EXTERNAL",
    VarAccess = "VAR_ACCESS",
    VarConfig = "VAR_CONFIG",
    EndVar = "END_VAR",
    Constant = "CONSTANT",
    Retain = "RETAIN",
    NonRetain = "NON_RETAIN",
    Persistent = "PERSISTENT",
    At = "AT",
    Array = "ARRAY",
    Pointer = "POINTER",
    RefTo = "REF_TO",
    ;
    String = "STRING",
    Wstring = "WSTRING",
    Reference = "REFERENCE",
    Abstract = "ABSTRACT",
    Final = "FINAL",
    Override = "OVERRIDE",
    Public = "PUBLIC",
    Private = "PRIVATE",
    Protected = "PROTECTED",
    Internal = "INTERNAL",
    Get = "GET",
    Set = "SET",
    Resource = "RESOURCE",
    Task = "TASK",
    On = "ON",
    With = "WITH",
    Overlap = "OVERLAP",
    REdge = "R_EDGE",
    FEdge = "F_EDGE",
    Class = "CLASS",
    Namespace = "NAMESPACE",
    Using = "USING",
    Step = "STEP",
    InitialStep = "INITIAL_STEP",
    Transition = "TRANSITION",
    Try = "__TRY",
    EndTry = "__ENDTRY",
    S = "S",
    R = "R",
    Ref = "REF",
    Ld = "LD",
    Ldn = "LDN",
    Cal = "CAL",
    Calc = "CALC",
    Calcn = "CALCN",
}

impl Word {
    /// The word of a key.
    pub(super) fn of(key: Key) -> Option<Word> {
        Word::ALL.get(key.0 as usize).map(|(word, _)| *word)
    }

    pub(super) fn text(self) -> &'static str {
        Word::ALL.get(self as usize).map_or("", |(_, text)| text)
    }

    pub(super) fn key(self) -> Key {
        Key(self as u32)
    }

    /// Whether nothing can have this name.
    pub(super) fn is_reserved(key: Key) -> bool {
        (key.0 as usize) < Word::RESERVED
    }

    /// VAR, VAR_INPUT and the like.
    pub(super) fn opens_section(self) -> bool {
        (Word::Var as u32..=Word::VarConfig as u32).contains(&(self as u32))
    }

    /// IF, CASE, FOR, WHILE, REPEAT.
    pub(super) fn opens_statements(self) -> bool {
        matches!(self, Word::If | Word::Case | Word::For | Word::While | Word::Repeat)
    }

    /// Whether this closes or divides a statement of several lines.
    pub(super) fn belongs_to_statement(self) -> bool {
        matches!(
            self,
            Word::Elsif
                | Word::Else
                | Word::EndIf
                | Word::EndCase
                | Word::EndFor
                | Word::EndWhile
                | Word::Until
                | Word::EndRepeat
        )
    }

    /// Whether the declaration of something starts here: a list of statements cannot go on.
    pub(super) fn opens_declaration(self) -> bool {
        self.opens_section()
            || matches!(
                self,
                Word::Program
                    | Word::Function
                    | Word::FunctionBlock
                    | Word::Method
                    | Word::Property
                    | Word::Action
                    | Word::Interface
                    | Word::Type
                    | Word::Configuration
            )
    }

    /// Whether this closes what holds statements or declarations.
    pub(super) fn closes_declaration(self) -> bool {
        matches!(
            self,
            Word::EndProgram
                | Word::EndFunction
                | Word::EndFunctionBlock
                | Word::EndMethod
                | Word::EndProperty
                | Word::EndGet
                | Word::EndSet
                | Word::EndAction
                | Word::EndInterface
                | Word::EndType
                | Word::EndConfiguration
        )
    }

    /// Whether this closes what no list of statements is in.
    pub(super) fn closes_elsewhere(self) -> bool {
        matches!(
            self,
            Word::EndVar
                | Word::EndStruct
                | Word::EndUnion
                | Word::EndResource
                | Word::EndClass
                | Word::EndNamespace
                | Word::EndStep
                | Word::EndTransition
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_places() {
        for (place, (word, text)) in Word::ALL.iter().enumerate() {
            assert_eq!(*word as usize, place);
            assert_eq!(Word::of(word.key()), Some(*word));
            assert_eq!(word.text(), *text);
            assert_eq!(*text, text.to_ascii_uppercase());
        }
        assert!(Word::is_reserved(Word::RefTo.key()) && !Word::is_reserved(Word::String.key()));
        assert!(Word::VarGlobal.opens_section() && !Word::EndVar.opens_section());
    }
}
