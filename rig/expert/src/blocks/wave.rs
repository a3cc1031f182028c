//! The blocks of pulse width modulation and frequency generators (io:STD-PWM-02, io:STD-FG-01).

use super::{BlockCall, BlockPinKind, BlockType, PinType, ValueType, pin};
use crate::functions::FunctionUnit;
use crate::wave::{HALF, INVALID_PARAMETER, SquareWave, WaveRequest, WaveShape};

/// The blocks.
pub(super) const BLOCKS: &[BlockType] = &[
    BlockType { name: "PWM_M241", pins: PWM, run: |call| run(call, &PWM_PLACES) },
    BlockType { name: "FrequencyGenerator_M241", pins: GENERATOR, run: |call| run(call, &GENERATOR_PLACES) },
];

const PWM: &[PinType] = &[
    pin("PWM_REF_IN", BlockPinKind::Input, ValueType::Reference),
    pin("Enable", BlockPinKind::Input, ValueType::Bool),
    pin("Frequency", BlockPinKind::Input, ValueType::Udint),
    pin("Duty", BlockPinKind::Input, ValueType::Udint),
    pin("Sync", BlockPinKind::Input, ValueType::Bool),
    pin("EN_Enable", BlockPinKind::Input, ValueType::Bool),
    pin("EN_Sync", BlockPinKind::Input, ValueType::Bool),
    pin("HighPrecision", BlockPinKind::Input, ValueType::Bool),
    pin("InFrequency", BlockPinKind::Output, ValueType::Bool),
    pin("Busy", BlockPinKind::Output, ValueType::Bool),
    pin("Error", BlockPinKind::Output, ValueType::Bool),
    pin("ErrorID", BlockPinKind::Output, ValueType::Word),
    pin("last Sync", BlockPinKind::Hidden, ValueType::Bool),
];

const GENERATOR: &[PinType] = &[
    pin("FREQGEN_REF_IN", BlockPinKind::Input, ValueType::Reference),
    pin("Enable", BlockPinKind::Input, ValueType::Bool),
    pin("Frequency", BlockPinKind::Input, ValueType::Udint),
    pin("Sync", BlockPinKind::Input, ValueType::Bool),
    pin("EN_Enable", BlockPinKind::Input, ValueType::Bool),
    pin("EN_Sync", BlockPinKind::Input, ValueType::Bool),
    pin("InFrequency", BlockPinKind::Output, ValueType::Bool),
    pin("Busy", BlockPinKind::Output, ValueType::Bool),
    pin("Error", BlockPinKind::Output, ValueType::Bool),
    pin("ErrorID", BlockPinKind::Output, ValueType::Word),
    pin("last Sync", BlockPinKind::Hidden, ValueType::Bool),
];

/// Where the pins of a block are.
struct Places {
    /// Duty and HighPrecision.
    duty: Option<(usize, usize)>,
    sync: usize,
    enable_by_input: usize,
    sync_by_input: usize,
    in_frequency: usize,
    busy: usize,
    error: usize,
    error_id: usize,
    last_sync: usize,
    pick: fn(&mut FunctionUnit) -> Option<&mut SquareWave>,
}

const REFERENCE: usize = 0;
const ENABLE: usize = 1;
const FREQUENCY: usize = 2;

const PWM_PLACES: Places = Places {
    duty: Some((3, 7)),
    sync: 4,
    enable_by_input: 5,
    sync_by_input: 6,
    in_frequency: 8,
    busy: 9,
    error: 10,
    error_id: 11,
    last_sync: 12,
    pick: |unit| if let FunctionUnit::Pwm(it) = unit { Some(it) } else { None },
};

const GENERATOR_PLACES: Places = Places {
    duty: None,
    sync: 3,
    enable_by_input: 4,
    sync_by_input: 5,
    in_frequency: 6,
    busy: 7,
    error: 8,
    error_id: 9,
    last_sync: 10,
    pick: |unit| if let FunctionUnit::Generator(it) = unit { Some(it) } else { None },
};

/// ErrorID: no such function, or one of another kind (io:EXP-06).
const UNKNOWN_REFERENCE: i64 = 1;

fn run(call: &mut BlockCall<'_>, places: &Places) {
    let pins = &mut *call.pins;
    let sync = pins.get(places.sync) != 0;
    let request = WaveRequest {
        enable: pins.get(ENABLE) != 0,
        enable_by_input: pins.get(places.enable_by_input) != 0,
        sync: sync && pins.get(places.last_sync) == 0,
        sync_by_input: pins.get(places.sync_by_input) != 0,
        shape: shape(
            pins.get(FREQUENCY),
            places.duty.map(|(duty, fine)| (pins.get(duty), pins.get(fine) != 0)),
        ),
    };
    let status = call
        .expert
        .call(call.now, pins.get(REFERENCE), places.pick, |wave, fx| wave.call(call.now, &request, fx));
    let error = match status {
        None => UNKNOWN_REFERENCE,
        Some(status) if status.refused => INVALID_PARAMETER,
        Some(_) => 0,
    };
    let status = status.unwrap_or_default();
    pins.set(places.last_sync, sync.into());
    pins.set(places.in_frequency, status.in_frequency.into());
    pins.set(places.busy, status.busy.into());
    pins.set(places.error, (error != 0).into());
    pins.set(places.error_id, error);
}

/// The shape of a frequency in tenths of a hertz and a duty in percent, or with high precision in tenths of it.
fn shape(frequency: i64, duty: Option<(i64, bool)>) -> Option<WaveShape> {
    let duty = match duty {
        None => HALF,
        Some((duty, fine)) => {
            let tenths = if fine { duty } else { duty.checked_mul(10)? };
            u16::try_from(tenths).ok().filter(|tenths| *tenths <= 1000)?
        }
    };
    Some(WaveShape { frequency: u32::try_from(frequency).ok()?, duty })
}
