//! PLC_R and PLC_W (plcsystem: sections 2 and 3).

use super::enumeration as names;
use super::member::MemberType::{Bool, Byte, Bytes, Dword, Lword, Text, Udint, Uint, Word};
use super::member::{M241, SystemMember, members};
use super::{SystemField, SystemVariable};

members! {
    /// The members of PLC_R: what the controller says of itself.
    PlcRead of PlcR, PLC_R:
    VendorId = "i_wVendorID": Word, [at(60_000), fixed()], "plcsystem:PLCR-06",
        "The vendor: 101A hex is Schneider Electric.";
    ProductId = "i_wProductID": Word, [at(60_001), fixed()], "plcsystem:PLCR-06",
        "The reference: a number of the rig for each.";
    SerialNumber = "i_dwSerialNumber": Dword, [at(60_002), fixed()], "controller:SYS-06", "The serial number.";
    FirmwareVersion = "i_byFirmVersion": Bytes(4), [at(60_004), fixed()], "controller:SYS-06",
        "The version aa.bb.cc.dd of the firmware, aa first.";
    BootVersion = "i_byBootVersion": Bytes(4), [at(60_006), fixed()], "controller:SYS-06",
        "The version aa.bb.cc.dd of the boot firmware, aa first.";
    HardwareVersion = "i_dwHardVersion": Dword, [at(60_008), fixed()], "controller:SYS-06",
        "The version of the hardware; reserved, 0.";
    CoprocessorVersion = "i_dwChipVersion": Dword, [at(60_010), fixed()], "controller:SYS-06",
        "The version of the coprocessor.";
    Status = "i_wStatus": Word, [at(60_012), names(&names::STATUS)], "plcsystem:PLCR-01", "The state.";
    BootProjectStatus = "i_wBootProjectStatus": Word, [at(60_013), names(&names::BOOT_PROJECT_STATUS)], "controller:SYS-01",
        "How the boot application stands to the one in memory.";
    LastStopCause = "i_wLastStopCause": Word, [at(60_014), names(&names::STOP_CAUSE)], "plcsystem:PLCR-02",
        "Why RUNNING was left last.";
    LastApplicationError = "i_wLastApplicationError": Word, [at(60_015), names(&names::APPLICATION_ERROR)], "plcsystem:PLCR-03",
        "The last error of the application.";
    SystemFault1 = "i_lwSystemFault_1": Lword, [at(60_016)], "plcsystem:PLCR-21", "A bit for each error: 0 where it is detected.";
    SystemFault2 = "i_lwSystemFault_2": Lword, [at(60_020), only(M241), fixed()], "plcsystem:PLCR-21",
        "More such bits: none is documented, all are 1.";
    IoStatus1 = "i_wIOStatus1": Word,
        [at(60_024), only(M241), names(&names::IO_STATUS), alias("i_wLocalIOStatus")], "plcsystem:PLCR-20",
        "The status of the embedded inputs and outputs.";
    IoStatus2 = "i_wIOStatus2": Word, [at(60_025), names(&names::IO_STATUS)], "plcsystem:PLCR-20",
        "The status of the expansion modules.";
    Battery = "i_wClockBatterystatus": Word, [at(60_026), unit("%")], "plcsystem:PLCR-05",
        "The battery of the clock: 100 is full, 0 asks for another one.";
    Signature1 = "i_dwAppliSignature1": Dword, [at(60_028)], "plcsystem:PLCR-07",
        "The first double word of the signature of the application.";
    Signature2 = "i_dwAppliSignature2": Dword, [at(60_030)], "plcsystem:PLCR-07", "The second one.";
    Signature3 = "i_dwAppliSignature3": Dword, [at(60_032)], "plcsystem:PLCR-07", "The third one.";
    Signature4 = "i_dwAppliSignature4": Dword, [at(60_034)], "plcsystem:PLCR-07", "The fourth one.";
    VendorName = "i_sVendorName": Text(31), [fixed()], "controller:SYS-06", "The name of the vendor.";
    ProductReference = "i_sProductRef": Text(31), [fixed()], "controller:SYS-06", "The reference of the controller.";
    NodeName = "i_sNodeName": Text(31), [in_m251(Text(99)), fixed()], "controller:SYS-06",
        "The name of the controller in the network of the tool.";
    LastStopTime = "i_dwLastStopTime": Dword, [unit("s")], "plcsystem:PLCR-02",
        "When RUNNING was left last, since 1970-01-01 00:00 UTC.";
    LastPowerOffDate = "i_dwLastPowerOffDate": Dword, [unit("s")], "plcsystem:PLCR-08",
        "When the power went last, since 1970-01-01 00:00 UTC.";
    EventsCounter = "i_uiEventsCounter": Uint, [], "plcsystem:PLCR-11",
        "How many events inputs raised; reserved in an M251, 0.";
    TerminalPort = "i_wTerminalPortStatus": Word, [names(&names::TERMINAL_PORT_STATUS)], "controller:SYS-06",
        "The port of the programming tool.";
    SdCard = "i_wSdCardStatus": Word, [names(&names::SD_CARD_STATUS), rest(0)], "plcsystem:PLCR-09", "The SD card.";
    FreeFileHandles = "i_wUsrFreeFileHdl": Word, [fixed()], "controller:SYS-06", "How many more files can be opened.";
    TotalBytes = "i_udiUsrFsTotalBytes": Udint, [unit("B"), fixed()], "controller:SYS-06", "The size of the disk /usr.";
    FreeBytes = "i_udiUsrFsFreeBytes": Udint, [unit("B")], "controller:SYS-06", "What of the disk /usr is free.";
    Tm3BusState = "i_uiTM3BusState": Word, [names(&names::TM3_BUS_STATE)], "io:DIAG-01",
        "Whether the fitted expansion modules are the configured ones.";
    RunStopInput = "i_ExpertIO_RunStop_Input": Byte, [], "plcsystem:PLCR-11",
        "The Run/Stop input: n for In, FF hex for none; reserved in an M251, 0.";
    Clock10Ms = "i_x10msClk": Bool, [], "plcsystem:PLCR-04", "A clock of 10 ms: half of each period TRUE.";
    Clock100Ms = "i_x100msClk": Bool, [], "plcsystem:PLCR-04", "A clock of 100 ms.";
    Clock1S = "i_x1sClk": Bool, [], "plcsystem:PLCR-04", "A clock of 1 s.";
}

members! {
    /// The members of PLC_W: commands to the controller.
    PlcWrite of PlcW, PLC_W:
    ResetCounterEvent = "q_wResetCounterEvent": Word, [], "plcsystem:PLCR-11",
        "From 0 to 1 it sets PLC_R.i_uiEventsCounter to 0.";
    OpenPlcControl = "q_uiOpenPLCControl": Uint, [], "plcsystem:PLCW-01", "From 0 to 6699 it has the command executed.";
    PlcControl = "q_wPLCControl": Word, [names(&names::COMMAND)], "plcsystem:PLCW-01", "The command.";
}
