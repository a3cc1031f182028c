//! CONFIGURATION: the tasks of an application and the programs that they run.

use super::ast::{Configuration, ProgramDecl, TaskDecl};
use super::lexer::Token;
use super::words::Word;
use super::{AlreadyReported, Parsed, Parser};
use crate::findings::SourcePlace;

impl Parser<'_, '_, '_> {
    pub(super) fn configuration(&mut self) -> Parsed<Configuration> {
        let at = self.expect_word(Word::Configuration)?;
        let name = self.new_name("the name of a configuration")?;
        let mut configuration =
            Configuration { name, globals: Vec::new(), tasks: Vec::new(), programs: Vec::new() };
        // The one controller is the one resource; its name and type say nothing more.
        let (mut resource, mut resources) = (None, 0);
        loop {
            let start = self.at();
            match self.word() {
                Some(Word::EndConfiguration) if resource.is_none() => {
                    self.advance();
                    return Ok(configuration);
                }
                Some(Word::EndResource) if resource.is_some() => {
                    self.advance();
                    resource = None;
                }
                Some(Word::Resource) if resource.is_none() => {
                    resources += 1;
                    if resources > 1 {
                        self.unsupported(start, "a second RESOURCE", "bring all tasks into one resource");
                    }
                    resource = Some(start);
                    if self.resource().is_err() {
                        self.recover_in_configuration(start);
                    }
                }
                Some(word) if word.closes_declaration() || word.opens_declaration() && self.is_foreign() => {
                    let (word, open) = match resource {
                        Some(open) => (Word::EndResource, open),
                        None => (Word::EndConfiguration, at),
                    };
                    self.unclosed(word, open);
                    if self.accept_word(Word::EndConfiguration) {
                        return Ok(configuration);
                    }
                    return Err(AlreadyReported);
                }
                _ if self.is(Token::End) => {
                    return Err(self.unclosed(Word::EndConfiguration, at));
                }
                _ => {
                    if self.inside_configuration(&mut configuration).is_err() {
                        self.recover_in_configuration(start);
                    }
                }
            }
        }
    }

    /// Whether what starts here is not part of a configuration.
    fn is_foreign(&self) -> bool {
        !matches!(self.word(), Some(Word::Program | Word::VarGlobal | Word::VarAccess | Word::VarConfig))
    }

    fn inside_configuration(&mut self, configuration: &mut Configuration) -> Parsed<()> {
        match self.word() {
            Some(Word::VarGlobal | Word::VarAccess | Word::VarConfig) => {
                configuration.globals.extend(self.section()?);
            }
            Some(Word::Task) => configuration.tasks.push(self.task()?),
            Some(Word::Program) => configuration.programs.push(self.program_of_task()?),
            _ if self.accept(Token::Semicolon) => {}
            _ => return Err(self.unexpected("RESOURCE, TASK, PROGRAM, VAR_GLOBAL or END_CONFIGURATION")),
        }
        Ok(())
    }

    /// `RESOURCE name ON type`
    fn resource(&mut self) -> Parsed<()> {
        self.expect_word(Word::Resource)?;
        self.new_name("the name of a resource")?;
        self.expect_word(Word::On)?;
        self.name("the type of the resource")?;
        Ok(())
    }

    /// To the next word that starts or closes something.
    fn recover_in_configuration(&mut self, start: SourcePlace) {
        if self.at() == start {
            self.advance();
        }
        while !self.is(Token::End) {
            let stops = match self.word() {
                Some(Word::Task | Word::Resource) => self.ahead(1).is_name(),
                Some(Word::EndResource) => true,
                Some(word) => word.closes_declaration() || word.opens_declaration(),
                None => false,
            };
            if stops {
                return;
            }
            self.advance();
        }
    }

    /// `TASK fast(INTERVAL := T#10ms, PRIORITY := 1);`
    fn task(&mut self) -> Parsed<TaskDecl> {
        self.expect_word(Word::Task)?;
        let name = self.new_name("the name of a task")?;
        self.expect(Token::Open, "an opening bracket (")?;
        let mut parameters = Vec::new();
        loop {
            let name = self.name("INTERVAL, PRIORITY or SINGLE")?;
            self.expect(Token::Assign, ":=")?;
            parameters.push((name, self.expression()?));
            if !self.accept(Token::Comma) {
                break;
            }
        }
        self.expect(Token::Close, "a comma or a closing bracket )")?;
        self.semicolon()?;
        Ok(TaskDecl { name, parameters })
    }

    /// `PROGRAM instance WITH task : type;`
    fn program_of_task(&mut self) -> Parsed<ProgramDecl> {
        let at = self.expect_word(Word::Program)?;
        if matches!(self.word(), Some(Word::Retain | Word::NonRetain | Word::Persistent)) {
            let help = "write RETAIN where the variables of the program are declared";
            self.unsupported(self.at(), "RETAIN for a whole program", help);
            self.advance();
        }
        let instance = self.new_name("the name of the instance")?;
        let task = if self.accept_word(Word::With) { Some(self.name("the name of a task")?) } else { None };
        self.expect(Token::Colon, "a colon and the name of a PROGRAM")?;
        let program = self.path_name("the name of a PROGRAM")?;
        if self.is(Token::Open) {
            let help = "let the program use its own addresses or global variables";
            self.unsupported(self.at(), "a connection to an instance of a program", help);
            self.skip_brackets();
        }
        let end = self.last;
        self.semicolon()?;
        Ok(ProgramDecl { instance, task, program, at: at.to(end) })
    }
}
