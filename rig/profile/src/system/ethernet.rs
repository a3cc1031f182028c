//! ETH_R and ETH_W (plcsystem: section 5). The members without an ending describe Ethernet or Ethernet_1, those with `_I2`
//! Ethernet or Ethernet_2. No network is modelled yet: an interface rests without a cable and without an address, with the
//! mode that it has where nothing gives it one, and every counter rests at 0.

use super::enumeration as names;
use super::member::MemberType::{Byte, Bytes, Text, Udint, Uint, Word};
use super::member::{SystemMember, members};
use super::{SystemField, SystemVariable};

/// ETH_R_PORT_NA_DUPLEX and ETH_R_SPEED_NA: there is no link.
const NO_DUPLEX: u64 = 3;
/// ETH_ERROR: the cable is not connected.
const NO_CABLE: u64 = 3;
/// ETH_DEFAULT_IP: no address was stored or given.
const DEFAULT_IP: u64 = 0xFF;
/// ETH_R_ETHERNET_II.
const ETHERNET_II: u64 = 1;

members! {
    /// The members of ETH_R: what the Ethernet interfaces and their protocols do.
    EthernetRead of EthR, ETH_R:
    IpAddress = "i_byIPAddress": Bytes(4), [at(60_050), rest(0)], "plcsystem:ETHR-01", "The IP address, its first number first.";
    SubnetMask = "i_bySubNetMask": Bytes(4), [at(60_052), rest(0)], "plcsystem:ETHR-01", "The mask of the subnet.";
    Gateway = "i_byGateway": Bytes(4), [at(60_054), rest(0)], "plcsystem:ETHR-01", "The gateway.";
    MacAddress = "i_byMACAddress": Bytes(6), [at(60_056), rest(0)], "plcsystem:ETHR-01", "The MAC address.";
    DeviceName = "i_sDeviceName": Text(15), [at(60_059), rest(0)], "plcsystem:ETHR-01",
        "The name by which a server knows the interface.";
    IpMode = "i_wIpMode": Word, [names(&names::IP_MODE), rest(DEFAULT_IP)], "plcsystem:ETHR-01", "How the IP address was obtained.";
    FdrServerIpAddress = "i_byFDRServerIPAddress": Bytes(4), [rest(0)], "plcsystem:ETHR-01",
        "The IP address of the DHCP or BootP server, 0.0.0.0 for none.";
    OpenTcpConnections = "i_udiOpenTcpConnections": Udint, [rest(0)], "plcsystem:ETHR-01", "Open TCP connections.";
    FramesTransmittedOk = "i_udiFramesTransmittedOK": Udint, [rest(0)], "plcsystem:ETHR-04", "Frames transmitted.";
    FramesReceivedOk = "i_udiFramedReceivedOK": Udint, [rest(0)], "plcsystem:ETHR-04", "Frames received.";
    TransmitBufferErrors = "i_udiTransmitBufferErrors": Udint, [rest(0)], "plcsystem:ETHR-04", "Frames transmitted with errors.";
    ReceiveBufferErrors = "i_udiReceiveBufferErrors": Udint, [rest(0)], "plcsystem:ETHR-04", "Frames received with errors.";
    FrameSendingProtocol = "i_wFrameSendingProtocol": Word, [names(&names::FRAME_PROTOCOL), rest(ETHERNET_II)], "plcsystem:ETHR-01",
        "How frames are sent.";
    LinkStatus = "i_wPortALinkStatus": Word, [names(&names::LINK_STATUS), rest(0)], "plcsystem:ETHR-01", "The link of the port.";
    Speed = "i_wPortASpeed": Word, [unit("Mbit/s"), names(&names::PORT_SPEED), rest(0)], "plcsystem:ETHR-01", "Its speed.";
    DuplexStatus = "i_wPortADuplexStatus": Word, [names(&names::DUPLEX_STATUS), rest(NO_DUPLEX)], "plcsystem:ETHR-01",
        "Whether it sends and receives at once.";
    Collisions = "i_udiPortACollisions": Udint, [rest(0)], "plcsystem:ETHR-04", "Frames that were sent after collisions.";
    IpAddress2 = "i_byIPAddress_I2": Bytes(4), [alias("i_byIPAddress_If2"), rest(0)], "plcsystem:ETHR-05",
        "The IP address of Ethernet or Ethernet_2.";
    SubnetMask2 = "i_bySubNetMask_I2": Bytes(4), [alias("i_bySubNetMask_If2"), rest(0)], "plcsystem:ETHR-05", "Its mask.";
    Gateway2 = "i_byGateway_I2": Bytes(4), [alias("i_byGateway_If2"), rest(0)], "plcsystem:ETHR-05", "Its gateway.";
    MacAddress2 = "i_byMACAddress_I2": Bytes(6), [alias("i_byMACAddress_If2"), rest(0)], "plcsystem:ETHR-05", "Its MAC address.";
    DeviceName2 = "i_sDeviceName_I2": Text(15), [alias("i_sDeviceName_If2"), rest(0)], "plcsystem:ETHR-05", "Its name.";
    IpMode2 = "i_wIpMode_I2": Word, [alias("i_wIpMode_If2"), names(&names::IP_MODE), rest(DEFAULT_IP)], "plcsystem:ETHR-05",
        "How its IP address was obtained.";
    LinkStatus2 = "i_wPortALinkStatus_I2": Word, [alias("i_wPortALinkStatus_If2"), names(&names::LINK_STATUS), rest(0)],
        "plcsystem:ETHR-05", "Its link.";
    Speed2 = "i_wPortASpeed_I2": Word, [alias("i_wPortASpeed_If2"), unit("Mbit/s"), names(&names::PORT_SPEED), rest(0)],
        "plcsystem:ETHR-05", "Its speed.";
    DuplexStatus2 = "i_wPortADuplexStatus_I2": Word,
        [alias("i_wPortADuplexStatus_If2"), names(&names::DUPLEX_STATUS), rest(NO_DUPLEX)], "plcsystem:ETHR-05",
        "Whether it sends and receives at once.";
    IpStatus2 = "i_wPortAIpStatus_I2": Word, [alias("i_wPortAIpStatus_If2"), names(&names::IP_STATUS), rest(NO_CABLE)],
        "plcsystem:ETHR-05", "What its TCP/IP does.";
    ModbusTransmitted = "i_udiModbusMessageTransmitted": Udint, [rest(0)], "plcsystem:ETHR-04", "Modbus messages transmitted.";
    ModbusReceived = "i_udiModbusMessageReceived": Udint, [rest(0)], "plcsystem:ETHR-04", "Modbus messages received.";
    ModbusErrors = "i_udiModbusErrorMessage": Udint, [rest(0)], "plcsystem:ETHR-04", "Modbus errors transmitted and received.";
    IoMessagingTransmitted = "i_udiETHIP_IOMessagingTransmitted": Udint, [rest(0)], "plcsystem:ETHR-04",
        "EtherNet/IP frames of class 1 transmitted.";
    IoMessagingReceived = "i_udiETHIP_IOMessagingReceived": Udint, [rest(0)], "plcsystem:ETHR-04", "Those received.";
    UcmmRequest = "i_udiUCMM_Request": Udint, [rest(0)], "plcsystem:ETHR-04", "Unconnected messages received.";
    UcmmError = "i_udiUCMM_Error": Udint, [rest(0)], "plcsystem:ETHR-04", "Those of them that were not valid.";
    Class3Request = "i_udiClass3_Request": Udint, [rest(0)], "plcsystem:ETHR-04", "Requests of class 3 received.";
    Class3Error = "i_udiClass3_Error": Udint, [rest(0)], "plcsystem:ETHR-04", "Those of them that were not valid.";
    AssemblyInput = "i_uiAssemblyInstanceInput": Uint, [rest(0)], "plcsystem:GVL-04", "The number of the input assembly.";
    AssemblyInputSize = "i_uiAssemblyInstanceInputSize": Uint, [rest(0)], "plcsystem:GVL-04", "Its size.";
    AssemblyOutput = "i_uiAssemblyInstanceOutput": Uint, [rest(0)], "plcsystem:GVL-04", "The number of the output assembly.";
    AssemblyOutputSize = "i_uiAssemblyInstanceOutputSize": Uint, [rest(0)], "plcsystem:GVL-04", "Its size.";
    ConnectionTimeouts = "i_uiETHIP_ConnectionTimeouts": Uint, [rest(0)], "plcsystem:ETHR-04",
        "EtherNet/IP connections that timed out.";
    EipRunIdle = "i_ucEipRunIdle": Word, [names(&names::RUN_IDLE), rest(0)], "plcsystem:ETHR-03",
        "What the connection of class 1 says.";
    MasterIpTimeouts = "i_byMasterIpTimeouts": Byte, [rest(0)], "plcsystem:ETHR-02", "Time-outs of the Modbus TCP master.";
    MasterIpLost = "i_byMasterIpLost": Byte, [rest(0)], "plcsystem:ETHR-02", "1 where the Modbus TCP master is lost.";
    IpStatus = "i_wPortAIpStatus": Word, [names(&names::IP_STATUS), rest(NO_CABLE)], "plcsystem:ETHR-01", "What TCP/IP does.";
}

members! {
    /// The members of ETH_W: commands to Ethernet.
    EthernetWrite of EthW, ETH_W:
    ResetCounter = "q_wResetCounter": Word, [], "plcsystem:ETHR-04", "From 0 to 1 it sets the counters of ETH_R to 0.";
}
