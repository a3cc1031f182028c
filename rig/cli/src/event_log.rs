//! `RUST_LOG`: what the threads beside the scan are at, on standard error, for whoever looks for a fault of a bench.

use crate::output;
use document::Diagnostic;
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::prelude::*;

/// The variable that says what is logged.
const VARIABLE: &str = "RUST_LOG";

/// What all parts of the rig are called by: the names of its crates begin with it.
const PARTS: &str = "scanrig";

/// Logs what `RUST_LOG` asks for: a level (`debug`), or levels of parts (`scanrig_drivers=debug`). Without it nothing is
/// logged, and a text that is no filter is a warning. Not where the screen is taken.
pub fn start() {
    let Some(text) = std::env::var_os(VARIABLE).filter(|text| !text.is_empty()) else { return };
    match filter(&text.to_string_lossy()) {
        Ok(filter) => {
            let lines =
                tracing_subscriber::fmt::layer().with_writer(|| output::ErrorStream).with_thread_names(true);
            // A closed standard error is no fault.
            let lines = lines.log_internal_errors(false);
            // It is the first and the only one.
            let _ = tracing_subscriber::registry().with(lines.with_filter(filter)).try_init();
        }
        Err(why) => {
            let found = Diagnostic::warning("R0226", format!("{VARIABLE} is not understood: {why}"));
            let help = "name a level (off, error, warn, info, debug, trace), or levels of parts, as in \
                        RUST_LOG=scanrig_drivers=debug,scanrig_services=info";
            output::findings(&[found.help(help)], &[]);
        }
    }
}

/// The filter that a text means.
fn filter(text: &str) -> Result<Targets, String> {
    let directives: Vec<&str> = text.split(',').map(str::trim).collect();
    for directive in &directives {
        let directive = *directive;
        // The library takes a word that is no level for a part of which everything is wanted, and would log nothing.
        let part = directive.split_once('=').map_or(directive, |(part, _)| part);
        // An empty word would be read as a level.
        let is_level = part == directive && !part.is_empty() && part.parse::<LevelFilter>().is_ok();
        if !is_level && !part.starts_with(PARTS) {
            return Err(format!("`{part}` is neither a level nor a part of the rig"));
        }
    }
    // Without the blanks, which the library takes for a part of the words.
    directives.join(",").parse().map_err(|_| format!("`{text}` has a level that there is not"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use tracing_subscriber::filter::LevelFilter;

    #[test]
    fn a_level_or_parts_with_levels_make_a_filter_and_a_slip_is_not_taken_for_a_part() {
        assert_eq!(filter("debug").unwrap().default_level(), Some(LevelFilter::DEBUG));
        let parts = filter("scanrig_drivers=debug, scanrig_services=info").unwrap();
        assert!(parts.would_enable("scanrig_drivers::thread", &tracing::Level::DEBUG));
        assert!(!parts.would_enable("scanrig_services::control", &tracing::Level::DEBUG));
        assert!(parts.would_enable("scanrig_services::control", &tracing::Level::INFO));
        assert_eq!(filter(" debug\n").unwrap().default_level(), Some(LevelFilter::DEBUG));
        for slip in ["debgu", "drivers=debug", "scanrig_drivers=debgu", "debug,", "=", "info,debgu=info"] {
            assert!(filter(slip).is_err(), "{slip}");
        }
    }
}
