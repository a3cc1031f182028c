//! `rig judge`.

use crate::args::JudgeArgs;
use crate::exit::Exit;
use crate::output;
use record::CaseRecord;
use reports::text::{Style, case_line, details};
use runtime::suite::{self, Disk};
use signal::{LoadLimits, Trace};
use std::fs::File;
use std::io::BufReader;

/// Judges a recorded trace again.
pub fn run(args: &JudgeArgs) -> Exit {
    let path = args.trace.display();
    let trace = match File::open(&args.trace) {
        Ok(file) => Trace::load(&mut BufReader::new(file), LoadLimits::default()),
        Err(error) => {
            output::complain(&format!("{path} cannot be read: {error}"));
            return Exit::UserFiles;
        }
    };
    let trace = match trace {
        Ok(trace) => trace,
        Err(error) => {
            output::complain(&format!("{path} is no whole trace: {error}"));
            return Exit::UserFiles;
        }
    };
    let mut sources = Vec::new();
    match judge(&args.plan.to_string_lossy(), &trace, &mut sources) {
        Ok(record) => {
            let style = Style { color: output::color_out(), quiet: false };
            output::print(&format!("{}\n{}", case_line(&record, style).trim_end(), details(&record, style)));
            Exit::of(record.verdict)
        }
        Err(found) => {
            output::findings(&found, &sources);
            Exit::UserFiles
        }
    }
}

fn judge(
    path: &str,
    trace: &Trace,
    sources: &mut Vec<document::SourceFile>,
) -> Result<CaseRecord, Vec<document::Diagnostic>> {
    let file = suite::load(&Disk, path).map_err(|found| vec![found])?;
    sources.push(file.clone());
    runtime::rejudge::judge(&file, trace)
}
