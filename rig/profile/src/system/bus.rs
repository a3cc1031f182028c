//! TM3_MODULE_R, TM3_BUS_W and PROFIBUS_R (plcsystem: sections 6 and 7).

use super::enumeration as names;
use super::member::MemberType::{Udint, Uint, Word};
use super::member::{SINCE_2019, SystemMember, members};
use super::{SystemField, SystemVariable};

members! {
    /// The members of an element of TM3_MODULE_R: an expansion module, index 0 the one closest to the controller.
    ModuleRead of Tm3ModuleR, TM3_MODULE_R:
    ProductId = "i_wProductID": Word, [], "io:DIAG-01", "The internal ID code of the module.";
    State = "i_wModuleState": Word, [names(&names::MODULE_STATE)], "plcsystem:TM3V-01", "The state of the module.";
}

members! {
    /// The members of TM3_BUS_W: commands to the expansion bus.
    BusWrite of Tm3BusW, TM3_BUS_W:
    ErrorPassive = "q_wIOBusErrPassiv": Word, [only(SINCE_2019), names(&names::BUS_ERROR_HANDLING)], "plcsystem:TM3V-05",
        "How errors on the bus are handled.";
    Restart = "q_wIOBusRestart": Word, [only(SINCE_2019)], "plcsystem:TM3V-04", "From 0 to 1 it restarts the bus.";
}

members! {
    /// The members of PROFIBUS_R: a PROFIBUS slave, of which none is modelled.
    ProfibusRead of ProfibusR, PROFIBUS_R:
    Identifier = "i_wPNIdentifier": Word, [rest(0)], "plcsystem:GVL-04", "The identification code of the slave.";
    Address = "i_wBusAdr": Uint, [rest(0)], "plcsystem:GVL-04", "The address of the slave.";
    State = "i_CommState": Udint, [rest(1)], "plcsystem:GVL-04",
        "0 unknown, 1 not configured, 2 stop, 3 idle, 4 operate; 1 without a module.";
    Error = "i_CommError": Udint, [rest(0)], "plcsystem:GVL-04", "The code of an error of communication, 0 for none.";
    ErrorCount = "i_ErrorCount": Udint, [rest(0)], "plcsystem:GVL-04", "How many there were.";
}
