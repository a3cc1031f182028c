//! The instrument file: what an instrument that records captures says of the errors of its clock and its channels.
//!
//! ```toml
//! format = 1
//! title = "Oscilloscope of the bench"
//! [timebase]
//! error = "25 ppm"
//! resolution = "10 ns"
//! [channels.CH1]
//! unit = "V"
//! threshold = "2.5 V"
//! hysteresis = "200 mV"
//! accuracy = { of-value = "1.5 %", plus = "50 mV", coverage = "95 %" }
//! ```

use crate::codes;
use crate::suite::describe::sha256;
use crate::suite::file_source::{FileSource, load};
use capture::{ChannelErrors, InstrumentErrors, ReadingError, TimebaseErrors};
use document::{
    Codes, Data, Diagnostic, Entry, Fields, Findings, KeySpec, KeyType, Node, SourceFile, Table, toml,
};
use drivers::file::Statement;
use drivers::file::accuracy::{self, AccuracyCodes, COVERAGE, OF_VALUE, PLUS};
use drivers::file::clock::clock_error;
use drivers::file::statements::of_table;
use record::{InstrumentRecord, InstrumentStatement};
use signal::{Coverage, Span};
use std::ops::Range;

/// The keys of an instrument file.
pub const KEYS: &[KeySpec] = &[
    KeySpec::required("format", KeyType::Integer(1, i64::MAX), "Version of the format: 1"),
    KeySpec::optional("title", KeyType::Text, "What the instrument is, in a line"),
    KeySpec::optional("timebase", KeyType::Table(TIMEBASE), "The clock that stamps all channels"),
    KeySpec::optional(
        "channels",
        KeyType::Map(&KeyType::Table(CHANNEL)),
        "The channels, by their names in the capture",
    ),
];

const TIMEBASE: &[KeySpec] = &[
    KeySpec::optional(
        "error",
        KeyType::Quantity,
        "How far its rate may be off, either way, as in \"25 ppm\"; 0",
    ),
    KeySpec::optional(
        "offset",
        KeyType::Text,
        "What is subtracted from each stamp, so that it counts from the instant that --start and --at name by a time; may be below 0",
    ),
    KeySpec::optional("offset-error", KeyType::Duration, "How far the offset may be off, either way; 0"),
    KeySpec::optional(
        "resolution",
        KeyType::Duration,
        "The step of its stamps: an instant is known to within one, either way; 0",
    ),
    KeySpec::optional(
        "skew",
        KeyType::Duration,
        "The greatest distance between the stamps that two channels give one instant; 0",
    ),
    COVERAGE,
];

const CHANNEL: &[KeySpec] = &[
    KeySpec::optional("unit", KeyType::Text, "The unit of its values in the capture, as in \"V\"; none"),
    KeySpec::optional(
        "delay",
        KeyType::Text,
        "How much later than the instant its stamp is, which is subtracted; may be below 0",
    ),
    KeySpec::optional("delay-error", KeyType::Duration, "How far the delay may be off, either way; 0"),
    KeySpec::optional(
        "threshold",
        KeyType::Quantity,
        "Where it is a line: TRUE above this and half of the hysteresis",
    ),
    KeySpec::optional(
        "hysteresis",
        KeyType::Quantity,
        "Distance of the thresholds of TRUE and FALSE; between them it is what it was; 0",
    ),
    KeySpec::optional("accuracy", KeyType::Table(ACCURACY), "How far its readings may be off, either way"),
];

const ACCURACY: &[KeySpec] = &[OF_VALUE, PLUS, COVERAGE];

const TOML: Codes = Codes {
    syntax: codes::INSTRUMENT_NOT_READ,
    newer_toml: codes::INSTRUMENT_NOT_READ,
    too_large: codes::INSTRUMENT_NOT_READ,
    unknown_key: codes::INSTRUMENT_KEY,
    missing_key: codes::INSTRUMENT_KEY,
    wrong_type: codes::INSTRUMENT_KEY,
    unreadable: codes::INSTRUMENT_KEY,
};

const FIGURES: AccuracyCodes =
    AccuracyCodes { unit: codes::INSTRUMENT_ERROR, figure: codes::INSTRUMENT_ERROR };

/// An instrument file that was read and is sound.
#[derive(Clone, Debug, PartialEq)]
pub struct InstrumentFile {
    /// Path as the user gave it.
    pub name: String,
    /// Its text.
    pub text: String,
    /// Its title; may be empty.
    pub title: String,
    /// The errors of its clock.
    pub timebase: TimebaseErrors,
    /// What these, and the delays of the channels, cover.
    pub coverage: Coverage,
    /// The channels, in the order of the file.
    pub channels: Vec<InstrumentChannel>,
    /// What it states, in the order of the file.
    pub statements: Vec<InstrumentStatement>,
}

/// A channel of an instrument.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InstrumentChannel {
    /// Its name in the capture.
    pub name: String,
    /// Where the file names it.
    pub place: Range<usize>,
    /// The unit of all its figures, as it is written; empty for none.
    pub unit: String,
    /// What its stamps may be off.
    pub errors: ChannelErrors,
    /// Where it is a line, the middle between both levels.
    pub threshold: Option<f64>,
    /// Distance of the thresholds of both levels; at least 0.
    pub hysteresis: f64,
    /// What its readings may be off.
    pub error: ReadingError,
    /// What that covers.
    pub coverage: Coverage,
}

impl InstrumentFile {
    /// The channel of this name.
    pub fn channel(&self, name: &str) -> Option<&InstrumentChannel> {
        self.channels.iter().find(|channel| channel.name == name)
    }

    /// What its stamps may be off.
    pub fn errors(&self) -> InstrumentErrors {
        let channels = self.channels.iter().map(|channel| (channel.name.clone(), channel.errors));
        InstrumentErrors { timebase: self.timebase, channels: channels.collect() }
    }

    /// What a record says of it.
    pub fn record(&self) -> InstrumentRecord {
        InstrumentRecord {
            file: self.name.clone(),
            title: self.title.clone(),
            sha256: sha256(self.text.as_bytes()),
            statements: self.statements.clone(),
        }
    }
}

/// Loads an instrument file and reads it.
///
/// # Errors
/// R0201 where there is no such file, and everything that is wrong with it: R0210 to R0212, by place.
pub fn load_instrument(
    files: &dyn FileSource,
    path: &str,
    sources: &mut Vec<SourceFile>,
) -> Result<InstrumentFile, Vec<Diagnostic>> {
    let file = load(files, path).map_err(|found| vec![found])?;
    sources.push(file.clone());
    read(&file)
}

/// Reads an instrument file.
///
/// # Errors
/// Everything that is wrong with it, by place: R0210 to R0212.
pub fn read(file: &SourceFile) -> Result<InstrumentFile, Vec<Diagnostic>> {
    let tree = toml::parse(file, TOML)?;
    let mut out = Findings::new(file, TOML);
    let fields = Fields::check(&tree, 0..0, "instrument file", KEYS, &mut out);
    if let Some(node) = fields.get("format").filter(|node| node.data != Data::Integer(1)) {
        out.bad(codes::INSTRUMENT_KEY, node, "this format is not supported", "write format = 1");
    }
    if out.has_errors() {
        return Err(out.into_vec());
    }
    let clock = fields.inner("timebase");
    let timebase = clock.as_ref().map(|clock| timebase(clock, &mut out)).unwrap_or_default();
    let entries = fields.get("channels").and_then(Node::as_table).map_or(&[][..], |table| &table.entries);
    if let Some(one) = entries.get(MOST_CHANNELS) {
        let message = format!("the file has {} channels", entries.len());
        let help = format!("leave {MOST_CHANNELS} at most: those that are mapped to signals");
        out.error(codes::INSTRUMENT_ERROR, one.key_span.clone(), message, help);
    }
    let mut channels = Vec::new();
    for entry in entries {
        let Some(table) = entry.node.as_table() else { continue };
        channels.extend(channel(entry, &Fields::checked(table, CHANNEL), &mut out));
    }
    let coverage = clock.and_then(|clock| clock_coverage(&clock, &timebase, &channels, &mut out));
    if out.has_errors() {
        return Err(out.into_vec());
    }
    Ok(InstrumentFile {
        name: file.name.clone(),
        text: file.text.clone(),
        title: fields.text("title").unwrap_or_default().to_owned(),
        timebase,
        coverage: coverage.unwrap_or_default(),
        channels,
        statements: statements(&tree),
    })
}

fn timebase(fields: &Fields, out: &mut Findings) -> TimebaseErrors {
    let span = |key| fields.duration(key).unwrap_or(Span::ZERO);
    let rate = fields.get("error").and_then(|node| clock_error(node, codes::INSTRUMENT_ERROR, out));
    TimebaseErrors {
        rate: rate.unwrap_or_default(),
        offset: moved(fields, "offset", out),
        offset_error: span("offset-error"),
        resolution: span("resolution"),
        skew: span("skew"),
    }
}

/// What the figures of the clock cover, and with them those of the delays of channels. `None` where it is wrong, which is reported.
fn clock_coverage(
    clock: &Fields,
    errors: &TimebaseErrors,
    channels: &[InstrumentChannel],
    out: &mut Findings,
) -> Option<Coverage> {
    let spans = [errors.offset_error, errors.resolution, errors.skew];
    let delays = channels.iter().map(|channel| channel.errors.delay_error);
    // Of a file with other findings it is not known what it states.
    let is_off = out.has_errors()
        || !errors.rate.is_none()
        || spans.into_iter().chain(delays).any(|error| error > Span::ZERO);
    let help = "write how far the clock may be off, as in error = \"25 ppm\" or resolution = \"10 ns\", or remove `coverage`";
    accuracy::covers_something(clock, is_off, help, FIGURES, out)?;
    clock.get("coverage").and_then(|node| accuracy::coverage(node, FIGURES, out))
}

/// The most channels of a file: each is looked for among those of a capture.
const MOST_CHANNELS: usize = 256;

/// The most that stamps are moved by, days: what counts from 1970 has less.
const MOST_MOVED: i64 = 36_500;

/// A duration that may be below 0; 0 where there is none.
fn moved(fields: &Fields, key: &str, out: &mut Findings) -> Span {
    let Some(node) = fields.get(key) else { return Span::ZERO };
    let most = Span::from_nanos(MOST_MOVED * 86_400_000_000_000);
    let read = node.as_text().and_then(|text| Span::parse(text).ok());
    if let Some(span) = read.filter(|span| span.as_nanos().unsigned_abs() > most.as_nanos().unsigned_abs()) {
        let message = format!("`{key}` moves stamps by {span}");
        out.bad(codes::INSTRUMENT_ERROR, node, message, format!("write at most {MOST_MOVED} d"));
    }
    if read.is_none() {
        let help = "write a duration such as \"10 ns\" or \"-1.2 us\"";
        out.bad(codes::INSTRUMENT_ERROR, node, format!("`{key}` does not read as a duration"), help);
    }
    read.unwrap_or_default()
}

/// `None` where something is wrong with it, which is reported.
fn channel(named: &Entry, fields: &Fields, out: &mut Findings) -> Option<InstrumentChannel> {
    let name = &named.key;
    let unit = fields.text("unit").unwrap_or_default();
    let threshold = fields.get("threshold").map(|node| accuracy::quantity(node, unit, FIGURES, out));
    let hysteresis = fields.get("hysteresis").map(|node| accuracy::width(node, unit, FIGURES, out));
    if let (Some(entry), None) = (fields.entry("hysteresis"), &threshold) {
        let message = format!("the channel `{name}` has a hysteresis and no threshold");
        let help = "add `threshold`: the middle between the levels of TRUE and FALSE";
        out.error(codes::INSTRUMENT_ERROR, entry.key_span.clone(), message, help);
    }
    let delay = moved(fields, "delay", out);
    let stated = accuracy::accuracy(fields, unit, FIGURES, out)?;
    Some(InstrumentChannel {
        name: name.clone(),
        place: named.key_span.clone(),
        unit: unit.to_owned(),
        errors: ChannelErrors { delay, delay_error: fields.duration("delay-error").unwrap_or_default() },
        threshold: threshold.map_or(Some(None), |read| read.map(Some))?,
        hysteresis: hysteresis.unwrap_or(Some(0.0))?,
        error: ReadingError { of_value: stated.of_value, plus: stated.plus },
        coverage: stated.coverage,
    })
}

/// What a file states, as it is written.
fn statements(tree: &Table) -> Vec<InstrumentStatement> {
    let mut stated = Vec::new();
    if let Some(table) = tree.get("timebase").and_then(Node::as_table) {
        of_table(table, "timebase", &|_| true, &mut stated);
    }
    for entry in tree.get("channels").and_then(Node::as_table).map_or(&[][..], |table| &table.entries) {
        if let Some(table) = entry.node.as_table() {
            of_table(table, &entry.key, &|_| true, &mut stated);
        }
    }
    stated.into_iter().map(recorded).collect()
}

/// A statement as records have it.
pub(crate) fn recorded(statement: Statement) -> InstrumentStatement {
    let Statement { of, key, value } = statement;
    InstrumentStatement { of, key, value }
}

#[cfg(test)]
mod tests {
    use super::*;
    use signal::ClockError;

    fn file(text: &str) -> SourceFile {
        SourceFile::new("scope.toml", format!("format = 1\n{text}"))
    }

    fn good(text: &str) -> InstrumentFile {
        read(&file(text)).unwrap_or_else(|found| panic!("{text}: {found:#?}"))
    }

    #[test]
    fn an_instrument_file_reads() {
        let read = good(
            "title = \"Scope\"\n[timebase]\nerror = \"25 ppm\"\noffset = \"-1.2 us\"\noffset-error = \"50 ns\"\n\
             resolution = \"10 ns\"\nskew = \"2 ns\"\ncoverage = \"k = 2\"\n[channels.CH1]\nunit = \"V\"\ndelay = \"5 ns\"\n\
             delay-error = \"1 ns\"\nthreshold = \"2.5 V\"\nhysteresis = \"200 mV\"\n\
             accuracy = { of-value = \"1.5 %\", plus = \"50 mV\", coverage = \"95 %\" }\n",
        );
        let ns = Span::from_nanos;
        let timebase = TimebaseErrors {
            rate: ClockError::from_parts(25_000_000).unwrap(),
            offset: ns(-1_200),
            offset_error: ns(50),
            resolution: ns(10),
            skew: ns(2),
        };
        assert_eq!(read.timebase, timebase);
        let channel = read.channel("CH1").unwrap();
        assert_eq!(channel.errors, ChannelErrors { delay: ns(5), delay_error: ns(1) });
        assert_eq!((channel.threshold, channel.hysteresis), (Some(2.5), 0.2));
        assert_eq!(channel.error, ReadingError { of_value: 0.015, plus: 0.05 });
        assert_eq!(
            (read.coverage.to_string(), channel.coverage.to_string()),
            ("k = 2".into(), "95 %".into())
        );
        let stated: Vec<String> =
            read.statements.iter().map(|one| format!("{} {} = {}", one.of, one.key, one.value)).collect();
        assert_eq!(stated[0], "timebase error = 25 ppm");
        assert_eq!(stated.last().unwrap(), "CH1 accuracy.coverage = 95 %");
        assert_eq!(stated.len(), 14);
    }

    #[test]
    fn a_rate_is_counted_finely_and_never_too_small() {
        let of = |text: &str| good(&format!("[timebase]\nerror = \"{text}\"")).timebase.rate;
        let parts = |parts| ClockError::from_parts(parts).unwrap();
        assert_eq!(of("1 ppm"), parts(1_000_000));
        assert_eq!(of("0.0025 %"), parts(25_000_000));
        assert_eq!(of("10 %"), ClockError::MAX);
        assert_eq!(of("0.0000001 ppm"), parts(1));
        assert_eq!(good("").timebase, TimebaseErrors::default());
    }

    #[test]
    fn a_coverage_of_the_clock_is_that_of_delays_too() {
        good("[timebase]\ncoverage = \"95 %\"\n[channels.CH1]\ndelay-error = \"1 ns\"");
    }

    #[test]
    fn what_no_instrument_has_is_refused() {
        for (text, code) in [
            ("[timebase", "R0210"),
            ("[time-base]", "R0211"),
            ("[timebase]\nresolution = 10", "R0211"),
            ("[timebase]\nskew = \"-1 ns\"", "R0211"),
            ("[timebase]\nerror = \"-1 ppm\"", "R0212"),
            ("[timebase]\nerror = \"11 %\"", "R0212"),
            ("[timebase]\nerror = \"1 V\"", "R0212"),
            ("[timebase]\nerror = 25", "R0212"),
            ("[timebase]\noffset = \"soon\"", "R0212"),
            ("[timebase]\nerror = \"1e308 %\"", "R0212"),
            ("[timebase]\noffset = \"-9223372036854775808 ns\"", "R0212"),
            ("[channels.CH1]\ndelay = \"100000 d\"", "R0212"),
            ("[channels.CH1]\naccuracy = { of-value = 0.015 }", "R0212"),
            ("[timebase]\ncoverage = \"often\"", "R0212"),
            ("[channels.CH1]\nthreshold = \"2.5 V\"", "R0212"),
            ("[channels.CH1]\nunit = \"V\"\nthreshold = \"2.5 A\"", "R0212"),
            ("[channels.CH1]\nhysteresis = 1", "R0212"),
            ("[channels.CH1]\nthreshold = 1\nhysteresis = -1", "R0212"),
            ("[channels.CH1]\naccuracy = { of-value = \"-1 %\" }", "R0212"),
            ("[channels.CH1]\naccuracy = { of-value = \"1 %\", coverage = \"100 %\" }", "R0212"),
            ("[channels.CH1]\naccuracy = { of-range = \"1 %\" }", "R0211"),
            // An error that was forgotten, or is none: nothing would be known with this probability.
            ("[timebase]\nerror = \"0 ppm\"\ncoverage = \"95 %\"", "R0212"),
            ("[timebase]\nerror = 0\nresolution = \"0 ns\"\nskew = \"0 s\"\ncoverage = \"k = 2\"", "R0212"),
            ("[timebase]\ncoverage = \"95 %\"\n[channels.CH1]\ndelay-error = \"0 ns\"", "R0212"),
            ("[channels.CH1]\nunit = \"V\"\naccuracy = { plus = \"0 V\", coverage = \"95 %\" }", "R0212"),
            (
                "[channels.CH1]\nunit = \"V\"\naccuracy = { of-value = \"0 %\", plus = 0, coverage = \"95 %\" }",
                "R0212",
            ),
            ("[timebase]\ncoverage = \"95 %\"", "R0212"),
            ("[timebase]\noffset = \"1 us\"\ncoverage = \"95 %\"", "R0212"),
            ("[channels.CH1]\naccuracy = { coverage = \"95 %\" }", "R0212"),
        ] {
            let found = read(&file(text)).expect_err(text);
            assert_eq!(found[0].code, code, "{text}: {found:?}");
            assert!(!found[0].message.is_empty());
        }
        let other = read(&SourceFile::new("scope.toml", "format = 2")).unwrap_err();
        assert_eq!(other[0].code, "R0211");
    }
}
