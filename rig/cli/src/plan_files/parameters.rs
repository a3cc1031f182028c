//! `--param K=V`: a parameter may belong to one plan of several, but not to none.

use crate::exit::ExitStatus;
use crate::output;
use document::suggest;
use runtime::suite::{self, FileSource};

/// A parameter that cannot be given.
const PARAMETER: &str = "R0229";

/// What the command line gives.
#[derive(Debug)]
pub struct Parameters {
    given: Vec<(String, String)>,
    /// Names that the plans have so far.
    known: Vec<String>,
    /// A plan could not be read, so that it is not known which parameters it has.
    unread: bool,
}

impl Parameters {
    /// Reads `K=V`, each name once.
    pub fn read(given: &[String]) -> Result<Parameters, ExitStatus> {
        let mut read: Vec<(String, String)> = Vec::new();
        for text in given {
            let Some((name, value)) = text.split_once('=') else {
                let message = format!("--param {text}: this gives no parameter a value");
                return Err(output::refuse(PARAMETER, message, "write it as NAME=VALUE"));
            };
            if read.iter().any(|(known, _)| known == name) {
                let message = format!("--param {text}: `{name}` has a value already");
                return Err(output::refuse(PARAMETER, message, "leave one of the two out"));
            }
            read.push((name.to_owned(), value.to_owned()));
        }
        Ok(Parameters { given: read, known: Vec::new(), unread: false })
    }

    /// Those of the given ones that this plan or what it includes has. None of a plan that does not read, whose findings
    /// are reported anyway.
    pub fn of_plan(&mut self, files: &dyn FileSource, path: &str) -> Vec<(String, String)> {
        if self.given.is_empty() {
            return Vec::new();
        }
        let Ok(text) = suite::gather(files, path, &mut Vec::new()) else {
            self.unread = true;
            return Vec::new();
        };
        let names = text.parameters();
        let own = self.given.iter().filter(|(name, _)| names.contains(name)).cloned().collect();
        self.known.extend(names);
        own
    }

    /// After the last plan: refuses a parameter that no plan has.
    pub fn finish(&self) -> Result<(), ExitStatus> {
        let missing = self.given.iter().find(|(name, _)| !self.known.contains(name));
        match missing {
            Some((name, _)) if !self.unread => {
                let help = match suggest(name, self.known.iter().map(String::as_str)) {
                    Some(meant) => format!("did you mean `{meant}`?"),
                    None if self.known.is_empty() => {
                        String::from("these plans have none: `[parameters]` names them")
                    }
                    None => format!("there are {}", self.known.join(", ")),
                };
                Err(output::refuse(PARAMETER, format!("no plan has a parameter `{name}`"), &help))
            }
            _ => Ok(()),
        }
    }
}
