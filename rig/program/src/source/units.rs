//! TwinCAT's `.TcPOU`, `.TcDUT`, `.TcGVL`, `.TcIO`, and PLCopen XML with the declarations as text beside their elements:
//! an element for each unit, method, property and action, whose declaration and body stand apart. They become one text
//! in which every line has the number that it has in the file.

use super::SourceFault;
use super::xml::{XmlEvent, read};
use crate::parse::first_word;

/// Elements that have a declaration of their own.
const OWNERS: [&str; 9] = ["POU", "Itf", "DUT", "GVL", "Method", "Property", "Get", "Set", "Action"];

/// The name that TwinCAT has for an element of PLCopen XML.
fn known(name: &str) -> &str {
    match name {
        "pou" => "POU",
        "Interface" => "Itf",
        "dataType" => "DUT",
        "globalVars" => "GVL",
        "GetAccessor" => "Get",
        "SetAccessor" => "Set",
        "action" => "Action",
        "body" => "Implementation",
        "InterfaceAsPlainText" => "Declaration",
        other => other,
    }
}

/// The text of the units in a document.
pub(super) fn structured_text(text: &str) -> Result<String, SourceFault> {
    let mut taken = Taken { file: text, ..Taken::default() };
    read(text, |event, at| taken.take(event, at))?;
    if !taken.found {
        let help = "TwinCAT's files and PLCopen exports of CODESYS, with declarations as text, are read";
        return Err(SourceFault { help, ..SourceFault::new(0, "there is no Structured Text in this XML") });
    }
    if !taken.pending.is_empty() {
        taken.part();
        taken.flush();
    }
    Ok(taken.text)
}

/// What has been put together so far.
#[derive(Default)]
struct Taken<'t> {
    file: &'t str,
    text: String,
    /// Elements around the present place, outermost first.
    open: Vec<&'t str>,
    /// Words that stand in no text of the file: they open and close what the elements are.
    pending: Vec<String>,
    /// What closes the unit, once its declaration has been read.
    closer: Option<&'static str>,
    /// A declaration has been met.
    found: bool,
    /// For each of the elements around the present place that have declarations, whether it has been read.
    declared: Vec<bool>,
    /// A place in the file, and the characters before it in its line.
    seen: (usize, usize),
    /// Characters of the last line of the text.
    column: usize,
    /// Whether a remark up to the end of the line begins in the last line of the text.
    remark: bool,
}

impl<'t> Taken<'t> {
    fn take(&mut self, event: XmlEvent<'t>, at: usize) -> Result<(), SourceFault> {
        match event {
            XmlEvent::Break => {
                self.push("\n");
                self.flush();
            }
            XmlEvent::Text(text) => match self.open.last().copied() {
                Some("Declaration") if self.is_first_declaration() => self.declaration(&text, at),
                Some("ST") => self.content(&text, at),
                // Of no interest: only its lines count.
                _ => text.chars().filter(|c| *c == '\n').for_each(|_| self.push("\n")),
            },
            XmlEvent::Open(name, given) => {
                let name = match (name, self.open.last()) {
                    // Marks of text around text.
                    ("xhtml" | "p", Some(last)) => last,
                    _ => known(name),
                };
                self.opened(name, given, at)?;
                self.open.push(name);
                if OWNERS.contains(&name) {
                    self.declared.push(false);
                }
            }
            XmlEvent::Close(name) => {
                let name = known(name);
                self.open.pop();
                if OWNERS.contains(&name) {
                    self.declared.pop();
                }
                self.closed(name);
            }
        }
        Ok(())
    }

    /// Whether what declarations are of has none yet: some tools write them twice.
    fn is_first_declaration(&mut self) -> bool {
        self.declared.last_mut().is_some_and(|declared| !std::mem::replace(declared, true))
    }

    fn opened(&mut self, name: &str, given: &str, at: usize) -> Result<(), SourceFault> {
        if self.open.last() == Some(&"POU") && matches!(name, "Method" | "Action" | "Property" | "Transition")
        {
            self.close_unit();
        }
        if matches!(name, "NWL" | "FBD" | "LD" | "IL" | "SFC" | "CFC")
            && self.open.contains(&"Implementation")
        {
            let what = "this body is not in Structured Text";
            return Err(SourceFault { at, what, help: "write the body in Structured Text", language: true });
        }
        match name {
            "Action" => self.pending.push(format!("ACTION {given}:")),
            "Get" => self.pending.push("GET".to_owned()),
            "Set" => self.pending.push("SET".to_owned()),
            _ => {}
        }
        Ok(())
    }

    fn closed(&mut self, name: &str) {
        let word = match name {
            "Implementation" if self.open.last() == Some(&"POU") => return self.close_unit(),
            "POU" | "Itf" => return self.close_unit(),
            "Method" => "END_METHOD",
            "Action" => "END_ACTION",
            "Property" => "END_PROPERTY",
            "Get" => "END_GET",
            "Set" => "END_SET",
            _ => return,
        };
        self.pending.push(word.to_owned());
    }

    fn close_unit(&mut self) {
        self.pending.extend(self.closer.take().map(str::to_owned));
    }

    /// Divides what follows from what stands before: a remark up to the end of its line would swallow it.
    fn part(&mut self) {
        self.push(if self.remark { "\n" } else { " " });
    }

    /// Adds to the text, and keeps count of where its last line is: a file may be one line.
    fn push(&mut self, text: &str) {
        let line = match text.rfind('\n') {
            None => {
                self.remark |= text.starts_with('/') && self.text.ends_with('/');
                text
            }
            Some(end) => {
                (self.column, self.remark) = (0, false);
                text.get(end + 1..).unwrap_or("")
            }
        };
        self.column += line.chars().count();
        self.remark |= line.contains("//");
        self.text.push_str(text);
    }

    /// The characters before a place of the file in its line. Places come in their order.
    fn column_of(&mut self, at: usize) -> usize {
        let (from, column) = self.seen;
        let between = self.file.get(from..at).unwrap_or("");
        let column = match between.rfind('\n') {
            None => column + between.chars().count(),
            Some(end) => between.get(end + 1..).unwrap_or("").chars().count(),
        };
        self.seen = (at, column);
        column
    }

    /// Words that are still to be written come into the line here.
    fn flush(&mut self) {
        for word in std::mem::take(&mut self.pending) {
            self.push(&word);
            self.push(" ");
        }
    }

    fn declaration(&mut self, text: &str, at: usize) {
        self.found = true;
        let owner = self.open.iter().rev().find(|name| OWNERS.contains(name));
        if matches!(owner, Some(&"POU" | &"Itf")) {
            self.closer = match first_word(text).as_str() {
                "FUNCTION" => Some("END_FUNCTION"),
                "PROGRAM" => Some("END_PROGRAM"),
                "INTERFACE" => Some("END_INTERFACE"),
                _ => Some("END_FUNCTION_BLOCK"),
            };
        }
        self.content(text, at);
    }

    /// A text of the file, in the columns that it has there where there is room.
    fn content(&mut self, text: &str, at: usize) {
        if !self.pending.is_empty() {
            self.part();
            self.flush();
        }
        let missing = self.column_of(at).saturating_sub(self.column).max(1);
        self.push(&" ".repeat(missing));
        self.push(text);
    }
}

#[cfg(test)]
mod tests {
    use super::super::source;

    const FILE: &str = r#"<?xml version="1.0" encoding="utf-8"?>
<TcPlcObject Version="1.1.0.1">
  <POU Name="Lamp" Id="{1}" SpecialFunc="None">
    <Declaration><![CDATA[// PROGRAM is not what this is
{attribute 'x'}
FUNCTION_BLOCK Lamp
VAR n : INT; END_VAR
]]></Declaration>
    <Implementation>
      <ST><![CDATA[n := n + 1; // counts]]></ST>
    </Implementation>
    <Folder Name="more" />
    <Method Name="up"><Declaration><![CDATA[METHOD up : INT]]></Declaration>
      <Implementation><ST><![CDATA[up := n;]]></ST></Implementation></Method>
    <Property Name="level">
      <Declaration><![CDATA[PROPERTY level : INT]]></Declaration>
      <Get Name="Get"><Declaration><![CDATA[VAR
END_VAR
]]></Declaration><Implementation><ST><![CDATA[level := n;]]></ST></Implementation></Get>
    </Property>
    <Action Name="off">
      <Implementation><ST>n := 0 &lt;&gt; 0;</ST></Implementation>
    </Action>
    <LineIds Name="Lamp"><LineId Id="3" Count="0" /></LineIds>
  </POU>
</TcPlcObject>
"#;

    #[test]
    fn lines_keep_their_numbers() {
        let text = source("Lamp.TcPOU", FILE.as_bytes()).unwrap().text;
        assert_eq!(text.lines().count(), FILE.lines().count());
        for wanted in ["n := n + 1;", "METHOD up : INT", "level := n;", "FUNCTION_BLOCK Lamp"] {
            let at = |text: &str| text.lines().position(|line| line.contains(wanted));
            assert_eq!(at(&text), at(FILE), "{wanted} in\n{text}");
        }
        let words: Vec<&str> = text.split_whitespace().filter(|word| word.starts_with("END_")).collect();
        let closers = ["END_VAR", "END_FUNCTION_BLOCK", "END_METHOD", "END_VAR", "END_GET"];
        assert_eq!(words.get(..5).unwrap(), closers.as_slice());
        assert_eq!(words.get(5..).unwrap(), ["END_PROPERTY", "END_ACTION"]);
        assert!(text.contains("ACTION off:") && text.contains("n := 0 <> 0;"));
    }

    const EXPORT: &str = r#"<project xmlns="http://www.plcopen.org/xml/tc6_0200"><types>
<dataTypes><dataType name="Kind"><baseType><enum/></baseType><addData><data><InterfaceAsPlainText>
<xhtml xmlns="x">TYPE Kind : (low, high); END_TYPE</xhtml></InterfaceAsPlainText></data></addData></dataType></dataTypes>
<pous><pou name="Pump" pouType="functionBlock"><interface><localVars><variable name="n"><type><INT/></type></variable>
</localVars><addData><data><InterfaceAsPlainText><xhtml>FUNCTION_BLOCK Pump
VAR n : INT; END_VAR</xhtml></InterfaceAsPlainText></data></addData></interface>
<actions><action name="stop"><body><ST><xhtml>n := 0;</xhtml></ST></body></action></actions>
<body><ST><xhtml>IF n &lt; 5 THEN n := n + 1; END_IF</xhtml></ST></body>
<addData><data><Method name="get"><interface><addData><data><InterfaceAsPlainText><xhtml>METHOD get : INT</xhtml>
</InterfaceAsPlainText></data></addData></interface><body><ST><xhtml>get := n;</xhtml></ST></body></Method></data>
<data><InterfaceAsPlainText><xhtml>FUNCTION_BLOCK Pump</xhtml></InterfaceAsPlainText></data></addData></pou></pous>
</types></project>
"#;

    #[test]
    fn broken_files_are_refused_and_nothing_worse() {
        for text in [FILE, EXPORT] {
            for end in 0..text.len() {
                let whole = text.get(end..).is_none_or(|rest| rest.trim().is_empty());
                let bytes = text.as_bytes().get(..end).unwrap();
                assert!(whole || end == 0 || source("a.TcPOU", bytes).is_err(), "{end}");
                // The other half, and each byte missing once.
                let _ = source("a.TcPOU", text.as_bytes().get(end..).unwrap());
                let mut bytes = text.as_bytes().to_vec();
                bytes.remove(end);
                let _ = source("a.TcPOU", &bytes);
            }
        }
    }

    #[test]
    fn exports_of_projects_are_read() {
        let text = source("plant.xml", EXPORT.as_bytes()).unwrap().text;
        assert_eq!(text.lines().count(), EXPORT.lines().count());
        let words: Vec<&str> = text.split_whitespace().collect();
        let expected = "TYPE Kind : (low, high); END_TYPE FUNCTION_BLOCK Pump VAR n : INT; END_VAR ACTION stop: \
                        n := 0; END_ACTION IF n < 5 THEN n := n + 1; END_IF END_FUNCTION_BLOCK METHOD get : INT \
                        get := n; END_METHOD";
        assert_eq!(words, expected.split_whitespace().collect::<Vec<_>>());
        let typed = "<project><pous><pou name='a'><interface/><body><ST><xhtml>a := 1;</xhtml></ST></body></pou></pous></project>";
        assert_eq!(source("plant.xml", typed.as_bytes()).unwrap_err().code, "S0102");
    }
}
