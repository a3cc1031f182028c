//! SERIAL_R and SERIAL_W (plcsystem: section 4). Index 0 is the first serial line; index 1 the second one of an M241, reserved
//! in an M251. Nothing counts yet: every counter rests at 0.

use super::member::MemberType::{Udint, Uint, Word};
use super::member::{SystemMember, members};
use super::{SystemField, SystemVariable};

members! {
    /// The members of an element of SERIAL_R: the counters of a serial line.
    SerialRead of SerialR, SERIAL_R:
    FramesTransmittedOk = "i_udiFramesTransmittedOK": Udint, [rest(0)], "plcsystem:SERV-01", "Frames transmitted.";
    FramesReceivedOk = "i_udiFramesReceivedOK": Udint, [rest(0)], "plcsystem:SERV-01", "Frames received without an error.";
    MessagesError = "i_udiRX_MessagesError": Uint, [rest(0)], "plcsystem:SERV-01",
        "Frames received with a wrong checksum or parity.";
    SlaveExceptionCount = "i_uiSlaveExceptionCount": Uint, [rest(0)], "plcsystem:SERV-01",
        "Exceptions that the controller answered.";
    SlaveMsgCount = "i_udiSlaveMsgCount": Uint, [rest(0)], "plcsystem:SERV-01", "Requests to this controller.";
    SlaveNoRespCount = "i_uiSlaveNoRespCount": Uint, [rest(0)], "plcsystem:SERV-01", "Broadcast requests.";
    SlaveNakCount = "i_uiSlaveNakCount": Uint, [rest(0)], "plcsystem:SERV-02", "Not used: 0.";
    SlaveBusyCount = "i_uiSlaveBusyCount": Uint, [rest(0)], "plcsystem:SERV-02", "Not used: 0.";
    CharOverrunCount = "i_uiCharOverrunCount": Uint, [rest(0)], "plcsystem:SERV-01", "Overruns of characters.";
}

members! {
    /// The members of an element of SERIAL_W: commands to a serial line.
    SerialWrite of SerialW, SERIAL_W:
    ResetCounter = "q_wResetCounter": Word, [], "plcsystem:SERV-03", "From 0 to 1 it sets the counters of the line to 0.";
}
