//! The register of codes: nothing is reported without one.

macro_rules! codes {
    ($($name:ident = $code:literal, $title:literal;)*) => {
        /// What a finding is about.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Code {
            $(
                #[doc = $title]
                $name,
            )*
        }

        impl Code {
            pub(crate) const fn text(self) -> &'static str {
                match self {
                    $(Code::$name => $code,)*
                }
            }
        }

        /// Every code that this crate reports, with its title, in order.
        pub const CODES: &[(&str, &str)] = &[$(($code, $title),)*];
    };
}

codes! {
    Character = "S0101", "A character that Structured Text does not have";
    Unexpected = "S0102", "Something else was expected here";
    Identifier = "S0103", "A name breaks the rules for identifiers";
    Unterminated = "S0104", "A comment, pragma or string is not closed";
    Number = "S0105", "A number is malformed, too large or too small";
    Duration = "S0106", "A duration is malformed or too long";
    Nesting = "S0107", "Expressions or statements are nested too deeply";
    Unclosed = "S0108", "A block is not closed";
    LongName = "S0109", "A name is longer than 32 characters";
    Text = "S0110", "A text literal is malformed";
    Date = "S0111", "A date or time of day is malformed or outside its type";
    Underscores = "S0112", "A name has two underscores side by side";
    Duplicate = "S0201", "A name is declared twice";
    UnknownType = "S0202", "A type is not known";
    NotConstant = "S0203", "A constant is needed here";
    ArrayBounds = "S0204", "The bounds of an array or the length of a text are wrong";
    ContainsItself = "S0205", "A function block contains itself";
    Section = "S0206", "A declaration cannot be here";
    Address = "S0207", "An address does not exist";
    AddressSize = "S0208", "A variable does not cover its address";
    Located = "S0209", "A located variable cannot be here";
    ConstantValue = "S0210", "A constant has no value";
    NoProgram = "S0211", "The sources have no PROGRAM";
    Reserved = "S0212", "A name belongs to the language";
    InitialValue = "S0213", "An initial value does not suit its variable";
    Task = "S0214", "A task is configured wrongly";
    Unconnected = "S0215", "An address is completed elsewhere";
    Lifecycle = "S0216", "FB_Exit and FB_Reinit are never called";
    UnknownName = "S0301", "A name is not known";
    Type = "S0302", "The types do not go together";
    Range = "S0303", "A value is outside the range of its type";
    Operator = "S0304", "An operator does not take these types";
    DivisionByZero = "S0305", "Division by a constant 0";
    SignChange = "S0306", "A conversion can change the value's sign";
    NotAValue = "S0307", "A name is not one of a value";
    Index = "S0308", "An index does not suit its array";
    NotCut = "S0309", "A difference is not cut to its type";
    Inexact = "S0310", "A REAL is compared with a number that it does not hold";
    ReadOnly = "S0401", "The target cannot be assigned to";
    Condition = "S0402", "A condition is not BOOL";
    CaseLabel = "S0403", "A label of CASE is wrong";
    ForVariable = "S0404", "The control variable or step of FOR is wrong";
    OutsideLoop = "S0405", "EXIT or CONTINUE outside a loop";
    UnknownParameter = "S0406", "A parameter is not known";
    Arguments = "S0407", "The parameters of a call are wrong";
    NotCallable = "S0408", "What is called is no function, block or program";
    Override = "S0409", "A method does not fit what it overrides or implements";
    Output = "S0410", "A value cannot be passed by reference";
    Endless = "S0411", "A loop that never gets beyond its end";
    SourceSize = "S0501", "The sources are too large";
    DataSize = "S0502", "The variables need too much memory";
    RetainedSize = "S0503", "The retained variables need too much memory";
    Depth = "S0504", "An expression or a chain of calls is too deep";
    Length = "S0505", "The program is too long";
    TooMany = "S0506", "Too many errors";
    Unsupported = "S0901", "A part of the language that is not there yet";
}

#[cfg(test)]
mod tests {
    use super::CODES;

    #[test]
    fn codes_are_unique_and_in_order() {
        for pair in CODES.windows(2) {
            assert!(pair[0].0 < pair[1].0, "{} before {}", pair[0].0, pair[1].0);
        }
        assert!(
            CODES.iter().all(|(code, title)| code.starts_with('S') && code.len() == 5 && !title.is_empty())
        );
    }
}
