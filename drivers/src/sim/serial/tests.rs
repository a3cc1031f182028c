//! Serial lines against what their bits say, and against a reader that looks at each nanosecond.

use super::*;
use proptest::prelude::*;
use signal::{MAX_SERIAL_DATA, Parity, SerialErrors, SerialFlaw, SerialSettings, Span};

const SETTINGS: SerialSettings =
    SerialSettings { baud: 1_000_000, data_bits: 8, parity: Parity::Even, stop_bits: 1 };
/// Of a character with [`SETTINGS`], ns.
const CHARACTER: i64 = 11_000;
const GAP: Span = Span::from_nanos(40_000);
const RS485: SerialMedium = SerialMedium::Rs485 { hears_itself: false };
const ECHO: SerialMedium = SerialMedium::Rs485 { hears_itself: true };
const FAR: Time = Time::from_nanos(1_000_000_000);

fn end(medium: SerialMedium) -> SerialEnd {
    SerialEnd { settings: SETTINGS, medium, delay: Span::ZERO, message_gap: GAP }
}

/// A line with these ends.
fn line(ends: &[SerialEnd]) -> SerialLines {
    let mut lines = SerialLines::default();
    for (place, end) in ends.iter().enumerate() {
        lines.push(BusId(place as u16), *end, (place > 0).then_some(BusId(0)));
    }
    lines.start();
    lines
}

fn at(nanos: i64) -> Time {
    Time::from_nanos(nanos)
}

/// What is reported up to `now`: the end, whether it is its own, the first and the last instant, bytes and errors.
type Line = (u16, bool, i64, i64, Vec<u8>, SerialErrors);

fn polled(lines: &mut SerialLines, now: Time) -> Vec<Line> {
    let mut out = Vec::new();
    lines.poll(now, &mut out);
    let line = |event: &BusEvent| match event {
        BusEvent::SerialMessage { bus, message, own } => {
            let (first, last) = (message.first.latest.as_nanos(), message.last.latest.as_nanos());
            (bus.0, *own, first, last, message.data().to_vec(), message.errors)
        }
        other => panic!("{other:?}"),
    };
    out.iter().map(line).collect()
}

/// What an end received, without instants.
fn received(lines: &mut SerialLines, at: u16) -> Vec<(Vec<u8>, SerialErrors)> {
    let all = polled(lines, FAR).into_iter().filter(|(bus, own, ..)| *bus == at && !own);
    all.map(|(.., bytes, errors)| (bytes, errors)).collect()
}

#[test]
fn characters_take_their_time_and_a_message_is_over_when_the_line_was_silent() {
    let mut lines = line(&[end(SerialMedium::Rs232), end(SerialMedium::Rs232)]);
    lines.send(at(5_000), BusId(0), &SerialOutput::plain(&[0x01, 0xFF, 0x00])).unwrap();
    let last = 5_000 + 3 * CHARACTER;
    assert_eq!(lines.next_event(), Some(at(last)));
    assert_eq!(polled(&mut lines, at(last - 1)), []);
    let none = SerialErrors::NONE;
    assert_eq!(polled(&mut lines, at(last)), [(0, true, 5_000, last, vec![1, 0xFF, 0], none)]);
    assert_eq!(lines.next_event(), Some(at(last + GAP.as_nanos())));
    assert_eq!(polled(&mut lines, at(last + GAP.as_nanos() - 1)), []);
    let heard = polled(&mut lines, at(last + GAP.as_nanos()));
    assert_eq!(heard, [(1, false, 5_000, last, vec![1, 0xFF, 0], none)]);
    assert_eq!(lines.next_event(), None);
}

#[test]
fn real_speeds_do_not_drift() {
    let settings = SerialSettings { baud: 115_200, ..SETTINGS };
    let one = SerialEnd { settings, ..end(SerialMedium::Rs232) };
    let mut lines = line(&[one, one]);
    lines.send(Time::ZERO, BusId(0), &SerialOutput::plain(&[0x55; 256])).unwrap();
    // 256 characters of 11 bits: 2816 / 115200 s.
    let lasts = 2_816_i64 * 1_000_000_000 / 115_200;
    let none = SerialErrors::NONE;
    let heard = polled(&mut lines, FAR);
    assert_eq!(heard[0], (0, true, 0, lasts, vec![0x55; 256], none));
    assert_eq!(heard[1], (1, false, 0, lasts, vec![0x55; 256], none));
}

#[test]
fn a_gap_inside_a_message_keeps_it_and_a_longer_one_cuts_it() {
    for (gap, messages) in [(39_000, vec![vec![1, 2]]), (40_000, vec![vec![1], vec![2]])] {
        let mut lines = line(&[end(SerialMedium::Rs232), end(SerialMedium::Rs232)]);
        let output = SerialOutput::Characters { data: vec![1, 2], gap: Span::from_nanos(gap), flaw: None };
        lines.send(Time::ZERO, BusId(0), &output).unwrap();
        let heard: Vec<Vec<u8>> = received(&mut lines, 1).into_iter().map(|(bytes, _)| bytes).collect();
        assert_eq!(heard, messages);
    }
}

#[test]
fn ends_that_disagree_on_parity_hear_parity_errors() {
    let odd = SerialEnd { settings: SerialSettings { parity: Parity::Odd, ..SETTINGS }, ..end(RS485) };
    let mut lines = line(&[end(RS485), odd]);
    lines.send(Time::ZERO, BusId(0), &SerialOutput::plain(&[1, 2, 3])).unwrap();
    let errors = SerialErrors { parity: 3, ..SerialErrors::NONE };
    assert_eq!(received(&mut lines, 1), [(vec![1, 2, 3], errors)]);
}

#[test]
fn ends_that_disagree_on_speed_hear_something_else() {
    // Twice as fast: each bit is read twice. 0x55 is a start bit of two, then 1010...: the stop bit of the reader is a 1.
    let fast = SerialSettings { baud: 2_000_000, parity: Parity::None, ..SETTINGS };
    let mut lines = line(&[end(RS485), SerialEnd { settings: fast, ..end(RS485) }]);
    lines.send(Time::ZERO, BusId(0), &SerialOutput::plain(&[0x00])).unwrap();
    // Nine bits of 0 (start and data) and the parity of 0: ten bits, twenty at its speed. All of its character is 0: a break.
    let broken = SerialErrors { breaks: 1, ..SerialErrors::NONE };
    assert_eq!(received(&mut lines, 1), [(vec![], broken)]);
    // Half as fast, the other way: two bits in one.
    lines.send(at(1_000_000), BusId(1), &SerialOutput::plain(&[0xFF])).unwrap();
    // Start bit of half a bit: no start bit when it is looked at again.
    assert_eq!(received(&mut lines, 0), []);
}

#[test]
fn a_character_is_sent_wrong_on_purpose() {
    let flawed = |flaw| SerialOutput::Characters {
        data: vec![1, 2, 3],
        gap: Span::from_nanos(2_000),
        flaw: Some((1, flaw)),
    };
    for (flaw, errors) in [
        (SerialFlaw::Parity, SerialErrors { parity: 1, ..SerialErrors::NONE }),
        (SerialFlaw::Framing, SerialErrors { framing: 1, ..SerialErrors::NONE }),
    ] {
        let mut lines = line(&[end(SerialMedium::Rs232), end(SerialMedium::Rs232)]);
        lines.send(Time::ZERO, BusId(0), &flawed(flaw)).unwrap();
        assert_eq!(received(&mut lines, 1), [(vec![1, 2, 3], errors)], "{flaw:?}");
    }
}

#[test]
fn a_break_is_heard_once_and_silence_begins_at_its_end() {
    let mut lines = line(&[end(RS485), end(RS485)]);
    lines.send(Time::ZERO, BusId(0), &SerialOutput::Break(Span::from_nanos(100_000))).unwrap();
    let errors = SerialErrors { breaks: 1, ..SerialErrors::NONE };
    let all = polled(&mut lines, FAR);
    assert_eq!(all[0], (0, true, 0, 100_000, vec![], errors));
    assert_eq!(all[1], (1, false, 0, CHARACTER, vec![], errors));
    assert_eq!(all.len(), 2);
    lines.start();
    lines.send(Time::ZERO, BusId(0), &SerialOutput::Break(Span::from_nanos(100_000))).unwrap();
    assert_eq!(polled(&mut lines, at(100_000 + GAP.as_nanos() - 1)).len(), 1);
    assert_eq!(polled(&mut lines, at(100_000 + GAP.as_nanos())).len(), 1);
}

#[test]
fn ends_that_send_at_once_on_one_pair_of_wires_spoil_it_and_over_rs232_they_do_not() {
    let both = |medium| {
        let mut lines = line(&[end(medium), end(medium), end(medium)]);
        lines.send(Time::ZERO, BusId(0), &SerialOutput::plain(&[0x0F, 0x33])).unwrap();
        lines.send(Time::ZERO, BusId(1), &SerialOutput::plain(&[0x3C, 0x55])).unwrap();
        lines
    };
    // The line is at 0 where one of both wants it: the parity of 0x0F & 0x3C is even as theirs.
    let heard = received(&mut both(RS485), 2);
    assert_eq!(heard, [(vec![0x0C, 0x11], SerialErrors::NONE)]);
    let mut ends = [end(SerialMedium::Rs232); 2];
    ends[1].delay = Span::ZERO;
    let mut lines = line(&ends);
    lines.send(Time::ZERO, BusId(0), &SerialOutput::plain(&[1])).unwrap();
    lines.send(Time::ZERO, BusId(1), &SerialOutput::plain(&[2])).unwrap();
    let all = polled(&mut lines, FAR);
    let heard: Vec<(u16, Vec<u8>)> =
        all.into_iter().filter(|(_, own, ..)| !own).map(|(bus, _, _, _, bytes, _)| (bus, bytes)).collect();
    assert_eq!(heard, [(0, vec![2]), (1, vec![1])]);
}

#[test]
fn an_end_hears_itself_only_where_it_is_set_up_so() {
    for (medium, heard) in [(ECHO, vec![(vec![7], SerialErrors::NONE)]), (RS485, vec![])] {
        let mut lines = line(&[end(medium)]);
        lines.send(Time::ZERO, BusId(0), &SerialOutput::plain(&[7])).unwrap();
        assert_eq!(received(&mut lines, 0), heard);
    }
}

#[test]
fn what_an_end_sends_takes_its_delay_to_the_others_but_not_to_itself() {
    let far = SerialEnd { delay: Span::from_nanos(500_000), ..end(ECHO) };
    let mut lines = line(&[far, end(RS485)]);
    lines.send(Time::ZERO, BusId(0), &SerialOutput::plain(&[7])).unwrap();
    let ends: Vec<(u16, bool, i64)> =
        polled(&mut lines, FAR).into_iter().map(|(bus, own, _, last, ..)| (bus, own, last)).collect();
    assert_eq!(ends, [(0, true, CHARACTER), (0, false, CHARACTER), (1, false, 500_000 + CHARACTER)]);
}

#[test]
fn a_message_that_is_too_long_comes_in_parts_and_one_that_just_fits_does_not() {
    for extra in [0, 1] {
        let mut lines = line(&[end(SerialMedium::Rs232), end(SerialMedium::Rs232)]);
        lines.send(Time::ZERO, BusId(0), &SerialOutput::plain(&[7; MAX_SERIAL_DATA])).unwrap();
        if extra > 0 {
            lines.send(Time::ZERO, BusId(0), &SerialOutput::plain(&[8])).unwrap();
        }
        let mut out = Vec::new();
        lines.poll(FAR, &mut out);
        let parts: Vec<(usize, bool, bool)> = out
            .iter()
            .filter_map(|event| match event {
                BusEvent::SerialMessage { message, own: false, .. } => {
                    Some((message.data().len(), message.continues, message.ends))
                }
                _ => None,
            })
            .collect();
        match extra {
            0 => assert_eq!(parts, [(MAX_SERIAL_DATA, false, true)]),
            _ => assert_eq!(parts, [(MAX_SERIAL_DATA, false, false), (1, true, true)]),
        }
    }
}

#[test]
fn what_cannot_be_sent_is_refused() {
    let mut lines = line(&[end(RS485)]);
    let bus = BusId(0);
    let plain = SerialOutput::plain(&[1]);
    assert_eq!(lines.send(Time::ZERO, BusId(1), &plain), Err(BoardError::NoBus(BusId(1))));
    for bad in [
        SerialOutput::plain(&[]),
        SerialOutput::plain(&[0; MAX_SERIAL_DATA + 1]),
        SerialOutput::Break(Span::ZERO),
        SerialOutput::Characters { data: vec![1], gap: Span::ZERO, flaw: Some((1, SerialFlaw::Parity)) },
        SerialOutput::Characters { data: vec![1], gap: Span::from_nanos(-1), flaw: None },
    ] {
        assert_eq!(lines.send(Time::ZERO, bus, &bad), Err(BoardError::BadFrame(bus)), "{bad:?}");
    }
    for _ in 0..MAX_SERIAL_QUEUED {
        lines.send(Time::ZERO, bus, &plain).unwrap();
    }
    assert_eq!(lines.send(Time::ZERO, bus, &plain), Err(BoardError::BusFull(bus)));
    // What was sent makes room.
    assert_eq!(polled(&mut lines, FAR).len(), MAX_SERIAL_QUEUED);
    lines.send(FAR, bus, &plain).unwrap();
    lines.send(FAR, bus, &plain).unwrap();
    // What has begun comes to its end, and the rest is not sent.
    lines.safe(FAR.saturating_add(Span::from_nanos(1)));
    assert_eq!(lines.send(FAR, bus, &plain), Err(BoardError::Latched));
    assert_eq!(polled(&mut lines, Time::from_nanos(2_000_000_000)).len(), 1);
}

#[test]
fn a_receiver_too_slow_to_hear_anything_does_not_fill_the_queue_of_the_sender() {
    let at_speed = |baud| SerialEnd { settings: SerialSettings { baud, ..SETTINGS }, ..end(RS485) };
    let mut lines = line(&[at_speed(115_200), at_speed(300)]);
    // Its start bit is over long before the slow end looks at it again, half a bit of its own later.
    for turn in 0..4 * MAX_SERIAL_QUEUED as i64 {
        let now = at(turn * 2_000_000);
        lines.send(now, BusId(0), &SerialOutput::plain(&[0xFF])).unwrap();
        let sent: Vec<bool> = polled(&mut lines, at(turn * 2_000_000 + 1_999_999))
            .into_iter()
            .map(|(_, own, ..)| own)
            .collect();
        assert_eq!(sent, [true], "turn {turn}");
    }
}

#[test]
fn who_sends_into_a_line_held_at_0_takes_it_for_released_from_then_on() {
    let mut lines = line(&[end(RS485), end(RS485)]);
    lines.send(Time::ZERO, BusId(0), &SerialOutput::Break(Span::from_nanos(55_000))).unwrap();
    assert_eq!(polled(&mut lines, at(50_000)), []);
    // It hears nothing while it sends, and the line is free again before that is over.
    lines.send(at(50_000), BusId(1), &SerialOutput::plain(&[1])).unwrap();
    let over = 50_000 + GAP.as_nanos();
    let before: Vec<Line> =
        polled(&mut lines, at(over - 1)).into_iter().filter(|(bus, own, ..)| *bus == 1 && !own).collect();
    assert_eq!(before, []);
    let errors = SerialErrors { breaks: 1, ..SerialErrors::NONE };
    let at_last: Vec<Line> = polled(&mut lines, at(over)).into_iter().filter(|(bus, ..)| *bus == 1).collect();
    assert_eq!(at_last, [(1, false, 0, CHARACTER, vec![], errors)]);
}

#[test]
fn a_message_that_nobody_asked_for_yet_is_not_lost_by_sending_again() {
    let mut lines = line(&[end(RS485), end(RS485)]);
    lines.send(Time::ZERO, BusId(0), &SerialOutput::plain(&[1])).unwrap();
    let over = CHARACTER + GAP.as_nanos();
    lines.send(at(10 * over), BusId(0), &SerialOutput::plain(&[2])).unwrap();
    let heard: Vec<(i64, Vec<u8>)> = polled(&mut lines, FAR)
        .into_iter()
        .filter(|(bus, ..)| *bus == 1)
        .map(|(_, _, first, _, bytes, _)| (first, bytes))
        .collect();
    assert_eq!(heard, [(0, vec![1]), (10 * over, vec![2])]);
}

/// A reader that looks at each nanosecond of a line that is painted bit by bit.
mod naive {
    use super::*;

    /// The end, first and last instant, bytes, errors, and when it was over.
    pub type Received = (u16, i64, i64, Vec<u8>, SerialErrors, i64);
    pub type Sent = (i64, usize, Vec<u8>, i64, Option<(u16, SerialFlaw)>);

    /// What an end puts on the line, a level for each nanosecond; 1 where it sends nothing.
    fn painted(end: &SerialEnd, at: usize, sent: &[Sent], cells: usize) -> (Vec<bool>, Vec<bool>) {
        let (mut levels, mut busy) = (vec![true; cells], vec![false; cells]);
        let mut free = 0;
        for (now, _, bytes, gap, flaw) in sent.iter().filter(|(_, from, ..)| *from == at) {
            let start = free.max(*now);
            let SerialSettings { baud, data_bits, parity, stop_bits } = end.settings;
            let mut bits = 0_i64;
            let mut end_of = start;
            for (place, byte) in bytes.iter().enumerate() {
                let mut character = vec![false];
                character.extend((0..data_bits).map(|bit| byte >> bit & 1 == 1));
                let ones = character.iter().filter(|bit| **bit).count();
                match parity {
                    Parity::None => {}
                    Parity::Even => character.push(ones % 2 == 1),
                    Parity::Odd => character.push(ones % 2 == 0),
                }
                if *flaw == Some((place as u16, SerialFlaw::Parity)) && parity != Parity::None {
                    let bit = character.len() - 1;
                    character[bit] = !character[bit];
                }
                character.push(*flaw != Some((place as u16, SerialFlaw::Framing)));
                character.extend((1..stop_bits).map(|_| true));
                for bit in character {
                    let edge =
                        |bits: i64| start + bits * 1_000_000_000 / i64::from(baud) + place as i64 * gap;
                    for cell in edge(bits)..edge(bits + 1) {
                        levels[cell as usize] = bit;
                    }
                    bits += 1;
                    end_of = edge(bits);
                }
            }
            (start..end_of).for_each(|cell| busy[cell as usize] = true);
            free = end_of;
        }
        (levels, busy)
    }

    /// What each end receives: the end, first and last instant, bytes, errors, and when it was over.
    pub fn received(ends: &[SerialEnd], sent: &[Sent], cells: usize) -> Vec<Received> {
        let painted: Vec<_> = (0..ends.len()).map(|at| painted(&ends[at], at, sent, cells)).collect();
        let mut all = Vec::new();
        for (at, end) in ends.iter().enumerate() {
            let heard: Vec<bool> = (0..cells)
                .map(|cell| {
                    if end.medium == RS485 && painted[at].1[cell] {
                        return true;
                    }
                    (0..ends.len()).all(|from| {
                        if from == at {
                            return end.medium != ECHO || painted[at].0[cell];
                        }
                        let delay = ends[from].delay.as_nanos() as usize;
                        cell < delay || painted[from].0[cell - delay]
                    })
                })
                .collect();
            read(at as u16, end, &heard, &mut all);
        }
        all.sort_by_key(|(bus, .., over)| (*over, *bus));
        all
    }

    fn read(bus: u16, end: &SerialEnd, heard: &[bool], all: &mut Vec<Received>) {
        let SerialSettings { baud, data_bits, parity, .. } = end.settings;
        let with_parity = usize::from(parity != Parity::None);
        let samples = 2 + usize::from(data_bits) + with_parity;
        let nanos = |halves: i64| halves * 500_000_000 / i64::from(baud);
        let mut message: Option<(i64, i64, Vec<u8>, SerialErrors)> = None;
        // The edge and the bits so far of the character under way; whether the line has to rise first.
        let mut under_way: Option<(i64, Vec<bool>)> = None;
        let (mut held, mut silent) = (false, 0);
        for now in 1..heard.len() as i64 {
            // What the line was in the nanosecond before now.
            let level = heard[now as usize - 1];
            if let Some((fall, bits)) = &mut under_way {
                if now < *fall + nanos(2 * bits.len() as i64 + 1) {
                    continue;
                }
                bits.push(level);
                let no_start = bits.len() == 1 && level;
                if no_start {
                    under_way = None;
                } else if bits.len() == samples {
                    let (fall, bits) = under_way.take().unwrap();
                    let data = &bits[1..1 + usize::from(data_bits)];
                    let byte = data.iter().rev().fold(0_u8, |byte, bit| byte << 1 | u8::from(*bit));
                    let stop = bits[samples - 1];
                    let ones = bits[1..samples - 1].iter().filter(|bit| **bit).count();
                    let wrong = with_parity == 1 && (ones % 2 == 1) != (parity == Parity::Odd);
                    let last = fall + nanos(2 * samples as i64);
                    let (_, end, bytes, errors) =
                        message.get_or_insert((fall, last, Vec::new(), SerialErrors::NONE));
                    *end = last;
                    if ones == 0 && !stop {
                        errors.breaks += 1;
                    } else {
                        bytes.push(byte);
                        errors.framing += u16::from(!stop);
                        errors.parity += u16::from(stop && wrong);
                    }
                    (silent, held) = (last, !stop);
                }
                if !no_start {
                    continue;
                }
            }
            if held {
                // The rise is at the beginning of a nanosecond of 1.
                if level {
                    (held, silent) = (false, silent.max(now - 1));
                }
                continue;
            }
            if !level {
                under_way = Some((now - 1, Vec::new()));
                // A sample of its own instant comes later: half a bit is more than a nanosecond.
                continue;
            }
            if now >= silent + end.message_gap.as_nanos()
                && let Some((first, last, bytes, errors)) = message.take()
            {
                all.push((bus, first, last, bytes, errors, now));
            }
        }
    }
}

fn settings() -> impl Strategy<Value = SerialSettings> {
    let parity = prop_oneof![Just(Parity::None), Just(Parity::Even), Just(Parity::Odd)];
    let baud = prop_oneof![Just(1_000_000_u32), Just(2_000_000), Just(1_234_567), 900_000_u32..1_100_000];
    (baud, 5_u8..=8, parity, 1_u8..=2).prop_map(|(baud, data_bits, parity, stop_bits)| SerialSettings {
        baud,
        data_bits,
        parity,
        stop_bits,
    })
}

fn ends() -> impl Strategy<Value = Vec<SerialEnd>> {
    let one = (settings(), any::<bool>(), 0_i64..3_000, 1_000_i64..60_000);
    (proptest::collection::vec(one, 1..4), any::<bool>(), any::<bool>()).prop_map(|(ends, alike, wires)| {
        let two = ends.len() <= 2 && wires;
        let first = ends[0].0;
        ends.into_iter()
            .map(|(settings, hears_itself, delay, gap)| SerialEnd {
                settings: if alike { first } else { settings },
                medium: if two { SerialMedium::Rs232 } else { SerialMedium::Rs485 { hears_itself } },
                delay: Span::from_nanos(delay),
                message_gap: Span::from_nanos(gap),
            })
            .collect()
    })
}

fn sent() -> impl Strategy<Value = Vec<naive::Sent>> {
    let flaw = prop_oneof![
        4 => Just(None),
        1 => (0_u16..4, prop_oneof![Just(SerialFlaw::Parity), Just(SerialFlaw::Framing)]).prop_map(Some),
    ];
    let bytes = proptest::collection::vec(prop_oneof![any::<u8>(), Just(0), Just(0xFF)], 1..5);
    let one = (0_i64..200_000, 0_usize..3, bytes, prop_oneof![Just(0_i64), 0_i64..50_000], flaw);
    proptest::collection::vec(one, 0..6).prop_map(|mut sent| {
        sent.sort_by_key(|(now, ..)| *now);
        sent
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// What ends hear is what a reader of each nanosecond makes of the bits, and how often they are asked never shows.
    #[test]
    fn ends_hear_what_the_bits_say(ends in ends(), sent in sent(), step in 500_i64..300_000) {
        let sent: Vec<naive::Sent> = sent
            .into_iter()
            .filter(|(_, from, bytes, _, flaw)| {
                *from < ends.len() && flaw.is_none_or(|(at, _)| usize::from(at) < bytes.len())
            })
            .collect();
        let cells = 2_500_000;
        let oracle = naive::received(&ends, &sent, cells);
        let run = |step: i64| {
            let mut lines = line(&ends);
            let mut all = Vec::new();
            let mut asked = 0;
            let mut take = |lines: &mut SerialLines, now: i64| {
                while let Some(next) = lines.next_event().filter(|next| next.as_nanos() <= now) {
                    let events = polled(lines, next);
                    let heard = events.into_iter().filter(|(_, own, ..)| !own);
                    all.extend(heard.map(|(bus, _, first, last, bytes, errors)| {
                        (bus, first, last, bytes, errors, next.as_nanos())
                    }));
                }
                let _ = polled(lines, at(now));
            };
            for (now, from, data, gap, flaw) in &sent {
                while asked + step <= *now {
                    asked += step;
                    take(&mut lines, asked);
                }
                // A look at the very instant does not begin anything.
                take(&mut lines, *now);
                let gap = Span::from_nanos(*gap);
                let output = SerialOutput::Characters { data: data.clone(), gap, flaw: *flaw };
                lines.send(at(*now), BusId(*from as u16), &output).unwrap();
            }
            take(&mut lines, cells as i64);
            all.sort_by_key(|(bus, .., over)| (*over, *bus));
            all
        };
        prop_assert_eq!(&run(step), &oracle);
        prop_assert_eq!(&run(i64::MAX / 2), &oracle);
    }
}
