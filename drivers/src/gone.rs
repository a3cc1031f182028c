//! What a failed call says of its device.

use rustix::io::Errno;

/// Whether the error of a call says that the device is not there any more: no such device, one that is unbound or shut down,
/// a descriptor or a file that is taken away. `also`: what else says so of this kind of device.
pub(crate) fn is_gone(code: i32, also: &[Errno]) -> bool {
    let gone = [Errno::NODEV, Errno::NXIO, Errno::SHUTDOWN, Errno::BADF, Errno::NOENT];
    gone.iter().chain(also).any(|gone| gone.raw_os_error() == code)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_of_the_line_is_a_loss_only_where_the_device_says_so() {
        assert!(is_gone(Errno::NODEV.raw_os_error(), &[]) && is_gone(Errno::NOENT.raw_os_error(), &[]));
        let hung_up = Errno::IO.raw_os_error();
        assert!(!is_gone(hung_up, &[]) && is_gone(hung_up, &[Errno::IO]));
        for stays in [Errno::BUSY, Errno::TIMEDOUT, Errno::AGAIN, Errno::ACCESS, Errno::INVAL] {
            assert!(!is_gone(stays.raw_os_error(), &[Errno::IO]), "{stays}");
        }
        assert!(!is_gone(0, &[]), "no error");
    }
}
