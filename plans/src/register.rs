//! The register of requirements: every requirement, what class it is, one line of what it asks.

use profile::Profile;
use std::fmt;

/// What kind of thing a requirement is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum RequirementClass {
    /// Behaviour that a plan can prove.
    #[default]
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

/// What a requirement that no case proves can wait for: the part of the controller that it needs, or a plan.
pub const OPEN: [&str; 23] = [
    "CANopen",
    "EtherNet/IP",
    "Ethernet",
    "FTP",
    "J1939",
    "Modbus TCP",
    "OPC UA",
    "SD card",
    "SNMP",
    "access rights",
    "clock",
    "configuration",
    "firewall",
    "firmware",
    "libraries",
    "modules",
    "plan",
    "post configuration",
    "serial line",
    "supply",
    "system functions",
    "system variables",
    "web server",
];

/// What the register says of how far a requirement, or one of its clauses, can be proven.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ProofFacts {
    /// The profiles that it holds for; empty for all, of a clause for those of its requirement.
    pub profiles: Vec<Profile>,
    /// What kind of thing it is; a clause without one is of the kind of its requirement.
    pub class: RequirementClass,
    /// Why a rig cannot reproduce it; empty for what it can.
    pub reason: String,
    /// What it waits for where its proof is not complete: one of [`OPEN`].
    pub open: Option<String>,
    /// The number of the decision by which it is proven against its letter: a file of `docs/decisions`.
    pub decision: Option<u16>,
    /// What stands in its proof in place of what it names, as a file in place of a card; empty for nothing.
    pub stand_in: String,
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
    /// How far it can be proven; of one with clauses, profiles and class alone.
    pub proof: ProofFacts,
    /// Its clauses in the order of the file. Empty where it is one statement.
    pub clauses: Vec<RequirementClause>,
}

/// One statement of a requirement that makes several; cited as in `controller:RB-02#8`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RequirementClause {
    /// What stands after the `#`.
    pub id: String,
    /// What it asks, one line.
    pub asks: String,
    /// How far it can be proven.
    pub proof: ProofFacts,
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
    /// they differ from the usual the keys of [`ProofFacts`]: `profiles` (all), `class` (behaviour), `reason`,
    /// `open`, `decision`, `stand-in`. `clauses` is a table of statements, `"8" = "what it asks"` or
    /// `"8" = { asks = "...", profiles = [...] }` with the same keys.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn read(text: &str) -> Result<RequirementRegister, RequirementError> {
        let file = document::SourceFile::new("requirements.toml", text);
        let root = document::toml::parse(&file, crate::TOML).map_err(|found| RequirementError {
            id: String::new(),
            fault: found.first().map_or_else(String::new, |first| first.message.clone()),
        })?;
        let entries = root.entries.iter().map(|entry| {
            let id = entry.key.clone();
            requirement(&id, &entry.node).map_err(|fault| RequirementError { id, fault })
        });
        Ok(RequirementRegister { entries: entries.collect::<Result<_, _>>()? })
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

fn requirement(id: &str, node: &document::Node) -> Result<Requirement, String> {
    let table = node.as_table().ok_or_else(|| String::from("is no table"))?;
    let mut proof = proof_facts(table, &["asks", "source", "clauses"], RequirementClass::default())?;
    let clauses = clauses(table, proof.class)?;
    if !clauses.is_empty() {
        if proof.open.is_some() || proof.decision.is_some() || !proof.stand_in.is_empty() {
            return Err(String::from(
                "has clauses: `open`, `decision` and `stand-in` are said of the clause",
            ));
        }
        // Of what cannot be reproduced nothing is cited.
        if proof.class == RequirementClass::NotReproducible {
            return Err(String::from("has clauses: the class `not-reproducible` is said of the clause"));
        }
        proof.reason.clear();
    }
    Ok(Requirement {
        id: id.to_owned(),
        asks: text(table, "asks")?.ok_or("has no `asks`")?,
        source: text(table, "source")?.ok_or("has no `source`")?,
        proof,
        clauses,
    })
}

/// The text of a key, where it stands; nothing that is no text or empty.
fn text(table: &document::Table, key: &str) -> Result<Option<String>, String> {
    match table.get(key).map(document::Node::as_text) {
        None => Ok(None),
        Some(Some(text)) if !text.is_empty() => Ok(Some(text.to_owned())),
        Some(_) => Err(format!("`{key}` is no text, or an empty one")),
    }
}

/// How far the requirement or the clause of a table can be proven. `others` are the keys beside it, `class` is that of
/// a table that names none.
fn proof_facts(
    table: &document::Table,
    others: &[&str],
    class: RequirementClass,
) -> Result<ProofFacts, String> {
    const KEYS: [&str; 6] = ["profiles", "class", "reason", "open", "decision", "stand-in"];
    let key_is_known = |key: &str| KEYS.contains(&key) || others.contains(&key);
    if let Some(entry) = table.entries.iter().find(|entry| !key_is_known(&entry.key)) {
        return Err(format!("there is no key `{}`", entry.key));
    }
    let class = match text(table, "class")?.as_deref() {
        None => class,
        Some("behaviour") => RequirementClass::Behaviour,
        Some("constant") => RequirementClass::Constant,
        Some("not-reproducible") => RequirementClass::NotReproducible,
        Some(other) => return Err(format!("there is no class `{other}`")),
    };
    let open = text(table, "open")?;
    if let Some(open) = open.as_ref().filter(|open| !OPEN.contains(&open.as_str())) {
        return Err(format!("`open` cannot be `{open}`: it is one of {}", OPEN.join(", ")));
    }
    let decision = match table.get("decision").map(|node| &node.data) {
        None => None,
        Some(document::Data::Integer(number)) if *number > 0 => u16::try_from(*number).ok(),
        Some(_) => return Err(String::from("`decision` is no number of a decision")),
    };
    let facts = ProofFacts {
        profiles: profiles(table)?,
        class,
        reason: text(table, "reason")?.unwrap_or_default(),
        open,
        decision,
        stand_in: text(table, "stand-in")?.unwrap_or_default(),
    };
    let reproducible = facts.class != RequirementClass::NotReproducible;
    if reproducible != facts.reason.is_empty() {
        return Err(String::from(
            "`reason` says why it is `not-reproducible`: one does not go without the other",
        ));
    }
    if !reproducible && (facts.open.is_some() || facts.decision.is_some() || !facts.stand_in.is_empty()) {
        return Err(String::from(
            "is `not-reproducible`: `open`, `decision` and `stand-in` say nothing of it",
        ));
    }
    Ok(facts)
}

fn profiles(table: &document::Table) -> Result<Vec<Profile>, String> {
    let Some(node) = table.get("profiles") else { return Ok(Vec::new()) };
    let names = node.as_array().ok_or_else(|| String::from("`profiles` is no list"))?;
    names
        .iter()
        .map(|name| {
            let name = name.as_text().unwrap_or_default();
            name.parse().map_err(|_| format!("there is no profile `{name}`"))
        })
        .collect()
}

/// The clauses of a requirement of this class.
fn clauses(table: &document::Table, class: RequirementClass) -> Result<Vec<RequirementClause>, String> {
    let Some(node) = table.get("clauses") else { return Ok(Vec::new()) };
    let list = node.as_table().ok_or_else(|| String::from("`clauses` is no table"))?;
    let clause = |entry: &document::Entry| {
        let id = entry.key.clone();
        if !is_clause(&id) {
            return Err(format!("`{id}` cannot be the name of a clause"));
        }
        let at = |fault: String| format!("clause `{id}`: {fault}");
        let (asks, proof) = match entry.node.as_table() {
            None => (entry.node.as_text().map(str::to_owned), ProofFacts { class, ..ProofFacts::default() }),
            Some(inner) => {
                (text(inner, "asks").map_err(at)?, proof_facts(inner, &["asks"], class).map_err(at)?)
            }
        };
        let asks = asks.ok_or_else(|| at(String::from("does not say what it asks")))?;
        Ok(RequirementClause { id, asks, proof })
    };
    list.entries.iter().map(clause).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clauses_read() {
        let text = "[\"controller:RB-02\"]\nasks = \"a\"\nsource = \"s\"\n[\"controller:RB-02\".clauses]\n\"8\" = \"b\"\n\"9\" = { asks = \"c\", profiles = [\"m241-2014\"] }\n";
        let register = RequirementRegister::read(text).unwrap();
        assert!(register.knows("controller:RB-02#8") && !register.knows("controller:RB-02#7"));
        assert_eq!(register.entries[0].clauses[1].proof.profiles, vec![Profile::M241_2014]);
        assert!(is_clause("reset-cold/retain") && !is_clause("Reset") && !is_clause("a/") && !is_clause(""));
    }

    #[test]
    fn entries_read() {
        let register = RequirementRegister::read(
            "[\"controller:WD-04\"]\nasks = \"a\"\nsource = \"s\"\nprofiles = [\"m241-2014\"]\nclass = \"constant\"\n",
        );
        let entry = register.unwrap().find("controller:WD-04").cloned().unwrap();
        assert_eq!(
            (entry.proof.class, entry.proof.profiles),
            (RequirementClass::Constant, vec![Profile::M241_2014])
        );
        assert!(RequirementRegister::read("[\"x\"]\nasks = \"a\"\n").is_err());
        assert!(RequirementRegister::read("[\"x\"]\nasks = \"a\"\nsource = \"s\"\nclass = \"y\"\n").is_err());
    }
    fn fault(keys: &str) -> String {
        let text = format!("[\"controller:WD-04\"]\nasks = \"a\"\nsource = \"s\"\n{keys}\n");
        RequirementRegister::read(&text).map_or_else(|error| error.fault, |_| String::new())
    }

    #[test]
    fn what_is_not_reproducible_has_a_reason_and_nothing_else() {
        assert_eq!(fault("class = \"not-reproducible\"\nreason = \"a drawing\""), "");
        for keys in [
            "class = \"not-reproducible\"",
            "reason = \"a drawing\"",
            "class = \"not-reproducible\"\nreason = \"\"",
            "class = \"not-reproducible\"\nreason = \"a drawing\"\nopen = \"plan\"",
            "clauses = { 1 = { asks = \"b\", class = \"not-reproducible\" } }",
            "class = \"not-reproducible\"\nreason = \"a drawing\"\nclauses = { 1 = \"b\" }",
        ] {
            assert_ne!(fault(keys), "", "{keys}");
        }
    }

    #[test]
    fn what_is_said_of_a_proof_is_one_of_few_words() {
        for keys in [
            "open = \"SD card\"",
            "decision = 66",
            "stand-in = \"a file\"",
            "clauses = { 1 = { asks = \"b\", open = \"plan\" } }",
        ] {
            assert_eq!(fault(keys), "", "{keys}");
        }
        for (keys, says) in [
            ("open = \"later\"", "it is one of CANopen"),
            ("decision = \"66\"", "no number of a decision"),
            ("decision = 0", "no number of a decision"),
            ("stand_in = \"a file\"", "no key `stand_in`"),
            ("profiles = \"m241-2014\"", "no list"),
            ("open = \"plan\"\nclauses = { 1 = \"b\" }", "of the clause"),
            ("clauses = { 1 = { asks = \"b\", why = \"c\" } }", "clause `1`: there is no key `why`"),
        ] {
            assert!(fault(keys).contains(says), "{keys}: {}", fault(keys));
        }
        assert!(OPEN.is_sorted());
    }
}
