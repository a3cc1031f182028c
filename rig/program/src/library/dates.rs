//! Functions of times and dates. Results are cut to the width of their type, as sums and differences of numbers are:
//! a TIME goes on at 0 after 4294967295 ms, a DT after 2106-02-07-06:28:15.

use super::Accepts::{AnyInt, AnyNum, Exact};
use super::calendar::days_of;
use super::convert::{convert, real, rounded};
use super::{Accepts, Body, Function, Gives, argument, scalar};
use crate::types::Elementary::{self, *};

/// A function of two operands, named as in the standard.
macro_rules! two {
    ($name:literal, $left:ident, $right:ident, $result:ident, $body:expr) => {
        scalar($name, &[("IN1", Exact($left)), ("IN2", Exact($right))], Gives::Exact($result), |_, cells| {
            let body: fn(i64, i64) -> i64 = $body;
            $result.wrap(body($left.wrap(argument(cells, 0)), $right.wrap(argument(cells, 1))))
        })
    };
}

/// A time by a number.
macro_rules! by_number {
    ($name:literal, $time:ident, $kind:ident, $body:ident) => {
        Function {
            name: $name,
            parameters: &[("IN1", Exact($time)), ("IN2", AnyNum)],
            extensible: false,
            gives: Gives::Exact($time),
            body: Body::$kind(|ty, cells| $body($time, argument(cells, 0), ty, argument(cells, 1))),
        }
    };
}

const MILLIS: i64 = 1_000;
const NANOS: i64 = 1_000_000;

const YEAR: (&str, Accepts) = ("YEAR", AnyInt);
const MONTH: (&str, Accepts) = ("MONTH", AnyInt);
const DAY: (&str, Accepts) = ("DAY", AnyInt);
const HOUR: (&str, Accepts) = ("HOUR", AnyInt);
const MINUTE: (&str, Accepts) = ("MINUTE", AnyInt);
const SECOND: (&str, Accepts) = ("SECOND", AnyInt);
const MILLISECOND: (&str, Accepts) = ("MILLISECOND", AnyInt);

const DATE: &[(&str, Accepts)] = &[YEAR, MONTH, DAY];
const CLOCK: &[(&str, Accepts)] = &[HOUR, MINUTE, SECOND, MILLISECOND];
const BOTH: &[(&str, Accepts)] = &[YEAR, MONTH, DAY, HOUR, MINUTE, SECOND, MILLISECOND];

/// The functions of IEC 61131-3 on times and dates, but SPLIT_..., which have several outputs.
pub(super) const FUNCTIONS: &[Function] = &[
    two!("ADD_TIME", Time, Time, Time, i64::wrapping_add),
    two!("ADD_LTIME", Ltime, Ltime, Ltime, i64::wrapping_add),
    two!("ADD_TOD_TIME", Tod, Time, Tod, i64::wrapping_add),
    two!("ADD_LTOD_LTIME", Ltod, Ltime, Ltod, i64::wrapping_add),
    // DT counts seconds: of a TIME, the whole seconds count.
    two!("ADD_DT_TIME", Dt, Time, Dt, |date, time| date + time / MILLIS),
    two!("ADD_LDT_LTIME", Ldt, Ltime, Ldt, i64::wrapping_add),
    two!("SUB_TIME", Time, Time, Time, i64::wrapping_sub),
    two!("SUB_LTIME", Ltime, Ltime, Ltime, i64::wrapping_sub),
    two!("SUB_DATE_DATE", Date, Date, Time, |left, right| (left - right) * MILLIS),
    two!("SUB_LDATE_LDATE", Ldate, Ldate, Ltime, i64::wrapping_sub),
    two!("SUB_TOD_TIME", Tod, Time, Tod, i64::wrapping_sub),
    two!("SUB_LTOD_LTIME", Ltod, Ltime, Ltod, i64::wrapping_sub),
    two!("SUB_TOD_TOD", Tod, Tod, Time, i64::wrapping_sub),
    two!("SUB_LTOD_LTOD", Ltod, Ltod, Ltime, i64::wrapping_sub),
    two!("SUB_DT_TIME", Dt, Time, Dt, |date, time| date - time / MILLIS),
    two!("SUB_LDT_LTIME", Ldt, Ltime, Ldt, i64::wrapping_sub),
    two!("SUB_DT_DT", Dt, Dt, Time, |left, right| (left - right) * MILLIS),
    two!("SUB_LDT_LDT", Ldt, Ldt, Ltime, i64::wrapping_sub),
    by_number!("MULTIME", Time, Scalar, multiply),
    by_number!("MUL_TIME", Time, Scalar, multiply),
    by_number!("MUL_LTIME", Ltime, Scalar, multiply),
    by_number!("DIVTIME", Time, Quotient, divide),
    by_number!("DIV_TIME", Time, Quotient, divide),
    by_number!("DIV_LTIME", Ltime, Quotient, divide),
    two!("CONCAT_DATE_TOD", Date, Tod, Dt, |date, clock| date + clock / MILLIS),
    two!("CONCAT_DATE_LTOD", Date, Ltod, Ldt, |date, clock| convert(Date, Ldt, date).wrapping_add(clock)),
    two!("CONCAT_LDATE_LTOD", Ldate, Ltod, Ldt, i64::wrapping_add),
    scalar("CONCAT_DATE", DATE, Gives::Exact(Date), |ty, cells| concat(Date, ty, cells, true, false)),
    scalar("CONCAT_LDATE", DATE, Gives::Exact(Ldate), |ty, cells| concat(Ldate, ty, cells, true, false)),
    scalar("CONCAT_TOD", CLOCK, Gives::Exact(Tod), |ty, cells| concat(Tod, ty, cells, false, true)),
    scalar("CONCAT_LTOD", CLOCK, Gives::Exact(Ltod), |ty, cells| concat(Ltod, ty, cells, false, true)),
    scalar("CONCAT_DT", BOTH, Gives::Exact(Dt), |ty, cells| concat(Dt, ty, cells, true, true)),
    scalar("CONCAT_LDT", BOTH, Gives::Exact(Ldt), |ty, cells| concat(Ldt, ty, cells, true, true)),
    scalar("DAY_OF_WEEK", &[("IN", Exact(Date))], Gives::Exact(Int), |_, cells| {
        // 1970-01-01 was a Thursday, day 4 of a week that begins with Sunday as day 0.
        (Date.wrap(argument(cells, 0)) / 86_400 + 4) % 7
    }),
];

/// A time by a whole number, cut to the width, or by a real number, to the nearest.
fn multiply(time: Elementary, cell: i64, ty: Elementary, factor: i64) -> i64 {
    if ty.is_real() {
        rounded(time, time.number(time.wrap(cell)) as f64 * real(ty, factor))
    } else {
        time.wrap(cell.wrapping_mul(factor))
    }
}

/// A time by a whole number, cut down, or by a real number, to the nearest.
fn divide(time: Elementary, cell: i64, ty: Elementary, divisor: i64) -> Option<i64> {
    let number = time.number(time.wrap(cell));
    if ty.is_real() {
        let divisor = real(ty, divisor);
        return (divisor != 0.0).then(|| rounded(time, number as f64 / divisor));
    }
    number.checked_div(ty.number(ty.wrap(divisor))).map(|quotient| time.wrap(quotient as i64))
}

/// A point in time of its numbers, which are of type `ty`; 0 where there is no such date or time of day.
fn concat(result: Elementary, ty: Elementary, cells: &[i64], date: bool, clock: bool) -> i64 {
    point(ty, cells, date, clock).map_or(0, |millis| match result {
        Date | Dt => result.wrap(millis / MILLIS),
        Tod => result.wrap(millis),
        _ => result.wrap(millis.wrapping_mul(NANOS)),
    })
}

/// Milliseconds since 1970-01-01 of a date, a time of day, or both.
fn point(ty: Elementary, cells: &[i64], date: bool, clock: bool) -> Option<i64> {
    let mut numbers = cells.iter().map(|cell| i64::try_from(ty.number(ty.wrap(*cell))).ok());
    let mut next = || numbers.next().flatten();
    let mut millis = 0;
    if date {
        millis = days_of(next()?, next()?, next()?)? * 86_400 * MILLIS;
    }
    if clock {
        let mut part = |limit: i64| next().filter(|number| (0..limit).contains(number));
        let seconds = (part(24)? * 60 + part(60)?) * 60 + part(60)?;
        millis += seconds * MILLIS + part(MILLIS)?;
    }
    Some(millis)
}
