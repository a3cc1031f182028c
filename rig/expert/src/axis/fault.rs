//! What blocks of an axis report as ErrorID.

/// Why a command is refused or failed, or why an axis is in ErrorStop. The numbers are a definition of the rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum AxisFault {
    /// No such function, or one of another kind (io:EXP-06).
    UnknownAxis = 1,
    /// The axis is Disabled, or became so while the command ran.
    Disabled = 1001,
    /// The limit switch for larger positions is reached.
    LimitPositive = 1002,
    /// The limit switch for smaller positions is reached.
    LimitNegative = 1003,
    /// The upper software limit is reached.
    SoftwareLimitPositive = 1004,
    /// The lower software limit is reached.
    SoftwareLimitNegative = 1005,
    /// The application was stopped.
    ApplicationStopped = 1006,
    /// Protection switched an output of the axis off.
    OutputProtection = 1007,
    /// The drive is not ready.
    DriveNotReady = 1008,
    /// The axis is in ErrorStop.
    ErrorStopActive = 2000,
    /// MC_Stop_PTO controls the axis.
    StoppingActive = 2001,
    /// The state of the axis does not allow the command.
    InvalidTransition = 2002,
    /// The position can be set in Standstill only.
    InvalidSetPosition = 2003,
    /// The axis has no PROBE input, or the window is empty.
    InvalidProbe = 2005,
    /// The axis lacks an input that this homing mode needs.
    InvalidHoming = 2006,
    /// The axis is not homed.
    NotHomed = 2007,
    /// There is a buffered command already.
    QueueFull = 2008,
    /// A velocity out of its range.
    InvalidVelocity = 3000,
    /// An acceleration out of its range, or a ramp that would last too long.
    InvalidAcceleration = 3001,
    /// A deceleration out of its range, or a ramp that would last too long.
    InvalidDeceleration = 3002,
    /// A jerk ratio out of its range.
    InvalidJerkRatio = 3003,
    /// No such direction, or one that the output mode does not have.
    InvalidDirection = 3004,
    /// No such buffer mode, or not for this command.
    InvalidBufferMode = 3005,
    /// No such homing mode.
    InvalidHomingMode = 3006,
    /// No such parameter.
    UnknownParameter = 3007,
    /// A parameter that cannot be written.
    ReadOnlyParameter = 3008,
    /// A value that the parameter cannot have.
    InvalidParameterValue = 3009,
}

impl AxisFault {
    /// Its number.
    pub const fn number(self) -> u16 {
        self as u16
    }
}
