//! Truth tables and timing by IEC 61131-3 ed. 3, tables 43 to 46, and the documents of the controllers' Standard library.

use super::*;
use crate::types::Elementary::{Bool, Dint, Int, Lint, Ltime, Sint, Udint, Ulint, Word};
use proptest::prelude::*;

/// One instance.
struct Instance {
    native: &'static Native,
    offsets: Vec<u16>,
    bytes: Vec<u8>,
}

impl Instance {
    fn new(name: &str) -> Self {
        let native = STANDARD.iter().find(|native| native.name == name).unwrap();
        let (offsets, size) = native.layout();
        Instance { native, offsets, bytes: vec![0; size as usize] }
    }

    fn pins(&mut self, now: i64) -> Pins<'_> {
        Pins::new(&mut self.bytes, self.native.pins, &self.offsets, &[], Time::from_nanos(now))
    }

    /// Sets the inputs in order, calls at a time, and gives the outputs in order.
    fn call(&mut self, now: i64, inputs: &[i64]) -> Vec<i64> {
        let native = self.native;
        let places = |kind| {
            native.pins.iter().enumerate().filter(move |(_, pin)| pin.kind == kind).map(|(place, _)| place)
        };
        let mut pins = self.pins(now);
        for (place, value) in places(PinKind::Input).zip(inputs) {
            pins.set(place, *value);
        }
        own(native)(&mut pins);
        places(PinKind::Output).map(|place| pins.get(place)).collect()
    }

    /// The same at a millisecond.
    fn at(&mut self, millis: i64, inputs: &[i64]) -> Vec<i64> {
        self.call(millis * 1_000_000, inputs)
    }
}

#[test]
fn instances_are_laid_out() {
    for native in STANDARD {
        let (offsets, size) = native.layout();
        assert_eq!(offsets.len(), native.pins.len(), "{}", native.name);
        assert_eq!(size % 8, 0, "{}", native.name);
        let mut end = 0;
        for (pin, offset) in native.pins.iter().zip(offsets) {
            let (offset, bytes) = (usize::from(offset), pin.ty.bytes());
            assert_eq!(offset % bytes, 0, "{}.{}", native.name, pin.name);
            assert!(offset >= end && offset - end < 8, "{}.{}", native.name, pin.name);
            end = offset + bytes;
        }
        assert!(end <= size as usize && size as usize - end < 8, "{}", native.name);
    }
    let (offsets, size) = Instance::new("TON").native.layout();
    assert_eq!((offsets, size), (vec![0, 4, 8, 12, 16, 24], 32));
}

#[test]
fn names_are_unique() {
    for (place, native) in STANDARD.iter().enumerate() {
        assert!(STANDARD[..place].iter().all(|other| other.name != native.name), "{}", native.name);
    }
}

#[test]
fn pins_have_two_names() {
    let pin = |name, pin| Instance::new(name).native.pin(pin);
    assert_eq!(pin("CTU", "RESET"), Some(1));
    assert_eq!(pin("CTU", "R"), Some(1));
    assert_eq!(pin("CTU_INT", "R"), Some(1));
    assert_eq!(pin("CTU_INT", "RESET"), Some(1));
    assert_eq!(pin("CTD", "LD"), Some(1));
    assert_eq!(pin("CTUD_DINT", "LOAD"), Some(3));
    assert_eq!(pin("SR", "S1"), Some(0));
    assert_eq!(pin("SR", "R"), Some(1));
    assert_eq!(pin("RS", "S"), Some(0));
    assert_eq!(pin("RS", "R1"), Some(1));
    assert_eq!(pin("RTC", "EN"), Some(0));
    assert_eq!(pin("TON", "R"), None);
    assert_eq!(pin("TON", "PHASE"), None, "hidden");
    assert_eq!(pin("R_TRIG", ""), None);
}

#[test]
fn pins_are_cells_in_bytes() {
    const PINS: &[Pin] =
        &[output("A", Bool), output("B", Int), output("C", Udint), output("D", Ltime), output("E", Sint)];
    let native = Native { name: "X", pins: PINS, body: BlockBody::Own(|_| {}) };
    let (offsets, size) = native.layout();
    assert_eq!((&offsets[..], size), (&[0, 2, 4, 8, 16][..], 24));
    let mut bytes = vec![0; size as usize];
    // Flags of the first bytes only.
    let flags = [1, 0, 2, 4, 8];
    let mut pins = Pins::new(&mut bytes, PINS, &offsets, &flags, Time::ZERO);
    pins.set(1, 0);
    assert_eq!(pins.changed, 0, "nothing differs");
    pins.set(1, -2);
    assert_eq!((pins.get(1), pins.changed), (-2, 6));
    pins.set(4, 200);
    assert_eq!((pins.get(4), pins.changed), (-56, 6), "cut to its type; no flags there");
    pins.set(2, -1);
    assert_eq!((pins.get(2), pins.changed), (0xFFFF_FFFF, 14));
    pins.set(3, -1);
    assert_eq!(pins.get(3), -1);
    pins.set(0, 1);
    assert!(pins.on(0));
    assert_eq!(pins.changed, 15);
    pins.set(9, 1);
    assert_eq!((pins.get(9), pins.ty(9)), (0, Lint), "no such pin");
    assert_eq!(bytes[..8], [1, 0, 0xFE, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF]);
    // An instance that is too short has no such pins.
    let mut pins = Pins::new(&mut bytes[..3], PINS, &offsets, &flags, Time::ZERO);
    pins.set(1, 5);
    assert_eq!((pins.get(0), pins.get(1), pins.get(3), pins.changed), (1, 0, 0, 0));
}

#[test]
fn on_delay() {
    // Inputs IN, PT; outputs Q, ET.
    let mut ton = Instance::new("TON");
    assert_eq!(ton.at(0, &[0, 100]), [0, 0]);
    assert_eq!(ton.at(10, &[1, 100]), [0, 0], "starts");
    assert_eq!(ton.at(109, &[1, 100]), [0, 99]);
    assert_eq!(ton.call(109_999_999, &[1, 100]), [0, 99], "never early");
    assert_eq!(ton.at(110, &[1, 100]), [1, 100]);
    assert_eq!(ton.at(500, &[1, 100]), [1, 100], "stays at PT");
    assert_eq!(ton.at(510, &[0, 100]), [0, 0]);
    assert_eq!(ton.at(520, &[1, 100]), [0, 0]);
    assert_eq!(ton.at(570, &[0, 100]), [0, 0], "too short");
    assert_eq!(ton.at(580, &[1, 0]), [1, 0], "PT of 0: at once");
    // PT counts as it is at each call.
    let mut ton = Instance::new("TON");
    ton.at(0, &[1, 100]);
    assert_eq!(ton.at(60, &[1, 50]), [1, 50]);
    // The longest PT.
    let mut ton = Instance::new("TON");
    ton.at(0, &[1, 4_294_967_295]);
    assert_eq!(ton.at(4_294_967_294, &[1, 4_294_967_295]), [0, 4_294_967_294]);
    assert_eq!(ton.at(9_000_000_000, &[1, 4_294_967_295]), [1, 4_294_967_295]);
}

#[test]
fn off_delay() {
    let mut tof = Instance::new("TOF");
    assert_eq!(tof.at(0, &[0, 100]), [0, 0], "nothing to delay yet");
    assert_eq!(tof.at(10, &[1, 100]), [1, 0]);
    assert_eq!(tof.at(50, &[0, 100]), [1, 0], "starts");
    assert_eq!(tof.at(149, &[0, 100]), [1, 99]);
    assert_eq!(tof.at(150, &[0, 100]), [0, 100]);
    assert_eq!(tof.at(400, &[0, 100]), [0, 100]);
    assert_eq!(tof.at(410, &[1, 100]), [1, 0]);
    assert_eq!(tof.at(420, &[0, 100]), [1, 0]);
    assert_eq!(tof.at(470, &[1, 100]), [1, 0], "too short");
    assert_eq!(tof.at(480, &[0, 0]), [0, 0], "PT of 0: no delay");
}

#[test]
fn pulse() {
    let mut tp = Instance::new("TP");
    assert_eq!(tp.at(0, &[0, 100]), [0, 0]);
    assert_eq!(tp.at(10, &[1, 100]), [1, 0]);
    assert_eq!(tp.at(50, &[0, 100]), [1, 40], "whatever IN does");
    assert_eq!(tp.at(60, &[1, 100]), [1, 50], "no new pulse meanwhile");
    assert_eq!(tp.at(110, &[1, 100]), [0, 100]);
    assert_eq!(tp.at(200, &[1, 100]), [0, 100], "ET is held");
    assert_eq!(tp.at(210, &[0, 100]), [0, 0]);
    assert_eq!(tp.at(220, &[1, 100]), [1, 0]);
    assert_eq!(tp.at(230, &[0, 100]), [1, 10]);
    assert_eq!(tp.at(320, &[0, 100]), [0, 0], "ends with IN FALSE");
    assert_eq!(tp.at(330, &[1, 0]), [0, 0], "PT of 0: no pulse");
}

#[test]
fn long_timers() {
    for (name, on) in [("LTON", [1, 1_000]), ("TON_LTIME", [1, 1_000])] {
        let mut ton = Instance::new(name);
        assert_eq!(ton.call(5, &on), [0, 0]);
        assert_eq!(ton.call(1_004, &on), [0, 999]);
        assert_eq!(ton.call(1_005, &on), [1, 1_000]);
    }
    let mut ton = Instance::new("LTON");
    ton.call(0, &[1, -1]);
    assert_eq!(ton.call(i64::MAX, &[1, -1]), [0, i64::MAX], "PT is unsigned");
    let mut tof = Instance::new("LTOF");
    tof.call(0, &[1, 10]);
    assert_eq!(tof.call(1, &[0, 10]), [1, 0]);
    assert_eq!(tof.call(11, &[0, 10]), [0, 10]);
    let mut tp = Instance::new("LTP");
    assert_eq!(tp.call(0, &[1, 10]), [1, 0]);
    assert_eq!(tp.call(10, &[1, 10]), [0, 10]);
}

/// Counts `edges` edges on the input at a place, with the other inputs as they are.
fn count(counter: &mut Instance, inputs: &[i64], pin: usize, edges: usize) -> Vec<i64> {
    let mut inputs = inputs.to_vec();
    let mut outputs = Vec::new();
    for _ in 0..edges {
        inputs[pin] = 0;
        counter.at(0, &inputs);
        inputs[pin] = 1;
        outputs = counter.at(0, &inputs);
    }
    outputs
}

#[test]
fn counting_up() {
    // Inputs CU, RESET, PV; outputs Q, CV.
    for name in ["CTU", "CTU_INT", "CTU_DINT", "CTU_LINT", "CTU_UDINT", "CTU_ULINT"] {
        let mut ctu = Instance::new(name);
        assert_eq!(ctu.at(0, &[0, 0, 2]), [0, 0], "{name}");
        assert_eq!(ctu.at(0, &[1, 0, 2]), [0, 1]);
        assert_eq!(ctu.at(0, &[1, 0, 2]), [0, 1], "only edges count");
        assert_eq!(count(&mut ctu, &[0, 0, 2], 0, 1), [1, 2]);
        assert_eq!(count(&mut ctu, &[0, 0, 2], 0, 1), [1, 3], "goes on beyond PV");
        assert_eq!(ctu.at(0, &[0, 0, 4]), [0, 3], "PV counts as it is");
        assert_eq!(ctu.at(0, &[1, 1, 4]), [0, 0], "RESET goes before counting");
        assert_eq!(ctu.at(0, &[1, 0, 4]), [0, 0], "the edge is over");
        assert_eq!(ctu.at(0, &[0, 0, 0]), [1, 0]);
    }
}

#[test]
fn counting_down() {
    // Inputs CD, LOAD, PV; outputs Q, CV.
    for name in ["CTD", "CTD_INT", "CTD_DINT", "CTD_LINT", "CTD_UDINT", "CTD_ULINT"] {
        let mut ctd = Instance::new(name);
        assert_eq!(ctd.at(0, &[0, 0, 2]), [1, 0], "{name}");
        assert_eq!(ctd.at(0, &[1, 1, 2]), [0, 2], "LOAD goes before counting");
        assert_eq!(count(&mut ctd, &[0, 0, 2], 0, 1), [0, 1]);
        assert_eq!(count(&mut ctd, &[0, 0, 2], 0, 1), [1, 0]);
    }
    // CV stops at the lowest value of its type.
    let mut ctd = Instance::new("CTD");
    assert_eq!(count(&mut ctd, &[0, 0, 0], 0, 3), [1, 0]);
    let mut ctd = Instance::new("CTD_INT");
    assert_eq!(count(&mut ctd, &[0, 0, 0], 0, 3), [1, -3]);
}

#[test]
fn counters_stop_at_the_limits_of_their_type() {
    for (ty, suffix) in
        [(Word, ""), (Int, "_INT"), (Dint, "_DINT"), (Lint, "_LINT"), (Udint, "_UDINT"), (Ulint, "_ULINT")]
    {
        let (low, high) = ty.range();
        let (low, high) = (low as i64, high as i64);
        // Inputs CU, CD, RESET, LOAD, PV; outputs QU, QD, CV.
        let mut both = Instance::new(&format!("CTUD{suffix}"));
        assert_eq!(both.at(0, &[0, 0, 0, 1, high])[2], high);
        assert_eq!(count(&mut both, &[0, 0, 0, 0, high], 0, 2), [1, 0, high], "CTUD{suffix}");
        assert_eq!(count(&mut both, &[0, 0, 0, 0, high], 1, 1), [0, 0, high - 1]);
        both.at(0, &[0, 0, 0, 1, low]);
        assert_eq!(count(&mut both, &[0, 0, 0, 0, low], 1, 2), [1, 1, low], "CTUD{suffix}");
        let mut up = Instance::new(&format!("CTU{suffix}"));
        let cv = up.native.pin("CV").unwrap();
        up.pins(0).set(cv, high - 1);
        assert_eq!(count(&mut up, &[0, 0, high], 0, 1), [1, high]);
        assert_eq!(count(&mut up, &[0, 0, high], 0, 1), [1, high]);
        let mut down = Instance::new(&format!("CTD{suffix}"));
        down.at(0, &[0, 1, low]);
        assert_eq!(count(&mut down, &[0, 0, low], 0, 2), [1, low]);
    }
}

#[test]
fn counting_both_ways() {
    let mut both = Instance::new("CTUD");
    assert_eq!(both.at(0, &[0, 0, 0, 0, 2]), [0, 1, 0]);
    assert_eq!(both.at(0, &[1, 0, 0, 0, 2]), [0, 0, 1]);
    assert_eq!(both.at(0, &[0, 0, 0, 0, 2]), [0, 0, 1]);
    assert_eq!(both.at(0, &[1, 1, 0, 0, 2]), [0, 0, 1], "two edges cancel out");
    assert_eq!(both.at(0, &[0, 0, 1, 1, 2]), [0, 1, 0], "RESET goes before LOAD");
    assert_eq!(both.at(0, &[1, 0, 0, 1, 2]), [1, 0, 2], "LOAD goes before counting");
}

#[test]
fn edges() {
    let mut r_trig = Instance::new("R_TRIG");
    let mut f_trig = Instance::new("F_TRIG");
    let clock = [0, 1, 1, 0, 0, 1, 0];
    let rising: Vec<_> = clock.iter().map(|clk| r_trig.at(0, &[*clk])[0]).collect();
    let falling: Vec<_> = clock.iter().map(|clk| f_trig.at(0, &[*clk])[0]).collect();
    assert_eq!(rising, [0, 1, 0, 0, 0, 1, 0]);
    assert_eq!(falling, [0, 0, 0, 1, 0, 0, 1]);
    assert_eq!(Instance::new("R_TRIG").at(0, &[1]), [1], "TRUE in the first call");
    assert_eq!(Instance::new("F_TRIG").at(0, &[0]), [0], "FALSE in the first call");
}

#[test]
fn bistables() {
    // Set, reset, state before; state after with dominant set, with dominant reset.
    for (set, reset, before, by_set, by_reset) in [
        (0, 0, 0, 0, 0),
        (0, 0, 1, 1, 1),
        (0, 1, 0, 0, 0),
        (0, 1, 1, 0, 0),
        (1, 0, 0, 1, 1),
        (1, 0, 1, 1, 1),
        (1, 1, 0, 1, 0),
        (1, 1, 1, 1, 0),
    ] {
        for (name, after) in [("SR", by_set), ("RS", by_reset)] {
            let mut block = Instance::new(name);
            block.pins(0).set(2, before);
            assert_eq!(block.at(0, &[set, reset]), [after], "{name} {set} {reset} {before}");
        }
    }
}

#[test]
fn real_time_clock() {
    // Inputs IN, PDT; outputs Q, CDT.
    let mut rtc = Instance::new("RTC");
    assert_eq!(rtc.at(0, &[0, 1_580_428_800]), [0, 0]);
    assert_eq!(rtc.at(500, &[1, 1_580_428_800]), [1, 1_580_428_800], "set");
    assert_eq!(rtc.at(1_499, &[1, 0]), [1, 1_580_428_800]);
    assert_eq!(rtc.at(1_500, &[1, 0]), [1, 1_580_428_801], "goes on, whatever PDT does");
    assert_eq!(rtc.at(86_400_500, &[1, 0]), [1, 1_580_515_200]);
    assert_eq!(rtc.at(86_400_600, &[0, 0]), [0, 0]);
    assert_eq!(rtc.at(86_400_700, &[1, 4_294_967_295]), [1, 4_294_967_295]);
    assert_eq!(rtc.at(86_401_700, &[1, 0]), [1, 0], "a DT ends in 2106");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1024))]

    #[test]
    fn any_memory(name in 0..STANDARD.len(), now: i64, bytes in proptest::collection::vec(any::<u8>(), 80)) {
        let native = &STANDARD[name];
        let (offsets, size) = native.layout();
        for end in [size as usize, size as usize / 2, 0] {
            let mut bytes = bytes[..end].to_vec();
            let mut pins = Pins::new(&mut bytes, native.pins, &offsets, &[], Time::from_nanos(now));
            own(native)(&mut pins);
        }
    }

    /// On-delay against the time since IN became TRUE, computed again at every call.
    #[test]
    fn delays_by_the_clock(steps in proptest::collection::vec((0..40i64, any::<bool>()), 1..40)) {
        let (mut ton, mut now, mut since) = (Instance::new("TON"), 0, None);
        for (pause, input) in steps {
            now += pause;
            since = if input { since.or(Some(now)) } else { None };
            let elapsed = since.map_or(0, |since| (now - since).min(50));
            prop_assert_eq!(ton.at(now, &[i64::from(input), 50]), vec![i64::from(elapsed == 50), elapsed]);
        }
    }

    /// Off-delay against the time since IN became FALSE.
    #[test]
    fn goes_off_by_the_clock(steps in proptest::collection::vec((0..40i64, any::<bool>()), 1..40)) {
        let (mut tof, mut now, mut fell) = (Instance::new("TOF"), 0, None);
        let mut last = false;
        for (pause, input) in steps {
            now += pause;
            fell = if last && !input { Some(now) } else { fell.filter(|_| !input) };
            last = input;
            let elapsed = fell.map_or(0, |fell: i64| (now - fell).min(50));
            let q = input || fell.is_some_and(|fell| now - fell < 50);
            prop_assert_eq!(tof.at(now, &[i64::from(input), 50]), vec![i64::from(q), elapsed]);
        }
    }

    /// Pulse against the time since the edge that started it.
    #[test]
    fn pulses_by_the_clock(steps in proptest::collection::vec((0..40i64, any::<bool>()), 1..40)) {
        let (mut tp, mut now, mut start) = (Instance::new("TP"), 0, None);
        for (pause, input) in steps {
            now += pause;
            if start.is_none() && input {
                start = Some(now);
            }
            let elapsed = start.map_or(0, |start: i64| (now - start).min(50));
            let q = start.is_some_and(|start| now - start < 50);
            // It is over, and ready for the next edge, when the time is up and IN is FALSE.
            let ended = start.is_some() && !q && !input;
            start = start.filter(|_| !ended);
            let et = if ended { 0 } else { elapsed };
            prop_assert_eq!(tp.at(now, &[i64::from(input), 50]), vec![i64::from(q), et]);
        }
    }
}

/// The body of a block that has one of its own.
fn own(native: &Native) -> fn(&mut Pins<'_>) {
    match native.body {
        BlockBody::Own(run) => run,
        BlockBody::Host(_) => panic!("{} is the host's", native.name),
    }
}
