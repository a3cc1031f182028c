//! The register of the codes of services.

document::codes! {
    /// Every code that a service answers with, with its title, in order.
    LINE = "R0620", "A line that is too long";
    JSON = "R0621", "A line that is not JSON";
    REQUEST = "R0622", "A request that cannot be read";
    UNKNOWN = "R0623", "A request of an unknown kind";
    PROTOCOL = "R0624", "Another version of the protocol";
    CLIENTS = "R0625", "More clients than the rig takes";
    TOO_MUCH = "R0626", "More than one client may ask for";
    SUBSCRIPTION = "R0627", "A subscription that is not there";
    LOCKED = "R0628", "The rig is locked";
    LOCK_FILE = "R0629", "The lock cannot be kept";
    SERVED = "R0630", "A socket that another rig serves";
    SOCKET = "R0631", "A socket that cannot be made";
    GROUP = "R0632", "A group that the socket cannot be given";
    OVER = "R0633", "The rig ended before it answered";
}
