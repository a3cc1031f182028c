//! The register of codes of the dashboard: what keeps it from its terminal or its rig.

/// Every code with its title, in order.
pub const CODES: &[(&str, &str)] =
    &[("R0660", "No terminal for the dashboard"), ("R0661", "A demonstration that does not run")];
