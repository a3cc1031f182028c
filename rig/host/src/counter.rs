//! Events of the kernel's counter subsystem: what a device reports by itself, with the instants at which it reported so.
//! Everything else of a counter stands in files of `/sys`.

use crate::HostInstant;
use std::io;
use std::os::fd::AsRawFd;

/// Bytes of one event as the kernel hands it over: `struct counter_event` of `linux/counter.h`.
pub const COUNTER_RECORD: usize = 24;

/// COUNTER_COMPONENT_COUNT and COUNTER_SCOPE_COUNT: with each event comes what its count showed.
const COMPONENT_COUNT: u8 = 2;
const SCOPE_COUNT: u8 = 2;

/// What a counter can report by itself: `enum counter_event_type`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CounterEventKind {
    /// It counted over its ceiling.
    Overflow,
    /// It counted below 0.
    Underflow,
    /// One of the two.
    OverflowUnderflow,
    /// It reached the value that it compares with.
    Threshold,
    /// Its index signal came.
    Index,
    /// It counted.
    ChangeOfState,
    /// It kept its count.
    Capture,
}

impl CounterEventKind {
    /// All, in the order of their numbers in the kernel.
    pub const ALL: [CounterEventKind; 7] = [
        CounterEventKind::Overflow,
        CounterEventKind::Underflow,
        CounterEventKind::OverflowUnderflow,
        CounterEventKind::Threshold,
        CounterEventKind::Index,
        CounterEventKind::ChangeOfState,
        CounterEventKind::Capture,
    ];
}

/// An event that a counter reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CounterEvent {
    /// When, as the kernel stamped it.
    pub stamp: HostInstant,
    /// What the count showed.
    pub count: u64,
    /// What happened.
    pub kind: CounterEventKind,
}

impl CounterEvent {
    /// Reads an event from the bytes of a record. `None` where the kernel says that it does not know the count, or where
    /// nobody asked for such an event.
    pub fn read(record: &[u8; COUNTER_RECORD]) -> Option<CounterEvent> {
        let [
            t0,
            t1,
            t2,
            t3,
            t4,
            t5,
            t6,
            t7,
            v0,
            v1,
            v2,
            v3,
            v4,
            v5,
            v6,
            v7,
            component,
            scope,
            _,
            _,
            event,
            _,
            status,
            ..,
        ] = *record;
        let stamp = u64::from_ne_bytes([t0, t1, t2, t3, t4, t5, t6, t7]);
        let count = u64::from_ne_bytes([v0, v1, v2, v3, v4, v5, v6, v7]);
        let kind = CounterEventKind::ALL.get(usize::from(event))?;
        let reported = (component, scope, status) == (COMPONENT_COUNT, SCOPE_COUNT, 0);
        let stamp = HostInstant::from_nanos(i64::try_from(stamp).ok()?);
        reported.then_some(CounterEvent { stamp, count, kind: *kind })
    }
}

/// `struct counter_watch` of `linux/counter.h`, with its `struct counter_component` in front.
#[repr(C)]
#[derive(Clone, Copy)]
struct RawWatch {
    component: u8,
    scope: u8,
    parent: u8,
    id: u8,
    event: u8,
    channel: u8,
}

/// COUNTER_ADD_WATCH_IOCTL, COUNTER_ENABLE_EVENTS_IOCTL and COUNTER_DISABLE_EVENTS_IOCTL.
const ADD_WATCH: libc::Ioctl = libc::_IOW::<RawWatch>(0x3e, 0x00);
const ENABLE: libc::Ioctl = libc::_IO(0x3e, 0x01);
const DISABLE: libc::Ioctl = libc::_IO(0x3e, 0x02);

/// Asks a counter for events of this kind on one of its counts, each with what that count shows then. It takes effect with
/// [`enable_counter_events`].
///
/// # Errors
/// EINVAL where the counter has no such event or no such count.
#[allow(unsafe_code)]
pub fn watch_count(counter: &impl AsRawFd, kind: CounterEventKind, count: u8) -> io::Result<()> {
    let event = CounterEventKind::ALL.iter().position(|known| *known == kind).unwrap_or_default() as u8;
    let watch = RawWatch {
        component: COMPONENT_COUNT,
        scope: SCOPE_COUNT,
        parent: count,
        id: count,
        event,
        channel: count,
    };
    // SAFETY: the call reads one `struct counter_watch`, whose layout this is and which lives for the whole call.
    done(unsafe { libc::ioctl(counter.as_raw_fd(), ADD_WATCH, &raw const watch) })
}

/// Events that were asked for come from now on; what waits is forgotten.
///
/// # Errors
/// Those of the counter's driver.
#[allow(unsafe_code)]
pub fn enable_counter_events(counter: &impl AsRawFd) -> io::Result<()> {
    // SAFETY: the call takes no argument.
    done(unsafe { libc::ioctl(counter.as_raw_fd(), ENABLE) })
}

/// No events come any more, and none is asked for.
///
/// # Errors
/// Those of the counter's driver.
#[allow(unsafe_code)]
pub fn disable_counter_events(counter: &impl AsRawFd) -> io::Result<()> {
    // SAFETY: the call takes no argument.
    done(unsafe { libc::ioctl(counter.as_raw_fd(), DISABLE) })
}

fn done(answer: libc::c_int) -> io::Result<()> {
    if answer == -1 { Err(io::Error::last_os_error()) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::File;

    fn record(stamp: u64, count: u64, about: [u8; 8]) -> [u8; COUNTER_RECORD] {
        let mut record = [0; COUNTER_RECORD];
        record[..8].copy_from_slice(&stamp.to_ne_bytes());
        record[8..16].copy_from_slice(&count.to_ne_bytes());
        record[16..].copy_from_slice(&about);
        record
    }

    #[test]
    fn what_is_asked_of_the_kernel_has_the_layout_of_its_headers() {
        assert_eq!(size_of::<RawWatch>(), 6);
        // As `strace` shows it: _IOC(_IOC_WRITE, 0x3e, 0, 0x6).
        assert_eq!(ADD_WATCH & 0x3fff_ffff, 0x0006_3e00);
    }

    #[test]
    fn an_event_is_read_as_the_kernel_wrote_it() {
        let reported = CounterEvent::read(&record(7_000, 42, [2, 2, 1, 1, 3, 1, 0, 0]));
        let stamp = HostInstant::from_nanos(7_000);
        assert_eq!(reported, Some(CounterEvent { stamp, count: 42, kind: CounterEventKind::Threshold }));
        for about in [[2, 2, 1, 1, 3, 1, 22, 0], [0, 0, 0, 0, 3, 1, 0, 0], [2, 2, 1, 1, 9, 1, 0, 0]] {
            assert_eq!(CounterEvent::read(&record(7_000, 42, about)), None, "{about:?}");
        }
        assert_eq!(CounterEvent::read(&record(u64::MAX, 42, [2, 2, 0, 0, 0, 0, 0, 0])), None);
    }

    #[test]
    fn what_is_no_counter_says_so() {
        let none = File::open("/dev/null").unwrap();
        let asked = watch_count(&none, CounterEventKind::Index, 0);
        for answer in [asked, enable_counter_events(&none), disable_counter_events(&none)] {
            assert_eq!(answer.unwrap_err().raw_os_error(), Some(libc::ENOTTY));
        }
    }
}
