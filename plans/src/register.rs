//! The register of requirements: every requirement, what class it is, one line of what it asks.

use profile::Profile;
use std::fmt;

/// What kind of thing a requirement is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RequirementClass {
    /// Behaviour that a plan can prove.
    Behaviour,
    /// A constant of a table.
    Constant,
    /// A rig cannot reproduce it.
    NotReproducible,
}

impl RequirementClass {
    /// The word in the register.
    pub const fn word(self) -> &'static str {
        match self {
            RequirementClass::Behaviour => "behaviour",
            RequirementClass::Constant => "constant",
            RequirementClass::NotReproducible => "not-reproducible",
        }
    }
}

/// One requirement.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Requirement {
    /// Its ID, as in `controller:WD-04`.
    pub id: String,
    /// What it asks, one line.
    pub asks: String,
    /// Where it comes from: section of the specification.
    pub source: String,
    /// The profiles that it holds for; empty for all.
    pub profiles: Vec<Profile>,
    /// What kind of thing it is.
    pub class: RequirementClass,
    /// Its clauses in the order of the file, each with what it asks. Empty where it is one statement.
    pub clauses: Vec<RequirementClause>,
}

/// One row of a requirement that is a table or a list; cited as in `controller:RB-02#8`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RequirementClause {
    /// What stands after the `#`.
    pub id: String,
    /// What it asks, one line.
    pub asks: String,
    /// The profiles that it holds for; empty for those of its requirement.
    pub profiles: Vec<Profile>,
}

/// Longest name of a clause in bytes.
const MAX_CLAUSE: usize = 48;

/// Whether a text can be the name of a clause: small letters, digits, `-`, and `/` between the two headings of a cell.
pub fn is_clause(text: &str) -> bool {
    let part = |part: &str| {
        !part.is_empty() && part.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-')
    };
    text.len() <= MAX_CLAUSE && text.split('/').all(part)
}

/// The register.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RequirementRegister {
    /// The requirements in the order of the file.
    pub entries: Vec<Requirement>,
}

/// What is wrong with a register.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RequirementError {
    /// The requirement, where known.
    pub id: String,
    /// What is wrong.
    pub fault: String,
}

impl fmt::Display for RequirementError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.id.is_empty() { f.write_str(&self.fault) } else { write!(f, "{}: {}", self.id, self.fault) }
    }
}

impl std::error::Error for RequirementError {}

impl RequirementRegister {
    /// Reads the register: a table for each requirement, `["controller:WD-04"]` with `asks`, `source`, and where
    /// they differ from the usual `class` (behaviour) and `profiles` (all).
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn read(text: &str) -> Result<RequirementRegister, RequirementError> {
        let fail = |id: &str, fault: String| RequirementError { id: id.to_owned(), fault };
        let file = document::SourceFile::new("requirements.toml", text);
        let root = document::toml::parse(&file, crate::TOML).map_err(|found| {
            fail("", found.first().map_or_else(String::new, |first| first.message.clone()))
        })?;
        let mut entries = Vec::with_capacity(root.entries.len());
        for entry in &root.entries {
            let id = &entry.key;
            let Some(table) = entry.node.as_table() else {
                return Err(fail(id, String::from("is no table")));
            };
            let text = |key: &str| table.get(key).and_then(document::Node::as_text).map(str::to_owned);
            let class = match text("class").as_deref() {
                None | Some("behaviour") => RequirementClass::Behaviour,
                Some("constant") => RequirementClass::Constant,
                Some("not-reproducible") => RequirementClass::NotReproducible,
                Some(other) => return Err(fail(id, format!("there is no class `{other}`"))),
            };
            let profiles = profiles(table).map_err(|fault| fail(id, fault))?;
            let asks = text("asks").ok_or_else(|| fail(id, String::from("has no `asks`")))?;
            let source = text("source").ok_or_else(|| fail(id, String::from("has no `source`")))?;
            let clauses = clauses(table).map_err(|fault| fail(id, fault))?;
            entries.push(Requirement { id: id.clone(), asks, source, profiles, class, clauses });
        }
        Ok(RequirementRegister { entries })
    }

    /// The requirement of this ID.
    pub fn find(&self, id: &str) -> Option<&Requirement> {
        self.entries.iter().find(|entry| entry.id == id)
    }

    /// Whether there is what a plan cites: a requirement, or a clause of one.
    pub fn knows(&self, cited: &str) -> bool {
        match cited.split_once('#') {
            None => self.find(cited).is_some(),
            Some((id, clause)) => {
                self.find(id).is_some_and(|entry| entry.clauses.iter().any(|known| known.id == clause))
            }
        }
    }
}

fn profiles(table: &document::Table) -> Result<Vec<Profile>, String> {
    let names = table.get("profiles").and_then(document::Node::as_array).unwrap_or_default();
    names
        .iter()
        .map(|name| {
            let name = name.as_text().unwrap_or_default();
            name.parse().map_err(|_| format!("there is no profile `{name}`"))
        })
        .collect()
}

/// The clauses of a requirement: `"8" = "what it asks"`, or `"8" = { asks = "...", profiles = [...] }`.
fn clauses(table: &document::Table) -> Result<Vec<RequirementClause>, String> {
    let Some(node) = table.get("clauses") else { return Ok(Vec::new()) };
    let list = node.as_table().ok_or_else(|| String::from("`clauses` is no table"))?;
    let mut clauses = Vec::with_capacity(list.entries.len());
    for entry in &list.entries {
        let id = entry.key.clone();
        if !is_clause(&id) {
            return Err(format!("`{id}` cannot be the name of a clause"));
        }
        let inner = entry.node.as_table();
        let asks = inner.map_or(Some(&entry.node), |table| table.get("asks"));
        let asks = asks.and_then(document::Node::as_text).map(str::to_owned);
        let asks = asks.ok_or_else(|| format!("the clause `{id}` does not say what it asks"))?;
        clauses.push(RequirementClause { id, asks, profiles: inner.map_or(Ok(Vec::new()), profiles)? });
    }
    Ok(clauses)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clauses_read() {
        let text = "[\"controller:RB-02\"]\nasks = \"a\"\nsource = \"s\"\n[\"controller:RB-02\".clauses]\n\"8\" = \"b\"\n\"9\" = { asks = \"c\", profiles = [\"m241-2014\"] }\n";
        let register = RequirementRegister::read(text).unwrap();
        assert!(register.knows("controller:RB-02#8") && !register.knows("controller:RB-02#7"));
        assert_eq!(register.entries[0].clauses[1].profiles, vec![Profile::M241_2014]);
        assert!(is_clause("reset-cold/retain") && !is_clause("Reset") && !is_clause("a/") && !is_clause(""));
    }

    #[test]
    fn entries_read() {
        let register = RequirementRegister::read(
            "[\"controller:WD-04\"]\nasks = \"a\"\nsource = \"s\"\nprofiles = [\"m241-2014\"]\nclass = \"constant\"\n",
        );
        let entry = register.unwrap().find("controller:WD-04").cloned().unwrap();
        assert_eq!((entry.class, entry.profiles), (RequirementClass::Constant, vec![Profile::M241_2014]));
        assert!(RequirementRegister::read("[\"x\"]\nasks = \"a\"\n").is_err());
        assert!(RequirementRegister::read("[\"x\"]\nasks = \"a\"\nsource = \"s\"\nclass = \"y\"\n").is_err());
    }
}
