//! `ask`: what only a person at the machine can do or see.

use document::{Fields, Findings, KeySpec, KeyType, Node};

use super::{StepNames, table_fields};
use super::{StepVerb, Stimulus};
use crate::codes;

/// Longest text that a person is asked, in bytes.
const LONGEST: usize = 2_000;
/// Most answers to choose from.
const MOST_ANSWERS: usize = 20;

const KEYS: &[KeySpec] = &[
    KeySpec::required("text", KeyType::Text, "What the person is to do, or is asked."),
    KeySpec::optional("photo", KeyType::Text, "A picture that shows it, relative to the plan."),
    KeySpec::optional(
        "answers",
        KeyType::List(&KeyType::Text),
        "What can be answered; \"yes\" and \"no\" if left out.",
    ),
    KeySpec::optional("pass", KeyType::Text, "The answer that passes; the first one if left out."),
];

pub(super) const ASK: StepVerb = StepVerb {
    name: "ask",
    doc: "Asks a person at the terminal, who does something or looks at something.",
    value: KeyType::Table(KEYS),
    needs: &["operator"],
    read,
};

/// What a person is asked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Question {
    /// The text.
    pub text: String,
    /// A picture beside the plan.
    pub photo: Option<String>,
    /// What can be answered, at least two.
    pub answers: Vec<String>,
    /// Place of the answer that passes.
    pub pass: usize,
}

fn read(node: &Node, _: &dyn StepNames, out: &mut Findings) -> Option<Stimulus> {
    let fields = table_fields(node, KEYS)?;
    let text = fields.get("text")?;
    let words = text.as_text()?.trim();
    if words.is_empty() || words.len() > LONGEST {
        let message = format!("the text has {} bytes; 1 to {LONGEST} are possible", words.len());
        out.bad(codes::QUESTION, text, message, "say in a sentence or two what is to be done or seen");
        return None;
    }
    let answers = answers(&fields, node, out)?;
    let pass = match fields.get("pass") {
        None => 0,
        Some(pass) => {
            let wanted = pass.as_text()?.trim();
            let Some(at) = answers.iter().position(|one| one.eq_ignore_ascii_case(wanted)) else {
                let help = format!("the answers are {}", answers.join(", "));
                out.bad(codes::QUESTION, pass, format!("`{wanted}` is no answer"), help);
                return None;
            };
            at
        }
    };
    let photo = fields.text("photo").map(str::to_owned);
    Some(Stimulus::Ask(Question { text: words.to_owned(), photo, answers, pass }))
}

fn answers(fields: &Fields<'_>, node: &Node, out: &mut Findings) -> Option<Vec<String>> {
    let Some(list) = fields.get("answers") else { return Some(vec!["yes".into(), "no".into()]) };
    let mut answers: Vec<String> = Vec::new();
    for one in fields.each("answers") {
        let answer = one.as_text()?.trim();
        let fault = if answer.is_empty() || answer.len() > 64 {
            "an answer has 1 to 64 bytes"
        } else if answer.bytes().all(|byte| byte.is_ascii_digit()) {
            "a number chooses among the answers and is none itself"
        } else if answers.iter().any(|known| known.eq_ignore_ascii_case(answer)) {
            "two answers are the same"
        } else {
            answers.push(answer.to_owned());
            continue;
        };
        out.bad(codes::QUESTION, one, fault, "write them as in answers = [\"green\", \"red\", \"dark\"]");
        return None;
    }
    if !(2..=MOST_ANSWERS).contains(&answers.len()) {
        let place = if fields.has("answers") { list } else { node };
        let message = format!("{} answers; 2 to {MOST_ANSWERS} are possible", answers.len());
        out.bad(codes::QUESTION, place, message, "a question with one answer is none: use `pass`");
        return None;
    }
    Some(answers)
}
