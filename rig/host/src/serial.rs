//! What the kernel's serial ports can do beyond a terminal's settings: RS-485 direction, low latency, counters of the
//! line, exclusive use.

use std::io;
use std::os::fd::AsRawFd;

/// ASYNC_LOW_LATENCY of `linux/tty_flags.h`: received bytes are handed on at once.
const LOW_LATENCY: libc::c_int = 1 << 13;
/// TIOCSER_TEMT of `asm-generic/termios.h`: the transmitter's shift register is empty.
const EMPTY: libc::c_int = 1;

/// Flags of `struct serial_rs485` in `linux/serial.h`.
mod flag {
    pub(super) const ENABLED: u32 = 1 << 0;
    pub(super) const RTS_ON_SEND: u32 = 1 << 1;
    pub(super) const RTS_AFTER_SEND: u32 = 1 << 2;
    pub(super) const RX_DURING_TX: u32 = 1 << 4;
    pub(super) const TERMINATE: u32 = 1 << 5;
}

/// How a port drives the direction of an RS-485 transceiver through its RTS line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rs485 {
    /// The kernel drives the direction.
    pub enabled: bool,
    /// RTS is active while the port sends.
    pub rts_on_send: bool,
    /// RTS is active while it does not.
    pub rts_after_send: bool,
    /// The port hears what it sends.
    pub rx_during_tx: bool,
    /// The resistor at the end of the bus is switched in, where the port has one.
    pub terminate: bool,
    /// Between RTS and the first bit, in milliseconds.
    pub delay_before: u32,
    /// Between the last bit and RTS, in milliseconds.
    pub delay_after: u32,
}

/// `struct serial_rs485` of `linux/serial.h`.
#[repr(C)]
#[derive(Clone, Copy, Default)]
struct RawRs485 {
    flags: u32,
    delay_before: u32,
    delay_after: u32,
    padding: [u32; 5],
}

impl From<Rs485> for RawRs485 {
    fn from(wanted: Rs485) -> RawRs485 {
        let flags = [
            (wanted.enabled, flag::ENABLED),
            (wanted.rts_on_send, flag::RTS_ON_SEND),
            (wanted.rts_after_send, flag::RTS_AFTER_SEND),
            (wanted.rx_during_tx, flag::RX_DURING_TX),
            (wanted.terminate, flag::TERMINATE),
        ];
        let flags = flags.iter().filter(|(set, _)| *set).fold(0, |all, (_, flag)| all | flag);
        RawRs485 {
            flags,
            delay_before: wanted.delay_before,
            delay_after: wanted.delay_after,
            padding: [0; 5],
        }
    }
}

impl From<RawRs485> for Rs485 {
    fn from(raw: RawRs485) -> Rs485 {
        let has = |flag| raw.flags & flag != 0;
        Rs485 {
            enabled: has(flag::ENABLED),
            rts_on_send: has(flag::RTS_ON_SEND),
            rts_after_send: has(flag::RTS_AFTER_SEND),
            rx_during_tx: has(flag::RX_DURING_TX),
            terminate: has(flag::TERMINATE),
            delay_before: raw.delay_before,
            delay_after: raw.delay_after,
        }
    }
}

/// How the kernel drives the direction of a port.
///
/// # Errors
/// ENOTTY where the driver of the port knows no RS-485.
#[allow(unsafe_code)]
pub fn rs485(port: &impl AsRawFd) -> io::Result<Rs485> {
    let mut raw = RawRs485::default();
    // SAFETY: the call writes one `struct serial_rs485`, whose layout this is and which lives for the whole call.
    done(unsafe { libc::ioctl(port.as_raw_fd(), libc::TIOCGRS485, &raw mut raw) })?;
    Ok(raw.into())
}

/// Sets how the kernel drives the direction of a port. What comes back is what the driver granted: it leaves out what it
/// cannot do, and shortens delays.
///
/// # Errors
/// As [`rs485`].
#[allow(unsafe_code)]
pub fn set_rs485(port: &impl AsRawFd, wanted: Rs485) -> io::Result<Rs485> {
    let mut raw = RawRs485::from(wanted);
    // SAFETY: the call reads and writes one `struct serial_rs485`, whose layout this is and which lives for the whole
    // call.
    done(unsafe { libc::ioctl(port.as_raw_fd(), libc::TIOCSRS485, &raw mut raw) })?;
    Ok(raw.into())
}

/// `struct serial_struct` of `linux/serial.h`.
#[repr(C)]
struct RawSettings {
    kind: libc::c_int,
    line: libc::c_int,
    port: libc::c_uint,
    irq: libc::c_int,
    flags: libc::c_int,
    transmit_buffer: libc::c_int,
    custom_divisor: libc::c_int,
    baud_base: libc::c_int,
    close_delay: libc::c_ushort,
    io_type: libc::c_char,
    reserved: libc::c_char,
    hub6: libc::c_int,
    closing_wait: libc::c_ushort,
    closing_wait2: libc::c_ushort,
    memory: *mut libc::c_uchar,
    register_shift: libc::c_ushort,
    port_high: libc::c_uint,
    map: libc::c_ulong,
}

#[allow(unsafe_code)]
fn settings(port: &impl AsRawFd) -> io::Result<RawSettings> {
    let mut raw = RawSettings {
        kind: 0,
        line: 0,
        port: 0,
        irq: 0,
        flags: 0,
        transmit_buffer: 0,
        custom_divisor: 0,
        baud_base: 0,
        close_delay: 0,
        io_type: 0,
        reserved: 0,
        hub6: 0,
        closing_wait: 0,
        closing_wait2: 0,
        memory: std::ptr::null_mut(),
        register_shift: 0,
        port_high: 0,
        map: 0,
    };
    // SAFETY: the call writes one `struct serial_struct`, whose layout this is and which lives for the whole call.
    done(unsafe { libc::ioctl(port.as_raw_fd(), libc::TIOCGSERIAL, &raw mut raw) })?;
    Ok(raw)
}

/// Whether the driver of a port hands on each received byte at once.
///
/// # Errors
/// ENOTTY where the driver has no such setting.
pub fn low_latency(port: &impl AsRawFd) -> io::Result<bool> {
    Ok(settings(port)?.flags & LOW_LATENCY != 0)
}

/// Sets whether the driver of a port hands on each received byte at once. Some drivers take it and go on as before.
///
/// # Errors
/// ENOTTY where the driver has no such setting, EPERM where the user may not change it.
#[allow(unsafe_code)]
pub fn set_low_latency(port: &impl AsRawFd, wanted: bool) -> io::Result<()> {
    let mut raw = settings(port)?;
    raw.flags = if wanted { raw.flags | LOW_LATENCY } else { raw.flags & !LOW_LATENCY };
    // SAFETY: the call reads one `struct serial_struct`, whose layout this is, which lives for the whole call, and whose
    // address of the port's memory is the one that the kernel gave a moment ago.
    done(unsafe { libc::ioctl(port.as_raw_fd(), libc::TIOCSSERIAL, &raw const raw) })
}

/// What a port counted since it is there. Each counter wraps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LineCounters {
    /// Bytes received.
    pub received: u32,
    /// Bytes sent.
    pub sent: u32,
    /// Bytes whose stop bit was missing.
    pub frame: u32,
    /// Bytes that came before the port had room.
    pub overrun: u32,
    /// Bytes with wrong parity.
    pub parity: u32,
    /// Breaks.
    pub breaks: u32,
    /// Bytes that the kernel had no room for.
    pub buffer_overrun: u32,
}

/// `struct serial_icounter_struct` of `linux/serial.h`.
#[repr(C)]
#[derive(Default)]
struct RawCounters {
    /// Changes of CTS, DSR, RI and DCD.
    modem: [libc::c_int; 4],
    received: libc::c_int,
    sent: libc::c_int,
    frame: libc::c_int,
    overrun: libc::c_int,
    parity: libc::c_int,
    breaks: libc::c_int,
    buffer_overrun: libc::c_int,
    reserved: [libc::c_int; 9],
}

/// What a port counted.
///
/// # Errors
/// ENOTTY where the driver does not count.
#[allow(unsafe_code)]
pub fn line_counters(port: &impl AsRawFd) -> io::Result<LineCounters> {
    let mut raw = RawCounters::default();
    // SAFETY: the call writes one `struct serial_icounter_struct`, whose layout this is and which lives for the whole
    // call.
    done(unsafe { libc::ioctl(port.as_raw_fd(), libc::TIOCGICOUNT, &raw mut raw) })?;
    Ok(LineCounters {
        received: raw.received as u32,
        sent: raw.sent as u32,
        frame: raw.frame as u32,
        overrun: raw.overrun as u32,
        parity: raw.parity as u32,
        breaks: raw.breaks as u32,
        buffer_overrun: raw.buffer_overrun as u32,
    })
}

/// Whether the last bit of what was sent has left the port.
///
/// # Errors
/// ENOTTY where the driver does not say.
pub fn transmitter_is_empty(port: &impl AsRawFd) -> io::Result<bool> {
    Ok(number(port, libc::TIOCSERGETLSR)? & EMPTY != 0)
}

/// Whether somebody has a port for himself: TIOCEXCL, which the kernel does not hold against a superuser.
///
/// # Errors
/// ENOTTY of what is no terminal.
pub fn is_exclusive(port: &impl AsRawFd) -> io::Result<bool> {
    Ok(number(port, libc::TIOCGEXCL)? != 0)
}

/// A call that gives a number.
#[allow(unsafe_code)]
fn number(port: &impl AsRawFd, call: libc::Ioctl) -> io::Result<libc::c_int> {
    let mut number: libc::c_int = 0;
    // SAFETY: both calls write one int, which lives for the whole call.
    done(unsafe { libc::ioctl(port.as_raw_fd(), call, &raw mut number) })?;
    Ok(number)
}

fn done(answer: libc::c_int) -> io::Result<()> {
    if answer == -1 { Err(io::Error::last_os_error()) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::File;

    #[test]
    fn what_is_asked_of_the_kernel_has_the_layout_of_its_headers() {
        assert_eq!(size_of::<RawRs485>(), 32);
        assert_eq!(size_of::<RawCounters>(), 80);
        #[cfg(target_pointer_width = "64")]
        assert_eq!(size_of::<RawSettings>(), 72);
    }

    #[test]
    fn every_setting_of_the_direction_has_a_flag_of_its_own() {
        let one = |pick: fn(&mut Rs485)| {
            let mut wanted = Rs485::default();
            pick(&mut wanted);
            let raw = RawRs485::from(wanted);
            assert_eq!((Rs485::from(raw), raw.flags.count_ones()), (wanted, 1));
            raw.flags
        };
        let flags = [
            one(|wanted| wanted.enabled = true),
            one(|wanted| wanted.rts_on_send = true),
            one(|wanted| wanted.rts_after_send = true),
            one(|wanted| wanted.rx_during_tx = true),
            one(|wanted| wanted.terminate = true),
        ];
        assert_eq!(flags, [1, 2, 4, 16, 32]);
    }

    #[test]
    fn what_is_no_port_says_so() {
        let none = File::open("/dev/null").unwrap();
        let refused = |answer: io::Result<()>| answer.unwrap_err().raw_os_error();
        for answer in [
            rs485(&none).map(drop),
            set_rs485(&none, Rs485::default()).map(drop),
            low_latency(&none).map(drop),
            set_low_latency(&none, true),
            line_counters(&none).map(drop),
            transmitter_is_empty(&none).map(drop),
            is_exclusive(&none).map(drop),
        ] {
            assert_eq!(refused(answer), Some(libc::ENOTTY));
        }
    }
}
