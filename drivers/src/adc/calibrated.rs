//! The calibrations of a board, for its record.

use document::Diagnostic;
use signal::calendar::Date;

use super::AdcsSpec;
use crate::channel_table::ChannelTable;
use crate::codes;

/// A channel with a calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibrated {
    /// Its name.
    pub channel: String,
    /// What the calibration rests on, in words.
    pub words: String,
    /// That it counts no longer.
    pub expired: Option<Diagnostic>,
}

/// The calibrated channels of a board as they stand on this day.
pub(crate) fn calibrated(table: &ChannelTable, spec: &AdcsSpec, today: Date) -> Vec<Calibrated> {
    let of = |sample: &super::SampleSpec| {
        let certificate = sample.certificate.as_ref()?;
        let channel = table.channels.get(usize::from(sample.channel.0))?.name.clone();
        let expired = certificate.is_expired(today).then(|| {
            let message = format!("the calibration of `{channel}` has expired: {certificate}");
            Diagnostic::warning(codes::EXPIRED, message)
                .at(table.file.clone(), sample.certificate_place.clone(), "")
                .help("calibrate the channel and write its new points and dates")
        });
        let late = if expired.is_some() { ": expired" } else { "" };
        Some(Calibrated { words: format!("{certificate}{late}"), channel, expired })
    };
    spec.samples.iter().filter_map(of).collect()
}
