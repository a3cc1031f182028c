//! Measurements and claims as CSV (RFC 4180), a line each, for spreadsheets and statistics.
//!
//! Numbers are plain decimals in the unit that stands beside them; what is not there is an empty field. A text that
//! a spreadsheet would take for a formula has an apostrophe in front.

use crate::show::{self, ShownOutcome, clean};
use record::{CaseRecord, Figure, RunRecord};

/// Header of [`measurements`].
const MEASUREMENTS: &str = "case,profile,name,verdict,low,high,unit,min,max,margin,margin_unit,from_earliest_ns,\
from_latest_ns,to_earliest_ns,to_latest_ns,signal,seed,reason,plan,line,guard,coverage";

/// Header of [`claims`].
const CLAIMS: &str = "case,profile,name,verb,verdict,margin,margin_unit,uncertainty,uncertainty_unit,\
deciding_earliest_ns,deciding_latest_ns,signal,expected,observed,seed,reason,plan,line";

/// Every measurement of every judged case. Limits are those that the value was judged by, whichever way they were
/// given; a value that was never taken has none.
pub fn measurements(run: &RunRecord) -> String {
    let mut table = CsvTable::new(MEASUREMENTS);
    for case in judged(run) {
        for m in &case.measurements {
            let (min, max) = show::bounds(m);
            let mut row = table.row();
            row.texts([&case.name, &case.profile, &m.name, m.verdict.word()]);
            row.number(m.value.map(|[low, _]| low));
            row.number(m.value.map(|[_, high]| high));
            row.text(&m.unit);
            row.number(min);
            row.number(max);
            row.figure(m.margin.as_ref());
            row.interval(m.from_ns);
            row.interval(m.to_ns);
            row.text(m.signal.as_deref().unwrap_or_default());
            row.origin(case, &m.reason, m.line);
            row.text(if m.guard_band.is_uncertainty() { "uncertainty" } else { "none" });
            row.text(&m.coverage);
        }
    }
    table.out
}

/// Every claim of every judged case.
pub fn claims(run: &RunRecord) -> String {
    let mut table = CsvTable::new(CLAIMS);
    for case in judged(run) {
        for claim in &case.claims {
            let mut row = table.row();
            row.texts([&case.name, &case.profile, &claim.name, &claim.verb, claim.verdict.word()]);
            row.figure(claim.margin.as_ref());
            row.figure(claim.uncertainty.as_ref());
            row.interval(claim.deciding_ns);
            row.text(claim.signal.as_deref().unwrap_or_default());
            row.texts([&claim.expected, &claim.observed]);
            row.origin(case, &claim.reason, claim.line);
        }
    }
    table.out
}

fn judged(run: &RunRecord) -> impl Iterator<Item = &CaseRecord> {
    run.cases.iter().filter(|case| matches!(ShownOutcome::of(case), ShownOutcome::Judged(_)))
}

/// Rows under a header.
struct CsvTable {
    out: String,
}

impl CsvTable {
    fn new(header: &str) -> CsvTable {
        CsvTable { out: format!("{header}\r\n") }
    }

    fn row(&mut self) -> CsvRow<'_> {
        CsvRow { out: &mut self.out, first: true }
    }
}

/// A row, which ends when it is dropped.
struct CsvRow<'a> {
    out: &'a mut String,
    first: bool,
}

impl Drop for CsvRow<'_> {
    fn drop(&mut self) {
        self.out.push_str("\r\n");
    }
}

impl CsvRow<'_> {
    fn field(&mut self, text: &str) {
        if !std::mem::take(&mut self.first) {
            self.out.push(',');
        }
        self.out.push_str(text);
    }

    fn text(&mut self, text: &str) {
        let text = clean(text);
        let guard = if text.starts_with(['=', '+', '-', '@']) { "'" } else { "" };
        if text.contains([',', '"']) || !guard.is_empty() {
            self.field(&format!("\"{guard}{}\"", text.replace('"', "\"\"")));
        } else {
            self.field(&text);
        }
    }

    fn texts<const N: usize>(&mut self, texts: [&str; N]) {
        texts.into_iter().for_each(|text| self.text(text));
    }

    fn number(&mut self, number: Option<f64>) {
        self.field(&number.map_or(String::new(), |number| number.to_string()));
    }

    fn figure(&mut self, figure: Option<&Figure>) {
        self.number(figure.map(|figure| figure.value));
        self.text(figure.map_or("", |figure| &figure.unit));
    }

    fn interval(&mut self, interval: Option<[i64; 2]>) {
        for end in 0..2 {
            self.field(&interval.map_or(String::new(), |ends| ends[end].to_string()));
        }
    }

    /// The columns at the end of every row.
    fn origin(&mut self, case: &CaseRecord, reason: &str, line: u32) {
        self.field(&case.seed.to_string());
        self.texts([reason, &case.plan]);
        self.field(&if line == 0 { String::new() } else { line.to_string() });
    }
}
