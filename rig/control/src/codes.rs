//! The register of codes of those who speak with a rig: what keeps a client from it, and what `rig ctl` refuses itself.
//! Why a rig refuses a request stands in the registers of the rig.

/// Every code with its title, in order.
pub const CODES: &[(&str, &str)] = &[
    ("R0640", "No rig that runs"),
    ("R0641", "More than one rig that runs"),
    ("R0642", "A socket that cannot be reached"),
    ("R0643", "A socket that is no rig's"),
    ("R0644", "A rig that speaks another protocol"),
    ("R0645", "A connection that is lost"),
    ("R0646", "A rig that ended the connection"),
    ("R0647", "A rig that does not answer"),
    ("R0648", "An answer that cannot be understood"),
    ("R0649", "Words that give a signal no value"),
];
