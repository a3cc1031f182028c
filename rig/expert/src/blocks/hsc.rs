//! The blocks of counters (io:STD-HSC-02, io:STD-HSC-03), and those that read and set their parameters.

use super::{BlockCall, BlockPinKind, BlockPins, BlockType, PinType, ValueType, pin};
use crate::ExpertEffects;
use crate::FunctionProbe;
use crate::counter::{Controls, Counter, CounterParam, Flag, ParamFault};
use crate::functions::FunctionUnit;

/// The blocks.
pub(super) const BLOCKS: &[BlockType] = &[
    BlockType { name: "HSCSimple_M241", pins: SIMPLE, run: run_simple },
    BlockType { name: "HSCMain_M241", pins: MAIN, run: run_main },
    BlockType { name: "EXPERTGetImmediateValue", pins: IMMEDIATE, run: get_immediate_value },
    BlockType { name: "EXPERTGetCapturedValue", pins: CAPTURED, run: get_captured_value },
    BlockType { name: "EXPERTGetDiag", pins: DIAG, run: get_diag },
    BlockType { name: "EXPERTGetParam", pins: GET_PARAM, run: get_param },
    BlockType { name: "EXPERTSetParam", pins: SET_PARAM, run: set_param },
];

const fn input(name: &'static str) -> PinType {
    pin(name, BlockPinKind::Input, ValueType::Bool)
}

const fn output(name: &'static str) -> PinType {
    pin(name, BlockPinKind::Output, ValueType::Bool)
}

const SIMPLE: &[PinType] = &[
    pin("HSC_REF_IN", BlockPinKind::Input, ValueType::Reference),
    input("Enable"),
    input("Sync"),
    input("ACK_Modulo"),
    output("Validity"),
    output("Error"),
    output("Run"),
    output("Modulo_Flag"),
    pin("CurrentValue", BlockPinKind::Output, ValueType::Dint),
    pin("last inputs", BlockPinKind::Hidden, ValueType::Word),
];

const MAIN: &[PinType] = &[
    pin("HSC_REF_IN", BlockPinKind::Input, ValueType::Reference),
    input("EN_Enable"),
    input("EN_Preset"),
    input("EN_Cap"),
    input("EN_Compare"),
    input("EN_Out0"),
    input("EN_Out1"),
    input("F_Enable"),
    input("F_Preset"),
    input("F_Out0"),
    input("F_Out1"),
    input("SuspendCompare"),
    input("ACK_Modulo"),
    input("ACK_Preset"),
    input("ACK_Cap"),
    output("Validity"),
    output("Error"),
    output("Run"),
    output("TH0"),
    output("TH1"),
    output("TH2"),
    output("TH3"),
    output("Modulo_Flag"),
    output("Preset_Flag"),
    output("Cap_Flag"),
    output("Reflex0"),
    output("Reflex1"),
    output("Out0"),
    output("Out1"),
    pin("CurrentValue", BlockPinKind::Output, ValueType::Dint),
    pin("last inputs", BlockPinKind::Hidden, ValueType::Word),
];

const REFERENCE: usize = 0;

fn counter(unit: &mut FunctionUnit) -> Option<&mut Counter> {
    if let FunctionUnit::Counter(it) = unit { Some(it.as_mut()) } else { None }
}

fn simple(unit: &mut FunctionUnit) -> Option<&mut Counter> {
    counter(unit).filter(|it| it.is_simple())
}

fn main(unit: &mut FunctionUnit) -> Option<&mut Counter> {
    counter(unit).filter(|it| !it.is_simple())
}

/// Which of the inputs at these places rose since the last call; bit n for the n-th place.
fn rises(pins: &mut dyn BlockPins, places: &[usize], last: usize) -> u8 {
    let now =
        places.iter().enumerate().fold(0, |mask, (n, place)| mask | i64::from(pins.get(*place) != 0) << n);
    let before = pins.get(last);
    pins.set(last, now);
    (now & !before) as u8
}

/// Shows what facts say at the pins from `first` on; 0 for those that there are not.
fn show(pins: &mut dyn BlockPins, shown: &[(usize, FunctionProbe)], counter: Option<&Counter>) {
    for (place, fact) in shown {
        let value = counter.and_then(|it| it.read(*fact)).and_then(|value| value.as_bool());
        pins.set(*place, value.unwrap_or(false).into());
    }
}

fn run_simple(call: &mut BlockCall<'_>) {
    const SHOWN: [(usize, FunctionProbe); 3] =
        [(4, FunctionProbe::Valid), (6, FunctionProbe::Run), (7, FunctionProbe::ModuloFlag)];
    let (now, pins, task) = (call.now, &mut *call.pins, call.expert.task());
    let rises = rises(pins, &[2, 3], 9);
    let controls = if pins.get(1) != 0 { Controls::ENABLE } else { Controls::default() };
    let found = call.expert.call(now, pins.get(REFERENCE), simple, |counter, fx| {
        counter.control(now, controls, fx);
        if rises & 1 != 0 {
            counter.preset(now, fx);
        }
        if rises & 2 != 0 {
            counter.acknowledge(Flag::Modulo);
        }
        pins.set(5, (counter.diag() != 0).into());
        pins.set(8, counter.sampled(task));
        show(pins, &SHOWN, Some(counter));
    });
    if found.is_none() {
        pins.set(5, 1);
        pins.set(8, 0);
        show(pins, &SHOWN, None);
    }
}

fn run_main(call: &mut BlockCall<'_>) {
    const CONTROLS: [(usize, Controls); 10] = [
        (1, Controls::BY_EN),
        (2, Controls::BY_SYNC),
        (3, Controls::BY_CAP),
        (4, Controls::COMPARE),
        (5, Controls::OUT[0]),
        (6, Controls::OUT[1]),
        (7, Controls::ENABLE),
        (9, Controls::FORCE_OUT[0]),
        (10, Controls::FORCE_OUT[1]),
        (11, Controls::SUSPEND),
    ];
    const SHOWN: [(usize, FunctionProbe); 11] = [
        (15, FunctionProbe::Valid),
        (17, FunctionProbe::Run),
        (18, FunctionProbe::Threshold(0)),
        (19, FunctionProbe::Threshold(1)),
        (20, FunctionProbe::Threshold(2)),
        (21, FunctionProbe::Threshold(3)),
        (22, FunctionProbe::ModuloFlag),
        (23, FunctionProbe::PresetFlag),
        (24, FunctionProbe::CaptureFlag),
        (25, FunctionProbe::Reflex(0)),
        (26, FunctionProbe::Reflex(1)),
    ];
    let (now, pins, task) = (call.now, &mut *call.pins, call.expert.task());
    let rises = rises(pins, &[8, 12, 13, 14], 30);
    let wanted = CONTROLS.iter().filter(|(place, _)| pins.get(*place) != 0);
    let controls = wanted.fold(Controls::default(), |all, (_, control)| Controls(all.0 | control.0));
    let found = call.expert.call(now, pins.get(REFERENCE), main, |counter, fx| {
        // Acknowledged first, so that what this call itself brings about is not lost.
        for (bit, flag) in [(2, Flag::Modulo), (4, Flag::Preset), (8, Flag::Capture)] {
            if rises & bit != 0 {
                counter.acknowledge(flag);
            }
        }
        counter.control(now, controls, fx);
        if rises & 1 != 0 {
            counter.preset(now, fx);
        }
        pins.set(16, (counter.diag() != 0).into());
        show(pins, &SHOWN, Some(counter));
        pins.set(27, counter.out(0).into());
        pins.set(28, counter.out(1).into());
        pins.set(29, counter.sampled(task));
    });
    if found.is_none() {
        pins.set(16, 1);
        show(pins, &SHOWN, None);
        for place in 27..=29 {
            pins.set(place, 0);
        }
    }
}

const REFERENCE_PIN: PinType = pin("HSC_REF_IN", BlockPinKind::Input, ValueType::Reference);
const EXECUTE_PIN: PinType = input("Execute");
const ERROR_ID_PIN: PinType = pin("ErrID", BlockPinKind::Output, ValueType::Word);
const LAST_PIN: PinType = pin("last Execute", BlockPinKind::Hidden, ValueType::Bool);

const IMMEDIATE: &[PinType] = &[
    REFERENCE_PIN,
    EXECUTE_PIN,
    output("Done"),
    output("Busy"),
    output("Error"),
    ERROR_ID_PIN,
    pin("ImmediateValue", BlockPinKind::Output, ValueType::Dint),
    LAST_PIN,
];

const CAPTURED: &[PinType] = &[
    REFERENCE_PIN,
    EXECUTE_PIN,
    pin("CaptureNumber", BlockPinKind::Input, ValueType::Word),
    output("Done"),
    output("Busy"),
    output("Error"),
    ERROR_ID_PIN,
    pin("CaptureValue", BlockPinKind::Output, ValueType::Dint),
    LAST_PIN,
];

const DIAG: &[PinType] = &[
    REFERENCE_PIN,
    EXECUTE_PIN,
    output("Done"),
    output("Busy"),
    output("Error"),
    ERROR_ID_PIN,
    pin("EXPERTDiag", BlockPinKind::Output, ValueType::Word),
    LAST_PIN,
];

const GET_PARAM: &[PinType] = &[
    REFERENCE_PIN,
    EXECUTE_PIN,
    pin("Param", BlockPinKind::Input, ValueType::Word),
    output("Done"),
    output("Busy"),
    output("Error"),
    ERROR_ID_PIN,
    pin("ParamValue", BlockPinKind::Output, ValueType::Dint),
    LAST_PIN,
];

const SET_PARAM: &[PinType] = &[
    REFERENCE_PIN,
    EXECUTE_PIN,
    pin("Param", BlockPinKind::Input, ValueType::Word),
    pin("ParamValue", BlockPinKind::Input, ValueType::Dint),
    output("Done"),
    output("Busy"),
    output("Error"),
    ERROR_ID_PIN,
    LAST_PIN,
];

/// ErrID: no such function, or one that is no counter (io:EXP-06).
const UNKNOWN_REFERENCE: i64 = 1;
/// ErrID: the counter has no such parameter or capture.
const UNKNOWN_PARAMETER: i64 = 2;
/// ErrID: the parameter cannot have this value.
const INVALID_PARAMETER: i64 = 3;

const EXECUTE: usize = 1;

/// What Execute brings about at its rising edge: all is done within the call, and shown until Execute falls. `done` is
/// the place of Done, which Busy, Error and ErrID follow; `result` is that of the result, and `last` that of the last
/// level of Execute.
fn once(
    call: &mut BlockCall<'_>,
    done: usize,
    result: Option<usize>,
    last: usize,
    body: impl FnOnce(&mut Counter, &mut ExpertEffects) -> Result<i64, i64>,
) {
    let (pins, now) = (&mut *call.pins, call.now);
    let (error, id) = (done + 2, done + 3);
    let execute = pins.get(EXECUTE) != 0;
    if !execute {
        for place in [done, error, id] {
            pins.set(place, 0);
        }
    } else if pins.get(last) == 0 {
        let outcome = call.expert.call(now, pins.get(REFERENCE), counter, body);
        let outcome = outcome.unwrap_or(Err(UNKNOWN_REFERENCE));
        pins.set(done, outcome.is_ok().into());
        pins.set(error, outcome.is_err().into());
        pins.set(id, outcome.err().unwrap_or(0));
        if let (Ok(value), Some(result)) = (outcome, result) {
            pins.set(result, value);
        }
    }
    pins.set(last, execute.into());
}

fn get_immediate_value(call: &mut BlockCall<'_>) {
    once(call, 2, Some(6), 7, |counter, _| Ok(counter.sampled(None)));
}

fn get_captured_value(call: &mut BlockCall<'_>) {
    let number = usize::try_from(call.pins.get(2)).unwrap_or(usize::MAX);
    once(call, 3, Some(7), 8, |counter, _| counter.captured(number).ok_or(UNKNOWN_PARAMETER));
}

fn get_diag(call: &mut BlockCall<'_>) {
    once(call, 2, Some(6), 7, |counter, _| Ok(counter.diag().into()));
}

fn get_param(call: &mut BlockCall<'_>) {
    let param = CounterParam::of(call.pins.get(2));
    once(call, 3, Some(7), 8, |counter, _| {
        param.and_then(|param| counter.param(param)).map(i64::from).ok_or(UNKNOWN_PARAMETER)
    });
}

fn set_param(call: &mut BlockCall<'_>) {
    let (param, value) = (CounterParam::of(call.pins.get(2)), call.pins.get(3));
    once(call, 4, None, 8, |counter, _| {
        let (Some(param), Ok(asked)) = (param, i32::try_from(value)) else { return Err(UNKNOWN_PARAMETER) };
        match counter.set_param(param, asked) {
            Ok(()) => Ok(value),
            Err(ParamFault::Unknown) => Err(UNKNOWN_PARAMETER),
            Err(ParamFault::Value) => Err(INVALID_PARAMETER),
        }
    });
}
