//! `rig judge`.

use crate::args::JudgeArgs;
use crate::exit::Exit;
use crate::output;
use record::CaseRecord;
use reports::text::{Style, case_line, details};
use runtime::suite::{self, Disk};
use signal::{LoadLimits, Trace};
use std::fs::File;
use std::io::{BufRead, BufReader};

/// Judges a recorded trace again.
pub fn run(args: &JudgeArgs) -> Exit {
    let path = args.trace.display();
    let mut file = match File::open(&args.trace) {
        Ok(file) => BufReader::new(file),
        Err(error) => {
            output::complain(&format!("{path} cannot be read: {error}"));
            return Exit::UserFiles;
        }
    };
    let trace = match Trace::load(&mut file, LoadLimits::default()) {
        Ok(trace) => trace,
        Err(error) => {
            output::complain(&format!("{path} is no whole trace: {error}"));
            return Exit::UserFiles;
        }
    };
    // A trace says where it ends; what stands behind it is of no trace.
    if !file.fill_buf().is_ok_and(<[u8]>::is_empty) {
        output::complain(&format!("{path} is no whole trace: something stands behind its end"));
        return Exit::UserFiles;
    }
    let mut sources = Vec::new();
    match judge(&args.plan.to_string_lossy(), &trace, &mut sources) {
        Ok(record) => {
            let style = Style { color: output::color_out(), quiet: false };
            let (line, details) = (case_line(&record, style), details(&record, style));
            output::print(&format!("{}\n{details}  trace  {}\n", line.trim_end(), record.trace_sha256));
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
