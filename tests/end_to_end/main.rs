//! The `rig` command as a user meets it: arguments and files in; exit code, output and reports out.

mod arguments;
mod bench;
mod broken;
mod check;
mod codes;
mod corpus;
mod fail;
mod goldens;
mod interrupt;
mod judge;
mod program;
mod report;
mod requirements;
mod selection;
mod verdicts;
