//! What can be observed of a function.

/// Something of a function that plans can observe, besides its outputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum FunctionProbe {
    /// The current value of a counter or meter.
    Value,
    /// The register of the last capture.
    Captured,
    /// Whether the value means something.
    Valid,
    /// Whether the counter counts.
    Run,
    /// A number of the function's error; 0 for none.
    Error,
    /// Whether the value has reached threshold n.
    Threshold(u8),
    /// Reflex n of the current zone.
    Reflex(u8),
    /// The flag of a crossing of the modulo.
    ModuloFlag,
    /// The flag of a preset.
    PresetFlag,
    /// The flag of a capture.
    CaptureFlag,
    /// Edges that came faster than the function can take them: so many the true value may be off (io:STD-HSC-16).
    Excess,
    /// State of an axis (io:STD-PTO-03).
    State,
    /// Position of an axis, in pulses.
    Position,
    /// Velocity of an axis, in pulses a second, negative backwards.
    Velocity,
    /// Whether an axis is homed.
    Homed,
    /// Pulses that left the output since power-on.
    Pulses,
    /// Frequency of a PWM or generator output, in tenths of a hertz.
    Frequency,
    /// Duty of a PWM output, in tenths of a percent.
    Duty,
}
