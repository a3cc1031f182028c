//! Functions that ask the controller: the machine stops at the call, and the caller of the machine answers.

use super::{Accepts, Body, Function, Gives};
use crate::types::Elementary::{self, Bool, Byte, Dint, Int, Lword, Sint, Udint, Uint, Usint, Word};

/// What a program asks of the controller that runs it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Service {
    /// `SysTaskWaitSleep(ulMilliSeconds)`: the task gives the processor away for so many milliseconds
    /// (controller:TASK-52). 0 where that was done.
    WaitSleep,
    /// `GetCurrentTaskCycle()`: the interval of the running task in microseconds (controller:TASK-13), 0 for a task
    /// without one.
    GetTaskCycle,
    /// `SetCurrentTaskCycle(Interval)`: sets it, in microseconds, from the next cycle on (controller:TASK-13). 0 where
    /// that was done, 1 where the task cannot have it.
    SetTaskCycle,
    /// `IsFirstMastCycle()` (controller:TASK-53).
    FirstMastCycle,
    /// `IsFirstMastColdCycle()` (controller:TASK-53).
    FirstMastColdCycle,
    /// `IsFirstMastWarmCycle()` (controller:TASK-53).
    FirstMastWarmCycle,
    /// `HasForcedIo()`: whether an input or output is forced (controller:STATE-03).
    HasForcedIo,
    /// What `TM3_GetModuleInternalStatus` asks (io:DIAG-06), with the index of a module in TM3_MODULE_R, the first status byte and how
    /// many, eight bits each from the lowest on. The answer is the code of an error in the lowest eight bits, then four bits for each
    /// status byte.
    ModuleInternalStatus,
    /// `GetRtc()`: seconds since 1970-01-01 00:00 UTC (controller:DEV-22).
    GetRtc,
    /// `SetRTCDrift(RtcDrift, Day, Hour, Minute)`: corrects the clock by so many seconds a week (controller:DEV-22).
    /// The other three have no effect.
    SetRtcDrift,
    /// `InhibitBatLed(Inhibit)` (controller:LED-05).
    InhibitBatteryLed,
    /// `TM3_GetModuleBusStatus(ModuleIndex)`: the code of the last exchange with an expansion module (io:DIAG-04).
    ModuleBusStatus,
    /// `TM3_GetModuleFWVersion(ModuleIndex)`: the version of its firmware (io:DIAG-05).
    ModuleFirmware,
}

/// The index of a module in TM3_MODULE_R.
const MODULE_INDEX: &[(&str, Accepts)] = &[("MODULEINDEX", Accepts::Exact(Byte))];

/// Every function that asks. The first argument is what is asked with.
pub(super) const FUNCTIONS: &[Function] = &[
    service("SYSTASKWAITSLEEP", &[("ULMILLISECONDS", Accepts::Exact(Udint))], Udint, Service::WaitSleep),
    service("GETCURRENTTASKCYCLE", &[], Udint, Service::GetTaskCycle),
    service("SETCURRENTTASKCYCLE", &[("INTERVAL", Accepts::Exact(Udint))], Udint, Service::SetTaskCycle),
    service("ISFIRSTMASTCYCLE", &[], Bool, Service::FirstMastCycle),
    service("ISFIRSTMASTCOLDCYCLE", &[], Bool, Service::FirstMastColdCycle),
    service("ISFIRSTMASTWARMCYCLE", &[], Bool, Service::FirstMastWarmCycle),
    service("HASFORCEDIO", &[], Bool, Service::HasForcedIo),
    service(
        "__TM3_INTERNALSTATUS",
        &[("REQUEST", Accepts::Exact(Udint))],
        Lword,
        Service::ModuleInternalStatus,
    ),
    service("GETRTC", &[], Dint, Service::GetRtc),
    service(
        "SETRTCDRIFT",
        &[
            ("RTCDRIFT", Accepts::Exact(Sint)),
            ("DAY", Accepts::Exact(Usint)),
            ("HOUR", Accepts::Exact(Usint)),
            ("MINUTE", Accepts::Exact(Usint)),
        ],
        Int,
        Service::SetRtcDrift,
    ),
    service("INHIBITBATLED", &[("INHIBIT", Accepts::Exact(Bool))], Int, Service::InhibitBatteryLed),
    service("TM3_GETMODULEBUSSTATUS", MODULE_INDEX, Word, Service::ModuleBusStatus),
    service("TM3_GETMODULEFWVERSION", MODULE_INDEX, Uint, Service::ModuleFirmware),
];

const fn service(
    name: &'static str,
    parameters: &'static [(&'static str, Accepts)],
    gives: Elementary,
    service: Service,
) -> Function {
    Function { name, parameters, extensible: false, gives: Gives::Exact(gives), body: Body::Service(service) }
}
